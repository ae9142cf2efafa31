//! What all processes have: a life, a clock, messages that wait, and a record that is being written.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::Tick;

use crate::message::Message;

/// A record that is being written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Writing {
    pub(crate) takes: Duration,
    /// Whether it succeeds in the end.
    pub(crate) succeeds: bool,
    /// The emergency stop, or the slow disk, has turned the outputs off already.
    pub(crate) is_off: bool,
}

/// A process.
#[derive(Debug)]
pub(crate) struct Process {
    pub(crate) is_up: bool,
    /// Number of its life; boot ids follow from it.
    pub(crate) life: u64,
    /// Number of reasons for which it does not run although it is up.
    pub(crate) stalls: u32,
    /// It ran again after the last of them then.
    pub(crate) resumed: Tick,
    /// What its clock shows is this much more than the time of the world, which begins at a day.
    origin: u64,
    /// Its machine sleeps: since when, and when it would have been called.
    suspended: Option<(Tick, Tick)>,
    /// Messages that wait, since when, and whether the observer has seen them arrive.
    pub(crate) inbox: VecDeque<(Message, Tick, bool)>,
    pub(crate) writing: Option<Writing>,
    /// It ends after so many further effects.
    pub(crate) dies_after: Option<u32>,
    /// It is called then at the latest.
    pub(crate) wakes: Tick,
}

impl Process {
    pub(crate) fn new() -> Self {
        Process {
            is_up: false,
            life: 0,
            stalls: 0,
            resumed: Tick::ZERO,
            origin: 0,
            suspended: None,
            inbox: VecDeque::new(),
            writing: None,
            dies_after: None,
            wakes: Tick::NEVER,
        }
    }

    /// A new life. Its clock begins anywhere.
    pub(crate) fn begin(&mut self, life: u64, origin: u64) {
        let (stalls, suspended) = (self.stalls, self.suspended);
        // The timers of the life before are gone.
        let suspended = suspended.map(|(since, _)| (since, Tick::NEVER));
        *self = Process { is_up: true, life, origin, stalls, suspended, ..Process::new() };
    }

    pub(crate) fn end(&mut self) {
        self.is_up = false;
        self.inbox.clear();
        self.writing = None;
        self.dies_after = None;
        self.wakes = Tick::NEVER;
    }

    /// It takes what arrives.
    pub(crate) fn runs(&self) -> bool {
        self.is_up && self.stalls == 0
    }

    /// The time by its own clock.
    pub(crate) fn clock(&self, now: Tick) -> Tick {
        now + Duration::from_micros(self.origin)
    }

    /// The time of the world at which its clock shows `local`.
    pub(crate) fn world(&self, local: Tick) -> Tick {
        if local == Tick::NEVER { local } else { Tick::from_micros(local.as_micros().saturating_sub(self.origin)) }
    }

    /// Its machine sleeps. Its clock goes on (`CLOCK_BOOTTIME`), the timers that call it stand.
    pub(crate) fn suspend(&mut self, now: Tick) {
        let wakes = std::mem::replace(&mut self.wakes, Tick::NEVER);
        self.suspended.get_or_insert((now, wakes));
    }

    /// It runs again. Gives the time at which its timer calls it, late by as long as its machine slept; none where it runs at once, as after
    /// a mere standstill, or with what has arrived.
    /// `clock_stands`: a broken rule, its clock has stood meanwhile.
    pub(crate) fn resume(&mut self, now: Tick, clock_stands: bool) -> Option<Tick> {
        self.resumed = now;
        let (since, wakes) = self.suspended.take()?;
        if clock_stands {
            self.origin = self.origin.saturating_sub(now.since(since).as_micros() as u64);
            self.inbox.iter_mut().for_each(|(_, delivered, _)| *delivered = now);
            return None;
        }
        (self.inbox.is_empty() && wakes != Tick::NEVER).then(|| now + wakes.since(since))
    }
}
