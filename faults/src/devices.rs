//! The devices of an owner: between its manager, which is a process, and its mechanisms.
//!
//! Not by frames: what a manager observes (validity, losses, outputs off by missing heartbeats) at its times.

use std::time::Duration;

use linewright_line::{Owner, Tick};
use linewright_plant::Plant;

/// Time from a boot-up to the first process data.
const BOOT: Duration = Duration::from_millis(30);

/// Inputs as a manager has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SeenImage {
    pub(crate) bits: u128,
    pub(crate) valid: bool,
    pub(crate) losses: u64,
}

/// The devices of one owner.
#[derive(Clone, Debug)]
pub(crate) struct OwnedIo {
    pub(crate) owner: Owner,
    asked: u128,
    /// What a manager has given since they started or were lost last.
    given: u128,
    /// Broken on purpose: they keep their outputs at a loss, and take them up after a restart.
    keeps: (bool, bool),
    losses: u64,
    timeout: Duration,
    /// They are not reached since then: the bus is off, or their manager is silent.
    pub(crate) unreached: Option<Tick>,
    /// The loss has been noticed by both sides.
    is_noticed: bool,
    /// Valid from then on.
    booted: Tick,
    /// Inputs at the loss.
    frozen: u128,
    /// Number of reasons for which they are not reached.
    reasons: u32,
}

impl OwnedIo {
    pub(crate) fn new(owner: Owner, timeout: Duration, keeps: (bool, bool)) -> Self {
        OwnedIo {
            owner,
            asked: 0,
            given: 0,
            keeps,
            losses: 0,
            timeout,
            unreached: None,
            is_noticed: false,
            booted: Tick::ZERO + BOOT,
            frozen: 0,
            reasons: 0,
        }
    }

    /// Next change by time alone.
    pub(crate) fn deadline(&self, now: Tick) -> Tick {
        let noticed = self.unreached.filter(|_| !self.is_noticed).map_or(Tick::NEVER, |since| since + self.timeout);
        let booted = if self.booted > now { self.booted } else { Tick::NEVER };
        noticed.min(booted)
    }

    /// Lets time pass.
    pub(crate) fn poll(&mut self, now: Tick, plant: &mut Plant) {
        if let Some(since) = self.unreached
            && !self.is_noticed
            && since + self.timeout <= now
        {
            self.is_noticed = true;
            self.losses += 1;
            if !self.keeps.0 {
                self.forget(now, plant);
            }
        }
        self.carry(now, plant);
    }

    fn carry(&self, now: Tick, plant: &mut Plant) {
        if self.unreached.is_none() && now >= self.booted {
            plant.set_outputs(now, self.owner, self.asked);
        }
    }

    pub(crate) fn ask(&mut self, now: Tick, bits: u128, plant: &mut Plant) {
        (self.asked, self.given) = (bits, bits);
        self.carry(now, plant);
    }

    /// The manager's image.
    pub(crate) fn image(&self, now: Tick, plant: &Plant) -> SeenImage {
        let valid = now >= self.booted && !self.is_noticed;
        let bits = if self.unreached.is_some() { self.frozen } else { plant.inputs(self.owner) };
        SeenImage { bits: if valid { bits } else { 0 }, valid, losses: self.losses }
    }

    /// The bus goes off, or the manager falls silent.
    pub(crate) fn lose(&mut self, now: Tick, plant: &Plant) {
        self.reasons += 1;
        if self.unreached.is_none() {
            self.unreached = Some(now);
            self.frozen = plant.inputs(self.owner);
        }
    }

    /// One of the reasons is over. What was lost for long starts over.
    pub(crate) fn find(&mut self, now: Tick, plant: &mut Plant) {
        self.reasons = self.reasons.saturating_sub(1);
        if self.reasons > 0 || self.unreached.is_none() {
            return;
        }
        self.poll(now, plant);
        self.unreached = None;
        if std::mem::take(&mut self.is_noticed) {
            self.booted = now + BOOT;
        }
        self.carry(now, plant);
    }

    /// The devices lose their power for a moment.
    pub(crate) fn reboot(&mut self, now: Tick, plant: &mut Plant) {
        self.losses += 1;
        self.forget(now, plant);
        self.booted = now + BOOT;
    }

    /// Outputs go off, and are not taken up again.
    fn forget(&mut self, now: Tick, plant: &mut Plant) {
        self.given = 0;
        if !self.keeps.1 {
            self.asked = 0;
        }
        plant.set_outputs(now, self.owner, 0);
    }

    /// What a manager has given since they started or were lost last.
    pub(crate) fn given(&self) -> u128 {
        self.given
    }

    /// They have been without a manager for longer than they may go on.
    pub(crate) fn is_lost(&self, now: Tick) -> bool {
        self.unreached.is_some_and(|since| now > since + self.timeout)
    }

    /// Another manager takes over: it counts losses from zero and boots every device.
    pub(crate) fn new_manager(&mut self, now: Tick, plant: &mut Plant) {
        self.losses = 0;
        self.forget(now, plant);
        self.booted = now + BOOT;
    }
}
