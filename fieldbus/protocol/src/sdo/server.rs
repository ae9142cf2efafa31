//! The server: answers for a dictionary, one transfer at a time.
//!
//! ```text
//!           ┌──▶ (expedited) ──────────────────────────────────────────────▶ Idle
//!  Idle ────┼──▶ Sending / Receiving, segment by segment ──────────────────▶ Idle
//!    ▲      ├──▶ BlockOffered ──▶ BlockSending ──▶ BlockEnding ────────────▶ Idle
//!    │      └──▶ BlockReceiving (until the end frame) ─────────────────────▶ Idle
//!    └── from everywhere: abort by either side, or nothing heard for too long; a new transfer replaces an old one
//! ```
//!
//! The dictionary is read once, when a transfer begins, and written once, when all bytes have come and are those that
//! were announced: a transfer that ends in between has changed nothing.

use std::borrow::Cow;
use std::time::Duration;

use linewright_line::Tick;

use super::block::{
    self, BLOCK_MAX, BURST, BlockReceiver, BlockSender, PACE, STALL, check_size, reserve, too_long, unused,
};
use super::cause::TransferFailure;
use super::wire::{ABORT, BlockSegment, ClientFrame, InitiateContent, SdoBytes, Segment, ServerFrame};
use super::{Abort, ObjectId};

/// A device's objects, as a [`SdoServer`] reaches them.
pub trait Dictionary {
    /// The bytes of an object, least significant first.
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort>;

    /// Gives an object these bytes. All of them are here; a wrong number is [`Abort::LENGTH`].
    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort>;

    /// Whether an object may be written, before its bytes come; `len` is their number, where the client gives it. Need
    /// not be complete, [`Dictionary::write`] decides. Saves useless transfers of long objects.
    fn may_write(&mut self, object: ObjectId, len: Option<usize>) -> Result<(), Abort> {
        let _ = (object, len);
        Ok(())
    }
}

#[derive(Debug)]
enum ServerState {
    Idle,
    /// Bytes up to `at` are sent; the segment requested next has this toggle.
    Sending {
        data: Vec<u8>,
        at: usize,
        toggle: bool,
    },
    /// The segment that comes next has this toggle.
    Receiving {
        data: Vec<u8>,
        size: Option<u32>,
        toggle: bool,
    },
    /// Blocks are announced, and begin on the client's start frame.
    BlockOffered {
        data: Vec<u8>,
        block: u8,
        crc: bool,
    },
    BlockSending {
        data: Vec<u8>,
        sender: BlockSender,
        crc: bool,
    },
    /// The end frame is out.
    BlockEnding,
    /// `first` is the frame that began it: it may come again.
    BlockReceiving {
        receiver: BlockReceiver,
        crc: bool,
        first: SdoBytes,
    },
}

/// Most silence of a client within a transfer. Longer than clients wait for an answer: they give up first.
const TIMEOUT: Duration = Duration::from_secs(3);

/// The SDO server of one device.
#[derive(Debug)]
pub struct SdoServer {
    len_max: usize,
    state: ServerState,
    object: ObjectId,
    due: Tick,
}

/// Result of a frame: nothing to answer here, or a reason to abort.
type ServerResult = Result<(), TransferFailure>;

impl SdoServer {
    /// A server that takes objects of up to `len_max` bytes.
    pub fn new(len_max: usize) -> Self {
        SdoServer { len_max, state: ServerState::Idle, object: ObjectId::new(0, 0), due: Tick::NEVER }
    }

    /// Forgets a transfer under way: the device boots, or may not communicate.
    pub fn reset(&mut self) {
        self.state = ServerState::Idle;
    }

    pub fn handle(&mut self, now: Tick, raw: &SdoBytes, dictionary: &mut impl Dictionary, out: &mut Vec<SdoBytes>) {
        let outcome = match &self.state {
            ServerState::BlockReceiving { receiver, first, .. } if !receiver.complete() && raw[0] != ABORT => {
                if receiver.len() == 0 && raw == first {
                    self.request(now, raw, dictionary, out)
                } else {
                    self.block(now, raw, out)
                }
            }
            _ => self.request(now, raw, dictionary, out),
        };
        if let Err(cause) = outcome {
            self.abort(&cause, out);
        }
    }

    /// Does what is due: sending more of a block, or giving up a client that is gone.
    pub fn poll(&mut self, now: Tick, out: &mut Vec<SdoBytes>) {
        if now < self.due {
            return;
        }
        let silent = TransferFailure::Silent { waited: TIMEOUT, done: 0, asked: 1 };
        match &mut self.state {
            ServerState::Idle => return,
            ServerState::BlockSending { data, sender, .. } if !sender.waits(data) => sender.send(data, BURST, out),
            // Perhaps only the end of the block was lost.
            ServerState::BlockReceiving { receiver, .. } if !receiver.complete() => match receiver.acknowledge() {
                Some(ack) => out.push(ServerFrame::BlockAck(ack).encode()),
                None => return self.abort(&silent, out),
            },
            _ => return self.abort(&silent, out),
        }
        self.due = now + self.patience();
    }

