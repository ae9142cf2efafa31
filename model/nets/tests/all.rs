//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod certificate;
mod certificate_published;
mod coloured;
mod common;
mod coverability;
mod explicit;
mod explicit_ring;
mod semiflows;
mod siphons;
mod tnces_errors;
mod tnces_examples;
mod tnces_fastorium;
mod tnces_random;
mod token_game;
mod verdicts;
mod wider_classes;
