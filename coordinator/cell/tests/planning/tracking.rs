//! Reports beside hand-made sums and a slow recount.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_cell::compile::{dispatcher, sheet};
use linewright_coordinator_cell::exception::{
    AlarmSubject, ExceptionStep, OutOfServiceReason, RecoveryDecision, SensorMismatch, Strategy, Whereabouts,
};
use linewright_coordinator_cell::production::{DispatchConfiguration, Production};
use linewright_coordinator_cell::tracking::{CellSummary, PartFlow, ResourceEntry, Spread, Tracking};
use linewright_coordinator_cell::{ActivityFailure, FiringId, ModeId, PartId, Record, RecordKind};
use linewright_line::Tick;

use super::shop::{ASSEMBLY, C1, Made, Shop, changed, request};

const LONG: Tick = Tick::from_millis(3_600_000);

fn played(made: &Made, orders: &[(&str, u32, Option<u64>)], spoil: impl Fn(&mut Shop)) -> Shop {
    let mut desk = DispatchConfiguration::new(dispatcher(&made.cell, &made.table), made.ordered(orders));
    let mut shop = Shop::new(&made.table);
    spoil(&mut shop);
    shop.run(&mut desk, LONG);
    shop
}

fn report(made: &Made, log: &[Record], now: Tick) -> CellSummary {
    let mut tracking = Tracking::new(sheet(&made.cell, &made.made));
    log.iter().for_each(|record| tracking.take(record));
    tracking.report(now)
}

fn seconds(time: f64) -> Duration {
    Duration::from_millis((time * 1000.0) as u64)
}

/// Seed 000, L2029-2035: a part of each type is loaded in 3, 2 and 2, worked on for 7.5, 5 and 4, unloaded in 3, 2 and 2.
#[test]
fn what_everybody_did_is_what_the_plan_adds_up_to() {
    let made = Made::new(ASSEMBLY);
    let shop = played(&made, &[("1", 1, None), ("2", 1, None), ("3", 1, None)], |_| ());
    let report = report(&made, &shop.log, shop.makespan());
    assert_eq!((report.left, report.inside, report.failures), (3, 0, 0));
    assert_eq!(report.observed, shop.makespan().since(Tick::ZERO));
    let of = |name: &str| report.resources.iter().find(|resource| resource.name == name).unwrap();
    assert_eq!(
        (of("robot_1").busy, of("robot_2").busy, of("human").busy),
        (seconds(14.0), seconds(13.5), seconds(17.0))
    );
    assert_eq!((of("robot_2").worked, of("robot_2").actual), (1, seconds(7.5)));
    assert_eq!((of("human").worked, of("human").nominal, of("human").performance()), (2, seconds(9.0), Some(1.0)));
    assert_eq!((of("robot_1").worked, of("robot_1").performance()), (0, None));
    assert_eq!(of("human").availability(report.observed), Some(1.0));
    assert_eq!(
        (report.worked.least, report.worked.median, report.worked.most),
        (seconds(4.0), seconds(5.0), seconds(7.5))
    );
    assert_eq!((report.moved.least, report.moved.most), (seconds(4.0), seconds(6.0)));
    let spent = report.worked.total + report.moved.total + report.waited.total;
    assert_eq!(spent, report.lead.total, "a part is always one of the three");
    let of = report.effectiveness().unwrap();
    assert_eq!((of.availability, of.performance, of.quality, of.product()), (1.0, 1.0, 1.0, 1.0));
    assert_eq!(CellSummary { lost: 1, ..report }.quality(), Some(0.75));
}

/// Each step of the plan was counted as a part.
#[test]
fn a_part_of_which_a_machine_does_two_steps_is_one_part() {
    let both = "{ resource = \"M1\", time_s = 40, program = 1 }, { resource = \"M2\", time_s = 55, program = 1 }";
    assert!(C1.contains(both));
    let made = Made::new(&C1.replacen(both, "{ resource = \"M3\", time_s = 40, program = 1 }", 1));
    let shop = played(&made, &[("A", 2, None)], |_| ());
    let report = report(&made, &shop.log, shop.makespan());
    let machine = report.resources.iter().find(|of| of.name == "M3").expect("it is one");
    assert_eq!((report.left, machine.worked, machine.actual), (2, 2, seconds(140.0)));
}

