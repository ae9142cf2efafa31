//! The buses of this machine, and a manager at work on one.
//!
//! - [`Bus`]: the wire: SocketCAN where the kernel has it, else a virtual bus between processes;
//! - [`Driver`]: the thin shell that joins a bus and a [`Manager`](linewright_canopen::Manager) for a node;
//! - [`CanFieldbus`]: the same as a node sees it, behind `linewright_fieldbus_seam::Fieldbus`;
//! - [`sdo_client`]: reading and writing objects from a tool;
//! - [`Clock`]: the time base of all of them.
//!
//! Nothing is decided here: the meaning of frames and the choice of the next one are in `linewright_canopen`.

pub mod bus;
mod can;
mod clock;
mod driver;
pub mod sdo_client;
pub mod texts;

pub use bus::{Bus, BusDirectory, BusError, BusOptions, OwnBuses, Transport, find_bus, place};
pub use can::{BusOpenError, CanFieldbus};
pub use clock::Clock;
pub use driver::{Driver, DriverError, LastFrames};
