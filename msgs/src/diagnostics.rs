//! `diagnostic_msgs`: how things are, for the stock tools that show it.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::describe::RosField;
use crate::macros::message;
use crate::{Header, Invalid};

/// A `byte` of a `.msg` file: eight bits without a meaning as a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Byte(pub u8);

impl fmt::Display for Byte {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl RosField for Byte {
    fn ros_type() -> String {
        "byte".to_owned()
    }
    fn check_bounds(&self, _path: &str) -> Result<(), Invalid> {
        Ok(())
    }
}

message! {
    /// `diagnostic_msgs/KeyValue`.
    "diagnostic_msgs" / KeyValue
    fields {
        /// Name of the value.
        key: String,
        /// Its value, as text.
        value: String,
    }
    ros name "KeyValue", meaning |_| Ok(())
}

message! {
    /// `diagnostic_msgs/DiagnosticStatus`: how one thing is.
    "diagnostic_msgs" / DiagnosticStatus
    constants {
        /// As it should be.
        const OK: Byte = Byte(0);
        /// It works, but look at it.
        const WARN: Byte = Byte(1);
        /// It does not work.
        const ERROR: Byte = Byte(2);
        /// It is not heard.
        const STALE: Byte = Byte(3);
    }
    fields {
        /// How it is ([`DiagnosticStatus::OK`] and the others).
        level: Byte,
        /// Who says it, and of what.
        name: String,
        /// State in a sentence.
        message: String,
        /// Which piece of hardware.
        hardware_id: String,
        /// Details.
        values: Vec<KeyValue>,
    }
    ros name "DiagnosticStatus", meaning |_| Ok(())
}

message! {
    /// `diagnostic_msgs/DiagnosticArray`: how several things are.
    "diagnostic_msgs" / DiagnosticArray
    fields {
        /// Time stamp.
        header: Header,
        /// Each.
        status: Vec<DiagnosticStatus>,
    }
    ros name "DiagnosticArray", meaning |_| Ok(())
}

impl KeyValue {
    /// A detail.
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Self {
        KeyValue { key: key.into(), value: value.into() }
    }
}
