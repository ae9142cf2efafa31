//! Devices in Modbus: a process image at one end, requests at the other.
//!
//! - [`ModbusRequest`] and [`ModbusFailure`]: what is asked of a device, and why there is no answer;
//! - [`ModbusManager`]: the manager of a node's Modbus devices, pure: it is called with the time and with what a connection has
//!   brought, and answers with what the connections have to do and what to report.
//!
//! Connections are in `linewright_modbus_tcp`. This crate knows Modbus's functions, tables and exception codes; it does not
//! know what a signal means or which mode a line is in.
//!
//! Clauses are those of the MODBUS Application Protocol Specification, version 1.1b3.

mod manager;
mod message;

pub use manager::{LinkAct, LinkOutcome, LinkTask, ModbusManager, ModbusOutbox};
pub use message::{ModbusFailure, ModbusRequest, exception_text, kept_bits};
