//! CANopen messages: frame ↔ [`CanopenMessage`], total in both directions.
//!
//! Pure translation by the predefined connection set (CiA 301 §7.3.5, table 40): which COB-ID means what, and how its
//! bytes are laid out (§7.2). Unknown codes survive as values; anything else that does not fit is a
//! [`FrameDecodeError`] with the expectation. The use of a message, and whether it comes at the right moment, is
//! decided elsewhere.

mod emcy;
pub(crate) mod emcy_codes;
mod nmt;
mod pdo;

use std::fmt;

use thiserror::Error;

pub(crate) use emcy::error_register_text;
pub use emcy::{BUS_OFF_RECOVERED, Emergency, HEARTBEAT_LOST, NO_ERROR, Profile};
pub use nmt::{NmtCommand, NmtState};
pub use pdo::Payload;

use crate::frame::{Frame, FrameKind};
pub use crate::sdo::Abort;
use crate::sdo::wire::SdoBytes;

/// A CANopen node id, 1 to 127 (CiA 301 §7.3.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u8);

impl NodeId {
    /// The node id `id`, or `None` outside 1 to 127.
    pub const fn new(id: u8) -> Option<Self> {
        if id >= 1 && id <= 127 { Some(NodeId(id)) } else { None }
    }

    pub const fn get(self) -> u8 {
        self.0
    }
}

impl fmt::Display for NodeId {
    /// In hexadecimal, as identifiers of frames are: `06h` is the node whose heartbeat is `706h`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{:02X}h", self.0))
    }
}

/// One message of the predefined connection set, as far as Linewright uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CanopenMessage {
    /// Network management order, COB-ID 0x000 (CiA 301 §7.2.8.3.1). `node` `None` addresses all.
    Nmt { command: NmtCommand, node: Option<NodeId> },
    /// Synchronisation, COB-ID 0x080 (CiA 301 §7.2.5), with its counter where the producer sends one.
    Sync {
        /// 1 to 240, where sent.
        counter: Option<u8>,
    },
    /// Emergency, COB-ID 0x080 + node (CiA 301 §7.2.7).
    Emergency { node: NodeId, emergency: Emergency },
    /// First transmit PDO, COB-ID 0x180 + node: the device's inputs (default mapping of CiA 401).
    Tpdo1 {
        node: NodeId,
        /// Bit `i` is input `i`.
        payload: Payload,
    },
    /// First receive PDO, COB-ID 0x200 + node: the device's outputs (default mapping of CiA 401).
    Rpdo1 {
        node: NodeId,
        /// Bit `i` is output `i`.
        payload: Payload,
    },
    /// Second to fourth transmit PDO, COB-ID 0x280, 0x380 and 0x480 + node: the device's analogue inputs (default
    /// mapping of CiA 401).
    Tpdo {
        node: NodeId,
        number: u8,
        /// Four channels of 16 bits.
        payload: Payload,
    },
    /// Second to fourth receive PDO, COB-ID 0x300, 0x400 and 0x500 + node: the device's analogue outputs (default
    /// mapping of CiA 401).
    Rpdo {
        node: NodeId,
        number: u8,
        /// Four channels of 16 bits.
        payload: Payload,
    },
    /// SDO answer, COB-ID 0x580 + node (CiA 301 §7.2.4). Its meaning depends on the transfer under way: see
    /// [`sdo::SdoClient`](crate::sdo::SdoClient).
    SdoResponse { node: NodeId, raw: SdoBytes },
    /// SDO request, COB-ID 0x600 + node (CiA 301 §7.2.4). Meaning: see [`sdo::SdoServer`](crate::sdo::SdoServer).
    SdoRequest { node: NodeId, raw: SdoBytes },
    /// Heartbeat, or boot-up in state [`NmtState::BootUp`], COB-ID 0x700 + node (CiA 301 §7.2.8.3.2, §7.2.8.3.3).
    Heartbeat { node: NodeId, state: NmtState },
}

/// Why a frame is not one of the messages.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FrameDecodeError {
    /// An extended identifier: CANopen's predefined connections use standard ones.
    #[error("identifier {id:08X}h is extended, CANopen uses 11-bit identifiers")]
    Extended { id: u32 },
    /// A remote request: PDOs here are sent by change and by time, never on request.
    #[error("{id:03X}h is a remote request")]
    Remote { id: u32 },
    /// The kernel's report about the bus, not a frame from it.
    #[error("error frame, classes {class:#X}")]
    ErrorFrame {
        /// Class bits of `linux/can/error.h`.
        class: u32,
    },
    /// No message of ours has this COB-ID.
    #[error("COB-ID {cob_id:03X}h has no meaning here")]
    UnknownCobId { cob_id: u16 },
    /// The frame is too short or too long for its COB-ID.
    #[error("COB-ID {cob_id:03X}h: {actual} data bytes, expected {expected}")]
    Length {
        cob_id: u16,
        /// Value required by the standard.
        expected: &'static str,
        actual: usize,
    },
    /// A field has a value the standard rules out.
    #[error("COB-ID {cob_id:03X}h: {field} is {actual:#04X}, expected {expected}")]
    Field {
        cob_id: u16,
        field: &'static str,
        /// Value required by the standard.
        expected: &'static str,
        actual: u8,
    },
}

