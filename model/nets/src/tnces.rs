//! Timed net condition/event systems: condition arcs, event arcs and time on input arcs (seed 003).
