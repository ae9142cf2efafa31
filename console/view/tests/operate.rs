//! What may be given, why the rest may not, and the button of the step that comes next.

use linewright_console_view::{OperateButton, PlanPart};
use linewright_line::StationId;
use linewright_line::net::ControlMode;
use linewright_msgs::{LineState, StationState};
use linewright_recovery::{PanelButton, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep};

use crate::bench::ViewBench;

/// The reasons of some buttons, by their keys.
fn reasons<'b>(buttons: impl IntoIterator<Item = &'b OperateButton>) -> Vec<(String, Option<String>)> {
    buttons.into_iter().map(|of| (of.key.clone(), of.why_not.clone())).collect()
}

#[test]
fn the_mode_takes_some_commands_and_the_others_name_them() {
    let mut bench = ViewBench::received(0);
    let mut possible = |change: fn(&mut LineState)| {
        change(&mut bench.coordinator.as_mut().expect("received").0);
        let commands = bench.page(1).operate.commands;
        let keys = commands.iter().filter(|of| of.why_not.is_none()).map(|of| of.label.clone()).collect::<Vec<_>>();
        keys.join(" ")
    };
    assert_eq!(possible(|_| {}), "stop estop");
    assert_eq!(possible(|of| of.master_stop = true), "start stop estop");
    assert_eq!(possible(|of| of.mode = StationState::MODE_HOME), "start manual estop");
    assert_eq!(possible(|of| of.mode = StationState::MODE_STANDBY), "start stop auto hand manual estop");
    assert_eq!(possible(|of| of.mode = StationState::MODE_HAND), "stop auto estop");
    assert_eq!(possible(|of| of.mode = StationState::MODE_MANUAL), "start stop auto hand estop");
    assert_eq!(possible(|of| of.mode = StationState::MODE_ESTOP), "manual estop");
    assert_eq!(possible(|of| of.estop_latched = true), "estop reset");
    let all = reasons(&bench.page(1).operate.commands);
    assert_eq!(all[0].1.as_deref(), Some("not possible in other; possible: reset, estop"));
    // Without a coordinator nothing but the stop, which it may receive.
    let late = bench.fresh() + 1;
    let all = reasons(&bench.page(late).operate.commands);
    assert_eq!(
        all.iter().filter(|(_, why)| why.is_none()).map(|(key, _)| &**key).collect::<Vec<_>>(),
        ["command estop"]
    );
    assert_eq!(all[0].1.as_deref(), Some("no state received from the coordinator"));
}

#[test]
fn a_held_button_names_the_mode_in_which_it_acts() {
    let mut bench = ViewBench::received(0);
    let page = bench.page(1);
    let why = |of: &OperateButton| of.why_not.clone().unwrap_or_default();
    assert_eq!(why(&page.operate.hand[0]), "hand-mode buttons act in hand mode only; the mode is auto");
    assert_eq!(why(&page.operate.resume), "it takes effect in manual only; the mode is auto");
    assert_eq!(why(&page.operate.panels[0].holds[0]), "a panel acts in manual mode only; the mode is auto");
    bench.coordinator.as_mut().expect("received").0.mode = StationState::MODE_MANUAL;
    bench.stations[0].as_mut().expect("received").0.mode = StationState::MODE_MANUAL;
    let page = bench.page(1);
    let step_by_step = "step by step with advance or return at each station's panel, as `linewright recover` lists it";
    assert_eq!(why(&page.operate.resume), format!("no operation is incomplete; go on {step_by_step}"));
    assert_eq!((why(&page.operate.panels[0].holds[0]), page.operate.panels[0].is_manual), (String::new(), Some(false)));
    assert!(!why(&page.operate.panels[1].holds[0]).is_empty(), "its station is not in manual yet");
    bench.stations[1].as_mut().expect("received").0.incomplete = vec![0];
    assert_eq!(why(&bench.page(1).operate.resume), "");
    bench.stations[0] = None;
    let panel = &bench.page(1).operate.panels[0];
    assert_eq!((why(&panel.holds[0]), panel.is_manual), (format!("no state received from {}", panel.station), None));
}

#[test]
fn the_next_step_of_the_way_back_has_the_button_that_does_it() {
    let line = ViewBench::new(false).line;
    let step =
        |action| RecoveryStep { action, moves: Vec::new(), is_doubtful: false, mode: ControlMode::Manual, after: None };
    let press = step(RecoveryAction::Press(StationId(2), PanelButton::Return));
    let auto = step(RecoveryAction::Command(linewright_coordinator_logic::ModeCommand::Auto));
    let texts = [press.text(&line), auto.text(&line)];
    let plan =
        |steps| PlanPart::of(&line, &RecoveryPlan::ends(steps, RecoveryEnd::Auto), &[Some("it is nearer".to_owned())]);
    let found = plan(vec![press, auto.clone()]);
    assert_eq!(found.steps.iter().map(|of| of.text.clone()).collect::<Vec<_>>(), texts);
    assert_eq!((found.next, found.steps[0].since.as_deref()), (Some(0), Some("it is nearer")));
    // The same key as at the panel, so that it is the same button.
    let of_panel = &ViewBench::received(0).page(1).operate.panels[2].holds[1];
    assert_eq!(found.button.expect("a button").key, of_panel.key);
    assert_eq!(plan(vec![auto]).button.expect("a button").key, "command auto");
    let selector = step(RecoveryAction::Selector(StationId(0), false));
    let name = &line.station(StationId(0)).name;
    assert_eq!(plan(vec![selector]).button.expect("a button").key, format!("select auto {name}"));
}
