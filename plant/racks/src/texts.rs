//! The texts of the running plant for operators. All of them are here; `tests/texts.rs` keeps a list of them.

use std::error::Error;
use std::fmt;
use std::path::Path;
use std::time::Duration;

use linewright_plant::PositionsMisfit;

use crate::kept::VERSION;
use crate::{PlantError, Served};

impl fmt::Display for PlantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlantError::Bus(error) => error.fmt(f),
            PlantError::Modbus { address, error } => write!(
                f,
                "cannot serve the simulated Modbus device at {address}: {error}; a device that is simulated needs an address of \
                 this machine, such as 127.0.0.1:1502; with real devices: `linewright run --no-plant`"
            ),
            PlantError::ModbusTaken { address, by } => write!(
                f,
                "cannot serve the simulated Modbus device at {address}: {} is there. Modbus addresses are not separated by ROS \
                 domains as virtual buses are: end that first, or give the device another address; with real devices: \
                 `linewright run --no-plant`",
                server(by.as_ref())
            ),
        }
    }
}

impl Error for PlantError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            PlantError::Bus(error) => error.source(),
            PlantError::Modbus { .. } | PlantError::ModbusTaken { .. } => None,
        }
    }
}

/// The process that serves an address.
fn server(by: Option<&Served>) -> String {
    match by {
        Some(Served::Simulated { run: Some(run) }) => format!("the plant of {run}"),
        Some(Served::Simulated { run: None }) => "another simulated plant".to_owned(),
        Some(Served::Other) | None => "another process".to_owned(),
    }
}

/// Reason why kept positions cannot be used.
#[derive(Clone, Debug)]
pub enum UnusablePositions {
    /// The file cannot be read, by this reason.
    Unreadable(String),
    /// Version of the file.
    Version(u32),
    /// Name of the line in the file.
    OtherLine(String),
    OtherBuses,
    Misfit(PositionsMisfit),
}

impl UnusablePositions {
    /// The text about the file at `path`.
    pub fn text(&self, path: &Path) -> String {
        let why = match self {
            UnusablePositions::Unreadable(why) => why.clone(),
            UnusablePositions::Version(version) => {
                format!("it has form {version}, this program reads form {VERSION}")
            }
            UnusablePositions::OtherLine(line) => format!("they are those of line `{line}`"),
            UnusablePositions::OtherBuses => "the line has other buses now".to_owned(),
            UnusablePositions::Misfit(misfit) => misfit.to_string(),
        };
        format!(
            "positions of the simulated machine in {} cannot be used: {why}; it begins at home, empty, and stations that were \
             stopped elsewhere report `position lost`",
            path.display()
        )
    }
}

/// Reason why a simulated Modbus device takes no fault, or does not answer.
#[derive(Clone, Debug)]
pub enum ModbusFaultError<'a> {
    NoSuchFault {
        device: &'a str,
        address: &'a str,
    },
    Refused {
        device: &'a str,
        address: &'a str,
        /// Text of the exception.
        why: String,
    },
    Unreachable {
        address: &'a str,
        /// Reason of the system.
        why: String,
    },
    Unanswered {
        address: &'a str,
        within: Duration,
    },
}

impl fmt::Display for ModbusFaultError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let remedy = "is the simulated plant running?";
        match self {
            ModbusFaultError::NoSuchFault { device, address } => write!(
                f,
                "{device} at {address} has no such fault; a device in Modbus can be silent, reboot or no-boot"
            ),
            ModbusFaultError::Refused { device, address, why } => write!(f, "{device} at {address} refuses it: {why}"),
            ModbusFaultError::Unreachable { address, why } => {
                write!(f, "no simulated device answers at {address}: {why}; {remedy}")
            }
            ModbusFaultError::Unanswered { address, within } => {
                let within = within.as_secs();
                write!(f, "no simulated device answers at {address}: nothing within {within} s; {remedy}")
            }
        }
    }
}

/// Entry of a plant in its log.
#[derive(Clone, Debug)]
pub enum PlantNews<'a> {
    /// Mechanisms and parts begin where they were, by this file.
    Resumed { path: &'a Path },
    /// Positions cannot be kept in this file.
    NotKept { path: &'a Path, why: String },
    /// A Modbus server has ended.
    ServerEnded { address: &'a str, why: String },
    /// A part has met with a mishap.
    Mishap { what: String },
}

impl fmt::Display for PlantNews<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlantNews::Resumed { path } => write!(f, "mechanisms and parts are where they were, by {}", path.display()),
            PlantNews::NotKept { path, why } => write!(
                f,
                "positions of the simulated machine cannot be written to {}: {why}; a run that goes on from this state finds it \
                 elsewhere; make room on the disk, or the directory writable",
                path.display()
            ),
            PlantNews::ServerEnded { address, why } => write!(f, "the Modbus server at {address} has ended: {why}"),
            PlantNews::Mishap { what } => write!(f, "simulated machine: {what}"),
        }
    }
}
