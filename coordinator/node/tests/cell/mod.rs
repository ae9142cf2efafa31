//! The log of a cell: what is in it, whatever was cut off; and both shipped cells, killed at every step and begun again
//! from the bytes of their logs; the database beside the log; and the planner on its thread.

mod crash;
mod dispatched;
mod full_disk;
mod history;
mod log;
mod planning;
mod shipped;
mod wire;
