//! Device profiles: what a device's process data mean, as pure state machines.
//!
//! A generic I/O device (CiA 401) needs none: its bits are the image's bits. A profile is for devices that have to be
//! talked to before a bit of the image comes true. It knows its device's process data and settings; network
//! management, heartbeats and transfers are the manager's.

pub mod drive;
