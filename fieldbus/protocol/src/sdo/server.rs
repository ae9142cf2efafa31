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

use super::block::{self, BLOCK_MAX, BURST, PACE, Receiver, STALL, Sender, check_size, reserve, too_long, unused};
use super::cause::Cause;
use super::wire::{ABORT, BlockSegment, Content, Raw, Request, Response, Segment};
use super::{Abort, ObjectId};

/// A device's objects, as a [`Server`] reaches them.
pub trait Dictionary {
    /// The bytes of an object, least significant first.
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort>;

    /// Gives an object these bytes. All of them are here; a wrong number is [`Abort::LENGTH`].
    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort>;

    /// Whether an object may be written, before its bytes come; `len` is how many will, where the client says. Need
    /// not be complete, [`Dictionary::write`] has the last word. Saves the transfer of a long object for nothing.
    fn may_write(&mut self, object: ObjectId, len: Option<usize>) -> Result<(), Abort> {
        let _ = (object, len);
        Ok(())
    }
}

#[derive(Debug)]
enum State {
    Idle,
    /// Bytes up to `at` are sent; the segment asked for next has this toggle.
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
    /// Blocks are announced, and begin when the client says so.
    BlockOffered {
        data: Vec<u8>,
        block: u8,
        crc: bool,
    },
    BlockSending {
        data: Vec<u8>,
        sender: Sender,
        crc: bool,
    },
    /// The end frame is out.
    BlockEnding,
    /// `first` is the frame that began it: it may come again.
    BlockReceiving {
        receiver: Receiver,
        crc: bool,
        first: Raw,
    },
}

/// How long a client may be silent within a transfer. Longer than clients wait for an answer: they give up first.
const TIMEOUT: Duration = Duration::from_secs(3);

/// The SDO server of one device.
#[derive(Debug)]
pub struct Server {
    len_max: usize,
    state: State,
    /// The object of the transfer under way.
    object: ObjectId,
    /// When [`Server::poll`] has something to do.
    due: Tick,
}

/// What a frame comes to: nothing to answer here, or a reason to abort.
type Outcome = Result<(), Cause>;

impl Server {
    /// A server that takes objects of up to `len_max` bytes.
    pub fn new(len_max: usize) -> Self {
        Server { len_max, state: State::Idle, object: ObjectId::new(0, 0), due: Tick::NEVER }
    }

    /// Forgets a transfer under way: the device boots, or may not communicate.
    pub fn reset(&mut self) {
        self.state = State::Idle;
    }

