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
//! Only the first frame is repeated when nothing comes: a repeated segment could be taken for the next one. Answers for
//! other objects are ignored in `Asking`, because tools may share the channel; later they mean that the server has
//! dropped this transfer. Blocks are not used with a server without checksum: out of step by one acknowledgement, a
//! block transfer can lose bytes unnoticed, a segmented one cannot.

use std::time::Duration;

use linewright_line::Tick;

use super::block::{self, BURST, BlockReceiver, BlockSender, PACE, STALL, check_size, reserve, too_long, unused};
use super::cause::{TransferError, TransferFailure};
use super::wire::{ABORT, BlockSegment, ClientFrame, InitiateContent, SdoBytes, Segment, ServerFrame};
use super::{Abort, ObjectId};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransferMode {
    /// Blocks where they pay, else segments. To read, the length is requested first, and if it is long, the object
    /// again in blocks.
    #[default]
    Auto,
    /// Never blocks: for devices that misbehave when blocks are requested.
    Segmented,
    /// Blocks whatever the length is, unless the device refuses.
    Block,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransferOptions {
    /// Most time for an answer. Some devices write to flash before they answer.
    pub timeout: Duration,
    /// Number of repetitions of the first frame when no answer comes.
    pub retries: u8,
    pub mode: TransferMode,
    /// Objects longer than this go in blocks, in [`TransferMode::Auto`].
    pub block_above: usize,
    /// Segments of a block sent each millisecond. Too many overflow the interface's transmit queue. With 0 none is sent
    /// but by [`SdoClient::stream`]: the caller with several transfers on one bus takes turns.
    pub burst: u8,
    /// Bytes read at most.
    pub len_max: usize,
}

impl Default for TransferOptions {
    /// One second, two repetitions, blocks above 64 bytes, four segments each millisecond, one MiB.
    fn default() -> Self {
        TransferOptions {
            timeout: Duration::from_secs(1),
            retries: 2,
            mode: TransferMode::Auto,
            block_above: 64,
            burst: BURST,
            len_max: 1 << 20,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TransferProgress {
    /// Under way. Also the result of every call after the end.
    Busy,
    /// Ended, returned once: the bytes read, none after a write; or why not.
    Done(Result<Vec<u8>, TransferError>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TransferDirection {
    Upload,
    Download,
}

#[derive(Debug)]
enum ClientState {
    Fresh,
    /// The first frame is out; `blocks`: it requested blocks.
    Asking {
        frame: SdoBytes,
        asked: u8,
        blocks: bool,
    },
    /// The segment up to `at` is out.
    Sending {
        at: usize,
        toggle: bool,
    },
    /// The segment with this toggle is requested.
    Receiving {
        size: Option<u32>,
        toggle: bool,
    },
    /// Blocks go out.
    BlockSending(BlockSender),
    /// All blocks are out, and the end frame too.
    BlockEnding,
    /// Blocks come in.
    BlockReceiving(BlockReceiver),
    Over,
}

/// Effect of a frame on the transfer.
enum TransferStep {
    Ignored,
    On,
    End,
}

/// One transfer of one object, from or to one device.
#[derive(Debug)]
pub struct SdoClient {
    object: ObjectId,
    direction: TransferDirection,
    options: TransferOptions,
    /// Bytes to write, or bytes read so far.
    data: Vec<u8>,
    state: ClientState,
    due: Tick,
    /// The first frame was repeated: its answer may come twice.
    repeated: bool,
    /// The server has no blocks, or none with a checksum.
    no_blocks: bool,
}

impl SdoClient {
    pub fn upload(object: ObjectId, options: TransferOptions) -> Self {
        SdoClient::new(object, TransferDirection::Upload, Vec::new(), options)
    }

    pub fn download(object: ObjectId, data: impl Into<Vec<u8>>, options: TransferOptions) -> Self {
        SdoClient::new(object, TransferDirection::Download, data.into(), options)
    }

    fn new(object: ObjectId, direction: TransferDirection, data: Vec<u8>, options: TransferOptions) -> Self {
        SdoClient {
            object,
            direction,
            options,
            data,
            state: ClientState::Fresh,
            due: Tick::NEVER,
            repeated: false,
            no_blocks: false,
        }
    }

    pub fn object(&self) -> ObjectId {
        self.object
    }

    /// Sends the first frame. A transfer is started once; starting it again does nothing.
    pub fn start(&mut self, now: Tick, out: &mut Vec<SdoBytes>) {
        if matches!(self.state, ClientState::Fresh) {
            let blocks = match (self.options.mode, self.direction) {
                (TransferMode::Segmented, _) | (TransferMode::Auto, TransferDirection::Upload) => false,
                (TransferMode::Auto, TransferDirection::Download) => self.data.len() > self.options.block_above,
                (TransferMode::Block, _) => true,
            };
            self.ask(now, blocks, out);
        }
    }

    pub fn handle(&mut self, now: Tick, raw: &SdoBytes, out: &mut Vec<SdoBytes>) -> TransferProgress {
        let step = match &self.state {
            ClientState::Fresh | ClientState::Over => Ok(TransferStep::Ignored),
            ClientState::BlockReceiving(receiver) if !receiver.complete() && raw[0] != ABORT => self.block(raw, out),
            _ => match ServerFrame::decode(raw) {
                Some(response) => self.response(now, response, raw[0], out),
                None => self.unexpected(raw[0], None),
            },
        };
        match step {
            Ok(TransferStep::Ignored) => TransferProgress::Busy,
            Ok(TransferStep::On) => {
                self.due = now + self.patience();
                TransferProgress::Busy
            }
            Ok(TransferStep::End) => self.end(Ok(())),
            Err(cause) => self.fail(cause, out),
        }
    }

    /// Does what is due: repeating the first frame, sending more of a block, giving up.
    pub fn poll(&mut self, now: Tick, out: &mut Vec<SdoBytes>) -> TransferProgress {
        if now < self.due {
            return TransferProgress::Busy;
        }
        let done = self.done();
        let waited = self.options.timeout;
        let silent = TransferFailure::Silent { waited, done, asked: 1 };
        match &mut self.state {
            ClientState::Fresh | ClientState::Over => return TransferProgress::Busy,
            ClientState::Asking { asked, .. } if *asked > self.options.retries => {
                let asked = *asked;
                return self.fail(TransferFailure::Silent { waited, done, asked }, out);
            }
            ClientState::Asking { frame, asked, .. } => {
                *asked += 1;
                self.repeated = true;
                out.push(*frame);
            }
            ClientState::BlockSending(sender) if !sender.waits(&self.data) => {
                sender.send(&self.data, self.options.burst, out);
            }
            // Perhaps only the end of the block was lost.
            ClientState::BlockReceiving(receiver) if !receiver.complete() => match receiver.acknowledge() {
                Some(ack) => out.push(ClientFrame::BlockAck(ack).encode()),
                None => return self.fail(silent, out),
            },
            ClientState::Sending { .. }
            | ClientState::Receiving { .. }
            | ClientState::BlockSending(_)
            | ClientState::BlockReceiving(_)
            | ClientState::BlockEnding => return self.fail(silent, out),
        }
        self.due = now + self.patience();
        TransferProgress::Busy
    }

    /// Whether it has segments of a block to send.
    pub fn streams(&self) -> bool {
        matches!(&self.state, ClientState::BlockSending(sender) if !sender.waits(&self.data))
    }

    /// Sends up to `count` of them now.
    pub fn stream(&mut self, now: Tick, count: u8, out: &mut Vec<SdoBytes>) {
        if let ClientState::BlockSending(sender) = &mut self.state {
            sender.send(&self.data, count, out);
            self.due = now + self.patience();
        }
    }

    /// When [`SdoClient::poll`] has something to do next; `None` before the start and after the end.
    pub fn next_deadline(&self) -> Option<Tick> {
        (!matches!(self.state, ClientState::Fresh | ClientState::Over)).then_some(self.due)
    }

    /// Gives the transfer up, with an abort to the server.
    pub fn cancel(&mut self, out: &mut Vec<SdoBytes>) -> TransferProgress {
        match self.state {
            ClientState::Fresh => self.end(Err(TransferFailure::Cancelled)),
            ClientState::Over => TransferProgress::Busy,
            _ => self.fail(TransferFailure::Cancelled, out),
        }
    }

    /// Bytes certainly transferred.
    pub fn done(&self) -> usize {
        match &self.state {
            ClientState::Fresh | ClientState::Asking { .. } => 0,
            ClientState::Sending { at, .. } => at.saturating_sub(7),
            ClientState::BlockSending(sender) => sender.acked(),
            ClientState::BlockReceiving(receiver) => receiver.len(),
            ClientState::Receiving { .. } | ClientState::BlockEnding | ClientState::Over => self.data.len(),
        }
    }

    /// Sends the first frame of a transfer of that kind.
    fn ask(&mut self, now: Tick, blocks: bool, out: &mut Vec<SdoBytes>) {
        let object = self.object;
        let len = self.data.len() as u32;
        let request = match (self.direction, blocks) {
            (TransferDirection::Upload, false) => ClientFrame::Upload { object },
            (TransferDirection::Upload, true) => {
                ClientFrame::BlockUpload { object, crc: true, block: block::BLOCK_MAX, switch_at: 0 }
            }
            (TransferDirection::Download, false) => {
                let segmented = InitiateContent::Segmented { size: Some(len) };
                ClientFrame::Download { object, content: InitiateContent::expedited(&self.data).unwrap_or(segmented) }
            }
            (TransferDirection::Download, true) => ClientFrame::BlockDownload { object, crc: true, size: Some(len) },
        };
        let frame = request.encode();
        out.push(frame);
        self.state = ClientState::Asking { frame, asked: 1, blocks };
        self.due = now + self.options.timeout;
    }

    fn response(
        &mut self,
        now: Tick,
        response: ServerFrame,
        command: u8,
        out: &mut Vec<SdoBytes>,
    ) -> Result<TransferStep, TransferFailure> {
        match (&mut self.state, response) {
            (ClientState::Asking { blocks, .. }, response) => {
                let blocks = *blocks;
                if response.object() == Some(self.object) {
                    self.answered(now, blocks, response, out)
                } else {
                    Ok(TransferStep::Ignored)
                }
            }
            // Within a transfer there is but one that could be meant.
            (_, ServerFrame::Abort { code, .. }) => Err(TransferFailure::Refused(code)),
            (ClientState::Sending { at, toggle }, ServerFrame::DownloadSegment { toggle: answer }) => {
                if answer != *toggle {
                    return Err(TransferFailure::Toggle { done: at.saturating_sub(7) });
                }
                if *at >= self.data.len() {
                    return Ok(TransferStep::End);
                }
                *toggle = !*toggle;
                out.push(ClientFrame::DownloadSegment(Segment::of(&self.data, *at, *toggle)).encode());
                *at += 7;
                Ok(TransferStep::On)
            }
            (ClientState::Receiving { .. }, ServerFrame::UploadSegment(segment)) => self.segment(segment, out),
            (ClientState::BlockSending(sender), ServerFrame::BlockAck(ack)) => {
                if sender.acknowledged(ack, &self.data)? {
                    let (unused, crc) = (unused(self.data.len()), block::crc(&self.data));
                    out.push(ClientFrame::BlockDownloadEnd { unused, crc }.encode());
                    self.state = ClientState::BlockEnding;
                } else {
                    sender.send(&self.data, self.options.burst, out);
                }
                Ok(TransferStep::On)
            }
            (ClientState::BlockEnding, ServerFrame::BlockDownloadEnd) => Ok(TransferStep::End),
            (ClientState::BlockReceiving(receiver), ServerFrame::BlockUploadEnd { unused, crc }) => {
                self.data = receiver.finish(unused, Some(crc))?;
                out.push(ClientFrame::BlockUploadEnd.encode());
                Ok(TransferStep::End)
            }
            (_, response) => self.unexpected(command, response.object()),
        }
    }

    /// The server has answered the first frame, for this object.
    fn answered(
        &mut self,
        now: Tick,
        blocks: bool,
        response: ServerFrame,
        out: &mut Vec<SdoBytes>,
    ) -> Result<TransferStep, TransferFailure> {
        match (self.direction, response) {
            (_, ServerFrame::Abort { code: Abort::COMMAND, .. }) if blocks => {
                self.no_blocks = true;
                self.ask(now, false, out);
                Ok(TransferStep::On)
            }
            (_, ServerFrame::Abort { code, .. }) => Err(TransferFailure::Refused(code)),
            (
                TransferDirection::Upload,
                ServerFrame::Upload { content: InitiateContent::Expedited { bytes, len, .. }, .. },
            ) => {
                self.data.extend_from_slice(&bytes[..usize::from(len)]);
                Ok(TransferStep::End)
            }
            (TransferDirection::Upload, ServerFrame::Upload { content: InitiateContent::Segmented { size }, .. }) => {
                self.announced(size)?;
                let long = size.is_some_and(|size| size as usize > self.options.block_above);
                // Not if the first frame was repeated: a second answer to it would be taken for that to the next.
                if long && !blocks && self.options.mode == TransferMode::Auto && !self.no_blocks && !self.repeated {
                    self.change(now, true, out);
                    return Ok(TransferStep::On);
                }
                self.data = reserve(size, self.options.len_max);
                self.state = ClientState::Receiving { size, toggle: false };
                out.push(ClientFrame::UploadSegment { toggle: false }.encode());
                Ok(TransferStep::On)
            }
            (TransferDirection::Upload, ServerFrame::BlockUpload { crc: true, size, .. }) if blocks => {
                self.announced(size)?;
                self.state = ClientState::BlockReceiving(BlockReceiver::new(size, self.options.len_max));
                out.push(ClientFrame::BlockUploadStart.encode());
                Ok(TransferStep::On)
            }
            (TransferDirection::Download, ServerFrame::Download { .. }) if !blocks => {
                if (1..=4).contains(&self.data.len()) {
                    return Ok(TransferStep::End);
                }
                out.push(ClientFrame::DownloadSegment(Segment::of(&self.data, 0, false)).encode());
                self.state = ClientState::Sending { at: 7, toggle: false };
                Ok(TransferStep::On)
            }
            (TransferDirection::Download, ServerFrame::BlockDownload { crc: true, block, .. }) if blocks => {
                let mut sender = BlockSender::new(block)?;
                sender.send(&self.data, self.options.burst, out);
                self.state = ClientState::BlockSending(sender);
                Ok(TransferStep::On)
            }
            (TransferDirection::Upload, ServerFrame::BlockUpload { crc: false, .. })
            | (TransferDirection::Download, ServerFrame::BlockDownload { crc: false, .. })
                if blocks =>
            {
                self.change(now, false, out);
                Ok(TransferStep::On)
            }
            // The answer to another client's question about the same object, or to one that was given up.
            _ => Ok(TransferStep::Ignored),
        }
    }

    /// Aborts the transfer at the server, and requests the other kind.
    fn change(&mut self, now: Tick, blocks: bool, out: &mut Vec<SdoBytes>) {
        let code = if blocks { Abort::GENERAL } else { Abort::CRC };
        out.push(ClientFrame::Abort { object: self.object, code }.encode());
        self.no_blocks |= !blocks;
        self.ask(now, blocks, out);
    }

    /// Takes a segment of a segmented upload.
    fn segment(&mut self, segment: Segment, out: &mut Vec<SdoBytes>) -> Result<TransferStep, TransferFailure> {
        let ClientState::Receiving { size, toggle } = &mut self.state else { return Ok(TransferStep::Ignored) };
        let (len_max, done) = (self.options.len_max, self.data.len());
        if segment.toggle != *toggle {
            return Err(TransferFailure::Toggle { done });
        }
        let most = size.map_or(len_max, |size| len_max.min(size as usize));
        if done + segment.bytes().len() > most {
            return Err(too_long(*size, len_max));
        }
        self.data.extend_from_slice(segment.bytes());
        if segment.last {
            check_size(*size, self.data.len())?;
            return Ok(TransferStep::End);
        }
        // A transfer of empty segments would never end.
        if segment.bytes().is_empty() {
            return Err(TransferFailure::Toggle { done });
        }
        *toggle = !*toggle;
        out.push(ClientFrame::UploadSegment { toggle: *toggle }.encode());
        Ok(TransferStep::On)
    }

    /// Takes a segment of a block.
    fn block(&mut self, raw: &SdoBytes, out: &mut Vec<SdoBytes>) -> Result<TransferStep, TransferFailure> {
        let ClientState::BlockReceiving(receiver) = &mut self.state else { return Ok(TransferStep::Ignored) };
        let segment = BlockSegment::decode(raw).ok_or(TransferFailure::Sequence { number: 0 })?;
        let before = receiver.len();
        let ends = receiver.take(&segment)?;
        if ends {
            let ack = receiver.acknowledge().ok_or(TransferFailure::Sequence { number: segment.number })?;
            out.push(ClientFrame::BlockAck(ack).encode());
        }
        // A frame without new data does not prolong the wait: a server that babbles is given up like a silent one.
        Ok(if ends || receiver.len() > before { TransferStep::On } else { TransferStep::Ignored })
    }

    /// Checks the announced size against the limit.
    fn announced(&self, size: Option<u32>) -> Result<(), TransferFailure> {
        let len_max = self.options.len_max;
        if size.is_some_and(|size| size as usize > len_max) {
            Err(TransferFailure::TooLong { len_max })
        } else {
            Ok(())
        }
    }

    /// A frame that does not belong where the transfer is.
    fn unexpected(&self, command: u8, object: Option<ObjectId>) -> Result<TransferStep, TransferFailure> {
        match (&self.state, object) {
            (ClientState::Asking { .. }, _) => Ok(TransferStep::Ignored),
            (_, Some(by)) if by != self.object => Err(TransferFailure::Interrupted { by }),
            // The answer to the first frame once more, before anything else was answered.
            (_, Some(_)) if self.repeated && self.done() == 0 => Ok(TransferStep::Ignored),
            _ => Err(TransferFailure::Command { command, done: self.done() }),
        }
    }

    /// Wait from here on before [`SdoClient::poll`] acts.
    fn patience(&self) -> Duration {
        match &self.state {
            ClientState::BlockSending(sender) if self.options.burst > 0 && !sender.waits(&self.data) => PACE,
            ClientState::BlockReceiving(receiver) if !receiver.complete() => STALL.min(self.options.timeout / 2),
            _ => self.options.timeout,
        }
    }

    fn fail(&mut self, cause: TransferFailure, out: &mut Vec<SdoBytes>) -> TransferProgress {
        if let Some(code) = cause.abort() {
            out.push(ClientFrame::Abort { object: self.object, code }.encode());
        }
        self.end(Err(cause))
    }

    fn end(&mut self, result: Result<(), TransferFailure>) -> TransferProgress {
        self.state = ClientState::Over;
        let data = std::mem::take(&mut self.data);
        let object = self.object;
        TransferProgress::Done(match (result, self.direction) {
            (Ok(()), TransferDirection::Upload) => Ok(data),
            (Ok(()), TransferDirection::Download) => Ok(Vec::new()),
            (Err(cause), _) => Err(TransferError { object, cause }),
        })
    }
}
