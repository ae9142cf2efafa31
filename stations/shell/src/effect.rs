//! Arrivals at a station, and their effects.

use std::sync::Arc;

use linewright_line::StationId;
use linewright_station_logic::{
    ModeOrder, OrderKey, PanelCommand, RejoinAt, StationHappening, StationReport, TaskCommand, TaskReply,
};

/// Participant of the middleware that a message came from: a process, in the rule. In DDS, the prefix of its publishers' identity.
pub type ParticipantId = [u8; 12];

/// A station's input image as the gateway sends it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputsMessage {
    /// Boot id of the gateway.
    pub boot_id: u64,
    /// Its number in that life.
    pub sequence: u64,
    /// Bit `i` is input `i` of the description.
    pub bits: u128,
    /// The gateway vouches for the bits.
    pub valid: bool,
    /// Changes when the devices are lost, and with the gateway's life.
    pub lives: u64,
    /// The output image that was in force: life of the station that sent it, and its number.
    pub under: (u64, u64),
}

/// Message, or input image of the devices, that has reached the node.
#[derive(Clone, Copy, Debug)]
pub enum StationArrival<'a> {
    /// A coordinator's order.
    Order {
        /// Its number in that coordinator's life.
        sequence: u64,
        /// Sender.
        from: ParticipantId,
        order: ModeOrder,
    },
    /// Another station's state.
    State {
        /// Sender.
        station: StationId,
        /// Its number in that station's life.
        sequence: u64,
        /// The state.
        report: &'a StationReport,
    },
    /// The input image, through the gateway.
    Inputs(InputsMessage),
    /// The input image of the station's own bus.
    Devices {
        /// Bit `i` is input `i` of the description.
        bits: u128,
        /// The bus's manager vouches for the bits.
        valid: bool,
        /// Number of losses of devices.
        losses: u64,
    },
    /// The panel, by message.
    Panel {
        /// Identity of the sender, another one with each start of it.
        console: u64,
        command: PanelCommand,
    },
    /// An operator's confirmation of where the station stands, with the parameters of the task that it stands in.
    Rejoin(RejoinAt, &'a [(Arc<str>, i32)]),
    /// An order for a task, or about one.
    Task(TaskCommand<'a>),
}

/// An output image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Driven {
    /// Its number as a message, in this life of the station.
    pub sequence: u64,
    /// Bit `i` is output `i` of the description.
    pub bits: u128,
    /// Grows with every change of the outputs, and with every motion that begins.
    pub number: u64,
    /// [`InputsMessage::lives`] of the image it was decided on.
    pub lives: u64,
    /// The newest mode epoch received when it was decided.
    pub mode_epoch: u64,
}

/// Effects are performed in the order in which they are given; if one fails, those after it are not performed.
#[derive(Clone, Debug, PartialEq)]
pub enum StationEffect {
    /// Write down [`crate::StationShell::snapshot`].
    Remember,
    /// Put out this image, on the own bus or by way of the gateway.
    Drive(Driven),
    /// Send the controller's report to all readers, as message number `sequence`.
    Tell {
        /// Its number in this life of the station.
        sequence: u64,
    },
    /// Answer an order for a task.
    Reply(OrderKey, TaskReply),
    /// Publish an event.
    Happened(StationHappening),
    /// Log the input ignored and the reason: the 1st, 2nd, 4th, 8th … time.
    Ignored {
        /// Number of inputs ignored so far.
        count: u64,
        /// Reason for the last of them.
        why: String,
    },
}