#[test]
fn work_that_takes_longer_than_it_should_is_performance_lost() {
    let made = Made::new(ASSEMBLY);
    let work = made.table.modes().find(|&mode| made.table.activity(mode).name.as_ref() == "robot_2.process").unwrap();
    let shop = played(&made, &[("1", 2, None)], |shop| _ = shop.really.insert(work, seconds(10.0)));
    let report = report(&made, &shop.log, shop.makespan());
    let robot = report.resources.iter().find(|resource| &*resource.name == "robot_2").unwrap();
    assert_eq!((robot.worked, robot.nominal, robot.actual), (2, seconds(15.0), seconds(20.0)));
    assert_eq!(robot.performance(), Some(0.75));
}

/// One that is fast makes up for no slow one, and none is more than all.
#[test]
fn work_that_takes_less_than_it_should_is_no_more_than_full_performance() {
    let made = Made::new(ASSEMBLY);
    let named = |name: &str| made.table.modes().find(|&mode| made.table.mode_name(mode) == name).unwrap();
    let (fast, slow) = (named("human.process<2.new>"), named("human.process<3.new>"));
    let orders = [("2", 1, None), ("3", 1, None)];
    let only_fast = played(&made, &orders, |shop| _ = shop.really.insert(fast, seconds(1.0)));
    let of = report(&made, &only_fast.log, only_fast.makespan()).effectiveness().unwrap();
    assert_eq!((of.performance, of.product()), (1.0, 1.0));
    let both = played(&made, &orders, |shop| shop.really.extend([(fast, seconds(1.0)), (slow, seconds(9.0))]));
    let report = report(&made, &both.log, both.makespan());
    let human = report.resources.iter().find(|resource| &*resource.name == "human").unwrap();
    assert_eq!((human.nominal, human.actual), (seconds(5.0), seconds(10.0)), "1 of 1, and 4 of 9");
}

/// Millisecond by millisecond, from lists of what began and ended when.
fn recounted(made: &Made, log: &[Record], now: Tick) -> BTreeMap<String, (u64, u64)> {
    let sheet = sheet(&made.cell, &made.made);
    let (mut modes, mut spans, mut downs) = (BTreeMap::<FiringId, ModeId>::new(), Vec::new(), Vec::new());
    let mut open: BTreeMap<FiringId, (u64, Option<u64>)> = BTreeMap::new();
    let milli = |tick: Tick| tick.as_micros() / 1000;
    for record in log {
        match &record.fact {
            RecordKind::Started { firing, mode, .. } => {
                modes.insert(*firing, *mode);
                open.insert(*firing, (milli(record.at), None));
            }
            RecordKind::Raised { firing, .. } => open.get_mut(firing).unwrap().1 = Some(milli(record.at)),
            RecordKind::Ended { firing } => {
                let (began, failed) = open.remove(firing).unwrap();
                spans.push((modes[firing], began, failed.unwrap_or(milli(record.at))));
                downs.extend(failed.map(|failed| (modes[firing], failed, milli(record.at))));
            }
            _ => {}
        }
    }
    for (firing, (began, failed)) in open {
        spans.push((modes[&firing], began, failed.unwrap_or(milli(now))));
        downs.extend(failed.map(|failed| (modes[&firing], failed, milli(now))));
    }
    let within = |list: &[(ModeId, u64, u64)], resource: usize, at: u64| {
        list.iter().any(|(mode, from, to)| {
            (*from..*to).contains(&at) && sheet.modes[mode.index()].resources.contains(&resource)
        })
    };
    let count = |(resource, of): (usize, &ResourceEntry)| {
        let down = (0..milli(now)).filter(|&at| within(&downs, resource, at)).count() as u64;
        let busy = (0..milli(now)).filter(|&at| within(&spans, resource, at) && !within(&downs, resource, at));
        (of.name.to_string(), (busy.count() as u64, down))
    };
    sheet.resources.iter().enumerate().map(count).collect()
}

