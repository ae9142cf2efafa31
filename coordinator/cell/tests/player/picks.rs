//! Order of parts, and ends of stores; number of starts at once; what is held, and until when.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_cell::{
    ActivityTiming, BadAnswer, CellEvent, CellKind, Coordination, DecidingRule, DispatchDecision, Dispatcher, Fifo,
    HeldCandidate, HoldReason, LostDecision, ModeId, PartId, PartPick, PlayedActivity, PlayerInput, PlayerOutbox,
    PlayerState, Question, RecordKind, Start,
};
use linewright_line::Tick;
use linewright_nets::NetBuilder;
use linewright_nets::coloured::ColouredBuilder;

use super::plans::{Compiled, TOKENS, alone, immediate};

/// Parts enter a store one second apart, three of them, and are fetched once a gate is open.
fn store(pick: PartPick, servers: u32) -> Compiled {
    let mut b = NetBuilder::new("store");
    let [supply, stored, gate, out] =
        [("supply", 3), ("stored", 0), ("gate", 0), ("out", 0)].map(|(name, count)| b.place(name, count));
    let [clock, enter, fetch] = ["clock", "enter", "fetch"].map(|name| b.transition(name));
    let (before, hours) = (b.place("before", 1), b.place("hands", 3));
    b.input(enter, supply, 1).output(enter, stored, 1);
    b.input(clock, before, 1).output(clock, gate, 3);
    b.input(fetch, stored, 1)
        .input(fetch, gate, 1)
        .input(fetch, hours, 1)
        .output(fetch, out, 1)
        .output(fetch, hours, 1);
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let parts = |name: &str| name == "stored" || name == "out";
    Compiled::new(
        net,
        |name| if parts(name) { CellKind::Parts(pick) } else { TOKENS },
        |name| match name {
            "clock" => alone(10_000),
            "enter" => alone(1000),
            _ => PlayedActivity { servers, ..alone(500) },
        },
    )
}

/// Parts fetched, with times in ms.
fn fetched(it: &Compiled) -> Vec<(u64, u64)> {
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], &mut Fifo, &mut out);
    while let Some(at) = player.next_deadline() {
        player.step(at, &[], &mut Fifo, &mut out);
    }
    let fetch = it.mode("fetch");
    let starts = out.records.iter().filter_map(|record| match record.fact {
        RecordKind::Started { mode, part: Some(part), .. } if mode == fetch => {
            Some((record.at.as_micros() / 1000, part.0))
        }
        _ => None,
    });
    starts.collect()
}

#[test]
fn a_store_gives_its_parts_from_the_end_it_gives_them_from() {
    assert_eq!(fetched(&store(PartPick::Oldest, 1)), [(10_000, 1), (10_500, 2), (11_000, 3)]);
    assert_eq!(fetched(&store(PartPick::Newest, 1)), [(10_000, 3), (10_500, 2), (11_000, 1)]);
    assert_eq!(fetched(&store(PartPick::Any, 1)), [(10_000, 1), (10_500, 2), (11_000, 3)]);
}

/// Proposition 15 of seed 000 (L2385) is one server; with two, two firings of one mode are in progress.
#[test]
fn a_mode_happens_as_often_at_once_as_it_has_servers() {
    assert_eq!(fetched(&store(PartPick::Any, 2)), [(10_000, 1), (10_000, 2), (10_500, 3)]);
    assert_eq!(fetched(&store(PartPick::Oldest, 3)), [(10_000, 1), (10_000, 2), (10_000, 3)]);
    assert_eq!(fetched(&store(PartPick::Newest, 3)), [(10_000, 3), (10_000, 2), (10_000, 1)]);
}

/// Errors of an answer to the first question; to all others there is none.
fn judged(it: &Compiled, answer: impl Fn(&Question<'_>) -> DispatchDecision) -> Vec<BadAnswer> {
    struct With<F>(Option<F>);
    impl<F: Fn(&Question<'_>) -> DispatchDecision> Dispatcher for With<F> {
        fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
            self.0.take().map_or_else(DispatchDecision::default, |answer| answer(question))
        }
    }
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], &mut With(Some(answer)), &mut out);
    let whys = out.events.iter().filter_map(|event| match event {
        CellEvent::BadAnswer { why, .. } => Some(*why),
        CellEvent::Superseded { .. } | CellEvent::Busy { .. } | CellEvent::Objected { .. } => None,
    });
    whys.collect()
}

