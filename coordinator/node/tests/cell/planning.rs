//! The planner on its thread: decisions go on while it stands still, and after it has ended.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use linewright_coordinator_cell::compile::follower_beside;
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_coordinator_cell::schedule::{PlanningSituation, RolloutScheduler, Schedule, Scheduler};
use linewright_coordinator_node::cell::{CellPlanning, RESTART_AFTER};
use linewright_line::Tick;
use linewright_simulation::cell::{CellSim, CellSimOptions};

use super::shipped::{Shipped, with_production_orders};

const PARTS: u32 = 5;

fn cell(of: &Shipped) -> CellSim {
    let mut sim = CellSim::new(of.table.clone(), of.stations, CellSimOptions::default());
    let name = "order".to_owned();
    let product = "1".to_owned();
    let order = ProductionOrderRequest { key: 1, name, product, quantity: PARTS, ..ProductionOrderRequest::default() };
    sim.asked = vec![vec![order]];
    sim
}

/// Plays in virtual time up to a moment; requests are passed as the cell's thread does, and nothing is taken from the planner.
fn play(sim: &mut CellSim, planning: &mut CellPlanning, until: Tick) {
    while sim.now < until {
        let next = (sim.now + Duration::from_millis(100)).min(until);
        sim.run_on(planning.dispatcher(), next);
        sim.now = sim.now.max(next);
        planning.request(sim.now, sim.state());
    }
}

/// Plans nothing before a gate opens.
struct Gated(Arc<Mutex<mpsc::Receiver<()>>>, mpsc::Sender<()>);

impl Scheduler for Gated {
    fn plan(&mut self, situation: &PlanningSituation<'_>) -> Schedule {
        self.1.send(()).expect("the test waits");
        // Until the test ends, or opens it.
        let _ = self.0.lock().expect("no panic").recv();
        RolloutScheduler::default().plan(situation)
    }
}

/// Waits for the planner, and takes what comes.
fn take(sim: &mut CellSim, planning: &mut CellPlanning) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().expect("a runtime");
    let news = async { tokio::time::timeout(Duration::from_secs(60), planning.news()).await };
    let news = runtime.block_on(news).expect("it comes");
    planning.take(sim.now, news, &mut sim.coordination);
}

#[test]
fn decisions_go_on_while_the_planner_stands_still_and_its_schedule_is_taken_when_it_comes() {
    let of = with_production_orders("assembly-cell", 5);
    let mut sim = cell(&of);
    let (open, gate) = mpsc::channel();
    let (begins, begun) = mpsc::channel();
    let gate = Arc::new(Mutex::new(gate));
    let scheduler = move || -> Box<dyn Scheduler + Send> { Box::new(Gated(gate.clone(), begins.clone())) };
    let mut planning = CellPlanning::new(follower_beside(&of.cell, &of.made, sim.state()), scheduler);
    play(&mut sim, &mut planning, Tick::from_millis(2000));
    begun.recv_timeout(Duration::from_secs(60)).expect("it has begun");
    play(&mut sim, &mut planning, Tick::from_millis(600_000));
    assert_eq!(sim.state().left(), u64::from(PARTS), "all is made meanwhile");
    assert!(planning.follower().schedule().is_none() && planning.follower().is_overdue(sim.now));
    assert!(begun.try_recv().is_err(), "one request at a time");
    open.send(()).expect("it waits");
    take(&mut sim, &mut planning);
    assert!(planning.follower().schedule().is_some());
}

/// Ends its thread.
struct Panics;

impl Scheduler for Panics {
    fn plan(&mut self, _: &PlanningSituation<'_>) -> Schedule {
        panic!("a scheduler with a bug, for a test");
    }
}

#[test]
fn after_a_planner_that_panics_another_is_begun_but_not_at_once() {
    let of = with_production_orders("assembly-cell", 5);
    let mut sim = cell(&of);
    let counted = Arc::new(AtomicUsize::new(0));
    let count = counted.clone();
    let scheduler = move || -> Box<dyn Scheduler + Send> {
        match count.fetch_add(1, Ordering::SeqCst) {
            0 => Box::new(Panics),
            _ => Box::new(RolloutScheduler::default()),
        }
    };
    let mut planning = CellPlanning::new(follower_beside(&of.cell, &of.made, sim.state()), scheduler);
    play(&mut sim, &mut planning, Tick::from_millis(100));
    take(&mut sim, &mut planning);
    let before = sim.state().sequence();
    play(&mut sim, &mut planning, Tick::ZERO + RESTART_AFTER - Duration::from_millis(100));
    assert!(sim.state().sequence() > before && planning.follower().schedule().is_none(), "the rules decide");
    assert_eq!(counted.load(Ordering::SeqCst), 1, "not at once");
    play(&mut sim, &mut planning, Tick::ZERO + RESTART_AFTER + Duration::from_millis(300));
    assert_eq!(counted.load(Ordering::SeqCst), 2);
    take(&mut sim, &mut planning);
    assert!(planning.follower().schedule().is_some(), "it plans again");
    play(&mut sim, &mut planning, Tick::from_millis(600_000));
    assert_eq!(sim.state().left(), u64::from(PARTS));
}
