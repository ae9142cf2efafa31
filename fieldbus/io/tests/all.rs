//! The tests of this crate as one program: programs of their own would each be linked with all that they share.
//!
//! Others are `vcan` and `sdo_python`, which are run whole where there is a real CAN interface.

mod interface;
mod own_buses;
mod texts;
mod virtual_bus;
