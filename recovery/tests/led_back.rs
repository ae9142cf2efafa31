//! What becomes of a part where a station is led back and auto begins anew, and the other way.

use std::time::Duration;

use linewright_line::StationId;
use linewright_plant::MotionFault;
use linewright_recovery::{LedBack, LineSituation, PanelButton, RecoveryAction, RecoveryEnd, RecoveryPlan, plan};
use linewright_simulation::{LineSim, MotionSelection, NodeProcess, OperatorAction};
use linewright_testkit::built::transfer_line;

use crate::operator::{in_auto, run_for, situation};

/// Clamp 1 has lost its memory, the tool of the mill is forward.
fn without_memory() -> LineSim {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(1130));
    let clamp = NodeProcess::Station(StationId(1));
    for action in [OperatorAction::Kill(clamp), OperatorAction::RestartEmpty(clamp)] {
        sim.act(action).expect("it is done");
        run_for(&mut sim, Duration::from_secs(3));
    }
    sim
}

fn presses(plan: &RecoveryPlan, station: StationId) -> Vec<PanelButton> {
    let press = |action: &RecoveryAction| match *action {
        RecoveryAction::Press(at, button) if at == station => Some(button),
        _ => None,
    };
    plan.steps.iter().filter_map(|step| press(&step.action)).collect()
}

#[test]
fn what_is_led_back_has_its_other_way_named_and_can_be_led_on() {
    let sim = without_memory();
    let (line, now) = (sim.line(), situation(&sim));
    let mill = line.station_named("mill_1").expect("a station");
    let found = plan(line, &now);
    assert_eq!(presses(&found, mill), [PanelButton::Return]);
    let texts: Vec<String> = found.led_back.iter().map(|back| back.text(line)).collect();
    assert_eq!(
        texts,
        [
            "mill_1 is led back to where its cycle began, before `rapid advance positioning slide` (after `advance clamp` of clamp_1). \
          The part that it was to take then stays in the machine before it, and the next one may come onto it; what it was \
          working on is not finished; if it grips anything, it lets it go. Look where its part is; the other way: 4 presses of advance, on to the end of its cycle"
        ]
    );
    let on = LineSituation { lead_on: vec![mill], ..now };
    let found = plan(line, &on);
    assert_eq!(found.end, RecoveryEnd::Auto);
    assert_eq!(found.begin_text(line), None);
    assert!(presses(&found, mill).iter().all(|button| *button == PanelButton::Advance), "{:?}", found.steps);
    assert!(found.led_back.iter().all(|back| back.station != mill));
    assert!(presses(&found, mill).len() > 1);
}

/// A motion that has begun, and jams before it has left its switch: what takes it back moves nothing.
#[test]
fn what_is_taken_back_without_a_motion_is_named_as_well() {
    let mut sim = in_auto(&transfer_line(), 1, Duration::from_millis(10));
    let (line, clamp) = (sim.line().clone(), NodeProcess::Station(StationId(1)));
    let mill = line.station_named("mill_1").expect("a station");
    let first = line.station(mill).op_ids().next().expect("an operation");
    let stick = OperatorAction::Fail((mill, first), MotionSelection::Normal, Some(MotionFault::Stick));
    sim.act(stick).expect("it is done");
    run_for(&mut sim, Duration::from_secs(8));
    for action in [OperatorAction::Kill(clamp), OperatorAction::RestartEmpty(clamp)] {
        sim.act(action).expect("it is done");
        run_for(&mut sim, Duration::from_secs(3));
    }
    let now = situation(&sim);
    let found = plan(&line, &now);
    let press = found.steps.iter().find(|step| step.action == RecoveryAction::Press(mill, PanelButton::Return));
    assert!(press.is_some_and(|press| press.moves.is_empty()), "{}", crate::operator::described(&sim));
    let back = found.led_back.iter().find(|back| back.station == mill).expect("it is named");
    assert_eq!((&back.taken_back[..], back.presses_on), (&[first][..], Some(5)));
}

/// Its last list is *command auto* alone: what becomes of parts stands there too.
#[test]
fn what_auto_does_to_parts_stands_below_every_list_that_ends_in_a_new_cycle() {
    let mut sim = without_memory();
    let mut lists = 0;
    loop {
        let (line, now) = (sim.line().clone(), situation(&sim));
        let found = plan(&line, &now);
        let Some(step) = found.steps.first() else { break };
        let text = found.end_text(&line).join(" ");
        assert!(text.contains("auto begins a new cycle at every station"), "{text} below {:?}", found.steps);
        lists += 1;
        crate::operator::follow(&mut sim, step);
    }
    assert!(lists > 3, "{lists} lists");
}

/// Before the position of a station is confirmed no presses are counted, so the other way is not denied.
#[test]
fn of_a_station_whose_position_is_to_be_confirmed_the_way_on_is_named_by_its_command() {
    let line = transfer_line();
    let station = line.station_named("mill_1").expect("a station");
    let taken_back = line.station(station).op_ids().take(1).collect();
    let mut back = LedBack { station, taken_back, presses_on: None, is_unconfirmed: true };
    assert!(back.text(&line).ends_with("; the other way, if there is one, is listed by `recover --on mill_1`"));
    back.is_unconfirmed = false;
    assert!(back.text(&line).ends_with("; advance alone does not lead it on from here"));
}
