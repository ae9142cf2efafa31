//! Schedules: as short as an exact oracle's, followed to the letter where the cell is as it should be, within their windows
//! where it is not, and never a reason for a part to wait for ever.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_cell::ActivityKind;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::ahead::{LookAhead, SimulationBasis};
use linewright_coordinator_cell::compile::{CompiledCell, OrderTiming, compile_cell};
use linewright_coordinator_cell::dispatch::RuleDispatcher;
use linewright_coordinator_cell::production::{DispatchConfiguration, Production};
use linewright_coordinator_cell::schedule::{
    PlanningSituation, RevisionReason, RolloutScheduler, Schedule, ScheduleFollower, Scheduler,
};
use linewright_coordinator_cell::{HoldReason, ModeId, PartId, PlayerState, RecordKind};
use linewright_line::Tick;
use linewright_random::Random;

use super::oracle::{least_tardiness, shortest};
use super::shop::{ASSEMBLY, C1, Made, Shop};

/// It takes what it needs to be sure.
const THOROUGH: RolloutScheduler = RolloutScheduler { effort: 200_000, exact: true, looks_ahead: true, samples: true };
const LONG: Tick = Tick::from_millis(86_400_000);

/// A net in which so many parts of each type are in the first store, and nothing comes or goes: it, its marking, the times of
/// its transitions in milliseconds, and the places of finished parts, type by type.
struct Closed {
    made: CompiledCell,
    marking: Vec<u32>,
    times: Vec<Option<u64>>,
    finished: Vec<Vec<usize>>,
    all: u32,
}

impl Closed {
    fn new(text: &str, counts: &[u32]) -> Self {
        let cell =
            linewright_cell::parse("cell.toml", text, None).unwrap_or_else(|problems| panic!("{problems:#}")).cell;
        let pace = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };
        let made = compile_cell(&cell, None, Supply::Closed(counts), pace).unwrap_or_else(|why| panic!("{why}"));
        let net = made.long.net();
        let mut marking = net.initial_marking().as_slice().to_vec();
        let of = |t| made.net.move_of(&cell, made.long.mode(t));
        let time = |t| {
            let (activity, of) = of(t)?;
            let inside = !matches!(activity.kind, ActivityKind::Enter | ActivityKind::Leave);
            inside.then(|| of.time.map_or(0, |time| time.as_millis() as u64))
        };
        let times: Vec<Option<u64>> = net.transitions().map(time).collect();
        // All come in first; that takes no time.
        let enters = |&t: &_| of(t).is_some_and(|(activity, _)| activity.kind == ActivityKind::Enter);
        for t in net.transitions().filter(enters) {
            while net.preset(t).iter().all(|&(place, weight)| marking[place.index()] >= weight) {
                net.preset(t).iter().for_each(|&(place, weight)| marking[place.index()] -= weight);
                net.postset(t).iter().for_each(|&(place, weight)| marking[place.index()] += weight);
            }
        }
        let places = |part: &str| {
            let name = format!(".stored-parts<{part}.done>");
            net.places().filter(|&p| net.place_name(p).ends_with(&name)).map(|p| p.index()).collect()
        };
        let finished = cell.part_types.iter().map(|part| places(&part.name)).collect();
        Closed { marking, times, finished, all: counts.iter().sum(), made }
    }

    fn is_done(&self, marking: &[u32]) -> bool {
        self.finished.iter().flatten().map(|&place| marking[place]).sum::<u32>() == self.all
    }
}

/// The shortest makespan in milliseconds.
fn optimum(text: &str, counts: &[u32]) -> u64 {
    let closed = Closed::new(text, counts);
    shortest(closed.made.long.net(), closed.marking.clone(), &closed.times, |marking| closed.is_done(marking)).unwrap()
}

/// The least tardiness in milliseconds, where parts of each type are due after so many.
fn least(text: &str, counts: &[u32], due: &[u64]) -> u64 {
    let closed = Closed::new(text, counts);
    let net = closed.made.long.net();
    let mut dues = vec![None; net.place_count()];
    for (places, &due) in closed.finished.iter().zip(due) {
        places.iter().for_each(|&place| dues[place] = Some(due));
    }
    let done = |marking: &[u32]| closed.is_done(marking);
    least_tardiness(net, closed.marking.clone(), &closed.times, &dues, done).unwrap()
}

/// The assembly cell with room for nine.
fn roomy() -> String {
    ASSEMBLY.replace("capacity = 5", "capacity = 9").replace("wip_max = 5", "wip_max = 9")
}

