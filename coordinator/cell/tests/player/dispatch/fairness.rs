//! Parts that wait for ever without urgency, and not with it.

use std::cell::Cell;
use std::time::Duration;

use linewright_coordinator_cell::dispatch::{
    DispatchRule, EntryCandidate, Fairness, PartPriority, RuleDispatcher, Window,
};
use linewright_coordinator_cell::{HoldReason, PartId, PartPlace, RecordKind};
use linewright_line::Tick;

use super::solo::{ByName, compiled, lines, play, seconds, starts};
use crate::player::plans::{Compiled, alone};
use linewright_random::Random as Dice;

/// Ten minutes.
const LONG: Tick = Tick::from_millis(600_000);

/// `low` parts matter least.
fn job(cell: &str) -> PartPriority {
    PartPriority { due: None, priority: if cell.contains("low") { 0 } else { 9 } }
}

fn by_priority(it: &Compiled, fairness: Fairness) -> ByName<fn(&str) -> PartPriority> {
    let mut inner = RuleDispatcher::new(&it.table, &[DispatchRule::Priority], Duration::ZERO);
    inner.fairness = fairness;
    ByName { inner, job }
}

/// First start, within ten minutes, of a mode named so.
fn first(it: &Compiled, fairness: Fairness, name: &str) -> Option<u64> {
    let (records, _) = play(it, &mut by_priority(it, fairness), LONG, |_, _| true);
    starts(it, &records, name).first().map(|&(at, _)| at)
}

const PATIENT: Fairness = Fairness { patience: Some(Duration::from_secs(60)), reserves: true, inherits: true };

fn one_machine() -> Compiled {
    compiled(
        &lines([
            "enter: room -> waiting.high",
            "work_high: waiting.high machine -> machine room",
            "enter_low: supply -> waiting.low",
            "work_low: waiting.low machine -> machine done.low",
        ]),
        &[("room", 3), ("machine", 1), ("supply", 1)],
        |name| if name.starts_with("work") { seconds(2) } else { alone(500) },
    )
}

/// One machine, 2 s for each part, and there is always a better one.
#[test]
fn a_part_that_is_never_the_best_waits_for_ever_without_patience_and_not_with_it() {
    let it = one_machine();
    assert_eq!(first(&it, Fairness::OFF, "work_low"), None);
    // It has waited since 0.5 s; the machine ends what it does at 0.5 s and every 2 s after that.
    assert_eq!(first(&it, PATIENT, "work_low"), Some(60_500));
}

/// A part needs two tools, which others take one at a time and never release together.
fn two_tools() -> Compiled {
    compiled(
        &lines([
            "enter_left: room_left -> waiting.left",
            "enter_right: room_right -> waiting.right",
            "work_left: waiting.left left -> left room_left",
            "work_right: waiting.right right -> right room_right",
            "enter_low: supply -> waiting.low",
            "work_low: waiting.low left right -> left right done.low",
        ]),
        &[("room_left", 2), ("room_right", 2), ("left", 1), ("right", 1), ("supply", 1)],
        |name| match name {
            "enter_right" => seconds(1),
            "enter_left" => seconds(2),
            "enter_low" => seconds(3),
            _ => seconds(2),
        },
    )
}

/// From 3 s on; the left tool comes back at even seconds, the right one at odd seconds.
#[test]
fn what_needs_two_things_that_never_come_together_gets_them_by_reservation() {
    let it = two_tools();
    assert_eq!(first(&it, Fairness::OFF, "work_low"), None);
    assert_eq!(first(&it, Fairness { reserves: false, ..PATIENT }, "work_low"), None);
    // Urgent from 63 s on, when the right tool comes back and is kept; the left one comes at 64 s.
    assert_eq!(first(&it, PATIENT, "work_low"), Some(64_000));
}

