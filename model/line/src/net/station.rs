//! A station's net: the connected modules as a Petri net, with what each place and transition means beside it.

use linewright_nets::{Net, NetBuilder};

use crate::net::connect::{StationTransition, TransitionKind, transitions_of};
use crate::net::module::{Block, MotionStage, StationPlace, places_of};
use crate::{Line, Station, StationId};

/// The Petri net of one station controller, and the meaning of its places and transitions.
///
/// The `i`-th place of the net is `places()[i]`, the `i`-th transition is `transitions()[i]`. One token per
/// concurrent branch; the initial marking is the completed home operation.
#[derive(Clone, Debug)]
pub struct StationNet {
    net: Net,
    places: Vec<StationPlace>,
    transitions: Vec<StationTransition>,
}

impl StationNet {
    /// Builds the net of a station of a checked line.
    pub fn of(line: &Line, station: StationId) -> Self {
        let station = line.station(station);
        let places = places_of(station);
        let transitions = transitions_of(station);
        let net = assemble(station, &places, &transitions);
        StationNet { net, places, transitions }
    }

    /// The bare Petri net.
    pub fn net(&self) -> &Net {
        &self.net
    }

    /// Meaning of each place, in the net's order.
    pub fn places(&self) -> &[StationPlace] {
        &self.places
    }

    /// Meaning and condition of each transition, in the net's order.
    pub fn transitions(&self) -> &[StationTransition] {
        &self.transitions
    }

    /// The index of a place.
    pub fn place_index(&self, place: StationPlace) -> Option<usize> {
        self.places.iter().position(|&p| p == place)
    }
}

fn assemble(station: &Station, places: &[StationPlace], transitions: &[StationTransition]) -> Net {
    let home = StationPlace::completed(station.home);
    let mut builder = NetBuilder::new(station.name.clone());
    let ids: Vec<_> = places.iter().map(|&p| builder.place(place_name(station, p), u32::from(p == home))).collect();
    let id_of = |place: &StationPlace| {
        let index = places.iter().position(|p| p == place).expect("transitions join places of their own station");
        ids[index]
    };
    for transition in transitions {
        let id = builder.transition(transition_name(station, transition.kind));
        for place in &transition.from {
            builder.input(id, id_of(place), 1);
        }
        for place in &transition.to {
            builder.output(id, id_of(place), 1);
        }
    }
    match builder.build() {
        Ok(net) => net,
        Err(errors) => unreachable!("a checked station has unique operation names: {errors:?}"),
    }
}

fn place_name(station: &Station, place: StationPlace) -> String {
    let stage = match place.stage {
        MotionStage::Operating => "O",
        MotionStage::Incomplete => "IC",
        MotionStage::Completed => "C",
    };
    let block = match place.block {
        Block::Normal => "N",
        Block::Recovery => "F",
    };
    format!("{} {stage}^{block}", station.operations[place.op.index()].name)
}

fn transition_name(station: &Station, kind: TransitionKind) -> String {
    let op = |id: crate::OpId| station.operations[id.index()].name.as_str();
    let step = |index: usize| {
        let names: Vec<_> = station.steps[index].iter().map(|&id| op(id)).collect();
        names.join(" + ")
    };
    let block = |block: Block| match block {
        Block::Normal => "",
        Block::Recovery => "undoing ",
    };
    match kind {
        TransitionKind::Stop(id, b) => format!("stop {}{}", block(b), op(id)),
        TransitionKind::Resume(id, b) => format!("resume {}{}", block(b), op(id)),
        TransitionKind::Complete(id, b) => format!("complete {}{}", block(b), op(id)),
        TransitionKind::Undo(id) => format!("undo {}", op(id)),
        TransitionKind::Retract(id) => format!("retract {}", op(id)),
        TransitionKind::Restart(id) => format!("restart {}", op(id)),
        TransitionKind::Again(id) => format!("turn forward {}", op(id)),
        TransitionKind::Next { from, to } => format!("{} -> {}", step(from), step(to)),
        TransitionKind::Back { from, to } => format!("back from {} to {}", step(from), step(to)),
        TransitionKind::GiveUp(task) => format!("give up {}", station.task(task).name),
        TransitionKind::EnterPath(id) => format!("recover {} by going home", op(id)),
        TransitionKind::FollowPath { from, to } => format!("on the way home, {} then {}", op(from), op(to)),
    }
}
