//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

// The crate that has it builds on every other one, which would all be built for it.
#[path = "../../../testkit/src/cases.rs"]
mod cases;
mod files;
mod never_panics;
mod round_trip;
mod rules;
