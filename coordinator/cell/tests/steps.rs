//! Plans with steps that follow each other on one machine, ways that end early, and variants: played, in parts and orders.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_cell::DispatchRule;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::dispatch::{RuleDispatcher, ShortestRoutes};
use linewright_coordinator_cell::{CellTable, Fifo};
use linewright_line::Tick;

use crate::described::{C1, made, world};

/// Workcell C1, in which A is chamfered in the clamp in which it was turned, if that is possible; or it is only sawn; and
/// there is an A that is not ground.
fn text() -> String {
    let chamfer = |of: &str| format!("{{ resource = \"{of}\", time_s = 10, program = 7, stays = \"may\" }}");
    let steps = format!(
        "[[part.step]]\nname = \"chamfer\"\non = [{}, {}]\n[[part.step]]\nname = \"grind\"",
        chamfer("M1"),
        chamfer("M2")
    );
    let text = C1.replacen("[[part.step]]\nname = \"grind\"", &steps, 1);
    let variant = "[[part.variant]]\nname = \"A rough\"\nwithout = [\"grind\"]\n[[part]]\nname = \"B\"";
    text.replacen("[[part]]\nname = \"B\"", variant, 1)
}

/// Whether messages are lost, come twice or the coordinator dies: a part that stays is clamped once, worked on twice and
/// released once, and the robot gets no order in between.
#[test]
fn a_part_that_stays_is_clamped_once() {
    for seed in 0..5 {
        let mut world = world(made(&text(), Supply::Batch(&[3, 2, 0])), 4, seed);
        world.options.bad_luck = 30;
        world.options.replays = true;
        if seed > 2 {
            world.options.crash_at = (40..4000).step_by(97).collect();
        }
        world.run(&mut Fifo, Tick::from_millis(1_500_000));
        assert_eq!((world.state().left(), world.state().parts().len()), (5, 0), "seed {seed}");
        let tasks = |station: usize| {
            let mut by_part: BTreeMap<_, Vec<(String, i32)>> = BTreeMap::new();
            for done in &world.stations[station].done {
                let program = done.parameters.first().map_or(0, |(_, program)| *program);
                by_part.entry(done.part).or_default().push((done.task.to_string(), program));
            }
            by_part
        };
        let turned: Vec<_> = tasks(0).into_values().chain(tasks(1).into_values()).collect();
        let one = [("clamp", 0), ("machine", 1), ("machine", 7), ("release", 0)];
        let one: Vec<(String, i32)> = one.map(|(task, program)| (task.to_owned(), program)).to_vec();
        assert_eq!(turned, vec![one; 5], "seed {seed}");
        // Only what is ground goes to M3, so the robot moves three parts four times and two of them twice.
        assert_eq!((tasks(2).len(), world.stations[3].done.len()), (3, 3 * 4 + 2 * 2), "seed {seed}");
    }
}

/// By each rule alone: where it does not decide for the unloading, the part stays.
#[test]
fn no_rule_unloads_a_part_to_load_it_again() {
    let rules = [DispatchRule::Fifo, DispatchRule::ShortestProcessingTime, DispatchRule::LeastSlack];
    for rule in rules {
        let it = made(&text(), Supply::Batch(&[3, 0, 1]));
        let mut dispatcher = RuleDispatcher::new(&it.table, &[rule], Duration::from_secs(600));
        let mut world = world(it, 4, 1);
        world.run(&mut dispatcher, Tick::from_millis(900_000));
        assert_eq!(world.state().left(), 4, "{rule}");
        assert_eq!(world.stations[3].done.len(), 4 * 4, "{rule}");
    }
}

fn cell_named(table: &CellTable, name: &str) -> linewright_coordinator_cell::CellId {
    table.cells().find(|&cell| table.cell_name(cell) == name).unwrap_or_else(|| panic!("no cell {name}"))
}

/// The rest is the way without transports, and without the steps that a variant leaves out.
#[test]
fn the_work_that_remains_is_that_of_a_part_that_stays() {
    let made = made(&text(), Supply::Open);
    let routes = ShortestRoutes::new(&made.table);
    let remaining = |name: &str| routes.remaining(cell_named(&made.table, name)).as_secs();
    // Chamfer, unload, load M3, grind, unload.
    assert_eq!(remaining("M1.unload-ready<A.turn>"), 10 + 12 + 12 + 30 + 12);
    assert_eq!(remaining("M1.unload-ready<A rough.turn>"), 10 + 12);
    assert_eq!(remaining("ST.stored-parts<A.turn>"), 12 + 10 + 12 + 12 + 30 + 12);
    let products: Vec<_> = made.table.products().iter().map(|product| product.name.to_string()).collect();
    assert_eq!(products, ["A", "A rough", "B"]);
}
