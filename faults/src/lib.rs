//! Whole lines under faults of everything around them, in virtual time.
//!
//! The shells are those of the nodes ([`linewright_station_shell`], [`linewright_coordinator_shell`]), and their effects are
//! performed as the nodes perform them: one after another, with records that take time and may fail, and a process may end
//! between any two of them.
//!
//! ```text
//!   plan: faults and people, from a seed ──▶ World ──▶ observer: positions, orders that arrived, records that were written
//!                                              │
//!        coordinator ── network ── stations    │    each process: a shell, its effects, a disk, a clock of its own
//!             └── devices ── plant ── devices ─┘
//! ```
//!
//! Some faults look first where the line stands (`provoke`). The same seed gives the same run. At the end of a run the faults end, and an operator brings the line back to auto; a
//! whole cycle has to follow. [`mutants`] are rules that are broken in the world around the shells, or switched off in the
//! controllers: each has to be found. [`play_cell`] is the same for a flexible cell, with its token player and pretended stations.
//!
//! Without clocks, files or threads. What is not simulated is in `docs/faults.md`.

mod broken;
mod cells;
mod chart;
mod checks;
mod coordinator;
mod deliver;
mod devices;
mod disk;
mod faults;
mod floors;
mod lines;
mod message;
pub mod mutants;
mod network;
mod observer;
mod people;
mod plan;
mod process;
mod provoke;
mod recovering;
mod run;
mod shrink;
mod station;
mod world;

pub use cells::{CELL_MUTANTS, CellMutant, PlayedCell, play_cell};
pub use floors::{FLOOR_MUTANTS, FloorMutant, PlayedFloor, play_floor};
pub use mutants::{MUTANTS, Mutant, MutantEntry};
pub use plan::{FaultEvent, FaultPlan, PlannedFault};
pub use provoke::Provocation;
pub use run::{Finding, PlayedSeed, play, play_plan};
pub use shrink::shrink;
