//! The client: one transfer of one object.
//!
//! ```text
//!            ┌──▶ (expedited) ───────────────────────────────────────▶ done
//!  Asking ───┼──▶ Sending / Receiving, segment by segment ───────────▶ done
//!    ▲       ├──▶ BlockSending ──▶ BlockEnding ──────────────────────▶ done
//!    │       └──▶ BlockReceiving (until the end frame) ──────────────▶ done
//!    └── asked for blocks and the server has none, or a long object was announced: asked again in the other way
//! ```
//!
//! Only the first frame is repeated when nothing comes: a repeated segment could be taken for the next one. Answers
//! for other objects are ignored while asking, because tools may share the channel; later they mean that the server
//! has dropped this transfer. A server without checksum is not asked for blocks: out of step by one acknowledgement, a
//! block transfer can lose bytes unnoticed, a segmented one cannot.

use std::time::Duration;

use linewright_line::Tick;

use super::block::{self, BURST, PACE, Receiver, STALL, Sender, check_size, reserve, too_long, unused};
use super::cause::{Cause, TransferError};
use super::wire::{ABORT, BlockSegment, Content, Raw, Request, Response, Segment};
use super::{Abort, ObjectId};

/// Which kind of transfer is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Blocks where they pay, else segments. To read, the device is asked how long the object is, and asked again for
    /// blocks if that is long.
    #[default]
    Auto,
    /// Never blocks: for devices that misbehave when they are asked for them.
    Segmented,
    /// Blocks whatever the length is, unless the device refuses.
    Block,
}

/// How a transfer is carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How long an answer may take. Some devices write to flash before they answer.
    pub timeout: Duration,
    /// How often the first frame is repeated when no answer comes.
    pub retries: u8,
    /// Which kind of transfer.
    pub mode: Mode,
    /// Objects longer than this go in blocks, in [`Mode::Auto`].
    pub block_above: usize,
    /// Segments of a block sent each millisecond. Too many overflow the interface's transmit queue. With 0 none is sent
    /// but by [`Client::stream`]: whoever has several transfers on one bus sees to all of them.
    pub burst: u8,
    /// Bytes read at most.
    pub len_max: usize,
}

impl Default for Options {
    /// One second, two repetitions, blocks above 64 bytes, four segments each millisecond, one MiB.
    fn default() -> Self {
        Options {
            timeout: Duration::from_secs(1),
            retries: 2,
            mode: Mode::Auto,
            block_above: 64,
            burst: BURST,
            len_max: 1 << 20,
        }
    }
}

/// How far a transfer is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Under way. Also what an ended transfer says to whatever comes after its end.
    Busy,
    /// Ended, and this is said once: the bytes read, none after a write; or why not.
    Done(Result<Vec<u8>, TransferError>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Upload,
    Download,
}

#[derive(Debug)]
enum State {
    /// Not started.
    Fresh,
    /// The first frame is out; `blocks` says for what kind it asked.
    Asking { frame: Raw, asked: u8, blocks: bool },
    /// The segment up to `at` is out.
    Sending { at: usize, toggle: bool },
    /// The segment with this toggle is asked for.
    Receiving { size: Option<u32>, toggle: bool },
    /// Blocks go out.
    BlockSending(Sender),
    /// All blocks are out, and the end frame too.
    BlockEnding,
    /// Blocks come in.
    BlockReceiving(Receiver),
    /// Ended.
    Over,
}

/// What a frame does to the transfer.
enum Step {
    Ignored,
    On,
    End,
}

/// One transfer of one object, from or to one device.
#[derive(Debug)]
pub struct Client {
    object: ObjectId,
    direction: Direction,
    options: Options,
    /// What is written, or what has been read so far.
    data: Vec<u8>,
    state: State,
    /// When [`Client::poll`] has something to do.
    due: Tick,
    /// The first frame was repeated: its answer may come twice.
    repeated: bool,
    /// The server has no blocks, or none with a checksum.
    no_blocks: bool,
}

impl Client {
    /// Reads an object. Nothing is sent before [`Client::start`].
    pub fn upload(object: ObjectId, options: Options) -> Self {
        Client::new(object, Direction::Upload, Vec::new(), options)
    }

    /// Writes an object. Nothing is sent before [`Client::start`].
    pub fn download(object: ObjectId, data: impl Into<Vec<u8>>, options: Options) -> Self {
        Client::new(object, Direction::Download, data.into(), options)
    }

    fn new(object: ObjectId, direction: Direction, data: Vec<u8>, options: Options) -> Self {
        Client {
            object,
            direction,
            options,
            data,
            state: State::Fresh,
            due: Tick::NEVER,
            repeated: false,
            no_blocks: false,
        }
    }

