//! Lines with a mistake in them: structure and exploration agree on each, and neither claims too much.
//!
//! The verdict of structure on a conflict is compared with every state of forward motion, both ways. A line that stops
//! by structure is let run until it does.

use std::collections::BTreeSet;

use linewright_line::net::{
    Conjunction, ControlMode, Literal, StationNet, StationTransition, Var, overlaps, overlaps_among,
};
use linewright_line::{Line, OpId};
use linewright_proof::explore::{LineExploration, Verdict};
use linewright_proof::generate::{self, LineShape, Random, break_it, breakages, text, without_literal};
use linewright_proof::structure::chart::{Gap, every_circuit_has_a_token, home_is_consistent, separated};
use linewright_testkit::cases::cases;

use crate::common::{
    APART, DEADLOCK, auto_and_manual, begins_well, explored, in_auto, met, undisturbed, verdict, with_conflict,
};

/// Results of the mistakes.
#[derive(Debug, Default)]
struct Tally {
    /// Structure: home contradicts an arrow.
    home: usize,
    /// Structure: a circuit without a token. Auto mode runs into it, as exploration does.
    stuck: usize,
    /// Structure: such a circuit, but not of auto's arrows. Auto mode goes on for ever, as exploration does.
    stuck_elsewhere: usize,
    /// Both: auto mode alone meets the conflict.
    met_in_auto: usize,
    /// Both: it takes a change of mode to meet it.
    met_by_changing: usize,
    /// Both: it takes something taken back to meet it.
    met_by_taking_back: usize,
    /// Both: a station runs away, and that is seen before the conflict is.
    runs_away: usize,
    /// Neither: the mistake does no harm to this conflict.
    harmless: usize,
    /// Structure: it can be met, though not in auto alone. Exploration has not seen it as far as it looked.
    open: usize,
}

impl Tally {
    fn enter(&mut self, what: &str, line: &Line) {
        if home_is_consistent(line).is_err() {
            self.home += 1;
        } else if every_circuit_has_a_token(line).is_err() {
            self.enter_stuck(what, line);
        } else {
            line.conflicts.iter().for_each(|conflict| self.enter_conflict(what, &with_conflict(line, conflict)));
        }
    }

    fn enter_stuck(&mut self, what: &str, line: &Line) {
        let auto = Line { conflicts: Vec::new(), ..in_auto(line) };
        let explored = explored(&undisturbed(&auto), 300_000);
        let (stops, apart) = (verdict(&explored, DEADLOCK), verdict(&explored, APART));
        if every_circuit_has_a_token(&auto).is_err() {
            // A station that waits for no one in the circuit runs away from those that stand still.
            let found = stops == Verdict::Fails || apart == Verdict::Fails;
            assert!(found, "{what}: {:?}\n{}", explored.properties, text(line));
            self.stuck += 1;
        } else {
            assert!(stops != Verdict::Fails, "{what}: {:?}\n{}", explored.properties, text(line));
            self.stuck_elsewhere += 1;
        }
    }

    /// A line with one conflict, whose chart is live and its home consistent.
    fn enter_conflict(&mut self, what: &str, line: &Line) {
        let conflict = &line.conflicts[0];
        let told = || format!("{what}: {:?}\n{}", separated(line, conflict), text(line));
        let auto = in_auto(line);
        let in_auto = explored(&undisturbed(&auto), 300_000);
        let runs_away = verdict(&in_auto, APART) == Verdict::Fails;
        let meets = met(&in_auto);
        if matches!(separated(&auto, conflict), Err(Gap::Forward(_))) {
            assert!(meets || runs_away, "structure alone says that auto meets it. {}", told());
            if meets {
                self.met_in_auto += 1
            } else {
                self.runs_away += 1
            }
            return;
        }
        assert!(!meets, "exploration alone says that auto meets it. {}", told());
        if let Err(gap) = separated(line, conflict) {
            self.enter_other(&gap, line, &told);
            return;
        }
        let everything = explored(&LineExploration::new(line), 4_000);
        assert!(!met(&everything), "kept apart, and yet: {}. {}", everything.counterexample().unwrap(), told());
        self.harmless += 1;
    }

