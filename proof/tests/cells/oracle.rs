//! A cell played with parts in places: slow, obvious, and without a net.
//!
//! It reads the checked description only: the parts of each resource, their stages, their order where that matters.
//! Possible steps follow from the contents of machines, stores and hands; capacities are counted, not tokens.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

use linewright_cell::{
    Activity, ActivityKind, Cell, Prototype, ResourceAction, ResourceId, Role, StageId, StageMove, Staying, Use,
};

/// Content of a resource.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Inside {
    /// Each part with whether it has been worked on; sorted.
    Machine(Vec<(StageId, bool)>),
    /// Sorted.
    Store(Vec<StageId>),
    /// By position, from where parts come in.
    Row(Vec<Option<StageId>>),
    /// The last one is on top.
    Stack(Vec<StageId>),
    Nothing,
}

/// State of the whole cell at a moment.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Moment {
    inside: Vec<Inside>,
    /// Parts that were grasped and not put yet: by which activity, and in which stage; sorted.
    held: Vec<(usize, StageId)>,
}

/// Result of playing with up to so many parts at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Played {
    pub moments: usize,
    pub steps: usize,
    /// In some moment parts are inside and nothing can be done but let others come; the steps to the first of them.
    pub stuck: Option<usize>,
    /// From every moment the cell can become empty.
    pub empties: bool,
}

struct Player<'c> {
    cell: &'c Cell,
    parts: usize,
}

/// Plays with up to so many parts at a time; none if that has more than `limit` moments.
pub fn play(cell: &Cell, parts: u32, limit: usize) -> Option<Played> {
    let player = Player { cell, parts: parts as usize };
    let first = player.empty();
    let mut numbers: HashMap<Moment, usize> = HashMap::from([(first.clone(), 0)]);
    let mut distance = vec![0];
    let mut before: Vec<Vec<usize>> = vec![Vec::new()];
    let mut queue = VecDeque::from([first]);
    let (mut next, mut steps, mut stuck) = (0, 0, None);
    while let Some(moment) = queue.pop_front() {
        let following = player.steps(&moment);
        steps += following.len();
        // Parts grasped outside have come already.
        let only_coming = following.keys().all(|(activity, (_, how))| match activity {
            Some(id) => cell.activities[*id].kind == ActivityKind::Enter && how % 2 == 0,
            None => false,
        });
        if only_coming && player.count(&moment) > 0 {
            stuck = stuck.or(Some(distance[next]));
        }
        for (_, after) in following {
            let number = match numbers.get(&after) {
                Some(&number) => number,
                None => {
                    let number = numbers.len();
                    if number == limit {
                        return None;
                    }
                    numbers.insert(after.clone(), number);
                    distance.push(distance[next] + 1);
                    before.push(Vec::new());
                    queue.push_back(after);
                    number
                }
            };
            before[number].push(next);
        }
        next += 1;
    }
    let mut leads_back = vec![false; numbers.len()];
    let mut open = vec![0];
    leads_back[0] = true;
    while let Some(at) = open.pop() {
        for &earlier in &before[at] {
            if !std::mem::replace(&mut leads_back[earlier], true) {
                open.push(earlier);
            }
        }
    }
    Some(Played { moments: numbers.len(), steps, stuck, empties: leads_back.into_iter().all(|back| back) })
}

/// Label of a step: activity (none for a part that moves up) and stage; for a row, position.
type Label = (Option<usize>, (StageId, usize));

