//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod golden;
mod hostile;
mod interfaces;
mod samples;
mod type_hashes;
