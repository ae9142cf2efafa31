//! Time at which a station is missed: exactly when it was not received for so long, whatever other stations and orders
//! do. The player keeps a bound of it; here everything is computed anew after each step.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_cell::{
    ActivityPhase, CellMessage, Coordination, Fifo, OngoingOrder, OrderFailure, OrderKey, OrderProgress, PlayerInput,
    PlayerOutbox, PlayerState, RecordKind, TaskOutcome, TaskReply, TaskReport,
};
use linewright_line::{StationId, Tick};
use linewright_random::Random;

use super::bench::{LOST_AFTER, table, workcell};

fn is_open(order: &OngoingOrder) -> bool {
    match order.state {
        OrderProgress::Written | OrderProgress::Running => true,
        OrderProgress::Ended | OrderProgress::Failed(_) => false,
    }
}

/// The orders that are waited for, by when their stations are missed.
fn waited_for<'a>(state: &'a PlayerState, last: &'a [Tick]) -> impl Iterator<Item = Tick> + 'a {
    let running = state.firings().filter(|firing| firing.phase == ActivityPhase::Running);
    let open = running.flat_map(|firing| firing.orders.iter().filter(|order| is_open(order)));
    open.map(|order| last[order.station.index()] + LOST_AFTER)
}

/// Number of orders lost.
fn play(seed: u64) -> usize {
    let mut dice = Random::new(seed);
    let (cell, table) = table(&workcell(), &[4, 4]);
    let mut last = vec![Tick::ZERO; cell.controllers.len()];
    // Period of each station's reports: some hardly ever.
    let seldom: Vec<usize> = last.iter().map(|_| 2 + dice.below(40)).collect();
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(table), Tick::ZERO, 1, &mut out).expect("a first life");
    let heard = TaskReport { memory: 1, ..TaskReport::default() };
    let mut told: BTreeMap<OrderKey, (StationId, bool)> = BTreeMap::new();
    let (mut now, mut lost) = (Tick::ZERO, 0);
    for step in 0..300 {
        let mut inputs = vec![PlayerInput::Starts(true)];
        for (at, last) in last.iter_mut().enumerate() {
            if step == 0 || dice.one_in(seldom[at]) {
                *last = now;
                inputs.push(PlayerInput::Station(StationId::at(at), &heard));
            }
        }
        let mut left = BTreeMap::new();
        for (key, (station, has_begun)) in std::mem::take(&mut told) {
            let (runs, ends) = (!has_begun && dice.one_in(2), has_begun && dice.one_in(30));
            let reply = if ends { TaskReply::Ended(TaskOutcome::Done) } else { TaskReply::Running };
            if runs || ends {
                inputs.push(PlayerInput::Reply(station, key, reply));
            }
            if !ends {
                left.insert(key, (station, has_begun || runs));
            }
        }
        told = left;
        player.step(now, &inputs, &mut Fifo, &mut out);
        for record in out.records.drain(..) {
            if let RecordKind::OrderFailed { key, failure: OrderFailure::Lost } = record.fact {
                let (_, order) = player.state().order(key).expect("it is kept while it is not known what is true");
                assert!(last[order.station.index()] + LOST_AFTER <= now, "{seed}: {key} is lost too early");
                lost += 1;
            }
        }
        for send in out.sends.drain(..) {
            if let CellMessage::Order(order) = send {
                told.entry(order.order.key).or_insert((order.station, false));
            }
        }
        let first = waited_for(player.state(), &last).min();
        assert!(first.is_none_or(|first| first > now), "{seed}: somebody is not missed");
        let wakes = player.next_deadline();
        assert!(first.is_none_or(|first| wakes.is_some_and(|wakes| wakes <= first)), "{seed}: nobody wakes it");
        now = match wakes {
            // Exactly then, now and then.
            Some(wakes) if wakes > now && dice.one_in(3) => wakes,
            Some(_) | None => now + Duration::from_millis(1 + dice.below(300) as u64),
        };
    }
    lost
}

#[test]
fn a_station_is_missed_exactly_when_it_was_not_heard_for_so_long() {
    let lost: Vec<usize> = (0..200).map(play).collect();
    assert!(lost.iter().filter(|&&lost| lost > 0).count() > 150, "{lost:?}");
}
