//! Production orders: refusals, entries, the order that a part counts to, and lateness.

use std::time::Duration;

use linewright_coordinator_cell::ProductionCommand::{Cancel, Submit, Withdraw};
use linewright_coordinator_cell::compile::dispatcher;
use linewright_coordinator_cell::dispatch::{DispatchRule, RuleDispatcher};
use linewright_coordinator_cell::production::{
    DispatchConfiguration, Production, ProductionChange, ProductionOrderRequest, ProductionRefusal, ProductionStatus,
    RequestProblem,
};
use linewright_coordinator_cell::{
    Dispatcher, HoldReason, PartId, PlayerState, ProductionCommandError, ProductionId, Record, RecordKind,
};
use linewright_line::Tick;

use super::shop::{C1, Made, Shop, changed, request};

fn at(seconds: u64) -> Tick {
    Tick::from_millis(seconds * 1000)
}

fn book() -> (Made, Production) {
    let made = Made::new(C1);
    let production = Production::new(&made.table);
    (made, production)
}

fn named(key: u128, name: &str, after: &[&str]) -> ProductionOrderRequest {
    let after = after.iter().map(|&name| name.to_owned()).collect();
    ProductionOrderRequest { name: name.to_owned(), after, ..request(key, &("A", 1, None)) }
}

/// Submits and applies.
fn accept(production: &mut Production, now: Tick, requests: &[ProductionOrderRequest]) -> usize {
    let changes = production.submit(requests).unwrap_or_else(|wrongs| panic!("{wrongs:?}"));
    let count = changes.len();
    changes.into_iter().for_each(|change| assert!(production.note(&changed(now, change)).unwrap()));
    count
}

fn apply(production: &mut Production, now: Tick, change: Result<ProductionChange, ProductionRefusal>) {
    assert!(production.note(&changed(now, change.unwrap())).unwrap());
}

#[test]
fn all_that_is_wrong_with_a_batch_is_said_at_once() {
    let (_, mut production) = book();
    accept(&mut production, at(0), &[named(1, "first", &[]), named(2, "second", &["first"])]);
    let withdrawn = production.withdraw("second");
    apply(&mut production, at(1), withdrawn);
    let bad = ProductionOrderRequest {
        product: "C".to_owned(),
        quantity: 0,
        release: Some(at(9)),
        due: Some(at(8)),
        after: vec!["frist".to_owned(), "second".to_owned()],
        ..named(3, "a\nb", &[])
    };
    let batch = [bad, named(4, "first", &[]), named(1, "other", &[]), named(5, "twice", &[]), named(6, "twice", &[])];
    let said: Vec<String> = production.submit(&batch).unwrap_err().iter().map(RequestProblem::to_string).collect();
    let expected = [
        "order `other`: key already used by `first` with other content; use a new key for each request",
        "order name `a\nb` not valid: 1 to 64 characters, one line",
        "order `a\nb`: no product `C`; did you mean `A` or `B`?",
        "order `a\nb`: quantity 0, allowed 1 to 1000000",
        "order `a\nb`: due 1 s before its release",
        "order `a\nb`: no predecessor `frist`; did you mean `first`?",
        "order `a\nb`: predecessor `second` was withdrawn",
        "order name `first` in use; choose another, or wait until that order is finished",
        "order name `twice` requested twice with different keys; choose another for one",
    ];
    assert_eq!(said, expected);
    assert_eq!(production.orders().len(), 2, "nothing has changed");
}

#[test]
fn what_waits_for_itself_is_refused_and_the_circle_is_named() {
    let (_, production) = book();
    let circle = |requests: &[ProductionOrderRequest]| match &production.submit(requests).unwrap_err()[..] {
        [wrong @ RequestProblem::Circle(_)] => wrong.to_string(),
        other => panic!("{other:?}"),
    };
    let alone = [named(1, "a", &["a"])];
    assert_eq!(circle(&alone), "predecessors form a circle: `a` after `a`");
    let three = [named(1, "x", &["a"]), named(2, "a", &["b"]), named(3, "b", &["c"]), named(4, "c", &["a"])];
    assert_eq!(circle(&three), "predecessors form a circle: `a` after `b` after `c` after `a`");
}

