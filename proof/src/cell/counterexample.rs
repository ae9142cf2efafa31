//! How parts come to be stuck, part by part: the steps of each, its place in the end, and its needs to go on.
//!
//! The net counts parts of a stage without identity; a counterexample names them. Of several alike, the one that came
//! first moves.

use std::collections::{HashMap, VecDeque};

use linewright_cell::net::{PlaceMeaning, ResourcePosition, TransitionPhase};
use linewright_cell::{ActivityId, PartTypeId, ResourceId, Role, StageId};
use linewright_nets::explicit::WitnessMarking;
use linewright_nets::{PlaceId, TransitionId};

use super::Nets;
use super::group::ResourceGroup;
use super::words::{begun_by, moved, needs, sentence, tokens_of};

/// Path to a marking, in the words of the description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellPath {
    /// Steps, in order: one of the shortest ways.
    pub steps: Vec<String>,
    /// Violation at the end.
    pub end: String,
    /// Content of each resource concerned then.
    pub resources: Vec<Holding>,
}

/// A resource in the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holding {
    /// Name of the resource.
    pub name: String,
    /// Number of parts it can hold or carry.
    pub capacity: u32,
    /// Those that it has.
    pub parts: Vec<WaitingPart>,
}

/// A part in the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaitingPart {
    /// Its name: its type, and the how manieth of it.
    pub part: String,
    /// Its stage.
    pub stage: String,
    /// Its position in the resource, if there are several.
    pub at: Option<String>,
    /// Needs of each way on; none if it can go on at once.
    pub needs: Vec<String>,
}

/// A part of the story.
struct StoryPart {
    name: String,
    stage: StageId,
}

/// The parts there are, and where.
#[derive(Default)]
struct PartsAtStart {
    parts: Vec<StoryPart>,
    /// By place of the long net, those that came first in front.
    at: HashMap<PlaceId, VecDeque<usize>>,
    /// Number of each type that have come.
    seen: HashMap<PartTypeId, u32>,
}

/// A step, with its activity and part.
struct StoryStep<'n> {
    text: String,
    of: Option<(&'n str, usize, TransitionPhase)>,
}

/// The path to a marking found, in words.
pub(super) fn tell(nets: &Nets<'_>, group: &ResourceGroup, found: &WitnessMarking, end: &str) -> CellPath {
    let mut cast = PartsAtStart::default();
    let mut steps: Vec<StoryStep<'_>> = Vec::new();
    for t in found.path.iter().map(|t| group.transitions[t.index()]) {
        let part = cast.play(nets, t);
        let Some((activity, of, phase)) = moved(nets, t) else {
            let name = part.map_or("a part", |part| cast.parts[part].name.as_str());
            steps.push(StoryStep { text: format!("{name} moves up{}", cast.place_of(nets, part)), of: None });
            continue;
        };
        let Some(part) = part else { continue };
        let name = &cast.parts[part].name;
        let own = activity.name.as_str();
        let begun =
            begun_by(phase).filter(|&(begin, _)| steps.last().is_some_and(|s| s.of == Some((own, part, begin))));
        if begun.is_some() {
            steps.pop();
        }
        let told = begun.map_or(phase, |(_, whole)| whole);
        steps.push(StoryStep { text: sentence(nets.cell, activity, of, told, name), of: Some((own, part, told)) });
    }
    let tokens = tokens_of(&group.places, &found.marking);
    let resources = group.resources.iter().map(|&id| cast.holding(nets, id, &tokens)).collect();
    CellPath { steps: steps.into_iter().map(|step| step.text).collect(), end: end.to_owned(), resources }
}

