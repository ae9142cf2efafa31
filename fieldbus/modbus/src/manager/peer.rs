//! One device, and the state of its connection.
//!
//! ```text
//!  Down ──after a while──▶ Connecting ──▶ Preparing ──▶ Operational
//!   ▲                          │              │              │
//!   └── no connection, no answer in time, an exception, a wrong register ──┘
//! ```
//!
//! Preparing: it is compared, its outputs are turned off, it is set up, its inputs are read. From then on outputs are
//! written and inputs read in each cycle, and changed outputs go out of turn.

use std::time::Duration;

use linewright_fieldbus_seam::{News, gather, scatter};
use linewright_line::{Modbus, Owner, RegisterValue, Table, Tick};

use super::{LinkAct, LinkOutcome, LinkTask, ModbusChange, ModbusOutbox};
use crate::message::{ModbusRequest, kept_bits};
use crate::texts::{ModbusNote, ModbusTrouble};

/// Most time until a device takes a connection.
const CONNECT: Duration = Duration::from_secs(1);
/// Time until a lost device is tried again the first time; then doubled each time.
const RETRY_FIRST: Duration = Duration::from_millis(100);
/// And at the latest.
const RETRY_MAX: Duration = Duration::from_secs(2);
/// One that was operational for so long is tried as soon as at first.
const PROVEN: Duration = Duration::from_secs(1);
/// So many answers in a row in time, and it is not called slow any more: ten seconds of the usual cycle.
const CALM: u32 = 1500;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Down {
        retry: Tick,
    },
    Connecting {
        until: Tick,
    },
    /// The step of its preparation that it has to answer.
    Preparing(usize),
    Operational,
}

/// A step of a preparation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Expect(RegisterValue),
    Release,
    Set(RegisterValue),
    Feed,
    Inputs,
}

/// A part of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReadPart {
    Outputs,
    /// Its outputs are read back.
    Check,
    Feed,
    Inputs,
}

pub(super) struct ModbusPeer {
    at: usize,
    pub name: String,
    pub owner: Owner,
    pub modbus: Modbus,
    pub link: u32,
    phase: Phase,
    steps: Vec<Step>,
    parts: Vec<ReadPart>,
    /// Pending request, and when it was sent.
    asked: Option<(ModbusRequest, Tick)>,
    /// The part of the cycle that comes next.
    part: usize,
    next_cycle: Tick,
    answered: Tick,
    wanted: u64,
    /// Outputs last sent; `None` since it was last lost.
    sent: Option<u64>,
    feed: u16,
    /// When the last write of its watchdog register was sent.
    fed: Tick,
    received: u64,
    /// When its inputs last came; `None` since it was last lost.
    pub updated: Option<Tick>,
    /// Reason why it is not operational.
    pub why: Option<ModbusTrouble>,
    failures: u32,
    up_since: Tick,
    pub losses: u32,
    /// Time until its last answer.
    pub took: Duration,
    pub is_slow: bool,
    calm: u32,
}

impl ModbusPeer {
    pub fn new(at: usize, name: &str, owner: Owner, modbus: &Modbus) -> Self {
        let (has_inputs, has_outputs) = (!modbus.inputs.is_empty(), !modbus.outputs.is_empty());
        let expected = modbus.expect.iter().copied().map(Step::Expect);
        let set = modbus.settings.iter().copied().map(Step::Set);
        let steps = expected
            .chain(has_outputs.then_some(Step::Release))
            .chain(set)
            .chain(modbus.watchdog.map(|_| Step::Feed))
            .chain(has_inputs.then_some(Step::Inputs));
        // Before they are written again, which would hide that they were changed.
        let parts = (has_outputs && modbus.reads_back).then_some(ReadPart::Check).into_iter();
        let parts = parts.chain(has_outputs.then_some(ReadPart::Outputs));
        let parts = parts.chain(modbus.watchdog.map(|_| ReadPart::Feed)).chain(has_inputs.then_some(ReadPart::Inputs));
        ModbusPeer {
            at,
            name: name.to_owned(),
            owner,
            link: 0,
            phase: Phase::Down { retry: Tick::ZERO },
            steps: steps.collect(),
            parts: parts.collect(),
            asked: None,
            part: 0,
            next_cycle: Tick::ZERO,
            answered: Tick::ZERO,
            wanted: 0,
            sent: None,
            feed: 0,
            fed: Tick::ZERO,
            received: 0,
            updated: None,
            why: None,
            failures: 0,
            up_since: Tick::ZERO,
            losses: 0,
            took: Duration::ZERO,
            is_slow: false,
            calm: 0,
            modbus: modbus.clone(),
        }
    }

