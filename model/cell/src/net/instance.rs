//! A resource as a net: the places of its prototype, and a port for each transition it takes part in.
//!
//! What an action takes when it begins and gives when it ends stands here and nowhere else. The capacity of where a part
//! comes from returns when the activity ends: the work position stays reserved until it is unloaded (seed 000, L1500).

use linewright_nets::coloured::{
    BasicId, ColouredBuilder, ColouredError, ColouredNet, Comparison, Domain, Function, Guard, Operand, abs, colour,
    compare, component, id, proj, succ,
};
use linewright_nets::{PlaceId, TransitionId};

use super::pieces::{Piece, Progress};
use super::{Meaning, OUTSIDE, RUNNING, STAGES, Spot, Supply};
use crate::{Action, Cell, Prototype, Resource, ResourceId, Role, StageId, Use};

/// How places end that keep a stage from being moved twice at a time.
const IDLE: &str = ".idle";

/// A net, and what each of its places stands for.
type Built = Result<(ColouredNet, Vec<Meaning>), Vec<ColouredError>>;

/// The places of a resource.
enum Places {
    /// available-capacity, loaded, unload-ready; and the token of a human.
    Machine { capacity: PlaceId, loaded: PlaceId, ready: PlaceId, free: Option<PlaceId> },
    /// available-capacity, stored-parts.
    Store { capacity: PlaceId, stored: PlaceId },
    /// free and at, by position.
    Row { free: Vec<PlaceId>, at: Vec<PlaceId> },
    /// The first free level, and what is on each. Levels are a domain of their own.
    Stack { level: BasicId, top: PlaceId, at: PlaceId, height: u32 },
    /// How many parts can still be carried.
    Carrier { free: PlaceId },
    /// Parts that have not come yet, where they are counted; where they go when they leave; how many may come.
    Outside { waiting: Option<PlaceId>, back: Option<PlaceId>, room: PlaceId },
}

/// The domain of stages, with their names.
fn stages(b: &mut ColouredBuilder, cell: &Cell) -> BasicId {
    b.named_basic(STAGES, cell.stages.iter().map(|stage| stage.name.as_str()))
}

/// The tone of a stage.
fn tone(stage: StageId) -> u32 {
    u32::from(stage.0) + 1
}

/// The domain of a stack's levels: as many as parts, and one for when it is full.
fn levels(b: &mut ColouredBuilder, resource: &Resource) -> BasicId {
    b.basic(format!("{} level", resource.name), resource.capacity + 1)
}

/// A resource, with a port for each piece it takes part in.
pub(super) fn resource(cell: &Cell, of: ResourceId, pieces: &[Piece]) -> Built {
    let resource = cell.resource(of);
    let mut b = ColouredBuilder::new(&resource.name);
    let s = stages(&mut b, cell);
    let places = places(&mut b, resource, s);
    for piece in pieces {
        port(&mut b, Some(of), piece, &places, s);
    }
    if let Places::Row { free, at } = &places {
        for i in 1..at.len() {
            let shift = b.transition(format!("shift {i}"), s);
            b.input(shift, at[i - 1], id()).input(shift, free[i], abs());
            b.output(shift, at[i], id()).output(shift, free[i - 1], abs());
        }
    }
    Ok((b.build()?, places.meanings(Some(of))))
}

/// The outside: where parts come from and go to.
pub(super) fn outside(cell: &Cell, supply: Supply<'_>, pieces: &[Piece]) -> Built {
    let mut b = ColouredBuilder::new(OUTSIDE);
    let s = stages(&mut b, cell);
    let mut waiting = |counts: &[u32]| {
        let place = b.place("waiting", s);
        for (part, &count) in cell.part_types.iter().zip(counts) {
            b.tokens(place, &[tone(part.new_stage())], count);
        }
        Some(place)
    };
    let (waiting, returns) = match supply {
        Supply::Open => (None, false),
        Supply::Closed(counts) => (waiting(counts), true),
        Supply::Batch(counts) => (waiting(counts), false),
    };
    let room = b.place("room", Domain::Uncoloured);
    b.tokens(room, &[], cell.limits.wip_max);
    let places = Places::Outside { waiting, back: waiting.filter(|_| returns), room };
    for piece in pieces {
        port(&mut b, None, piece, &places, s);
    }
    Ok((b.build()?, places.meanings(None)))
}

