//! The tests of this crate as one program: programs of their own would each be linked with all that they share.
//!
//! Another is `allocations`, which counts them, with an allocator for its whole program.

mod frames;
mod texts;
