//! One classic CAN frame.
//!
//! Laid out like Linux's `struct can_frame`, so that the virtual bus carries exactly what a CAN socket would. A frame
//! is a value: extended identifiers, remote requests and the kernel's error frames can all be held and printed, and
//! readers refuse those they have no use for.

use embedded_can::{ExtendedId, Id, StandardId};
use linewright_line::FrameId;
use thiserror::Error;

/// Error class "bus off" (`CAN_ERR_BUSOFF` in `linux/can/error.h`).
pub(crate) const BUS_OFF: u32 = 0x40;
/// Error class "controller restarted" (`CAN_ERR_RESTARTED`).
pub(crate) const RESTARTED: u32 = 0x100;

/// Set in the id word of a frame with a 29-bit identifier (`CAN_EFF_FLAG`).
const EXTENDED: u32 = 0x8000_0000;
/// Set in the id word of a remote transmission request (`CAN_RTR_FLAG`).
const REMOTE: u32 = 0x4000_0000;
/// Set in the id word of an error frame made by the kernel (`CAN_ERR_FLAG`).
const ERROR: u32 = 0x2000_0000;

/// A frame's size on a CAN socket and on the virtual bus, in bytes.
pub const FRAME_BYTES: usize = 16;

/// A classic CAN frame: identifier, kind, up to eight bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Frame {
    /// The kernel's id word: flags in the top three bits, identifier below.
    word: u32,
    len: u8,
    data: [u8; 8],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameKind {
    Data,
    /// A remote transmission request.
    Remote,
    /// An error frame: not from the bus, but the kernel's report about the bus. Carries its error class bits
    /// (`linux/can/error.h`).
    Error(u32),
}

/// Why sixteen bytes, or a line of text, are not a frame.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FrameError {
    /// The datagram has another size.
    #[error("a CAN frame takes {FRAME_BYTES} bytes, this has {actual}")]
    Size {
        /// Bytes found.
        actual: usize,
    },
    /// The length field exceeds what a classic frame holds.
    #[error("a classic CAN frame holds up to 8 bytes, this one claims {actual}")]
    Length {
        /// Bytes claimed.
        actual: usize,
    },
    /// The text does not follow candump's form.
    #[error("`{text}` is not a frame: expected {expected}, as in 181#0102")]
    Text {
        text: String,
        /// Expected value.
        expected: &'static str,
    },
}

impl Frame {
    /// A data frame with an 11-bit identifier, or `None` where the identifier or the data is too long.
    pub fn data_frame(id: u16, data: &[u8]) -> Option<Self> {
        embedded_can::Frame::new(StandardId::new(id)?, data)
    }

    /// A data frame with an identifier of either length, or `None` where the identifier or the data is too long.
    pub fn of_id(id: FrameId, data: &[u8]) -> Option<Self> {
        let id: Id = if id.extended {
            ExtendedId::new(id.id)?.into()
        } else {
            StandardId::new(u16::try_from(id.id).ok()?)?.into()
        };
        embedded_can::Frame::new(id, data)
    }

