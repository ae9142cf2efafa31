//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod alone;
mod analogue;
mod bus_load;
mod dbc_devices;
mod device;
mod drive_bench;
mod drive_managed;
mod drive_states;
mod drives;
mod eds;
mod frames;
mod lines;
mod managed;
mod mechanisms;
mod parts;
mod positions;
mod rack;
mod sync;
mod texts;
mod troubles;
mod turning;
mod wire;
