//! The fold: one record after the other.
//!
//! ```text
//!  of a resource:   busy ─┬─ an activity that it takes part in is in progress, and none of them has failed
//!                   down ─┴─ one of them has failed, and its alarm is not answered yet; or it is left out. A store is down only in
//!                          the second case: parts of other activities come and go as before
//!  of a part:       worked on, moved, or waiting: from its entering to its leaving it is one of the three
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use linewright_line::Tick;

use super::super::exception::{AlarmSubject, ExceptionStep, SensorMismatch, Whereabouts};
use super::super::ids::{FiringId, ModeId, PartId, ResourceId};
use super::super::production::{Production, ProductionChange};
use super::super::record::{ActivityFailure, Record, RecordKind};
use super::orders::OrdersReport;
use super::report::{Causes, CellSummary, ResourceReport};
use super::spread::Spread;
use super::{ModeEntry, PartFlow, ReportMetadata, ResourceEntry};

/// Report so far.
#[derive(Clone, Debug)]
pub struct Tracking {
    sheet: ReportMetadata,
    /// Nothing before this counts.
    from: Tick,
    began: Option<Tick>,
    now: Tick,
    open: BTreeMap<FiringId, OpenActivity>,
    resources: Vec<ResourceTally>,
    parts: BTreeMap<PartId, PartHistory>,
    left: Vec<PartHistory>,
    failures: u64,
    lost: u64,
    /// Resources that have a part by the model and none by their sensor, until somebody has put that right.
    missing: BTreeSet<ResourceId>,
    production: Production,
}

/// An activity in progress.
#[derive(Clone, Debug)]
struct OpenActivity {
    mode: ModeId,
    part: Option<PartId>,
    began: Tick,
    failed: Option<FailedSince>,
}

/// A failure that its alarm still asks about.
#[derive(Clone, Debug)]
struct FailedSince {
    at: Tick,
    cause: String,
    /// The resource of which a person has given alarm: it was counted there when the resource was left out.
    counted: Option<usize>,
}

impl FailedSince {
    /// Adds the failure to the causes of a resource that it has kept down for so long.
    fn add_to(&self, causes: &mut Causes, resource: usize, down: Duration) {
        match self.counted == Some(resource) {
            true => causes.go_on(&self.cause, down),
            false => causes.add(&self.cause, down),
        }
    }
}

/// Sums of a resource.
#[derive(Clone, Debug, Default)]
struct ResourceTally {
    /// Activities in progress that have not failed, and those that have.
    running: u32,
    failed: u32,
    busy: Duration,
    down: Duration,
    causes: Causes,
    /// Reason why it is left out, if it is.
    out: Option<String>,
    /// Of those in progress that have not failed, those that it works or carries in.
    working: u32,
    work: Duration,
    /// Positions taken, their integral over time, and their maximum.
    taken: u32,
    room: Duration,
    most: u32,
    /// Of work here that has ended: the nominal time, at most the actual one, and the actual one.
    nominal: Duration,
    actual: Duration,
    /// The parts of that: a part of which it does several steps is one.
    worked: BTreeSet<PartId>,
}

/// A part's way through the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartHistory {
    pub part: PartId,
    /// Its product, as a position in [`ReportMetadata::products`]; none if unknown.
    pub product: Option<usize>,
    pub entered: Tick,
    /// Time at which it left; none while it is inside.
    pub left: Option<Tick>,
    /// Time worked on, of activities that are over.
    pub worked: Duration,
    /// Time moved, of activities that are over.
    pub moved: Duration,
}

impl PartHistory {
    /// Time inside, and of that neither worked on nor moved; none while it is inside.
    pub fn lead_and_wait(&self) -> Option<(Duration, Duration)> {
        let lead = self.left?.since(self.entered);
        Some((lead, lead.saturating_sub(self.worked + self.moved)))
    }
}

impl Tracking {
    /// Nothing has happened yet.
    pub fn new(sheet: ReportMetadata) -> Self {
        Self::since(sheet, Tick::ZERO)
    }

