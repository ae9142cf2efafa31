//! The texts of this crate for operators.

use linewright_modbus::exception_text;

use crate::last::LastOutcome;

impl LastOutcome {
    /// The text for the device at this address and unit; none if the order was obeyed.
    pub(crate) fn text(self, device: &str) -> Option<String> {
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

#[cfg(test)]
mod tests {
    use linewright_testkit::samples::{listed, samples};

    use super::*;

    #[test]
    fn all_texts_of_last_orders() {
        let outcomes = samples!(LastOutcome {
            LastOutcome::Taken => LastOutcome::Taken;
            LastOutcome::Unsent => LastOutcome::Unsent;
            LastOutcome::Refused(_) => LastOutcome::Refused(4);
            LastOutcome::Gone => LastOutcome::Gone;
            LastOutcome::Unanswered => LastOutcome::Unanswered;
        });
        let text = |outcome: &LastOutcome| outcome.text("10.0.0.7:502 unit 1").unwrap_or_else(|| "no text".to_owned());
        let listed = listed("last orders", &outcomes, text);
        let expected = "last orders
  Taken: no text
  Unsent: Modbus device 10.0.0.7:502 unit 1 was not sent the order to turn its outputs off; they may be on
  Refused: Modbus device 10.0.0.7:502 unit 1 refuses the order to turn its outputs off: device failure (exception 4); \
they may be on
  Gone: Modbus device 10.0.0.7:502 unit 1 ended the connection before it answered the order to turn its outputs off; \
they may be on
  Unanswered: Modbus device 10.0.0.7:502 unit 1 has not answered the order to turn its outputs off; they may be on
";
        assert_eq!(listed, expected);
    }
}
