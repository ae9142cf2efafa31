//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod common;
mod devices;
mod hostile;
mod problems;
mod round_trip;
mod spelling;
