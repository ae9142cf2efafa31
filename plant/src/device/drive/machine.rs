//! The state machine of a drive's power (CiA 402, the figure of the power drive system): which transition a controlword
//! orders.
//!
//! Transitions have the numbers of the figure. Which of them happen by themselves, and when a ramp has to end first,
//! is the drive's business.

use linewright_canopen::profile::drive::DriveState;
use linewright_canopen::profile::drive::word::{ENABLE_OPERATION, FAULT_RESET};

/// The transition that `word` orders in `state`; `before` is the word before it. `stays` is whether the quick stop
/// option leaves the drive in quick stop active, from where it can be enabled again.
pub(super) fn ordered(state: DriveState, word: u16, before: u16, stays: bool) -> Option<u8> {
    let bits = |mask: u16, value: u16| word & mask == value;
    let reset = bits(FAULT_RESET, FAULT_RESET) && before & FAULT_RESET == 0;
    let disable_voltage = bits(0x02, 0x00);
    let quick_stop = bits(0x06, 0x02);
    let shutdown = bits(0x07, 0x06);
    let switch_on = bits(0x07, 0x07);
    let enable = bits(ENABLE_OPERATION, ENABLE_OPERATION);
    match state {
        DriveState::SwitchOnDisabled => shutdown.then_some(2),
        DriveState::ReadyToSwitchOn if disable_voltage || quick_stop => Some(7),
        DriveState::ReadyToSwitchOn => switch_on.then_some(3),
        DriveState::SwitchedOn if disable_voltage || quick_stop => Some(10),
        DriveState::SwitchedOn if shutdown => Some(6),
        DriveState::SwitchedOn => enable.then_some(4),
        DriveState::OperationEnabled if disable_voltage => Some(9),
        DriveState::OperationEnabled if quick_stop => Some(11),
        DriveState::OperationEnabled if shutdown => Some(8),
        DriveState::OperationEnabled => (!enable).then_some(5),
        DriveState::QuickStopActive if disable_voltage => Some(12),
        DriveState::QuickStopActive => (enable && stays).then_some(16),
        DriveState::Fault => reset.then_some(15),
        DriveState::NotReadyToSwitchOn | DriveState::FaultReactionActive | DriveState::Unknown => None,
    }
}

/// Target state of a transition.
pub(super) fn leads_to(transition: u8) -> DriveState {
    match transition {
        0 => DriveState::NotReadyToSwitchOn,
        2 | 6 | 8 => DriveState::ReadyToSwitchOn,
        3 | 5 => DriveState::SwitchedOn,
        4 | 16 => DriveState::OperationEnabled,
        11 => DriveState::QuickStopActive,
        13 => DriveState::FaultReactionActive,
        14 => DriveState::Fault,
        1 | 7 | 9 | 10 | 12 | 15 => DriveState::SwitchOnDisabled,
        _ => DriveState::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use DriveState::{
        FaultReactionActive as Reaction, NotReadyToSwitchOn as NotReady, OperationEnabled as Enabled,
        QuickStopActive as QuickStop, ReadyToSwitchOn as Ready, SwitchOnDisabled as Disabled, SwitchedOn as On,
    };

    use super::*;

    /// The arrows of the figure that a command drives: number, from, to, and the commands as its table prints them, bits
    /// 7, 3, 2, 1, 0 (x: does not matter; ^: a rising edge).
    const FIGURE: &[(u8, DriveState, DriveState, &[&str])] = &[
        (2, Disabled, Ready, &["0x110", "1x110"]),
        (3, Ready, On, &["xx111"]),
        (4, On, Enabled, &["x1111"]),
        (5, Enabled, On, &["x0111"]),
        (6, On, Ready, &["xx110"]),
        (7, Ready, Disabled, &["xxx0x", "xx01x"]),
        (8, Enabled, Ready, &["xx110"]),
        (9, Enabled, Disabled, &["xxx0x"]),
        (10, On, Disabled, &["xxx0x", "xx01x"]),
        (11, Enabled, QuickStop, &["xx01x"]),
        (12, QuickStop, Disabled, &["xxx0x"]),
        (15, DriveState::Fault, Disabled, &["^xxxx"]),
        (16, QuickStop, Enabled, &["x1111"]),
    ];

    fn fits(pattern: &str, word: u16, before: u16) -> bool {
        let bits = [7, 3, 2, 1, 0];
        pattern.bytes().zip(bits).all(|(digit, bit)| match digit {
            b'x' => true,
            b'^' => word >> bit & 1 == 1 && before >> bit & 1 == 0,
            digit => (digit == b'1') == (word >> bit & 1 == 1),
        })
    }

    #[test]
    fn every_controlword_in_every_state_is_an_arrow_of_the_figure() {
        let mut seen = std::collections::BTreeSet::new();
        for state in DriveState::KNOWN {
            for (word, before) in (0..=0x1FFu16).flat_map(|word| [(word, 0u16), (word, 0x80)]) {
                let arrows: Vec<&(u8, DriveState, DriveState, &[&str])> = FIGURE
                    .iter()
                    .filter(|(_, from, _, commands)| *from == state && commands.iter().any(|c| fits(c, word, before)))
                    .collect();
                assert!(arrows.len() <= 1, "{state} {word:04X}: the commands of one state exclude each other");
                let expected = arrows.first().map(|arrow| arrow.0);
                assert_eq!(ordered(state, word, before, true), expected, "{state} {word:04X} after {before:04X}");
                if let Some((number, _, to, _)) = arrows.first() {
                    assert_eq!(leads_to(*number), *to);
                    seen.insert(*number);
                }
                let without = ordered(state, word, before, false);
                assert_eq!(without, expected.filter(|number| *number != 16));
            }
        }
        assert_eq!(seen.len(), FIGURE.len());
        // Those that happen by themselves.
        for (number, to) in [(0, NotReady), (1, Disabled), (13, Reaction), (14, DriveState::Fault)] {
            assert_eq!(leads_to(number), to);
        }
    }
}
