//! All tests of this crate in one program.

mod cycle_time;
mod founding;
mod health;
mod held;
mod lifecycle;
mod parameters;
mod records;
mod rig;
mod rivals;
mod single;
mod stops;
