//! The tests of this crate as one program: programs of their own would each be linked with all that they share.
//!
//! Others are `allocations`, which counts them, with an allocator for its whole program, and `vcan` and `sdo_python`, which
//! are run whole where there is a real CAN interface.

mod any_frames;
mod frames;
mod virtual_bus;
