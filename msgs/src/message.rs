//! Common traits of the messages, services and actions of a line.

use crate::invalid::{ITEMS_MAX, Invalid, TEXT_BYTES_MAX, at_most};
use serde::{Deserialize, Serialize};

/// Type of a message's field.
pub trait RosField {
    /// Checks the lengths inside this value; `path` names it in the error.
    fn check_bounds(&self, path: &str) -> Result<(), Invalid>;
}

/// An interface as ROS 2 knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Package, kind and name: `linewright_msgs/msg/StationState`.
    pub name: &'static str,
    /// The hash of its structure, names included, as of REP-2016: two nodes with different hashes do not mean the same by a message.
    pub type_hash: &'static str,
    /// Text of its file.
    pub definition: &'static str,
}

/// A message.
pub trait RosMessage: RosField + Serialize + for<'de> Deserialize<'de> + Send + Sync + 'static {
    /// ROS 2 package.
    const PACKAGE: &'static str;
    /// Name within the package.
    const NAME: &'static str;

    /// Checks lengths and meaning. Nothing received is used before this succeeds.
    fn validate(&self) -> Result<(), Invalid>;
}

/// A service: request and response.
pub trait RosService: Send + Sync + 'static {
    /// ROS 2 package.
    const PACKAGE: &'static str;
    /// Name within the package.
    const NAME: &'static str;
    /// Request of the service.
    type Request: RosMessage + Clone;
    /// Response of the service.
    type Response: RosMessage;
}

/// A ROS 2 action: goal, result and feedback.
pub trait RosAction: Send + Sync + 'static {
    /// ROS 2 package.
    const PACKAGE: &'static str;
    /// Name within the package.
    const NAME: &'static str;
    /// Goal of the action.
    type Goal: RosMessage + Clone;
    /// Result of the action.
    type Result: RosMessage + Clone + Default;
    /// Feedback of the action.
    type Feedback: RosMessage + Clone;
}

macro_rules! without_length {
    ($($rust:ty),*) => {$(
        impl RosField for $rust {
            fn check_bounds(&self, _path: &str) -> Result<(), Invalid> { Ok(()) }
        }
    )*};
}

without_length!(bool, i8, u8, i16, u16, i32, u32, i64, u64, f64, crate::Byte);

impl RosField for String {
    fn check_bounds(&self, path: &str) -> Result<(), Invalid> {
        at_most(path, self.len(), TEXT_BYTES_MAX)
    }
}

impl<T: RosField> RosField for Vec<T> {
    fn check_bounds(&self, path: &str) -> Result<(), Invalid> {
        at_most(path, self.len(), ITEMS_MAX)?;
        self.iter().try_for_each(|item| item.check_bounds(path))
    }
}