    pub fn next_deadline(&self) -> Option<Tick> {
        self.under_way().map(|_| self.due)
    }

    /// The object whose transfer is under way.
    pub fn under_way(&self) -> Option<ObjectId> {
        (!matches!(self.state, ServerState::Idle)).then_some(self.object)
    }

    fn request(
        &mut self,
        now: Tick,
        raw: &SdoBytes,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<SdoBytes>,
    ) -> ServerResult {
        let Some(request) = ClientFrame::decode(raw) else { return Err(self.unexpected(raw[0])) };
        match request {
            ClientFrame::Upload { object } => self.upload(object, None, dictionary, out)?,
            ClientFrame::BlockUpload { object, crc, block, switch_at } => {
                self.upload(object, Some((crc, block, switch_at)), dictionary, out)?;
            }
            ClientFrame::Download { object, content } => self.download(object, content, dictionary, out)?,
            ClientFrame::BlockDownload { object, crc, size } => {
                self.begin_write(object, size, dictionary)?;
                let receiver = BlockReceiver::new(size, self.len_max);
                self.state = ServerState::BlockReceiving { receiver, crc, first: *raw };
                // A checksum is used if both sides have one, and some clients go by this answer alone.
                out.push(ServerFrame::BlockDownload { object, crc, block: BLOCK_MAX }.encode());
            }
            ClientFrame::UploadSegment { toggle } => self.send_segment(raw[0], toggle, out)?,
            ClientFrame::DownloadSegment(segment) => self.take_segment(raw[0], &segment, dictionary, out)?,
            // No matter which object it names: some clients name none.
            ClientFrame::Abort { .. } => self.state = ServerState::Idle,
            ClientFrame::BlockUploadStart | ClientFrame::BlockAck(_) | ClientFrame::BlockUploadEnd => {
                self.blocks_out(raw[0], request, out)?;
            }
            ClientFrame::BlockDownloadEnd { unused, crc } => self.end_blocks(raw[0], unused, crc, dictionary, out)?,
        }
        self.due = now + self.patience();
        Ok(())
    }

    /// Begins to send an object; `blocks`: whether with checksums, the block size, and the length up to which the
    /// object goes without blocks.
    fn upload(
        &mut self,
        object: ObjectId,
        blocks: Option<(bool, u8, u8)>,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<SdoBytes>,
    ) -> ServerResult {
        self.begin(object);
        if let Some((_, size, _)) = blocks
            && !(1..=BLOCK_MAX).contains(&size)
        {
            return Err(TransferFailure::BlockSize { size });
        }
        let data = dictionary.read(object).map_err(TransferFailure::Refused)?;
        let size = u32::try_from(data.len()).map_err(|_| TransferFailure::TooLong { len_max: u32::MAX as usize })?;
        let blocks = blocks.filter(|(_, _, switch_at)| data.len() > usize::from(*switch_at) || *switch_at == 0);
        if let Some((crc, block, _)) = blocks {
            self.state = ServerState::BlockOffered { data: data.into_owned(), block, crc };
            out.push(ServerFrame::BlockUpload { object, crc, size: Some(size) }.encode());
        } else if let Some(content) = InitiateContent::expedited(&data) {
            out.push(ServerFrame::Upload { object, content }.encode());
        } else {
            self.state = ServerState::Sending { data: data.into_owned(), at: 0, toggle: false };
            out.push(ServerFrame::Upload { object, content: InitiateContent::Segmented { size: Some(size) } }.encode());
        }
        Ok(())
    }

    /// Writes an object, or begins to receive it.
    fn download(
        &mut self,
        object: ObjectId,
        content: InitiateContent,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<SdoBytes>,
    ) -> ServerResult {
        match content {
            InitiateContent::Expedited { bytes, len, sized } => {
                self.begin(object);
                let len = if sized { usize::from(len) } else { length_of(object, dictionary) };
                dictionary.write(object, &bytes[..len]).map_err(TransferFailure::Refused)?;
            }
            InitiateContent::Segmented { size } => {
                self.begin_write(object, size, dictionary)?;
                self.state = ServerState::Receiving { data: reserve(size, self.len_max), size, toggle: false };
            }
        }
        out.push(ServerFrame::Download { object }.encode());
        Ok(())
    }

    /// A transfer begins. One that was under way is over.
    fn begin(&mut self, object: ObjectId) {
        self.state = ServerState::Idle;
        self.object = object;
    }

    fn begin_write(&mut self, object: ObjectId, size: Option<u32>, dictionary: &mut impl Dictionary) -> ServerResult {
        self.begin(object);
        let len = size.map(|size| size as usize);
        dictionary.may_write(object, len).map_err(TransferFailure::Refused)?;
        if len.is_some_and(|len| len > self.len_max) {
            return Err(TransferFailure::TooLong { len_max: self.len_max });
        }
        Ok(())
    }

    fn send_segment(&mut self, command: u8, asked: bool, out: &mut Vec<SdoBytes>) -> ServerResult {
        let ServerState::Sending { data, at, toggle } = &mut self.state else { return Err(self.unexpected(command)) };
        if asked != *toggle {
            return Err(TransferFailure::Toggle { done: *at });
        }
        let segment = Segment::of(data, *at, *toggle);
        out.push(ServerFrame::UploadSegment(segment).encode());
        *at += 7;
        *toggle = !*toggle;
        if segment.last {
            self.state = ServerState::Idle;
        }
        Ok(())
    }

