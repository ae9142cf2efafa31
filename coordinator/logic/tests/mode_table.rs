//! Every pair of mode and command, written out.
//!
//! One table for a line that stands at home, one for a line in the middle of a cycle. What is not obeyed is refused
//! with the words an operator reads. The table of `docs/semantics.md` is compared with the code as well.

use ControlMode as M;
use ModeCommand as C;
use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_logic::decision::{ARCS, ModeFacts};
use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::common::CoordinatorBench;

/// The mode after the command, and the refusal's reasons; "" where it is obeyed.
type Row<'a> = (ControlMode, ModeCommand, ControlMode, &'a str);

const AUTO_FROM_HOME: &str = "not possible from this mode; possible: start, manual; the way: start, then auto";
const HAND_FROM_HOME: &str = "not possible from this mode; possible: start, manual; the way: start, then hand";
const NOTHING: &str = "nothing to reset, no emergency stop is in force";
const ALREADY: &str = "mode already in force";
const LATCHED: &str = "emergency stop active; reset it, then select manual";
const HAND_FROM_AUTO: &str = "not possible from this mode; possible: stop, estop; \
                              the way: stop --wait, then start if it ended at home, then hand";
const MANUAL_FROM_AUTO: &str = "not possible from this mode; possible: stop, estop; the way: stop --wait, then manual";
const FROM_HAND: &str = "not possible from this mode; possible: auto, stop, estop";
const MANUAL_FROM_HAND: &str =
    "not possible from this mode; possible: auto, stop, estop; the way: stop --wait, then manual";

/// The refusal's reasons; "" where it is obeyed. The modes that follow are in the table of `docs/semantics.md`.
const AT_HOME: [(ControlMode, ModeCommand, &str); 42] = [
    (M::Home, C::Start, ""),
    (M::Home, C::Stop, ALREADY),
    (M::Home, C::Auto, AUTO_FROM_HOME),
    (M::Home, C::Hand, HAND_FROM_HOME),
    (M::Home, C::Manual, ""),
    (M::Home, C::EStop, ""),
    (M::Home, C::Reset, NOTHING),
    (M::StandBy, C::Start, ALREADY),
    (M::StandBy, C::Stop, ""),
    (M::StandBy, C::Auto, ""),
    (M::StandBy, C::Hand, ""),
    (M::StandBy, C::Manual, ""),
    (M::StandBy, C::EStop, ""),
    (M::StandBy, C::Reset, NOTHING),
    (M::Auto, C::Start, ""),
    (M::Auto, C::Stop, ""),
    (M::Auto, C::Auto, ALREADY),
    (M::Auto, C::Hand, HAND_FROM_AUTO),
    (M::Auto, C::Manual, MANUAL_FROM_AUTO),
    (M::Auto, C::EStop, ""),
    (M::Auto, C::Reset, NOTHING),
    (M::Hand, C::Start, FROM_HAND),
    (M::Hand, C::Stop, ""),
    (M::Hand, C::Auto, ""),
    (M::Hand, C::Hand, ALREADY),
    (M::Hand, C::Manual, MANUAL_FROM_HAND),
    (M::Hand, C::EStop, ""),
    (M::Hand, C::Reset, NOTHING),
    (M::Manual, C::Start, ""),
    (M::Manual, C::Stop, ""),
    (M::Manual, C::Auto, ""),
    (M::Manual, C::Hand, ""),
    (M::Manual, C::Manual, ALREADY),
    (M::Manual, C::EStop, ""),
    (M::Manual, C::Reset, NOTHING),
    (M::EStop, C::Start, LATCHED),
    (M::EStop, C::Stop, LATCHED),
    (M::EStop, C::Auto, LATCHED),
    (M::EStop, C::Hand, LATCHED),
    (M::EStop, C::Manual, LATCHED),
    (M::EStop, C::EStop, ""),
    (M::EStop, C::Reset, ""),
];

fn check(bench: &mut CoordinatorBench, (before, command, after, reasons): Row) {
    check_reasons(bench, before, command, reasons);
    assert_eq!(bench.mode(), after, "{} in {before}", command.name());
}

fn check_reasons(bench: &mut CoordinatorBench, before: ControlMode, command: ModeCommand, reasons: &str) {
    let refused = format!("{} refused in {before}: {reasons}", command.name());
    let expected = (!reasons.is_empty()).then_some(refused);
    assert_eq!(bench.command(command), expected, "{} in {before}", command.name());
}

