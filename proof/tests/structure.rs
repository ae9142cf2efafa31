//! The structure of the shipped line and of a cell with a concurrent group holds, and playing their nets out agrees; a mistake
//! in the chart is found and named.

use linewright_line::net::StationNet;
use linewright_line::{Arrow, Line, OpId, StationId, TransferLine, parse};
use linewright_nets::explore;
use linewright_proof::generate::{self, LineShape};
use linewright_proof::structure::chart::{every_circuit_has_a_token, home_is_consistent, run_ahead, separated};
use linewright_proof::structure::{StructureReport, judge_line, judge_stations};

/// A cell with two operations side by side.
const GROUPED: &str = include_str!("../../model/line/tests/descriptions/cell.toml");

fn line(text: &str) -> Line {
    parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

fn shipped(machines: usize) -> Line {
    line(&TransferLine { machines, time_scale: 1.0 }.text())
}

fn holds(report: &StructureReport) {
    assert_eq!(report.checks.len(), 10);
    for check in &report.checks {
        assert!(check.ok, "{}: {}: {}", report.name, check.name, check.reason);
    }
}

#[test]
fn every_station_of_the_shipped_line_holds_and_playing_it_out_agrees() {
    let line = shipped(1);
    judge_stations(&line).iter().for_each(holds);
    for id in line.station_ids() {
        let played = explore(StationNet::of(&line, id).net(), 1000).unwrap();
        assert!(played.is_live() && played.is_safe() && played.is_reversible().is_ok());
    }
}

#[test]
fn a_station_with_a_concurrent_group_holds_and_playing_it_out_agrees() {
    let line = line(GROUPED);
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
        let line = shipped(machines);
        let checks = judge_line(&line);
        assert!(checks.len() > line.conflicts.len() && checks.iter().all(|check| check.ok), "{checks:?}");
        assert_eq!(run_ahead(&line), []);
    }
}

#[test]
fn a_circuit_without_lag_is_found_and_named() {
    let mut line = shipped(1);
    line.arrows[3].lag = 0;
    let why = every_circuit_has_a_token(&line).unwrap_err();
    assert!(why.contains("clamp_1: return clamp") && why.contains("mill_1: reset main slide"), "{why}");
    let names: Vec<&str> = why.split_once(": ").unwrap().1.split(" → ").collect();
    assert_eq!(names.first(), names.last(), "{why}");
}

#[test]
fn a_home_that_needs_what_is_not_done_is_found() {
    let mut line = shipped(1);
    // At home, the clamp would already have needed this cycle's mill.
    line.arrows[3].lag = 0;
    let why = home_is_consistent(&line).unwrap_err();
    assert!(why.contains("`clamp_1: return clamp` counts as done"), "{why}");
}

/// The arrow that an advice writes out.
fn advised(line: &Line, advice: &str) -> Arrow {
    let value = |key: &str| advice.split_once(&format!("{key} = \"")).and_then(|(_, rest)| rest.split_once('"'));
    let end = |key: &str| {
        let (station, operation) = value(key).and_then(|(name, _)| name.split_once(": ")).expect(advice);
        let id = line.station_named(station).expect(station);
        (id, line.station(id).operation_named(operation).expect(operation))
    };
    let lag = advice.split_once("lag = ").map_or(0, |(_, rest)| rest[..1].parse().expect(advice));
    Arrow { from: end("from"), to: end("to"), lag, auto: true, manual: true }
}

