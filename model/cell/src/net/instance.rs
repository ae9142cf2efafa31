//! A resource as a net: the places of its prototype, and a port for each transition it takes part in.
//!
//! Only this module has the tokens that an action takes when it begins and gives when it ends. The capacity of where a
//! part comes from returns when the activity ends: the work position stays reserved until it is unloaded (seed 000,
//! L1500).

use linewright_nets::coloured::{
    BasicId, ColouredBuilder, ColouredError, ColouredNet, Comparison, Domain, Function, Guard, Operand, abs, colour,
    compare, component, id, proj, succ,
};
use linewright_nets::{PlaceId, TransitionId};

use super::pieces::{PlannedTransition, ProgressPlace};
use super::{OUTSIDE, PlaceMeaning, RUNNING, ResourcePosition, STAGES, Supply};
use crate::{Cell, Prototype, Resource, ResourceAction, ResourceId, Role, StageId, Use};

/// Suffix of the places that keep a stage from being moved twice at a time.
const IDLE: &str = ".idle";

/// A net, and the meaning of each of its places.
type Built = Result<(ColouredNet, Vec<PlaceMeaning>), Vec<ColouredError>>;

/// The places of a resource.
enum InstancePlaces {
    /// available-capacity, loaded, unload-ready; and the token of a human.
    Machine { capacity: PlaceId, loaded: PlaceId, ready: PlaceId, free: Option<PlaceId> },
    /// available-capacity, stored-parts.
    Store { capacity: PlaceId, stored: PlaceId },
    /// free and at, by position.
    Row { free: Vec<PlaceId>, at: Vec<PlaceId> },
    /// The first free level, and the part on each. Levels are a domain of their own.
    Stack { level: BasicId, top: PlaceId, at: PlaceId, height: u32 },
    /// Number of parts that can still be carried.
    Carrier { free: PlaceId },
    /// Parts that have not come yet, where they are counted; where they go when they leave; how many may come.
    Outside { waiting: Option<PlaceId>, back: Option<PlaceId>, room: PlaceId },
}

/// The domain of stages, with their names.
fn stages(b: &mut ColouredBuilder, cell: &Cell) -> BasicId {
    b.named_basic(STAGES, cell.stages.iter().map(|stage| stage.name.as_str()))
}

fn tone(stage: StageId) -> u32 {
    u32::from(stage.0) + 1
}

/// The domain of a stack's levels: as many as parts, and one for when it is full.
fn levels(b: &mut ColouredBuilder, resource: &Resource) -> BasicId {
    b.basic(format!("{} level", resource.name), resource.capacity + 1)
}

/// A resource, with a port for each piece it takes part in.
pub(super) fn resource(cell: &Cell, of: ResourceId, pieces: &[PlannedTransition]) -> Built {
    let resource = cell.resource(of);
    let mut b = ColouredBuilder::new(&resource.name);
    let s = stages(&mut b, cell);
    let places = places(&mut b, resource, s);
    for piece in pieces {
        port(&mut b, Some(of), piece, &places, s);
    }
    if let InstancePlaces::Row { free, at } = &places {
        for i in 1..at.len() {
            let shift = b.transition(format!("shift {i}"), s);
            b.input(shift, at[i - 1], id()).input(shift, free[i], abs());
            b.output(shift, at[i], id()).output(shift, free[i - 1], abs());
        }
    }
    Ok((b.build()?, places.meanings(Some(of))))
}

/// The outside: where parts come from and go to.
pub(super) fn outside(cell: &Cell, supply: Supply<'_>, pieces: &[PlannedTransition]) -> Built {
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
    let places = InstancePlaces::Outside { waiting, back: waiting.filter(|_| returns), room };
    for piece in pieces {
        port(&mut b, None, piece, &places, s);
    }
    Ok((b.build()?, places.meanings(None)))
}

/// Activities in progress; none if nothing ever is.
pub(super) fn running(cell: &Cell, pieces: &[PlannedTransition]) -> Option<Built> {
    pieces.iter().find(|piece| piece.from.is_some() || piece.to.is_some())?;
    let mut b = ColouredBuilder::new(RUNNING);
    let s = stages(&mut b, cell);
    let mut stacks: Vec<Option<BasicId>> = vec![None; cell.resources.len()];
    let mut known: Vec<(String, PlaceId)> = Vec::new();
    let mut meanings = Vec::new();
    for piece in pieces.iter().filter(|piece| piece.from.is_some() || piece.to.is_some()) {
        // What is held while neither action is in progress carries no level; the levels of the piece are its own.
        let mut domain_of = |progress: &ProgressPlace, b: &mut ColouredBuilder| -> Vec<BasicId> {
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
                meanings.push(PlaceMeaning::Busy { activity: piece.activity, is_held: progress.uses.is_empty() });
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
            meanings.push(PlaceMeaning::Idle(piece.activity));
        }
    }
    Some(b.build().map(|net| (net, meanings)))
}

