//! *Resume*: in a plan it is one press for several stations, and at each of them it does what its panel would do, or nothing.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId};
use linewright_proof::generate::{self, LineShape};
use linewright_recovery::{RecoveryAction, RecoveryEnd, plan};
use linewright_simulation::{LineSim, OperatorAction};
use linewright_station_logic::{Controller, ModeOrder, PanelCommand, StationInput, StationOutbox};
use linewright_testkit::built::transfer_line;

use crate::brute_force::{LineCopy, NOW, disturbed};
use crate::operator::{command, in_auto, recover, situation, works_on};

/// Steps a controller until nothing follows; the transitions that have fired.
fn play(controller: &mut Controller, out: &mut StationOutbox) -> Vec<u16> {
    let mut fired = Vec::new();
    for _ in 0..4 {
        controller.step(NOW, out);
        // A step that does nothing leaves those of the one before.
        fired.extend(controller.fired().iter().filter(|_| out.changed));
    }
    fired
}

fn resume(controller: &mut Controller, held: bool) {
    let manual = ModeOrder::of(1, 1, ControlMode::Manual, ModeOrder::FOR_GOOD);
    controller.handle(NOW, StationInput::Order(ModeOrder { manual_all: true, resume: held, ..manual }));
}

fn advance(controller: &mut Controller, held: bool) {
    controller.handle(NOW, StationInput::Panel(PanelCommand::Advance(held)));
}

/// One station, led on once by each of the two. Whether resume has moved anything.
fn compare(copy: &LineCopy, station: usize) -> bool {
    let [mut by_resume, mut by_panel] = [(), ()].map(|()| copy.controllers[station].clone());
    let (mut seen, mut wanted) = (StationOutbox::default(), StationOutbox::default());
    let before = by_resume.report();
    resume(&mut by_resume, true);
    advance(&mut by_panel, true);
    let fired = play(&mut by_resume, &mut seen);
    let wanted_fired = play(&mut by_panel, &mut wanted);
    if fired.is_empty() {
        assert_eq!(by_resume.report(), before, "nothing has changed");
        return false;
    }
    assert_eq!(fired, wanted_fired);
    let same = |a: &Controller, b: &Controller, seen: &StationOutbox, wanted: &StationOutbox| {
        assert_eq!((a.report(), seen.outputs), (b.report(), wanted.outputs));
    };
    same(&by_resume, &by_panel, &seen, &wanted);
    // Let go half-way, and from there once more.
    let (mut let_go, mut let_go_panel) = (by_resume.clone(), by_panel.clone());
    for held in [false, true] {
        resume(&mut let_go, held);
        advance(&mut let_go_panel, held);
        assert_eq!(play(&mut let_go, &mut seen), play(&mut let_go_panel, &mut wanted));
        same(&let_go, &let_go_panel, &seen, &wanted);
    }
    // To its end, and held on.
    let mut ends = [by_resume, by_panel].map(|controller| {
        let mut alone = copy.clone();
        alone.controllers[station] = controller;
        alone.arrive(station);
        alone
    });
    let (mut seen, mut wanted) = (StationOutbox::default(), StationOutbox::default());
    for held in [true, false] {
        resume(&mut ends[0].controllers[station], held);
        advance(&mut ends[1].controllers[station], held);
        play(&mut ends[0].controllers[station], &mut seen);
        play(&mut ends[1].controllers[station], &mut wanted);
        same(&ends[0].controllers[station], &ends[1].controllers[station], &seen, &wanted);
    }
    true
}

#[test]
fn at_each_station_it_does_what_advance_at_its_panel_does_or_nothing() {
    let shape = LineShape { irreversible: 40, ..LineShape::small() };
    let generated = (0..60).map(|seed| disturbed(&generate::line(&shape, seed), seed));
    let shipped = (0..40).map(|seed| disturbed(&transfer_line(), seed));
    let (mut moved, mut still) = (0, 0);
    for sim in generated.chain(shipped) {
        let copy = LineCopy::of(&sim);
        for station in 0..sim.line().stations.len() {
            if compare(&copy, station) { moved += 1 } else { still += 1 }
        }
    }
    assert!(moved > 30 && still > 30, "both are seen often: {moved}, {still}");
}

/// Stopped by an emergency stop, so long after auto.
fn stopped_after(line: &Line, long: Duration) -> LineSim {
    let mut sim = in_auto(line, 3, long);
    command(&mut sim, ModeCommand::EStop);
    sim
}

fn incomplete(sim: &LineSim) -> Vec<StationId> {
    let stands = |id: &StationId| sim.controller(*id).is_some_and(|of| !of.report().incomplete.is_empty());
    sim.line().station_ids().filter(stands).collect()
}

#[test]
fn several_stations_that_were_stopped_half_way_need_one_press() {
    let line = transfer_line();
    let mut several = 0;
    for tenths in 0..60 {
        let mut sim = stopped_after(&line, Duration::from_millis(tenths * 150));
        let stopped = incomplete(&sim);
        let found = plan(&line, &situation(&sim));
        assert_eq!((&found.end, found.is_shortest), (&RecoveryEnd::Auto, true));
        let actions: Vec<&RecoveryAction> = found.steps.iter().map(|step| &step.action).collect();
        assert_eq!(actions.contains(&&RecoveryAction::Resume), stopped.len() > 1, "{stopped:?}: {actions:?}");
        assert_eq!(found.presses(), stopped.len().min(1));
        if stopped.len() > 1 {
            several += 1;
            if several % 4 == 1 {
                recover(&mut sim);
                works_on(&mut sim);
            }
        }
    }
    assert!(several > 5, "{several} of 60");
}

#[test]
fn where_selectors_have_led_to_manual_each_panel_is_used() {
    let line = transfer_line();
    let sims = (0..60).map(|tenths| stopped_after(&line, Duration::from_millis(tenths * 150)));
    let mut sim = sims.into_iter().find(|sim| incomplete(sim).len() > 1).expect("some stop several");
    let stopped = incomplete(&sim);
    sim.act(OperatorAction::Selector(stopped[0], true)).expect("it is done");
    command(&mut sim, ModeCommand::Reset);
    assert_eq!(sim.mode(), ControlMode::Manual);
    let found = plan(&line, &situation(&sim));
    assert!(found.steps.iter().all(|step| step.action != RecoveryAction::Resume), "{:?}", found.steps);
    assert_eq!(found.presses(), stopped.len());
    recover(&mut sim);
}