fn orders(counts: &[u32]) -> Vec<(&'static str, u32, Option<u64>)> {
    ["1", "2", "3"]
        .into_iter()
        .zip(counts)
        .filter(|(_, count)| **count > 0)
        .map(|(name, &count)| (name, count, None))
        .collect()
}

fn planned(made: &Made, desk: &DispatchConfiguration, scheduler: &mut dyn Scheduler) -> Schedule {
    let basis = SimulationBasis::new(&made.table);
    let state = PlayerState::new(made.table.clone());
    let (now, until) = (Tick::ZERO, Tick::NEVER);
    scheduler.plan(&PlanningSituation { now, until, state: &state, desk, basis: &basis, previous: None })
}

fn desk(made: &Made, production: Production) -> DispatchConfiguration {
    DispatchConfiguration::new(
        RuleDispatcher::new(&made.table, &made.cell.dispatch.rules, made.cell.dispatch.patience),
        production,
    )
}

fn follower(made: &Made, production: Production, patience: u64, tolerance: u64) -> ScheduleFollower {
    let look = LookAhead::new(&made.table, desk(made, production), made.cell.dispatch.look_ahead);
    let mut follower = ScheduleFollower::new(look, Box::new(THOROUGH));
    follower.look.desk.rules.fairness.patience = Some(Duration::from_secs(patience));
    follower.tolerance = Duration::from_secs(tolerance);
    follower
}

/// The figures were worked out beforehand by another program, with all parts waiting at the beginning.
#[test]
fn schedules_of_the_assembly_cell_are_as_short_as_can_be() {
    let text = roomy();
    let made = Made::new(&text);
    for (counts, expected) in [([1, 1, 1], 17_500), ([2, 2, 1], 31_000), ([2, 2, 2], 35_000), ([3, 3, 3], 52_500)] {
        assert_eq!(optimum(&text, &counts), expected, "{counts:?}");
        let production = made.ordered(&orders(&counts));
        let schedule = planned(&made, &desk(&made, production.clone()), &mut { THOROUGH });
        assert_eq!((schedule.score.makespan, schedule.proved), (expected * 1000, true), "{counts:?}");
        // And the cell really does it in that time.
        let mut shop = Shop::new(&made.table);
        let mut follower = follower(&made, production, 10_000, 0);
        shop.run(&mut follower, LONG);
        assert_eq!(shop.state().left(), u64::from(counts.iter().sum::<u32>()));
        assert_eq!(shop.makespan(), Tick::from_millis(expected));
        assert_eq!(follower.revisions().len(), 1, "{:?}", follower.revisions().collect::<Vec<_>>());
    }
}

/// Where parts are due, nothing is less late than what is planned, and the shorter makespan is not paid for with tardiness.
#[test]
fn schedules_are_as_little_late_as_can_be() {
    let text = roomy();
    let made = Made::new(&text);
    let mut unequal = 0;
    for (counts, due) in [
        ([1, 1, 1], [10, 10, 10]),
        ([1, 1, 1], [14, 9, 13]),
        ([2, 1, 1], [20, 12, 12]),
        ([1, 2, 2], [40, 15, 20]),
        ([2, 2, 1], [15, 30, 12]),
    ] {
        let orders: Vec<_> =
            orders(&counts).into_iter().zip(due).map(|((name, n, _), due)| (name, n, Some(due))).collect();
        let schedule = planned(&made, &desk(&made, made.ordered(&orders)), &mut { THOROUGH });
        let expected = least(&text, &counts, &due.map(|due| due * 1000));
        assert_eq!((schedule.score.tardiness, schedule.proved), (expected * 1000, true), "{counts:?} {due:?}");
        unequal += usize::from(schedule.score.makespan > optimum(&text, &counts) * 1000);
    }
    assert!(unequal > 0, "the shortest is always the least late: this tests little");
}