    /// The object.
    pub fn object(&self) -> ObjectId {
        self.object
    }

    /// Sends the first frame. A transfer is started once; starting it again does nothing.
    pub fn start(&mut self, now: Tick, out: &mut Vec<Raw>) {
        if matches!(self.state, State::Fresh) {
            let blocks = match (self.options.mode, self.direction) {
                (Mode::Segmented, _) | (Mode::Auto, Direction::Upload) => false,
                (Mode::Auto, Direction::Download) => self.data.len() > self.options.block_above,
                (Mode::Block, _) => true,
            };
            self.ask(now, blocks, out);
        }
    }

    /// Takes a frame from the server.
    pub fn handle(&mut self, now: Tick, raw: &Raw, out: &mut Vec<Raw>) -> Progress {
        let step = match &self.state {
            State::Fresh | State::Over => Ok(Step::Ignored),
            State::BlockReceiving(receiver) if !receiver.complete() && raw[0] != ABORT => self.block(raw, out),
            _ => match Response::decode(raw) {
                Some(response) => self.response(now, response, raw[0], out),
                None => self.unexpected(raw[0], None),
            },
        };
        match step {
            Ok(Step::Ignored) => Progress::Busy,
            Ok(Step::On) => {
                self.due = now + self.patience();
                Progress::Busy
            }
            Ok(Step::End) => self.end(Ok(())),
            Err(cause) => self.fail(cause, out),
        }
    }

    /// Does what is due: repeating the first frame, sending more of a block, giving up.
    pub fn poll(&mut self, now: Tick, out: &mut Vec<Raw>) -> Progress {
        if now < self.due {
            return Progress::Busy;
        }
        let done = self.done();
        let waited = self.options.timeout;
        let silent = Cause::Silent { waited, done, asked: 1 };
        match &mut self.state {
            State::Fresh | State::Over => return Progress::Busy,
            State::Asking { asked, .. } if *asked > self.options.retries => {
                let asked = *asked;
                return self.fail(Cause::Silent { waited, done, asked }, out);
            }
            State::Asking { frame, asked, .. } => {
                *asked += 1;
                self.repeated = true;
                out.push(*frame);
            }
            State::BlockSending(sender) if !sender.waits(&self.data) => {
                sender.send(&self.data, self.options.burst, out);
            }
            // Perhaps only the end of the block was lost.
            State::BlockReceiving(receiver) if !receiver.complete() => match receiver.acknowledge() {
                Some(ack) => out.push(Request::BlockAck(ack).encode()),
                None => return self.fail(silent, out),
            },
            State::Sending { .. }
            | State::Receiving { .. }
            | State::BlockSending(_)
            | State::BlockReceiving(_)
            | State::BlockEnding => return self.fail(silent, out),
        }
        self.due = now + self.patience();
        Progress::Busy
    }

    /// Whether it has segments of a block to send.
    pub fn streams(&self) -> bool {
        matches!(&self.state, State::BlockSending(sender) if !sender.waits(&self.data))
    }

    /// Sends up to `count` of them now.
    pub fn stream(&mut self, now: Tick, count: u8, out: &mut Vec<Raw>) {
        if let State::BlockSending(sender) = &mut self.state {
            sender.send(&self.data, count, out);
            self.due = now + self.patience();
        }
    }

    /// When [`Client::poll`] has something to do next; `None` before the start and after the end.
    pub fn next_deadline(&self) -> Option<Tick> {
        (!matches!(self.state, State::Fresh | State::Over)).then_some(self.due)
    }

    /// Gives the transfer up, and tells the server.
    pub fn cancel(&mut self, out: &mut Vec<Raw>) -> Progress {
        match self.state {
            State::Fresh => self.end(Err(Cause::Cancelled)),
            State::Over => Progress::Busy,
            _ => self.fail(Cause::Cancelled, out),
        }
    }

    /// How many bytes have been transferred for certain.
    pub fn done(&self) -> usize {
        match &self.state {
            State::Fresh | State::Asking { .. } => 0,
            State::Sending { at, .. } => at.saturating_sub(7),
            State::BlockSending(sender) => sender.acked(),
            State::BlockReceiving(receiver) => receiver.len(),
            State::Receiving { .. } | State::BlockEnding | State::Over => self.data.len(),
        }
    }

