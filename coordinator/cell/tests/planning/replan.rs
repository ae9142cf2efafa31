//! Reality deviates: something is late, a machine is down, orders come and go; and what was planned is compared with what
//! was.

use std::time::Duration;

use linewright_coordinator_cell::described::foreman;
use linewright_coordinator_cell::production::Request;
use linewright_coordinator_cell::schedule::{Deviation, Foreman};
use linewright_coordinator_cell::{
    Answer, Dispatcher, Fact, Heard, Input, Outbox, PartId, Phase, ProductionCommand, Question, Record,
};
use linewright_line::{StationId, Tick};

use super::shop::{C1, Made, Shop, request};

const LONG: Tick = Tick::from_millis(86_400_000);

fn follower(made: &Made, orders: &[(&str, u32, Option<u64>)]) -> Foreman {
    let mut foreman = foreman(&made.cell, &made.made, &made.with(orders));
    foreman.look.desk.rules.fairness.patience = Some(Duration::from_secs(100_000));
    foreman
}

fn whys(foreman: &Foreman) -> Vec<Deviation> {
    foreman.revisions().map(|revision| revision.why).collect()
}

/// M1 breaks down with a part in it. Parts that were planned on it are planned on M2, and all but that one are finished.
#[test]
fn when_a_machine_is_down_its_work_is_planned_elsewhere() {
    let made = Made::new(C1);
    let process = made.mode("M1.process<A.new>");
    let mut foreman = follower(&made, &[("A", 6, None)]);
    let mut shop = Shop::new(&made.table);
    shop.fails.insert(process, 1);
    shop.run(&mut foreman, Tick::from_millis(13_000));
    let on = |foreman: &Foreman, name: &str| {
        let load = made.mode(name);
        foreman.schedule().unwrap().slots().iter().filter(|slot| slot.mode == load && slot.began.is_none()).count()
    };
    assert!(on(&foreman, "load M1<A.new>") >= 2, "M1 is the faster one");
    shop.run(&mut foreman, LONG);
    let failed = shop.state().firings().filter(|firing| matches!(firing.phase, Phase::Failed(_)));
    let failed: Vec<_> = failed.map(|firing| (firing.id, firing.mode)).collect();
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0].1, process);
    assert!(whys(&foreman).contains(&Deviation::Failed(failed[0].0)), "{:?}", whys(&foreman));
    assert_eq!((shop.state().left(), shop.state().parts().len()), (5, 1));
    assert_eq!(on(&foreman, "load M1<A.new>"), 0);
    // After the revision nobody was sent to M1.
    let down = shop.log.iter().find(|record| matches!(record.fact, Fact::Raised { .. })).unwrap().at;
    let late: Vec<_> = shop.starts().into_iter().filter(|&(at, ..)| at > down.as_micros() / 1000).collect();
    assert!(
        late.iter().all(|(_, name, _)| !name.contains(" M1"))
            && late.iter().any(|(_, name, _)| *name == "load M2<A.new>")
    );
    // The chart says so: one bar has failed, and those behind it are elsewhere than promised.
    let bars: Vec<_> = foreman.bars().filter(|bar| bar.failed).collect();
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
        let mut foreman = follower(&made, &[("A", 2, None)]);
        foreman.tolerance = Duration::from_secs(4);
        let mut shop = Shop::new(&made.table);
        shop.really.insert(slow, Duration::from_secs(slowness));
        shop.run(&mut foreman, LONG);
        assert_eq!(shop.state().left(), 2);
        let late = |why: &Deviation| matches!(why, Deviation::Late { .. });
        let late = foreman.revisions().find(|revision| late(&revision.why)).map(|revision| revision.at);
        let begun = shop.starts().into_iter().find(|&(_, name, _)| name == "M1.process<A.new>").unwrap().0;
        let on_m2 = shop.starts().into_iter().filter(|(_, name, _)| *name == "load M2<A.new>").count();
        let said = whys(&foreman).iter().map(|why| why.words(&made.table)).collect();
        (late.map(|at| at.since(Tick::from_millis(begun))), on_m2, said)
    };
    let (late, as_planned, said) = on_m2(40);
    assert_eq!((late, &said[..]), (None, &["nothing was planned yet".to_owned()][..]));
    let (late, instead, said) = on_m2(79);
    assert!(said[1].contains("is later than it may be, by 0.000001 s"), "{said:?}");
    assert!((44..79).contains(&late.unwrap().as_secs()), "{late:?}");
    // It is late again and again, and is believed to take as long again as it is late; M2 never becomes better by that.
    assert!((3..8).contains(&said.len()) && (as_planned, instead) == (0, 0), "{said:?}");
}