    fn take_segment(
        &mut self,
        command: u8,
        segment: &Segment,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<SdoBytes>,
    ) -> ServerResult {
        let ServerState::Receiving { data, size, toggle } = &mut self.state else {
            return Err(self.unexpected(command));
        };
        if segment.toggle != *toggle {
            return Err(TransferFailure::Toggle { done: data.len() });
        }
        let most = size.map_or(self.len_max, |size| self.len_max.min(size as usize));
        if data.len() + segment.bytes().len() > most {
            return Err(too_long(*size, self.len_max));
        }
        data.extend_from_slice(segment.bytes());
        *toggle = !*toggle;
        if segment.last {
            check_size(*size, data.len())?;
            dictionary.write(self.object, data).map_err(TransferFailure::Refused)?;
            self.state = ServerState::Idle;
        }
        out.push(ServerFrame::DownloadSegment { toggle: segment.toggle }.encode());
        Ok(())
    }

    /// Takes a client's frame while blocks go out.
    fn blocks_out(&mut self, command: u8, request: ClientFrame, out: &mut Vec<SdoBytes>) -> ServerResult {
        match (&mut self.state, request) {
            (ServerState::BlockOffered { data, block, crc }, ClientFrame::BlockUploadStart) => {
                let (data, crc, mut sender) = (std::mem::take(data), *crc, BlockSender::new(*block)?);
                sender.send(&data, BURST, out);
                self.state = ServerState::BlockSending { data, sender, crc };
            }
            (ServerState::BlockSending { data, sender, crc }, ClientFrame::BlockAck(ack)) => {
                if sender.acknowledged(ack, data)? {
                    let crc = if *crc { block::crc(data) } else { 0 };
                    out.push(ServerFrame::BlockUploadEnd { unused: unused(data.len()), crc }.encode());
                    self.state = ServerState::BlockEnding;
                } else {
                    sender.send(data, BURST, out);
                }
            }
            (ServerState::BlockEnding, ClientFrame::BlockUploadEnd) => self.state = ServerState::Idle,
            _ => return Err(self.unexpected(command)),
        }
        Ok(())
    }

    /// Takes a segment of a block.
    fn block(&mut self, now: Tick, raw: &SdoBytes, out: &mut Vec<SdoBytes>) -> ServerResult {
        let ServerState::BlockReceiving { receiver, .. } = &mut self.state else { return Ok(()) };
        let segment = BlockSegment::decode(raw).ok_or(TransferFailure::Sequence { number: 0 })?;
        let before = receiver.len();
        let ends = receiver.take(&segment)?;
        if ends {
            let ack = receiver.acknowledge().ok_or(TransferFailure::Sequence { number: segment.number })?;
            out.push(ServerFrame::BlockAck(ack).encode());
        }
        // A frame without new data does not prolong the wait: a client that babbles is given up like a silent one.
        if ends || receiver.len() > before {
            self.due = now + self.patience();
        }
        Ok(())
    }

    fn end_blocks(
        &mut self,
        command: u8,
        unused: u8,
        sent: u16,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<SdoBytes>,
    ) -> ServerResult {
        let ServerState::BlockReceiving { receiver, crc, .. } = &mut self.state else {
            return Err(self.unexpected(command));
        };
        let data = receiver.finish(unused, crc.then_some(sent))?;
        dictionary.write(self.object, &data).map_err(TransferFailure::Refused)?;
        self.state = ServerState::Idle;
        out.push(ServerFrame::BlockDownloadEnd.encode());
        Ok(())
    }

    fn unexpected(&mut self, command: u8) -> TransferFailure {
        if matches!(self.state, ServerState::Idle) {
            self.object = ObjectId::new(0, 0);
        }
        TransferFailure::Command { command, done: 0 }
    }

    fn abort(&mut self, cause: &TransferFailure, out: &mut Vec<SdoBytes>) {
        let code = match cause {
            TransferFailure::Refused(code) => Some(*code),
            cause => cause.abort(),
        };
        if let Some(code) = code {
            out.push(ServerFrame::Abort { object: self.object, code }.encode());
        }
        self.state = ServerState::Idle;
    }

    /// Wait from here on before [`SdoServer::poll`] acts.
    fn patience(&self) -> Duration {
        match &self.state {
            ServerState::BlockSending { data, sender, .. } if !sender.waits(data) => PACE,
            ServerState::BlockReceiving { receiver, .. } if !receiver.complete() => STALL,
            _ => TIMEOUT,
        }
    }
}

/// Number of the four bytes that count when a client does not give it: the object's length. Clients that write 22h for
/// every object rely on that with devices of fixed lengths.
fn length_of(object: ObjectId, dictionary: &mut impl Dictionary) -> usize {
    dictionary.read(object).ok().map(|data| data.len()).filter(|len| (1..=4).contains(len)).unwrap_or(4)
}