/// What is in progress; none if nothing ever is.
pub(super) fn running(cell: &Cell, pieces: &[Piece]) -> Option<Built> {
    pieces.iter().find(|piece| piece.from.is_some() || piece.to.is_some())?;
    let mut b = ColouredBuilder::new(RUNNING);
    let s = stages(&mut b, cell);
    let mut stacks: Vec<Option<BasicId>> = vec![None; cell.resources.len()];
    let mut known: Vec<(String, PlaceId)> = Vec::new();
    let mut meanings = Vec::new();
    for piece in pieces.iter().filter(|piece| piece.from.is_some() || piece.to.is_some()) {
        // What is held while neither action is in progress carries no level; the levels of the piece are its own.
        let mut domain_of = |progress: &Progress, b: &mut ColouredBuilder| -> Vec<BasicId> {
            let mut domain = vec![s];
            for held in progress.uses.iter().filter_map(|part| part.of) {
                let resource = cell.resource(held);
                if resource.prototype == Prototype::LifoBuffer {
                    domain.push(*stacks[held.index()].get_or_insert_with(|| levels(b, resource)));
                }
            }
            domain
        };
        let sides = [&piece.from, &piece.to].map(|side| side.as_ref().map(|side| (side, domain_of(side, &mut b))));
        let widest = sides.iter().flatten().map(|(_, domain)| domain).max_by_key(|domain| domain.len());
        let domain = widest.cloned().unwrap_or_else(|| vec![s]);
        let t = b.transition(&*piece.name, domain.clone());
        for (input, side) in [true, false].into_iter().zip(&sides) {
            let Some((progress, own)) = side else { continue };
            let place = known.iter().find(|(name, _)| *name == progress.place).map(|(_, place)| *place);
            let place = place.unwrap_or_else(|| {
                let place = b.place(&*progress.place, own.clone());
                known.push((progress.place.clone(), place));
                // Between grasping and putting no action of an end is in progress.
                meanings.push(Meaning::Busy { activity: piece.activity, is_held: progress.uses.is_empty() });
                place
            });
            let function = if own.len() == domain.len() { id() } else { proj([1]) };
            if input {
                b.input(t, place, function)
            } else {
                b.output(t, place, function)
            };
        }
        if serve(&mut b, piece, t, s, &mut known) {
            meanings.push(Meaning::Idle(piece.activity));
        }
    }
    Some(b.build().map(|net| (net, meanings)))
}

/// A token for each stage that an activity can move at a time; whether its place is a new one.
fn serve(
    b: &mut ColouredBuilder,
    piece: &Piece,
    t: TransitionId,
    s: BasicId,
    known: &mut Vec<(String, PlaceId)>,
) -> bool {
    let Some((variant, begins)) = &piece.server else { return false };
    let name = format!("{variant}{IDLE}");
    let before = known.len();
    let place = known.iter().find(|(known, _)| *known == name).map(|(_, place)| *place).unwrap_or_else(|| {
        let place = b.place(&*name, s);
        for &stage in piece.allowed.iter().flatten() {
            b.tokens(place, &[tone(stage)], 1);
        }
        known.push((name, place));
        place
    });
    if *begins {
        b.input(t, place, proj([1]))
    } else {
        b.output(t, place, proj([1]))
    };
    known.len() > before
}

