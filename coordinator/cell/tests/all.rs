//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod described;
mod exceptions;
mod planning;
mod player;
mod recovery;
mod steps;
mod texts;