#[test]
fn every_pair_is_in_the_table() {
    for mode in ControlMode::ALL {
        for command in ModeCommand::ALL {
            assert_eq!(AT_HOME.iter().filter(|row| (row.0, row.1) == (mode, command)).count(), 1);
        }
    }
}

#[test]
fn a_line_that_stands_at_home() {
    for (before, command, reasons) in AT_HOME {
        check_reasons(&mut CoordinatorBench::in_mode(before), before, command, reasons);
    }
}

#[test]
fn after_a_reset_only_manual_leads_out_of_the_emergency_stop() {
    for (command, way) in [
        (C::Start, "; the way: manual, then start"),
        (C::Stop, ""),
        (C::Auto, "; the way: manual, then auto"),
        (C::Hand, "; the way: manual, then hand"),
    ] {
        let mut bench = CoordinatorBench::in_mode(M::EStop);
        assert_eq!(bench.command(C::Reset), None);
        let reasons = format!("not possible from this mode; possible: manual{way}");
        check(&mut bench, (M::EStop, command, M::EStop, &reasons));
    }
    let mut bench = CoordinatorBench::in_mode(M::EStop);
    assert_eq!(bench.command(C::Reset), None);
    check(&mut bench, (M::EStop, C::Manual, M::Manual, ""));
}

const AWAY_AND_MOVING: &str = "mill_1: not at home; mill_1: motion in progress";

#[test]
fn a_line_whose_mill_is_under_way() {
    let rows: [Row; 8] = [
        (M::Auto, C::Stop, M::Auto, ""),
        (M::StandBy, C::Stop, M::StandBy, AWAY_AND_MOVING),
        (M::StandBy, C::Auto, M::Auto, ""),
        (M::StandBy, C::Hand, M::StandBy, "mill_1: motion in progress"),
        (M::StandBy, C::Manual, M::StandBy, "mill_1: motion in progress"),
        (M::Hand, C::Auto, M::Auto, ""),
        (M::Hand, C::Stop, M::StandBy, ""),
        (M::Auto, C::EStop, M::EStop, ""),
    ];
    for row in rows {
        let mut bench = CoordinatorBench::in_mode(row.0);
        (bench.heard[2].at_home, bench.heard[2].stopped) = (false, false);
        bench.beat();
        check(&mut bench, row);
    }
}

/// A mode that is to be had at home, and what is different then.
fn bench_of(mode: ControlMode, change: impl Fn(&mut CoordinatorBench)) -> CoordinatorBench {
    let mut bench = CoordinatorBench::in_mode(mode);
    change(&mut bench);
    bench.beat();
    bench
}

/// A cell of the table: for a line at home, and behind `, away: ` for one away from home.
fn cell(cell: &str) -> (&str, &str) {
    cell.split_once(", away: ").unwrap_or((cell, cell))
}

#[test]
fn the_table_of_the_documentation_is_what_the_commands_do() {
    let text = include_str!("../../../docs/semantics.md");
    let (_, table) = text.split_once("### What each command does").expect("the section");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let words: Vec<&str> = rows[0][1..].iter().map(|word| word.trim_matches('`')).collect();
    assert_eq!(words, ModeCommand::ALL.map(ModeCommand::name));
    let mut modes: Vec<&str> = ControlMode::ALL.iter().map(|mode| mode.name()).collect();
    modes.push("e-stop, reset");
    assert_eq!(rows[2..].iter().map(|row| row[0]).collect::<Vec<_>>(), modes);
    for row in &rows[2..] {
        for (command, written) in ModeCommand::ALL.into_iter().zip(&row[1..]) {
            let (home, away) = cell(written);
            for (is_home, expected) in [(true, home), (false, away)] {
                let mode = ControlMode::ALL.into_iter().find(|mode| row[0].starts_with(mode.name())).expect("a mode");
                let mut bench = bench_of(mode, |bench| bench.heard[2].at_home = is_home);
                if row[0].ends_with(", reset") {
                    assert_eq!(bench.command(C::Reset), None);
                }
                let refusal = bench.command(command);
                let done = if refusal.is_some() { "refused" } else { bench.mode().name() };
                assert_eq!(done, expected, "{} in {}, at home: {is_home}: {refusal:?}", command.name(), row[0]);
            }
        }
    }
}

