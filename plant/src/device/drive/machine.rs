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
