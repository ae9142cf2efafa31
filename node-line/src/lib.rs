//! The line-specific part common to a station's and the coordinator's node.
//!
//! - [`report_to_message`], [`report_from_message`], [`order_from_message`]: between the controller's words and the messages
//!   that carry them;
//! - [`Confirmation`]: where a station stands, as the text of a message;
//! - [`open_buses`]: the field buses of a node, whichever kinds;
//! - [`devices`]: devices on their buses as ROS 2 sees them;
//! - [`HealthTopic`]: the checks of a node as its diagnostics;
//! - [`Waiting`]: what arrives while a record is being written;
//! - [`quoted`]: foreign words, made fit for an answer.
//!
//! It decides nothing.

mod aggregator;
mod buses;
mod confirmation;
mod convert;
pub mod devices;
mod foreign;
mod health;
mod waiting;

pub use aggregator::{DiagnosticGroup, aggregator_file, diagnostic_groups};
pub use buses::open_buses;
pub use confirmation::{Confirmation, ConfirmationError};
pub use convert::{
    ConvertError, cause_from_code, cause_to_code, kind_of, mode_from_code, mode_to_code, of_this_description,
    order_from_message, report_from_message, report_to_message,
};
pub use foreign::quoted;
pub use health::{HealthTopic, status_message};
pub use waiting::Waiting;
