//! What came out of a simulation of a cell, from its records: parts, activities, and how busy resources were.

use std::collections::BTreeMap;

use linewright_cell::net::Origin;
use linewright_cell::{Activity, Cell, PartTypeId, ResourceId, Role};
use linewright_coordinator_logic::cell::{Fact, FiringId, ModeId, PartId, Record};
use linewright_coordinator_logic::described::Described;
use linewright_line::Tick;
use linewright_nets::TransitionId;

/// A part.
pub struct Part {
    /// Its number.
    pub id: PartId,
    /// Of which type it is.
    pub of: PartTypeId,
    /// When it came.
    pub entered: Tick,
    /// When it left, finished; none if it is still there.
    pub done: Option<Tick>,
}

/// An activity that took time, or that is still in progress.
pub struct Done {
    /// Its mode.
    pub mode: ModeId,
    /// With which part.
    pub part: Option<PartId>,
    /// When it started.
    pub began: Tick,
    /// When it ended.
    pub ended: Option<Tick>,
}

/// What a resource did.
#[derive(Clone, Default)]
pub struct Use {
    /// For how long it worked on or carried parts, in seconds, those at once added up.
    pub busy_s: f64,
    /// How much of it was taken, times for how long, in seconds.
    taken_s: f64,
    taken: u32,
    since: Tick,
    /// How much of it was taken at most.
    pub most: u32,
}

impl Use {
    fn take(&mut self, at: Tick, more: i64) {
        self.taken_s += f64::from(self.taken) * at.since(self.since).as_secs_f64();
        self.since = at;
        self.taken = u32::try_from(i64::from(self.taken) + more).unwrap_or(0);
        self.most = self.most.max(self.taken);
    }
}

/// All of it.
pub struct Made {
    /// In the order in which they came.
    pub parts: Vec<Part>,
    /// In the order in which they started.
    pub activities: Vec<Done>,
    /// By resource.
    pub uses: Vec<Use>,
    /// When the last part left, or the last thing happened.
    pub end: Tick,
}

impl Made {
    /// What records say.
    pub fn new(cell: &Cell, played: &Described, records: &[Record]) -> Self {
        let end = records.last().map_or(Tick::ZERO, |record| record.at);
        let mut made =
            Made { parts: Vec::new(), activities: Vec::new(), uses: vec![Use::default(); cell.resources.len()], end };
        let mut running: BTreeMap<FiringId, usize> = BTreeMap::new();
        for record in records {
            let at = record.at;
            match &record.fact {
                &Fact::Started { firing, mode, part, .. } => {
                    running.insert(firing, made.activities.len());
                    made.activities.push(Done { mode, part, began: at, ended: None });
                    made.start(cell, played, at, mode, part);
                }
                Fact::Ended { firing } => {
                    let Some(done) = running.remove(firing).map(|index| &mut made.activities[index]) else { continue };
                    done.ended = Some(at);
                    let (mode, part, began) = (done.mode, done.part, done.began);
                    made.end(cell, played, at, mode, part, at.since(began).as_secs_f64());
                }
                Fact::Fired { .. }
                | Fact::Epoch { .. }
                | Fact::Memory { .. }
                | Fact::Decided { .. }
                | Fact::Acknowledged { .. }
                | Fact::OrderEnded { .. }
                | Fact::OrderFailed { .. }
                | Fact::Raised { .. }
                | Fact::Production { .. } => (),
            }
        }
        made.uses.iter_mut().for_each(|of| of.take(end, 0));
        // What takes no time is no bar in a chart, and nothing that anybody does.
        made.activities.retain(|done| done.ended != Some(done.began));
        made
    }

    fn start(&mut self, cell: &Cell, played: &Described, at: Tick, mode: ModeId, part: Option<PartId>) {
        if let Some(target) = activity(cell, played, mode).and_then(|of| resource(of, Role::Target)) {
            self.uses[target.index()].take(at, 1);
        }
        let enters = played.table.part_in(mode).is_none();
        if let Some((id, of)) = part.filter(|_| enters).zip(part_type(cell, played, mode)) {
            self.parts.push(Part { id, of, entered: at, done: None });
        }
    }

    fn end(&mut self, cell: &Cell, played: &Described, at: Tick, mode: ModeId, part: Option<PartId>, took_s: f64) {
        let Some(of) = activity(cell, played, mode) else { return };
        if let Some(source) = resource(of, Role::Source) {
            self.uses[source.index()].take(at, -1);
        }
        for role in [Role::Worker, Role::Carrier] {
            resource(of, role).into_iter().for_each(|id| self.uses[id.index()].busy_s += took_s);
        }
        if played.table.part_out(mode).is_none()
            && let Some(part) = self.parts.iter_mut().rev().find(|known| Some(known.id) == part)
        {
            part.done = Some(at);
        }
    }

    /// How much of the time a resource worked or carried, of what it could at once.
    pub fn busy(&self, cell: &Cell, id: ResourceId) -> f64 {
        let could = self.end.since(Tick::ZERO).as_secs_f64() * f64::from(cell.resource(id).capacity.max(1));
        if could > 0.0 { self.uses[id.index()].busy_s / could } else { 0.0 }
    }

    /// How much of a resource was taken in the mean.
    pub fn taken(&self, id: ResourceId) -> f64 {
        let all = self.end.since(Tick::ZERO).as_secs_f64();
        if all > 0.0 { self.uses[id.index()].taken_s / all } else { 0.0 }
    }
}

/// The activity that a mode is, by the net it comes from.
fn activity<'c>(cell: &'c Cell, played: &Described, mode: ModeId) -> Option<&'c Activity> {
    match played.net.origin(played.long.mode(TransitionId(mode.0)).transition) {
        Origin::Activity { id, .. } => Some(cell.activity(id)),
        Origin::Shift => None,
    }
}

fn part_type(cell: &Cell, played: &Described, mode: ModeId) -> Option<PartTypeId> {
    let (_, of) = played.net.move_of(cell, played.long.mode(TransitionId(mode.0)))?;
    Some(cell.stages[of.to.index()].part_type)
}

fn resource(activity: &Activity, role: Role) -> Option<ResourceId> {
    activity.used(role).and_then(|part| part.of)
}
