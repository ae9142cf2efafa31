//! Buttons that are held by message, and releases that are repeated.

use std::collections::BTreeMap;

use linewright_line::StationId;

/// Number of repetitions of a release: one message can get lost, and silence is no release.
pub(crate) const RELEASES: u8 = 5;

/// The buttons that people hold, and the releases that are still to be repeated.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeldButtons {
    /// Panel buttons, advance (`true`) or return: held, or how often the release is still to be sent.
    panel: BTreeMap<(StationId, bool), Option<u8>>,
    buttons: u32,
    /// Messages still to be sent that no hand-mode button is held.
    no_buttons: u8,
    /// Resume: held, or how often the release is still to be sent.
    resume: Option<Option<u8>>,
}

impl HeldButtons {
    /// Whether this panel button is held.
    pub(crate) fn holds(&self, station: StationId, advance: bool) -> bool {
        self.panel.get(&(station, advance)) == Some(&None)
    }

    /// Holds a panel button. Gives whether it was not held before.
    pub(crate) fn press(&mut self, station: StationId, advance: bool) -> bool {
        self.panel.insert((station, advance), None) != Some(None)
    }

    /// Releases a panel button, with so many messages. Returns whether it was held.
    pub(crate) fn release(&mut self, station: StationId, advance: bool, times: u8) -> bool {
        let held = self.holds(station, advance);
        if held {
            self.panel.insert((station, advance), Some(times));
        }
        held
    }

    /// Holds exactly these hand-mode buttons; that there is none is to be sent so often.
    pub(crate) fn hold(&mut self, buttons: u32, times: u8) {
        (self.buttons, self.no_buttons) = (buttons, times);
    }

    /// Holds resume, or releases it with so many messages.
    pub(crate) fn resume(&mut self, held: bool, times: u8) {
        self.resume = Some((!held).then_some(times));
    }

    /// Resume, to be sent again.
    pub(crate) fn resume_again(&mut self) -> Option<bool> {
        let left = self.resume?;
        self.resume = match left {
            None => Some(None),
            Some(left) => left.checked_sub(1).filter(|&left| left > 0).map(Some),
        };
        Some(left.is_none())
    }

    /// Panel buttons to be sent again: station, advance rather than return, held rather than released.
    pub(crate) fn panel_again(&mut self) -> Vec<(StationId, bool, bool)> {
        let again = self.panel.iter().map(|(&(station, advance), left)| (station, advance, left.is_none())).collect();
        self.panel.retain(|_, left| {
            *left = left.map(|left| left - 1);
            *left != Some(0)
        });
        again
    }

    /// Hand-mode buttons to be sent again.
    pub(crate) fn buttons_again(&mut self) -> Option<u32> {
        if self.buttons == 0 {
            self.no_buttons = self.no_buttons.checked_sub(1)?;
        }
        Some(self.buttons)
    }
}
