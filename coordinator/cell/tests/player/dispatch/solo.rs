//! A cell without stations, where everything ends by the clock; and a dispatcher with priorities of parts by their
//! places.

use linewright_coordinator_cell::dispatch::{PartPriority, RuleDispatcher};
use linewright_coordinator_cell::{
    Coordination, DispatchDecision, Dispatcher, PartPlace, PlayedActivity, PlayerInput, PlayerOutbox, PlayerState,
    Question, Record, RecordKind,
};
use linewright_line::Tick;
use linewright_nets::NetBuilder;
use linewright_nets::coloured::ColouredBuilder;

use crate::player::plans::{Compiled, PARTS, TOKENS, alone};

/// A net in lines: `name: taken taken -> given given`, each a name of a place, once for each token. Places whose name has a
/// dot hold parts. Names in `marked` have tokens at the beginning. `millis` is the time of a transition.
pub fn compiled(lines: &[String], marked: &[(&str, u32)], millis: impl Fn(&str) -> PlayedActivity) -> Compiled {
    let mut b = NetBuilder::new("solo");
    let mut places: Vec<(String, _)> = Vec::new();
    for line in lines {
        let (name, moves) = line.split_once(": ").unwrap();
        let transition = b.transition(name);
        let (from, to) = moves.split_once("->").unwrap();
        for (side, names) in [from, to].into_iter().enumerate() {
            for name in names.split_whitespace() {
                let at = places.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
                    let count = marked.iter().find(|(of, _)| *of == name).map_or(0, |&(_, count)| count);
                    places.push((name.to_owned(), b.place(name, count)));
                    places.len() - 1
                });
                let place = places[at].1;
                if side == 0 {
                    b.input(transition, place, 1)
                } else {
                    b.output(transition, place, 1)
                };
            }
        }
    }
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    Compiled::new(net, |name| if name.contains('.') { PARTS } else { TOKENS }, millis)
}

pub fn lines<'a>(of: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    of.into_iter().map(str::to_owned).collect()
}

pub fn seconds(millis: u64) -> PlayedActivity {
    alone(millis * 1000)
}

/// Plays a cell that needs no station. `seen` is called after every step, and returns whether to go on.
pub fn play(
    it: &Compiled,
    dispatcher: &mut dyn Dispatcher,
    until: Tick,
    mut seen: impl FnMut(Tick, &PlayerState) -> bool,
) -> (Vec<Record>, Coordination) {
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], dispatcher, &mut out);
    while let Some(at) = player.next_deadline().filter(|&at| at <= until) {
        if !seen(at, player.state()) {
            break;
        }
        player.step(at, &[], dispatcher, &mut out);
    }
    assert_eq!(out.events, [], "every answer could be followed");
    (out.records, player)
}

/// Starts with times, in milliseconds, of the modes whose names begin so.
pub fn starts<'a>(it: &'a Compiled, records: &[Record], of: &str) -> Vec<(u64, &'a str)> {
    let started = records.iter().filter_map(|record| match record.fact {
        RecordKind::Started { mode, .. } => Some((record.at.as_micros() / 1000, it.table.mode_name(mode))),
        _ => None,
    });
    started.filter(|(_, name)| name.starts_with(of)).collect()
}

/// Priority of each part by the name of its cell.
pub struct ByName<F> {
    pub inner: RuleDispatcher,
    pub job: F,
}

impl<F: Fn(&str) -> PartPriority> Dispatcher for ByName<F> {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        for part in question.state.parts() {
            if let PartPlace::On { cell, .. } = part.place {
                let job = (self.job)(question.state.table().cell_name(cell));
                self.inner.jobs.parts.insert(part.id, job);
            }
        }
        self.inner.decide(question)
    }
}