    /// The same, without counting anything before a moment. Earlier records are needed as well.
    pub fn since(sheet: ReportMetadata, from: Tick) -> Self {
        let resources = vec![ResourceTally::default(); sheet.resources.len()];
        let production = Production::of_sheet(&sheet);
        Tracking {
            sheet,
            from,
            began: None,
            now: Tick::ZERO,
            open: BTreeMap::new(),
            resources,
            parts: BTreeMap::new(),
            left: Vec::new(),
            failures: 0,
            lost: 0,
            missing: BTreeSet::new(),
            production,
        }
    }

    /// The next record, in the order in which they were written.
    pub fn take(&mut self, record: &Record) {
        self.pass(record.at);
        // What does not fit is of an order that was accepted before the first record there is.
        _ = self.production.note(record);
        match &record.fact {
            RecordKind::Started { firing, mode, part, .. } => {
                self.open.insert(*firing, OpenActivity { mode: *mode, part: *part, began: record.at, failed: None });
                self.each(*mode, |tally| tally.running += 1);
                self.works(*mode, |working| working + 1);
                self.holds(*mode);
                self.enters(*mode, *part, record.at);
            }
            RecordKind::Raised { firing, cause } => self.fails(*firing, cause, record.at),
            RecordKind::Ended { firing } => self.ends(*firing, record.at),
            RecordKind::Fired { mode, part } => {
                self.holds(*mode);
                self.lets_go(*mode);
                self.enters(*mode, *part, record.at);
                self.leaves(*mode, *part, record.at);
            }
            RecordKind::Production { change: ProductionChange::Lost(part) } => {
                if self.parts.remove(part).is_some() {
                    self.lost += u64::from(record.at >= self.from);
                }
            }
            RecordKind::Production {
                change:
                    ProductionChange::Accepted { .. } | ProductionChange::Cancelled(_) | ProductionChange::Withdrawn(_),
            }
            | RecordKind::Epoch { .. }
            | RecordKind::Memory { .. }
            | RecordKind::Decided { .. }
            | RecordKind::Acknowledged { .. }
            | RecordKind::OrderEnded { .. }
            | RecordKind::OrderFailed { .. } => {}
            RecordKind::Exception(step) => self.excepts(step, record.at),
        }
    }

    /// Report until `now`, which no record is later than.
    pub fn report(&self, now: Tick) -> CellSummary {
        let mut until = self.clone();
        until.pass(now);
        for open in until.open.values() {
            if let (Some(failed), Some(entry)) = (&open.failed, until.sheet.modes.get(open.mode.index())) {
                for resource in until.sheet.kept_down(entry) {
                    let down = now.since(failed.at.max(self.from));
                    failed.add_to(&mut until.resources[resource].causes, resource, down);
                }
            }
        }
        let observed = until.began.map_or(Duration::ZERO, |began| now.since(began.max(self.from)));
        let mean = |room: Duration| if observed.is_zero() { 0.0 } else { room.as_secs_f64() / observed.as_secs_f64() };
        let resource = |(of, tally): (ResourceEntry, &ResourceTally)| ResourceReport {
            name: of.name,
            prototype: of.prototype,
            capacity: of.capacity,
            work: tally.work,
            taken: mean(tally.room),
            most: tally.most,
            busy: tally.busy,
            down: tally.down,
            causes: tally.causes.clone(),
            worked: tally.worked.len() as u64,
            nominal: tally.nominal,
            actual: tally.actual,
        };
        let missing = until.missing.len().min(until.parts.len());
        let times = until.left.iter().filter_map(PartHistory::lead_and_wait);
        let (lead, waited) = times.unzip();
        CellSummary {
            observed,
            resources: until.sheet.resources.iter().cloned().zip(&until.resources).map(resource).collect(),
            inside: until.parts.len() - missing,
            left: until.left.len(),
            lost: until.lost + missing as u64,
            failures: until.failures,
            orders: OrdersReport::of(self.production.orders(), self.from),
            lead: Spread::of(lead),
            worked: Spread::of(until.left.iter().map(|passage| passage.worked).collect()),
            moved: Spread::of(until.left.iter().map(|passage| passage.moved).collect()),
            waited: Spread::of(waited),
        }
    }