    fn enter_other(&mut self, gap: &Gap, line: &Line, told: &impl Fn() -> String) {
        let mut setting = auto_and_manual(line);
        setting.faults = false;
        let explored = explored(&setting, 100_000);
        match gap {
            Gap::Forward(_) if met(&explored) => self.met_by_changing += 1,
            Gap::TakenBack(_) if met(&explored) => self.met_by_taking_back += 1,
            _ if verdict(&explored, APART) == Verdict::Fails => self.runs_away += 1,
            Gap::Forward(_) => {
                assert!(!explored.exhausted, "structure alone says that it can be met. {}", told());
                self.open += 1;
            }
            Gap::TakenBack(_) => self.open += 1,
        }
    }
}

#[test]
fn of_every_mistake_structure_and_exploration_say_the_same() {
    let mut tally = Tally::default();
    let mut random = Random::new(3);
    // So many that each kind of end is among them.
    for (shape, count) in [(LineShape::small(), cases(30).max(30)), (LineShape::default(), cases(12).max(12))] {
        for seed in 0..count {
            let line = generate::line(&shape, seed);
            let all = breakages(&line);
            for _ in 0..4 {
                let breakage = *random.pick(&all);
                let broken = break_it(&line, breakage).expect("it was among those that can be made");
                tally.enter(&format!("line {seed} of {shape:?} with {breakage:?}"), &broken);
            }
        }
    }
    println!("{tally:?}");
    let kinds = [tally.home, tally.stuck, tally.met_in_auto, tally.met_by_changing, tally.harmless];
    assert!(kinds.into_iter().all(|count| count > 0), "{tally:?}");
    assert!(tally.open + tally.runs_away < tally.met_in_auto, "{tally:?}");
}

#[test]
fn a_line_stops_exactly_if_a_circuit_has_no_token() {
    // Arrows between any operations at all, of auto mode, most of which do not go together.
    let (mut stuck, mut live) = (0u64, 0u64);
    for seed in 0..cases(300) {
        let shape = if seed % 3 == 0 { LineShape::default() } else { LineShape::small() };
        let mut line = in_auto(&generate::line(&shape, seed));
        line.conflicts.clear();
        let mut random = Random::new(seed);
        for _ in 0..2 {
            let arrow = *random.pick(&line.arrows.clone());
            let any = |random: &mut Random, station| OpId::at(random.below(line.station(station).operations.len()));
            let (from, to) = (any(&mut random, arrow.to.0), any(&mut random, arrow.from.0));
            let reversed = linewright_line::Arrow { from: (arrow.to.0, from), to: (arrow.from.0, to), lag: 0, ..arrow };
            line.arrows.push(reversed);
        }
        if home_is_consistent(&line).is_err() {
            continue;
        }
        let explored = explored(&undisturbed(&line), 300_000);
        let (stops, apart) = (verdict(&explored, DEADLOCK), verdict(&explored, APART));
        let what = || format!("seed {seed}: {:?}\n{}", explored.properties, text(&line));
        if begins_well(&line) {
            assert!(stops == Verdict::Holds || apart == Verdict::Fails, "{}", what());
            live += 1;
        } else {
            assert!(stops == Verdict::Fails || apart == Verdict::Fails, "{}", what());
            stuck += 1;
        }
    }
    println!("{stuck} lines stop, {live} do not");
    assert!(stuck > cases(20) && live > cases(20));
}