/// A long chain, given from its end: each becomes an order after the one it is after, and no stack runs over.
#[test]
fn a_batch_is_put_in_order() {
    let (_, mut production) = book();
    let chain: Vec<ProductionOrderRequest> = (0..5000_u32)
        .rev()
        .map(|k| match k {
            0 => named(0, "0", &[]),
            k => named(u128::from(k), &k.to_string(), &[&(k - 1).to_string()]),
        })
        .collect();
    assert_eq!(accept(&mut production, at(0), &chain), 5000);
    let names = production.orders().map(|order| order.request.name.clone());
    assert!(names.eq((0..5000).map(|k| k.to_string())));
}

#[test]
fn the_same_request_twice_is_one_order() {
    let (_, mut production) = book();
    let request = named(7, "once", &[]);
    assert_eq!(accept(&mut production, at(0), &[request.clone(), request.clone()]), 1);
    assert_eq!(accept(&mut production, at(5), &[request]), 0);
    assert_eq!(production.orders().len(), 1);
}

/// The orders as they go through a cell: released parts enter, in turn, and none without an order.
#[test]
fn parts_enter_as_they_are_ordered_and_count_to_their_orders() {
    let (made, mut production) = book();
    let b = ProductionOrderRequest { priority: 5, release: Some(at(500)), ..request(2, &("B", 1, Some(900))) };
    let requests = [
        request(1, &("A", 2, Some(100))),
        b,
        ProductionOrderRequest { after: vec!["order 1".to_owned()], ..request(3, &("A", 1, None)) },
    ];
    accept(&mut production, at(0), &requests);
    let status = |production: &Production, name: &str, now| production.status(production.named(name).unwrap(), now);
    assert_eq!(status(&production, "order 1", at(0)), ProductionStatus::Released);
    assert_eq!(status(&production, "order 2", at(0)), ProductionStatus::Waiting { on: vec![], until: Some(at(500)) });
    assert_eq!(
        status(&production, "order 3", at(0)),
        ProductionStatus::Waiting { on: vec![ProductionId(1)], until: None }
    );
    let mut desk = DispatchConfiguration::new(dispatcher(&made.cell, &made.table), production);
    let mut shop = Shop::new(&made.table);
    shop.run(&mut desk, at(10));
    assert_eq!(shop.state().parts().len(), 2, "two are wanted now");
    let held: Vec<&HoldReason> = shop.state().held().iter().map(|(_, reason)| reason).collect();
    assert_eq!(held.iter().filter(|reason| ***reason == HoldReason::NotOrdered).count(), 2);
    let order = |desk: &DispatchConfiguration, name: &str| desk.production().unwrap().named(name).unwrap().clone();
    assert_eq!(status(desk.production().unwrap(), "order 1", at(10)), ProductionStatus::InWork { begun: at(0) });
    shop.run(&mut desk, at(400));
    assert_eq!((shop.state().left(), order(&desk, "order 1").done, order(&desk, "order 3").done), (3, 2, 1));
    // Nothing else happens before the release, and it is not lost.
    shop.run(&mut desk, at(2000));
    assert_eq!((shop.state().left(), shop.state().parts().len()), (4, 0));
    let enters: Vec<_> = shop.starts().into_iter().filter(|(_, name, _)| name.starts_with("enter")).collect();
    assert_eq!(enters.iter().map(|&(at, name, _)| (at, name)).next_back(), Some((500_000, "enter<B.new>")));
    // The second part of the first order is what ends it, and what lets the third begin.
    let ended = order(&desk, "order 1").ended.unwrap();
    assert_eq!(order(&desk, "order 3").begun, Some(ended));
    let late = i64::try_from(ended.as_micros()).unwrap() - 100_000_000;
    assert_eq!(order(&desk, "order 1").lateness(), Some(late));
    assert!(late > 0 && order(&desk, "order 2").lateness().is_some_and(|late| late < 0));
    assert_eq!(order(&desk, "order 3").lateness(), None);
    // All of it follows from the log.
    let (_, mut again) = book();
    accept(&mut again, at(0), &requests);
    shop.log.iter().for_each(|record| _ = again.note(record).unwrap());
    assert_eq!(&again, desk.production().unwrap());
}

