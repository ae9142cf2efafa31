//! A simulated operator: does what the plan says, and looks at it again after each step.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId};
use linewright_recovery::{
    LineSituation, Need, PanelButton, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep, as_received, plan,
};
use linewright_simulation::{LineSim, OperatorAction, SimOptions};
use linewright_station_logic::RejoinAt;

/// Longer than any mode, report or order takes.
const MOMENT: Duration = Duration::from_millis(600);

pub fn run_for(sim: &mut LineSim, long: Duration) {
    let end = sim.now() + long;
    sim.run_to(end);
}

/// A line that has just been switched on, with everything heard.
pub fn switched_on(line: &Line, seed: u64) -> LineSim {
    let options = SimOptions { seed, variation: 0.05, keeps_log: true, ..SimOptions::default() };
    let mut sim = LineSim::new(line, options).expect("the line starts");
    run_for(&mut sim, MOMENT);
    sim
}

pub fn command(sim: &mut LineSim, command: ModeCommand) {
    sim.act(OperatorAction::Command(command)).expect("nothing is started by it");
    run_for(sim, MOMENT);
}

/// In auto, for so long.
pub fn in_auto(line: &Line, seed: u64, long: Duration) -> LineSim {
    let mut sim = switched_on(line, seed);
    command(&mut sim, ModeCommand::Start);
    command(&mut sim, ModeCommand::Auto);
    assert_eq!(sim.mode(), ControlMode::Auto);
    run_for(&mut sim, long);
    sim
}

/// What a console sees.
pub fn situation(sim: &LineSim) -> LineSituation {
    let line = sim.line();
    let hears = |id: StationId| sim.coordinator().is_some_and(|coordinator| coordinator.hears(id));
    let report = |id| sim.controller(id).filter(|_| hears(id)).map(|controller| as_received(controller.report()));
    let stations = line.station_ids().map(report).collect();
    let coordinator = sim.coordinator().expect("the coordinator is up");
    LineSituation::read(line, sim.mode(), coordinator.order().enabled, coordinator.standing(), stations)
}

/// Does a step.
pub fn follow(sim: &mut LineSim, step: &RecoveryStep) {
    let act = |sim: &mut LineSim, action| sim.act(action).expect("nothing is started by it");
    match &step.action {
        RecoveryAction::First(Need::Standstill(_) | Need::Acknowledged) => run_for(sim, Duration::from_secs(3)),
        RecoveryAction::First(Need::Selector(station, input)) => {
            act(sim, OperatorAction::Force(Some(*station), *input, None));
        }
        RecoveryAction::First(need) => panic!("{need:?} is the machine's to end: {}", described(sim)),
        RecoveryAction::Command(command) => act(sim, OperatorAction::Command(*command)),
        RecoveryAction::Press(station, button) => {
            let advance = *button == PanelButton::Advance;
            act(sim, OperatorAction::Panel { station: *station, advance, down: true });
            let long = step.hold(sim.line());
            run_for(sim, long);
            act(sim, OperatorAction::Panel { station: *station, advance, down: false });
        }
        RecoveryAction::Resume => {
            act(sim, OperatorAction::Resume(true));
            let long = step.hold(sim.line());
            run_for(sim, long);
            act(sim, OperatorAction::Resume(false));
        }
        RecoveryAction::Hold { button, .. } => {
            act(sim, OperatorAction::Buttons(1 << button.0));
            run_for(sim, Duration::from_secs(20));
            act(sim, OperatorAction::Buttons(0));
        }
        RecoveryAction::ManualAlone(_) | RecoveryAction::AutoAgain(_) => {
            panic!("no station is led beside auto here: {}", described(sim))
        }
        RecoveryAction::Selector(station, manual) => act(sim, OperatorAction::Selector(*station, *manual)),
        RecoveryAction::Rejoin { station, at, .. } => {
            let within = match at.at {
                RejoinAt::Within(op) => Some(op),
                RejoinAt::Measured | RejoinAt::Rest(_) => None,
            };
            act(sim, OperatorAction::Rejoin(*station, within));
        }
    }
    run_for(sim, MOMENT);
}

/// The situation in words, for a failed test.
pub fn described(sim: &LineSim) -> String {
    let line = sim.line();
    let plan = plan(line, &situation(sim));
    let steps: Vec<String> = plan.steps.iter().map(|step| step.text(line)).collect();
    let stands = |id: StationId| {
        let Some(controller) = sim.controller(id) else { return "down".to_owned() };
        let waits = controller.blocked_by(line, sim.now()).join("; ");
        format!("{}: {} ({}) {waits}", line.station(id).name, controller.operation_text(line), controller.generation())
    };
    let stations: Vec<String> = line.station_ids().map(stands).collect();
    let text = sim.coordinator().map(|c| c.text()).unwrap_or_default();
    format!("{text}\n{}\n{steps:#?}\n{:?}", stations.join("\n"), plan.end)
}

/// Follows plans until auto is in force; gives the first of them. Each plan is the rest of the one before.
pub fn recover(sim: &mut LineSim) -> RecoveryPlan {
    let first = plan(sim.line(), &situation(sim));
    let mut now = first.clone();
    loop {
        assert_eq!(now.end, RecoveryEnd::Auto, "{}", described(sim));
        let Some(step) = now.steps.first().cloned() else { break };
        follow(sim, &step);
        let next = plan(sim.line(), &situation(sim));
        let is_looked_up = matches!(step.action, RecoveryAction::First(_));
        assert!(
            is_looked_up || next.steps.len() < now.steps.len(),
            "after `{}` {} steps are left of {}: {}",
            step.text(sim.line()),
            next.steps.len(),
            now.steps.len(),
            described(sim)
        );
        now = next;
    }
    assert_eq!(sim.mode(), ControlMode::Auto);
    first
}

/// The line works on: every station with a cycle ends more of them.
pub fn works_on(sim: &mut LineSim) {
    let cycles = |sim: &LineSim| sim.record().cycles();
    let before = cycles(sim);
    for _ in 0..60 {
        run_for(sim, Duration::from_secs(5));
        if cycles(sim) > before + 1 {
            break;
        }
    }
    assert_eq!(sim.mode(), ControlMode::Auto, "{}", described(sim));
    assert!(cycles(sim) > before, "{}", described(sim));
    assert_eq!((sim.conflicts(), sim.alarms()), (&[][..], 0));
}
