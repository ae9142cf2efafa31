//! Hand mode: the whole cycle by the main console's buttons, and back through the reverse sequences.
//!
//! ```text
//!   PB_2 lift (4)   PB_3 advance   PB_4 lower (4)   PB_5 close   PB_8 mill (5)   PB_7 return   PB_1 open
//!   ────▶           ────▶          ────▶            ────▶        ────▶           ────▶         ────▶
//!   ◀──── PB_4      ◀──── PB_7     ◀──── PB_2       ◀──── PB_1   (never back)    ◀──── PB_3    ◀──── PB_5
//! ```

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{Block, ControlMode};
use linewright_station_logic::HappeningKind;
use linewright_tests::{WatchedLine, hand_button, transfer_line};

fn in_hand_mode(seed: u64) -> WatchedLine {
    let mut sim = WatchedLine::new(&transfer_line(1.0), seed);
    sim.start();
    sim.order(ModeCommand::Hand);
    let all = |s: &WatchedLine| s.line().station_ids().all(|id| s.mode_of(id) == Some(ControlMode::Hand));
    sim.run_until("hand mode", all);
    sim
}

/// Holds a button until nothing has been energised for a while, lets go, and gives what was done in between.
fn hold(sim: &mut WatchedLine, button: &str) -> Vec<String> {
    let seen = sim.log().entries().len();
    let button = hand_button(sim.line(), button);
    sim.hold_button(button);
    loop {
        let moved = sim.wait_for(Duration::from_millis(150), WatchedLine::anything_energised);
        if !moved {
            break;
        }
        let stopped = sim.wait_for(Duration::from_secs(5), |s| !s.anything_energised());
        assert!(stopped, "a motion ends");
    }
    sim.release_buttons();
    sim.run_for(Duration::from_millis(100));
    done_since(sim, seen)
}

fn done_since(sim: &WatchedLine, seen: usize) -> Vec<String> {
    let done = sim.log().entries()[seen..].iter().filter_map(|entry| match entry.what {
        linewright_tests::LogKind::Station(id, event) => match event.what {
            HappeningKind::Completed(op, Block::Normal) => Some(sim.line().operation((id, op)).name.clone()),
            HappeningKind::Completed(op, Block::Recovery) => {
                Some(format!("undone: {}", sim.line().operation((id, op)).name))
            }
            _ => None,
        },
        _ => None,
    });
    done.collect()
}

const LIFTS: [&str; 4] = ["1st lift", "2nd lift", "3rd lift", "4th lift"];
const LOWERS: [&str; 4] = ["1st lower", "2nd lower", "3rd lower", "4th lower"];
const MILLING: [&str; 5] = [
    "rapid advance positioning slide",
    "decel",
    "feed main slide",
    "rapid return positioning slide",
    "reset main slide",
];

#[test]
fn the_whole_cycle_by_buttons_twice() {
    let mut sim = in_hand_mode(1);
    for cycle in 1..=2 {
        assert_eq!(hold(&mut sim, "PB_2"), LIFTS, "cycle {cycle}");
        assert_eq!(hold(&mut sim, "PB_3"), ["advance transfer"]);
        assert_eq!(hold(&mut sim, "PB_4"), LOWERS);
        assert_eq!(hold(&mut sim, "PB_5"), ["advance clamp"]);
        assert_eq!(hold(&mut sim, "PB_8"), MILLING);
        assert_eq!(hold(&mut sim, "PB_7"), ["return transfer"]);
        assert_eq!(hold(&mut sim, "PB_1"), ["return clamp"]);
        assert_eq!(sim.observer().machined(1, cycle), 1);
    }
    sim.order(ModeCommand::Auto);
    sim.run_until_done("mill_1", "reset main slide", 4);
}

#[test]
fn back_through_the_reverse_sequences() {
    let mut sim = in_hand_mode(2);
    let back = |names: [&str; 4]| names.iter().rev().map(|name| format!("undone: {name}")).collect::<Vec<_>>();
    assert_eq!(hold(&mut sim, "PB_2"), LIFTS);
    assert_eq!(hold(&mut sim, "PB_4"), back(LIFTS), "down again");
    assert_eq!(hold(&mut sim, "PB_2"), LIFTS);
    assert_eq!(hold(&mut sim, "PB_3"), ["advance transfer"]);
    assert_eq!(hold(&mut sim, "PB_7"), ["undone: advance transfer"], "back over");
    assert_eq!(hold(&mut sim, "PB_3"), ["advance transfer"]);
    assert_eq!(hold(&mut sim, "PB_4"), LOWERS);
    assert_eq!(hold(&mut sim, "PB_2"), back(LOWERS), "up again: the clamp has not closed yet, and agrees");
    assert_eq!(hold(&mut sim, "PB_4"), LOWERS);
    assert_eq!(hold(&mut sim, "PB_5"), ["advance clamp"]);
    assert_eq!(hold(&mut sim, "PB_1"), ["undone: advance clamp"], "open again: the mill has not begun, and agrees");
    assert_eq!(hold(&mut sim, "PB_5"), ["advance clamp"]);
    sim.order(ModeCommand::Auto);
    sim.run_until_done("mill_1", "reset main slide", 3);
}

#[test]
fn an_illegal_button_does_nothing_and_gives_a_reason() {
    let mut sim = in_hand_mode(3);
    let (transfer, clamp, mill) = (sim.id("transfer"), sim.id("clamp_1"), sim.id("mill_1"));
    let nothing: [&str; 0] = [];
    let refused = |sim: &mut WatchedLine, button: &str, station, reason: &str| {
        let before = sim.positions();
        assert_eq!(hold(sim, button), nothing, "{button}");
        assert_eq!(sim.positions(), before, "{button} moves nothing");
        let reasons = sim.blocked_by(station).join("; ");
        assert!(reasons.contains(reason), "{button}: {reasons}");
    };
    refused(&mut sim, "PB_8", mill, "clamp_1: advance clamp (cycle 1)");
    assert_eq!(hold(&mut sim, "PB_2"), LIFTS);
    // Under a raised bar the clamp neither closes on to its next step nor takes its opening back.
    refused(&mut sim, "PB_5", clamp, "interlock: transfer not clear: LS_vertical_0");
    refused(&mut sim, "PB_8", mill, "clamp_1: advance clamp (cycle 1)");
    assert_eq!(hold(&mut sim, "PB_3"), ["advance transfer"]);
    assert_eq!(hold(&mut sim, "PB_4"), LOWERS);
    assert_eq!(hold(&mut sim, "PB_5"), ["advance clamp"]);
    // Up again under a closed clamp: it is measured in the way.
    refused(&mut sim, "PB_2", transfer, "interlock: clamp_1 not clear: LS_open");
}
