//! Every condition held to the seed: Figures 12 and 20 (R-module), 13 and 22 (I-module), 21 (hand types).
//!
//! A cell of the seed's tables that we keep is listed once; one that we depart from is listed with both readings and
//! the departure's number in the head of `net/connect.rs`. `IVC` is the internal variable condition the designer
//! adds to a start (§6.1.2). A cell that differs and is not listed fails the test, and so does a departure that is
//! named and not used.

use std::collections::BTreeSet;

use linewright_line::net::{ControlMode, StationNet};
use linewright_line::{Line, OpId, StationId};

use super::words::{cell, number};
use linewright_testkit::built::{alone, i, r};

const AUTO: ControlMode = ControlMode::Auto;
const HAND: ControlMode = ControlMode::Hand;
const MANUAL: ControlMode = ControlMode::Manual;

/// A fault stops a motion in every mode, looked for as a level.
const FAULT: u8 = 1;
/// A released button is a level, not a falling edge.
const RELEASED: u8 = 2;
/// t9 has an auto condition.
const RESTART: u8 = 3;
/// Running motions finish in stand-by, and every motion stops on the emergency stop.
const UNATTENDED: u8 = 4;
/// A motion completes under the button that drives it, not under either.
const OWN_BUTTON: u8 = 5;
/// On a recovery path the return button drives, and there is no turning forward.
const ON_PATH: u8 = 6;

/// A recovery path is entered only if the arrows hold into everything it skips.
const WAY_HOME: u8 = 7;

/// A cell: transition, mode, what the seed prints, what we have, and why they differ.
type Cell = (&'static str, ControlMode, &'static str, &'static str, &'static [u8]);

/// Common part of Figures 12 and 13, 20 and 22, without the bracketed entries.
const BOTH_MODULES: &[Cell] = &[
    ("t1", AUTO, "f↑", "f or lost", &[FAULT]),
    ("t1", HAND, "f↑ h_a", "f or lost", &[FAULT]),
    ("t1", MANUAL, "m_a↓", "f or ¬m_a ¬path or ¬m_a ¬m_r path", &[FAULT, RELEASED, ON_PATH]),
    ("t2", AUTO, "·", "·", &[]),
    ("t2", HAND, "·", "·", &[]),
    ("t2", MANUAL, "m_a↑", "m_a↑ or m_r↑ path", &[ON_PATH]),
    ("t3", AUTO, "s↑", "s ¬f ¬lost", &[FAULT]),
    ("t3", HAND, "s↑ h_a", "s ¬f ¬lost h_a", &[FAULT]),
    ("t3", MANUAL, "s↑ (m_a or m_r)", "s ¬f m_a or s ¬f m_r path", &[FAULT, OWN_BUTTON, ON_PATH]),
    ("t5", AUTO, "·", "·", &[]),
    ("t5", HAND, "·", "·", &[]),
];

/// Figures 12 and 20 beyond that.
const R_MODULE: &[Cell] = &[
    ("t4", AUTO, "·", "·", &[]),
    ("t4", MANUAL, "m_r↑", "m_r↑", &[]),
    ("t5", MANUAL, "m_r↑", "m_r↑ ¬path", &[ON_PATH]),
    ("t6", AUTO, "·", "f or lost", &[FAULT, UNATTENDED]),
    ("t6", HAND, "[f↑ h_b]", "f or lost", &[FAULT]),
    ("t6", MANUAL, "m_r↓", "f or ¬m_r", &[FAULT, RELEASED]),
    ("t7", AUTO, "·", "·", &[]),
    ("t7", HAND, "·", "·", &[]),
    ("t7", MANUAL, "m_r↑", "m_r↑", &[]),
    ("t8", AUTO, "·", "s ¬f ¬lost", &[UNATTENDED]),
    ("t8", MANUAL, "s↑ (m_r or m_a)", "s ¬f m_r", &[FAULT, OWN_BUTTON]),
    ("t9", AUTO, "·", "IVC ¬path", &[RESTART, ON_PATH]),
    ("t9", MANUAL, "m_a↑", "m_a↑ IVC ¬path", &[ON_PATH]),
    ("t10", AUTO, "·", "·", &[]),
    ("t10", HAND, "·", "·", &[]),
    ("t10", MANUAL, "m_a↑", "m_a↑ ¬path", &[ON_PATH]),
    ("t11", AUTO, "N.C.", "IVC", &[]),
    ("t11", MANUAL, "m_a↑", "m_a↑ IVC", &[]),
    ("t12", AUTO, "·", "·", &[]),
];

/// Figures 13 and 22 beyond that.
const I_MODULE: &[Cell] = &[
    ("t4", AUTO, "N.C.", "IVC", &[]),
    ("t4", HAND, "h_a", "h_a IVC", &[]),
    ("t4", MANUAL, "m_a↑", "m_a↑ IVC", &[]),
    ("t5", MANUAL, "m_r↑", "m_r↑ ¬path IVC-home", &[ON_PATH, WAY_HOME]),
];

