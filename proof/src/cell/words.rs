//! Effects of a cell net's transitions, and tokens that a marking lacks, in the words of the description.

use linewright_cell::net::{Origin, PlaceMeaning, TransitionPhase};
use linewright_cell::{Activity, ActivityKind, Cell, ResourceId, Role, StageMove};
use linewright_nets::{Marking, PlaceId, TransitionId};

use super::Nets;

/// A step of a counterexample: a transition as an observer of the cell describes it.
pub(super) fn sentence(cell: &Cell, activity: &Activity, of: &StageMove, phase: TransitionPhase, part: &str) -> String {
    let name = |role: Role| {
        let of = activity.used(role).and_then(|part| part.of);
        of.map_or("outside", |id| cell.resource(id).name.as_str())
    };
    let (source, target) = (name(Role::Source), name(Role::Target));
    let carrier = activity.used(Role::Carrier).is_some().then(|| name(Role::Carrier));
    let what = match (phase, activity.kind, carrier) {
        (TransitionPhase::Grasp | TransitionPhase::GraspStart | TransitionPhase::GraspEnd, _, carrier) => {
            format!("{} grasps {part}, {}", carrier.unwrap_or("nobody"), at(source))
        }
        (TransitionPhase::Put | TransitionPhase::PutStart | TransitionPhase::PutEnd, _, carrier) => {
            format!("{} puts {part} {}", carrier.unwrap_or("nobody"), into(target))
        }
        (TransitionPhase::Whole | TransitionPhase::Start | TransitionPhase::End, ActivityKind::Process, _) => {
            format!("{} of {part}", step(cell, of))
        }
        (TransitionPhase::Whole | TransitionPhase::Start | TransitionPhase::End, ActivityKind::Enter, None) => {
            format!("{part} comes to {target}")
        }
        (TransitionPhase::Whole | TransitionPhase::Start | TransitionPhase::End, ActivityKind::Leave, None) => {
            format!("{part} leaves from {source}")
        }
        (TransitionPhase::Whole | TransitionPhase::Start | TransitionPhase::End, ActivityKind::Transport, None) => {
            format!("{part} goes from {source} to {target}")
        }
        (
            TransitionPhase::Whole | TransitionPhase::Start | TransitionPhase::End,
            ActivityKind::Enter | ActivityKind::Leave | ActivityKind::Transport,
            Some(carrier),
        ) => format!("{carrier} brings {part} from {source} to {target}"),
    };
    let how = match phase {
        TransitionPhase::Whole | TransitionPhase::Grasp | TransitionPhase::Put => "",
        TransitionPhase::Start | TransitionPhase::GraspStart | TransitionPhase::PutStart => " begins",
        TransitionPhase::End | TransitionPhase::GraspEnd | TransitionPhase::PutEnd => " ends",
    };
    format!("{}{how}: {what}", activity.name)
}

/// For the end of a phase: the phase that begins it, and the one that does both in one go. None for other phases.
pub(super) fn begun_by(phase: TransitionPhase) -> Option<(TransitionPhase, TransitionPhase)> {
    match phase {
        TransitionPhase::End => Some((TransitionPhase::Start, TransitionPhase::Whole)),
        TransitionPhase::GraspEnd => Some((TransitionPhase::GraspStart, TransitionPhase::Grasp)),
        TransitionPhase::PutEnd => Some((TransitionPhase::PutStart, TransitionPhase::Put)),
        TransitionPhase::Whole
        | TransitionPhase::Start
        | TransitionPhase::Grasp
        | TransitionPhase::Put
        | TransitionPhase::GraspStart
        | TransitionPhase::PutStart => None,
    }
}

fn at(name: &str) -> String {
    if name == "outside" { name.to_owned() } else { format!("at {name}") }
}

fn into(name: &str) -> String {
    if name == "outside" { name.to_owned() } else { format!("into {name}") }
}

