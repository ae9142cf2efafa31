//! A task-driven station that stands at another rest than its chart has it: a person looks, and confirms it.

use linewright_line::net::ControlMode;
use linewright_station_logic::PanelCommand::Advance;
use linewright_station_logic::{Handled, Ignored, RejoinAt, Restore, StationInput};

use super::bench::{OrderBench, order};

/// By its journal it holds a part; its switches are these.
fn clamped_by_its_journal(on: &[&str]) -> OrderBench {
    let kept = OrderBench::clamped().controller.snapshot();
    let mut m1 = OrderBench::measured(Restore::From(kept), on);
    m1.mode(ControlMode::Manual);
    m1
}

fn rejoin(m1: &mut OrderBench, at: RejoinAt) -> Handled {
    let now = m1.now;
    let handled = m1.controller.handle(now, StationInput::Rejoin(at));
    m1.refresh();
    handled
}

#[test]
fn the_one_rest_that_its_switches_fit_is_confirmed_and_tasks_begin_there() {
    let mut m1 = clamped_by_its_journal(&["C_0", "L_0"]);
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    assert!(m1.controller.position_lost().is_some());
    assert!(m1.fault().contains("confirm it with rejoin"), "{}", m1.fault());
    let waits = m1.blocked_by().join("\n");
    assert!(
        waits.contains("rejoin: axis not where the chart has it; by its switches it stands at rest `open`"),
        "{waits}"
    );
    assert!(rejoin(&mut m1, RejoinAt::Measured).is_taken());
    assert_eq!((m1.rest().as_deref(), m1.fault().as_str()), (Some("open"), ""));
    assert!(!m1.blocked_by().join("\n").contains("rejoin"));
    m1.mode(ControlMode::Auto);
    m1.set("part_present", true);
    m1.done(&order(2, "clamp"));
    // The counts of its record are those of a station that it is taken for again.
    let kept = m1.controller.snapshot();
    assert_eq!(OrderBench::measured(Restore::From(kept), &["C_60", "L_0"]).fault(), "");
}

#[test]
fn without_its_journal_it_is_confirmed_where_it_stands() {
    let mut m1 = OrderBench::measured(Restore::Fresh, &["C_60", "L_0"]);
    m1.mode(ControlMode::Manual);
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("no valid journal; by its switches it stands at rest `clamped`"), "{waits}");
    assert!(rejoin(&mut m1, RejoinAt::Measured).is_taken());
    assert_eq!((m1.rest().as_deref(), m1.fault().as_str()), (Some("clamped"), ""));
}

#[test]
fn a_named_rest_is_taken_if_its_switches_fit_it_and_a_known_position_not_at_all() {
    let mut m1 = clamped_by_its_journal(&["C_0", "L_0"]);
    let rest = |m1: &OrderBench, name| RejoinAt::Rest(m1.line.station(m1.station).rest_named(name).expect("it is one"));
    let (open, clamped) = (rest(&m1, "open"), rest(&m1, "clamped"));
    assert_eq!(rejoin(&mut m1, clamped), Handled::Ignored(Ignored::PositionUnclear));
    assert!(rejoin(&mut m1, open).is_taken());
    for at in [open, clamped, RejoinAt::Measured] {
        assert_eq!(rejoin(&mut m1, at), Handled::Ignored(Ignored::NotLost));
    }
    assert_eq!(m1.rest().as_deref(), Some("open"));
}

#[test]
fn between_two_switches_the_operation_is_named_and_its_panel_leads_it_on() {
    let mut m1 = clamped_by_its_journal(&["L_0"]);
    assert_eq!(rejoin(&mut m1, RejoinAt::Measured), Handled::Ignored(Ignored::PositionUnclear));
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("possible: `clamp close`, `clamp open`"), "{waits}");
    let opens = m1.line.station(m1.station).operation_named("clamp open");
    assert!(rejoin(&mut m1, opens.into()).is_taken());
    assert_eq!((m1.doing().as_str(), m1.outputs), ("clamp open (stopped)", 0), "nothing moves by it");
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("advance (go on) or return (take back) at its panel in manual, for clamp open"), "{waits}");
    m1.through(Advance(true));
    assert_eq!((m1.rest().as_deref(), m1.fault().as_str()), (Some("open"), ""));
}
