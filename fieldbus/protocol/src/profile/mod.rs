//! Device profiles: the meaning of a device's process data, as pure state machines.
//!
//! A generic I/O device (CiA 401) needs none: its bits are the image's bits. A profile is for devices that need a
//! dialogue before a bit of the image takes effect. It covers its device's process data and settings; network
//! management, heartbeats and transfers are the manager's.

pub mod drive;
