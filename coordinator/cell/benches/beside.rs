//! Cost of planning beside the decisions: makespan and lateness of the shipped cells, in virtual time, by rules, with planning
//! at once within the decision, and with planning beside that takes so long.
//!
//! `cargo bench -p linewright-coordinator-cell --bench beside [SEEDS]`. Times of activities vary by chance around the nominal
//! ones; every way of planning has the same ones. Virtual times: the machine does not matter.

use std::sync::Arc;
use std::time::{Duration, Instant};

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{
    CompiledCell, OrderTiming, compile_cell, dispatcher, follower_beside, schedule_follower,
};
use linewright_coordinator_cell::production::{DispatchConfiguration, ProductionOrderRequest};
use linewright_coordinator_cell::schedule::RolloutScheduler;
use linewright_coordinator_cell::{CellTable, Dispatcher, PlayerInput, ProductionCommand};
use linewright_line::Tick;
use linewright_simulation::cell::{CellSim, CellSimOptions, SimulatedPlanner, StationSpeed};

const C1: &str = include_str!("../../../launch-config/lines/workcell-c1/cell.toml");
const ASSEMBLY: &str = include_str!("../../../launch-config/lines/assembly-cell/cell.toml");
const LONG: Tick = Tick::from_millis(86_400_000);

/// Way of planning.
#[derive(Clone, Copy)]
enum Way {
    Rules,
    AtOnce,
    Beside(u64),
}

const WAYS: [(&str, Way); 6] = [
    ("rules", Way::Rules),
    ("at once", Way::AtOnce),
    ("beside, 50 ms", Way::Beside(50)),
    ("beside, 150 ms", Way::Beside(150)),
    ("beside, 1 s", Way::Beside(1000)),
    ("beside, 5 s", Way::Beside(5000)),
];

struct Played {
    cell: Cell,
    made: CompiledCell,
    table: Arc<CellTable>,
}

impl Played {
    fn new(text: &str) -> Self {
        let cell = linewright_cell::parse("cell.toml", text, None).unwrap_or_else(|why| panic!("{why:#}")).cell;
        let pace = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
        let made = compile_cell(&cell, None, Supply::Open, pace).expect("it can be played");
        let table = Arc::new(made.table.clone());
        Played { cell, made, table }
    }

    /// Makespan and sum of lateness in seconds, and the number of schedules made.
    fn play(&self, way: Way, orders: &[ProductionOrderRequest], seed: u64, spread: f64) -> (f64, f64, usize) {
        let options = CellSimOptions {
            seed,
            pace: StationSpeed::Nominal { spread },
            delay: (Duration::from_millis(2), Duration::from_millis(6)),
            ..CellSimOptions::default()
        };
        let orders_of = self.table.modes().flat_map(|mode| &self.table.activity(mode).orders);
        let stations = orders_of.map(|order| order.station.index() + 1).max().unwrap_or(0);
        let mut sim = CellSim::new(self.table.clone(), stations, options);
        let rules = dispatcher(&self.cell, &self.table);
        let mut by_rules = DispatchConfiguration::new(rules, sim.state().production().clone());
        let submit = [PlayerInput::Production(0, ProductionCommand::Submit(orders))];
        let plans = match way {
            Way::Rules => {
                sim.say(&mut by_rules, &submit);
                sim.run(&mut by_rules, LONG);
                0
            }
            Way::AtOnce => {
                let mut follower = schedule_follower(&self.cell, &self.made, sim.state());
                sim.say(&mut follower, &submit);
                sim.run(&mut follower as &mut dyn Dispatcher, LONG);
                follower.revisions().len()
            }
            Way::Beside(delay) => {
                let follower = follower_beside(&self.cell, &self.made, sim.state());
                let scheduler = Box::new(RolloutScheduler::default());
                let takes = move |_| Some(Duration::from_millis(delay));
                let mut planner = SimulatedPlanner::new(follower, scheduler, takes);
                sim.say(&mut planner.follower, &submit);
                planner.run(&mut sim, LONG);
                planner.asked.len()
            }
        };
        let made = sim.state().production().orders();
        let ended = made.map(|order| (order.ended.expect("it is made"), order.request.due));
        let (mut makespan, mut late) = (0.0_f64, 0.0);
        for (at, due) in ended {
            makespan = makespan.max(at.as_secs_f64());
            late += due.map_or(0.0, |due| at.since(due).as_secs_f64());
        }
        (makespan, late, plans)
    }
}

/// Orders of one part each, in turn, due one after the other.
fn orders(products: &[&str], count: u64, every: u64) -> Vec<ProductionOrderRequest> {
    let order = |at: u64| ProductionOrderRequest {
        key: u128::from(at) + 1,
        name: format!("order {at}"),
        product: products[at as usize % products.len()].to_owned(),
        quantity: 1,
        // The last ones first, so that the order in which they came is not the best one.
        due: Some(Tick::from_millis((count - at) * every * 1000)),
        ..ProductionOrderRequest::default()
    };
    (0..count).map(order).collect()
}

/// Time of the copy of a cell for its planner, with so many orders that are over, or in work.
fn copy(cell: &Played, products: &[&str], count: u64) -> Duration {
    let orders_of = cell.table.modes().flat_map(|mode| &cell.table.activity(mode).orders);
    let stations = orders_of.map(|order| order.station.index() + 1).max().unwrap_or(0);
    let mut sim = CellSim::new(cell.table.clone(), stations, CellSimOptions::default());
    let orders: Vec<_> = orders(products, count, 60);
    let mut follower = follower_beside(&cell.cell, &cell.made, sim.state());
    sim.say(&mut follower, &[PlayerInput::Production(0, ProductionCommand::Submit(&orders))]);
    while sim.state().left() + 5 < count {
        let next = sim.now + Duration::from_secs(10);
        sim.run_on(&mut follower, next);
        sim.now = sim.now.max(next);
    }
    let mut times: Vec<Duration> = (0..101)
        .map(|_| {
            follower.restored();
            let begin = Instant::now();
            let request = follower.take_request(sim.now, sim.state());
            let took = begin.elapsed();
            assert!(request.is_some(), "it is due");
            follower.planner_lost();
            took
        })
        .collect();
    times.sort_unstable();
    times[50]
}

fn main() {
    let seeds: u64 = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(10);
    let cells = [
        ("workcell-c1", Played::new(C1), orders(&["A", "B"], 16, 60)),
        ("assembly-cell", Played::new(ASSEMBLY), orders(&["1", "2", "3"], 16, 8)),
    ];
    for ((name, cell, _), products) in cells.iter().zip([&["A", "B"][..], &["1", "2", "3"]]) {
        let [few, many] = [8, 500].map(|count| copy(cell, products, count).as_secs_f64() * 1e6);
        println!("{name}: copy for the planner with 8 orders {few:.0} µs, with 500 {many:.0} µs (median)");
    }
    println!("16 parts, mean of {seeds} seeds; s; late: sum over all orders");
    for (name, cell, orders) in &cells {
        for spread in [0.0, 0.3] {
            println!(
                "\n{name}, times within {:.0} % of the nominal ones\n{:16} makespan     late  schedules",
                spread * 100.0,
                ""
            );
            for (what, way) in WAYS {
                let all: Vec<_> = (1..=seeds).map(|seed| cell.play(way, orders, seed, spread)).collect();
                let mean = |of: &dyn Fn(&(f64, f64, usize)) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
                let (makespan, late, plans) = (mean(&|of| of.0), mean(&|of| of.1), mean(&|of| of.2 as f64));
                println!("{what:16} {makespan:8.1} {late:8.1} {plans:10.1}");
            }
        }
    }
}
