//! Service data objects: reading and writing a device's object dictionary (CiA 301 §7.2.4).
//!
//! Expedited, segmented and block transfers, in both directions and on both sides, without clock or socket:
//! - [`SdoClient`] is one transfer to one device; [`SdoServer`] answers for a [`Dictionary`];
//! - [`wire`] is the meaning of the eight bytes of a frame; [`Abort`] is why a transfer ended without result.
//!
//! Neither side checks identifiers: the caller picks those of one channel (COB-IDs 600h and 580h plus the node id).
//! Whatever comes on it, memory is bounded, a transfer ends in bounded time if it is polled, and a dictionary is
//! written only once per transfer and only when all of it has arrived.

mod abort;
mod block;
mod cause;
mod client;
mod object;
mod server;
mod setting;
pub mod wire;

pub use abort::Abort;
pub use cause::{TransferError, TransferFailure};
pub use client::{SdoClient, TransferMode, TransferOptions, TransferProgress};
pub use object::{ObjectId, ObjectIdError};
pub use server::{Dictionary, SdoServer};
pub use setting::SdoWrite;

#[cfg(test)]
mod tests;