/// Two parts in a store and two ways to fetch one, with two hands.
fn fetching(pick: PartPick, hands: u32) -> Compiled {
    let mut b = NetBuilder::new("fetching");
    let [stored, hand, out] = [("stored", 2), ("hands", hands), ("out", 0)].map(|(name, count)| b.place(name, count));
    for name in ["left", "right"] {
        let fetch = b.transition(name);
        b.input(fetch, stored, 1).input(fetch, hand, 1).output(fetch, out, 1).output(fetch, hand, 1);
    }
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let kind = |name: &str| if name == "hands" { TOKENS } else { CellKind::Parts(pick) };
    Compiled::new(net, kind, |_| alone(100))
}

#[test]
fn an_answer_that_cannot_be_followed_is_refused_with_the_reason() {
    let start = |list: &[(usize, Option<u64>)]| -> DispatchDecision {
        let start = list.iter().map(|&(candidate, part)| Start { candidate, part: part.map(PartId) }).collect();
        DispatchDecision { start, held: Vec::new() }
    };
    let it = fetching(PartPick::Any, 2);
    let bad = |list| judged(&it, |_| start(list));
    assert_eq!(bad(&[(0, Some(1)), (1, Some(2))]), []);
    assert_eq!(bad(&[]), []);
    assert_eq!(bad(&[(2, Some(1))]), [BadAnswer::NoCandidate(2)]);
    assert_eq!(bad(&[(0, None)]), [BadAnswer::Part { mode: ModeId(0), part: None }]);
    assert_eq!(bad(&[(0, Some(3))]), [BadAnswer::Part { mode: ModeId(0), part: Some(PartId(3)) }]);
    assert_eq!(bad(&[(0, Some(1)), (1, Some(1))]), [BadAnswer::PartTwice(PartId(1))]);
    assert_eq!(bad(&[(0, Some(1)), (0, Some(2))]), [BadAnswer::TooOften(ModeId(0))]);
    let one_hand = fetching(PartPick::Any, 1);
    let hands = one_hand.cell("hands");
    assert_eq!(judged(&one_hand, |_| start(&[(0, Some(1)), (1, Some(2))])), [BadAnswer::NotCovered(hands)]);
    let newest = fetching(PartPick::Newest, 2);
    assert_eq!(
        judged(&newest, |_| start(&[(0, Some(1))])),
        [BadAnswer::Part { mode: ModeId(0), part: Some(PartId(1)) }]
    );
    assert_eq!(judged(&newest, |_| start(&[(0, Some(2))])), []);
}

/// Candidates that compete are one group, those that do not are several.
#[test]
fn groups_are_who_competes() {
    for (hands, groups) in [(1, 1), (2, 2)] {
        let asked = std::cell::RefCell::new(BTreeMap::new());
        // Two parts and two hands are enough for both ways; with one hand they compete.
        judged(&fetching(PartPick::Any, hands), |question| {
            let pairs = question.groups.iter().map(|group| group.candidates.clone()).collect::<Vec<_>>();
            asked.borrow_mut().insert(question.candidates.len(), pairs);
            DispatchDecision::default()
        });
        assert_eq!(asked.borrow()[&2].len(), groups, "{hands}");
    }
}

#[test]
fn first_come_first_served_says_who_won() {
    let it = fetching(PartPick::Any, 1);
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], &mut Fifo, &mut out);
    let decided = out.records.iter().find_map(|record| match &record.fact {
        RecordKind::Decided { question, started, held } => Some((*question, started.clone(), held.clone())),
        _ => None,
    });
    let (left, right) = (it.mode("left"), it.mode("right"));
    let first = Some(PartId(1));
    let lost = LostDecision { to: left, with: first, own: first, by: DecidingRule::Order };
    let expected = (1, vec![(left, first)], vec![(right, HoldReason::LostTo(lost))]);
    assert_eq!(decided, Some(expected));
}