impl Player<'_> {
    fn empty(&self) -> Moment {
        let inside = |resource: &linewright_cell::Resource| match resource.prototype {
            Prototype::Machine | Prototype::Human => Inside::Machine(Vec::new()),
            Prototype::RandomAccessStore => Inside::Store(Vec::new()),
            Prototype::FifoBuffer => Inside::Row(vec![None; resource.capacity as usize]),
            Prototype::LifoBuffer => Inside::Stack(Vec::new()),
            Prototype::Robot | Prototype::Conveyor => Inside::Nothing,
        };
        Moment { inside: self.cell.resources.iter().map(inside).collect(), held: Vec::new() }
    }

    fn count(&self, moment: &Moment) -> usize {
        let inside = moment.inside.iter().map(|inside| match inside {
            Inside::Machine(parts) => parts.len(),
            Inside::Store(parts) | Inside::Stack(parts) => parts.len(),
            Inside::Row(at) => at.iter().flatten().count(),
            Inside::Nothing => 0,
        });
        inside.sum::<usize>() + moment.held.len()
    }

    fn steps(&self, moment: &Moment) -> BTreeMap<Label, Moment> {
        let mut found = BTreeMap::new();
        for (number, activity) in self.cell.activities.iter().enumerate() {
            for of in &activity.moves {
                for (how, after) in self.done(number, activity, of, moment) {
                    // The stage distinguishes modes of one activity, unless it turns one stage into different ones.
                    let label = (Some(number), (of.from, (usize::from(of.to.0) << 1) | how));
                    found.insert(label, after);
                }
            }
        }
        for (number, inside) in moment.inside.iter().enumerate() {
            if let Inside::Row(at) = inside {
                for i in 1..at.len() {
                    if let (Some(stage), None) = (at[i - 1], at[i]) {
                        let mut after = moment.clone();
                        let mut at = at.clone();
                        at.swap(i - 1, i);
                        after.inside[number] = Inside::Row(at);
                        found.insert((None, (stage, number * 1000 + i)), after);
                    }
                }
            }
        }
        found
    }

    /// Steps of an activity with a stage: all in one, or grasping (0) and putting (1).
    fn done(&self, number: usize, activity: &Activity, of: &StageMove, moment: &Moment) -> Vec<(usize, Moment)> {
        let used = |role: Role| activity.used(role);
        if let Some(worker) = used(Role::Worker).and_then(|part| part.of) {
            let Inside::Machine(parts) = &moment.inside[worker.index()] else { return Vec::new() };
            if self.cell.resource(worker).prototype == Prototype::Human && self.hands_free(moment, worker) == 0 {
                return Vec::new();
            }
            // It has been loaded for this, or it stays after work before.
            let ways = [(false, of.stays != Staying::Must), (true, of.stays != Staying::No)];
            let can_be = ways.into_iter().filter(|(_, can_be)| *can_be).map(|(was_worked_on, _)| was_worked_on);
            let begun = can_be.filter_map(|was_worked_on| {
                let at = parts.iter().position(|part| *part == (of.from, was_worked_on))?;
                let mut parts = parts.clone();
                parts[at] = (of.to, true);
                parts.sort();
                Some((usize::from(was_worked_on), with(moment, worker, Inside::Machine(parts))))
            });
            return begun.collect();
        }
        let (Some(source), Some(target)) = (used(Role::Source), used(Role::Target)) else { return Vec::new() };
        let carrier = used(Role::Carrier).and_then(|part| part.of);
        let free = carrier.is_none_or(|carrier| self.hands_free(moment, carrier) > 0);
        if self.cell.limits.reserve || carrier.is_none() {
            let taken = self.taken(moment, source, of.from).filter(|_| free);
            let put = taken.and_then(|taken| self.put(&taken, target, of.to));
            return put.map(|after| (0, after)).into_iter().collect();
        }
        let mut found = Vec::new();
        if let Some(mut taken) = self.taken(moment, source, of.from).filter(|_| free) {
            taken.held.push((number, of.from));
            taken.held.sort();
            found.push((0, taken));
        }
        if let Some(at) = moment.held.iter().position(|held| *held == (number, of.from)) {
            let mut without = moment.clone();
            without.held.remove(at);
            found.extend(self.put(&without, target, of.to).map(|after| (1, after)));
        }
        found
    }

    /// Number of further parts that a carrier can take.
    fn hands_free(&self, moment: &Moment, carrier: ResourceId) -> usize {
        let of = |number: usize| self.cell.activities[number].used(Role::Carrier).and_then(|part| part.of);
        let holds = moment.held.iter().filter(|(number, _)| of(*number) == Some(carrier)).count();
        let resource = self.cell.resource(carrier);
        let hands = if resource.prototype == Prototype::Conveyor { resource.capacity as usize } else { 1 };
        hands - holds
    }

    fn taken(&self, moment: &Moment, source: Use, stage: StageId) -> Option<Moment> {
        let Some(id) = source.of else { return (self.count(moment) < self.parts).then(|| moment.clone()) };
        let without = |parts: &[StageId]| {
            let at = parts.iter().position(|part| *part == stage)?;
            let mut parts = parts.to_vec();
            parts.remove(at);
            Some(parts)
        };
        let left = match (&moment.inside[id.index()], source.action) {
            (Inside::Machine(parts), ResourceAction::Unload) => {
                let at = parts.iter().position(|part| *part == (stage, true))?;
                let mut parts = parts.clone();
                parts.remove(at);
                Inside::Machine(parts)
            }
            (Inside::Store(parts), ResourceAction::Retrieve) => Inside::Store(without(parts)?),
            (Inside::Row(at), ResourceAction::Retrieve) => {
                let mut at = at.clone();
                at.pop_if(|last| *last == Some(stage))?;
                at.push(None);
                Inside::Row(at)
            }
            (Inside::Stack(parts), ResourceAction::Retrieve) => {
                let mut parts = parts.clone();
                parts.pop_if(|last| *last == stage)?;
                Inside::Stack(parts)
            }
            other => panic!("nothing can be taken: {other:?}"),
        };
        Some(with(moment, id, left))
    }

    fn put(&self, moment: &Moment, target: Use, stage: StageId) -> Option<Moment> {
        let Some(id) = target.of else { return Some(moment.clone()) };
        let room = self.cell.resource(id).capacity as usize;
        let full = match (&moment.inside[id.index()], target.action) {
            (Inside::Machine(parts), ResourceAction::Load) if parts.len() < room => {
                Inside::Machine(sorted(parts, (stage, false)))
            }
            (Inside::Store(parts), ResourceAction::Store) if parts.len() < room => Inside::Store(sorted(parts, stage)),
            (Inside::Row(at), ResourceAction::Store) if at[0].is_none() => {
                let mut at = at.clone();
                at[0] = Some(stage);
                Inside::Row(at)
            }
            (Inside::Stack(parts), ResourceAction::Store) if parts.len() < room => {
                let mut parts = parts.clone();
                parts.push(stage);
                Inside::Stack(parts)
            }
            _ => return None,
        };
        Some(with(moment, id, full))
    }
}

fn sorted<T: Clone + Ord>(parts: &[T], new: T) -> Vec<T> {
    let mut parts = parts.to_vec();
    parts.push(new);
    parts.sort();
    parts
}

fn with(moment: &Moment, id: ResourceId, inside: Inside) -> Moment {
    let mut after = moment.clone();
    after.inside[id.index()] = inside;
    after
}

/// The resources that anything is done with, in as many groups as have nothing in common.
pub fn groups(cell: &Cell) -> usize {
    let mut groups: Vec<BTreeSet<ResourceId>> = Vec::new();
    for activity in cell.activities.iter().filter(|activity| !activity.moves.is_empty()) {
        let mut own: BTreeSet<ResourceId> = activity.uses.iter().filter_map(|part| part.of).collect();
        groups.retain(|group| {
            let apart = group.is_disjoint(&own);
            if !apart {
                own.extend(group);
            }
            apart
        });
        groups.push(own);
    }
    groups.len()
}
