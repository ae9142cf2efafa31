//! Beyond the limits the verdict is undecided, or a refusal, never a yes, and memory stays within its limit.

use linewright_line::net::ControlMode;
use linewright_line::{Line, parse};
use linewright_proof::explore::{
    LimitReached, LineExploration, LineExplored, LineNotExplorable, SearchLimits, Verdict, explore,
};
use linewright_proof::generate::{self, LineShape};

use crate::common::explored;

const MEBIBYTE: usize = 1 << 20;

/// One station that moves so many axes side by side, out and back.
fn side_by_side(count: usize) -> Line {
    let hand = "hand = { type = 6, forward = \"F\", back = \"B\", next = \"F\" }";
    let operation = |name: String, axis: String, (from, to): (u32, u32), with: Option<&str>| {
        let (there, back) = if from < to { ("out", "in") } else { ("in", "out") };
        let with = with.map_or(String::new(), |first| format!("with = \"{first}\"\n"));
        format!(
            "[[station.operation]]\nname = \"{name}\"\nmodule = \"R\"\n\
             moves = {{ axis = \"{axis}\", from = {from}, to = {to} }}\nduration_s = 0.5\nwatchdog_s = 1.0\n\
             normal = {{ actuator = \"Y_{axis}_{there}\", complete = \"{axis}_{to}\" }}\n\
             recovery = {{ actuator = \"Y_{axis}_{back}\", complete = \"{axis}_{from}\" }}\n{hand}\n{with}\n"
        )
    };
    let axes: Vec<String> = (0..count).map(|nth| format!("x{nth}")).collect();
    let all = || axes.iter().map(String::as_str).chain(["main"]);
    let group = |name: &str, ends: (u32, u32)| {
        let one = |(nth, axis): (usize, &String)| {
            operation(format!("{name} {nth}"), axis.clone(), ends, (nth > 0).then_some(&format!("{name} 0")))
        };
        axes.iter().enumerate().map(one).collect::<String>()
    };
    let quoted = |names: Vec<String>| {
        format!("[{}]", names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", "))
    };
    let switches = all().flat_map(|axis| [format!("{axis}_0"), format!("{axis}_1")]);
    let inputs = ["S", "P", "Q"].map(String::from).into_iter().chain(switches).collect();
    let outputs = all().flat_map(|axis| [format!("Y_{axis}_out"), format!("Y_{axis}_in")]).collect();
    let text = [
        "name = \"wide\"\nbuttons = [\"F\", \"B\"]\n[timing]\nrefresh_ms = 40\nstale_ms = 200\n".to_owned(),
        "[[station]]\nname = \"s\"\nhome = \"back\"\n".to_owned(),
        format!("axes = {{ {} }}\n", all().map(|axis| format!("{axis} = 0.0")).collect::<Vec<_>>().join(", ")),
        "panel = { manual = \"S\", advance = \"P\", return = \"Q\" }\n".to_owned(),
        operation("on".to_owned(), "main".to_owned(), (0, 1), None),
        group("out", (0, 1)),
        group("in", (1, 0)),
        operation("back".to_owned(), "main".to_owned(), (1, 0), None),
        format!(
            "[[device]]\nname = \"d\"\nnode = 1\nstation = \"s\"\ninputs = {}\noutputs = {}\n",
            quoted(inputs),
            quoted(outputs)
        ),
    ];
    parse("wide.toml", &text.concat()).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

/// A row of stations of few operations.
fn row(stations: usize) -> Line {
    generate::line(&LineShape { operations: 2..=3, ..LineShape::row(stations) }, 1)
}

fn is_no_yes(explored: &LineExplored) {
    assert!(!explored.exhausted && !explored.holds());
    assert!(explored.properties.iter().all(|property| property.verdict == Verdict::Undecided), "{explored:?}");
}