#[test]
fn busy_and_down_are_what_a_slow_recount_says() {
    for text in [ASSEMBLY, C1] {
        let made = Made::new(text);
        let products: Vec<_> = made.cell.part_types.iter().map(|part| (part.name.as_str(), 2, None)).collect();
        for failing in [false, true] {
            let shop = played(&made, &products, |shop| {
                // The second activity of a worker fails and stays so; the others go on as far as they can.
                let works = made.table.modes().find(|&mode| made.table.activity(mode).name.ends_with(".process"));
                if failing {
                    shop.fails.insert(works.unwrap(), 1);
                }
            });
            let now = shop.now.max(shop.makespan());
            let now = now.min(shop.makespan() + seconds(30.0));
            let report = report(&made, &shop.log, now);
            let expected = recounted(&made, &shop.log, now);
            for resource in &report.resources {
                let said = (resource.busy.as_millis() as u64, resource.down.as_millis() as u64);
                assert_eq!(said, expected[&resource.name], "{}", resource.name);
                let causes: Duration = resource.causes.iter().map(|(.., down)| down).sum();
                assert!(causes >= resource.down, "each has its own cause");
            }
            assert_eq!(report.failures > 0, failing);
            assert_eq!(report.resources.iter().any(|resource| resource.down > Duration::ZERO), failing);
            assert!(!failing || report.to_string().contains("once awaited input not on in time (code 7)"), "{report}");
        }
    }
}

/// A failed loading keeps its robot and its machine down until it is answered. Other parts go into the store and out of it meanwhile.
#[test]
fn a_store_is_not_down_while_an_activity_from_it_has_failed() {
    let made = Made::new(C1);
    let products: Vec<_> = made.cell.part_types.iter().map(|part| (part.name.as_str(), 2, None)).collect();
    let load = made.table.modes().find(|&mode| made.table.activity(mode).name.starts_with("load M1")).unwrap();
    let shop = played(&made, &products, |shop| _ = shop.fails.insert(load, 1));
    let report = report(&made, &shop.log, shop.now.max(shop.makespan()) + seconds(30.0));
    let of = |name: &str| report.resources.iter().find(|resource| resource.name == name).unwrap();
    assert!(report.failures > 0 && of("M1").down > Duration::ZERO && of("R").down > Duration::ZERO, "{report}");
    assert_eq!((of("ST").down, of("ST").causes.iter().count()), (Duration::ZERO, 0), "{report}");
}

/// A resource that is left out once is down once, whatever else happens meanwhile.
#[test]
fn a_resource_is_left_out_as_often_as_somebody_leaves_it_out() {
    let made = Made::new(C1);
    let products: Vec<_> = made.cell.part_types.iter().map(|part| (part.name.as_str(), 2, None)).collect();
    let mut log = played(&made, &products, |_| ()).log;
    let m1 = made.table.handling().resource_named("M1").unwrap();
    let why = OutOfServiceReason::ByHand { text: String::new() };
    let steps = [
        ExceptionStep::Down { resource: m1, why: why.clone(), activity: String::new() },
        ExceptionStep::Up { resource: m1, unchecked: true },
        ExceptionStep::Down { resource: m1, why, activity: String::new() },
    ];
    let thirds = [log.len() / 4, log.len() / 2, log.len() * 3 / 4].map(|at| log[at].at);
    for (at, step) in thirds.into_iter().zip(steps) {
        let place = log.iter().position(|record| record.at > at).unwrap();
        log.insert(place, Record { at, fact: RecordKind::Exception(step) });
    }
    let now = log.last().unwrap().at;
    let report = report(&made, &log, now);
    let m1 = report.resources.iter().find(|resource| &*resource.name == "M1").unwrap();
    let down = thirds[1].since(thirds[0]) + now.since(thirds[2]);
    assert!(down > Duration::ZERO);
    assert_eq!((m1.down, m1.causes.iter().collect::<Vec<_>>()), (down, vec![("taken out by hand", 2, down)]));
}