/// And the record has for which part it is kept.
#[test]
fn what_is_kept_for_an_urgent_part_is_said() {
    let it = two_tools();
    let (records, _) = play(&it, &mut by_priority(&it, PATIENT), LONG, |_, _| true);
    let held: Vec<_> = records
        .iter()
        .filter_map(|record| match &record.fact {
            RecordKind::Decided { held, .. } => Some(held.iter().map(|held| (record.at, *held))),
            _ => None,
        })
        .flatten()
        .filter(|(_, (_, reason))| matches!(reason, HoldReason::ReservedFor { .. }))
        .collect();
    let [(at, (mode, reason)), ..] = held[..] else { panic!("nothing was kept") };
    assert_eq!((at, mode), (Tick::from_millis(63_000), it.mode("work_right")));
    assert_eq!(
        linewright_coordinator_cell::texts::reason(&it.table, &reason),
        "resources reserved for `work_low`: part 3 waited longer than patience_s"
    );
}

/// A machine has to be cleaned before a part can use it. Cleaning moves no part, so it never waits too long itself; and the
/// robot that would do it always has something better to do.
#[test]
fn what_is_in_the_way_of_an_urgent_part_is_done_in_its_place() {
    let it = compiled(
        &lines([
            "enter: room -> waiting.high",
            "work_high: waiting.high robot -> robot room",
            "soil: fresh -> dirty",
            "clean: dirty robot -> robot clean",
            "enter_low: supply -> waiting.low",
            "work_low: waiting.low clean -> done.low dirty",
        ]),
        &[("room", 3), ("robot", 1), ("fresh", 1), ("supply", 1)],
        |name| match name {
            "clean" => seconds(5),
            "soil" => seconds(2),
            _ => seconds(1),
        },
    );
    assert_eq!(first(&it, Fairness::OFF, "clean"), None);
    assert_eq!(first(&it, Fairness { inherits: false, ..PATIENT }, "clean"), None);
    // The part is there since 1 s, so it is urgent at 61 s, when the robot comes back.
    assert_eq!(first(&it, PATIENT, "clean"), Some(61_000));
    assert_eq!(first(&it, PATIENT, "work_low"), Some(66_000));
}

/// A token that an urgent part lacks and no mode can bring is not waited for by others.
#[test]
fn a_part_that_nothing_helps_keeps_nothing_from_others() {
    let it = compiled(
        &lines([
            "enter: room -> waiting.high",
            "work_high: waiting.high robot -> robot room",
            "work_low: waiting.low robot key -> robot done.low",
        ]),
        &[("room", 3), ("robot", 1), ("waiting.low", 1)],
        |_| seconds(1),
    );
    let (records, player) = play(&it, &mut by_priority(&it, PATIENT), LONG, |_, _| true);
    assert!(starts(&it, &records, "work_high").len() > 590, "the robot is never idle");
    assert_eq!(player.state().parts().filter(|part| part.entered == Tick::ZERO).count(), 1);
}

/// A stack of two: what lies beneath needs its neighbour gone *and* the machine free, and whatever is gone is put back by
/// others while the machine works. The free ones of these are kept, too.
#[test]
fn what_lies_at_the_bottom_of_a_stack_gets_out() {
    let it = compiled(
        &lines([
            "enter: room -> in.high",
            "put: in.high top2 -> at2.high top3",
            "get: at2.high top3 machine -> top2 on.high",
            "work_high: on.high -> machine room",
            "get_low: at1.low top2 machine -> top1 on.low",
            "work_low: on.low -> machine",
        ]),
        &[("room", 3), ("top2", 1), ("machine", 1), ("at1.low", 1), ("at2.high", 0)],
        |name| if name == "put" { alone(100) } else { seconds(1) },
    );
    // At 0 s nothing is in the way, so the part is only there to be kept in by one that comes before.
    let mut by_priority = by_priority(&it, PATIENT);
    let low = Some(PartId(1));
    let window = Window { from: Tick::from_millis(5500), until: Tick::NEVER };
    by_priority.inner.rules.insert(0, DispatchRule::Schedule);
    by_priority.inner.timetable.windows.insert((low, it.mode("get_low")), window);
    // Then it would be the first by the timetable.
    by_priority.inner.rules.rotate_left(1);
    let first = |fairness| {
        let mut dispatcher = ByName { inner: by_priority.inner.clone(), job: by_priority.job };
        dispatcher.inner.fairness = fairness;
        let (records, _) = play(&it, &mut dispatcher, LONG, |_, _| true);
        starts(&it, &records, "get_low").first().map(|&(at, _)| at)
    };
    assert_eq!(first(Fairness::OFF), None);
    assert_eq!(first(Fairness { reserves: false, ..PATIENT }), None);
    assert!(first(PATIENT).is_some_and(|at| (60_000..66_000).contains(&at)), "{:?}", first(PATIENT));
}

