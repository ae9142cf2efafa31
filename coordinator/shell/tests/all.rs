//! All tests of this crate in one program.

mod founding;
mod records;
mod rig;
mod rivals;
mod stops;
