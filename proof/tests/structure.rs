//! Structure: stations of the shipped line and one with a concurrent group, the chart, and its gaps where arrows are missing.

use linewright_line::net::StationNet;
use linewright_line::{TransferLine, parse};
use linewright_nets::{Net, NetBuilder, explore};
use linewright_proof::structure::chart::{every_circuit_has_a_token, home_is_consistent, separated};
use linewright_proof::structure::reduce::{NotReducible, PlaceGroup, reduce};
use linewright_proof::structure::{StructureReport, judge_stations};
use linewright_testkit::built::transfer_line;

/// A cell with two operations side by side.
const GROUPED: &str = include_str!("../../model/line/tests/descriptions/cell.toml");

fn holds(report: &StructureReport) {
    assert_eq!(report.checks.len(), 10);
    for check in &report.checks {
        assert!(check.ok, "{}: {}: {}", report.name, check.name, check.reason);
    }
}

#[test]
fn every_station_of_the_shipped_line_holds_and_playing_it_out_agrees() {
    let line = transfer_line();
    let reports = judge_stations(&line);
    for (id, report) in line.station_ids().zip(&reports) {
        holds(report);
        let played = explore(StationNet::of(&line, id).net(), 1000).unwrap();
        assert!(played.is_live() && played.is_safe() && played.is_reversible().is_ok());
    }
}

#[test]
fn a_station_with_a_concurrent_group_holds_and_playing_it_out_agrees() {
    let line = parse("cell.toml", GROUPED).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let id = line.station_named("lifter").expect("the station with a group");
    assert!(line.station(id).steps.iter().any(|step| step.len() == 2), "there is a group");
    holds(&judge_stations(&line)[id.index()]);
    let net = StationNet::of(&line, id);
    assert!(net.net().is_state_machine().is_err(), "as it stands it is none");
    let played = explore(net.net(), 10_000).unwrap();
    assert!(played.is_live() && played.is_safe() && played.is_reversible().is_ok());
}

#[test]
fn the_shipped_line_holds_with_any_number_of_machines() {
    for machines in [1, 2, TransferLine::MACHINES_MAX] {
        let line = parse("line.toml", &TransferLine { machines, time_scale: 1.0 }.text()).expect("it is sound").line;
        home_is_consistent(&line).unwrap();
        assert!(every_circuit_has_a_token(&line).unwrap().contains("no station can run away"));
        for conflict in &line.conflicts {
            separated(&line, conflict).unwrap();
        }
    }
}

#[test]
fn a_circuit_without_lag_is_found_and_named() {
    let mut line = transfer_line();
    line.arrows[3].lag = 0;
    let why = every_circuit_has_a_token(&line).unwrap_err();
    assert!(why.contains("clamp_1: return clamp") && why.contains("mill_1: reset main slide"), "{why}");
    let names: Vec<&str> = why.split_once(": ").unwrap().1.split(" → ").collect();
    assert_eq!(names.first(), names.last(), "{why}");
}

#[test]
fn a_home_that_needs_what_is_not_done_is_found() {
    let mut line = transfer_line();
    // Standing at home, the clamp would already have needed this cycle's mill.
    line.arrows[3].lag = 0;
    let why = home_is_consistent(&line).unwrap_err();
    assert!(why.contains("`clamp_1: return clamp` counts as done"), "{why}");
}

#[test]
fn every_arrow_in_both_modes_is_needed_to_keep_the_conflicts_apart() {
    for index in 0..4 {
        let mut line = transfer_line();
        line.arrows.remove(index);
        let found: Vec<_> = line.conflicts.iter().filter_map(|conflict| separated(&line, conflict).err()).collect();
        assert!(!found.is_empty(), "without arrow {index} a conflict must be found");
        assert!(found[0].to_string().contains("wait for"), "{}", found[0]);
    }
}

#[test]
fn an_arrow_for_auto_alone_does_not_separate() {
    let mut line = transfer_line();
    line.arrows[0].manual = false;
    let why = separated(&line, &line.conflicts[0]).unwrap_err().to_string();
    assert!(why.contains("manual gets round them"), "{why}");
}

#[test]
fn a_lag_more_lets_the_states_overlap() {
    let mut line = transfer_line();
    line.arrows[1].lag = 1;
    let why = separated(&line, &line.conflicts[0]).unwrap_err().to_string();
    assert!(why.contains("too early a cycle (2 in all"), "{why}");
}

/// Start, then two branches of two places each, then back to the start.
fn fork_and_join(back_in: [bool; 2], join: [bool; 2]) -> (Net, Vec<PlaceGroup>) {
    let mut b = NetBuilder::new("pair");
    let start = b.place("start", 1);
    let (fork, joined) = (b.transition("fork"), b.transition("join"));
    b.input(fork, start, 1).output(joined, start, 1);
    let mut group = Vec::new();
    for (branch, name) in ["left", "right"].into_iter().enumerate() {
        let (on, off) = (b.place(format!("{name} on"), 0), b.place(format!("{name} off"), 0));
        let done = b.transition(format!("{name} done"));
        b.output(fork, on, 1).input(done, on, 1).output(done, off, 1);
        if back_in[branch] {
            let again = b.transition(format!("{name} again"));
            b.input(again, off, 1).output(again, on, 1);
        }
        if join[branch] {
            b.input(joined, off, 1);
        }
        group.push(vec![on, off]);
    }
    (b.build().unwrap(), vec![group])
}

#[test]
fn a_group_becomes_a_place() {
    let (net, groups) = fork_and_join([true; 2], [true; 2]);
    let reduced = reduce(&net, &groups).unwrap();
    assert_eq!((reduced.place_count(), reduced.transition_count()), (2, 2));
    assert!(reduced.is_state_machine().is_ok() && reduced.is_strongly_connected().is_ok());
}

#[test]
fn a_join_that_leaves_a_branch_out_is_found() {
    let (net, groups) = fork_and_join([true; 2], [true, false]);
    let error = reduce(&net, &groups).unwrap_err();
    assert!(error.to_string().contains("`join`"), "{error}");
}

#[test]
fn a_branch_with_a_dead_end_is_found() {
    let (net, groups) = fork_and_join([true, false], [true; 2]);
    let error = reduce(&net, &groups).unwrap_err();
    assert!(matches!(&error, NotReducible::Branch(_)) && error.to_string().contains("right"), "{error}");
}
