//! Each rule by a table that was worked out by hand.
//!
//! Four parts wait for one machine, which opens at 10 s. Each is then packed, by a packer of its own, so that the work that
//! remains is not only the time on the machine. In seconds:
//!
//! ```text
//!  part   there since   machine p   pack q   work p+q   due   due − work   priority
//!  a           1            4          6        10       50        40          0
//!  b           2            2         16        18       30        12          5
//!  c           3            7          1         8       21        13          5
//!  d           4            5         19        24       74        50          9
//! ```
//! The definitions are those of Pinedo, *Scheduling*, §14.1 (SPT, EDD, MS), and of Blackstone, Phillips and Hogg 1982 (CR).

use std::time::Duration;

use linewright_coordinator_cell::dispatch::{DispatchRule, EntryCandidate, PartPriority, RuleDispatcher, Window};
use linewright_coordinator_cell::{PartId, PlayedActivity, Record};
use linewright_line::Tick;

use super::solo::{ByName, compiled, lines, play, seconds, starts};
use crate::player::plans::Compiled;

const PARTS: [(char, u64, u64, u64, u64, i32); 4] =
    [('a', 1, 4, 6, 50, 0), ('b', 2, 2, 16, 30, 5), ('c', 3, 7, 1, 21, 5), ('d', 4, 5, 19, 74, 9)];

pub fn machine() -> Compiled {
    let mut net = lines(["open: closed -> machine"]);
    for (x, ..) in PARTS {
        net.push(format!("enter_{x}: supply_{x} -> waiting.{x}"));
        net.push(format!("work_{x}: waiting.{x} machine -> machine worked.{x}"));
        net.push(format!("pack_{x}: worked.{x} packer_{x} -> packer_{x} packed.{x}"));
    }
    let supplies =
        ["supply_a", "supply_b", "supply_c", "supply_d", "packer_a", "packer_b", "packer_c", "packer_d", "closed"];
    compiled(&net, &supplies.map(|name| (name, 1)), |name| {
        let of = PARTS.iter().find(|(x, ..)| name.ends_with(&format!("_{x}")));
        match (name.split('_').next().unwrap(), of) {
            ("enter", Some(of)) => seconds(of.1),
            ("work", Some(of)) => seconds(of.2),
            ("pack", Some(of)) => seconds(of.3),
            _ => seconds(10),
        }
    })
}

pub fn job(cell: &str) -> PartPriority {
    let of = PARTS.iter().find(|(x, ..)| cell.ends_with(*x)).unwrap();
    PartPriority { due: Some(Tick::from_millis(of.4 * 1000)), priority: of.5 }
}

pub fn run(it: &Compiled, rules: &[DispatchRule], change: impl Fn(&mut RuleDispatcher)) -> Vec<Record> {
    let mut inner = RuleDispatcher::new(&it.table, rules, Duration::from_secs(1000));
    change(&mut inner);
    play(it, &mut ByName { inner, job }, Tick::from_millis(200_000), |_, _| true).0
}

fn order(rules: &[DispatchRule]) -> String {
    let it = machine();
    let records = run(&it, rules, |_| ());
    let order: String = starts(&it, &records, "work").iter().map(|(_, name)| &name[5..]).collect();
    assert_eq!(order.len(), 4, "all of them are worked on: {order}");
    order
}

#[test]
fn each_rule_gives_the_order_that_was_worked_out_by_hand() {
    use DispatchRule::{
        CriticalRatio, EarliestDueDate, Fifo, LeastSlack, Priority, ShortestProcessingTime as Shortest,
    };
    let rows: [(&[DispatchRule], &str); 11] = [
        // By arrival: 1, 2, 3, 4.
        (&[Fifo], "abcd"),
        (&[], "abcd"),
        // By p: 2, 4, 5, 7.
        (&[Shortest], "badc"),
        // By due date: 21, 30, 50, 74.
        (&[EarliestDueDate], "cbad"),
        // By due − work, which stay in the same order at any time: 12, 13, 40, 50.
        (&[LeastSlack], "bcad"),
        // At 10 s: a 40/10, b 20/18, c 11/8, d 64/24, so b, until 12 s. Then c 9/8 is first, a 38/10, d 62/24; until
        // 19 s. Then d 55/24 = 2.3 before a 31/10 = 3.1: another order than by slack.
        (&[CriticalRatio], "bcda"),
        // d has 9, b and c have 5, a has 0; the next rule decides between b and c.
        (&[Priority], "dbca"),
        (&[Priority, Fifo], "dbca"),
        (&[Priority, EarliestDueDate], "dcba"),
        (&[Priority, Shortest, EarliestDueDate], "dbca"),
        // At 15 s, when d is over: c 6/8 before b 15/18.
        (&[Priority, CriticalRatio], "dcba"),
    ];
    for (rules, expected) in rows {
        assert_eq!(order(rules), expected, "{rules:?}");
    }
}