    /// The parts that have left, and those that are inside, each in its order.
    pub fn passages(&self) -> impl Iterator<Item = &PartHistory> {
        self.left.iter().chain(self.parts.values())
    }

    /// The production orders.
    pub fn production(&self) -> &Production {
        &self.production
    }

    /// Data of the cell.
    pub fn sheet(&self) -> &ReportMetadata {
        &self.sheet
    }

    /// Time passes: what is busy was busy, what is down was down.
    fn pass(&mut self, now: Tick) {
        self.began.get_or_insert(now);
        let gone = now.since(self.now.max(self.from));
        for tally in &mut self.resources {
            tally.work += gone * tally.working;
            tally.room += gone * tally.taken;
            if !gone.is_zero() {
                tally.most = tally.most.max(tally.taken);
            }
            if tally.failed > 0 {
                tally.down += gone;
            } else if let Some(cause) = &tally.out {
                tally.down += gone;
                tally.causes.go_on(cause, gone);
            } else if tally.running > 0 {
                tally.busy += gone;
            }
        }
        self.now = self.now.max(now);
    }

    fn each(&mut self, mode: ModeId, change: impl Fn(&mut ResourceTally)) {
        for &resource in self.sheet.entry(mode).map(|entry| &entry.resources[..]).unwrap_or_default() {
            change(&mut self.resources[resource]);
        }
    }

    /// The worker or carrier of a mode takes part in more activities, or in fewer.
    fn works(&mut self, mode: ModeId, change: impl Fn(u32) -> u32) {
        let Some(entry) = self.sheet.modes.get(mode.index()) else { return };
        for resource in [entry.worker, entry.carrier].into_iter().flatten() {
            self.resources[resource].working = change(self.resources[resource].working);
        }
    }

    /// Room for the part is taken where it goes.
    fn holds(&mut self, mode: ModeId) {
        if let Some(target) = self.sheet.entry(mode).and_then(|entry| entry.target) {
            self.resources[target].taken += 1;
        }
    }

    /// Room for the part is free where it was.
    fn lets_go(&mut self, mode: ModeId) {
        if let Some(source) = self.sheet.entry(mode).and_then(|entry| entry.source) {
            let taken = &mut self.resources[source].taken;
            *taken = taken.saturating_sub(1);
        }
    }

    fn fails(&mut self, firing: FiringId, cause: &ActivityFailure, at: Tick) {
        let Some(open) = self.open.get_mut(&firing) else { return };
        // An alarm given by hand leaves its resource out first, with its text: one event, one cause.
        let counted = match cause {
            ActivityFailure::ByHand { resource } => Some(resource.index()),
            ActivityFailure::TimedOut | ActivityFailure::Order { .. } => None,
        };
        let text = counted.and_then(|of| self.resources.get(of)?.out.clone());
        let counted = counted.filter(|_| text.is_some());
        open.failed = Some(FailedSince { at, cause: text.unwrap_or_else(|| cause.summary()), counted });
        let mode = open.mode;
        self.failures += u64::from(at >= self.from);
        self.works(mode, |working| working - 1);
        self.each(mode, |tally| tally.running -= 1);
        for resource in self.sheet.entry(mode).into_iter().flat_map(|entry| self.sheet.kept_down(entry)) {
            self.resources[resource].failed += 1;
        }
    }

