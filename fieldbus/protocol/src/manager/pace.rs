//! Rate of the manager's frames: one limit for all devices of its bus.
//!
//! An interface queues about ten frames (`txqueuelen`) and drops the rest; a bus of 500 kbit/s carries about four in a
//! millisecond. Frames for 32 devices at once are far more than that. So frames wait here, not there:
//!
//! - **urgent** ones (network management, the heartbeat, SYNC) never wait;
//! - **process data** wait for the manager's own rate. Of each device only the newest waits, so what is late is never
//!   old: an order to let go takes the place of the one it revokes;
//! - **service data** have the remaining rate, other nodes' frames deducted, and at least one frame each millisecond.
//!   Requests go in the order in which they came; segments of blocks, which could fill any queue, are taken from the
//!   transfers one by one and in turn when there is room for them ([`SendQueue::may_stream`]).
//!
//! Frames that the interface refuses all the same, because other nodes keep the bus busy, come back
//! ([`SendQueue::give_back`]) and go first.
//!
//! A transfer that is alone has the whole rate. Frames are distinguished by their COB-ID alone.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::Tick;

use crate::codec::NodeId;
use crate::frame::Frame;

/// Bus time of an average frame at 500 kbit/s, in µs.
const FRAME: i64 = 250;
/// Most frames at once after a pause. Less than an interface's queue, which urgent ones need as well.
const BURST: i64 = 8;
/// Service data go at least this often, however busy the bus is.
const LEAST: Duration = Duration::from_millis(1);
/// Urgent frames that wait at most, on an interface that takes nothing: an order for each device.
const URGENT_MAX: usize = 128;
/// Requests to one device that wait at most. It has one transfer at a time: older ones belong to one that was given up.
const REQUESTS_MAX: usize = 4;

/// Frames that wait, and when they may go.
#[derive(Debug, Default)]
pub(super) struct SendQueue {
    at: Tick,
    /// Microseconds of the bus that may be used, by the manager's own frames.
    own: i64,
    /// Microseconds of the bus that may be used, by the frames of all nodes.
    shared: i64,
    /// Urgent frames that were refused.
    urgent: VecDeque<Frame>,
    /// Identifiers, with the kernel's flags, of frames for devices without CANopen.
    plain: Vec<u32>,
    process: VecDeque<Frame>,
    service: VecDeque<Frame>,
    /// When service data may go in any case.
    next_service: Tick,
    /// Frames given to [`SendQueue::pass`], while it runs: kept, so that steady traffic allocates nothing.
    given: Vec<Frame>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum SendClass {
    Urgent,
    Process,
    Service,
}

fn class(frame: &Frame) -> SendClass {
    match frame.cob_id().map(|id| id & 0x780) {
        // Among a manager's frames: RPDO 1 to 4, and those of devices without CANopen.
        Some(0x200 | 0x300 | 0x400 | 0x500) | None => SendClass::Process,
        Some(0x600) => SendClass::Service,
        Some(_) => SendClass::Urgent,
    }
}

impl SendQueue {
    /// From here on frames with this id word are process data, whatever they would be in CANopen.
    pub fn treat_as_process_data(&mut self, id_word: u32) {
        self.plain.push(id_word);
    }

    fn class(&self, frame: &Frame) -> SendClass {
        if self.plain.contains(&frame.id_word()) { SendClass::Process } else { class(frame) }
    }

    /// With its whole burst to spend.
    pub fn new() -> Self {
        SendQueue { own: BURST * FRAME, shared: BURST * FRAME, ..SendQueue::default() }
    }

    /// Another node has sent a frame.
    pub fn received(&mut self, now: Tick) {
        self.refill(now);
        self.shared = (self.shared - FRAME).max(-BURST * FRAME);
    }

    /// Takes the frames from `start` on and gives back those that may go now.
    pub fn pass(&mut self, now: Tick, start: usize, frames: &mut Vec<Frame>) {
        self.refill(now);
        let mut given = std::mem::take(&mut self.given);
        given.extend(frames.drain(start..));
        for frame in given.drain(..) {
            match self.class(&frame) {
                SendClass::Urgent if !self.urgent.is_empty() => self.queue_urgent(frame),
                SendClass::Urgent => {
                    self.spend();
                    frames.push(frame);
                }
                SendClass::Process => self.queue_process(frame),
                SendClass::Service => self.queue_service(frame),
            }
            self.release(now, frames);
        }
        self.given = given;
        self.release(now, frames);
    }

    fn release(&mut self, now: Tick, frames: &mut Vec<Frame>) {
        while self.own >= FRAME
            && let Some(frame) = self.urgent.pop_front().or_else(|| self.process.pop_front())
        {
            self.spend();
            frames.push(frame);
        }
        while self.own_is_through()
            && self.service_may_go(now)
            && let Some(frame) = self.service.pop_front()
        {
            self.spend_service(now);
            frames.push(frame);
        }
    }

    /// The interface had no room for these.
    pub fn give_back(&mut self, now: Tick, frames: Vec<Frame>) {
        self.refill(now);
        // The interface is full: its queue goes first.
        (self.own, self.shared) = (0, 0);
        self.next_service = now + LEAST;
        for frame in frames.into_iter().rev() {
            let waits = |queue: &VecDeque<Frame>| queue.iter().any(|waiting| waiting.id_word() == frame.id_word());
            match self.class(&frame) {
                // A heartbeat or SYNC that is late is no better than the next; orders all count.
                SendClass::Urgent if frame.cob_id() != Some(0) && waits(&self.urgent) => {}
                SendClass::Urgent if self.urgent.len() >= URGENT_MAX => {}
                SendClass::Urgent => self.urgent.push_front(frame),
                SendClass::Process if waits(&self.process) => {}
                SendClass::Process => self.process.push_front(frame),
                SendClass::Service => self.service.push_front(frame),
            }
        }
    }

