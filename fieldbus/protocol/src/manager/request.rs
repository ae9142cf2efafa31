//! Requests of operators and programs to the devices, through the manager's own SDO channel.
//!
//! A device has one channel, and a foreign client on it disturbs whatever the manager does there. So requests go through
//! here: one at a time for each device, when the manager itself has nothing to transfer; the manager's own business
//! overtakes them. They are bounded in number and in time, and each gets exactly one answer.
//!
//! A service of ROS 2 gives a number and not its length, and only the device has the length of its object: before such
//! a number is written, the object is read. One that cannot be read is written in the shortest length the number has,
//! and in longer ones as long as the device refuses the length.

use std::collections::VecDeque;

use linewright_line::Tick;

use super::Manager;
use super::device_request::{DeviceRequest, DeviceRequestError, PATIENCE, RequestResult, WAITING_MAX};
use super::event::{BusEvent, BusOutbox};
use super::peer::{Peer, SdoChannelState};
use super::protected_objects::guarded;
use super::texts::{not_asked, unknown_node};
use super::transfer::Transfer;
use crate::codec::{NmtCommand, NodeId};
use crate::sdo::wire::SdoBytes;
use crate::sdo::{Abort, ObjectId, SdoWrite, TransferError, TransferFailure, TransferProgress};

#[derive(Debug)]
struct QueuedRequest {
    number: u64,
    node: NodeId,
    ask: DeviceRequest,
    until: Tick,
}

#[derive(Debug)]
struct ActiveRequest {
    number: u64,
    node: NodeId,
    ask: DeviceRequest,
    transfer: Transfer,
    step: RequestStep,
}

/// Purpose of a request's transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RequestStep {
    /// To read the length of the object.
    Measure,
    /// To find that out by writing so many bytes.
    Try(usize),
    /// The requested transfer.
    Last,
}

#[derive(Debug, Default)]
pub(super) struct Requests {
    waiting: VecDeque<QueuedRequest>,
    /// At most one for each device.
    active: Vec<ActiveRequest>,
    /// Next request to send a segment of a block.
    turn: usize,
    last: u64,
}

impl Requests {
    /// The first request from `from` on whose transfer has segments of a block to send.
    pub fn streaming(&self, from: usize) -> Option<usize> {
        (from..self.active.len()).find(|at| self.active[*at].transfer.streams())
    }

    /// Sends one of them, those of the requests in turn; false if there is none.
    pub fn stream(&mut self, now: Tick, out: &mut BusOutbox) -> bool {
        let Some(at) = self.streaming(self.turn).or_else(|| self.streaming(0)) else { return false };
        self.active[at].transfer.stream(now, &mut out.frames);
        self.turn = at + 1;
        true
    }

    pub fn deadline(&self) -> Tick {
        let waiting = self.waiting.iter().map(|request| request.until);
        waiting.chain(self.active.iter().map(|active| active.transfer.deadline())).fold(Tick::NEVER, Tick::min)
    }

    /// Takes eight bytes of a device's SDO server, if they belong to a request.
    pub fn answered(&mut self, now: Tick, peer: &mut Peer, raw: &SdoBytes, out: &mut BusOutbox) -> bool {
        let Some(at) = self.active.iter().position(|active| active.node == peer.node && peer.lent) else {
            return false;
        };
        let progress = self.active[at].transfer.handle(now, raw, &mut out.frames);
        self.go_on(now, at, progress, peer, out);
        true
    }

