//! The eight bytes of an SDO frame and their meaning (CiA 301 §7.2.4.3).
//!
//! Pure translation, total: bytes without meaning decode to `None`. The segments of a block carry a number where all
//! other frames have their command; they are therefore a type of their own, which only the state of a transfer can
//! distinguish. Reserved bits are sent as 0 and not looked at.

use super::{Abort, ObjectId};

/// An SDO frame's data: always eight bytes.
pub type SdoBytes = [u8; 8];

/// The first byte of an abort, in either direction. Compared whole: in a block, 81h to FFh are segments.
pub(super) const ABORT: u8 = 0x80;

/// Content of an initiating frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitiateContent {
    /// The whole object, up to four bytes.
    Expedited {
        /// The bytes; those beyond `len` are 0.
        bytes: [u8; 4],
        /// Number of data bytes, 1 to 4.
        len: u8,
        /// Whether the sender gave the number. If not, `len` is 4, and the object may be shorter.
        sized: bool,
    },
    /// Nothing yet: segments follow.
    Segmented {
        /// Bytes they will carry, where announced.
        size: Option<u32>,
    },
}

impl InitiateContent {
    /// Up to four bytes, but at least one, as an expedited transfer carries them.
    pub fn expedited(data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 4];
        bytes.get_mut(..data.len()).filter(|b| !b.is_empty())?.copy_from_slice(data);
        Some(InitiateContent::Expedited { bytes, len: data.len() as u8, sized: true })
    }

    fn decode(raw: &SdoBytes) -> Self {
        let [command, _, _, _, a, b, c, d] = *raw;
        let sized = command & 0x01 != 0;
        if command & 0x02 == 0 {
            return InitiateContent::Segmented { size: sized.then(|| u32::from_le_bytes([a, b, c, d])) };
        }
        let len = if sized { 4 - ((command >> 2) & 3) } else { 4 };
        let mut bytes = [0; 4];
        bytes[..usize::from(len)].copy_from_slice(&raw[4..4 + usize::from(len)]);
        InitiateContent::Expedited { bytes, len, sized }
    }

    fn encode(self, command: u8, object: ObjectId) -> SdoBytes {
        match self {
            InitiateContent::Expedited { bytes, len, sized: true } => {
                build(command | (4 - len) << 2 | 0x03, object, bytes)
            }
            InitiateContent::Expedited { bytes, .. } => build(command | 0x02, object, bytes),
            InitiateContent::Segmented { size: Some(size) } => build(command | 0x01, object, size.to_le_bytes()),
            InitiateContent::Segmented { size: None } => build(command, object, [0; 4]),
        }
    }
}

/// Up to seven bytes of a segmented transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Alternates, beginning with `false`.
    pub toggle: bool,
    pub last: bool,
    len: u8,
    bytes: [u8; 7],
}

impl Segment {
    /// The segment of `data` that begins at `at`, up to seven bytes.
    pub fn of(data: &[u8], at: usize, toggle: bool) -> Self {
        let rest = data.get(at..).unwrap_or(&[]);
        let len = rest.len().min(7);
        let mut bytes = [0; 7];
        bytes[..len].copy_from_slice(&rest[..len]);
        Segment { toggle, last: rest.len() <= 7, len: len as u8, bytes }
    }

    /// The bytes carried, 0 to 7.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }

    fn decode(raw: &SdoBytes) -> Self {
        let [command, ref rest @ ..] = *raw;
        let len = 7 - (command >> 1 & 7);
        let mut bytes = [0; 7];
        bytes[..usize::from(len)].copy_from_slice(&rest[..usize::from(len)]);
        Segment { toggle: command & TOGGLE != 0, last: command & 0x01 != 0, len, bytes }
    }

    fn encode(self) -> SdoBytes {
        let [a, b, c, d, e, f, g] = self.bytes;
        [toggled(0x00, self.toggle) | (7 - self.len) << 1 | u8::from(self.last), a, b, c, d, e, f, g]
    }
}

/// Seven bytes of a block, numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockSegment {
    /// Its number in its block, 1 to 127.
    pub number: u8,
    /// Whether it is the last of the transfer. The number of its bytes that count is in the end frame.
    pub last: bool,
    pub bytes: [u8; 7],
}

impl BlockSegment {
    /// The segment a frame carries while a block is under way; `None` for number 0.
    pub fn decode(raw: &SdoBytes) -> Option<Self> {
        let [head, bytes @ ..] = *raw;
        (head & 0x7F != 0).then_some(BlockSegment { number: head & 0x7F, last: head & 0x80 != 0, bytes })
    }

    pub fn encode(&self) -> SdoBytes {
        let [a, b, c, d, e, f, g] = self.bytes;
        [self.number & 0x7F | if self.last { 0x80 } else { 0 }, a, b, c, d, e, f, g]
    }
}

