//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod confirmation;
mod convert;
mod devices;
mod foreign;
mod health;