/// Workcells with times by chance: what is proved to be the shortest is.
#[test]
fn what_is_proved_is_the_optimum_of_random_cells() {
    let mut random = Random::new(12_345);
    let mut draw = || 1 + random.below(60);
    let (mut by_rules, mut proved) = (0, 0);
    for round in 0..24 {
        let mut text = String::new();
        for line in C1.lines() {
            let mut rest = line;
            while let Some((before, after)) = rest.split_once("time_s = ") {
                let digits = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
                text.push_str(&format!("{before}time_s = {}", draw()));
                rest = &after[digits..];
            }
            text.push_str(rest);
            text.push('\n');
        }
        // Limits are not what this is about.
        let text = text.replace(", max_s = 24", "").replace(", max_s = 26", "");
        let made = Made::new(&text);
        let counts = [[1, 1], [2, 1], [1, 2], [2, 2]][round % 4];
        let production = made.ordered(&[("A", counts[0], None), ("B", counts[1], None)]);
        let desk = desk(&made, production);
        let schedule = planned(&made, &desk, &mut { THOROUGH });
        let least = optimum(&text, &counts) * 1000;
        assert!(schedule.score.makespan >= least, "{round}");
        if schedule.proved {
            assert_eq!(schedule.score.makespan, least, "{round}");
            proved += 1;
        }
        let rough = planned(
            &made,
            &desk,
            &mut RolloutScheduler { effort: 100_000, exact: false, looks_ahead: false, samples: false },
        );
        assert!(rough.score >= schedule.score && !rough.proved);
        by_rules += usize::from(rough.score.makespan > least);
    }
    assert!(proved >= 20, "{proved} of 24 were proved");
    assert!(by_rules > 0, "rules alone find the optimum everywhere: this tests nothing");
}

/// As [`ScheduleFollower`] followed it: what was planned for each start, in force at that time.
fn strays(shop: &Shop, follower: &ScheduleFollower) -> Vec<(ModeId, Option<PartId>, Tick)> {
    let mut all = Vec::new();
    for record in &shop.log {
        if let RecordKind::Started { mode, part, .. } = record.fact {
            let known = |part| follower.bars().find(|bar| bar.mode == mode && bar.part == part && bar.actual.is_some());
            let bar = known(part).unwrap_or_else(|| panic!("{mode} with {part:?} has no bar"));
            assert_eq!(bar.actual.unwrap().0, record.at, "the chart has what happened");
            match bar.planned {
                Some((from, _)) if from <= record.at + follower.tolerance => (),
                Some(_) | None => all.push((mode, part, record.at)),
            }
        }
    }
    all
}

/// Where activities take less time than they should, nothing starts before its window, less the tolerance.
#[test]
fn nothing_starts_before_its_window() {
    for (tolerance, early) in [(0, 0), (5, 1)] {
        let made = Made::new(C1);
        let mut follower = follower(&made, made.ordered(&[("A", 3, None), ("B", 3, None)]), 10_000, tolerance);
        let mut shop = Shop::new(&made.table);
        for mode in made.table.modes().filter(|&mode| made.table.mode_name(mode).starts_with("load")) {
            shop.really.insert(mode, Duration::from_secs(8));
        }
        shop.run(&mut follower, LONG);
        assert_eq!(shop.state().left(), 6);
        assert_eq!(strays(&shop, &follower), []);
        assert_eq!(follower.revisions().len(), 1, "it was one schedule all the time");
        let before = follower.bars().filter(|bar| bar.planned.is_some_and(|(from, _)| bar.actual.unwrap().0 < from));
        assert!(before.count() >= early, "the tolerance is made use of");
        let held = shop.log.iter().filter_map(|record| match &record.fact {
            RecordKind::Decided { held, .. } => Some(held),
            _ => None,
        });
        assert!(held.flatten().any(|(_, reason)| matches!(reason, HoldReason::NotYet(_))), "something was held");
    }
}

/// Plans badly on purpose: whatever the question, everything is planned for a day later.
struct Procrastinator(RolloutScheduler);

impl Scheduler for Procrastinator {
    fn plan(&mut self, situation: &PlanningSituation<'_>) -> Schedule {
        let now = situation.now + Duration::from_secs(86_400);
        self.0.plan(&PlanningSituation { now, ..*situation })
    }
}

