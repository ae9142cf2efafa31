//! The shipped flexible cell in virtual time: three parts of each type, and when each activity begins.
//!
//! `cargo run -p linewright-examples --bin flexible_cell`

use std::error::Error;
use std::sync::Arc;

use linewright_cell::net::Supply;
use linewright_coordinator_cell::RecordKind;
use linewright_coordinator_cell::compile::{compile_cell, dispatcher};
use linewright_coordinator_cell::texts::named;
use linewright_line::Tick;
use linewright_simulation::cell::{CellSim, CellSimOptions, UNCHANGED, UNDISTURBED};

fn main() -> Result<(), Box<dyn Error>> {
    let line = linewright_line::parse("line.toml", include_str!("../../../launch-config/lines/workcell-c1/line.toml"))
        .map_err(|problems| format!("{problems:?}"))?
        .line;
    let cell = linewright_cell::parse(
        "cell.toml",
        include_str!("../../../launch-config/lines/workcell-c1/cell.toml"),
        Some(&line),
    )
    .map_err(|problems| format!("{problems:?}"))?
    .cell;
    let batch = vec![3; cell.part_types.len()];
    let played = compile_cell(&cell, Some(&line), Supply::Batch(&batch), UNDISTURBED)?;
    let table = Arc::new(played.table.clone());
    let mut rules = dispatcher(&cell, &table);
    let mut sim =
        CellSim::new(table, line.stations.len(), CellSimOptions { period: UNCHANGED, ..CellSimOptions::default() });
    sim.run(&mut rules, Tick::NEVER);
    for record in &sim.log {
        if let RecordKind::Started { mode, part, .. } = record.fact {
            println!("{:>9.3} s  {}", record.at.as_secs_f64(), named(sim.state().table(), mode, part));
        }
    }
    println!("{} of {} parts have left", sim.state().left(), batch.iter().sum::<u32>());
    Ok(())
}