#[test]
fn every_arrow_in_both_modes_is_needed_to_keep_the_conflicts_apart_and_the_advice_puts_it_back() {
    for index in 0..4 {
        let mut line = shipped(1);
        line.arrows.remove(index);
        let found: Vec<_> = line.conflicts.iter().filter_map(|conflict| separated(&line, conflict).err()).collect();
        assert!(!found.is_empty(), "without arrow {index} a conflict must be found");
        let why = found[0].to_string();
        assert!(why.contains("wait for"), "{why}");
        let arrow = advised(&line, &why);
        if let Some(ahead) = run_ahead(&line).first() {
            assert_eq!(advised(&line, &ahead.help), arrow, "one arrow for both: {}", ahead.help);
        }
        line.arrows.push(arrow);
        assert!(line.conflicts.iter().all(|conflict| separated(&line, conflict).is_ok()), "{why}");
        assert_eq!(run_ahead(&line), []);
        assert!(every_circuit_has_a_token(&line).is_ok() && home_is_consistent(&line).is_ok(), "{why}");
    }
}

/// An arrow to the operation that hands on would leave those before it free.
#[test]
fn where_no_conflict_is_described_the_advice_holds_the_whole_cycle_back() {
    for index in 1..4 {
        let mut line = shipped(1);
        line.conflicts.clear();
        line.arrows.remove(index);
        let help = run_ahead(&line).remove(0).help;
        let arrow = advised(&line, &help);
        assert_eq!((arrow.to.1, arrow.lag), (line.station(arrow.to.0).steps[0][0], 1), "{help}");
        line.arrows.push(arrow);
        assert_eq!(run_ahead(&line), []);
        assert!(every_circuit_has_a_token(&line).is_ok() && home_is_consistent(&line).is_ok(), "{help}");
    }
}

#[test]
fn an_arrow_for_auto_alone_does_not_separate() {
    let mut line = shipped(1);
    line.arrows[0].manual = false;
    let why = separated(&line, &line.conflicts[0]).unwrap_err().to_string();
    let arrow = line.arrows[0];
    let [from, to] = [arrow.from, arrow.to].map(|end| full_name(&line, end));
    assert!(why.contains("manual gets round this one, which has to be without `modes`: "), "{why}");
    assert!(why.ends_with(&format!("from = \"{from}\", to = \"{to}\"")), "{why}");
}

#[test]
fn a_lag_more_lets_the_states_overlap() {
    let mut line = shipped(1);
    line.arrows[1].lag = 1;
    let why = separated(&line, &line.conflicts[0]).unwrap_err().to_string();
    assert!(why.contains("in the cycle before, so both can begin before either has ended"), "{why}");
    let [from, to] = [line.arrows[1].from, line.arrows[1].to].map(|end| full_name(&line, end));
    let arrow = format!("from = \"{from}\", to = \"{to}\", lag = 1");
    assert!(why.contains("an arrow may be the wrong way round: ") && why.contains(&arrow), "{why}");
}

/// In a ring each station waits for each other one at some time. Each arrow that is advised there separates, and lets the cycle go on.
#[test]
fn of_states_that_wait_for_each_other_too_far_back_the_missing_arrow_is_named() {
    let shape =
        LineShape { stations: 3..=3, operations: 2..=4, more_arrows: 0, more_conflicts: 2, ..LineShape::default() };
    let mut advised_arrows = 0;
    for seed in 0..60 {
        let whole = generate::line(&shape, seed);
        for index in 0..whole.arrows.len() {
            let mut line = whole.clone();
            line.arrows.remove(index);
            for conflict in &line.conflicts {
                let Err(gap) = separated(&line, conflict) else { continue };
                let text = gap.to_string();
                let Some((_, advice)) = text.split_once("either has ended; an arrow ") else { continue };
                let Some((advice, _)) = advice.split_once(" in both modes keeps them apart") else { continue };
                for one in advice.split(" or ") {
                    let mut mended = line.clone();
                    mended.arrows.push(advised(&line, one));
                    assert!(separated(&mended, conflict).is_ok(), "seed {seed}, without arrow {index}: {text}");
                    assert!(every_circuit_has_a_token(&mended).is_ok(), "seed {seed}, without arrow {index}: {text}");
                    advised_arrows += 1;
                }
            }
        }
    }
    assert!(advised_arrows > 10, "{advised_arrows}");
}

