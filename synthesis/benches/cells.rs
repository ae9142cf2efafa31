//! Synthesis against machines and products: by decision diagrams, and the monolithic way in the same run.
//!
//! Two kinds of cells: the shipped one with two robots, and rings of robots that share a zone with each neighbour, each of which
//! takes both zones one after the other. `cargo bench -p linewright-synthesis` prints a table; `-- robots 6` or `-- ring 8 6` takes one
//! case alone, with the peak memory of the process.

use std::fmt::Write as _;
use std::time::Instant;

use linewright_relations::{ConditionId, Relations, SourceText, parse};
use linewright_synthesis::monolithic::explore;
use linewright_synthesis::{Synthesis, SynthesisLimits, synthesise};

/// More states are not explored one by one.
const STATES_MAX: usize = 1_000_000;

fn two_robots() -> Relations {
    let description =
        include_str!("../../launch-config/lines/two-robot-cell/relations.toml").replace("max = 2", "max = 6");
    let sources = [
        ("relations.toml", description.as_str()),
        ("operations.csv", include_str!("../../launch-config/lines/two-robot-cell/operations.csv")),
        ("relations.csv", include_str!("../../launch-config/lines/two-robot-cell/relations.csv")),
    ];
    parse(&sources.map(|(name, text)| SourceText { name, text })).expect("it is sound").relations
}

/// Robots in a ring: each takes the zone to its left, then the one to its right, and frees both.
fn ring(robots: usize) -> Relations {
    let mut description = "name = \"ring\"\nproducts_max = 6\n[[condition]]\nname = \"A\"\n".to_owned();
    let mut operations = "id,machine,conditions\n".to_owned();
    let mut relations = "machine,operation,after,zones_before,zones_after\n".to_owned();
    for robot in 0..robots {
        let next = (robot + 1) % robots;
        let _ = write!(description, "[[machine]]\nname = \"R{robot}\"\n[[zone]]\nname = \"z{robot}\"\n");
        let _ = write!(operations, "{robot}1,R{robot},A\n{robot}2,R{robot},A\n{robot}3,R{robot},A\n");
        let _ = writeln!(relations, "R{robot},{robot}1,,z{robot},z{robot}");
        let _ = writeln!(relations, "R{robot},{robot}2,,z{robot} z{next},z{next}");
        let _ = writeln!(relations, "R{robot},{robot}3,,z{next},");
    }
    let sources = [("relations.toml", &description), ("operations.csv", &operations), ("relations.csv", &relations)];
    parse(&sources.map(|(name, text)| SourceText { name, text })).expect("it is sound").relations
}

fn measure(name: &str, relations: &Relations, products: usize, is_compared: bool) {
    let products = vec![ConditionId(0); products];
    let begin = Instant::now();
    let found = synthesise(relations, &products, &SynthesisLimits::default());
    let time = begin.elapsed().as_secs_f64();
    let line = match found {
        Ok(Synthesis::Supervisor(found)) => {
            let sizes = &found.sizes;
            format!(
                "{time:8.2} s, {} operations, {} states, {} supervised, {} added, {} nodes, {} steps, {}",
                sizes.operations,
                sizes.reachable,
                sizes.supervised,
                found.added.len(),
                sizes.peak_nodes,
                sizes.steps,
                sizes.order
            )
        }
        Ok(Synthesis::Contradiction(_)) => format!("{time:8.2} s, a contradiction"),
        Err(too_large) => format!("{time:8.2} s, {too_large}"),
    };
    println!("{name}, {} products: {line}", products.len());
    if is_compared {
        let begin = Instant::now();
        let explored = explore(relations, &products, STATES_MAX);
        let time = begin.elapsed().as_secs_f64();
        match explored {
            Some(explored) => {
                println!(
                    "{:>24}monolithic {time:8.2} s, {} states, {} supervised",
                    "",
                    explored.reachable,
                    explored.supervised.len()
                );
            }
            None => println!("{:>24}monolithic {time:8.2} s, more than {STATES_MAX} states", ""),
        }
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let number = |nth: usize| arguments.get(nth).and_then(|number| number.parse().ok()).unwrap_or(2);
    match arguments.first().map(String::as_str) {
        Some("robots") => measure("two robots", &two_robots(), number(1), false),
        Some("ring") => measure(&format!("ring of {}", number(1)), &ring(number(1)), number(2), false),
        // A filter of `cargo xtask bench` for other benchmarks.
        Some(filter) if !"synthesis cells".contains(filter) => return,
        _ => {
            for products in 1..=6 {
                measure("two robots", &two_robots(), products, products <= 2);
            }
            for (robots, products) in [(3, 1), (3, 2), (4, 1), (4, 2), (6, 1), (6, 2), (8, 1), (8, 2), (8, 4), (8, 6)] {
                measure(&format!("ring of {robots}"), &ring(robots), products, robots * products <= 8);
            }
            return;
        }
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().filter(|line| line.starts_with("VmHWM")).for_each(|line| println!("{line}"));
}
