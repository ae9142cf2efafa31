//! A whole line in virtual time: the real station and mode controllers against the simulated plant.
