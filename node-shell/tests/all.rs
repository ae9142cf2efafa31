//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod actions;
mod confined;
mod cut_link;
mod disk;
mod interop;
mod log;
mod loopback;
mod many_participants;
mod namespace;
mod parameters;
mod services;