/// Whether some assignment of the variables lets both terms hold; only the meaning of the variables is used.
fn can_hold_together(a: &Conjunction, b: &Conjunction) -> bool {
    let mut vars: BTreeSet<Var> = a.iter().chain(b).map(|literal| literal.var).collect();
    for var in vars.clone() {
        vars.extend(match var {
            Var::AdvancePressed => vec![Var::Advance],
            Var::RetractPressed => vec![Var::Retract],
            Var::Pressed(button) => vec![Var::Held(button)],
            Var::OnPath(_) => vec![Var::OnAnyPath],
            _ => Vec::new(),
        });
    }
    let vars: Vec<Var> = vars.into_iter().collect();
    assert!(vars.len() < 16, "{vars:?}");
    (0..1u32 << vars.len()).any(|bits| {
        let is = |var: Var| vars.iter().position(|&known| known == var).is_some_and(|nth| bits & (1 << nth) != 0);
        let makes_sense = vars.iter().filter(|&&var| is(var)).all(|&var| match var {
            Var::AdvancePressed => is(Var::Advance),
            Var::RetractPressed => is(Var::Retract),
            Var::Advance => !is(Var::Retract),
            Var::Pressed(button) => is(Var::Held(button)),
            Var::OnPath(op) => {
                let other = |var: &Var| matches!(var, Var::OnPath(other) if *other != op);
                is(Var::OnAnyPath) && !vars.iter().any(|var| other(var) && is(*var))
            }
            _ => true,
        });
        makes_sense && a.iter().chain(b).all(|literal: &Literal| is(literal.var) == literal.on)
    })
}

/// Whether two transitions out of one place can be meant at once, by trying every assignment.
fn some_overlap(net: &StationNet, transitions: &[StationTransition]) -> bool {
    net.places().iter().any(|place| {
        let outgoing: Vec<&StationTransition> = transitions.iter().filter(|t| t.from.contains(place)).collect();
        let pairs = outgoing.iter().enumerate().flat_map(|(nth, a)| outgoing[nth + 1..].iter().map(move |b| (a, b)));
        pairs.into_iter().any(|(a, b)| {
            ControlMode::ALL
                .iter()
                .any(|&mode| a.terms(mode).iter().any(|ta| b.terms(mode).iter().any(|tb| can_hold_together(ta, tb))))
        })
    })
}

#[test]
fn a_condition_forgotten_is_found_exactly_if_two_transitions_can_then_be_meant_at_once() {
    let (mut found, mut harmless) = (0, 0);
    for seed in 0..cases(4) {
        let line = generate::line(&LineShape { stations: 1..=1, operations: 4..=5, ..LineShape::default() }, seed);
        let net = StationNet::of(&line, line.station_ids().next().expect("it has one station"));
        assert!(overlaps(&net).is_empty() && !some_overlap(&net, net.transitions()), "seed {seed}");
        for nth in 0.. {
            let Some(transitions) = without_literal(&net, nth) else { break };
            let overlaps = overlaps_among(net.places(), &transitions);
            assert_eq!(
                !overlaps.is_empty(),
                some_overlap(&net, &transitions),
                "seed {seed}, literal {nth}: {overlaps:?}"
            );
            if overlaps.is_empty() { harmless += 1 } else { found += 1 }
        }
    }
    println!("{found} forgotten conditions make two transitions overlap, {harmless} do not");
    assert!(found > 100 && harmless > 100);
}

/// A cell whose `lifter` grips and turns side by side.
const CELL: &str = include_str!("../../model/line/tests/descriptions/cell.toml");