/// Frame of a client, segments of a block excepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClientFrame {
    /// Write an object.
    Download {
        object: ObjectId,
        content: InitiateContent,
    },
    /// More of what is to be written.
    DownloadSegment(Segment),
    /// Read an object.
    Upload {
        object: ObjectId,
    },
    /// Send more of what is read.
    UploadSegment {
        /// Alternates, beginning with `false`.
        toggle: bool,
    },
    /// Write an object in blocks.
    BlockDownload {
        object: ObjectId,
        /// Whether the client computes the checksum.
        crc: bool,
        /// Length in bytes, where announced.
        size: Option<u32>,
    },
    /// All blocks are written.
    BlockDownloadEnd {
        /// Unused bytes of the last segment, 0 to 7.
        unused: u8,
        crc: u16,
    },
    /// Read an object in blocks.
    BlockUpload {
        object: ObjectId,
        /// Whether the client checks the checksum.
        crc: bool,
        /// Segments in the first block, 1 to 127.
        block: u8,
        /// Up to this many bytes the server may answer as to [`ClientFrame::Upload`]; 0 for never.
        switch_at: u8,
    },
    BlockUploadStart,
    /// A block was received.
    BlockAck(BlockAck),
    /// All blocks were received, and the checksum was right.
    BlockUploadEnd,
    Abort {
        object: ObjectId,
        code: Abort,
    },
}

/// Frame of a server, segments of a block excepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServerFrame {
    /// The object is written, or its segments may come.
    Download {
        object: ObjectId,
    },
    DownloadSegment {
        /// Toggle bit of the confirmed segment.
        toggle: bool,
    },
    /// The object, or the announcement of its segments.
    Upload {
        object: ObjectId,
        /// Its bytes or their number.
        content: InitiateContent,
    },
    /// More of the object.
    UploadSegment(Segment),
    /// Blocks may come.
    BlockDownload {
        object: ObjectId,
        /// Whether the server checks the checksum.
        crc: bool,
        /// Segments in the first block, 1 to 127.
        block: u8,
    },
    /// A block was received.
    BlockAck(BlockAck),
    /// All blocks were received and written.
    BlockDownloadEnd,
    /// Blocks will come.
    BlockUpload {
        object: ObjectId,
        /// Whether the server computes the checksum.
        crc: bool,
        /// Length in bytes, where announced.
        size: Option<u32>,
    },
    /// All blocks are sent.
    BlockUploadEnd {
        /// Unused bytes of the last segment, 0 to 7.
        unused: u8,
        crc: u16,
    },
    Abort {
        object: ObjectId,
        code: Abort,
    },
}

/// A receiver's acknowledgement of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockAck {
    /// The last segment that came in order, 0 for none: the next block begins after it.
    pub good: u8,
    /// Segments in the next block, 1 to 127.
    pub next: u8,
}

const TOGGLE: u8 = 0x10;

fn toggled(command: u8, toggle: bool) -> u8 {
    if toggle { command | TOGGLE } else { command }
}

fn flag(on: bool, bit: u8) -> u8 {
    if on { bit } else { 0 }
}

fn build(command: u8, object: ObjectId, data: [u8; 4]) -> SdoBytes {
    let [low, high] = object.index.to_le_bytes();
    let [a, b, c, d] = data;
    [command, low, high, object.sub, a, b, c, d]
}

fn object(raw: &SdoBytes) -> ObjectId {
    ObjectId::new(u16::from_le_bytes([raw[1], raw[2]]), raw[3])
}

fn number(raw: &SdoBytes) -> u32 {
    u32::from_le_bytes([raw[4], raw[5], raw[6], raw[7]])
}

fn end(command: u8, unused: u8, crc: u16) -> SdoBytes {
    let [low, high] = crc.to_le_bytes();
    [command | 0x01 | (unused & 7) << 2, low, high, 0, 0, 0, 0, 0]
}

fn block_size(command: u8, object: ObjectId, crc: bool, size: Option<u32>) -> SdoBytes {
    build(command | flag(crc, 0x04) | flag(size.is_some(), 0x02), object, size.unwrap_or(0).to_le_bytes())
}

fn ack(raw: &SdoBytes) -> BlockAck {
    BlockAck { good: raw[1], next: raw[2] }
}

impl ClientFrame {
    /// The request in a frame; `None` for a command that does not exist.
    pub fn decode(raw: &SdoBytes) -> Option<Self> {
        let command = raw[0];
        Some(match (command >> 5, command & 0x03) {
            (0, _) => ClientFrame::DownloadSegment(Segment::decode(raw)),
            (1, _) => ClientFrame::Download { object: object(raw), content: InitiateContent::decode(raw) },
            (2, _) => ClientFrame::Upload { object: object(raw) },
            (3, _) => ClientFrame::UploadSegment { toggle: command & TOGGLE != 0 },
            (4, _) if command == ABORT => ClientFrame::Abort { object: object(raw), code: Abort(number(raw)) },
            (5, 0) => {
                let (crc, block, switch_at) = (command & 0x04 != 0, raw[4], raw[5]);
                ClientFrame::BlockUpload { object: object(raw), crc, block, switch_at }
            }
            (5, 1) => ClientFrame::BlockUploadEnd,
            (5, 2) => ClientFrame::BlockAck(ack(raw)),
            (5, _) => ClientFrame::BlockUploadStart,
            (6, 0 | 2) => {
                let size = (command & 0x02 != 0).then(|| number(raw));
                ClientFrame::BlockDownload { object: object(raw), crc: command & 0x04 != 0, size }
            }
            (6, _) => {
                ClientFrame::BlockDownloadEnd { unused: command >> 2 & 7, crc: u16::from_le_bytes([raw[1], raw[2]]) }
            }
            _ => return None,
        })
    }