impl Places {
    /// What each place stands for, in the order of the places.
    fn meanings(&self, of: Option<ResourceId>) -> Vec<Meaning> {
        let mut all: Vec<(PlaceId, Meaning)> = Vec::new();
        match (self, of) {
            (Places::Machine { capacity, loaded, ready, free }, Some(of)) => {
                all.extend([
                    (*capacity, Meaning::Room(of)),
                    (*loaded, Meaning::Held(of, Spot::Loaded)),
                    (*ready, Meaning::Held(of, Spot::Ready)),
                ]);
                all.extend(free.map(|free| (free, Meaning::Free(of))));
            }
            (Places::Store { capacity, stored }, Some(of)) => {
                all.extend([(*capacity, Meaning::Room(of)), (*stored, Meaning::Held(of, Spot::Stored))]);
            }
            (Places::Row { free, at }, Some(of)) => {
                all.extend((1..).zip(free).map(|(i, &free)| (free, Meaning::Position(of, i))));
                all.extend((1..).zip(at).map(|(i, &at)| (at, Meaning::Held(of, Spot::Position(i)))));
            }
            (Places::Stack { top, at, .. }, Some(of)) => {
                all.extend([(*top, Meaning::Top(of)), (*at, Meaning::Held(of, Spot::Stored))]);
            }
            (Places::Carrier { free }, Some(of)) => all.push((*free, Meaning::Free(of))),
            (Places::Outside { waiting, room, .. }, _) => {
                all.extend(waiting.map(|waiting| (waiting, Meaning::Waiting)));
                all.push((*room, Meaning::Admission));
            }
            // Only the outside is nobody's.
            (
                Places::Machine { .. }
                | Places::Store { .. }
                | Places::Row { .. }
                | Places::Stack { .. }
                | Places::Carrier { .. },
                None,
            ) => {}
        }
        all.sort_by_key(|(place, _)| place.index());
        all.into_iter().map(|(_, meaning)| meaning).collect()
    }
}

fn places(b: &mut ColouredBuilder, resource: &Resource, s: BasicId) -> Places {
    let n = resource.capacity;
    let tokens = |b: &mut ColouredBuilder, name: &str, count| {
        let place = b.place(name, Domain::Uncoloured);
        b.tokens(place, &[], count);
        place
    };
    match resource.prototype {
        Prototype::Machine | Prototype::Human => Places::Machine {
            capacity: tokens(b, "available-capacity", n),
            loaded: b.place("loaded", s),
            ready: b.place("unload-ready", s),
            free: (resource.prototype == Prototype::Human).then(|| tokens(b, "free", 1)),
        },
        Prototype::RandomAccessStore => {
            Places::Store { capacity: tokens(b, "available-capacity", n), stored: b.place("stored-parts", s) }
        }
        Prototype::FifoBuffer => Places::Row {
            free: (1..=n).map(|i| tokens(b, &format!("free {i}"), 1)).collect(),
            at: (1..=n).map(|i| b.place(format!("at {i}"), s)).collect(),
        },
        Prototype::LifoBuffer => {
            let level = levels(b, resource);
            let (top, at) = (b.place("top", level), b.place("at", [s, level]));
            b.tokens(top, &[1], 1);
            Places::Stack { level, top, at, height: n }
        }
        Prototype::Robot => Places::Carrier { free: tokens(b, "free", 1) },
        Prototype::Conveyor => Places::Carrier { free: tokens(b, "room", n) },
    }
}

