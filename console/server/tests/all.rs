//! The tests of this crate as one program.

mod browser;
mod bundle;
mod driver;
mod operated;
mod served;