/// At 10 s, b due at 7 s is at −3/18 = −0.17; a is at −5/10, −2/10 or −1/10 when it is due at 5, 8 or 9 s. Both are late, c
/// and d are not.
#[test]
fn the_ratio_of_what_is_late_is_below_zero() {
    let it = machine();
    for (due_a, expected) in [(5, "work_a"), (8, "work_a"), (9, "work_b")] {
        let job = move |cell: &str| {
            let due = match cell.chars().last().unwrap() {
                'a' => due_a,
                'b' => 7,
                _ => 90,
            };
            PartPriority { due: Some(Tick::from_millis(due * 1000)), priority: 0 }
        };
        let inner = RuleDispatcher::new(&it.table, &[DispatchRule::CriticalRatio], Duration::from_secs(1000));
        let (records, _) = play(&it, &mut ByName { inner, job }, Tick::from_millis(200_000), |_, _| true);
        assert_eq!(starts(&it, &records, "work")[0], (10_000, expected), "{due_a}");
    }
}

/// A part without a due date comes after all that have one, by each of the rules that use it.
#[test]
fn what_is_never_due_comes_last() {
    let it = machine();
    for rule in [DispatchRule::EarliestDueDate, DispatchRule::LeastSlack, DispatchRule::CriticalRatio] {
        let inner = RuleDispatcher::new(&it.table, &[rule], Duration::from_secs(1000));
        let job = |cell: &str| if cell.ends_with('a') { PartPriority::default() } else { job(cell) };
        let (records, _) = play(&it, &mut ByName { inner, job }, Tick::from_millis(200_000), |_, _| true);
        assert_eq!(starts(&it, &records, "work")[3].1, "work_a", "{rule}");
    }
}

/// Windows from 30 s for a, from 12 s for b, 4 s to 5 s for c, none for d; 1 s of tolerance. c is late, so it is first, at
/// 10 s, until 17 s. b, planned from 12 s, is first then; it ends at 19 s. a is held until 29 s, so d is next, until 24 s.
#[test]
fn the_timetable_orders_and_holds() {
    let it = machine();
    let records = run(&it, &[DispatchRule::Schedule], |rules| {
        rules.timetable.tolerance = Duration::from_secs(1);
        for (part, mode, from, until) in [(1, "work_a", 30, 40), (2, "work_b", 12, 14), (3, "work_c", 4, 5)] {
            let [from, until] = [from, until].map(|at| Tick::from_millis(at * 1000));
            rules.timetable.windows.insert((Some(PartId(part)), it.mode(mode)), Window { from, until });
        }
    });
    let expected = [(10_000, "work_c"), (17_000, "work_b"), (19_000, "work_d"), (29_000, "work_a")];
    assert_eq!(starts(&it, &records, "work"), expected);
}

/// A timetable that no rule uses holds nothing.
#[test]
fn the_timetable_counts_only_where_it_is_a_rule() {
    let it = machine();
    let records = run(&it, &[DispatchRule::Fifo], |rules| {
        let never = Window { from: Tick::NEVER, until: Tick::NEVER };
        rules.timetable.windows.insert((Some(PartId(1)), it.mode("work_a")), never);
    });
    assert_eq!(starts(&it, &records, "work")[0], (10_000, "work_a"));
}

/// The times of seed 000 (L2029-2035): robot 1 loads robot 2 in 3, which works on part 1 for 7.5; it loads the human in 2,
/// who works for 5 on part 2, for 4 on part 3. Loading is a decision for loading and working: 10.5, 7, 6. So part 3 is
/// first. The rest of a part is that and its unloading: 13.5, 9, 8.
fn assembly(parts: [u32; 3]) -> Compiled {
    let net = lines([
        "load_1: input.1 robot_1 robot_2 -> robot_1 on.1",
        "load_2: input.2 robot_1 human -> robot_1 on.2",
        "load_3: input.3 robot_1 human -> robot_1 on.3",
        "work_1: on.1 -> ready.1",
        "work_2: on.2 -> ready.2",
        "work_3: on.3 -> ready.3",
        "unload_1: ready.1 robot_1 -> robot_1 robot_2 output.1",
        "unload_2: ready.2 robot_1 -> robot_1 human output.2",
        "unload_3: ready.3 robot_1 -> robot_1 human output.3",
    ]);
    let [one, two, three] = parts;
    let marked = [("input.1", one), ("input.2", two), ("input.3", three), ("robot_1", 1), ("robot_2", 1), ("human", 1)];
    let time = |name: &str| -> PlayedActivity {
        crate::player::plans::alone(match name {
            "load_1" | "unload_1" => 3000,
            "work_1" => 7500,
            "work_2" => 5000,
            "work_3" => 4000,
            _ => 2000,
        })
    };
    compiled(&net, &marked, time)
}