/// Of a cancelled order nothing more enters; what is inside is finished as surplus. A withdrawn one leaves no trace.
#[test]
fn cancelled_and_withdrawn_orders() {
    let made = Made::new(C1);
    let mut shop = Shop::new(&made.table);
    let rules = RuleDispatcher::new(&made.table, &[DispatchRule::Fifo], Duration::from_secs(600));
    let mut desk = DispatchConfiguration::new(rules, shop.state().production().clone());
    let requests = [request(1, &("A", 6, None)), request(2, &("B", 1, None)), named(3, "c", &["order 2"])];
    let ids = [1, 2, 3].map(ProductionId).to_vec();
    for _ in 0..2 {
        assert_eq!(shop.command(Submit(&requests), &mut desk), Ok(ids.clone()), "asked twice, it is the same order");
    }
    let needed = ProductionRefusal::Needed { name: "order 2".to_owned(), by: "c".to_owned() };
    assert_eq!(shop.command(Withdraw("order 2"), &mut desk), Err(ProductionCommandError::Order(needed)));
    assert_eq!(shop.command(Withdraw("c"), &mut desk), Ok(vec![ProductionId(3)]));
    assert_eq!(shop.command(Withdraw("order 2"), &mut desk), Ok(vec![ProductionId(2)]));
    assert!(matches!(
        shop.command(Withdraw("c"), &mut desk),
        Err(ProductionCommandError::Order(ProductionRefusal::Unknown { .. }))
    ));
    assert_eq!(shop.log.len(), 1 + 3 + 2, "what is refused changes nothing");
    shop.run(&mut desk, at(100));
    let inside = u32::try_from(shop.state().parts().len()).unwrap();
    let begun = shop.command(Withdraw("order 1"), &mut desk).unwrap_err();
    assert_eq!(
        begun.to_string(),
        "order `order 1` cannot be withdrawn: 6 of its parts have entered; cancel it instead"
    );
    assert_eq!(shop.command(Cancel("order 1"), &mut desk), Ok(vec![ProductionId(1)]));
    let status = |shop: &Shop| {
        let production = shop.state().production();
        production.status(production.order(ProductionId(1)).unwrap(), shop.now)
    };
    assert_eq!(status(&shop), ProductionStatus::Cancelled { at: at(100), inside });
    shop.run(&mut desk, at(3000));
    let order = shop.state().production().order(ProductionId(1)).unwrap();
    assert_eq!((order.done, order.surplus, order.inside(), order.lateness()), (6, inside, 0, None));
    assert!(order.ended.is_some() && shop.state().parts().len() == 0);
    let over = ProductionRefusal::Over("order 1".to_owned());
    assert_eq!(shop.command(Cancel("order 1"), &mut desk), Err(ProductionCommandError::Order(over)));
    assert_eq!(desk.production(), Some(shop.state().production()), "both were told the same");
    // The production orders are in the log, and in a snapshot, with all that has become of them.
    assert!(PlayerState::replay(made.table.clone(), &shop.log).as_ref() == Ok(shop.state()));
    let text = serde_json::to_string(&shop.state().snapshot()).unwrap();
    let again = PlayerState::restore(made.table.clone(), serde_json::from_str(&text).unwrap()).unwrap();
    assert_eq!(again.snapshot(), shop.state().snapshot());
}