#[test]
fn an_arrow_whose_lag_is_too_large_is_named() {
    let mut line = shipped(1);
    line.arrows[1].lag = 2;
    let arrow = line.arrows[1];
    let why = separated(&line, &line.conflicts[0]).unwrap_err().to_string();
    let [from, to] = [arrow.from, arrow.to].map(|end| full_name(&line, end));
    assert!(why.contains(&format!("from = \"{from}\", to = \"{to}\", lag = 2")), "{why}");
    assert!(!why.contains("nothing in both modes"), "{why}");
}

/// Each arrow that keeps a conflict apart, the wrong way round: it is named, and nothing else is reported of the same slip.
#[test]
fn an_arrow_the_wrong_way_round_is_named_once() {
    for at in 1..4 {
        let mut line = shipped(1);
        let arrow = line.arrows[at];
        (line.arrows[at].from, line.arrows[at].to) = (arrow.to, arrow.from);
        let [from, to] = [arrow.from, arrow.to].map(|end| full_name(&line, end));
        let swapped = format!("the arrow from `{to}` to `{from}` may be the wrong way round");
        let found: Vec<String> =
            line.conflicts.iter().filter_map(|conflict| Some(separated(&line, conflict).err()?.to_string())).collect();
        assert!(found.len() == 1 && found[0].contains(&swapped), "{found:?}");
        assert_eq!(run_ahead(&line), []);
    }
}

#[test]
fn swapped_ends_of_a_conflict_are_named() {
    let mut line = shipped(1);
    let a = &mut line.conflicts[0].a;
    (a.from, a.until) = (a.until, a.from);
    let why = separated(&line, &line.conflicts[0]).unwrap_err().to_string();
    assert!(why.contains("`from` and `until` may be swapped"), "{why}");
}

fn full_name(line: &Line, (station, op): (StationId, OpId)) -> String {
    format!("{}: {}", line.station(station).name, line.operation((station, op)).name)
}

fn joins(line: &Line, arrow: &Arrow, from: &str, to: &str) -> bool {
    line.station(arrow.from.0).name.starts_with(from) && line.station(arrow.to.0).name.starts_with(to)
}

#[test]
fn a_station_that_no_arrow_leads_back_to_runs_ahead_until_each_arrow_back_is_drawn() {
    let (mut line, whole) = (shipped(2), shipped(2));
    line.arrows.retain(|arrow| !joins(&whole, arrow, "clamp", "transfer"));
    let texts = |line: &Line| run_ahead(line).into_iter().map(|ahead| ahead.text).collect::<Vec<_>>();
    let pair = |ahead: &str, behind: &str| {
        format!(
            "{ahead} may run ahead of {behind} in auto without limit: no arrow leads back from there, through others either"
        )
    };
    assert_eq!(texts(&line), [pair("transfer", "clamp_1, mill_1"), pair("transfer", "clamp_2, mill_2")]);
    // As the advice is, for one clamp and then for the other.
    line.arrows.push(advised(&line, &run_ahead(&line)[0].help));
    assert_eq!(texts(&line), [pair("transfer, clamp_1, mill_1", "clamp_2, mill_2")]);
    line.arrows.push(advised(&line, &run_ahead(&line)[0].help));
    assert_eq!(texts(&line), [""; 0]);
    assert!(every_circuit_has_a_token(&line).is_ok());
}

#[test]
fn arrows_of_manual_alone_hold_nothing_back_in_auto() {
    let mut line = shipped(2);
    line.arrows.iter_mut().for_each(|arrow| arrow.auto = false);
    let found = run_ahead(&line);
    assert_eq!(found.len(), 3, "the first pairs");
    assert!(found[0].text.starts_with("transfer and clamp_1 may run ahead of each other"), "{found:?}");
    assert!(found[2].text.ends_with("; and 7 more such pairs"), "five stations are ten pairs: {found:?}");
}
