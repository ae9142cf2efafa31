//! Reality deviates: something is late, a machine is down, orders come and go; and the plan is compared with what was.

use std::time::Duration;

use linewright_coordinator_cell::compile::schedule_follower;
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_coordinator_cell::schedule::{RevisionReason, ScheduleFollower};
use linewright_coordinator_cell::{
    ActivityPhase, DispatchDecision, Dispatcher, PartId, PlayerInput, PlayerOutbox, ProductionCommand, Question,
    Record, RecordKind, TaskReport,
};
use linewright_line::{StationId, Tick};

use super::shop::{C1, Made, Shop, request};

const LONG: Tick = Tick::from_millis(86_400_000);

fn follower(made: &Made, orders: &[(&str, u32, Option<u64>)]) -> ScheduleFollower {
    let mut follower = schedule_follower(&made.cell, &made.made, &made.with(orders));
    follower.look.desk.rules.fairness.patience = Some(Duration::from_secs(100_000));
    follower
}

fn whys(follower: &ScheduleFollower) -> Vec<RevisionReason> {
    follower.revisions().map(|revision| revision.why).collect()
}

/// M1 breaks down with a part in it. Parts that were planned on it are planned on M2, and all but that one are finished.
#[test]
fn when_a_machine_is_down_its_work_is_planned_elsewhere() {
    let made = Made::new(C1);
    let process = made.mode("M1.process<A.new>");
    let mut follower = follower(&made, &[("A", 6, None)]);
    let mut shop = Shop::new(&made.table);
    shop.fails.insert(process, 1);
    shop.run(&mut follower, Tick::from_millis(13_000));
    let on = |follower: &ScheduleFollower, name: &str| {
        let load = made.mode(name);
        follower.schedule().unwrap().slots().iter().filter(|slot| slot.mode == load && slot.began.is_none()).count()
    };
    assert!(on(&follower, "load M1<A.new>") >= 2, "M1 is the faster one");
    shop.run(&mut follower, LONG);
    let failed = shop.state().firings().filter(|firing| matches!(firing.phase, ActivityPhase::Failed(_)));
    let failed: Vec<_> = failed.map(|firing| (firing.id, firing.mode)).collect();
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0].1, process);
    assert!(whys(&follower).contains(&RevisionReason::Failed(failed[0].0)), "{:?}", whys(&follower));
    assert_eq!((shop.state().left(), shop.state().parts().len()), (5, 1));
    assert_eq!(on(&follower, "load M1<A.new>"), 0);
    // After the revision no part was sent to M1.
    let down = shop.log.iter().find(|record| matches!(record.fact, RecordKind::Raised { .. })).unwrap().at;
    let late: Vec<_> = shop.starts().into_iter().filter(|&(at, ..)| at > down.as_micros() / 1000).collect();
    assert!(
        late.iter().all(|(_, name, _)| !name.contains(" M1"))
            && late.iter().any(|(_, name, _)| *name == "load M2<A.new>")
    );
    // The chart shows it: one bar has failed, and those behind it are elsewhere than promised.
    let bars: Vec<_> = follower.bars().filter(|bar| bar.failed).collect();
    assert!(bars.iter().any(|bar| bar.mode == process && bar.actual.is_some()), "{bars:?}");
}

/// The work on M1 takes nearly twice as long as it should: that is noticed when window and tolerance are over, not when it
/// ends: a part that waits for M1 could go to M2 instead, if that had become better.
#[test]
fn when_something_is_late_what_follows_is_planned_anew() {
    let made = Made::new(&C1.replace("time_s = 55", "time_s = 110"));
    let slow = made.mode("M1.process<A.new>");
    // No limit of an order runs out: late is not failed.
    let on_m2 = |slowness: u64| -> (Option<Duration>, usize, Vec<String>) {
        let mut follower = follower(&made, &[("A", 2, None)]);
        follower.tolerance = Duration::from_secs(4);
        let mut shop = Shop::new(&made.table);
        shop.really.insert(slow, Duration::from_secs(slowness));
        shop.run(&mut follower, LONG);
        assert_eq!(shop.state().left(), 2);
        let late = |why: &RevisionReason| matches!(why, RevisionReason::Late { .. });
        let late = follower.revisions().find(|revision| late(&revision.why)).map(|revision| revision.at);
        let begun = shop.starts().into_iter().find(|&(_, name, _)| name == "M1.process<A.new>").unwrap().0;
        let on_m2 = shop.starts().into_iter().filter(|(_, name, _)| *name == "load M2<A.new>").count();
        let said = whys(&follower).iter().map(|why| why.text(&made.table)).collect();
        (late.map(|at| at.since(Tick::from_millis(begun))), on_m2, said)
    };
    let (late, as_planned, said) = on_m2(40);
    assert_eq!((late, &said[..]), (None, &["no schedule yet".to_owned()][..]));
    let (late, instead, said) = on_m2(79);
    assert!(said[1].contains("later than tolerated, by less than 0.1 s"), "{said:?}");
    assert!((44..79).contains(&late.unwrap().as_secs()), "{late:?}");
    // It is late again and again, and is assumed to take as long again as it is late; M2 never becomes better by that.
    assert!((3..8).contains(&said.len()) && (as_planned, instead) == (0, 0), "{said:?}");
}

