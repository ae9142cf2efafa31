//! Devices in Modbus: a process image at one end, requests at the other.
//!
//! - [`ModbusRequest`] and [`ModbusFailure`]: a request to a device, and why it has no answer;
//! - [`ModbusManager`]: the manager of a node's Modbus devices, pure: it is called with the time and with what a connection has
//!   brought, and answers with what the connections have to do and what to report.
//! - [`ModbusTrouble`], [`ModbusCondition`], [`ModbusNote`]: what operators read of a device.
//!
//! Connections are in `linewright_modbus_tcp`. This crate has Modbus's functions, tables and exception codes; the
//! meaning of signals and the mode of a line are not its concern.
//!
//! Clauses are those of the MODBUS Application Protocol Specification, version 1.1b3.

mod manager;
mod message;
mod texts;

pub use manager::{LinkAct, LinkOutcome, LinkTask, ModbusManager, ModbusOutbox};
pub use message::{ModbusFailure, ModbusRequest, kept_bits};
pub use texts::{ModbusCondition, ModbusNote, ModbusServiceReply, ModbusTrouble, exception_text};
