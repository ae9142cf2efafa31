//! The line description: text → checked [`Line`] → nets.
//!
//! This crate knows what a line is and how its description is written. It knows nothing of time passing, messages or
//! devices beyond their names and numbers: those are the business of the crates that take a [`Line`].

mod analogue;
mod console;
mod device;
mod drive;
mod frames;
mod handling;
mod line;
mod modbus;
pub mod net;
mod parse;
mod position;
mod task;
mod time;
mod transfer_line;
mod whereabouts;

pub use analogue::{Analogue, AnalogueInput, AnalogueOutput, CHANNELS_MAX, Channel, Follows, Lag};
pub use console::{Console, StopContact};
pub use device::{
    Canopen, Device, DeviceKind, Identity, Io, Owner, Reaction, Setting, Setup, Transmission, is_the_managers,
    keeps_an_output, wired_bits,
};
pub use drive::{AtRest, Drive, DriveMode, DriveTarget, Homing};
pub use frames::{
    Checksum, Coding, Field, FrameBinding, FrameId, Frames, HeardFrame, Named, Page, Receive, Send, SignalInput,
    SignalOutput, ToldFrame, Unsound, When,
};
pub use handling::{Grip, Handling, Holder, HolderId, Reach, Sensor, Sign, Stand};
pub use line::*;
pub use modbus::{Modbus, REGISTER_BITS, RegisterValue, Table, Watchdog};
pub use parse::{Parsed, Problem, Problems, parse, schema, suggestion};
pub use position::NoClearance;
pub use task::{
    CODE_MAX, PARAMETER_BITS_MAX, PARAMETERS_MAX, Parameter, RESTS_MAX, Rest, RestId, TASKS_MAX, Task, TaskId,
};
pub use time::Tick;
pub use transfer_line::TransferLine;
pub use whereabouts::duration_text;
