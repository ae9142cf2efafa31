//! The log of a cell: what is in it, whatever was cut off; and both shipped cells, killed at every step and begun again
//! from the bytes of their logs.

mod crash;
mod log;
mod shipped;
