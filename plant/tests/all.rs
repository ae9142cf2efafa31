//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod analogue;
mod any_frames;
mod bus_load;
mod common;
mod devices;
mod drive_bench;
mod drive_managed;
mod drive_objects;
mod drive_rack;
mod drive_states;
mod drives;
mod eds;
mod frames;
mod lines;
mod mechanisms;
mod objects;
mod parts;
mod plain;
mod sync;
mod troubles;
mod wire;