    pub fn is_operational(&self) -> bool {
        self.phase == Phase::Operational
    }

    pub fn is_preparing(&self) -> bool {
        matches!(self.phase, Phase::Preparing(_))
    }

    /// When it is tried again, if it is not connected to.
    pub fn retry(&self) -> Option<Tick> {
        match self.phase {
            Phase::Down { retry } => Some(retry),
            _ => None,
        }
    }

    /// Pending request.
    pub fn pending(&self) -> Option<ModbusRequest> {
        self.asked.map(|(request, _)| request)
    }

    /// Its inputs may be acted upon: it is operational, and neither an answer nor the next question is overdue.
    pub fn is_trusted(&self, now: Tick) -> bool {
        let overdue = match self.asked {
            Some((_, since)) => since + self.modbus.timeout,
            None => self.next_cycle.max(self.answered) + self.modbus.timeout,
        };
        self.is_operational() && now < overdue
    }

    pub fn input_bits(&self) -> u128 {
        gather(self.received, &self.modbus.inputs)
    }

    /// Request that turns its outputs off, if it has any.
    pub fn rest(&self) -> Option<ModbusRequest> {
        (!self.modbus.outputs.is_empty()).then(|| self.write(0))
    }

    fn write(&self, bits: u64) -> ModbusRequest {
        ModbusRequest::write_bits(self.modbus.outputs_at, self.modbus.outputs.len(), bits)
    }

    /// Takes its share of the image its owner has set. One that is not operational gets none of it.
    pub fn want(&mut self, image: u128) {
        self.wanted = if self.is_operational() { scatter(image, &self.modbus.outputs) } else { 0 };
    }

    pub fn deadline(&self) -> Tick {
        match (self.phase, self.asked) {
            (Phase::Down { retry }, _) => retry,
            (Phase::Connecting { until }, _) => until,
            (_, Some((_, since))) => since + self.modbus.timeout,
            (_, None) => self.next_cycle,
        }
    }

    /// Why earlier outputs may not be written any more: no request was sent for longer than a cycle may take, since
    /// this program or its machine stood still, or the device's watchdog may have run out. The device may have turned
    /// its outputs off by itself then, and a write would turn them on again.
    fn stood_still(&self, now: Tick) -> Option<ModbusTrouble> {
        if !self.is_operational() || self.asked.is_some() {
            return None;
        }
        if !self.is_trusted(now) {
            return Some(ModbusTrouble::NotAsked(now.since(self.answered)));
        }
        let watchdog = self.modbus.watchdog?;
        // A write that is sent now may take as long as an answer to arrive.
        let is_due = self.fed + watchdog.timeout <= now + self.modbus.timeout;
        is_due.then(|| ModbusTrouble::WatchdogUnwritten(now.since(self.fed)))
    }

    pub fn poll(&mut self, now: Tick, out: &mut ModbusOutbox) -> ModbusChange {
        match self.phase {
            Phase::Down { retry } if retry <= now => {
                self.link += 1;
                self.phase = Phase::Connecting { until: now + CONNECT };
                self.act(LinkTask::Connect, out);
            }
            Phase::Connecting { until } if until <= now => {
                return self.lose(now, ModbusTrouble::NotConnected(CONNECT), out);
            }
            _ => {}
        }
        match self.asked {
            Some((request, since)) if since + self.modbus.timeout <= now => {
                self.lose(now, ModbusTrouble::Unanswered { request, within: self.modbus.timeout }, out)
            }
            _ => match self.stood_still(now) {
                Some(why) => self.lose(now, why, out),
                None => ModbusChange::Nothing,
            },
        }
    }