/// After a restart in the middle, from the log or from a snapshot, production orders are made to their end, once.
#[test]
fn production_orders_outlive_their_coordinator() {
    let made = Made::new(C1);
    let dispatcher = |state: &PlayerState| {
        DispatchConfiguration::new(
            RuleDispatcher::new(&made.table, &[DispatchRule::Fifo], Duration::from_secs(600)),
            state.production().clone(),
        )
    };
    for (until, from_snapshot) in [(0, false), (0, true), (70, false), (70, true), (300, false), (300, true)] {
        let mut shop = Shop::new(&made.table);
        let mut desk = dispatcher(shop.state());
        shop.command(Submit(&[request(1, &("A", 3, None)), request(2, &("B", 2, None))]), &mut desk).unwrap();
        shop.run(&mut desk, at(until));
        let state = match from_snapshot {
            true => PlayerState::restore(made.table.clone(), shop.state().snapshot()).unwrap(),
            false => PlayerState::replay(made.table.clone(), &shop.log).unwrap(),
        };
        let mut desk = dispatcher(&state);
        shop.restart(state);
        shop.run(&mut desk, at(10_000));
        assert_eq!((shop.state().left(), shop.state().parts().len()), (5, 0), "{until} s, snapshot: {from_snapshot}");
        assert!(shop.state().production().orders().all(|order| order.ended.is_some() && order.surplus == 0));
    }
}

/// For a part that is lost another one enters, and has its number in the order.
#[test]
fn a_lost_part_is_replaced() {
    let (made, mut production) = book();
    accept(&mut production, at(0), &[request(1, &("A", 3, None))]);
    let enter = made.mode("enter<A.new>");
    let entering = |firing: u64, part: u64| Record {
        at: at(1),
        fact: RecordKind::Started {
            firing: linewright_coordinator_cell::FiringId(firing),
            mode: enter,
            part: Some(PartId(part)),
            orders: Vec::new(),
        },
    };
    for part in 1..=3 {
        assert!(production.note(&entering(part, part)).unwrap());
    }
    let missing = |production: &Production| production.missing().count();
    assert_eq!(missing(&production), 0);
    let lost = changed(at(2), ProductionChange::Lost(PartId(1)));
    production.note(&lost).unwrap();
    assert_eq!((missing(&production), production.named("order 1").unwrap().lost), (1, 1));
    production.note(&lost).unwrap_err();
    assert!(production.note(&entering(4, 4)).unwrap());
    assert_eq!(production.order_of(PartId(4)).unwrap().id, ProductionId(1));
    let numbers = |production: &Production| [1, 2, 3, 4].map(|part| production.number_in_order(PartId(part)));
    assert_eq!(numbers(&production), [None, Some(2), Some(3), Some(1)]);
    // One without an order counts to nothing.
    assert!(!production.note(&entering(5, 5)).unwrap());
}

/// A change that does not follow from what was written before is refused, and nothing changes.
#[test]
fn changes_of_other_orders_do_not_fit() {
    let (_, mut production) = book();
    let before = production.clone();
    let accepted = |id, request| ProductionChange::Accepted { id: ProductionId(id), request };
    for change in [
        accepted(2, named(1, "a", &[])),
        accepted(1, named(1, "a", &["b"])),
        accepted(1, ProductionOrderRequest { product: "C".to_owned(), ..named(1, "a", &[]) }),
        ProductionChange::Cancelled(ProductionId(1)),
        ProductionChange::Withdrawn(ProductionId(1)),
        ProductionChange::Lost(PartId(1)),
    ] {
        let record = changed(at(0), change);
        production.note(&record).unwrap_err();
        assert_eq!(production, before, "{record:?}");
    }
}

/// The rules have the due dates: what is due first is loaded first.
#[test]
fn rules_know_due_dates_and_priorities_of_orders() {
    let made = Made::new(C1);
    let first = |due: [u64; 2]| {
        let production = made.ordered(&[("A", 1, Some(due[0])), ("B", 1, Some(due[1]))]);
        let mut desk = DispatchConfiguration::new(dispatcher(&made.cell, &made.table), production);
        let mut shop = Shop::new(&made.table);
        shop.run(&mut desk, at(1));
        let load = shop.starts().into_iter().find(|(_, name, _)| name.starts_with("load")).unwrap().1.to_owned();
        desk.note(&Record { at: at(1), fact: RecordKind::Epoch { epoch: 2 } });
        load
    };
    assert!(first([100, 200]).ends_with("<A.new>"));
    assert!(first([200, 100]).ends_with("<B.new>"));
}
