//! The CAN field bus: a process image at one end, CANopen frames at the other.
//!
//! From the inside out:
//! - [`Frame`]: one classic CAN frame, as the kernel lays it out, and its [`candump`] text;
//! - [`codec`]: frame ↔ CANopen [`Message`], total and pure;
//! - [`sdo`]: reading and writing objects, client and server, pure;
//! - [`Manager`]: the CANopen manager of one bus, pure: it is called with the time and a frame, and answers with
//!   frames to send and events to report;
//! - [`profile`]: what the process data of a device mean that has to be talked to first: drives;
//! - `Bus`: the wire: SocketCAN where the kernel has it, else a virtual bus between processes;
//! - `Driver`: the thin shell that joins a bus and a manager for a node.
//!
//! The last two, and whatever else waits for a clock, need the feature `io`, which is on by default. A simulation in
//! virtual time does without it, and with it without everything that is not pure.
//!
//! Only this crate knows COB-IDs and byte layouts. It does not know what a signal means, when a motion may start or
//! which mode a line is in; it moves bits between devices and images, says whether they can be trusted, and lets go
//! of every output it cannot vouch for.
//!
//! Clauses cited as "CiA 301" are those of the CANopen application layer, version 4.2.0; "CiA 401" is the profile of
//! generic I/O devices, version 3.0; "CiA 402" that of drives, which is IEC 61800-7-201 as well.

#[cfg(feature = "io")]
pub mod bus;
pub mod candump;
#[cfg(feature = "io")]
mod clock;
pub mod codec;
#[cfg(feature = "io")]
mod driver;
mod frame;
pub mod manager;
pub mod profile;
pub mod sdo;
#[cfg(feature = "io")]
pub mod sdo_client;
pub mod survey;
pub mod tell;

#[cfg(feature = "io")]
pub use bus::{Bus, BusError, Found, Options, OwnBuses, Transport, find_bus, place};
#[cfg(feature = "io")]
pub use clock::Clock;
pub use codec::{DecodeError, Message, NodeId};
#[cfg(feature = "io")]
pub use driver::{Driver, DriverError, LastFrames};
pub use frame::{Frame, FrameError, Kind};
pub use manager::{
    Answer, Ask, AskError, Event, IgnoreReason, InputImage, MANAGER_NODE, Manager, ManagerError, Outbox,
};
