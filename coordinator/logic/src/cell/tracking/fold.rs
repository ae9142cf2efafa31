//! The fold: one record after the other.
//!
//! ```text
//!  of a resource:   busy ─┬─ an activity that it takes part in is in progress, and none of them has failed
//!                   down ─┴─ one of them has failed, and nobody has said yet what is true
//!  of a part:       worked on, moved, or waiting: from its entering to its leaving it is one of the three
//! ```

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ids::{FiringId, ModeId, PartId};
use super::super::record::{Cause, Fact, Record};
use super::report::{Causes, Report, ResourceReport};
use super::spread::Spread;
use super::{Entry, Passing, Sheet};

/// What has happened so far.
#[derive(Clone, Debug)]
pub struct Tracking {
    sheet: Sheet,
    began: Option<Tick>,
    now: Tick,
    open: BTreeMap<FiringId, Open>,
    resources: Vec<Tally>,
    parts: BTreeMap<PartId, Passage>,
    left: Vec<Passage>,
    waited: Vec<Duration>,
    failures: u64,
}

/// An activity in progress.
#[derive(Clone, Debug)]
struct Open {
    mode: ModeId,
    part: Option<PartId>,
    began: Tick,
    failed: Option<(Tick, String)>,
}

/// What a resource has done.
#[derive(Clone, Debug, Default)]
struct Tally {
    /// Activities in progress that have not failed, and those that have.
    running: u32,
    failed: u32,
    busy: Duration,
    down: Duration,
    causes: Causes,
    /// Of what was worked on here and has ended: how long it should have taken, and how long it did.
    nominal: Duration,
    actual: Duration,
    worked: u64,
}

/// A part on its way.
#[derive(Clone, Copy, Debug)]
struct Passage {
    entered: Tick,
    left: Tick,
    worked: Duration,
    moved: Duration,
}

impl Tracking {
    /// Nothing has happened yet.
    pub fn new(sheet: Sheet) -> Self {
        let resources = vec![Tally::default(); sheet.resources.len()];
        Tracking {
            sheet,
            began: None,
            now: Tick::ZERO,
            open: BTreeMap::new(),
            resources,
            parts: BTreeMap::new(),
            left: Vec::new(),
            waited: Vec::new(),
            failures: 0,
        }
    }

    /// The next record, in the order in which they were written.
    pub fn take(&mut self, record: &Record) {
        self.pass(record.at);
        match &record.fact {
            Fact::Started { firing, mode, part, .. } => {
                self.open.insert(*firing, Open { mode: *mode, part: *part, began: record.at, failed: None });
                self.each(*mode, |tally| tally.running += 1);
                self.enters(*mode, *part, record.at);
            }
            Fact::Raised { firing, cause } => self.fails(*firing, cause, record.at),
            Fact::Ended { firing } => self.ends(*firing, record.at),
            Fact::Fired { mode, part } => {
                self.enters(*mode, *part, record.at);
                self.leaves(*mode, *part, record.at);
            }
            Fact::Epoch { .. }
            | Fact::Memory { .. }
            | Fact::Decided { .. }
            | Fact::Acknowledged { .. }
            | Fact::OrderEnded { .. }
            | Fact::OrderFailed { .. }
            | Fact::Production { .. } => {}
        }
    }

    /// What there is to report until `now`, which no record is later than.
    pub fn report(&self, now: Tick) -> Report {
        let mut until = self.clone();
        until.pass(now);
        for open in until.open.values() {
            if let (Some((since, cause)), Some(entry)) = (&open.failed, until.sheet.modes.get(open.mode.index())) {
                for &resource in &entry.resources {
                    until.resources[resource].causes.add(cause, now.since(*since));
                }
            }
        }
        let observed = until.began.map_or(Duration::ZERO, |began| now.since(began));
        let resource = |(name, tally): (_, &Tally)| ResourceReport {
            name,
            busy: tally.busy,
            down: tally.down,
            causes: tally.causes.clone(),
            worked: tally.worked,
            nominal: tally.nominal,
            actual: tally.actual,
        };
        let lead = |passage: &Passage| passage.left.since(passage.entered);
        Report {
            observed,
            resources: until.sheet.resources.iter().cloned().zip(&until.resources).map(resource).collect(),
            inside: until.parts.len(),
            left: until.left.len(),
            failures: until.failures,
            lead: Spread::of(until.left.iter().map(lead).collect()),
            worked: Spread::of(until.left.iter().map(|passage| passage.worked).collect()),
            moved: Spread::of(until.left.iter().map(|passage| passage.moved).collect()),
            waited: Spread::of(until.waited.clone()),
        }
    }

    /// Time goes by: whoever is busy was busy, whoever is down was down.
    fn pass(&mut self, now: Tick) {
        self.began.get_or_insert(now);
        let gone = now.since(self.now);
        for tally in &mut self.resources {
            if tally.failed > 0 {
                tally.down += gone;
            } else if tally.running > 0 {
                tally.busy += gone;
            }
        }
        self.now = self.now.max(now);
    }

    fn each(&mut self, mode: ModeId, change: impl Fn(&mut Tally)) {
        for &resource in self.sheet.entry(mode).map(|entry| &entry.resources[..]).unwrap_or_default() {
            change(&mut self.resources[resource]);
        }
    }

    fn fails(&mut self, firing: FiringId, cause: &Cause, at: Tick) {
        let Some(open) = self.open.get_mut(&firing) else { return };
        let cause = match cause {
            Cause::TimedOut => "takes longer than it may".to_owned(),
            Cause::Order { failure, .. } => failure.to_string(),
        };
        open.failed = Some((at, cause));
        let mode = open.mode;
        self.failures += 1;
        self.each(mode, |tally| {
            tally.running -= 1;
            tally.failed += 1;
        });
    }

    fn ends(&mut self, firing: FiringId, at: Tick) {
        let Some(open) = self.open.remove(&firing) else { return };
        let took = at.since(open.began);
        match &open.failed {
            None => self.each(open.mode, |tally| tally.running -= 1),
            Some((since, cause)) => self.each(open.mode, |tally| {
                tally.failed -= 1;
                tally.causes.add(cause, at.since(*since));
            }),
        }
        let Some(Entry { worker, nominal, .. }) = self.sheet.modes.get(open.mode.index()) else { return };
        if let Some(worker) = *worker {
            let tally = &mut self.resources[worker];
            tally.worked += 1;
            tally.nominal += *nominal;
            tally.actual += took;
        }
        if let Some(passage) = open.part.and_then(|part| self.parts.get_mut(&part)) {
            match worker {
                Some(_) => passage.worked += took,
                None => passage.moved += took,
            }
        }
        self.leaves(open.mode, open.part, at);
    }

    fn enters(&mut self, mode: ModeId, part: Option<PartId>, at: Tick) {
        if let Some(part) = part
            && self.sheet.entry(mode).is_some_and(|entry| entry.passing == Passing::Enters)
        {
            let (worked, moved) = (Duration::ZERO, Duration::ZERO);
            self.parts.insert(part, Passage { entered: at, left: at, worked, moved });
        }
    }

    fn leaves(&mut self, mode: ModeId, part: Option<PartId>, at: Tick) {
        let leaves = self.sheet.entry(mode).is_some_and(|entry| entry.passing == Passing::Leaves);
        let passage = part.filter(|_| leaves).and_then(|part| self.parts.remove(&part));
        if let Some(passage) = passage {
            let passage = Passage { left: at, ..passage };
            let spent = passage.worked + passage.moved;
            self.waited.push(at.since(passage.entered).saturating_sub(spent));
            self.left.push(passage);
        }
    }
}