    /// A frame from the kernel's id word and its data; what exceeds eight bytes is an error.
    pub fn from_word(word: u32, data: &[u8]) -> Result<Self, FrameError> {
        if data.len() > 8 {
            return Err(FrameError::Length { actual: data.len() });
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        Ok(Frame { word: normal(word), len: data.len() as u8, data: bytes })
    }

    /// A remote request with the kernel's id word; it has a length but no data.
    pub fn remote_from_word(word: u32, len: u8) -> Result<Self, FrameError> {
        if len > 8 {
            return Err(FrameError::Length { actual: len.into() });
        }
        Ok(Frame { word: normal(word | REMOTE), len, data: [0; 8] })
    }

    /// The kernel's id word: flags and identifier.
    pub fn id_word(&self) -> u32 {
        self.word
    }

    /// The 11-bit identifier of a data frame: what CANopen calls the COB-ID. `None` for anything else.
    pub fn cob_id(&self) -> Option<u16> {
        (self.word & (EXTENDED | REMOTE | ERROR) == 0).then_some((self.word & 0x7FF) as u16)
    }

    /// The identifier of a data frame, whatever its length; `None` for anything else.
    pub fn frame_id(&self) -> Option<FrameId> {
        let extended = self.word & EXTENDED != 0;
        (self.kind() == FrameKind::Data).then_some(FrameId { id: self.word & 0x1FFF_FFFF, extended })
    }

    pub fn kind(&self) -> FrameKind {
        if self.word & ERROR != 0 {
            FrameKind::Error(self.word & 0x1FFF_FFFF)
        } else if self.word & REMOTE != 0 {
            FrameKind::Remote
        } else {
            FrameKind::Data
        }
    }

    /// The length field, 0 to 8. A remote request has one without having data.
    pub fn len(&self) -> usize {
        self.len.into()
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The data; empty for a remote request.
    pub fn data(&self) -> &[u8] {
        if self.kind() == FrameKind::Remote { &[] } else { &self.data[..usize::from(self.len)] }
    }

    /// The frame as `struct can_frame` lays it out on this machine: id word, length, three bytes of padding, data.
    pub fn to_bytes(&self) -> [u8; FRAME_BYTES] {
        let mut bytes = [0; FRAME_BYTES];
        bytes[..4].copy_from_slice(&self.word.to_ne_bytes());
        bytes[4] = self.len;
        bytes[8..].copy_from_slice(&self.data);
        bytes
    }

    /// The frame those bytes hold.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FrameError> {
        let bytes: &[u8; FRAME_BYTES] = bytes.try_into().map_err(|_| FrameError::Size { actual: bytes.len() })?;
        let word = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let len = usize::from(bytes[4]);
        if len > 8 {
            return Err(FrameError::Length { actual: len });
        }
        if word & REMOTE != 0 && word & ERROR == 0 {
            return Frame::remote_from_word(word, bytes[4]);
        }
        Frame::from_word(word, &bytes[8..8 + len])
    }
}

/// The id word without bits that have no meaning: above bit 11 in a standard identifier. Two equal frames then
/// compare equal.
fn normal(word: u32) -> u32 {
    if word & (EXTENDED | ERROR) != 0 { word } else { word & (REMOTE | 0x7FF) }
}

fn word_of(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => EXTENDED | id.as_raw(),
    }
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Frame::from_word(word_of(id.into()), data).ok()
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        Frame::remote_from_word(word_of(id.into()), u8::try_from(dlc).ok()?).ok()
    }

    fn is_extended(&self) -> bool {
        // An error frame's class bits fill 29 bits: as an identifier it can only be an extended one.
        self.word & (EXTENDED | ERROR) != 0
    }

    fn is_remote_frame(&self) -> bool {
        self.kind() == FrameKind::Remote
    }

    fn is_data_frame(&self) -> bool {
        self.kind() == FrameKind::Data
    }

    fn id(&self) -> Id {
        if self.is_extended() {
            Id::Extended(ExtendedId::new(self.word & 0x1FFF_FFFF).unwrap_or(ExtendedId::ZERO))
        } else {
            Id::Standard(StandardId::new((self.word & 0x7FF) as u16).unwrap_or(StandardId::ZERO))
        }
    }

    fn dlc(&self) -> usize {
        self.len()
    }

    fn data(&self) -> &[u8] {
        Frame::data(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::Frame as _;
    use proptest::prelude::*;

    #[test]
    fn layout_is_that_of_the_kernel() {
        let frame = Frame::data_frame(0x181, &[1, 2]).unwrap();
        let mut expected = [0u8; 16];
        expected[..4].copy_from_slice(&0x181u32.to_ne_bytes());
        expected[4] = 2;
        expected[8] = 1;
        expected[9] = 2;
        assert_eq!(frame.to_bytes(), expected);
        assert_eq!(frame.cob_id(), Some(0x181));
    }

    #[test]
    fn too_long_is_refused() {
        assert_eq!(Frame::data_frame(0x800, &[]), None);
        assert_eq!(Frame::data_frame(0x7FF, &[0; 9]), None);
        assert_eq!(Frame::from_bytes(&[0; 15]), Err(FrameError::Size { actual: 15 }));
        let mut bytes = [0; 16];
        bytes[4] = 9;
        assert_eq!(Frame::from_bytes(&bytes), Err(FrameError::Length { actual: 9 }));
    }

    #[test]
    fn extended_remote_and_error_frames_survive_as_values() {
        let extended = Frame::new(ExtendedId::new(0x181).unwrap(), &[7]).unwrap();
        assert!(extended.is_extended());
        assert_eq!(extended.cob_id(), None);
        let id = FrameId { id: 0x181, extended: true };
        assert_eq!((extended.frame_id(), Frame::of_id(id, &[7])), (Some(id), Some(extended)));
        assert_eq!(Frame::of_id(FrameId { id: 0x800, extended: false }, &[]), None);
        let remote = Frame::new_remote(StandardId::new(0x701).unwrap(), 1).unwrap();
        assert_eq!((remote.kind(), remote.len(), remote.data()), (FrameKind::Remote, 1, &[][..]));
        let error = Frame::from_word(ERROR | 0x40, &[0; 8]).unwrap();
        assert_eq!((remote.frame_id(), error.frame_id()), (None, None));
        assert_eq!(error.kind(), FrameKind::Error(0x40));
        for frame in [extended, remote, error] {
            assert_eq!(Frame::from_bytes(&frame.to_bytes()), Ok(frame));
        }
    }

    proptest! {
        #[test]
        fn any_sixteen_bytes_are_a_frame_or_an_error(bytes in any::<[u8; 16]>()) {
            if let Ok(frame) = Frame::from_bytes(&bytes) {
                prop_assert_eq!(Frame::from_bytes(&frame.to_bytes()), Ok(frame));
                let _ = (frame.id(), frame.data(), format!("{frame} {frame:?}"));
            }
        }
    }
}
