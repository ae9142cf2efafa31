//! The two decisions that seed 000 prints for the conflict of its Fig. 41 (L2924-2944, Figs. 49a and 49b).
//!
//! Robot 2 has finished a part 1, the human is free, parts 2 and 3 wait: enabled are t1 in (m2,r1,p2) and (m2,r1,p3) and t5
//! in (m1,r1,p1). a: DF(t1) = bdv3 ∧ G&3 = 1, DF(t5) = 0: part 3 is loaded. b: DF(t5) = bdv1 ∧ G&1 = 1, DF(t1) = 0: part 1
//! is unloaded. The drawing of a lacks its line for t1, so the effect is tested: exactly one mode starts.

use std::time::Duration;

use linewright_coordinator_cell::dispatch::{DispatchRule, RuleDispatcher, Window};
use linewright_coordinator_cell::texts;
use linewright_coordinator_cell::{DecidingRule, HoldReason, ModeId, PartId, PlayerOutbox, RecordKind};

use crate::player::printed::conflict_state;

/// First decision, and texts about it: the timetable has these three at these times, in seconds from now.
fn decided(times: [u64; 3], tolerance: u64) -> (String, Vec<(ModeId, HoldReason)>, Vec<String>) {
    let (mut world, _) = conflict_state();
    let now = world.now;
    let mut rules = RuleDispatcher::new(&world.it.table, &[DispatchRule::Schedule], Duration::from_secs(1000));
    rules.timetable.tolerance = Duration::from_secs(tolerance);
    let modes = ["t5<m1,r1,p1>", "t1<m2,r1,p2>", "t1<m2,r1,p3>"].map(|name| world.it.mode(name));
    for (part, (mode, at)) in (1..).zip(modes.into_iter().zip(times)) {
        let from = now + Duration::from_secs(at);
        let window = Window { from, until: from + Duration::from_secs(60) };
        rules.timetable.windows.insert((Some(PartId(part)), mode), window);
    }
    let mut out = PlayerOutbox::default();
    world.coordination.reconsider();
    world.coordination.step(now, &[], &mut rules, &mut out);
    assert_eq!(out.events, []);
    let RecordKind::Decided { started, held, .. } = &out.records[0].fact else { panic!("{:?}", out.records[0]) };
    let [(mode, Some(_))] = started[..] else { panic!("{started:?}") };
    let words = texts::decision(&world.it.table, started, held);
    (world.it.table.mode_name(mode).to_owned(), held.clone(), words)
}

/// A4 a: the schedule has part 3 next. The other two are held, and the record has the reason.
#[test]
fn with_part_3_next_it_is_loaded_and_nothing_else_starts() {
    let (started, held, words) = decided([5, 20, 0], 30);
    assert_eq!(started, "t1<m2,r1,p3>");
    assert_eq!(held.len(), 2);
    for (_, reason) in &held {
        assert!(
            matches!(reason, HoldReason::LostTo(lost) if matches!(lost.by, DecidingRule::Rule { rule: DispatchRule::Schedule, .. }))
        );
    }
    let expected = [
        "`t1<m2,r1,p3>` with part 3 starts, before `t1<m2,r1,p2>` with part 2: by schedule (planned in 0 s; the other \
         planned in 20 s); before `t5<m1,r1,p1>` with part 1: by schedule (planned in 0 s; the other planned in 5 s).",
        "`t1<m2,r1,p2>` with part 2 is held: `t1<m2,r1,p3>` with part 3 goes first: by schedule (planned in 0 s; the other \
         planned in 20 s).",
        "`t5<m1,r1,p1>` with part 1 is held: `t1<m2,r1,p3>` with part 3 goes first: by schedule (planned in 0 s; the other \
         planned in 5 s).",
    ];
    assert_eq!(words, expected);
}

/// A4 b: the schedule has the unloading next.
#[test]
fn with_the_unloading_next_it_is_done_and_nothing_else_starts() {
    let (started, held, _) = decided([0, 5, 20], 30);
    assert_eq!(started, "t5<m1,r1,p1>");
    assert_eq!(held.len(), 2);
}

/// The same where the others' windows have not opened: they are held for that, and decided anew when the first opens.
#[test]
fn what_is_planned_for_later_is_held_until_then() {
    let (started, held, words) = decided([0, 5, 20], 0);
    assert_eq!(started, "t5<m1,r1,p1>");
    assert!(held.iter().all(|(_, reason)| matches!(reason, HoldReason::NotYet(_))));
    assert!(words[1].starts_with("`t1<m2,r1,p2>` is held: scheduled not before "), "{}", words[1]);
    assert_eq!(words[0], "`t5<m1,r1,p1>` with part 1 starts: no competing candidate.");
}
