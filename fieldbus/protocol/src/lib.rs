//! The CAN field bus: a process image at one end, CANopen frames at the other.
//!
//! From the inside out:
//! - [`Frame`]: one classic CAN frame, as the kernel lays it out, and its [`candump`] text;
//! - [`codec`]: frame ↔ CANopen [`CanopenMessage`], total and pure;
//! - [`sdo`]: reading and writing objects, client and server, pure;
//! - [`Manager`]: the CANopen manager of one bus, pure: it is called with the time and a frame, and answers with
//!   frames to send and events to report;
//! - [`profile`]: process data of devices with a protocol of their own: drives.
//!
//! Buses of a machine, and a manager at work on one, are in `linewright_fieldbus`.
//!
//! COB-IDs and byte layouts occur only in this crate. The meaning of signals, the permission of motions and the mode of
//! a line do not; it moves bits between devices and images, reports whether they can be trusted, and lets go of every
//! output that cannot be.
//!
//! Clauses cited as "CiA 301" are those of the CANopen application layer, version 4.2.0; "CiA 401" is the profile of
//! generic I/O devices, version 3.0; "CiA 402" that of drives, which is IEC 61800-7-201 as well.

pub mod bus_scan;
pub mod candump;
pub mod codec;
pub mod describe_frame;
mod frame;
pub mod manager;
pub mod profile;
pub mod sdo;
mod texts;

pub use codec::{CanopenMessage, FrameDecodeError, NodeId};
pub use frame::{FRAME_BYTES, Frame, FrameError, FrameKind};
pub use manager::{
    BusEvent, BusOutbox, DeviceRequest, DeviceRequestError, IgnoreReason, MANAGER_NODE, Manager, ManagerError,
    RequestResult,
};