/// A part that would enter can wait too long as well, since the production orders have the time from which it could
/// have.
#[test]
fn what_waits_outside_does_not_wait_for_ever() {
    let it = compiled(
        &lines([
            "enter_high: slot -> waiting.high",
            "leave_high: waiting.high -> slot",
            "enter_low: slot supply -> waiting.low",
            "leave_low: waiting.low -> slot",
        ]),
        &[("slot", 1), ("supply", 1)],
        |_| seconds(1),
    );
    let first = |fairness| {
        let mut dispatcher = by_priority(&it, fairness);
        for (mode, priority, since) in [("enter_high", 9, Tick::NEVER), ("enter_low", 0, Tick::ZERO)] {
            let waiting = EntryCandidate { job: PartPriority { due: None, priority }, since };
            dispatcher.inner.jobs.outside.insert(it.mode(mode), waiting);
        }
        let (records, _) = play(&it, &mut dispatcher, LONG, |_, _| true);
        starts(&it, &records, "enter_low").first().map(|&(at, _)| at)
    };
    assert_eq!(first(Fairness::OFF), None);
    assert_eq!(first(PATIENT), Some(60_000));
}

/// A part that is to wait by the timetable is not urgent before its window opens.
#[test]
fn what_is_planned_for_later_is_not_urgent() {
    let it = one_machine();
    let mut dispatcher = by_priority(&it, PATIENT);
    dispatcher.inner.rules.push(DispatchRule::Schedule);
    let window = Window { from: Tick::from_millis(300_000), until: Tick::from_millis(400_000) };
    dispatcher.inner.timetable.windows.insert((Some(PartId(2)), it.mode("work_low")), window);
    let (records, _) = play(&it, &mut dispatcher, LONG, |_, _| true);
    // Its priority would let it wait for ever; as soon as it may, it has waited too long.
    assert_eq!(starts(&it, &records, "work_low"), [(300_500, "work_low")]);
}