    /// Takes a frame from a client.
    pub fn handle(&mut self, now: Tick, raw: &Raw, dictionary: &mut impl Dictionary, out: &mut Vec<Raw>) {
        let outcome = match &self.state {
            State::BlockReceiving { receiver, first, .. } if !receiver.complete() && raw[0] != ABORT => {
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
    pub fn poll(&mut self, now: Tick, out: &mut Vec<Raw>) {
        if now < self.due {
            return;
        }
        let silent = Cause::Silent { waited: TIMEOUT, done: 0, asked: 1 };
        match &mut self.state {
            State::Idle => return,
            State::BlockSending { data, sender, .. } if !sender.waits(data) => sender.send(data, BURST, out),
            // Perhaps only the end of the block was lost.
            State::BlockReceiving { receiver, .. } if !receiver.complete() => match receiver.acknowledge() {
                Some(ack) => out.push(Response::BlockAck(ack).encode()),
                None => return self.abort(&silent, out),
            },
            _ => return self.abort(&silent, out),
        }
        self.due = now + self.patience();
    }

    /// When [`Server::poll`] has something to do next.
    pub fn next_deadline(&self) -> Option<Tick> {
        (!matches!(self.state, State::Idle)).then_some(self.due)
    }

    /// Whether a transfer is under way.
    pub fn is_busy(&self) -> bool {
        !matches!(self.state, State::Idle)
    }

    fn request(&mut self, now: Tick, raw: &Raw, dictionary: &mut impl Dictionary, out: &mut Vec<Raw>) -> Outcome {
        let Some(request) = Request::decode(raw) else { return Err(self.unexpected(raw[0])) };
        match request {
            Request::Upload { object } => self.upload(object, None, dictionary, out)?,
            Request::BlockUpload { object, crc, block, switch_at } => {
                self.upload(object, Some((crc, block, switch_at)), dictionary, out)?;
            }
            Request::Download { object, content } => self.download(object, content, dictionary, out)?,
            Request::BlockDownload { object, crc, size } => {
                self.begin_write(object, size, dictionary)?;
                let receiver = Receiver::new(size, self.len_max);
                self.state = State::BlockReceiving { receiver, crc, first: *raw };
                // A checksum is used if both sides have one, and some clients go by this answer alone.
                out.push(Response::BlockDownload { object, crc, block: BLOCK_MAX }.encode());
            }
            Request::UploadSegment { toggle } => self.send_segment(raw[0], toggle, out)?,
            Request::DownloadSegment(segment) => self.take_segment(raw[0], &segment, dictionary, out)?,
            // No matter which object it names: some clients name none.
            Request::Abort { .. } => self.state = State::Idle,
            Request::BlockUploadStart | Request::BlockAck(_) | Request::BlockUploadEnd => {
                self.blocks_out(raw[0], request, out)?;
            }
            Request::BlockDownloadEnd { unused, crc } => self.end_blocks(raw[0], unused, crc, dictionary, out)?,
        }
        self.due = now + self.patience();
        Ok(())
    }

    /// Begins to send an object; `blocks` is whether checksums are wanted, how large blocks may be, and up to which
    /// length the object goes without any.
    fn upload(
        &mut self,
        object: ObjectId,
        blocks: Option<(bool, u8, u8)>,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<Raw>,
    ) -> Outcome {
        self.begin(object);
        if let Some((_, size, _)) = blocks
            && !(1..=BLOCK_MAX).contains(&size)
        {
            return Err(Cause::BlockSize { size });
        }
        let data = dictionary.read(object).map_err(Cause::Refused)?;
        let size = u32::try_from(data.len()).map_err(|_| Cause::TooLong { len_max: u32::MAX as usize })?;
        let blocks = blocks.filter(|(_, _, switch_at)| data.len() > usize::from(*switch_at) || *switch_at == 0);
        if let Some((crc, block, _)) = blocks {
            self.state = State::BlockOffered { data: data.into_owned(), block, crc };
            out.push(Response::BlockUpload { object, crc, size: Some(size) }.encode());
        } else if let Some(content) = Content::expedited(&data) {
            out.push(Response::Upload { object, content }.encode());
        } else {
            self.state = State::Sending { data: data.into_owned(), at: 0, toggle: false };
            out.push(Response::Upload { object, content: Content::Segmented { size: Some(size) } }.encode());
        }
        Ok(())
    }

    /// Writes an object, or begins to receive it.
    fn download(
        &mut self,
        object: ObjectId,
        content: Content,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<Raw>,
    ) -> Outcome {
        match content {
            Content::Expedited { bytes, len, sized } => {
                self.begin(object);
                let len = if sized { usize::from(len) } else { length_of(object, dictionary) };
                dictionary.write(object, &bytes[..len]).map_err(Cause::Refused)?;
            }
            Content::Segmented { size } => {
                self.begin_write(object, size, dictionary)?;
                self.state = State::Receiving { data: reserve(size, self.len_max), size, toggle: false };
            }
        }
        out.push(Response::Download { object }.encode());
        Ok(())
    }

    /// A transfer begins. One that was under way is over.
    fn begin(&mut self, object: ObjectId) {
        self.state = State::Idle;
        self.object = object;
    }

    fn begin_write(&mut self, object: ObjectId, size: Option<u32>, dictionary: &mut impl Dictionary) -> Outcome {
        self.begin(object);
        let len = size.map(|size| size as usize);
        dictionary.may_write(object, len).map_err(Cause::Refused)?;
        if len.is_some_and(|len| len > self.len_max) {
            return Err(Cause::TooLong { len_max: self.len_max });
        }
        Ok(())
    }

    fn send_segment(&mut self, command: u8, asked: bool, out: &mut Vec<Raw>) -> Outcome {
        let State::Sending { data, at, toggle } = &mut self.state else { return Err(self.unexpected(command)) };
        if asked != *toggle {
            return Err(Cause::Toggle { done: *at });
        }
        let segment = Segment::of(data, *at, *toggle);
        out.push(Response::UploadSegment(segment).encode());
        *at += 7;
        *toggle = !*toggle;
        if segment.last {
            self.state = State::Idle;
        }
        Ok(())
    }

    fn take_segment(
        &mut self,
        command: u8,
        segment: &Segment,
        dictionary: &mut impl Dictionary,
        out: &mut Vec<Raw>,
    ) -> Outcome {
        let State::Receiving { data, size, toggle } = &mut self.state else { return Err(self.unexpected(command)) };
        if segment.toggle != *toggle {
            return Err(Cause::Toggle { done: data.len() });
        }
        let most = size.map_or(self.len_max, |size| self.len_max.min(size as usize));
        if data.len() + segment.bytes().len() > most {
            return Err(too_long(*size, self.len_max));
        }
        data.extend_from_slice(segment.bytes());
        *toggle = !*toggle;
        if segment.last {
            check_size(*size, data.len())?;
            dictionary.write(self.object, data).map_err(Cause::Refused)?;
            self.state = State::Idle;
        }
        out.push(Response::DownloadSegment { toggle: segment.toggle }.encode());
        Ok(())
    }

    /// What a client says while blocks go out.
    fn blocks_out(&mut self, command: u8, request: Request, out: &mut Vec<Raw>) -> Outcome {
        match (&mut self.state, request) {
            (State::BlockOffered { data, block, crc }, Request::BlockUploadStart) => {
                let (data, crc, mut sender) = (std::mem::take(data), *crc, Sender::new(*block)?);
                sender.send(&data, BURST, out);
                self.state = State::BlockSending { data, sender, crc };
            }
            (State::BlockSending { data, sender, crc }, Request::BlockAck(ack)) => {
                if sender.acknowledged(ack, data)? {
                    let crc = if *crc { block::crc(data) } else { 0 };
                    out.push(Response::BlockUploadEnd { unused: unused(data.len()), crc }.encode());
                    self.state = State::BlockEnding;
                } else {
                    sender.send(data, BURST, out);
                }
            }
            (State::BlockEnding, Request::BlockUploadEnd) => self.state = State::Idle,
            _ => return Err(self.unexpected(command)),
        }
        Ok(())
    }

    /// Takes a segment of a block.
    fn block(&mut self, now: Tick, raw: &Raw, out: &mut Vec<Raw>) -> Outcome {
        let State::BlockReceiving { receiver, .. } = &mut self.state else { return Ok(()) };
        let segment = BlockSegment::decode(raw).ok_or(Cause::Sequence { number: 0 })?;
        let before = receiver.len();
        let ends = receiver.take(&segment)?;
        if ends {
            let ack = receiver.acknowledge().ok_or(Cause::Sequence { number: segment.number })?;
            out.push(Response::BlockAck(ack).encode());
        }
        // What brings nothing new buys no time: a client that babbles is given up like a silent one.
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
        out: &mut Vec<Raw>,
    ) -> Outcome {
        let State::BlockReceiving { receiver, crc, .. } = &mut self.state else { return Err(self.unexpected(command)) };
        let data = receiver.finish(unused, crc.then_some(sent))?;
        dictionary.write(self.object, &data).map_err(Cause::Refused)?;
        self.state = State::Idle;
        out.push(Response::BlockDownloadEnd.encode());
        Ok(())
    }

    fn unexpected(&mut self, command: u8) -> Cause {
        if matches!(self.state, State::Idle) {
            self.object = ObjectId::new(0, 0);
        }
        Cause::Command { command, done: 0 }
    }

    fn abort(&mut self, cause: &Cause, out: &mut Vec<Raw>) {
        let code = match cause {
            Cause::Refused(code) => Some(*code),
            cause => cause.abort(),
        };
        if let Some(code) = code {
            out.push(Response::Abort { object: self.object, code }.encode());
        }
        self.state = State::Idle;
    }

    /// How long to wait from here on before [`Server::poll`] acts.
    fn patience(&self) -> Duration {
        match &self.state {
            State::BlockSending { data, sender, .. } if !sender.waits(data) => PACE,
            State::BlockReceiving { receiver, .. } if !receiver.complete() => STALL,
            _ => TIMEOUT,
        }
    }
}

/// How many of the four bytes count when a client does not say: as many as the object has. Who writes 22h for every
/// object has always been right with devices of fixed lengths.
fn length_of(object: ObjectId, dictionary: &mut impl Dictionary) -> usize {
    dictionary.read(object).ok().map(|data| data.len()).filter(|len| (1..=4).contains(len)).unwrap_or(4)
}
