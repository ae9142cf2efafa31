//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod analogue;
mod devices;
mod drives;
mod fields;
mod fingerprint;
mod io_list;
mod modbus;
mod net;
mod never_panics;
mod position;
mod problems;
mod report;
mod setups;
mod shipped;
mod task_driven;
mod types;
