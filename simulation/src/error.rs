//! Errors of starting a simulated line.

use linewright_canopen::ManagerError;
use linewright_station_logic::CompileError;
use thiserror::Error;

/// Reason why a line, or a process of it, cannot be started.
#[derive(Debug, Error)]
pub enum StartError {
    /// A station does not compile.
    #[error(transparent)]
    Station(#[from] CompileError),
    /// The devices of a bus have no manager.
    #[error(transparent)]
    Bus(#[from] ManagerError),
    /// A device is on no CAN bus.
    #[error(
        "frames are played on CAN buses, and device `{device}` speaks Modbus: simulate without frames, or run the line"
    )]
    NoFrames {
        /// The device.
        device: String,
    },
}
