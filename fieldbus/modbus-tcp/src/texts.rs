//! The texts of this crate for operators.

use linewright_modbus::exception_text;

use crate::last::LastOutcome;

impl LastOutcome {
    /// The text for the device at this address and unit; none if the order was obeyed.
    pub fn text(self, device: &str) -> Option<String> {
        let order = "the order to turn its outputs off";
        let what = match self {
            LastOutcome::Taken => return None,
            LastOutcome::Unsent => format!("was not sent {order}"),
            LastOutcome::Gone => format!("ended the connection before it answered {order}"),
            LastOutcome::Refused(code) => {
                format!("refuses {order}: {} (exception {code})", exception_text(code))
            }
            LastOutcome::Unanswered => format!("has not answered {order}"),
        };
        Some(format!("Modbus device {device} {what}; they may be on"))
    }
}
