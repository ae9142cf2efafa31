//! A net written down and analysed: two machines that take turns at a robot, and the same with the classic mistake.
//!
//! `cargo run -p linewright-examples --bin net`

use std::error::Error;

use linewright_nets::explicit::{ExplorationLimits, decide};
use linewright_nets::{Net, NetBuilder, NetError};

/// Each machine takes the robot, then a pallet, and gives both back. In the wrong order one of them takes the pallet first.
fn machines(in_order: bool) -> Result<Net, Vec<NetError>> {
    let mut b = NetBuilder::new("two machines");
    let robot = b.place("robot free", 1);
    let pallet = b.place("pallet free", 1);
    for machine in ["m1", "m2"] {
        let (first, second) = if in_order || machine == "m1" { (robot, pallet) } else { (pallet, robot) };
        let idle = b.place(format!("{machine} idle"), 1);
        let waits = b.place(format!("{machine} waits"), 0);
        let works = b.place(format!("{machine} works"), 0);
        let begin = b.transition(format!("{machine} begins"));
        let go_on = b.transition(format!("{machine} goes on"));
        let end = b.transition(format!("{machine} ends"));
        b.input(begin, idle, 1).input(begin, first, 1).output(begin, waits, 1);
        b.input(go_on, waits, 1).input(go_on, second, 1).output(go_on, works, 1);
        b.input(end, works, 1).output(end, idle, 1).output(end, first, 1).output(end, second, 1);
    }
    b.build()
}

fn main() -> Result<(), Box<dyn Error>> {
    for in_order in [true, false] {
        let net = machines(in_order).map_err(|mistakes| format!("{mistakes:?}"))?;
        let facts = decide(&net, &ExplorationLimits::default())?;
        println!("{}: {} markings", if in_order { "in the same order" } else { "in different orders" }, facts.states);
        println!("  live: {}, safe: {}", facts.is_live(), facts.is_safe());
        if let Some(dead) = facts.deadlock {
            let path: Vec<&str> = dead.path.iter().map(|&t| net.transition_name(t)).collect();
            println!("  deadlock: {} after {}", net.describe(&dead.marking), path.join(", "));
        }
    }
    Ok(())
}
