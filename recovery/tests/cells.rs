//! The shipped cells: every station was stopped in the middle of a task, and is led to a rest.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Line, StationId, Tick, parse};
use linewright_recovery::LineSituation;
use linewright_station_logic::{
    Controller, NO_DELAY, Restore, StationInput, StationOutbox, StationReport, StationSnapshot,
};

/// Name and line of both.
pub fn shipped() -> [(&'static str, Line); 2] {
    [
        ("workcell-c1", include_str!("../../launch-config/lines/workcell-c1/line.toml")),
        ("assembly-cell", include_str!("../../launch-config/lines/assembly-cell/line.toml")),
    ]
    .map(|(name, text)| (name, parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line))
}

/// Stopped in an operation in the middle of its longest task; of one that needs no leading, at a rest.
fn stopped(line: &Line, id: StationId) -> StationReport {
    let station = line.station(id);
    let fresh = Controller::new(line, id, 7, Restore::Fresh).expect("a shipped station compiles");
    // Its devices have confirmed where it stands.
    let mut snapshot = StationSnapshot { placed: true, ..fresh.snapshot() };
    if let Some(task) = station.tasks.iter().max_by_key(|task| task.steps.len()) {
        let step = &station.steps[task.steps.start + task.steps.len() / 2];
        snapshot.cycle += 1;
        for &op in step {
            snapshot.started[op.index()] = snapshot.done[op.index()] + 1;
        }
        snapshot.marking = step.iter().map(|&op| StationPlace::incomplete(op)).collect();
    }
    let bits = snapshot.marking.iter().fold(0, |bits, &place| bits | station.rest_inputs(place));
    // What it has grasped is still in its hand.
    let results = station.operations.iter().filter_map(|op| op.result);
    let bits = results.fold(bits, |bits, result| bits | result.input.bit());
    let mut controller = Controller::new(line, id, 7, Restore::From(snapshot)).expect("its own");
    let (now, until, under) = (Tick::from_millis(1), Tick::NEVER, NO_DELAY);
    controller.handle(now, StationInput::Inputs { bits, valid: true, until, under });
    controller.step(now, &mut StationOutbox::default());
    controller.report()
}

/// All of them, in stand-by.
pub fn half_way(line: &Line) -> LineSituation {
    let stations = line.station_ids().map(|id| Some(stopped(line, id))).collect();
    LineSituation::of(line, ControlMode::StandBy, stations)
}

#[test]
fn every_station_of_a_shipped_cell_is_led_to_a_rest() {
    for (name, line) in shipped() {
        let seen = half_way(&line);
        let stopped = seen.stations.iter().flatten().filter(|report| !report.incomplete.is_empty()).count();
        assert!(stopped > 2, "{name}: {stopped}");
        let found = linewright_recovery::plan(&line, &seen);
        let steps: Vec<String> = found.steps.iter().map(|step| step.text(&line)).collect();
        assert_eq!(
            (&found.end, found.is_shortest),
            (&linewright_recovery::RecoveryEnd::Auto, true),
            "{name}: {steps:#?}"
        );
        let resumes = |steps: &[String]| steps.iter().filter(|text| text.starts_with("hold resume")).count();
        assert_eq!(resumes(&steps), 1, "{name}: {steps:#?}");
        // With memories from before the last start of their hosts each is led on by somebody who sees it.
        let mut seen = seen;
        seen.stations.iter_mut().flatten().for_each(|report| report.placed = false);
        let by_panels = linewright_recovery::plan(&line, &seen);
        let texts: Vec<String> = by_panels.steps.iter().map(|step| step.text(&line)).collect();
        assert_eq!(
            (&by_panels.end, resumes(&texts)),
            (&linewright_recovery::RecoveryEnd::Auto, 0),
            "{name}: {texts:#?}"
        );
        assert!(by_panels.presses() > found.presses(), "{name}: {texts:#?}");
        let last =
            |id: StationId| found.steps.iter().rev().find_map(|step| step.after.as_ref().filter(|of| of.station == id));
        let rest = |id: &StationId| last(*id).is_none_or(|after| after.at_home && after.is_in_order);
        assert!(line.station_ids().all(|id| rest(&id)), "{name}: {steps:#?}");
    }
}