    /// Sends the first frame of a transfer of that kind.
    fn ask(&mut self, now: Tick, blocks: bool, out: &mut Vec<Raw>) {
        let object = self.object;
        let len = self.data.len() as u32;
        let request = match (self.direction, blocks) {
            (Direction::Upload, false) => Request::Upload { object },
            (Direction::Upload, true) => {
                Request::BlockUpload { object, crc: true, block: block::BLOCK_MAX, switch_at: 0 }
            }
            (Direction::Download, false) => {
                let segmented = Content::Segmented { size: Some(len) };
                Request::Download { object, content: Content::expedited(&self.data).unwrap_or(segmented) }
            }
            (Direction::Download, true) => Request::BlockDownload { object, crc: true, size: Some(len) },
        };
        let frame = request.encode();
        out.push(frame);
        self.state = State::Asking { frame, asked: 1, blocks };
        self.due = now + self.options.timeout;
    }

    fn response(&mut self, now: Tick, response: Response, command: u8, out: &mut Vec<Raw>) -> Result<Step, Cause> {
        match (&mut self.state, response) {
            (State::Asking { blocks, .. }, response) => {
                let blocks = *blocks;
                if response.object() == Some(self.object) {
                    self.answered(now, blocks, response, out)
                } else {
                    Ok(Step::Ignored)
                }
            }
            // Within a transfer there is but one that could be meant.
            (_, Response::Abort { code, .. }) => Err(Cause::Refused(code)),
            (State::Sending { at, toggle }, Response::DownloadSegment { toggle: answer }) => {
                if answer != *toggle {
                    return Err(Cause::Toggle { done: at.saturating_sub(7) });
                }
                if *at >= self.data.len() {
                    return Ok(Step::End);
                }
                *toggle = !*toggle;
                out.push(Request::DownloadSegment(Segment::of(&self.data, *at, *toggle)).encode());
                *at += 7;
                Ok(Step::On)
            }
            (State::Receiving { .. }, Response::UploadSegment(segment)) => self.segment(segment, out),
            (State::BlockSending(sender), Response::BlockAck(ack)) => {
                if sender.acknowledged(ack, &self.data)? {
                    let (unused, crc) = (unused(self.data.len()), block::crc(&self.data));
                    out.push(Request::BlockDownloadEnd { unused, crc }.encode());
                    self.state = State::BlockEnding;
                } else {
                    sender.send(&self.data, self.options.burst, out);
                }
                Ok(Step::On)
            }
            (State::BlockEnding, Response::BlockDownloadEnd) => Ok(Step::End),
            (State::BlockReceiving(receiver), Response::BlockUploadEnd { unused, crc }) => {
                self.data = receiver.finish(unused, Some(crc))?;
                out.push(Request::BlockUploadEnd.encode());
                Ok(Step::End)
            }
            (_, response) => self.unexpected(command, response.object()),
        }
    }

    /// The server has answered the first frame, for this object.
    fn answered(&mut self, now: Tick, blocks: bool, response: Response, out: &mut Vec<Raw>) -> Result<Step, Cause> {
        match (self.direction, response) {
            (_, Response::Abort { code: Abort::COMMAND, .. }) if blocks => {
                self.no_blocks = true;
                self.ask(now, false, out);
                Ok(Step::On)
            }
            (_, Response::Abort { code, .. }) => Err(Cause::Refused(code)),
            (Direction::Upload, Response::Upload { content: Content::Expedited { bytes, len, .. }, .. }) => {
                self.data.extend_from_slice(&bytes[..usize::from(len)]);
                Ok(Step::End)
            }
            (Direction::Upload, Response::Upload { content: Content::Segmented { size }, .. }) => {
                self.announced(size)?;
                let long = size.is_some_and(|size| size as usize > self.options.block_above);
                // Not if the first frame was repeated: a second answer to it would be taken for that to the next.
                if long && !blocks && self.options.mode == Mode::Auto && !self.no_blocks && !self.repeated {
                    self.change(now, true, out);
                    return Ok(Step::On);
                }
                self.data = reserve(size, self.options.len_max);
                self.state = State::Receiving { size, toggle: false };
                out.push(Request::UploadSegment { toggle: false }.encode());
                Ok(Step::On)
            }
            (Direction::Upload, Response::BlockUpload { crc: true, size, .. }) if blocks => {
                self.announced(size)?;
                self.state = State::BlockReceiving(Receiver::new(size, self.options.len_max));
                out.push(Request::BlockUploadStart.encode());
                Ok(Step::On)
            }
            (Direction::Download, Response::Download { .. }) if !blocks => {
                if (1..=4).contains(&self.data.len()) {
                    return Ok(Step::End);
                }
                out.push(Request::DownloadSegment(Segment::of(&self.data, 0, false)).encode());
                self.state = State::Sending { at: 7, toggle: false };
                Ok(Step::On)
            }
            (Direction::Download, Response::BlockDownload { crc: true, block, .. }) if blocks => {
                let mut sender = Sender::new(block)?;
                sender.send(&self.data, self.options.burst, out);
                self.state = State::BlockSending(sender);
                Ok(Step::On)
            }
            (Direction::Upload, Response::BlockUpload { crc: false, .. })
            | (Direction::Download, Response::BlockDownload { crc: false, .. })
                if blocks =>
            {
                self.change(now, false, out);
                Ok(Step::On)
            }
            // The answer to another client's question about the same object, or to one that was given up.
            _ => Ok(Step::Ignored),
        }
    }