/// Also where it falls on its way in: it has begun to count when it entered. One that is still outside has not.
#[test]
fn a_part_that_an_answer_gives_up_is_lost_wherever_it_was() {
    let made = Made::new(ASSEMBLY);
    let played = played(&made, &[("1", 1, None)], |_| ()).log;
    let sheet = sheet(&made.cell, &made.made);
    let enters = |record: &Record| match record.fact {
        RecordKind::Started { firing, mode, part, .. } if sheet.modes[mode.index()].passing == PartFlow::Enters => {
            Some((firing, mode, part))
        }
        _ => None,
    };
    let place = played.iter().position(|record| enters(record).is_some()).expect("a part is brought in");
    let (firing, mode, part) = enters(&played[place]).expect("that one");
    let at = played[place].at;
    for (whereabouts, lost) in [(Whereabouts::Gone, 1), (Whereabouts::From, 0)] {
        let ruling = RecoveryDecision { word: "scrap".to_owned(), part: whereabouts, then: Strategy::Backward };
        let mut log = played[..=place].to_vec();
        log.push(Record { at, fact: RecordKind::Raised { firing, cause: ActivityFailure::TimedOut } });
        let closed = ExceptionStep::Closed { firing, mode, part, ruling, unchecked: Vec::new() };
        log.push(Record { at, fact: RecordKind::Exception(closed) });
        let report = report(&made, &log, at);
        assert_eq!((report.lost, report.inside, report.left), (lost, 0, 0), "{whereabouts:?}");
        assert_eq!(report.quality(), (lost > 0).then_some(0.0));
    }
}

/// The resource is left out and its activity has failed by the same alarm.
#[test]
fn an_alarm_given_by_hand_is_one_cause() {
    let made = Made::new(C1);
    let played = played(&made, &[("A", 1, None)], |_| ()).log;
    let load = |record: &Record| match record.fact {
        RecordKind::Started { firing, mode, .. } if made.table.called(mode) == "load M1" => Some(firing),
        _ => None,
    };
    let place = played.iter().position(|record| load(record).is_some()).expect("a part is loaded");
    let (firing, at) = (load(&played[place]).expect("that one"), played[place].at);
    let resource = made.table.handling().resource_named("M1").expect("it is there");
    let mut log = played[..=place].to_vec();
    for (text, cause) in [("smoke", "smoke"), ("", "alarm raised by hand")] {
        log.truncate(place + 1);
        let why = OutOfServiceReason::Alarm { text: text.to_owned() };
        let down = ExceptionStep::Down { resource, why, activity: String::new() };
        log.push(Record { at, fact: RecordKind::Exception(down) });
        log.push(Record { at, fact: RecordKind::Raised { firing, cause: ActivityFailure::ByHand { resource } } });
        let (after, four) = (at + Duration::from_secs(4), Duration::from_secs(4));
        for name in ["M1", "R"] {
            let found = report(&made, &log, after);
            let of = found.resources.iter().find(|of| of.name == name).expect("it is there");
            assert_eq!(of.causes.iter().collect::<Vec<_>>(), [(cause, 1, four)], "{name}");
        }
    }
}

/// As long as the sensor of a resource sees no part where the cell has one.
#[test]
fn a_part_that_is_missing_by_a_sensor_counts_as_lost_until_it_is_put_back() {
    let made = Made::new(C1);
    let products: Vec<_> = made.cell.part_types.iter().map(|part| (part.name.as_str(), 2, None)).collect();
    let mut log = played(&made, &products, |_| ()).log;
    log.truncate(log.len() / 2);
    let at = log[log.len() - 1].at;
    let before = report(&made, &log, at);
    assert!(before.inside > 0 && before.lost == 0);
    let resource = made.table.handling().resource_named("M1").unwrap();
    let mut then = |step: ExceptionStep| {
        log.push(Record { at, fact: RecordKind::Exception(step) });
        let now = report(&made, &log, at);
        (now.lost, now.inside)
    };
    let is_seen = |model| ExceptionStep::Mismatch {
        about: AlarmSubject::Resource(resource),
        found: vec![SensorMismatch { resource, model, plant: !model }],
    };
    let down = OutOfServiceReason::Mismatch;
    assert_eq!(then(is_seen(true)), (1, before.inside - 1));
    assert_eq!(then(ExceptionStep::Down { resource, why: down, activity: String::new() }), (1, before.inside - 1));
    assert_eq!(then(is_seen(true)), (1, before.inside - 1), "once, however often it is compared");
    assert_eq!(then(ExceptionStep::Up { resource, unchecked: false }), (0, before.inside));
    assert_eq!(then(is_seen(false)), (0, before.inside), "one too many is none lost");
}

