//! Every reachable marking, packed: counts, bounds, deadlocks, liveness and reversibility within a known memory.