/// A schedule can make a part wait, but not for longer than parts should wait: then it is as urgent as any, and starts.
#[test]
fn no_schedule_makes_anybody_wait_longer_than_patience() {
    let made = Made::new(C1);
    let production = || made.ordered(&[("A", 2, None), ("B", 2, None)]);
    let patience = Duration::from_secs(100);
    let look = || {
        let mut desk = desk(&made, production());
        desk.rules.fairness.patience = Some(patience);
        LookAhead::new(&made.table, desk, Duration::ZERO)
    };
    let mut follower = ScheduleFollower::new(look(), Box::new(Procrastinator(RolloutScheduler::default())));
    let mut shop = Shop::new(&made.table);
    shop.run(&mut follower, Tick::from_millis(86_000_000));
    assert_eq!(shop.state().left(), 4, "all is done before any window opens");
    let mut waited: BTreeMap<PartId, Tick> = BTreeMap::new();
    let mut longest = Duration::ZERO;
    for record in &shop.log {
        if let RecordKind::Started { part: Some(part), .. } = record.fact {
            let since = waited.insert(part, record.at);
            longest = longest.max(since.map_or(Duration::ZERO, |since| record.at.since(since)));
        }
    }
    // A start, an activity of a minute at most, patience, and a robot that has to come.
    assert!(longest > patience && longest < patience + Duration::from_secs(240), "{longest:?}");
}

/// An urgent part goes before one whose window is open, and is not held by its own.
#[test]
fn patience_goes_before_windows() {
    let made = Made::new(C1);
    let mut follower = follower(&made, made.ordered(&[("A", 4, None), ("B", 4, None)]), 60, 0);
    let mut shop = Shop::new(&made.table);
    shop.run(&mut follower, LONG);
    assert_eq!(shop.state().left(), 8);
    // No part that had waited a minute was held by the schedule at any question.
    let (mut state, mut urgent) = (PlayerState::new(made.table.clone()), 0);
    for record in &shop.log {
        state.apply(record).unwrap();
        let RecordKind::Decided { held, .. } = &record.fact else { continue };
        for (mode, reason) in held {
            let by_plan = matches!(reason, HoldReason::NotYet(_) | HoldReason::PlannedOtherwise(_));
            let waits = |part: PartId| record.at.since(state.part(part).unwrap().since) >= Duration::from_secs(60);
            let all_late = state.takeable(*mode).count() > 0 && state.takeable(*mode).all(waits);
            assert!(!by_plan || !all_late, "{} at {}", made.table.mode_name(*mode), record.at);
            urgent += usize::from(all_late);
        }
    }
    assert!(urgent > 0, "nobody waits for a minute: this tests nothing");
}

#[test]
fn the_same_cell_has_the_same_schedule() {
    let made = Made::new(C1);
    let desk = desk(&made, made.ordered(&[("A", 4, Some(300)), ("B", 4, Some(200))]));
    let plan = || planned(&made, &desk, &mut RolloutScheduler { effort: 20_000, ..RolloutScheduler::default() });
    assert_eq!(plan(), plan());
}

/// A large order is planned as far as the effort goes, and the rest when that is over.
#[test]
fn what_is_too_large_is_planned_in_part() {
    let made = Made::new(C1);
    let production = made.ordered(&[("A", 1_000_000, None)]);
    let schedule =
        planned(&made, &desk(&made, production), &mut RolloutScheduler { effort: 2000, ..RolloutScheduler::default() });
    let starts = schedule.slots().len();
    assert!((1000..=2000).contains(&starts) && !schedule.proved, "{starts}");
}

/// An order that is planned piece by piece is made all the same.
#[test]
fn when_all_that_was_planned_has_started_more_is_planned() {
    let made = Made::new(C1);
    let mut desk = desk(&made, made.ordered(&[("A", 20, None), ("B", 20, None)]));
    desk.rules.fairness.patience = Some(Duration::from_secs(100_000));
    let scheduler = RolloutScheduler { effort: 60, exact: false, looks_ahead: false, samples: false };
    let mut follower = ScheduleFollower::new(LookAhead::new(&made.table, desk, Duration::ZERO), Box::new(scheduler));
    let mut shop = Shop::new(&made.table);
    shop.run(&mut follower, LONG);
    assert_eq!(shop.state().left(), 40);
    let whys: Vec<RevisionReason> = follower.revisions().map(|revision| revision.why).collect();
    assert!(whys.len() > 3 && whys[1..].iter().all(|why| *why == RevisionReason::Over), "{whys:?}");
}

/// A large order enters part by part; the long wait of its last parts outside makes none urgent.
#[test]
fn an_order_that_goes_on_is_not_urgent() {
    let made = Made::new(C1);
    let mut desk = desk(&made, made.ordered(&[("A", 60, None)]));
    let mut shop = Shop::new(&made.table);
    shop.run(&mut desk, Tick::from_millis(2_000_000));
    assert!(shop.state().left() > 10 && shop.state().left() < 50);
    assert!(!desk.rules.is_pressed(shop.now, shop.state()));
}
