//! Anything in any order: orders new, old, doubled and for other memories, faults, modes, people, restarts. An independent
//! ledger is kept from the outputs and the answers alone.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use linewright_line::net::{Block, ControlMode};
use linewright_station_logic::PanelCommand::{Advance, Retract};
use linewright_station_logic::{OrderKey, TaskOrder, TaskOutcome, TaskReply};
use proptest::prelude::*;

use super::bench::{MEMORY, OrderBench, key, order};

#[derive(Clone, Debug)]
enum Act {
    Run { id: u64, epoch: u64, task: usize, memory: u64, limit_ms: u64 },
    Secure(u64),
    Stop(u64),
    Arrive,
    Mode(usize),
    Input(usize, bool),
    Devices(bool),
    Panel(usize),
    Wait(u64),
    Kill,
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        6 => (0u64..12, 1u64..3, 0usize..4, prop::bool::weighted(0.95), prop_oneof![Just(0u64), 100..9000u64])
            .prop_map(|(id, epoch, task, mine, limit_ms)| Act::Run {
                id, epoch, task, memory: if mine { MEMORY } else { 99 }, limit_ms,
            }),
        2 => (0u64..12).prop_map(Act::Secure),
        1 => (0u64..12).prop_map(Act::Stop),
        8 => Just(Act::Arrive),
        3 => (0usize..9).prop_map(Act::Mode),
        2 => (0usize..2, any::<bool>()).prop_map(|(input, on)| Act::Input(input, on)),
        1 => prop::bool::weighted(0.8).prop_map(Act::Devices),
        2 => (0usize..3).prop_map(Act::Panel),
        2 => (0u64..4000).prop_map(Act::Wait),
        1 => Just(Act::Kill),
    ]
}

const TASKS: [&str; 4] = ["clamp", "machine", "release", "dance"];

/// Observations of each key.
#[derive(Default)]
struct Ledger {
    ended: BTreeMap<OrderKey, TaskOutcome>,
    begun: BTreeMap<OrderKey, usize>,
    /// It was ordered to stop these.
    stopped: BTreeSet<OrderKey>,
}

impl Ledger {
    fn hears(&mut self, key: OrderKey, reply: TaskReply) -> Result<(), TestCaseError> {
        if let TaskReply::Ended(outcome) = reply {
            let first = *self.ended.entry(key).or_insert(outcome);
            prop_assert_eq!(first, outcome, "{:?} has ended once", key);
        }
        Ok(())
    }

    /// The station's reports fit to those before.
    fn looks(&mut self, m1: &mut OrderBench) -> Result<(), TestCaseError> {
        let orders = m1.orders();
        for &(key, outcome) in &orders.results {
            self.hears(key, TaskReply::Ended(outcome))?;
        }
        if let Some(slot) = orders.slot {
            prop_assert!(!self.stopped.contains(&slot.key), "{:?} was stopped, and goes on or back", slot.key);
        }
        if let Some(slot) = orders.slot.filter(|slot| !slot.is_securing) {
            prop_assert!(!self.ended.contains_key(&slot.key), "{:?} is done again", slot.key);
        }
        let events = m1.events();
        for began in events.iter().filter(|event| event.starts_with("accepted a task order: ")) {
            let key = orders.slot.map(|slot| slot.key).or_else(|| orders.results.last().map(|(key, _)| *key));
            let key = key.expect("what is to be done is in the slot, or has ended in the same step");
            *self.begun.entry(key).or_default() += 1;
            prop_assert_eq!(self.begun[&key], 1, "{}", began);
        }
        let report = m1.controller.report();
        let place = m1.marking();
        for (done, started) in report.done.iter().zip(&report.started) {
            prop_assert!(done <= started && started - done <= 1 && *started <= report.cycle);
        }
        // Motors only by the marking; numbers only while there is an order, or a person leads a station on its way.
        let motor = match (place.is_operating(), place.op.0, place.block) {
            (false, _, _) => None,
            (true, 0, Block::Normal) | (true, 4, Block::Recovery) => Some("Y_close"),
            (true, 0, Block::Recovery) | (true, 4, Block::Normal) => Some("Y_open"),
            (true, 1, Block::Normal) => Some("Y_in"),
            (true, 2, _) | (true, 3, Block::Recovery) => Some("Y_mill"),
            (true, _, _) => Some("Y_out"),
        };
        for output in m1.on() {
            let is_led = matches!(report.mode, Some(ControlMode::Hand | ControlMode::Manual)) && m1.rest().is_none();
            let number = output.starts_with("prog") && (orders.slot.is_some() || is_led);
            prop_assert!(number || Some(output) == motor, "{} is on in {}", output, place);
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_order_is_done_twice_and_no_end_is_taken_back(acts in prop::collection::vec(act(), 1..120)) {
        let mut m1 = OrderBench::new();
        let mut ledger = Ledger::default();
        let (mut newest, mut boots) = (0u64, 100u64);
        for act in acts {
            match act {
                Act::Run { id, epoch, task, memory, limit_ms } => {
                    // Mostly the next one, at times one from before.
                    let id = if id < 8 { newest + 1 } else { newest.saturating_sub(id - 8) };
                    newest = newest.max(id);
                    let known = order(id, TASKS[task]);
                    let limit = Duration::from_millis(limit_ms);
                    let order = TaskOrder { key: key(epoch, id), memory, limit, ..known };
                    let reply = m1.run(&order);
                    ledger.hears(order.key, reply)?;
                }
                Act::Secure(id) => {
                    let key = m1.slot().filter(|_| id < 8).unwrap_or(key(1, newest.saturating_sub(id)));
                    let reply = m1.secure(key);
                    ledger.hears(key, reply)?;
                }
                Act::Stop(id) => {
                    let key = m1.slot().filter(|_| id < 8).unwrap_or(key(1, newest.saturating_sub(id)));
                    let was_at_it = m1.slot() == Some(key);
                    let reply = m1.stop(key);
                    ledger.hears(key, reply)?;
                    prop_assert!(!was_at_it || m1.outputs == 0, "{:?} is on after a stop", m1.on());
                    ledger.stopped.insert(key);
                }
                Act::Arrive if m1.marking().is_operating() => m1.arrive(),
                Act::Arrive => {}
                Act::Mode(mode) => m1.mode(*ControlMode::ALL.get(mode).unwrap_or(&ControlMode::Auto)),
                Act::Input(input, on) => m1.set(["part_present", "F_mill"][input], on),
                Act::Devices(valid) => m1.devices(valid),
                Act::Panel(held) => m1.hold([&[Advance(true)][..], &[Retract(true)], &[]][held]),
                Act::Wait(ms) => m1.wait(Duration::from_millis(ms)),
                Act::Kill => {
                    boots += 1;
                    m1 = m1.killed(boots);
                    m1.mode(ControlMode::Auto);
                }
            }
            ledger.looks(&mut m1)?;
        }
    }
}