/// A token for each stage that an activity can move at a time; whether its place is a new one.
fn serve(
    b: &mut ColouredBuilder,
    piece: &PlannedTransition,
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

impl InstancePlaces {
    /// Meaning of each place, in the order of the places.
    fn meanings(&self, of: Option<ResourceId>) -> Vec<PlaceMeaning> {
        let mut all: Vec<(PlaceId, PlaceMeaning)> = Vec::new();
        match (self, of) {
            (InstancePlaces::Machine { capacity, loaded, ready, free }, Some(of)) => {
                all.extend([
                    (*capacity, PlaceMeaning::Room(of)),
                    (*loaded, PlaceMeaning::Held(of, ResourcePosition::Loaded)),
                    (*ready, PlaceMeaning::Held(of, ResourcePosition::Ready)),
                ]);
                all.extend(free.map(|free| (free, PlaceMeaning::Free(of))));
            }
            (InstancePlaces::Store { capacity, stored }, Some(of)) => {
                all.extend([
                    (*capacity, PlaceMeaning::Room(of)),
                    (*stored, PlaceMeaning::Held(of, ResourcePosition::Stored)),
                ]);
            }
            (InstancePlaces::Row { free, at }, Some(of)) => {
                all.extend((1..).zip(free).map(|(i, &free)| (free, PlaceMeaning::Position(of, i))));
                all.extend((1..).zip(at).map(|(i, &at)| (at, PlaceMeaning::Held(of, ResourcePosition::Position(i)))));
            }
            (InstancePlaces::Stack { top, at, .. }, Some(of)) => {
                all.extend([(*top, PlaceMeaning::Top(of)), (*at, PlaceMeaning::Held(of, ResourcePosition::Stored))]);
            }
            (InstancePlaces::Carrier { free }, Some(of)) => all.push((*free, PlaceMeaning::Free(of))),
            (InstancePlaces::Outside { waiting, room, .. }, _) => {
                all.extend(waiting.map(|waiting| (waiting, PlaceMeaning::Waiting)));
                all.push((*room, PlaceMeaning::Admission));
            }
            // Only the outside has no resource.
            (
                InstancePlaces::Machine { .. }
                | InstancePlaces::Store { .. }
                | InstancePlaces::Row { .. }
                | InstancePlaces::Stack { .. }
                | InstancePlaces::Carrier { .. },
                None,
            ) => {}
        }
        all.sort_by_key(|(place, _)| place.index());
        all.into_iter().map(|(_, meaning)| meaning).collect()
    }
}

fn places(b: &mut ColouredBuilder, resource: &Resource, s: BasicId) -> InstancePlaces {
    let n = resource.capacity;
    let tokens = |b: &mut ColouredBuilder, name: &str, count| {
        let place = b.place(name, Domain::Uncoloured);
        b.tokens(place, &[], count);
        place
    };
    match resource.prototype {
        Prototype::Machine | Prototype::Human => InstancePlaces::Machine {
            capacity: tokens(b, "available-capacity", n),
            loaded: b.place("loaded", s),
            ready: b.place("unload-ready", s),
            free: (resource.prototype == Prototype::Human).then(|| tokens(b, "free", 1)),
        },
        Prototype::RandomAccessStore => {
            InstancePlaces::Store { capacity: tokens(b, "available-capacity", n), stored: b.place("stored-parts", s) }
        }
        Prototype::FifoBuffer => InstancePlaces::Row {
            free: (1..=n).map(|i| tokens(b, &format!("free {i}"), 1)).collect(),
            at: (1..=n).map(|i| b.place(format!("at {i}"), s)).collect(),
        },
        Prototype::LifoBuffer => {
            let level = levels(b, resource);
            let (top, at) = (b.place("top", level), b.place("at", [s, level]));
            b.tokens(top, &[1], 1);
            InstancePlaces::Stack { level, top, at, height: n }
        }
        Prototype::Robot => InstancePlaces::Carrier { free: tokens(b, "free", 1) },
        Prototype::Conveyor => InstancePlaces::Carrier { free: tokens(b, "room", n) },
    }
}

/// Tokens that an action takes when it begins and gives when it ends, as functions of a mode of stages (and levels).
/// `moved` is the stage afterwards; a part `stays` that is worked on without having been loaded for it.
fn arcs(
    places: &InstancePlaces,
    action: ResourceAction,
    moved: Function,
    stays: bool,
) -> [Vec<(PlaceId, Function)>; 2] {
    match (places, action) {
        (InstancePlaces::Machine { capacity, loaded, .. }, ResourceAction::Load) => {
            [vec![(*capacity, abs())], vec![(*loaded, moved)]]
        }
        (InstancePlaces::Machine { loaded, ready, free, .. }, ResourceAction::Process) => {
            let attention = || free.iter().map(|free| (*free, abs()));
            let before = if stays { *ready } else { *loaded };
            [
                std::iter::once((before, id())).chain(attention()).collect(),
                std::iter::once((*ready, moved)).chain(attention()).collect(),
            ]
        }
        (InstancePlaces::Machine { capacity, ready, .. }, ResourceAction::Unload) => {
            [vec![(*ready, id())], vec![(*capacity, abs())]]
        }
        (
            InstancePlaces::Machine { free: Some(free), .. } | InstancePlaces::Carrier { free },
            ResourceAction::PickAndPlace,
        ) => [vec![(*free, abs())], vec![(*free, abs())]],
        (InstancePlaces::Store { capacity, stored }, ResourceAction::Store) => {
            [vec![(*capacity, abs())], vec![(*stored, moved)]]
        }
        (InstancePlaces::Store { capacity, stored }, ResourceAction::Retrieve) => {
            [vec![(*stored, id())], vec![(*capacity, abs())]]
        }
        (InstancePlaces::Row { free, at }, ResourceAction::Store) => [vec![(free[0], abs())], vec![(at[0], moved)]],
        (InstancePlaces::Row { free, at }, ResourceAction::Retrieve) => {
            let last = at.len() - 1;
            [vec![(at[last], id())], vec![(free[last], abs())]]
        }
        // The mode has the level of the part; the stack's top is one higher while it is there.
        (InstancePlaces::Stack { top, at, .. }, ResourceAction::Store) => {
            [vec![(*top, proj([2]))], vec![(*at, id()), (*top, proj([2]).of(succ(2, 1)))]]
        }
        (InstancePlaces::Stack { top, at, .. }, ResourceAction::Retrieve) => {
            [vec![(*at, id()), (*top, proj([2]).of(succ(2, 1)))], vec![(*top, proj([2]))]]
        }
        (InstancePlaces::Outside { waiting, room, .. }, ResourceAction::In) => {
            [waiting.iter().map(|waiting| (*waiting, id())).chain([(*room, abs())]).collect(), Vec::new()]
        }
        (InstancePlaces::Outside { back, room, .. }, ResourceAction::Out) => {
            [Vec::new(), back.iter().map(|back| (*back, moved.clone())).chain([(*room, abs())]).collect()]
        }
        // No prototype has these, so no description can name them.
        (
            InstancePlaces::Machine { .. },
            ResourceAction::PickAndPlace
            | ResourceAction::Store
            | ResourceAction::Retrieve
            | ResourceAction::In
            | ResourceAction::Out,
        )
        | (
            InstancePlaces::Store { .. } | InstancePlaces::Row { .. } | InstancePlaces::Stack { .. },
            ResourceAction::Load
            | ResourceAction::Process
            | ResourceAction::Unload
            | ResourceAction::PickAndPlace
            | ResourceAction::In
            | ResourceAction::Out,
        )
        | (
            InstancePlaces::Carrier { .. },
            ResourceAction::Load
            | ResourceAction::Process
            | ResourceAction::Unload
            | ResourceAction::Store
            | ResourceAction::Retrieve
            | ResourceAction::In
            | ResourceAction::Out,
        )
        | (
            InstancePlaces::Outside { .. },
            ResourceAction::Load
            | ResourceAction::Process
            | ResourceAction::Unload
            | ResourceAction::Store
            | ResourceAction::Retrieve
            | ResourceAction::PickAndPlace,
        ) => [Vec::new(), Vec::new()],
    }
}

/// The transition that a piece is here, if it is one.
fn port(
    b: &mut ColouredBuilder,
    of: Option<ResourceId>,
    piece: &PlannedTransition,
    places: &InstancePlaces,
    s: BasicId,
) {
    let mut inputs = Vec::new();
    let mut outputs = Vec::new();
    let actions: Vec<(Use, bool, bool)> = piece.actions_of(of);
    for &(part, begins, ends) in &actions {
        let moved = if piece.shift == 0 { id() } else { succ(1, piece.shift) };
        let [takes, gives] = arcs(places, part.action, moved, piece.stays);
        inputs.extend(takes.into_iter().filter(|_| begins));
        outputs.extend(gives.into_iter().filter(|_| ends));
    }
    if inputs.is_empty() && outputs.is_empty() {
        return;
    }
    let t = match places {
        InstancePlaces::Stack { level, .. } => b.transition(&*piece.name, [s, *level]),
        InstancePlaces::Carrier { .. } => b.transition(&*piece.name, Domain::Uncoloured),
        InstancePlaces::Machine { .. }
        | InstancePlaces::Store { .. }
        | InstancePlaces::Row { .. }
        | InstancePlaces::Outside { .. } => b.transition(&*piece.name, s),
    };
    let fits = |function: Function| if matches!(places, InstancePlaces::Carrier { .. }) { id() } else { function };
    inputs.into_iter().for_each(|(place, function)| _ = b.input(t, place, fits(function)));
    outputs.into_iter().for_each(|(place, function)| _ = b.output(t, place, fits(function)));
    // The stages are written once, at the resource that has the part before.
    let leads = actions.iter().any(|(part, ..)| matches!(part.action.role(), Role::Source | Role::Worker));
    let allowed = piece.allowed.as_ref().filter(|_| leads);
    let below = match places {
        InstancePlaces::Stack { height, .. } => {
            Some(compare(component(2), Comparison::LessOrEqual, Operand::Number((*height).into())))
        }
        InstancePlaces::Machine { .. }
        | InstancePlaces::Store { .. }
        | InstancePlaces::Row { .. }
        | InstancePlaces::Carrier { .. }
        | InstancePlaces::Outside { .. } => None,
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