    /// Whether there is room for one segment of a block.
    pub fn may_stream(&self, now: Tick) -> bool {
        self.own_is_through() && self.service.is_empty() && self.service_may_go(now)
    }

    /// Counts a segment that was sent.
    pub fn streamed(&mut self, now: Tick) {
        self.spend_service(now);
    }

    /// A device is lost: frames waiting for it were decided before, and are not sent after.
    pub fn forget(&mut self, node: NodeId) {
        let its = |id: u16| matches!(id & 0x780, 0x200 | 0x300 | 0x400 | 0x500) && id & 0x7F == u16::from(node.get());
        self.process.retain(|frame| !frame.cob_id().is_some_and(its));
    }

    #[cfg(test)]
    pub fn is_empty(&self) -> bool {
        self.own_is_through() && self.service.is_empty()
    }

    /// The manager ends: waiting frames are not sent.
    pub fn forget_all(&mut self) {
        self.urgent.clear();
        self.process.clear();
        self.service.clear();
    }

    /// When something that waits may go; `streaming` is whether a transfer has segments to send.
    pub fn deadline(&self, streaming: bool) -> Tick {
        let after = |credit: i64| self.at + Duration::from_micros((FRAME - credit).max(0).unsigned_abs());
        let process = if self.own_is_through() { Tick::NEVER } else { after(self.own) };
        let waits = streaming || !self.service.is_empty();
        // Behind process data, if any wait.
        let service =
            if waits && self.own_is_through() { after(self.shared).min(self.next_service) } else { Tick::NEVER };
        process.min(service)
    }

    fn refill(&mut self, now: Tick) {
        let passed = i64::try_from(now.since(self.at).as_micros()).unwrap_or(i64::MAX);
        self.at = self.at.max(now);
        for credit in [&mut self.own, &mut self.shared] {
            *credit = credit.saturating_add(passed).min(BURST * FRAME);
        }
    }

    fn spend(&mut self) {
        for credit in [&mut self.own, &mut self.shared] {
            *credit = (*credit - FRAME).max(-BURST * FRAME);
        }
    }

    fn spend_service(&mut self, now: Tick) {
        self.spend();
        self.next_service = now + LEAST;
    }

    fn service_may_go(&self, now: Tick) -> bool {
        self.shared >= FRAME || self.next_service <= now
    }

    /// Whether nothing waits that goes before service data.
    fn own_is_through(&self) -> bool {
        self.urgent.is_empty() && self.process.is_empty()
    }

    fn queue_urgent(&mut self, frame: Frame) {
        self.urgent.retain(|waiting| waiting.cob_id() == Some(0) || waiting.id_word() != frame.id_word());
        if self.urgent.len() < URGENT_MAX {
            self.urgent.push_back(frame);
        }
    }

    fn queue_process(&mut self, frame: Frame) {
        match self.process.iter_mut().find(|waiting| waiting.id_word() == frame.id_word()) {
            Some(waiting) => *waiting = frame,
            None => self.process.push_back(frame),
        }
    }

    fn queue_service(&mut self, frame: Frame) {
        let same = |waiting: &Frame| waiting.id_word() == frame.id_word();
        if self.service.iter().filter(|waiting| same(waiting)).count() >= REQUESTS_MAX
            && let Some(oldest) = self.service.iter().position(same)
        {
            self.service.remove(oldest);
        }
        self.service.push_back(frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(pace: &mut SendQueue, micros: u64, frames: &[&str]) -> Vec<String> {
        let mut frames: Vec<Frame> = frames.iter().map(|text| text.parse().unwrap()).collect();
        pace.pass(Tick::from_micros(micros), 0, &mut frames);
        frames.iter().map(Frame::to_string).collect()
    }

    #[test]
    fn of_each_device_the_newest_process_data_wait_and_urgent_frames_do_not() {
        let mut pace = SendQueue::new();
        let eight = ["201#00", "202#00", "203#00", "204#00", "205#00", "206#00", "207#00", "208#00"];
        assert_eq!(pass(&mut pace, 0, &eight), eight);
        assert!(pass(&mut pace, 0, &["209#01", "20A#00", "601#4000100000000000"]).is_empty());
        assert_eq!(pass(&mut pace, 0, &["209#00", "77F#05"]), ["77F#05"]);
        // The urgent frame's share is missing for a moment.
        assert_eq!(pace.deadline(false), Tick::from_micros(500));
        assert_eq!(pass(&mut pace, 500, &[]), ["209#00"]);
        pace.forget(NodeId::new(10).unwrap());
        assert_eq!(pass(&mut pace, 1500, &[]), ["601#4000100000000000"]);
    }

    #[test]
    fn a_busy_bus_leaves_service_data_a_frame_each_millisecond() {
        let mut pace = SendQueue::new();
        let mut sent = 0;
        for micros in (0..100_000).step_by(100) {
            pace.received(Tick::from_micros(micros));
            sent += pass(&mut pace, micros, &["601#4000100000000000"]).len();
            assert!(pace.service.len() <= REQUESTS_MAX, "what one device babbles for is bounded");
        }
        assert!((100..=112).contains(&sent), "{sent}");
    }
}