    pub fn take(&mut self, now: Tick, outcome: LinkOutcome, out: &mut ModbusOutbox) -> ModbusChange {
        if let LinkOutcome::Connected = outcome {
            return if matches!(self.phase, Phase::Connecting { .. }) {
                self.prepare(now, 0, out)
            } else {
                ModbusChange::Nothing
            };
        }
        let asked = self.asked.take();
        let value = match outcome {
            LinkOutcome::Failed(failure) => {
                return self.lose(now, ModbusTrouble::Failed { request: asked.map(|asked| asked.0), failure }, out);
            }
            LinkOutcome::Read(value) => Some(value),
            LinkOutcome::Written | LinkOutcome::Connected => None,
        };
        if let Some((_, since)) = asked {
            (self.took, self.answered) = (now.since(since), now);
            self.judge_pace(out);
        }
        match self.phase {
            Phase::Preparing(step) => self.prepared(now, step, value, out),
            Phase::Operational => match (asked, value) {
                (Some((ModbusRequest::Read { .. }, _)), Some(value)) => match self.part_asked() {
                    Some(ReadPart::Check) => self.compare(now, value, out),
                    _ => self.receive(now, value),
                },
                _ => ModbusChange::Nothing,
            },
            Phase::Down { .. } | Phase::Connecting { .. } => ModbusChange::Nothing,
        }
    }

    fn receive(&mut self, now: Tick, value: u64) -> ModbusChange {
        self.received = kept_bits(value, self.modbus.inputs.len());
        self.updated = Some(now);
        ModbusChange::Inputs
    }

    /// The last part of the cycle that was requested.
    fn part_asked(&self) -> Option<ReadPart> {
        self.parts.get(self.part.checked_sub(1)?).copied()
    }

    /// Compares its outputs with what it was last written: another master may write them, or they have gone off.
    fn compare(&mut self, now: Tick, value: u64, out: &mut ModbusOutbox) -> ModbusChange {
        let (found, written) = (kept_bits(value, self.modbus.outputs.len()), self.sent.unwrap_or(0));
        if found == written {
            return ModbusChange::Nothing;
        }
        self.lose(now, ModbusTrouble::OutputsChanged { found, written }, out)
    }

    /// A step of its preparation is answered.
    fn prepared(&mut self, now: Tick, step: usize, value: Option<u64>, out: &mut ModbusOutbox) -> ModbusChange {
        match (self.steps.get(step), value) {
            (Some(Step::Expect(expected)), Some(value)) if value != u64::from(expected.value) => {
                let RegisterValue { register, value: expected } = *expected;
                return self.lose(now, ModbusTrouble::OtherDevice { register, found: value, expected }, out);
            }
            (Some(Step::Inputs), Some(value)) => {
                self.receive(now, value);
            }
            _ => {}
        }
        self.prepare(now, step + 1, out)
    }

    /// Sends the next step of its preparation, or is operational after the last one.
    fn prepare(&mut self, now: Tick, step: usize, out: &mut ModbusOutbox) -> ModbusChange {
        self.phase = Phase::Preparing(step);
        let request = match self.steps.get(step) {
            Some(Step::Expect(RegisterValue { register, .. })) => {
                ModbusRequest::Read { table: Table::HoldingRegisters, first: *register, count: 1 }
            }
            Some(Step::Release) => self.write(0),
            Some(Step::Set(RegisterValue { register, value })) => ModbusRequest::write_register(*register, *value),
            Some(Step::Feed) => self.next_feed(now),
            Some(Step::Inputs) => ModbusRequest::read_bits(self.modbus.inputs_at, self.modbus.inputs.len()),
            None => {
                self.phase = Phase::Operational;
                (self.why, self.up_since, self.wanted, self.sent) = (None, now, 0, Some(0));
                (self.part, self.next_cycle) = (self.parts.len(), now + self.modbus.cycle);
                self.note(ModbusNote::Operational, out);
                return ModbusChange::Inputs;
            }
        };
        self.ask(now, request, out);
        ModbusChange::Nothing
    }

    fn next_feed(&mut self, now: Tick) -> ModbusRequest {
        // Never 0, which some devices take for a watchdog switched off.
        self.feed = self.feed.wrapping_add(1).max(1);
        self.fed = now;
        ModbusRequest::write_register(self.modbus.watchdog.map_or(0, |watchdog| watchdog.register), self.feed)
    }

