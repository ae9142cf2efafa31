//! The texts of this crate for operators.

use linewright_modbus::exception_text;

use crate::last::LastOutcome;

/// Why a device may have outputs on after the last order to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LastOrderTrouble {
    /// The connection has not taken the order.
    Unsent,
    Gone,
    /// Refused with this exception code.
    Refused(u8),
    Unanswered,
}

impl LastOrderTrouble {
    /// None if the order was obeyed.
    pub fn of(outcome: LastOutcome) -> Option<Self> {
        match outcome {
            LastOutcome::Taken => None,
            LastOutcome::Gone => Some(LastOrderTrouble::Gone),
            LastOutcome::Refused(code) => Some(LastOrderTrouble::Refused(code)),
            LastOutcome::Unanswered => Some(LastOrderTrouble::Unanswered),
        }
    }

    /// The text for the device at this address and unit.
    pub fn text_of(self, device: &str) -> String {
        let order = "the order to turn its outputs off";
        let what = match self {
            LastOrderTrouble::Unsent => format!("was not sent {order}"),
            LastOrderTrouble::Gone => format!("ended the connection before it answered {order}"),
            LastOrderTrouble::Refused(code) => {
                format!("refuses {order}: {} (exception {code})", exception_text(code))
            }
            LastOrderTrouble::Unanswered => format!("has not answered {order}"),
        };
        format!("Modbus device {device} {what}; they may be on")
    }
}

#[cfg(test)]
mod tests {
    use linewright_testkit::samples::{listed, samples};

    use super::*;

    #[test]
    fn all_texts_of_last_orders() {
        let troubles = samples!(LastOrderTrouble {
            LastOrderTrouble::Unsent => LastOrderTrouble::Unsent;
            LastOrderTrouble::Gone => LastOrderTrouble::Gone;
            LastOrderTrouble::Refused(_) => LastOrderTrouble::Refused(4);
            LastOrderTrouble::Unanswered => LastOrderTrouble::Unanswered;
        });
        let text = |trouble: &LastOrderTrouble| trouble.text_of("10.0.0.7:502 unit 1");
        let listed = listed("last orders", &troubles, text);
        let expected = "last orders
  Unsent: Modbus device 10.0.0.7:502 unit 1 was not sent the order to turn its outputs off; they may be on
  Gone: Modbus device 10.0.0.7:502 unit 1 ended the connection before it answered the order to turn its outputs off; \
they may be on
  Refused: Modbus device 10.0.0.7:502 unit 1 refuses the order to turn its outputs off: device failure (exception 4); \
they may be on
  Unanswered: Modbus device 10.0.0.7:502 unit 1 has not answered the order to turn its outputs off; they may be on
";
        assert_eq!(listed, expected);
    }
}