    /// A failed activity is over, or a resource is left out.
    fn excepts(&mut self, step: &ExceptionStep, at: Tick) {
        match step {
            ExceptionStep::Closed { firing, mode, part, ruling, unchecked: _ } => match ruling.part {
                Whereabouts::To => self.ends(*firing, at),
                Whereabouts::From | Whereabouts::Carrier | Whereabouts::Gone => {
                    self.stops(*firing, at);
                    self.is_undone(*mode, ruling.part == Whereabouts::Gone);
                    let is_gone = ruling.part == Whereabouts::Gone;
                    let enters = self.sheet.entry(*mode).is_some_and(|entry| entry.passing == PartFlow::Enters);
                    // One that has not come in is outside as before, and not lost.
                    let is_outside = part.filter(|_| enters || is_gone);
                    if is_outside.is_some_and(|part| self.parts.remove(&part).is_some()) && is_gone {
                        self.lost += u64::from(at >= self.from);
                    }
                }
            },
            ExceptionStep::Mismatch { about: AlarmSubject::Resource(resource), found } => {
                let is_missing = |of: &SensorMismatch| of.resource == *resource && of.model && !of.plant;
                match found.iter().any(is_missing) {
                    true => self.missing.insert(*resource),
                    false => self.missing.remove(resource),
                };
            }
            ExceptionStep::Missing { resource, mode, part } => {
                self.missing.remove(resource);
                self.lets_go(*mode);
                if self.parts.remove(part).is_some() {
                    self.lost += u64::from(at >= self.from);
                }
            }
            ExceptionStep::Down { resource, why, activity: _ } => {
                if let Some(tally) = self.resources.get_mut(resource.index()) {
                    let cause = why.summary();
                    if at >= self.from {
                        tally.causes.add(&cause, Duration::ZERO);
                    }
                    tally.out = Some(cause);
                }
            }
            ExceptionStep::Up { resource, unchecked: _ } => {
                self.missing.remove(resource);
                self.resources.get_mut(resource.index()).into_iter().for_each(|tally| tally.out = None);
            }
            step => debug_assert!(!step.changes_the_cell(), "{step:?}"),
        }
    }

    /// Room where the part was to go is free; where it was only if it is no more.
    fn is_undone(&mut self, mode: ModeId, is_gone: bool) {
        if let Some(target) = self.sheet.entry(mode).and_then(|entry| entry.target) {
            let taken = &mut self.resources[target].taken;
            *taken = taken.saturating_sub(1);
        }
        if is_gone {
            self.lets_go(mode);
        }
    }

    /// Its resources are not busy with an activity any more, nor down by it.
    fn stops(&mut self, firing: FiringId, at: Tick) -> Option<OpenActivity> {
        let open = self.open.remove(&firing)?;
        let (from, counts) = (self.from, at >= self.from);
        match &open.failed {
            None => {
                self.works(open.mode, |working| working - 1);
                self.each(open.mode, |tally| tally.running -= 1);
            }
            Some(failed) => {
                for resource in self.sheet.entry(open.mode).into_iter().flat_map(|entry| self.sheet.kept_down(entry)) {
                    let tally = &mut self.resources[resource];
                    tally.failed -= 1;
                    if counts {
                        failed.add_to(&mut tally.causes, resource, at.since(failed.at.max(from)));
                    }
                }
            }
        }
        Some(open)
    }

    fn ends(&mut self, firing: FiringId, at: Tick) {
        let Some(open) = self.stops(firing, at) else { return };
        let (took, counts) = (at.since(open.began), at >= self.from);
        self.lets_go(open.mode);
        let Some(ModeEntry { worker, nominal, .. }) = self.sheet.modes.get(open.mode.index()) else { return };
        if let Some(worker) = worker.filter(|_| counts) {
            let tally = &mut self.resources[worker];
            tally.worked.extend(open.part);
            // Each part for itself: one that was faster makes up for no other.
            tally.nominal += took.min(*nominal);
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
            && self.sheet.entry(mode).is_some_and(|entry| entry.passing == PartFlow::Enters)
        {
            let product = self.sheet.entry(mode).and_then(|entry| entry.product);
            let (worked, moved) = (Duration::ZERO, Duration::ZERO);
            self.parts.insert(part, PartHistory { part, product, entered: at, left: None, worked, moved });
        }
    }

    fn leaves(&mut self, mode: ModeId, part: Option<PartId>, at: Tick) {
        let leaves = self.sheet.entry(mode).is_some_and(|entry| entry.passing == PartFlow::Leaves);
        let passage = part.filter(|_| leaves).and_then(|part| self.parts.remove(&part));
        self.left.extend(passage.filter(|_| at >= self.from).map(|passage| PartHistory { left: Some(at), ..passage }));
    }
}
