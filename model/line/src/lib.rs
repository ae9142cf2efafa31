//! The line description: text → checked [`Line`] → nets.
//!
//! This crate contains lines and their descriptions. It contains no time passing, messages, or devices beyond their
//! names and numbers: those are the business of the crates that take a [`Line`].

mod analogue;
mod console;
mod device;
mod drive;
mod fingerprint;
mod frames;
mod hand;
mod handling;
mod io_list;
mod line;
mod modbus;
pub mod net;
mod parse;
mod position;
mod task;
mod time;
mod transfer_line;
mod whereabouts;

pub use analogue::{Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, CHANNELS_MAX, Follows, Lag};
pub use console::{Console, StopContact};
pub use device::{
    Canopen, Device, DeviceIdentity, DeviceKind, DeviceSetup, Io, ObjectWrite, Owner, Reaction, Transmission,
    is_the_managers, keeps_an_output, wired_bits,
};
pub use drive::{AtRest, Drive, DriveIndex, DriveMode, DriveTarget, Homing, NumberedOrder, TurnDirection};
pub use fingerprint::Fnv;
pub use frames::{
    Checksum, Coding, CyclicFrame, DbcName, FrameBinding, FrameField, FrameId, FrameTable, Page, ReceivedFrameBinding,
    ReceivedMessageTable, SentFrameBinding, SignalError, SignalInput, SignalOutput, When,
};
pub use hand::{HandMode, HandType};
pub use handling::{Grip, Holder, HolderId, MaterialFlow, Reach, Sensor, Sign, Stand};
pub use io_list::{
    BitAddress, DeviceBegin, IO_COLUMNS, IoChange, IoDirection, IoListError, IoRow, RowProblem, io_list,
    unknown_devices, with_io_list, within_devices,
};
pub use line::*;
pub use modbus::{Modbus, REGISTER_BITS, RegisterValue, Table, WatchdogRegister};
pub use parse::{ParsedLine, Problem, Problems, expand, is_described, parse, schema, suggestion};
pub use position::{ClearanceInputs, CutShort, NoClearance};
pub use task::{
    CODE_MAX, PARAMETER_BITS_MAX, PARAMETERS_MAX, Parameter, REJOIN_AT_REST, RESTS_MAX, Rest, RestId, TASKS_MAX, Task,
    TaskId, TaskOrderSource,
};
pub use time::Tick;
pub use transfer_line::TransferLine;
pub use whereabouts::duration_text;