impl PartsAtStart {
    /// Fires a transition; the part that it moves.
    fn play(&mut self, nets: &Nets<'_>, t: TransitionId) -> Option<usize> {
        let long = nets.long.net();
        let place = |arcs: &[(PlaceId, u32)]| {
            arcs.iter().map(|&(place, _)| place).find(|&place| nets.meaning(place).holds_parts_inside())
        };
        let of = moved(nets, t);
        let part = match place(long.preset(t)) {
            Some(from) => self.at.get_mut(&from)?.pop_front()?,
            None => self.enters(nets, of?.1.from),
        };
        if let Some(to) = place(long.postset(t)) {
            self.at.entry(to).or_default().push_back(part);
        }
        if let Some((_, of, _)) = of.filter(|(_, _, phase)| phase.ends()) {
            self.parts[part].stage = of.to;
        }
        Some(part)
    }

    fn enters(&mut self, nets: &Nets<'_>, stage: StageId) -> usize {
        let of = nets.cell.stages[stage.index()].part_type;
        let count = self.seen.entry(of).or_default();
        *count += 1;
        self.parts.push(StoryPart { name: format!("{} #{count}", nets.cell.part_types[of.index()].name), stage });
        self.parts.len() - 1
    }

    /// Position up to which a part has moved.
    fn place_of(&self, nets: &Nets<'_>, part: Option<usize>) -> String {
        let at = self.at.iter().find(|(_, parts)| part.is_some_and(|part| parts.contains(&part)));
        if let Some(PlaceMeaning::Held(id, ResourcePosition::Position(at))) = at.map(|(&place, _)| nets.meaning(place))
        {
            format!(" to position {at} of {}", nets.cell.resource(id).name)
        } else {
            String::new()
        }
    }

    fn holding(&self, nets: &Nets<'_>, id: ResourceId, tokens: &impl Fn(PlaceId) -> u32) -> Holding {
        let mut here: Vec<(usize, PlaceId)> = Vec::new();
        for (&place, parts) in &self.at {
            if nets.holder(nets.meaning(place)) == Some(id) {
                here.extend(parts.iter().map(|&part| (part, place)));
            }
        }
        here.sort_unstable();
        let waiting = |&(part, place): &(usize, PlaceId)| WaitingPart {
            part: self.parts[part].name.clone(),
            stage: nets.cell.stages[self.parts[part].stage.index()].name.clone(),
            at: nets.whereabouts(nets.meaning(place)),
            needs: needs(nets, place, tokens).unwrap_or_default(),
        };
        let resource = nets.cell.resource(id);
        let parts = here.iter().map(waiting).collect();
        Holding { name: resource.name.clone(), capacity: resource.capacity, parts }
    }
}

impl Nets<'_> {
    /// The resource that has the parts of a place.
    fn holder(&self, meaning: PlaceMeaning) -> Option<ResourceId> {
        match meaning {
            PlaceMeaning::Busy { activity, .. } => self.who_moves(activity),
            other => other.resource(),
        }
    }

    /// The resource that has a part while an activity is in progress.
    fn who_moves(&self, activity: ActivityId) -> Option<ResourceId> {
        let activity = self.cell.activity(activity);
        let roles = [Role::Carrier, Role::Worker, Role::Source, Role::Target];
        roles.into_iter().find_map(|role| activity.used(role).and_then(|part| part.of))
    }

    fn whereabouts(&self, meaning: PlaceMeaning) -> Option<String> {
        match meaning {
            PlaceMeaning::Held(_, ResourcePosition::Position(at)) => Some(format!("position {at}")),
            PlaceMeaning::Held(_, ResourcePosition::Loaded) => Some("not worked on yet".to_owned()),
            PlaceMeaning::Busy { activity, is_held: true } => {
                Some(format!("for `{}`", self.cell.activity(activity).name))
            }
            PlaceMeaning::Busy { activity, is_held: false } => {
                Some(format!("`{}` is in progress", self.cell.activity(activity).name))
            }
            PlaceMeaning::Held(_, ResourcePosition::Stored | ResourcePosition::Ready)
            | PlaceMeaning::Room(_)
            | PlaceMeaning::Free(_)
            | PlaceMeaning::Position(..)
            | PlaceMeaning::Top(_)
            | PlaceMeaning::Waiting
            | PlaceMeaning::Admission
            | PlaceMeaning::Idle(_) => None,
        }
    }
}
