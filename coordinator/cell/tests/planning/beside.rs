//! Planning beside the decisions: requests, schedules that come late, or never, and what is decided meanwhile.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_cell::compile::{dispatcher, follower_beside, schedule_follower};
use linewright_coordinator_cell::dispatch::DispatchRule;
use linewright_coordinator_cell::production::{DispatchConfiguration, ProductionOrderRequest};
use linewright_coordinator_cell::schedule::{
    PlanningRequest, RevisionReason, RolloutScheduler, Schedule, Scheduler, WITHIN,
};
use linewright_coordinator_cell::{HoldReason, PartId, PlayerInput, ProductionCommand, Record, RecordKind};
use linewright_line::Tick;
use linewright_random::Random;
use linewright_simulation::cell::{CellSim, CellSimOptions, SimulatedOperator, SimulatedPlanner, StationSpeed};

use super::shop::{ASSEMBLY, C1, Made, request};

const LONG: Tick = Tick::from_millis(86_400_000);
const MS: fn(u64) -> Duration = Duration::from_millis;
type Orders<'a> = &'a [(&'a str, u32, Option<u64>)];

/// The cell with these orders, not yet played.
fn sim(made: &Made, orders: Orders<'_>, options: CellSimOptions) -> CellSim {
    let orders_of = made.table.modes().flat_map(|mode| &made.table.activity(mode).orders);
    let stations = orders_of.map(|order| order.station.index() + 1).max().unwrap_or(0);
    let mut sim = CellSim::new(made.table.clone(), stations, options);
    let requests: Vec<_> = (1..).zip(orders).map(|(key, of)| request(key, of)).collect();
    let mut rules = DispatchConfiguration::new(dispatcher(&made.cell, &made.table), sim.state().production().clone());
    sim.say(&mut rules, &[PlayerInput::Production(0, ProductionCommand::Submit(&requests))]);
    sim
}

fn beside(made: &Made, sim: &CellSim, takes: impl FnMut(u64) -> Option<Duration> + 'static) -> SimulatedPlanner {
    let follower = follower_beside(&made.cell, &made.made, sim.state());
    SimulatedPlanner::new(follower, Box::new(RolloutScheduler::default()), takes)
}

fn by_rules(made: &Made, sim: &CellSim) -> DispatchConfiguration {
    DispatchConfiguration::new(dispatcher(&made.cell, &made.table), sim.state().production().clone())
}

fn end(log: &[Record]) -> Tick {
    let ends = log.iter().filter(|record| matches!(record.fact, RecordKind::Ended { .. }));
    ends.map(|record| record.at).max().unwrap_or(Tick::ZERO)
}

/// Starts, with times.
fn starts(log: &[Record]) -> Vec<(Tick, u32, Option<PartId>)> {
    let started = log.iter().filter_map(|record| match record.fact {
        RecordKind::Started { mode, part, .. } => Some((record.at, mode.0, part)),
        _ => None,
    });
    started.collect()
}

fn holds(log: &[Record]) -> impl Iterator<Item = (Tick, HoldReason)> + '_ {
    let held = log.iter().filter_map(|record| match &record.fact {
        RecordKind::Decided { held, .. } => Some((record.at, held)),
        _ => None,
    });
    held.flat_map(|(at, held)| held.iter().map(move |&(_, why)| (at, why)))
}

fn is_by_plan(why: HoldReason) -> bool {
    matches!(why, HoldReason::PlannedOtherwise(_) | HoldReason::NotYet(_))
}

/// The longest time from the end of a part's activity to the start of its next one.
fn longest_wait(log: &[Record]) -> Duration {
    let (mut since, mut longest, mut ends) = (BTreeMap::new(), Duration::ZERO, BTreeMap::new());
    for record in log {
        match record.fact {
            RecordKind::Started { firing, part: Some(part), .. } => {
                let waited = since.remove(&part).map_or(Duration::ZERO, |since| record.at.since(since));
                longest = longest.max(waited);
                ends.insert(firing, part);
            }
            RecordKind::Ended { firing } => {
                since.extend(ends.remove(&firing).map(|part| (part, record.at)));
            }
            _ => (),
        }
    }
    longest
}

#[test]
fn a_planner_that_never_answers_leaves_all_to_the_rules() {
    for (text, orders) in [(C1, [("A", 4, None), ("B", 4, Some(300))]), (ASSEMBLY, [("1", 4, None), ("2", 4, None)])] {
        let made = Made::new(text);
        let mut usual = sim(&made, &orders, CellSimOptions::default());
        let mut rules = by_rules(&made, &usual);
        usual.run(&mut rules, LONG);
        let mut alone = sim(&made, &orders, CellSimOptions::default());
        let mut planner = beside(&made, &alone, |_| None);
        planner.run(&mut alone, LONG);
        assert_eq!(alone.state().left(), 8);
        assert_eq!(starts(&alone.log), starts(&usual.log));
        let first = planner.asked[0].0;
        assert_eq!(planner.asked, [(first, RevisionReason::First)], "one request at a time");
        assert!(planner.follower.schedule().is_none());
        assert!(!planner.follower.is_overdue(first) && planner.follower.is_overdue(first + WITHIN));
    }
}

#[test]
fn a_schedule_is_followed_as_soon_as_it_comes() {
    let made = Made::new(C1);
    let orders = [("A", 3, None), ("B", 3, None)];
    for delay in [0, 150, 20_000] {
        let mut sim = sim(&made, &orders, CellSimOptions::default());
        let mut planner = beside(&made, &sim, move |_| Some(MS(delay)));
        planner.run(&mut sim, LONG);
        assert_eq!(sim.state().left(), 6, "{delay}");
        let copied = planner.asked[0].0;
        let whys: Vec<_> = planner.follower.revisions().map(|revision| (revision.at, revision.why)).collect();
        assert_eq!(whys[0], (copied + MS(delay), RevisionReason::First), "{delay}");
        // What was recorded since the copy is noted: the chart has everything that began after it, once.
        let since = |at: &Tick| *at > copied;
        let mut real: Vec<_> = starts(&sim.log).into_iter().filter(|(at, ..)| since(at)).collect();
        let bars: Vec<_> = planner.follower.bars().collect();
        let began = bars.iter().filter_map(|bar| Some((bar.actual?.0, bar.mode.0, bar.part)));
        let mut shown: Vec<_> = began.filter(|(at, ..)| since(at)).collect();
        real.sort_unstable();
        shown.sort_unstable();
        assert_eq!(real, shown, "{delay}");
        assert!(bars.iter().all(|bar| bar.actual.is_none_or(|(_, ended)| ended.is_some())), "{delay}: all has ended");
        if delay < 1000 {
            // Nothing has happened meanwhile, so everything starts as planned.
            assert_eq!(whys.len(), 1, "{delay}: {whys:?}");
            let as_planned = |bar: &&linewright_coordinator_cell::schedule::PlanActualBar| {
                bar.actual
                    .is_none_or(|(began, _)| began <= copied || bar.planned.is_some_and(|(from, _)| from == began))
            };
            assert!(bars.iter().all(|bar| as_planned(&bar)), "{delay}: {bars:?}");
            assert!(holds(&sim.log).any(|(_, why)| is_by_plan(why)), "{delay}: it waits for a window");
        }
    }
}

/// A schedule that holds everything for a day does not hold any more when an order comes, and no other one does: 2 s later the
/// rules alone decide, though nothing else happens then.
#[test]
fn an_old_schedule_holds_nothing_for_long() {
    let made = Made::new(C1);
    let mut sim = sim(&made, &[("A", 3, None)], CellSimOptions::default());
    let mut follower = follower_beside(&made.cell, &made.made, sim.state());
    follower.look.desk.rules.fairness.patience = Some(Duration::from_secs(100_000));
    let takes = |number| (number == 1).then_some(MS(150));
    let mut planner = SimulatedPlanner::new(follower, Box::new(Procrastinator), takes);
    let ordered = Tick::from_millis(60_000);
    planner.run(&mut sim, ordered);
    sim.now = ordered;
    let before = starts(&sim.log).len();
    assert!(sim.state().held().iter().any(|&(_, why)| is_by_plan(why)), "it is followed: {:?}", sim.state().held());
    let released = Tick::from_millis(36_000_000);
    let later = [ProductionOrderRequest { release: Some(released), ..request(9, &("B", 1, None)) }];
    sim.say(&mut planner.follower, &[PlayerInput::Production(1, ProductionCommand::Submit(&later))]);
    planner.ask(&sim);
    planner.run(&mut sim, LONG);
    assert_eq!(planner.asked[1..], [(ordered, RevisionReason::Orders)], "one request at a time");
    assert_eq!(starts(&sim.log)[before].0, ordered + WITHIN, "what was held is posed again");
    assert!(holds(&sim.log).all(|(at, why)| at < ordered + WITHIN || !is_by_plan(why)));
    assert_eq!(sim.state().left(), 4);
}

#[test]
fn what_has_changed_meanwhile_makes_another_request_and_no_second_one_is_under_way() {
    let made = Made::new(C1);
    let mut sim = sim(&made, &[("A", 4, None)], CellSimOptions::default());
    let mut planner = beside(&made, &sim, |_| Some(MS(2000)));
    planner.run(&mut sim, Tick::from_millis(500));
    let copied = planner.asked[0].0;
    let more = [request(9, &("B", 1, None))];
    sim.say(&mut planner.follower, &[PlayerInput::Production(1, ProductionCommand::Submit(&more))]);
    planner.run(&mut sim, Tick::from_millis(1500));
    assert_eq!(planner.asked.len(), 1);
    planner.run(&mut sim, LONG);
    assert_eq!(planner.asked[1], (copied + MS(2000), RevisionReason::Orders));
    assert_eq!(sim.state().left(), 5);
}

/// A machine goes out of service: from this moment on nothing is held by the schedule that counts on it, nor by one that was
/// being made; the next is followed.
#[test]
fn a_schedule_that_counts_on_what_has_failed_is_not_followed() {
    let made = Made::new(C1);
    let orders = [("A", 3, None), ("B", 3, None)];
    let handling = made.table.handling();
    let m1 = handling.resource_ids().find(|&id| handling.resource_name(id) == "M1").expect("it has one");
    let is_held = |sim: &CellSim| sim.state().held().iter().any(|&(_, why)| is_by_plan(why));
    let mut sim = sim(&made, &orders, CellSimOptions::default());
    let mut planner = beside(&made, &sim, |_| Some(MS(1000)));
    while !is_held(&sim) {
        let next = sim.now + MS(100);
        planner.run(&mut sim, next);
        sim.now = sim.now.max(next);
    }
    let requests = planner.asked.len();
    sim.say(&mut planner.follower, &[PlayerInput::Resource { resource: m1, up: false }]);
    assert!(!is_held(&sim), "the rules decide: {:?}", sim.state().held());
    let down = sim.now;
    planner.run(&mut sim, down + MS(500));
    assert_eq!(planner.asked[requests..], [(down, RevisionReason::Down(m1))]);
    // What is being made counts on M1 as it is now: when it fails as well, it comes and is not followed either.
    let m2 = handling.resource_ids().find(|&id| handling.resource_name(id) == "M2").expect("it has one");
    sim.say(&mut planner.follower, &[PlayerInput::Resource { resource: m2, up: false }]);
    planner.run(&mut sim, down + MS(1500));
    assert_eq!(planner.asked[requests + 1..], [(down + MS(1000), RevisionReason::Down(m2))]);
    assert!(!is_held(&sim), "{:?}", sim.state().held());
    for up in [m1, m2] {
        sim.say(&mut planner.follower, &[PlayerInput::Resource { resource: up, up: true }]);
    }
    planner.run(&mut sim, LONG);
    assert_eq!(sim.state().left(), 6);
}

#[test]
fn the_schedule_of_another_request_is_dropped() {
    let made = Made::new(C1);
    let mut sim = sim(&made, &[("A", 2, None)], CellSimOptions::default());
    let mut follower = follower_beside(&made.cell, &made.made, sim.state());
    sim.run_on(&mut follower, Tick::from_millis(10));
    let plan = |request: &PlanningRequest| request.plan(&mut RolloutScheduler::default());
    let first = follower.take_request(sim.now, sim.state()).expect("there is no schedule");
    assert!(follower.take_request(sim.now, sim.state()).is_none(), "one at a time");
    assert!(!follower.take_schedule(sim.now, first.number() + 1, plan(&first)) && follower.schedule().is_none());
    follower.planner_lost();
    assert!(!follower.take_schedule(sim.now, first.number(), plan(&first)), "nothing is waited for");
    let second = follower.take_request(sim.now, sim.state()).expect("it is asked again");
    assert_eq!((second.number(), second.reason()), (first.number() + 1, RevisionReason::First));
    assert!(!follower.take_schedule(sim.now, first.number(), plan(&first)), "it is of the first request");
    assert!(follower.take_schedule(sim.now, second.number(), plan(&second)));
    assert!(!follower.take_schedule(sim.now, second.number(), plan(&second)), "it was taken");
    assert_eq!(follower.revisions().len(), 1);
}

/// Where no rule is `schedule`, the time looked ahead is planned, again when half of it has passed.
#[test]
fn looking_ahead_is_planned_beside_as_well() {
    let made = Made::new(&C1.replace("\"schedule\", ", ""));
    assert!(!made.cell.dispatch.rules.contains(&DispatchRule::Schedule) && !made.cell.dispatch.look_ahead.is_zero());
    let mut sim = sim(&made, &[("A", 5, None), ("B", 5, None)], CellSimOptions::default());
    let mut planner = beside(&made, &sim, |_| Some(MS(150)));
    planner.run(&mut sim, Tick::from_millis(30_000));
    let schedule = planner.follower.schedule().expect("it has come");
    let last = schedule.slots().iter().map(|slot| slot.from).max().expect("it plans something");
    assert!(last <= schedule.made + made.cell.dispatch.look_ahead, "{last}");
    planner.run(&mut sim, LONG);
    assert_eq!(sim.state().left(), 10);
    let whys: Vec<_> = planner.asked.iter().map(|&(_, why)| why).collect();
    assert!(whys.iter().filter(|why| **why == RevisionReason::Ahead).count() > 3, "{whys:?}");
    let between: Vec<_> = planner.asked.windows(2).map(|pair| pair[1].0.since(pair[0].0)).collect();
    assert!(between.iter().all(|&between| between >= MS(500)), "{between:?}");
}

#[test]
fn the_same_seed_has_the_same_trace() {
    let made = Made::new(ASSEMBLY);
    let play = || {
        let options = CellSimOptions {
            seed: 3,
            pace: StationSpeed::Nominal { spread: 0.3 },
            delay: (MS(1), MS(20)),
            bad_luck: 20,
            period: MS(200),
            ..CellSimOptions::default()
        };
        let mut sim = sim(&made, &[("1", 4, Some(60)), ("2", 4, None), ("3", 2, None)], options);
        let mut random = Random::new(3);
        let mut planner = beside(&made, &sim, move |_| Some(MS(random.below(3000) as u64)));
        planner.run(&mut sim, LONG);
        assert_eq!(sim.state().left(), 10);
        (sim.log, planner.asked)
    };
    assert_eq!(play(), play());
}

/// Scheduler whose plans begin a day late. How long planning takes is up to the simulated planner.
struct Procrastinator;

impl Scheduler for Procrastinator {
    fn plan(&mut self, situation: &linewright_coordinator_cell::schedule::PlanningSituation<'_>) -> Schedule {
        let now = situation.now + Duration::from_secs(86_400);
        let effort = RolloutScheduler { effort: 2000, ..RolloutScheduler::default() };
        { effort }.plan(&linewright_coordinator_cell::schedule::PlanningSituation { now, ..*situation })
    }
}

/// Whatever a planner does: late answers, none, bad ones; whatever happens meanwhile. All is made, and no part waits for longer
/// than it would by the rules with that patience.
#[test]
fn with_a_planner_of_any_delay_all_is_made_and_no_part_waits_for_ever() {
    let patience = Duration::from_secs(60);
    let (mut random, mut followed, mut failed) = (Random::new(7), 0, 0);
    for round in 0..24 {
        let look_alone = C1.replace("\"schedule\", ", "");
        let (text, products): (&str, [&str; 2]) =
            [(C1, ["A", "B"]), (ASSEMBLY, ["1", "2"]), (&look_alone, ["A", "B"])][round % 3];
        let made = Made::new(text);
        let mut count = || 1 + random.below(3) as u32;
        let orders = [(products[0], count(), None), (products[1], count(), Some(200))];
        let options = CellSimOptions {
            seed: round as u64,
            pace: StationSpeed::Nominal { spread: 0.5 },
            delay: (MS(1), MS(20)),
            bad_luck: if random.one_in(2) { 30 } else { 0 },
            period: MS(200),
            ..CellSimOptions::default()
        };
        let mut sim = sim(&made, &orders, options);
        let (longest, silent) = (*random.pick(&[1, 500, 5000, 100_000]), *random.pick(&[0, 10, 60]));
        let mut dice = Random::new(round as u64);
        let takes = move |_| (!dice.chance(silent)).then(|| MS(dice.below(longest) as u64));
        let scheduler: Box<dyn Scheduler + Send> =
            if random.one_in(4) { Box::new(Procrastinator) } else { Box::new(RolloutScheduler::default()) };
        let mut follower = follower_beside(&made.cell, &made.made, sim.state());
        follower.look.desk.rules.fairness.patience = Some(patience);
        let mut planner = SimulatedPlanner::new(follower, scheduler, takes);
        let mut operator = SimulatedOperator::default();
        let fails = random.one_in(2).then(|| random.below(sim.stations.len()));
        for minute in 1..=300 {
            planner.run(&mut sim, Tick::from_millis(minute * 60_000));
            operator.look(&mut sim, &mut planner.follower);
            if let Some(station) = fails.filter(|_| minute == 2) {
                sim.stations[station].fails_with = Some(7);
            }
        }
        let wanted: u32 = orders.iter().map(|order| order.1).sum();
        let open: Vec<_> = sim.state().firings().map(|firing| (firing.mode, firing.phase)).collect();
        assert_eq!(sim.state().left(), u64::from(wanted), "{round}: all is made; {open:?}, {:?}", sim.state().held());
        failed += operator.answers;
        followed += usize::from(planner.follower.schedule().is_some());
        if operator.answers == 0 {
            let waited = longest_wait(&sim.log);
            assert!(waited < patience + Duration::from_secs(300), "{round}: {waited:?}");
        }
    }
    assert!(followed > 10 && failed > 0, "{followed} {failed}: it tests little");
}

#[test]
fn planning_beside_costs_little_of_what_planning_gains() {
    let made = Made::new(C1);
    let orders = [("A", 6, None), ("B", 6, None)];
    let mut at_once = sim(&made, &orders, CellSimOptions::default());
    let mut follower = schedule_follower(&made.cell, &made.made, at_once.state());
    at_once.run(&mut follower, LONG);
    let mut later = sim(&made, &orders, CellSimOptions::default());
    let mut planner = beside(&made, &later, |_| Some(MS(150)));
    planner.run(&mut later, LONG);
    let mut usual = sim(&made, &orders, CellSimOptions::default());
    let mut rules = by_rules(&made, &usual);
    usual.run(&mut rules, LONG);
    let [at_once, later, usual] = [at_once, later, usual].map(|sim| end(&sim.log).as_secs_f64());
    println!("at once {at_once} s, beside {later} s, rules {usual} s");
    assert!(later <= at_once * 1.05 && later <= usual, "{at_once} {later} {usual}");
}