const NMT: u16 = 0x000;
const SYNC: u16 = 0x080;
const EMERGENCY: u16 = 0x080;
const TPDO1: u16 = 0x180;
const RPDO1: u16 = 0x200;
/// Those of the second to fourth are 0x100 apart.
const TPDO2: u16 = 0x280;
const TPDO3: u16 = 0x380;
const TPDO4: u16 = 0x480;
const RPDO2: u16 = 0x300;
const RPDO3: u16 = 0x400;
const RPDO4: u16 = 0x500;
const SDO_RESPONSE: u16 = 0x580;
const SDO_REQUEST: u16 = 0x600;
const HEARTBEAT: u16 = 0x700;

impl CanopenMessage {
    pub fn decode(frame: &Frame) -> Result<CanopenMessage, FrameDecodeError> {
        let word = frame.id_word();
        let cob_id = match (frame.cob_id(), frame.kind()) {
            (Some(cob_id), _) => cob_id,
            (None, FrameKind::Error(class)) => return Err(FrameDecodeError::ErrorFrame { class }),
            (None, FrameKind::Remote) => return Err(FrameDecodeError::Remote { id: word & 0x1FFF_FFFF }),
            (None, FrameKind::Data) => return Err(FrameDecodeError::Extended { id: word & 0x1FFF_FFFF }),
        };
        let data = frame.data();
        match (cob_id & 0x780, NodeId::new((cob_id & 0x7F) as u8)) {
            (NMT, None) => nmt::decode(data),
            (SYNC, None) => decode_sync(data),
            (EMERGENCY, Some(node)) => emcy::decode(cob_id, node, data),
            (TPDO1, Some(node)) => Ok(CanopenMessage::Tpdo1 { node, payload: Payload::of(data) }),
            (RPDO1, Some(node)) => Ok(CanopenMessage::Rpdo1 { node, payload: Payload::of(data) }),
            (base @ (TPDO2 | TPDO3 | TPDO4), Some(node)) => {
                Ok(CanopenMessage::Tpdo { node, number: number(base, TPDO2), payload: Payload::of(data) })
            }
            (base @ (RPDO2 | RPDO3 | RPDO4), Some(node)) => {
                Ok(CanopenMessage::Rpdo { node, number: number(base, RPDO2), payload: Payload::of(data) })
            }
            (SDO_RESPONSE, Some(node)) => Ok(CanopenMessage::SdoResponse { node, raw: eight(cob_id, data)? }),
            (SDO_REQUEST, Some(node)) => Ok(CanopenMessage::SdoRequest { node, raw: eight(cob_id, data)? }),
            (HEARTBEAT, Some(node)) => {
                let state = nmt::decode_state(cob_id, data)?;
                Ok(CanopenMessage::Heartbeat { node, state })
            }
            _ => Err(FrameDecodeError::UnknownCobId { cob_id }),
        }
    }

    pub fn encode(&self) -> Frame {
        match self {
            CanopenMessage::Nmt { command, node } => frame(NMT, None, &[command.code(), node.map_or(0, NodeId::get)]),
            CanopenMessage::Sync { counter } => frame(SYNC, None, counter.as_ref().map_or(&[], std::slice::from_ref)),
            CanopenMessage::Emergency { node, emergency } => frame(EMERGENCY, Some(*node), &emergency.to_bytes()),
            CanopenMessage::Tpdo1 { node, payload } => frame(TPDO1, Some(*node), payload.bytes()),
            CanopenMessage::Rpdo1 { node, payload } => frame(RPDO1, Some(*node), payload.bytes()),
            CanopenMessage::Tpdo { node, number, payload } => frame(base(TPDO2, *number), Some(*node), payload.bytes()),
            CanopenMessage::Rpdo { node, number, payload } => frame(base(RPDO2, *number), Some(*node), payload.bytes()),
            CanopenMessage::SdoResponse { node, raw } => frame(SDO_RESPONSE, Some(*node), raw),
            CanopenMessage::SdoRequest { node, raw } => frame(SDO_REQUEST, Some(*node), raw),
            CanopenMessage::Heartbeat { node, state } => frame(HEARTBEAT, Some(*node), &[state.code()]),
        }
    }
}

/// A frame of at most eight bytes with an identifier of at most 0x77F: both hold by construction of the callers.
fn frame(base: u16, node: Option<NodeId>, data: &[u8]) -> Frame {
    let cob_id = base | u16::from(node.map_or(0, NodeId::get));
    Frame::data_frame(cob_id, data).expect("every message fits an 11-bit identifier and eight bytes")
}

/// Number of the PDO with this COB-ID, that of the second being `second`.
fn number(cob_id: u16, second: u16) -> u8 {
    ((cob_id - second) / 0x100) as u8 + 2
}

/// And back; beyond the second to the fourth there is none.
fn base(second: u16, number: u8) -> u16 {
    second + 0x100 * u16::from(number.clamp(2, 4) - 2)
}

/// SDO frames always have eight bytes (CiA 301 §7.2.4.3).
fn eight(cob_id: u16, data: &[u8]) -> Result<SdoBytes, FrameDecodeError> {
    data.try_into().map_err(|_| FrameDecodeError::Length { cob_id, expected: "8", actual: data.len() })
}

/// CiA 301 §7.2.5.3.1: no data, or a counter of one byte.
fn decode_sync(data: &[u8]) -> Result<CanopenMessage, FrameDecodeError> {
    match data {
        [] => Ok(CanopenMessage::Sync { counter: None }),
        [counter] => Ok(CanopenMessage::Sync { counter: Some(*counter) }),
        _ => Err(FrameDecodeError::Length { cob_id: SYNC, expected: "0 or 1", actual: data.len() }),
    }
}

#[cfg(test)]
mod tests;