/// A part that is inside counts to nothing yet.
#[test]
fn a_report_in_between_counts_what_has_left() {
    let made = Made::new(C1);
    let products: Vec<_> = made.cell.part_types.iter().map(|part| (part.name.as_str(), 2, None)).collect();
    let shop = played(&made, &products, |_| ());
    let mut seen = (0, 0);
    for count in 0..shop.log.len() {
        let now = shop.log[count].at;
        let report = report(&made, &shop.log[..=count], now);
        let named = |mode: &ModeId| made.table.activity(*mode).name.to_string();
        let parts = |word: &str, ended: bool| {
            let mut of = BTreeMap::<FiringId, PartId>::new();
            let mut number = 0;
            for record in &shop.log[..=count] {
                match &record.fact {
                    RecordKind::Started { firing, mode, part: Some(part), .. } if named(mode) == word => {
                        of.insert(*firing, *part);
                        number += usize::from(!ended);
                    }
                    RecordKind::Ended { firing } if of.contains_key(firing) => number += usize::from(ended),
                    _ => {}
                }
            }
            number
        };
        let (entered, left) = (parts("enter", false), parts("leave", true));
        assert_eq!((report.left, report.inside), (left, entered - left), "after {:?}", shop.log[count]);
        assert_eq!(report.waited.count, left);
        seen = (entered, left);
    }
    assert_eq!(seen, (4, 4));
}

/// Whatever spans a time is cut into, what is counted in them adds up to what is counted in all of it.
#[test]
fn what_is_counted_in_spans_adds_up() {
    for (text, failing) in [(ASSEMBLY, false), (C1, false), (C1, true)] {
        let made = Made::new(text);
        let products: Vec<_> = made.cell.part_types.iter().map(|part| (part.name.as_str(), 3, None)).collect();
        let shop = played(&made, &products, |shop| {
            let works = made.table.modes().find(|&mode| made.table.activity(mode).name.ends_with(".process"));
            if failing {
                shop.fails.insert(works.unwrap(), 1);
            }
        });
        let end = shop.makespan() + seconds(17.0);
        let whole = report(&made, &shop.log, end);
        for length in [7.3, 31.0, 1000.0] {
            let mut spans = Vec::new();
            let mut from = Tick::ZERO;
            while from < end {
                let to = (from + seconds(length)).min(end);
                let mut tracking = Tracking::since(sheet(&made.cell, &made.made), from);
                // What happens at the moment between two belongs to the later one.
                let told = shop.log.iter().filter(|record| record.at < to || to == end);
                told.for_each(|record| tracking.take(record));
                spans.push(tracking.report(to));
                from = to;
            }
            assert_eq!(spans.iter().map(|span| span.observed).sum::<Duration>(), whole.observed);
            assert_eq!(spans.iter().map(|span| span.left).sum::<usize>(), whole.left);
            assert_eq!(spans.iter().map(|span| span.failures).sum::<u64>(), whole.failures);
            assert_eq!(spans.last().unwrap().inside, whole.inside);
            for (index, expected) in whole.resources.iter().enumerate() {
                let of = || spans.iter().map(move |span| &span.resources[index]);
                let sum = |what: fn(&linewright_coordinator_cell::tracking::ResourceReport) -> Duration| {
                    of().map(what).sum::<Duration>()
                };
                assert_eq!(sum(|of| of.busy), expected.busy, "{} in spans of {length} s", expected.name);
                assert_eq!(sum(|of| of.work), expected.work);
                assert_eq!(sum(|of| of.down), expected.down);
                assert_eq!((sum(|of| of.nominal), sum(|of| of.actual)), (expected.nominal, expected.actual));
                let causes = |of: &linewright_coordinator_cell::tracking::ResourceReport| {
                    of.causes.iter().map(|(.., down)| down).sum::<Duration>()
                };
                assert_eq!(sum(causes), causes(expected));
                assert_eq!(of().map(|of| of.most).max().unwrap(), expected.most);
                let taken: f64 =
                    spans.iter().map(|span| span.resources[index].taken * span.observed.as_secs_f64()).sum();
                assert!((taken - expected.taken * whole.observed.as_secs_f64()).abs() < 1e-6);
            }
        }
    }
}