fn cell(arrows: &[(&str, &str, u32)]) -> Line {
    let mut line = linewright_line::parse("cell.toml", CELL).expect("the cell is sound").line;
    let keep = |name: &str| line.station_named(name).expect("it has such a station");
    let (feeder, lifter) = (keep("feeder"), keep("lifter"));
    let end = |text: &str| {
        let (station, op) = text.split_once(": ").expect("a station and its operation");
        let station = line.station_named(station).expect("it has such a station");
        (station, line.station(station).operation_named(op).expect("it has such an operation"))
    };
    let arrow = |&(from, to, lag): &(&str, &str, u32)| linewright_line::Arrow {
        from: end(from),
        to: end(to),
        lag,
        auto: true,
        manual: true,
    };
    line.arrows = arrows.iter().map(arrow).collect();
    let span = |station, op: &str| {
        let op = line.station(station).operation_named(op).expect("it has such an operation");
        linewright_line::StateSpan { station, from: op, until: op }
    };
    let (a, b) = (span(feeder, "push"), span(lifter, "turn"));
    line.conflicts = vec![linewright_line::Conflict { why: "the lifter turns into the feeder".to_owned(), a, b }];
    // The press has nothing to do with it.
    let press = line.station_named("press").expect("it has such a station");
    let without = |id: linewright_line::StationId| linewright_line::StationId(id.0 - u16::from(id > press));
    line.stations.remove(press.index());
    line.arrows.iter_mut().for_each(|arrow| (arrow.from.0, arrow.to.0) = (without(arrow.from.0), without(arrow.to.0)));
    line.conflicts.iter_mut().for_each(|c| (c.a.station, c.b.station) = (without(c.a.station), without(c.b.station)));
    line.devices.clear();
    line
}

#[test]
fn operations_side_by_side_wait_for_each_other_s_arrows() {
    // To grip it waits until the feeder has pushed, and the feeder with that until it has turned.
    let mut line = cell(&[("feeder: push", "lifter: grip", 0), ("lifter: turn", "feeder: push", 0)]);
    line.conflicts.clear();
    assert!(home_is_consistent(&line).is_ok());
    let why = every_circuit_has_a_token(&line).unwrap_err();
    assert!(why.contains("feeder: push") && why.contains("lifter: turn"), "{why}");
    let explored = explored(&undisturbed(&line), 100_000);
    assert_eq!(verdict(&explored, DEADLOCK), Verdict::Fails);
}

#[test]
fn what_only_a_neighbour_waits_for_can_be_got_round_by_taking_it_back() {
    let turns_alone = cell(&[("feeder: push", "lifter: grip", 0), ("lifter: turn", "feeder: push", 1)]);
    let gap = separated(&turns_alone, &turns_alone.conflicts[0]).unwrap_err();
    assert!(matches!(gap, Gap::TakenBack(_)) && gap.to_string().contains("`lifter: turn` waits for"), "{gap}");
    assert!(!met(&explored(&undisturbed(&turns_alone), 100_000)), "forward motion keeps them apart");
    assert!(met(&explored(&auto_and_manual(&turns_alone), 100_000)), "taking back does not");

    let itself = cell(&[("feeder: push", "lifter: turn", 0), ("lifter: turn", "feeder: push", 1)]);
    separated(&itself, &itself.conflicts[0]).unwrap();
    let mut setting = auto_and_manual(&itself);
    setting.faults = false;
    let explored = explored(&setting, 200_000);
    assert!(explored.exhausted && !met(&explored));
}

/// No arrow leads back: the feeder goes on while the lifter has done nothing yet.
#[test]
fn a_station_that_runs_ahead_is_named_as_the_one_ahead() {
    let mut line = cell(&[("feeder: push", "lifter: grip", 0)]);
    line.conflicts.clear();
    for (ahead, behind) in [("feeder", "lifter"), ("lifter", "feeder")] {
        if ahead == "lifter" {
            line.arrows.iter_mut().for_each(|arrow| std::mem::swap(&mut arrow.from, &mut arrow.to));
        }
        let explored = explored(&undisturbed(&line), 100_000);
        let apart = explored.properties.iter().find(|of| of.name.starts_with(APART));
        let end = apart.and_then(|of| of.counterexample.as_ref()).map(|path| path.end.clone()).expect("it is found");
        assert!(end.starts_with(&format!("{ahead} is ")) && end.contains(&format!("ahead of {behind},")), "{end}");
    }
}
