//! Texts of decisions, and of reasons why a part does not go on.

use std::time::Duration;

use linewright_coordinator_cell::dispatch::Reasons;
use linewright_coordinator_cell::dispatch::{DispatchRule, RuleDispatcher, ShortestRoutes, why_not};
use linewright_coordinator_cell::texts;
use linewright_coordinator_cell::{Coordination, PartId, Record, RecordKind};
use linewright_line::Tick;

use super::rules::{job, machine, run};
use super::solo::{ByName, compiled, lines, play, seconds};
use crate::player::plans::Compiled;

/// Texts of a time.
fn said(it: &Compiled, records: &[Record], at: u64) -> Vec<String> {
    let at = records.iter().filter(|record| record.at == Tick::from_millis(at));
    let decided = at.filter_map(|record| match &record.fact {
        RecordKind::Decided { started, held, .. } => Some(texts::decision(&it.table, started, held)),
        _ => None,
    });
    decided.flatten().collect()
}

/// In the table of [`super::rules`] at 10 s.
#[test]
fn a_decision_says_by_which_rule_and_with_which_numbers() {
    let it = machine();
    assert_eq!(
        said(&it, &run(&it, &[DispatchRule::EarliestDueDate], |_| ()), 10_000),
        [
            "`work_c` with part 3 starts, before `work_a` with part 1: by earliest-due-date (due in 11 s; the other due in \
             40 s); before `work_b` with part 2: by earliest-due-date (due in 11 s; the other due in 20 s); before `work_d` \
             with part 4: by earliest-due-date (due in 11 s; the other due in 64 s).",
            "`work_a` with part 1 is held: `work_c` with part 3 goes first: by earliest-due-date (due in 11 s; the other \
             due in 40 s).",
            "`work_b` with part 2 is held: `work_c` with part 3 goes first: by earliest-due-date (due in 11 s; the other \
             due in 20 s).",
            "`work_d` with part 4 is held: `work_c` with part 3 goes first: by earliest-due-date (due in 11 s; the other \
             due in 64 s).",
        ]
    );
    let last = |rules: &[DispatchRule]| said(&it, &run(&it, rules, |_| ()), 10_000).pop().unwrap();
    assert_eq!(
        last(&[DispatchRule::Fifo]),
        "`work_d` with part 4 is held: `work_a` with part 1 goes first: by fifo (waited 9 s; the other waited 6 s)."
    );
    // By this rule a and c enter before b, so that is part 3.
    assert_eq!(
        last(&[DispatchRule::ShortestProcessingTime]),
        "`work_d` with part 4 is held: `work_b` with part 3 goes first: by shortest-processing-time (takes 2 s; the other \
         takes 5 s)."
    );
    assert_eq!(
        last(&[DispatchRule::LeastSlack]),
        "`work_d` with part 4 is held: `work_b` with part 2 goes first: by least-slack (slack 2 s; the other slack 40 s)."
    );
    assert_eq!(
        last(&[DispatchRule::CriticalRatio]),
        "`work_d` with part 4 is held: `work_b` with part 2 goes first: by critical-ratio (ratio 1.11; the other ratio \
         2.67)."
    );
    assert_eq!(
        last(&[DispatchRule::Priority]),
        "`work_c` with part 3 is held: `work_d` with part 4 goes first: by priority (priority 9; the other priority 5)."
    );
    assert_eq!(
        last(&[]),
        "`work_d` with part 4 is held: `work_a` with part 1 goes first: waited longer, or lower part number."
    );
}

/// Reasons about a part at a time, in the table of [`super::rules`] by due dates.
fn asked(it: &Compiled, dispatcher: RuleDispatcher, at: u64, part: u64) -> Vec<String> {
    let until = Tick::from_millis(at);
    let (records, player) = play(it, &mut ByName { inner: dispatcher.clone(), job }, until, |_, _| true);
    answered(dispatcher.ways(), &records, &player, until, part)
}

fn answered(ways: &ShortestRoutes, records: &[Record], player: &Coordination, now: Tick, part: u64) -> Vec<String> {
    let mut reasons = Reasons::default();
    records.iter().for_each(|record| reasons.note(record));
    why_not(ways, &reasons, player, now, PartId(part))
}

#[test]
fn whoever_asks_about_a_part_is_told_what_it_waits_for() {
    let it = machine();
    let rules = RuleDispatcher::new(&it.table, &[DispatchRule::EarliestDueDate], Duration::from_secs(1000));
    let asked = |at, part| asked(&it, rules.clone(), at, part);
    assert_eq!(asked(500, 9), ["part 9 is not in the cell."]);
    assert_eq!(asked(500, 4), ["part 4 is under way: `enter_d` with part 4, 3.5 s left."]);
    assert_eq!(
        asked(9000, 1),
        ["part 1 has been on `waiting.a` for 8 s.", "`work_a`: `machine` in use by `open`, 1 s left."]
    );
    assert_eq!(
        asked(12_000, 1),
        [
            "part 1 has been on `waiting.a` for 11 s.",
            "`work_a`: `machine` in use by `work_c` with part 3, 5 s left; held 2 s ago: `work_c` with part 3 \
             goes first: by earliest-due-date (due in 11 s; the other due in 40 s).",
        ]
    );
    assert_eq!(asked(100_000, 1), ["part 1 has been on `packed.a` for 71 s.", "No activity takes it from there."]);
}

/// The robot comes at 10 s; until then another part has been put into the only slot. Part 2 stands on the machine, done, and
/// cannot be unloaded; part 1 is to go there.
#[test]
fn what_rests_somewhere_is_named_with_whom_it_waits_for() {
    let net = lines([
        "open: closed -> robot",
        "enter: supply slot -> stored.c",
        "load: stored.a machine robot -> robot slot on.a",
        "unload: on.b slot robot -> robot machine stored.b",
    ]);
    let marked = ["stored.a", "on.b", "closed", "supply", "slot"].map(|name| (name, 1));
    let it = compiled(&net, &marked, |_| seconds(10));
    let mut rules = RuleDispatcher::new(&it.table, &[], Duration::from_secs(1000));
    let (records, player) = play(&it, &mut rules, Tick::from_millis(20_000), |_, _| true);
    let [one, two] = ["stored.a", "on.b"].map(|name| {
        let part = player.state().marking().parts(it.cell(name)).next().unwrap();
        (part.0, answered(rules.ways(), &records, &player, Tick::from_millis(15_000), part.0))
    });
    assert_eq!(
        one.1,
        [
            format!("part {} has been on `stored.a` for 15 s.", one.0),
            format!("`load`: `machine` is returned by `unload` of part {}, not started yet.", two.0),
        ]
    );
    assert_eq!(
        two.1,
        [
            format!("part {} has been on `on.b` for 15 s.", two.0),
            format!("`unload`: `slot` is returned by `load` of part {}, not started yet.", one.0),
        ]
    );
}