/// With one order of each product, an order is over when the last part of its product has left.
#[test]
fn lateness_is_that_of_the_last_part() {
    for (due, expected_late) in [(20, 3), (1000, 0)] {
        let made = Made::new(ASSEMBLY);
        let orders = [("1", 2, Some(due)), ("2", 2, Some(due)), ("3", 2, Some(due))];
        let mut shop = played(&made, &orders, |_| ());
        let requests: Vec<_> = (1..).zip(&orders).map(|(key, of)| request(key, of)).collect();
        let accepted = Production::new(&made.table).submit(&requests).unwrap().into_iter();
        shop.log.splice(1..1, accepted.map(|change| changed(Tick::ZERO, change)));
        let mut last = BTreeMap::<usize, Tick>::new();
        let mut leaving = BTreeMap::new();
        let entries = sheet(&made.cell, &made.made).modes;
        for record in &shop.log {
            match &record.fact {
                RecordKind::Started { firing, mode, .. } if &*entries[mode.index()].activity == "depart" => {
                    leaving.insert(*firing, entries[mode.index()].product.unwrap());
                }
                RecordKind::Ended { firing } => {
                    leaving.get(firing).and_then(|&product| last.insert(product, record.at));
                }
                _ => {}
            }
        }
        let mut tracking = Tracking::new(sheet(&made.cell, &made.made));
        shop.log.iter().for_each(|record| tracking.take(record));
        let due = Tick::from_millis(due * 1000);
        let said = tracking.production().orders().map(|order| (order.product, order.ended, order.lateness()));
        let signed = |tick: Tick| i64::try_from(tick.as_micros()).unwrap();
        let expected = last.iter().map(|(&product, &at)| (product, Some(at), Some(signed(at) - signed(due))));
        assert_eq!(said.collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        let report = tracking.report(shop.makespan());
        let late: Vec<Duration> = last.values().map(|at| at.since(due)).filter(|late| !late.is_zero()).collect();
        assert_eq!((report.orders.done, report.orders.open, report.orders.due), (3, 0, 3));
        assert_eq!((report.orders.in_time, report.orders.late.count), (3 - expected_late, expected_late));
        assert_eq!(report.orders.late.most, late.iter().max().copied().unwrap_or_default());
        assert!(report.to_string().contains("orders: 3 done, 0 open;"), "{report}");
    }
}

/// The usual example of the nearest-rank method: of 15, 20, 35, 40, 50 the 5th, 30th, 40th, 50th and 100th percentile
/// are 15, 20, 20, 35 and 50.
#[test]
fn percentiles_are_the_nearest_rank() {
    let seconds = |all: &[u64]| all.iter().map(|&s| Duration::from_secs(s)).collect::<Vec<_>>();
    let spread = Spread::of(seconds(&[40, 15, 50, 20, 35]));
    assert_eq!((spread.least, spread.median, spread.most), (seconds(&[15])[0], seconds(&[35])[0], seconds(&[50])[0]));
    assert_eq!((spread.p90, spread.p99, spread.total), (seconds(&[50])[0], seconds(&[50])[0], seconds(&[160])[0]));
    let hundred: Vec<u64> = (1..=100).rev().collect();
    let spread = Spread::of(seconds(&hundred));
    let [median, p90, p99] = [spread.median, spread.p90, spread.p99].map(|time| time.as_secs());
    assert_eq!((median, p90, p99, spread.count), (50, 90, 99, 100));
    assert_eq!(Spread::of(Vec::new()), Spread::default());
    let one = Spread::of(seconds(&[7]));
    assert_eq!((one.least, one.median, one.p99), (one.most, one.most, one.most));
}