#[test]
fn processing_time_is_what_a_decision_leads_to() {
    let it = assembly([1, 1, 1]);
    let inner = RuleDispatcher::new(&it.table, &[DispatchRule::ShortestProcessingTime], Duration::from_secs(1000));
    let millis = |span: Duration| span.as_millis();
    let runs = ["load_1", "load_2", "load_3", "work_1", "unload_3"].map(|name| millis(inner.ways().run(it.mode(name))));
    assert_eq!(runs, [10_500, 7000, 6000, 7500, 2000]);
    let left = ["input.1", "input.2", "input.3", "ready.1", "output.1"];
    let left = left.map(|name| millis(inner.ways().remaining(it.cell(name))));
    assert_eq!(left, [13_500, 9000, 8000, 3000, 0]);
    let (records, _) = play(&it, &mut inner.clone(), Tick::from_millis(100_000), |_, _| true);
    // Worked out by hand: at 2 only part 1 can be loaded; at 6 the human is ready and the robot is free; and so on.
    let expected = [
        (0, "load_3"),
        (2000, "load_1"),
        (6000, "unload_3"),
        (8000, "load_2"),
        (12_500, "unload_1"),
        (15_500, "unload_2"),
    ];
    let moves: Vec<_> = starts(&it, &records, "").into_iter().filter(|(_, name)| !name.starts_with("work")).collect();
    assert_eq!(moves, expected);
}

/// The same cell with more parts of each kind, all there at 0: no chain of rules is faster than the shortest time there
/// is, which was found by exhaustive search (Dijkstra) in another program. And none takes more than all activities one after
/// the other, since none ever idles.
#[test]
fn no_rule_is_faster_than_the_optimum_and_none_idles() {
    for (parts, best) in [([1, 1, 1], 17_500), ([2, 2, 1], 31_000), ([2, 2, 2], 35_000), ([3, 3, 3], 52_500)] {
        let it = assembly(parts);
        let all: u64 = parts.iter().zip([13_500, 9000, 8000]).map(|(&count, work)| u64::from(count) * work).sum();
        for rules in DispatchRule::ALL.map(|(_, rule)| vec![rule]).into_iter().chain([vec![]]) {
            let mut by_rules = RuleDispatcher::new(&it.table, &rules, Duration::from_secs(1000));
            for part in 1..=parts.iter().sum::<u32>() {
                let due = Some(Tick::from_millis(u64::from(part * 7919 % 50_000)));
                by_rules
                    .jobs
                    .parts
                    .insert(PartId(part.into()), PartPriority { due, priority: (part * 7919 % 5) as i32 });
            }
            let (_, player) = play(&it, &mut by_rules, Tick::from_millis(1_000_000), |_, _| true);
            let done = ["output.1", "output.2", "output.3"].map(|name| player.state().marking().count(it.cell(name)));
            assert_eq!(done, parts.map(u64::from), "{rules:?}");
            let took = player.state().now().as_micros() / 1000;
            assert!(took >= best && took < all, "{rules:?} {parts:?}: {took}");
        }
    }
}

/// A part inside goes before one outside, whatever the rules; among those outside the rules decide.
#[test]
fn parts_inside_go_before_parts_outside() {
    let net = lines([
        "move: stored.in slot hand -> hand gone",
        "enter_1: supply_1 hand -> hand stored.1",
        "enter_2: supply_2 hand -> hand stored.2",
    ]);
    let marked = ["stored.in", "slot", "hand", "supply_1", "supply_2"].map(|name| (name, 1));
    let it = compiled(&net, &marked, |_| seconds(1));
    let mut rules = RuleDispatcher::new(&it.table, &[DispatchRule::Priority], Duration::from_secs(1000));
    for (mode, priority) in [("enter_1", 5), ("enter_2", 7)] {
        let waiting = EntryCandidate { job: PartPriority { due: None, priority }, since: Tick::ZERO };
        rules.jobs.outside.insert(it.mode(mode), waiting);
    }
    let (records, _) = play(&it, &mut rules, Tick::from_millis(60_000), |_, _| true);
    assert_eq!(starts(&it, &records, ""), [(0, "move"), (1000, "enter_2"), (2000, "enter_1")]);
}