/// The name of the step that leads from the one stage to the other.
fn step<'c>(cell: &'c Cell, of: &StageMove) -> &'c str {
    let part = &cell.part_types[cell.stages[of.from.index()].part_type.index()];
    part.steps.iter().find(|step| (step.from, step.to) == (of.from, of.to)).map_or("work", |step| step.name.as_str())
}

/// Needs of parts on a place to go on, one sentence for each way; none if something can go on at once.
pub(super) fn needs(nets: &Nets<'_>, place: PlaceId, tokens: impl Fn(PlaceId) -> u32) -> Option<Vec<String>> {
    let long = nets.long.net();
    // By what can be done: of several modes, which differ in the level of a stack, the one that lacks least.
    let mut ways: Vec<(String, Vec<String>)> = Vec::new();
    for &(t, _) in long.consumers(place) {
        let (activity, name) = match nets.net.origin(nets.long.mode(t).transition) {
            Origin::Activity { id, .. } => (Some(nets.cell.activity(id)), format!("`{}`", nets.cell.activity(id).name)),
            Origin::Shift => (None, "moving up".to_owned()),
        };
        let lacking = long.preset(t).iter().filter(|&&(other, weight)| other != place && tokens(other) < weight);
        let lacking: Vec<String> =
            lacking.filter_map(|&(other, _)| lack(nets.cell, activity, nets.meaning(other))).collect();
        if lacking.is_empty() {
            return None;
        }
        match ways.iter_mut().find(|(known, _)| *known == name) {
            Some((_, least)) if least.len() <= lacking.len() => {}
            Some((_, least)) => *least = lacking,
            None => ways.push((name, lacking)),
        }
    }
    Some(ways.into_iter().map(|(name, lacking)| format!("{name} needs {}", lacking.join(" and "))).collect())
}

/// What is missing, by the place that lacks it.
fn lack(cell: &Cell, activity: Option<&Activity>, meaning: PlaceMeaning) -> Option<String> {
    let name = |id: ResourceId| cell.resource(id).name.as_str();
    let comes_from =
        |id| activity.and_then(|activity| activity.used(Role::Source)).is_some_and(|part| part.of == Some(id));
    match meaning {
        PlaceMeaning::Room(id) => Some(format!("room in {}", name(id))),
        PlaceMeaning::Free(id) => Some(format!("{} free", name(id))),
        PlaceMeaning::Position(id, at) => Some(format!("position {at} of {} free", name(id))),
        PlaceMeaning::Top(id) if comes_from(id) => Some(format!("to be on top of {}", name(id))),
        PlaceMeaning::Top(id) => Some(format!("room in {}", name(id))),
        PlaceMeaning::Idle(id) => Some(format!("`{}` not to be in progress", cell.activity(id).name)),
        PlaceMeaning::Admission => Some("a part less in the cell".to_owned()),
        PlaceMeaning::Held(..) | PlaceMeaning::Waiting | PlaceMeaning::Busy { .. } => None,
    }
}

/// The activity, and what it makes of which stage, that a transition of the long net is a part of; none for a part that
/// moves up in a buffer.
pub(super) fn moved<'n>(nets: &'n Nets<'_>, t: TransitionId) -> Option<(&'n Activity, &'n StageMove, TransitionPhase)> {
    let mode = nets.long.mode(t);
    let (activity, of) = nets.net.move_of(nets.cell, mode)?;
    match nets.net.origin(mode.transition) {
        Origin::Activity { phase, .. } => Some((activity, of, phase)),
        Origin::Shift => None,
    }
}

/// The tokens of a group's own marking by places of the long net; what is elsewhere counts as empty.
pub(super) fn tokens_of<'m>(places: &'m [PlaceId], marking: &'m Marking) -> impl Fn(PlaceId) -> u32 + 'm {
    |place| places.binary_search(&place).map_or(0, |at| marking.tokens(PlaceId(at as u32)))
}
