//! Who waits for ever without urgency, and does not with it.

use std::cell::Cell;
use std::time::Duration;

use linewright_coordinator_logic::cell::dispatch::{ByRules, Fairness, Job, Rule};
use linewright_coordinator_logic::cell::{Fact, Place, Reason};
use linewright_line::Tick;

use super::solo::{ByName, compiled, lines, play, seconds, starts};
use crate::dice::Dice;
use crate::plans::{Compiled, alone};

/// Ten minutes.
const LONG: Tick = Tick::from_millis(600_000);

/// `low` parts matter least.
fn job(cell: &str) -> Job {
    Job { due: None, priority: if cell.contains("low") { 0 } else { 9 } }
}

fn by_priority(it: &Compiled, fairness: Fairness) -> ByName<fn(&str) -> Job> {
    let mut inner = ByRules::new(&it.table, &[Rule::Priority], Duration::ZERO);
    inner.fairness = fairness;
    ByName { inner, job }
}

/// When something named so was first started in ten minutes.
fn first(it: &Compiled, fairness: Fairness, name: &str) -> Option<u64> {
    let (records, _) = play(it, &mut by_priority(it, fairness), LONG, |_, _| true);
    starts(it, &records, name).first().map(|&(at, _)| at)
}

const PATIENT: Fairness = Fairness { patience: Some(Duration::from_secs(60)), reserves: true, inherits: true };

/// One machine, 2 s for each part, and there is always a better one.
#[test]
fn a_part_that_is_never_the_best_waits_for_ever_without_patience_and_not_with_it() {
    let it = compiled(
        &lines([
            "enter: room -> waiting.high",
            "work_high: waiting.high machine -> machine room",
            "enter_low: supply -> waiting.low",
            "work_low: waiting.low machine -> machine done.low",
        ]),
        &[("room", 3), ("machine", 1), ("supply", 1)],
        |name| if name.starts_with("work") { seconds(2) } else { alone(500) },
    );
    assert_eq!(first(&it, Fairness::OFF, "work_low"), None);
    // It has waited since 0.5 s; the machine ends what it does at 0.5 s and every 2 s after that.
    assert_eq!(first(&it, PATIENT, "work_low"), Some(60_500));
}

/// A part needs two tools, which others take one at a time and never let go of together.
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

/// And the record says for whom it is kept.
#[test]
fn what_is_kept_for_an_urgent_part_is_said() {
    let it = two_tools();
    let (records, _) = play(&it, &mut by_priority(&it, PATIENT), LONG, |_, _| true);
    let held: Vec<_> = records
        .iter()
        .filter_map(|record| match &record.fact {
            Fact::Decided { held, .. } => Some(held.iter().map(|held| (record.at, *held))),
            _ => None,
        })
        .flatten()
        .filter(|(_, (_, reason))| matches!(reason, Reason::ReservedFor { .. }))
        .collect();
    let [(at, (mode, reason)), ..] = held[..] else { panic!("nothing was kept") };
    assert_eq!((at, mode), (Tick::from_millis(63_000), it.mode("work_right")));
    assert_eq!(
        linewright_coordinator_logic::cell::dispatch::words::reason(&it.table, &reason),
        "what it needs is kept for `work_low`: part 3 has waited too long"
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

/// What an urgent part lacks and nobody can bring is not waited for by others.
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

/// A random cell: one or two robots, machines, a store; an endless stream of parts that matter and one or two that do not
/// and go round. No more are inside than the store has room for, so nothing gets stuck.
fn random(dice: &mut Dice) -> Compiled {
    let (robots, machines, lows) = (1 + dice.below(2), 2 + dice.below(2), 1 + dice.below(2));
    let slots = lows + 1 + dice.below(3);
    let mut net = Vec::new();
    let mut times = vec![("again".to_owned(), 1000)];
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
                        add(format!("process_{at}: on{step}m{m}.{kind} -> off{step}m{m}.{kind}"), time(dice));
                    }
                    add(format!("unload_{at}_{r}: off{step}m{m}.{kind} r{r} slot -> r{r} m{m} {to}"), time(dice));
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
    marked.extend([("slot", (slots - lows) as u32), ("permit", (slots - lows) as u32), ("st0.low", lows as u32)]);
    compiled(&net, &marked, |name| alone(times.iter().find(|(of, _)| of == name).map_or(0, |&(_, millis)| millis)))
}

/// The longest time in an hour for which a part that somebody could take on has rested.
fn longest(it: &Compiled, fairness: Fairness) -> Duration {
    let most = Cell::new(Duration::ZERO);
    let job = |cell: &str| Job { due: None, priority: if cell.ends_with("low") { 0 } else { cell.len() as i32 } };
    let mut inner = ByRules::new(&it.table, &[Rule::Priority, Rule::ShortestProcessingTime], Duration::ZERO);
    inner.fairness = fairness;
    let (_, player) = play(it, &mut ByName { inner, job }, Tick::from_millis(3_600_000), |now, state| {
        let rests = state.parts().filter(|part| matches!(part.place, Place::On { .. }));
        most.set(rests.map(|part| now.since(part.since)).chain([most.get()]).max().unwrap());
        true
    });
    assert!(player.state().now() > Tick::from_millis(3_500_000), "it goes on all the time");
    most.get()
}

/// With a patience of a minute nobody waits for more than two; without, somebody waits nearly all the hour in many cells.
#[test]
fn in_random_cells_nobody_waits_longer_than_patience_and_a_bound() {
    let (mut starved, mut worst) = (0, Duration::ZERO);
    for seed in 0..200 {
        let it = random(&mut Dice::new(seed));
        worst = worst.max(longest(&it, PATIENT));
        if seed % 4 == 0 {
            starved += usize::from(longest(&it, Fairness::OFF) > Duration::from_secs(1800));
        }
    }
    assert!(worst < Duration::from_secs(120), "{worst:?}");
    assert!(starved > 5, "{starved}");
}