    pub fn encode(self) -> SdoBytes {
        match self {
            ClientFrame::Download { object, content } => content.encode(0x20, object),
            ClientFrame::DownloadSegment(segment) => segment.encode(),
            ClientFrame::Upload { object } => build(0x40, object, [0; 4]),
            ClientFrame::UploadSegment { toggle } => [toggled(0x60, toggle), 0, 0, 0, 0, 0, 0, 0],
            ClientFrame::BlockDownload { object, crc, size } => block_size(0xC0, object, crc, size),
            ClientFrame::BlockDownloadEnd { unused, crc } => end(0xC0, unused, crc),
            ClientFrame::BlockUpload { object, crc, block, switch_at } => {
                build(0xA0 | flag(crc, 0x04), object, [block, switch_at, 0, 0])
            }
            ClientFrame::BlockUploadStart => [0xA3, 0, 0, 0, 0, 0, 0, 0],
            ClientFrame::BlockAck(BlockAck { good, next }) => [0xA2, good, next, 0, 0, 0, 0, 0],
            ClientFrame::BlockUploadEnd => [0xA1, 0, 0, 0, 0, 0, 0, 0],
            ClientFrame::Abort { object, code } => build(ABORT, object, code.0.to_le_bytes()),
        }
    }
}

impl ServerFrame {
    /// The response in a frame; `None` for a command that does not exist.
    pub fn decode(raw: &SdoBytes) -> Option<Self> {
        let command = raw[0];
        Some(match (command >> 5, command & 0x03) {
            (0, _) => ServerFrame::UploadSegment(Segment::decode(raw)),
            (1, _) => ServerFrame::DownloadSegment { toggle: command & TOGGLE != 0 },
            (2, _) => ServerFrame::Upload { object: object(raw), content: InitiateContent::decode(raw) },
            (3, _) => ServerFrame::Download { object: object(raw) },
            (4, _) if command == ABORT => ServerFrame::Abort { object: object(raw), code: Abort(number(raw)) },
            (5, 0) => ServerFrame::BlockDownload { object: object(raw), crc: command & 0x04 != 0, block: raw[4] },
            (5, 1) => ServerFrame::BlockDownloadEnd,
            (5, 2) => ServerFrame::BlockAck(ack(raw)),
            (6, 0 | 2) => {
                let size = (command & 0x02 != 0).then(|| number(raw));
                ServerFrame::BlockUpload { object: object(raw), crc: command & 0x04 != 0, size }
            }
            (6, _) => {
                ServerFrame::BlockUploadEnd { unused: command >> 2 & 7, crc: u16::from_le_bytes([raw[1], raw[2]]) }
            }
            _ => return None,
        })
    }

    pub fn encode(self) -> SdoBytes {
        match self {
            ServerFrame::Download { object } => build(0x60, object, [0; 4]),
            ServerFrame::DownloadSegment { toggle } => [toggled(0x20, toggle), 0, 0, 0, 0, 0, 0, 0],
            ServerFrame::Upload { object, content } => content.encode(0x40, object),
            ServerFrame::UploadSegment(segment) => segment.encode(),
            ServerFrame::BlockDownload { object, crc, block } => {
                build(0xA0 | flag(crc, 0x04), object, [block, 0, 0, 0])
            }
            ServerFrame::BlockAck(BlockAck { good, next }) => [0xA2, good, next, 0, 0, 0, 0, 0],
            ServerFrame::BlockDownloadEnd => [0xA1, 0, 0, 0, 0, 0, 0, 0],
            ServerFrame::BlockUpload { object, crc, size } => block_size(0xC0, object, crc, size),
            ServerFrame::BlockUploadEnd { unused, crc } => end(0xC0, unused, crc),
            ServerFrame::Abort { object, code } => build(ABORT, object, code.0.to_le_bytes()),
        }
    }

    /// The object it names; the frames within a transfer name none.
    pub fn object(&self) -> Option<ObjectId> {
        match *self {
            ServerFrame::Download { object }
            | ServerFrame::Upload { object, .. }
            | ServerFrame::BlockDownload { object, .. }
            | ServerFrame::BlockUpload { object, .. }
            | ServerFrame::Abort { object, .. } => Some(object),
            ServerFrame::DownloadSegment { .. }
            | ServerFrame::UploadSegment(_)
            | ServerFrame::BlockAck(_)
            | ServerFrame::BlockDownloadEnd
            | ServerFrame::BlockUploadEnd { .. } => None,
        }
    }
}
