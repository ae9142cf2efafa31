//! The ROS 2 interfaces of a line.
//!
//! Each message exists twice: as a `.msg` file under `msg/` (those of an action or a service in one file under `action/` or
//! `srv/`), from which a ROS 2 workspace generates C++ and Python, and as the Rust struct of the same name here. The struct
//! is written once, with the `message!` macro of `macros.rs`, which also records its fields and constants;
//! `tests/msg_files.rs` compares that record with the parsed `.msg` file, and `tests/golden.rs` compares the bytes with
//! checked-in ones. So the two cannot drift apart unnoticed.
//!
//! This crate knows nothing of DDS: it holds data, its structure and its [bounds](Invalid). What
//! decodes is not yet believable; [`RosMessage::validate`] is called on everything that arrives.

mod cell;
mod describe;
mod diagnostics;
mod invalid;
mod line;
mod macros;
mod order;
mod services;
mod station;
mod std_types;

pub use cell::{
    ActivityState, AlarmState, AnswerAlarm, AnswerAlarmRequest, AnswerAlarmResponse, CellState, ChangeOrder,
    ChangeOrderRequest, ChangeOrderResponse, LISTED_MAX, PartState, ProductionRequest, ProductionState, SetResource,
    SetResourceRequest, SetResourceResponse, SubmitOrders, SubmitOrdersRequest, SubmitOrdersResponse, WhyNot,
    WhyNotRequest, WhyNotResponse,
};
pub use describe::{Bounded, Constant, Field, RosField, RosMessage};
pub use diagnostics::{Byte, DiagnosticArray, DiagnosticStatus, KeyValue};
pub use invalid::{ITEMS_MAX, Invalid, TEXT_BYTES_MAX, cut, fitting};
pub use line::{LineState, ModeOrder};
pub use order::{OrderEnd, OrderState, RosAction, RunTask, RunTaskFeedback, RunTaskGoal, RunTaskResult, SecureOrder};
pub use services::{
    CORead, COReadID, COWrite, COWriteID, CoReadIdRequest, CoReadIdResponse, CoReadRequest, CoReadResponse,
    CoWriteIdRequest, CoWriteIdResponse, CoWriteRequest, CoWriteResponse, RosService, Trigger, TriggerRequest,
    TriggerResponse,
};
pub use station::{Answer, ProcessImage, StationEvent, StationState};
pub use std_types::{Flag, Header, Text, Time};

/// Package that the messages of this crate belong to on the ROS 2 side.
pub const PACKAGE: &str = "linewright_msgs";
