//! Reasons why resources are out of service.

use crate::exception::OutOfServiceReason;
use crate::ids::FiringId;

impl OutOfServiceReason {
    /// The reason, for operators, with the name of the activity that it is about; without one by its number.
    pub fn text(&self, activity: &str) -> String {
        let of = |firing: &FiringId| if activity.is_empty() { firing.to_string() } else { activity.to_owned() };
        match self {
            OutOfServiceReason::ByHand { text } => with("taken out by hand", text),
            OutOfServiceReason::Alarm { text } => with("alarm raised by hand", text),
            OutOfServiceReason::Rule(firing) => format!("taken out by the rule for {}", of(firing)),
            OutOfServiceReason::Station(firing) => format!("station not available after {}", of(firing)),
            OutOfServiceReason::Unheard(firing) => {
                format!("a station of {} was not heard, and may stand in it", of(firing))
            }
            OutOfServiceReason::EmergencyStop(firing) => format!("station in emergency stop after {}", of(firing)),
            OutOfServiceReason::Mismatch => "sensor contradicts the model".to_owned(),
            OutOfServiceReason::Rest => "station at another rest than its next task begins at".to_owned(),
        }
    }

    /// The reason without what differs from time to time, for reports.
    pub fn summary(&self) -> String {
        match self {
            OutOfServiceReason::ByHand { text } if text.is_empty() => "taken out by hand".to_owned(),
            OutOfServiceReason::Alarm { text } if text.is_empty() => "alarm raised by hand".to_owned(),
            OutOfServiceReason::ByHand { text } | OutOfServiceReason::Alarm { text } => text.clone(),
            OutOfServiceReason::Rule(_) => "taken out by a rule".to_owned(),
            OutOfServiceReason::Station(_) => "station not available".to_owned(),
            OutOfServiceReason::Unheard(_) => "a station not heard may stand in it".to_owned(),
            OutOfServiceReason::EmergencyStop(_) => "station in emergency stop".to_owned(),
            OutOfServiceReason::Mismatch => "sensor contradicts the model".to_owned(),
            OutOfServiceReason::Rest => "station at another rest".to_owned(),
        }
    }
}

fn with(reason: &str, text: &str) -> String {
    if text.is_empty() { reason.to_owned() } else { format!("{reason}: {text}") }
}