/// Figure 21 with the bracketed entries of Figure 20, as far as they depend on the hand type: t4, t8, t9, t11 and t12
/// in hand mode, and t12 in manual mode.
const HAND_TYPES: [(u8, [&str; 6]); 6] = [
    (1, ["·", "s ¬f ¬lost", "·", "h_a IVC", "none", "none"]),
    (2, ["·", "s ¬f ¬lost", "·", "h_c↑ IVC", "none", "none"]),
    (3, ["·", "s ¬f ¬lost h_b", "h_a↑ IVC ¬path", "h_a IVC", "none", "none"]),
    (4, ["·", "s ¬f ¬lost h_b", "·", "h_a IVC", "h_b ¬path", "m_r↑ ¬path"]),
    (5, ["h_b↑ ¬h_c↑", "s ¬f ¬lost h_b", "·", "h_c↑ IVC", "h_b ¬path", "m_r↑ ¬path"]),
    (6, ["h_b↑ ¬h_c↑", "s ¬f ¬lost h_b", "h_a↑ IVC ¬path", "h_c↑ IVC", "none", "none"]),
];

/// All types in one station: op `n` has type TYPES[n].
const TYPES: [u8; 7] = [6, 6, 1, 2, 3, 4, 5];

fn all_types() -> Line {
    alone(0, &TYPES.map(r))
}

/// A cell of the net: `none` where the transition does not exist.
fn found(line: &Line, op: OpId, transition: &str, mode: ControlMode) -> String {
    let station = line.station(StationId(0));
    let net = StationNet::of(line, StationId(0));
    let hand = station.operations[op.index()].hand;
    match net.transitions().iter().find(|t| number(station, t, op) == Some(transition)) {
        Some(t) => cell(t.terms(mode), hand),
        None => "none".to_owned(),
    }
}

fn compare(line: &Line, op: OpId, table: &[Cell], used: &mut BTreeSet<u8>) {
    for &(transition, mode, seed, here, departures) in table {
        let kept = seed.replace('↑', "") == here.replace('↑', "").replace(" IVC", "").replace("IVC", "N.C.");
        assert_eq!(kept, departures.is_empty(), "{transition} {mode}: {seed} against {here}");
        assert_eq!(found(line, op, transition, mode), here, "{transition} in {mode}");
        used.extend(departures);
    }
}

#[test]
fn every_departure_from_the_figures_is_one_the_head_of_connect_names() {
    let mut used = BTreeSet::new();
    // Type 5 has every transition; op 6 is neither first nor next to home.
    let irreversible = alone(4, &[r(1), r(1), i(1, &[0]), r(1), r(2)]);
    for (line, op, own) in [(all_types(), OpId(6), R_MODULE), (irreversible, OpId(2), I_MODULE)] {
        compare(&line, op, BOTH_MODULES, &mut used);
        compare(&line, op, own, &mut used);
    }
    assert_eq!(used.into_iter().collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn hand_types_have_the_conditions_of_figure_21() {
    let line = all_types();
    for (number, expected) in HAND_TYPES {
        let op = OpId::at(TYPES.iter().rposition(|&t| t == number).expect("every type is there"));
        let cells = [("t4", HAND), ("t8", HAND), ("t9", HAND), ("t11", HAND), ("t12", HAND), ("t12", MANUAL)];
        let found = cells.map(|(transition, mode)| found(&line, op, transition, mode));
        assert_eq!(found, expected, "type {number}");
    }
}

#[test]
fn one_button_for_back_and_next_means_on_if_the_arrows_hold_and_back_if_not() {
    let shared = linewright_testkit::built::station("clamp", 0, &[r(6), r(6)], 0, true);
    let line = linewright_testkit::built::line(vec![shared], Vec::new());
    assert_eq!(found(&line, OpId(0), "t4", HAND), "h_b↑ ¬IVC");
    assert_eq!(found(&line, OpId(0), "t11", HAND), "h_b↑ IVC");
}

#[test]
fn in_stand_by_running_motions_finish_and_nothing_starts() {
    let line = all_types();
    let moves = |mode| {
        let net = StationNet::of(&line, StationId(0));
        let station = line.station(StationId(0));
        let enabled = net.transitions().iter().filter(|t| !t.terms(mode).is_empty());
        enabled.filter_map(|t| number(station, t, OpId(6))).collect::<Vec<_>>()
    };
    assert_eq!(moves(ControlMode::StandBy), ["t1", "t3", "t6", "t8"]);
    assert_eq!(moves(ControlMode::Home), moves(ControlMode::StandBy));
    assert_eq!(moves(ControlMode::EStop), ["t1", "t6"], "everything stops, nothing completes");
}

#[test]
fn master_stop_holds_the_output_transitions_of_the_home_place_alone() {
    let line = all_types();
    assert_eq!(found(&line, OpId(0), "t11", AUTO), "IVC ¬stop", "op 0 is home");
    assert_eq!(found(&line, OpId(1), "t9", AUTO), "IVC ¬path ¬stop", "op 1 undone is the same position");
    assert_eq!(found(&line, OpId(1), "t11", AUTO), "IVC");
}