/// An order that comes is planned in, one that goes is planned out; what does not have to move keeps its promise.
#[test]
fn orders_that_come_and_go_change_the_schedule() {
    let made = Made::new(C1);
    let mut follower = follower(&made, &[("A", 2, None)]);
    let mut shop = Shop::begin(made.with(&[("A", 2, None)]));
    shop.run(&mut follower, Tick::from_millis(20_000));
    let before = follower.schedule().unwrap().clone();
    let urgent =
        ProductionOrderRequest { priority: 3, due: Some(Tick::from_millis(150_000)), ..request(9, &("B", 1, None)) };
    shop.command(ProductionCommand::Submit(&[urgent]), &mut follower).unwrap();
    shop.run(&mut follower, Tick::from_millis(21_000));
    assert_eq!(whys(&follower), [RevisionReason::First, RevisionReason::Orders]);
    let after = follower.schedule().unwrap();
    let is_new = |name: &str| after.slots().iter().any(|slot| made.table.mode_name(slot.mode) == name);
    assert!(
        is_new("load M3<B.new>") && after.slots().len() > before.slots().iter().filter(|s| s.ended.is_none()).count()
    );
    // What was in progress keeps what was promised for it.
    let running = after.slots().iter().find(|slot| slot.began.is_some_and(|began| began < after.made)).unwrap();
    let promised = before.slots().iter().find(|slot| slot.mode == running.mode && slot.began == running.began).unwrap();
    assert_eq!(running.promised, promised.promised);
    assert!(running.promised.is_some());
    shop.command(ProductionCommand::Cancel("order 9"), &mut follower).unwrap();
    shop.run(&mut follower, LONG);
    assert_eq!(follower.look.desk.production(), Some(shop.state().production()), "both were told the same");
    assert_eq!(whys(&follower)[2], RevisionReason::Orders);
    assert!(shop.state().left() <= 3 && shop.state().parts().len() == 0);
}

/// The chart has every activity that really was, once, with what was planned for it.
#[test]
fn plan_and_actual_are_compared() {
    let made = Made::new(C1);
    let mut follower = follower(&made, &[("A", 3, None), ("B", 3, None)]);
    let mut shop = Shop::new(&made.table);
    shop.really.insert(made.mode("load M3<B.new>"), Duration::from_secs(20));
    shop.run(&mut follower, LONG);
    let mut real: Vec<(Tick, String, Option<PartId>)> = Vec::new();
    for record in &shop.log {
        if let RecordKind::Started { mode, part, .. } = record.fact {
            real.push((record.at, made.table.mode_name(mode).to_owned(), part));
        }
    }
    let bars: Vec<_> = follower.bars().collect();
    let mut shown: Vec<_> =
        bars.iter().map(|bar| (bar.actual.unwrap().0, made.table.mode_name(bar.mode).to_owned(), bar.part)).collect();
    real.sort();
    shown.sort();
    assert_eq!(real, shown);
    assert!(bars.iter().all(|bar| bar.promised.is_some() && bar.actual.unwrap().1.is_some() && !bar.failed));
    let late = bars.iter().filter(|bar| bar.actual.unwrap().0 > bar.promised.unwrap().0).count();
    assert!(late > 0, "something was later than promised");
}

/// A dispatcher may take long, so it is asked when something is new, and at its own time; not at each repeated report
/// of a station.
#[test]
fn nobody_is_asked_twice_about_the_same() {
    struct Counting(ScheduleFollower, usize);
    impl Dispatcher for Counting {
        fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
            self.1 += 1;
            self.0.decide(question)
        }

        fn note(&mut self, record: &Record) {
            self.0.note(record);
        }
    }
    let made = Made::new(C1);
    let orders = [("A", 2, None), ("B", 2, None)];
    let mut counting = Counting(follower(&made, &orders), 0);
    let mut shop = Shop::begin(made.with(&orders));
    shop.run(&mut counting, Tick::from_millis(5_000));
    let (asked, sequence) = (counting.1, shop.state().sequence());
    let heard = TaskReport { memory: 1, epoch: 1, ..TaskReport::default() };
    for milli in 5_001..5_200 {
        let mut out = PlayerOutbox::default();
        let says = [PlayerInput::Starts(true), PlayerInput::Station(StationId(0), &heard)];
        shop.player.step(Tick::from_millis(milli), &says, &mut counting, &mut out);
    }
    assert_eq!((counting.1, shop.state().sequence()), (asked, sequence));
    shop.run(&mut counting, LONG);
    assert_eq!(shop.state().left(), 4);
}
