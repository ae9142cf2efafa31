//! Why a plan has each of its presses.

use std::time::Duration;

use linewright_line::StationId;
use linewright_proof::generate::{self, LineShape};
use linewright_recovery::{LineSituation, PanelButton, RecoveryAction, RecoveryStep, plan};
use linewright_simulation::{LineSim, NodeProcess, OperatorAction};
use linewright_testkit::built::transfer_line;

use crate::brute_force::disturbed;
use crate::operator::{in_auto, run_for, situation};

/// The presses of a plan, each with its reason.
fn reasons(sim: &LineSim) -> Vec<String> {
    let (line, now) = (sim.line(), situation(sim));
    let found = plan(line, &now);
    let all = found.steps.iter().zip(found.reasons(line, &now));
    all.filter_map(|(step, why)| Some(format!("{} ({})", step.text(line), why?.text(line)))).collect()
}

/// Clamp 1 has lost its memory, the tool of the mill is forward.
#[test]
fn a_station_that_is_in_the_way_is_moved_for_the_one_that_is_refused() {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(1130));
    let clamp = NodeProcess::Station(StationId(1));
    for action in [OperatorAction::Kill(clamp), OperatorAction::RestartEmpty(clamp)] {
        sim.act(action).expect("it is done");
        run_for(&mut sim, Duration::from_secs(3));
    }
    assert_eq!(
        reasons(&sim),
        [
            "mill_1: hold return until `rapid advance positioning slide` is undone: positioning_slide to 0, LS_positioning_0 on, 0.3 s \
             (mill_1 is not at home, where all begin anew; otherwise clamp_1 is refused `return clamp`)",
            "clamp_1: hold advance until `return clamp` is done: stroke to 0, LS_open on, 0.2 s (`return clamp` of clamp_1 is incomplete)",
        ]
    );
}

#[test]
fn what_is_taken_back_and_what_is_led_on_have_their_reasons() {
    assert_eq!(
        reasons(&disturbed(&transfer_line(), 105)),
        [
            "mill_1: hold return until `rapid advance positioning slide` is undone: positioning_slide to 0, LS_positioning_0 on, 0.3 s \
             (undoing `rapid advance positioning slide` of mill_1 is incomplete)",
            "mill_1: hold return until `reset main slide` is done: main_slide to 0, LS_main_0 on, 0.3 s (mill_1 is on its recovery path)",
        ]
    );
    assert_eq!(
        reasons(&disturbed(&transfer_line(), 22)),
        [
            "mill_1: hold advance until `feed main slide` is done: main_slide to 60, LS_main_60 on, 0.7 s \
             (`feed main slide` of mill_1 is incomplete)",
            "transfer: hold advance until `return transfer` is done: horizontal to 0, LS_horizontal_0 on, 0.5 s \
             (undoing `return transfer` of transfer is incomplete)",
        ]
    );
}

/// A single *advance* explains itself; of a single *return* it is to be seen why it is not *advance*.
#[test]
fn one_press_alone_has_a_reason_where_it_leads_back() {
    let sims = (0..80).map(|seed| disturbed(&transfer_line(), seed));
    let mut seen = [0, 0];
    for sim in sims.filter(|sim| plan(sim.line(), &situation(sim)).presses() == 1) {
        let found = plan(sim.line(), &situation(&sim));
        let is_back = |step: &RecoveryStep| matches!(step.action, RecoveryAction::Press(_, PanelButton::Return));
        let is_back = found.steps.iter().any(is_back);
        assert_eq!(!reasons(&sim).is_empty(), is_back, "{:?}", found.steps);
        seen[usize::from(is_back)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
}

/// The feed of the mill is irreversible, and has a recovery path.
#[test]
fn what_return_alone_leads_home_is_known() {
    let sim = disturbed(&transfer_line(), 22);
    let (line, now) = (sim.line(), situation(&sim));
    let found = plan(line, &now);
    let home = |name: &str| found.returns_home(line, &now, line.station_named(name).expect("it is there"));
    assert_eq!([home("mill_1"), home("transfer")], [true, false]);
}

/// The mechanism stands where the recovery path ends: the press moves nothing, and ends the path. Where it is the only press, too.
#[test]
fn a_press_that_moves_nothing_has_its_reason() {
    let shape = LineShape { irreversible: 40, ..LineShape::small() };
    for is_alone in [true, false] {
        let sims = (0..60).map(|seed| disturbed(&generate::line(&shape, seed), seed));
        let plans = sims.map(|sim| (plan(sim.line(), &situation(&sim)), sim));
        let is_still = |step: &RecoveryStep| matches!(step.action, RecoveryAction::Press(..)) && step.moves.is_empty();
        let mut plans = plans.filter(|(plan, _)| (plan.presses() == 1) == is_alone && plan.steps.iter().any(is_still));
        let (found, sim) = plans.next().expect("some have one");
        let at = found.steps.iter().position(is_still).expect("it has one");
        let (step, line) = (&found.steps[at], sim.line());
        assert!(step.after.as_ref().is_some_and(|after| after.at_home), "{step:?}");
        let name = &line.station(step.action.station().expect("a press is at a station")).name;
        let why = found.reasons(line, &situation(&sim))[at].as_ref().map(|why| why.text(line)).unwrap_or_default();
        assert_eq!(
            why,
            format!("{name} is on its recovery path, and stands at the end of it: this press ends the path")
        );
    }
}

/// A station is killed at some moment of the cycle, and started again.
fn killed(at: u64, station: u16) -> LineSim {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(at));
    let node = NodeProcess::Station(StationId(station));
    for action in [OperatorAction::Kill(node), OperatorAction::Restart(node)] {
        sim.act(action).expect("it is done");
        run_for(&mut sim, Duration::from_secs(3));
    }
    sim
}

/// Where *advance* moves nothing that is seen to arrive, it is not called the longer way.
#[test]
fn back_is_called_shorter_only_where_on_moves_something() {
    let mut unseen = 0;
    let moments = (0..2_400).step_by(20).flat_map(|at| [0, 1].map(|station| (at, station)));
    for sim in moments.map(|(at, station)| killed(at, station)) {
        let (line, now) = (sim.line(), situation(&sim));
        let found = plan(line, &now);
        let all = found.steps.iter().zip(found.reasons(line, &now));
        for (step, why) in all.filter_map(|(step, why)| Some((step, why?.text(line)))) {
            let RecoveryAction::Press(station, _) = step.action else { continue };
            let on = plan(line, &LineSituation { lead_on: vec![station], ..now.clone() });
            let is_press = |of: &&RecoveryStep| of.action == RecoveryAction::Press(station, PanelButton::Advance);
            let Some(on) = on.steps.iter().find(is_press) else { continue };
            let is_seen = !on.moves.is_empty() && !on.is_doubtful;
            assert!(is_seen || !why.ends_with("back is shorter than on"), "{why}: {on:?}");
            if why.ends_with("no motion would be seen to arrive") {
                unseen += 1;
                assert!(!is_seen, "{why}: {on:?}");
            }
        }
    }
    assert!(unseen > 0, "some stand where their motion ends");
}