/// A dispatcher that holds everything until a time is asked again at that time, and the same reasons are written once.
#[test]
fn what_is_held_until_a_time_is_asked_about_again_then() {
    struct Later(u64);
    impl Dispatcher for Later {
        fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
            let until = Tick::from_millis(self.0);
            if question.now >= until {
                return Fifo.decide(question);
            }
            let hold = |candidate| HeldCandidate { candidate, reason: HoldReason::NotYet(until), until: Some(until) };
            DispatchDecision { start: Vec::new(), held: (0..question.candidates.len()).map(hold).collect() }
        }
    }
    let it = fetching(PartPick::Any, 2);
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    for at in [0, 300, 600] {
        player.step(Tick::from_millis(at), &[PlayerInput::Starts(true)], &mut Later(700), &mut out);
        assert_eq!(player.next_deadline(), Some(Tick::from_millis(700)));
    }
    let decided = |out: &PlayerOutbox| {
        out.records.iter().filter(|record| matches!(record.fact, RecordKind::Decided { .. })).count()
    };
    assert_eq!((decided(&out), player.state().firings().len()), (1, 0));
    player.step(Tick::from_millis(700), &[], &mut Later(700), &mut out);
    assert_eq!((decided(&out), player.state().firings().len()), (2, 2));
}

/// A circle that takes no time does not hang the player: it reports it, and goes on in the next step.
#[test]
fn a_circle_that_takes_no_time_does_not_stop_the_rest() {
    let mut b = NetBuilder::new("circle");
    let [here, there, work, done] =
        [("here", 1), ("there", 0), ("work", 1), ("done", 0)].map(|(name, count)| b.place(name, count));
    let [go, come, act] = ["go", "come", "act"].map(|name| b.transition(name));
    b.input(go, here, 1).output(go, there, 1).input(come, there, 1).output(come, here, 1);
    b.input(act, work, 1).output(act, done, 1);
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let it = Compiled::new(net, |_| TOKENS, |name| if name == "act" { alone(5) } else { immediate() });
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], &mut Fifo, &mut out);
    assert!(matches!(out.events[..], [CellEvent::Busy { .. }]));
    assert_eq!(player.next_deadline(), Some(Tick::ZERO));
    // One epoch, so many turns, and beside them one decision and one start.
    assert_eq!((player.state().sequence(), player.state().firings().len()), (10_003, 1));
}

/// Time limit of an activity, beside those of its orders.
#[test]
fn an_activity_has_a_limit_of_its_own() {
    let limited = |limit: u64| {
        let kind = ActivityTiming::Decided { time: Duration::ZERO, limit: Some(Duration::from_millis(limit)) };
        PlayedActivity { kind, ..super::plans::ordered("fetch", &[0], 60_000) }
    };
    let mut b = NetBuilder::new("limit");
    let [todo, done] = [("todo", 1), ("done", 0)].map(|(name, count)| b.place(name, count));
    let act = b.transition("act");
    b.input(act, todo, 1).output(act, done, 1);
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let it = Compiled::new(net, |_| TOKENS, |_| limited(700));
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    let heard = linewright_coordinator_cell::TaskReport::default();
    let inputs = [PlayerInput::Starts(true), PlayerInput::Station(linewright_line::StationId(0), &heard)];
    player.step(Tick::ZERO, &inputs, &mut Fifo, &mut out);
    player.step(Tick::from_millis(699), &[], &mut Fifo, &mut out);
    let phase = |player: &Coordination| player.state().firings().next().unwrap().phase;
    use linewright_coordinator_cell::{ActivityFailure, ActivityPhase};
    assert_eq!(phase(&player), ActivityPhase::Running);
    player.step(Tick::from_millis(700), &[], &mut Fifo, &mut out);
    assert_eq!(phase(&player), ActivityPhase::Failed(ActivityFailure::TimedOut));
}
