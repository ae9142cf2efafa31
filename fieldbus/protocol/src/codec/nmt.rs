//! Network management: orders to devices and the states they report (CiA 301 §7.2.8, §7.3.2).

use super::{CanopenMessage, FrameDecodeError, HEARTBEAT, NMT, NodeId};

/// An order to a device's state machine (CiA 301 §7.2.8.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NmtCommand {
    /// 0x01: enter operational.
    Start,
    /// 0x02: enter stopped.
    Stop,
    /// 0x80: enter pre-operational.
    EnterPreOperational,
    /// 0x81: reset the application, and with it the communication.
    ResetNode,
    /// 0x82: reset the communication.
    ResetCommunication,
    Unknown(u8),
}

impl NmtCommand {
    pub const fn code(self) -> u8 {
        match self {
            NmtCommand::Start => 0x01,
            NmtCommand::Stop => 0x02,
            NmtCommand::EnterPreOperational => 0x80,
            NmtCommand::ResetNode => 0x81,
            NmtCommand::ResetCommunication => 0x82,
            NmtCommand::Unknown(code) => code,
        }
    }

    pub const fn from_code(code: u8) -> Self {
        match code {
            0x01 => NmtCommand::Start,
            0x02 => NmtCommand::Stop,
            0x80 => NmtCommand::EnterPreOperational,
            0x81 => NmtCommand::ResetNode,
            0x82 => NmtCommand::ResetCommunication,
            code => NmtCommand::Unknown(code),
        }
    }
}

/// The state a device reports of itself (CiA 301 §7.2.8.3.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NmtState {
    /// 0x00: it has just booted; sent once.
    BootUp,
    /// 0x04: stopped, answers network management only.
    Stopped,
    /// 0x05: operational, exchanges process data.
    Operational,
    /// 0x7F: pre-operational, can be configured.
    PreOperational,
    Unknown(u8),
}

impl NmtState {
    pub const fn code(self) -> u8 {
        match self {
            NmtState::BootUp => 0x00,
            NmtState::Stopped => 0x04,
            NmtState::Operational => 0x05,
            NmtState::PreOperational => 0x7F,
            NmtState::Unknown(code) => code,
        }
    }

    pub const fn from_code(code: u8) -> Self {
        match code {
            0x00 => NmtState::BootUp,
            0x04 => NmtState::Stopped,
            0x05 => NmtState::Operational,
            0x7F => NmtState::PreOperational,
            code => NmtState::Unknown(code),
        }
    }
}

pub(super) fn decode(data: &[u8]) -> Result<CanopenMessage, FrameDecodeError> {
    let &[command, node] = data else {
        return Err(FrameDecodeError::Length { cob_id: NMT, expected: "2", actual: data.len() });
    };
    if node > 127 {
        return Err(FrameDecodeError::Field { cob_id: NMT, field: "node id", expected: "0 to 127", actual: node });
    }
    Ok(CanopenMessage::Nmt { command: NmtCommand::from_code(command), node: NodeId::new(node) })
}

pub(super) fn decode_state(cob_id: u16, data: &[u8]) -> Result<NmtState, FrameDecodeError> {
    debug_assert_eq!(cob_id & 0x780, HEARTBEAT);
    match data {
        [code] => Ok(NmtState::from_code(*code)),
        _ => Err(FrameDecodeError::Length { cob_id, expected: "1", actual: data.len() }),
    }
}
