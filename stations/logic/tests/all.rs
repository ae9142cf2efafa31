//! The tests of this crate as one program: programs of their own would each be linked with all that they share.
//!
//! Only `allocations` is another, because it counts allocations, with an allocator for its whole program.

mod controller;
mod orders;
mod texts;