    /// Advances all of them: ends what was overtaken or is late, begins what may begin.
    pub fn poll(&mut self, now: Tick, peers: &mut [Peer], out: &mut BusOutbox) {
        for at in (0..self.active.len()).rev() {
            let Some(peer) = peers.iter_mut().find(|peer| peer.node == self.active[at].node) else { continue };
            if peer.lent {
                let progress = self.active[at].transfer.poll(now, &mut out.frames);
                self.go_on(now, at, progress, peer, out);
            } else {
                // No abort to the device: a transfer of the manager's own has ended this one there.
                let request = self.active.swap_remove(at);
                finish(request.number, Err(DeviceRequestError::Overtaken(peer.explain(now))), out);
            }
        }
        for _ in 0..self.waiting.len() {
            let Some(request) = self.waiting.pop_front() else { break };
            let Some(peer) = peers.iter_mut().find(|peer| peer.node == request.node) else { continue };
            match peer.channel() {
                SdoChannelState::Free => self.begin(now, &request, peer, out),
                SdoChannelState::None => {
                    finish(request.number, Err(DeviceRequestError::NotReady(peer.explain(now))), out)
                }
                SdoChannelState::Busy if request.until <= now => {
                    finish(request.number, Err(DeviceRequestError::Waited(peer.explain(now))), out);
                }
                // Back to the end: the order of those of one device stays as it is.
                SdoChannelState::Busy => self.waiting.push_back(request),
            }
        }
    }

    fn begin(&mut self, now: Tick, request: &QueuedRequest, peer: &mut Peer, out: &mut BusOutbox) {
        let QueuedRequest { number, node, ask, .. } = *request;
        let (transfer, step) = match ask {
            DeviceRequest::Read(object) => (Transfer::read(now, node, object, &mut out.frames), RequestStep::Last),
            DeviceRequest::Write { object, value, bytes } => match bytes.map(|bytes| setting(object, value, bytes)) {
                Some(Ok(setting)) => (Transfer::write(now, node, &setting, &mut out.frames), RequestStep::Last),
                Some(Err(error)) => return finish(number, Err(error), out),
                None => (Transfer::read(now, node, object, &mut out.frames), RequestStep::Measure),
            },
        };
        peer.lent = true;
        self.active.push(ActiveRequest { number, node, ask, transfer, step });
    }

    fn go_on(&mut self, now: Tick, at: usize, progress: TransferProgress, peer: &mut Peer, out: &mut BusOutbox) {
        let TransferProgress::Done(result) = progress else { return };
        let active = &mut self.active[at];
        let answer = match (active.step, active.ask, result) {
            (RequestStep::Measure, DeviceRequest::Write { .. }, Ok(bytes)) => {
                active.write(now, bytes.len(), RequestStep::Last, out)
            }
            (
                RequestStep::Measure,
                DeviceRequest::Write { .. },
                Err(TransferError { cause: TransferFailure::Refused(Abort::WRITE_ONLY), .. }),
            ) => active.try_longer_than(now, 0, out),
            (
                RequestStep::Try(bytes),
                DeviceRequest::Write { .. },
                Err(TransferError { cause: TransferFailure::Refused(code), .. }),
            ) if bytes < 4 && matches!(code, Abort::LENGTH | Abort::TOO_LONG | Abort::TOO_SHORT) => {
                active.try_longer_than(now, bytes, out)
            }
            (_, DeviceRequest::Write { .. }, Ok(_)) => Some(Ok(Vec::new())),
            (_, DeviceRequest::Read(_), Ok(bytes)) => Some(Ok(bytes)),
            (_, _, Err(error)) => Some(Err(error.into())),
        };
        let Some(answer) = answer else { return };
        let number = self.active.swap_remove(at).number;
        finish(number, answer, out);
        peer.give_back(now, out);
    }
}

impl ActiveRequest {
    /// Writes the number in so many bytes; an answer if that cannot be.
    fn write(&mut self, now: Tick, bytes: usize, step: RequestStep, out: &mut BusOutbox) -> Option<RequestResult> {
        let DeviceRequest::Write { object, value, .. } = self.ask else { return None };
        match setting(object, value, bytes) {
            Ok(setting) => {
                self.step = step;
                self.transfer = Transfer::write(now, self.node, &setting, &mut out.frames);
                None
            }
            Err(error) => Some(Err(error)),
        }
    }