#[test]
fn a_station_that_can_do_very_much_by_itself_takes_no_more_memory_than_allowed() {
    for lumped in [true, false] {
        let mut setting = LineExploration::new(&side_by_side(8));
        setting.lumped = lumped;
        let bytes = 32 * MEBIBYTE;
        let explored =
            explore(&setting, SearchLimits { bytes, ..SearchLimits::default() }).expect("one station can be explored");
        println!("lumped {lumped}: {} states, {} kept, {} MiB", explored.states, explored.kept, explored.bytes >> 20);
        is_no_yes(&explored);
        assert_eq!(explored.limit, Some(LimitReached::Memory));
        // One class of situations, and one batch of states, may come on top.
        assert!(explored.bytes < 2 * bytes, "{}", explored.bytes);
    }
}

#[test]
fn classes_that_are_found_in_pieces_change_no_verdict() {
    let mut setting = LineExploration::new(&side_by_side(4));
    let lumped = explore(&setting, SearchLimits::default()).expect("one station can be explored");
    setting.lumped = false;
    let plain = explore(&setting, SearchLimits::default()).expect("one station can be explored");
    println!("{} states, {} kept", plain.states, lumped.kept);
    // More than are compared together.
    assert!(plain.exhausted && plain.states > 3 * 4096 && 1 < lumped.kept && lumped.kept < plain.kept);
    assert_eq!((lumped.states, lumped.arcs, &lumped.properties), (plain.states, plain.arcs, &plain.properties));
}

#[test]
fn a_limit_of_states_ends_a_search_at_the_same_state_each_time() {
    let setting = LineExploration::new(&generate::line(&LineShape::small(), 1));
    let found = || explored(&setting, 5_000);
    let first = found();
    assert_eq!((first.limit, first.kept), (Some(LimitReached::States), 5_000));
    for _ in 0..5 {
        let again = found();
        assert_eq!((again.states, again.arcs, again.kept), (first.states, first.arcs, first.kept));
    }
}

#[test]
fn a_limit_that_is_just_enough_is_enough() {
    let mut setting = LineExploration::new(&generate::line(&LineShape::small(), 1));
    (setting.modes, setting.faults) = (vec![ControlMode::Auto], false);
    let all = explored(&setting, 1_000_000);
    assert!(all.exhausted);
    assert!(explored(&setting, all.kept).exhausted);
    let short = explored(&setting, all.kept - 1);
    assert_eq!((short.exhausted, short.limit), (false, Some(LimitReached::States)));
}

#[test]
fn a_state_of_many_stations_that_stands_for_very_many_takes_no_more_memory_than_allowed() {
    let bytes = 64 * MEBIBYTE;
    for stations in [12, 20, 31] {
        let limits = SearchLimits { states: 3_000, bytes };
        let explored = explore(&LineExploration::new(&row(stations)), limits).expect("there are bits enough");
        println!("{stations}: {} states, {} kept, {} MiB", explored.states, explored.kept, explored.bytes >> 20);
        is_no_yes(&explored);
        assert!(explored.bytes < 2 * bytes, "{}", explored.bytes);
    }
}

#[test]
fn more_than_can_be_packed_is_said_to_be_too_much() {
    let mut setting = LineExploration::new(&row(32));
    setting.lag = 12;
    let error =
        explore(&setting, SearchLimits { states: 100, ..SearchLimits::default() }).expect_err("it does not fit");
    assert!(matches!(error, LineNotExplorable::State { found, max } if found > max), "{error}");
    assert!(error.to_string().contains("explore the line in parts"), "{error}");
}

#[test]
fn without_any_mode_nothing_moves() {
    let mut setting = LineExploration::new(&row(3));
    setting.modes.clear();
    for lumped in [true, false] {
        setting.lumped = lumped;
        let explored = explore(&setting, SearchLimits::default()).expect("three stations can be explored");
        assert_eq!((explored.states, explored.arcs, explored.exhausted), (1, 0, true));
    }
}

#[test]
fn a_mode_named_twice_is_one() {
    let line = generate::line(&LineShape::small(), 3);
    let mut setting = LineExploration::new(&line);
    setting.faults = false;
    setting.modes.truncate(1);
    let once = explore(&setting, SearchLimits::default()).expect("two stations can be explored");
    setting.modes = vec![setting.modes[0]; 9];
    assert_eq!(explore(&setting, SearchLimits::default()), Ok(once));
}