/// A random cell: one or two robots, machines, a store; an endless stream of parts that matter and one or two that do not
/// and go round. No more are inside than the store has room for, so nothing gets stuck. In some cells the parts that do not
/// matter need two tools at once, of which the others need one each; in some a machine has to be cleaned before it is used
/// again, by a robot.
fn random(dice: &mut Dice) -> Compiled {
    let (robots, machines, lows) = (1 + dice.below(2), 2 + dice.below(2), 1 + dice.below(2));
    let slots = lows + 1 + dice.below(3);
    let (tools, dirt) = (dice.one_in(2), dice.one_in(2));
    let mut net = Vec::new();
    let mut times = vec![("again".to_owned(), 1000)];
    for (m, r) in (0..machines).flat_map(|m| (0..robots).map(move |r| (m, r))).filter(|_| dirt) {
        net.push(format!("clean_{m}_{r}: dirty{m} r{r} -> r{r} m{m}"));
        times.push((format!("clean_{m}_{r}"), 1000));
    }
    for kind in ["low", "high", "best"] {
        let steps = 1 + dice.below(2);
        for step in 0..steps {
            for m in (0..machines).filter(|m| *m == step % machines || dice.one_in(2)).collect::<Vec<_>>() {
                for r in 0..robots {
                    let mut add = |line: String, millis| {
                        times.push((line.split(':').next().unwrap().to_owned(), millis));
                        net.push(line);
                    };
                    let time = |dice: &mut Dice| 1000 + dice.below(4000) as u64;
                    let at = format!("{kind}_{step}_{m}");
                    let (from, to) = (format!("st{step}.{kind}"), format!("st{}.{kind}", step + 1));
                    add(format!("load_{at}_{r}: {from} m{m} r{r} -> r{r} slot on{step}m{m}.{kind}"), time(dice));
                    if r == 0 {
                        let tools = match (tools, kind) {
                            (false, _) => "",
                            (true, "low") => "t0 t1",
                            (true, "high") => "t0",
                            (true, _) => "t1",
                        };
                        let process = format!("on{step}m{m}.{kind} {tools} -> {tools} off{step}m{m}.{kind}");
                        add(format!("process_{at}: {process}"), time(dice));
                    }
                    let left = if dirt { "dirty" } else { "m" };
                    let unload = format!("off{step}m{m}.{kind} r{r} slot -> r{r} {left}{m} {to}");
                    add(format!("unload_{at}_{r}: {unload}"), time(dice));
                }
            }
        }
        if kind == "low" {
            net.push(format!("again: st{steps}.low -> st0.low"));
        } else {
            net.push(format!("enter_{kind}: permit slot -> st0.{kind}"));
            net.push(format!("leave_{kind}: st{steps}.{kind} -> permit slot"));
            times.push((format!("enter_{kind}"), 200));
            times.push((format!("leave_{kind}"), 100));
        }
    }
    let names: Vec<String> =
        (0..machines).map(|m| format!("m{m}")).chain((0..robots).map(|r| format!("r{r}"))).collect();
    let mut marked: Vec<(&str, u32)> = names.iter().map(|name| (name.as_str(), 1)).collect();
    marked.extend([("t0", 1), ("t1", 1)]);
    marked.extend([("slot", (slots - lows) as u32), ("permit", (slots - lows) as u32), ("st0.low", lows as u32)]);
    compiled(&net, &marked, |name| alone(times.iter().find(|(of, _)| of == name).map_or(0, |&(_, millis)| millis)))
}

/// The longest time in an hour for which a part that could be taken on has rested.
fn longest(it: &Compiled, fairness: Fairness) -> Duration {
    let most = Cell::new(Duration::ZERO);
    let job =
        |cell: &str| PartPriority { due: None, priority: if cell.ends_with("low") { 0 } else { cell.len() as i32 } };
    let mut inner =
        RuleDispatcher::new(&it.table, &[DispatchRule::Priority, DispatchRule::ShortestProcessingTime], Duration::ZERO);
    inner.fairness = fairness;
    let (_, player) = play(it, &mut ByName { inner, job }, Tick::from_millis(3_600_000), |now, state| {
        let rests = state.parts().filter(|part| matches!(part.place, PartPlace::On { .. }));
        most.set(rests.map(|part| now.since(part.since)).chain([most.get()]).max().unwrap());
        true
    });
    assert!(player.state().now() > Tick::from_millis(3_500_000), "it goes on all the time");
    most.get()
}

/// With a patience of a minute no part waits for more than two; without, one waits for more than half of the hour in many
/// cells. Cells that need reservation and inheritance are above: cells by chance rarely are so tight.
#[test]
fn in_random_cells_nobody_waits_longer_than_patience_and_a_bound() {
    let cell = |seed| random(&mut Dice::new(seed));
    let worst = (0..100).map(|seed| longest(&cell(seed), PATIENT)).max().unwrap();
    assert!(worst < Duration::from_secs(120), "{worst:?}");
    let starved = (0..40).filter(|&seed| longest(&cell(seed), Fairness::OFF) > Duration::from_secs(1800)).count();
    assert!(starved > 10, "{starved}");
}
