//! Texts of the boot-up procedure.

use std::fmt;

use crate::manager::boot::{BootError, BootStage};
use crate::manager::errors::ERROR_REGISTER;
use crate::manager::on_error::is_one;
use crate::sdo::ObjectId;

impl fmt::Display for BootError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BootError::Identity { object, expected, found } => {
                let what = what(*object);
                write!(f, "it is another device: its {what} (object {object}) is {found:08X}h, not {expected:08X}h")
            }
            BootError::NotANumber { object, bytes } => {
                write!(f, "its {} (object {object}) has {bytes} bytes, not 4", what(*object))
            }
            BootError::NotKept { object, written, found } => {
                write!(f, "object {object}{} is {found:02X}h, not {written:02X}h as written", remedied(object.index))
            }
            BootError::NotReadBack(error) => {
                write!(
                    f,
                    "object {}{} cannot be read back: {}",
                    error.object,
                    remedied(error.object.index),
                    error.cause
                )
            }
            BootError::NoSync { times } => write!(f, "it has lost SYNC (080h) {times} times in a row"),
            BootError::Transfer { writing: true, error } => {
                write!(f, "it cannot be configured: {error}{}", remedied(error.object.index))
            }
            BootError::Transfer { writing: false, error } if error.object == ERROR_REGISTER => {
                write!(f, "it does not say whether an error stands: {error}")
            }
            BootError::Transfer { writing: false, error } => write!(f, "it cannot be identified: {error}"),
        }
    }
}

/// For objects by which outputs go off without a manager: their purpose, and the remedy if a device lacks one.
fn remedied(index: u16) -> &'static str {
    if is_one(index) {
        " (it turns the outputs off when the manager is gone; without it they may stay on. Use or set up a device that \
         keeps it, or give the reason in `without_error_values` why that is safe)"
    } else {
        ""
    }
}

fn what(object: ObjectId) -> &'static str {
    match (object.index, object.sub) {
        (0x1000, _) => "device type",
        (_, 1) => "vendor id",
        (_, 2) => "product code",
        (_, 3) => "revision number",
        _ => "serial number",
    }
}

impl fmt::Display for BootStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BootStage::Identifying(object) => {
                write!(f, "being identified: waits for its {} (object {object})", what(*object))
            }
            BootStage::Configuring { object, reads_back, number, of } => {
                let does = if *reads_back { "read back" } else { "written" };
                write!(f, "being configured: object {object} is {does}, {number} of {of}")
            }
            BootStage::AskingForErrors(object) => {
                write!(f, "configured, and asked whether an error stands (object {object})")
            }
        }
    }
}