/// What is refused is not done, not by half either.
#[test]
fn a_refused_command_changes_no_mode() {
    let changes: [fn(&mut CoordinatorBench); 8] = [
        |_| {},
        |bench| bench.heard[2].at_home = false,
        |bench| (bench.heard[2].at_home, bench.heard[2].stopped) = (false, false),
        |bench| bench.heard[1].incomplete = true,
        |bench| bench.heard[1].devices_valid = false,
        |bench| bench.heard[0].selector_manual = true,
        |bench| bench.heard[0].generation = 0,
        |bench| (bench.heard[0].generation, bench.heard[2].at_home) = (0, false),
    ];
    let mut refused = 0;
    for (nth, change) in changes.iter().enumerate() {
        for mode in ControlMode::ALL {
            for command in ModeCommand::ALL {
                let mut bench = bench_of(mode, change);
                let before = (bench.mode(), bench.coordinator.epoch());
                if let Some(refusal) = bench.command(command) {
                    assert_eq!((bench.mode(), bench.coordinator.epoch()), before, "change {nth}: {refusal}");
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn a_command_that_is_obeyed_ends_what_was_refused_before() {
    let mut bench = CoordinatorBench::in_mode(M::Auto);
    bench.coordinator.handle(bench.now, linewright_coordinator_logic::ModeInput::Command(C::Hand));
    bench.coordinator.step(bench.now, &mut bench.out);
    assert!(!bench.out.obeyed);
    bench.coordinator.handle(bench.now, linewright_coordinator_logic::ModeInput::Command(C::Stop));
    bench.coordinator.step(bench.now, &mut bench.out);
    assert!(bench.out.obeyed);
    // Of two in one step the last one counts.
    bench.coordinator.handle(bench.now, linewright_coordinator_logic::ModeInput::Command(C::EStop));
    bench.coordinator.handle(bench.now, linewright_coordinator_logic::ModeInput::Command(C::Auto));
    bench.coordinator.step(bench.now, &mut bench.out);
    assert!(!bench.out.obeyed);
}

#[test]
fn from_home_manual_is_refused_for_what_would_refuse_it_after_start() {
    let mut bench = bench_of(M::Home, |bench| bench.heard[1].stopped = false);
    check(&mut bench, (M::Home, C::Manual, M::Home, "clamp_1: motion in progress"));
    bench.heard[1].stopped = true;
    bench.beat();
    check(&mut bench, (M::Home, C::Manual, M::Manual, ""));
    check(&mut bench, (M::Manual, C::Stop, M::Home, ""));
}

/// What is moved in manual is counted: so the generation is founded before, as by start.
#[test]
fn from_home_manual_comes_once_the_generation_is_founded() {
    let found = |bench: &mut CoordinatorBench| {
        for at in 0..3 {
            bench.heard[at].generation = bench.coordinator.founding().unwrap_or(bench.heard[at].generation);
            bench.say(at);
        }
    };
    let mut bench = bench_of(M::Home, |bench| bench.heard[1].generation = 0);
    assert_eq!((bench.command(C::Manual), bench.mode()), (None, M::StandBy));
    found(&mut bench);
    bench.beat();
    assert_eq!((bench.mode(), bench.coordinator.order().enabled), (M::Manual, true));

    // One that cannot take it does not keep the line from manual.
    let mut bench = bench_of(M::Home, |bench| bench.heard[1].generation = 0);
    bench.command(C::Manual);
    let lease = bench.line.timing.lease;
    let waits_until = bench.now + lease;
    while bench.now < waits_until {
        assert_eq!(bench.mode(), M::StandBy);
        bench.wait(std::time::Duration::from_millis(50));
        bench.beat();
    }
    assert_eq!(bench.mode(), M::Manual);
    // Another command, given before, is what holds.
    let mut bench = bench_of(M::Home, |bench| bench.heard[1].generation = 0);
    bench.command(C::Manual);
    assert_eq!(bench.command(C::Auto), None);
    found(&mut bench);
    bench.beat();
    assert_eq!(bench.mode(), M::Auto);
}

#[test]
fn what_speaks_against_auto_is_said_in_full() {
    let mut bench = CoordinatorBench::in_mode(M::StandBy);
    bench.heard[0].incomplete = true;
    bench.heard[1].devices_valid = false;
    bench.beat();
    let refusal = bench.command(C::Auto);
    let expected = "auto refused in stand-by: \
                    transfer: operation incomplete; complete or undo it in manual; clamp_1: I/O devices lost";
    assert_eq!(refusal.as_deref(), Some(expected));
}

/// A doubt is ended by a person who looks, not at the panel.
#[test]
fn of_an_index_in_doubt_only_the_lost_position_is_named() {
    let text = include_str!("../../../examples/rotary-table.toml");
    let line = linewright_line::parse("rotary-table.toml", text).expect("sound").line;
    let table = line.station_named("table").expect("the table");
    let index = line.station(table).operation_named("index");
    let mut bench = CoordinatorBench::of(line, 0);
    bench.command(C::Start);
    (bench.heard[table.index()].incomplete, bench.heard[table.index()].incomplete_op) = (true, index);
    bench.beat();
    let stopped = bench.command(C::Auto).expect("it is refused");
    assert_eq!(stopped, "auto refused in stand-by: table: index incomplete; complete it in manual, it has no way back");
    bench.heard[table.index()].position_lost = true;
    bench.beat();
    let lost = bench.command(C::Auto).expect("it is refused");
    assert_eq!(lost, "auto refused in stand-by: table: position lost; see its fault, look, then rejoin");
}

#[test]
fn a_stop_in_stand_by_that_is_refused_always_says_why() {
    let reason = |change: fn(&mut CoordinatorBench)| {
        let mut bench = CoordinatorBench::in_mode(M::StandBy);
        change(&mut bench);
        bench.out.refusals.clear();
        bench.input(linewright_coordinator_logic::ModeInput::Command(C::Stop));
        bench.out.refusals.first().map(|refusal| refusal.text(&bench.line)).unwrap_or_default()
    };
    let behind = reason(|b| {
        b.heard[0].round = 3;
        b.heard[1].round = 3;
        b.beat();
    });
    assert_eq!(behind, "stop refused in stand-by: mill_1: at home one cycle behind the others; give auto, then stop");
    let unheard = reason(|b| {
        b.wait(std::time::Duration::from_millis(240));
        b.say(0);
        b.say(1);
        b.wait(std::time::Duration::from_millis(20));
    });
    assert_eq!(unheard, "stop refused in stand-by: mill_1: no state received");
}

#[test]
fn every_arc_is_allowed_under_some_facts() {
    for arc in ARCS {
        assert!(ModeFacts::all().any(|facts| (arc.when)(&facts)), "{arc:?}");
    }
}

#[test]
fn only_manual_leads_out_of_the_emergency_stop() {
    let out: Vec<_> = ARCS.iter().filter(|a| a.from == ControlMode::EStop).map(|a| a.to).collect();
    assert_eq!(out, [ControlMode::Manual]);
}

#[test]
fn what_several_stations_lack_is_once_in_the_text_of_the_mode() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard.iter_mut().for_each(|heard| heard.generation = 0);
    bench.heard[1].at_home = false;
    bench.beat();
    let text = bench.coordinator.text();
    assert_eq!(text.matches("no memory").count(), 1, "{text}");
    let expected =
        "transfer, clamp_1, mill_1: no memory of the cycle; lead all stations home in manual, then give auto";
    assert!(text.contains(expected), "{text}");

    // Two began anew together, and the third one apart from them.
    for (heard, generation) in bench.heard.iter_mut().zip([5, 0, 5]) {
        heard.generation = generation;
    }
    bench.beat();
    assert!(
        bench.coordinator.text().contains("; clamp_1: no memory of the cycle; lead"),
        "{}",
        bench.coordinator.text()
    );
    bench.heard[1].generation = 4;
    bench.beat();
    let apart = "clamp_1: began anew apart from the other stations; lead all stations home in manual, then give auto";
    assert!(bench.coordinator.text().contains(apart), "{}", bench.coordinator.text());
    bench.heard[0].generation = 0;
    bench.heard[2].generation = 4;
    bench.heard[1].generation = 3;
    bench.beat();
    let both = "transfer: no memory of the cycle, and clamp_1: began anew apart from the other stations; lead all";
    assert!(bench.coordinator.text().contains(both), "{}", bench.coordinator.text());
}

/// Start is no way from there: what is incomplete is led in manual, where the station is looked at.
#[test]
fn a_restarted_station_with_an_incomplete_operation_asks_for_manual_alone() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard[1].boot_id += 1;
    bench.heard[1].incomplete = true;
    bench.beat();
    let texts = [bench.coordinator.text(), bench.command(ModeCommand::Auto).expect("it is incomplete")];
    for text in texts {
        assert!(text.contains("clamp_1: operation incomplete") && !text.contains("give start"), "{text}");
    }
    assert_eq!(bench.coordinator.standing().restarted, [StationId(1)]);
}
