//! All tests of this crate as one program.

mod agreement;
// The crate that has it builds on every other one, which would all be built for it.
#[path = "../../testkit/src/cases.rs"]
mod cases;
mod contradiction;
mod generate;
mod two_robots;