/// An order that comes is planned in, one that goes is planned out; what does not have to move keeps its promise.
#[test]
fn orders_that_come_and_go_change_the_schedule() {
    let made = Made::new(C1);
    let mut foreman = follower(&made, &[("A", 2, None)]);
    let mut shop = Shop::begin(made.with(&[("A", 2, None)]));
    shop.run(&mut foreman, Tick::from_millis(20_000));
    let before = foreman.schedule().unwrap().clone();
    let urgent = Request { priority: 3, due: Some(Tick::from_millis(150_000)), ..request(9, &("B", 1, None)) };
    shop.command(ProductionCommand::Submit(&[urgent]), &mut foreman).unwrap();
    shop.run(&mut foreman, Tick::from_millis(21_000));
    assert_eq!(whys(&foreman), [Deviation::First, Deviation::Orders]);
    let after = foreman.schedule().unwrap();
    let is_new = |name: &str| after.slots().iter().any(|slot| made.table.mode_name(slot.mode) == name);
    assert!(
        is_new("load M3<B.new>") && after.slots().len() > before.slots().iter().filter(|s| s.ended.is_none()).count()
    );
    // What was in progress keeps what was promised for it.
    let running = after.slots().iter().find(|slot| slot.began.is_some_and(|began| began < after.made)).unwrap();
    let promised = before.slots().iter().find(|slot| slot.mode == running.mode && slot.began == running.began).unwrap();
    assert_eq!(running.promised, promised.promised);
    assert!(running.promised.is_some());
    shop.command(ProductionCommand::Cancel("order 9"), &mut foreman).unwrap();
    shop.run(&mut foreman, LONG);
    assert_eq!(foreman.look.desk.production(), Some(shop.state().production()), "both were told the same");
    assert_eq!(whys(&foreman)[2], Deviation::Orders);
    assert!(shop.state().left() <= 3 && shop.state().parts().len() == 0);
}

/// The chart has every activity that really was, once, with what was planned for it.
#[test]
fn plan_and_actual_are_compared() {
    let made = Made::new(C1);
    let mut foreman = follower(&made, &[("A", 3, None), ("B", 3, None)]);
    let mut shop = Shop::new(&made.table);
    shop.really.insert(made.mode("load M3<B.new>"), Duration::from_secs(20));
    shop.run(&mut foreman, LONG);
    let mut real: Vec<(Tick, String, Option<PartId>)> = Vec::new();
    for record in &shop.log {
        if let Fact::Started { mode, part, .. } = record.fact {
            real.push((record.at, made.table.mode_name(mode).to_owned(), part));
        }
    }
    let bars: Vec<_> = foreman.bars().collect();
    let mut shown: Vec<_> =
        bars.iter().map(|bar| (bar.actual.unwrap().0, made.table.mode_name(bar.mode).to_owned(), bar.part)).collect();
    real.sort();
    shown.sort();
    assert_eq!(real, shown);
    assert!(bars.iter().all(|bar| bar.promised.is_some() && bar.actual.unwrap().1.is_some() && !bar.failed));
    let late = bars.iter().filter(|bar| bar.actual.unwrap().0 > bar.promised.unwrap().0).count();
    assert!(late > 0, "something was later than promised");
}

/// A dispatcher may think for long, so it is asked when something is new, and when it wants to be; not each time that a
/// station says once more what it has said.
#[test]
fn nobody_is_asked_twice_about_the_same() {
    struct Counting(Foreman, usize);
    impl Dispatcher for Counting {
        fn decide(&mut self, question: &Question<'_>) -> Answer {
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
    let heard = Heard { memory: 1, epoch: 1, ..Heard::default() };
    for milli in 5_001..5_200 {
        let mut out = Outbox::default();
        let says = [Input::Starts(true), Input::Station(StationId(0), &heard)];
        shop.player.step(Tick::from_millis(milli), &says, &mut counting, &mut out);
    }
    assert_eq!((counting.1, shop.state().sequence()), (asked, sequence));
    shop.run(&mut counting, LONG);
    assert_eq!(shop.state().left(), 4);
}