    /// Sends the next request that is due, unless an answer is awaited.
    pub fn go_on(&mut self, now: Tick, out: &mut ModbusOutbox) {
        // If it stood still, the next poll loses it.
        if !self.is_operational() || self.asked.is_some() || self.stood_still(now).is_some() {
            return;
        }
        // Changed outputs go first, whatever else is due.
        if !self.modbus.outputs.is_empty() && self.sent != Some(self.wanted) {
            return self.send_outputs(now, out);
        }
        if self.part == self.parts.len() {
            if now < self.next_cycle {
                return;
            }
            // A cycle missed by a late caller is not made up for: the next one counts from now.
            (self.part, self.next_cycle) = (0, now + self.modbus.cycle);
        }
        let Some(part) = self.parts.get(self.part).copied() else { return };
        self.part += 1;
        match part {
            ReadPart::Outputs => self.send_outputs(now, out),
            ReadPart::Check => {
                self.ask(now, ModbusRequest::read_bits(self.modbus.outputs_at, self.modbus.outputs.len()), out);
            }
            ReadPart::Feed => {
                let request = self.next_feed(now);
                self.ask(now, request, out);
            }
            ReadPart::Inputs => {
                self.ask(now, ModbusRequest::read_bits(self.modbus.inputs_at, self.modbus.inputs.len()), out);
            }
        }
    }

    fn send_outputs(&mut self, now: Tick, out: &mut ModbusOutbox) {
        self.sent = Some(self.wanted);
        self.ask(now, self.write(self.wanted), out);
    }

    fn ask(&mut self, now: Tick, request: ModbusRequest, out: &mut ModbusOutbox) {
        self.asked = Some((request, now));
        self.act(LinkTask::Ask(request), out);
    }

    fn act(&self, what: LinkTask, out: &mut ModbusOutbox) {
        out.acts.push(LinkAct { device: self.at, link: self.link, what });
    }

    fn judge_pace(&mut self, out: &mut ModbusOutbox) {
        if self.took > self.modbus.cycle {
            self.calm = 0;
            if !self.is_slow {
                self.is_slow = true;
                self.note(ModbusNote::Slow { took: self.took, cycle: self.modbus.cycle }, out);
            }
        } else if self.is_slow {
            self.calm += 1;
            if self.calm >= CALM {
                self.is_slow = false;
                self.note(ModbusNote::SlowNoLonger, out);
            }
        }
    }

    fn note(&self, note: ModbusNote<'_>, out: &mut ModbusOutbox) {
        out.news.push(News::Noted(format!("{} {note}", self.name)));
    }

    /// It cannot be used, or not any more.
    fn lose(&mut self, now: Tick, why: ModbusTrouble, out: &mut ModbusOutbox) -> ModbusChange {
        let was_up = self.is_operational();
        if was_up && self.up_since + PROVEN <= now {
            self.failures = 0;
        }
        if was_up {
            self.note(ModbusNote::Lost(&why), out);
        } else if self.why.as_ref() != Some(&why) {
            self.note(ModbusNote::NotStarted(&why), out);
        }
        let wait = if why.is_refusal() { RETRY_MAX } else { RETRY_FIRST * 2u32.pow(self.failures.min(5)) };
        self.failures += 1;
        self.why = Some(why);
        self.losses += u32::from(was_up);
        self.hang_up(out);
        self.phase = Phase::Down { retry: now + wait.min(RETRY_MAX) };
        if was_up { ModbusChange::Lost } else { ModbusChange::Nothing }
    }

    /// Lets go of its outputs and closes its connection.
    fn hang_up(&mut self, out: &mut ModbusOutbox) {
        if !matches!(self.phase, Phase::Down { .. }) {
            let is_connected = !matches!(self.phase, Phase::Connecting { .. });
            // One that may be another device is sent nothing.
            let is_known = match self.phase {
                Phase::Preparing(step) => !matches!(self.steps.get(step), Some(Step::Expect(_))),
                _ => true,
            };
            self.act(LinkTask::Close { last: self.rest().filter(|_| is_connected && is_known) }, out);
        }
        self.link += 1;
        (self.asked, self.sent, self.wanted, self.updated) = (None, None, 0, None);
    }

    /// For an orderly end.
    pub fn close(&mut self, out: &mut ModbusOutbox) {
        self.hang_up(out);
        self.phase = Phase::Down { retry: Tick::NEVER };
    }

    /// Starts anew on request.
    pub fn reset(&mut self, now: Tick, out: &mut ModbusOutbox) -> ModbusChange {
        let change = self.lose(now, ModbusTrouble::Reset, out);
        self.retry_now(now);
        change
    }

    /// Is tried again now, if it is waited with.
    pub fn retry_now(&mut self, now: Tick) {
        self.failures = 0;
        if let Phase::Down { retry } = &mut self.phase {
            *retry = now;
        }
    }
}