/// What an action takes when it begins and gives when it ends, as functions of a mode of stages (and levels). `moved` is
/// the stage afterwards.
fn arcs(places: &Places, action: Action, moved: Function) -> [Vec<(PlaceId, Function)>; 2] {
    match (places, action) {
        (Places::Machine { capacity, loaded, .. }, Action::Load) => [vec![(*capacity, abs())], vec![(*loaded, moved)]],
        (Places::Machine { loaded, ready, free, .. }, Action::Process) => {
            let attention = || free.iter().map(|free| (*free, abs()));
            [
                std::iter::once((*loaded, id())).chain(attention()).collect(),
                std::iter::once((*ready, moved)).chain(attention()).collect(),
            ]
        }
        (Places::Machine { capacity, ready, .. }, Action::Unload) => [vec![(*ready, id())], vec![(*capacity, abs())]],
        (Places::Machine { free: Some(free), .. } | Places::Carrier { free }, Action::PickAndPlace) => {
            [vec![(*free, abs())], vec![(*free, abs())]]
        }
        (Places::Store { capacity, stored }, Action::Store) => [vec![(*capacity, abs())], vec![(*stored, moved)]],
        (Places::Store { capacity, stored }, Action::Retrieve) => [vec![(*stored, id())], vec![(*capacity, abs())]],
        (Places::Row { free, at }, Action::Store) => [vec![(free[0], abs())], vec![(at[0], moved)]],
        (Places::Row { free, at }, Action::Retrieve) => {
            let last = at.len() - 1;
            [vec![(at[last], id())], vec![(free[last], abs())]]
        }
        // The mode has the level of the part; the stack's top is one higher while it is there.
        (Places::Stack { top, at, .. }, Action::Store) => {
            [vec![(*top, proj([2]))], vec![(*at, id()), (*top, proj([2]).of(succ(2, 1)))]]
        }
        (Places::Stack { top, at, .. }, Action::Retrieve) => {
            [vec![(*at, id()), (*top, proj([2]).of(succ(2, 1)))], vec![(*top, proj([2]))]]
        }
        (Places::Outside { waiting, room, .. }, Action::In) => {
            [waiting.iter().map(|waiting| (*waiting, id())).chain([(*room, abs())]).collect(), Vec::new()]
        }
        (Places::Outside { back, room, .. }, Action::Out) => {
            [Vec::new(), back.iter().map(|back| (*back, moved.clone())).chain([(*room, abs())]).collect()]
        }
        // No prototype has these, so no description can name them.
        (
            Places::Machine { .. },
            Action::PickAndPlace | Action::Store | Action::Retrieve | Action::In | Action::Out,
        )
        | (
            Places::Store { .. } | Places::Row { .. } | Places::Stack { .. },
            Action::Load | Action::Process | Action::Unload | Action::PickAndPlace | Action::In | Action::Out,
        )
        | (
            Places::Carrier { .. },
            Action::Load
            | Action::Process
            | Action::Unload
            | Action::Store
            | Action::Retrieve
            | Action::In
            | Action::Out,
        )
        | (
            Places::Outside { .. },
            Action::Load | Action::Process | Action::Unload | Action::Store | Action::Retrieve | Action::PickAndPlace,
        ) => [Vec::new(), Vec::new()],
    }
}

/// The transition that a piece is here, if it is one.
fn port(b: &mut ColouredBuilder, of: Option<ResourceId>, piece: &Piece, places: &Places, s: BasicId) {
    let mut inputs = Vec::new();
    let mut outputs = Vec::new();
    let actions: Vec<(Use, bool, bool)> = piece.actions_of(of);
    for &(part, begins, ends) in &actions {
        let moved = if piece.shift == 0 { id() } else { succ(1, piece.shift) };
        let [takes, gives] = arcs(places, part.action, moved);
        inputs.extend(takes.into_iter().filter(|_| begins));
        outputs.extend(gives.into_iter().filter(|_| ends));
    }
    if inputs.is_empty() && outputs.is_empty() {
        return;
    }
    let t = match places {
        Places::Stack { level, .. } => b.transition(&*piece.name, [s, *level]),
        Places::Carrier { .. } => b.transition(&*piece.name, Domain::Uncoloured),
        Places::Machine { .. } | Places::Store { .. } | Places::Row { .. } | Places::Outside { .. } => {
            b.transition(&*piece.name, s)
        }
    };
    let fits = |function: Function| if matches!(places, Places::Carrier { .. }) { id() } else { function };
    inputs.into_iter().for_each(|(place, function)| _ = b.input(t, place, fits(function)));
    outputs.into_iter().for_each(|(place, function)| _ = b.output(t, place, fits(function)));
    // The stages are said once, by whoever has the part before.
    let leads = actions.iter().any(|(part, ..)| matches!(part.action.role(), Role::Source | Role::Worker));
    let allowed = piece.allowed.as_ref().filter(|_| leads);
    let below = match places {
        Places::Stack { height, .. } => {
            Some(compare(component(2), Comparison::LessOrEqual, Operand::Number((*height).into())))
        }
        Places::Machine { .. }
        | Places::Store { .. }
        | Places::Row { .. }
        | Places::Carrier { .. }
        | Places::Outside { .. } => None,
    };
    match (allowed, below) {
        (Some(stages), below) => {
            let clauses = stages.iter().map(|&stage| {
                let atoms = std::iter::once(colour(1, tone(stage))).chain(below);
                linewright_nets::coloured::Clause::all(atoms)
            });
            b.guard(t, Guard::any(clauses));
        }
        (None, Some(below)) => _ = b.guard(t, Guard::all([below])),
        (None, None) => {}
    }
}