    fn try_longer_than(&mut self, now: Tick, bytes: usize, out: &mut BusOutbox) -> Option<RequestResult> {
        let DeviceRequest::Write { object, value, .. } = self.ask else { return None };
        let longer = [1, 2, 4].into_iter().filter(|&length| length > bytes);
        let fits = longer.into_iter().find(|&length| setting(object, value, length).is_ok());
        // Four bytes hold any number, and after four nothing is tried.
        self.write(now, fits.unwrap_or(4), RequestStep::Try(fits.unwrap_or(4)), out)
    }
}

fn finish(number: u64, answer: RequestResult, out: &mut BusOutbox) {
    out.answers.push((number, answer));
    out.events.push(BusEvent::Answered { number });
}

/// A number in the bytes an object has.
fn setting(object: ObjectId, value: u32, bytes: usize) -> Result<SdoWrite, DeviceRequestError> {
    let all = value.to_le_bytes();
    let fits = (1..=4).contains(&bytes) && all[bytes..].iter().all(|&byte| byte == 0);
    if fits {
        Ok(SdoWrite::new(object.index, object.sub, all[..bytes].to_vec()))
    } else {
        Err(DeviceRequestError::TooLarge { object, value, bytes })
    }
}

impl Manager {
    /// Sends a request to a device; the answer comes as [`BusEvent::Answered`] with the number given here, and is in
    /// [`BusOutbox::answers`]. At once if it is refused.
    pub fn ask(&mut self, now: Tick, node: u8, ask: DeviceRequest, out: &mut BusOutbox) -> u64 {
        let start = out.frames.len();
        self.requests.last += 1;
        let number = self.requests.last;
        let Some(peer) = self.peers.iter().find(|peer| peer.node.get() == node) else {
            finish(number, Err(DeviceRequestError::UnknownNode { node }), out);
            return number;
        };
        if let Some(why) = self.rival.keeps_off(now) {
            finish(number, Err(DeviceRequestError::NotReady(not_asked(&why))), out);
        } else if let DeviceRequest::Write { object, .. } = ask
            && let Some(why) = guarded(object, &peer.plan.settings)
        {
            finish(number, Err(DeviceRequestError::Guarded { object, why }), out);
        } else if self.requests.waiting.len() >= WAITING_MAX {
            finish(number, Err(DeviceRequestError::Full), out);
        } else {
            let node = peer.node;
            self.requests.waiting.push_back(QueuedRequest { number, node, ask, until: now + PATIENCE });
            self.requests.poll(now, &mut self.peers, out);
            self.pass(now, start, out);
        }
        number
    }

    /// Resets a device (NMT 81h), whatever it does: it lets go of its outputs, its owner loses it, and it is booted
    /// again. That fails safe, so it is allowed at any time; only not where another manager may drive the bus.
    pub fn reset_node(&mut self, now: Tick, node: NodeId, out: &mut BusOutbox) {
        if self.rival.keeps_off(now).is_some() {
            return;
        }
        if let Some(peer) = self.peers.iter().find(|peer| peer.node == node) {
            let start = out.frames.len();
            peer.order(NmtCommand::ResetNode, out);
            self.pass(now, start, out);
        }
    }

    /// Starts a device that another node has stopped, and has one that was refused looked at again. Otherwise a device
    /// is started when it has been configured, and not before.
    ///
    /// # Errors
    /// Why it is not started now, in words.
    pub fn start_node(&mut self, now: Tick, node: NodeId, out: &mut BusOutbox) -> Result<String, String> {
        if let Some(why) = self.rival.keeps_off(now) {
            return Err(why);
        }
        let start = out.frames.len();
        let reply = match self.peers.iter_mut().find(|peer| peer.node == node) {
            Some(peer) => peer.start_by_request(now, out),
            None => Err(unknown_node(node.get())),
        };
        self.pass(now, start, out);
        reply
    }
}