    /// Tells the server that the transfer is over, and asks again for the other kind.
    fn change(&mut self, now: Tick, blocks: bool, out: &mut Vec<Raw>) {
        let code = if blocks { Abort::GENERAL } else { Abort::CRC };
        out.push(Request::Abort { object: self.object, code }.encode());
        self.no_blocks |= !blocks;
        self.ask(now, blocks, out);
    }

    /// Takes a segment of a segmented upload.
    fn segment(&mut self, segment: Segment, out: &mut Vec<Raw>) -> Result<Step, Cause> {
        let State::Receiving { size, toggle } = &mut self.state else { return Ok(Step::Ignored) };
        let (len_max, done) = (self.options.len_max, self.data.len());
        if segment.toggle != *toggle {
            return Err(Cause::Toggle { done });
        }
        let most = size.map_or(len_max, |size| len_max.min(size as usize));
        if done + segment.bytes().len() > most {
            return Err(too_long(*size, len_max));
        }
        self.data.extend_from_slice(segment.bytes());
        if segment.last {
            check_size(*size, self.data.len())?;
            return Ok(Step::End);
        }
        // A transfer of empty segments would never end.
        if segment.bytes().is_empty() {
            return Err(Cause::Toggle { done });
        }
        *toggle = !*toggle;
        out.push(Request::UploadSegment { toggle: *toggle }.encode());
        Ok(Step::On)
    }

    /// Takes a segment of a block.
    fn block(&mut self, raw: &Raw, out: &mut Vec<Raw>) -> Result<Step, Cause> {
        let State::BlockReceiving(receiver) = &mut self.state else { return Ok(Step::Ignored) };
        let segment = BlockSegment::decode(raw).ok_or(Cause::Sequence { number: 0 })?;
        let before = receiver.len();
        let ends = receiver.take(&segment)?;
        if ends {
            let ack = receiver.acknowledge().ok_or(Cause::Sequence { number: segment.number })?;
            out.push(Request::BlockAck(ack).encode());
        }
        // What brings nothing new buys no time: a server that babbles is given up like a silent one.
        Ok(if ends || receiver.len() > before { Step::On } else { Step::Ignored })
    }

    /// Whether an object announced with this size is taken.
    fn announced(&self, size: Option<u32>) -> Result<(), Cause> {
        let len_max = self.options.len_max;
        if size.is_some_and(|size| size as usize > len_max) { Err(Cause::TooLong { len_max }) } else { Ok(()) }
    }

    /// A frame that does not belong where the transfer is.
    fn unexpected(&self, command: u8, object: Option<ObjectId>) -> Result<Step, Cause> {
        match (&self.state, object) {
            (State::Asking { .. }, _) => Ok(Step::Ignored),
            (_, Some(by)) if by != self.object => Err(Cause::Interrupted { by }),
            // The answer to the first frame once more, before anything else was answered.
            (_, Some(_)) if self.repeated && self.done() == 0 => Ok(Step::Ignored),
            _ => Err(Cause::Command { command, done: self.done() }),
        }
    }

    /// How long to wait from here on before [`Client::poll`] acts.
    fn patience(&self) -> Duration {
        match &self.state {
            State::BlockSending(sender) if self.options.burst > 0 && !sender.waits(&self.data) => PACE,
            State::BlockReceiving(receiver) if !receiver.complete() => STALL.min(self.options.timeout / 2),
            _ => self.options.timeout,
        }
    }

    fn fail(&mut self, cause: Cause, out: &mut Vec<Raw>) -> Progress {
        if let Some(code) = cause.abort() {
            out.push(Request::Abort { object: self.object, code }.encode());
        }
        self.end(Err(cause))
    }

    fn end(&mut self, result: Result<(), Cause>) -> Progress {
        self.state = State::Over;
        let data = std::mem::take(&mut self.data);
        let object = self.object;
        Progress::Done(match (result, self.direction) {
            (Ok(()), Direction::Upload) => Ok(data),
            (Ok(()), Direction::Download) => Ok(Vec::new()),
            (Err(cause), _) => Err(TransferError { object, cause }),
        })
    }
}
