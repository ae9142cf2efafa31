//! Texts of events.

use std::fmt;

use linewright_line::Owner;

use crate::codec::error_register_text;
use crate::frame::{BUS_OFF, RESTARTED};
use crate::manager::MANAGER_NODE;
use crate::manager::event::BusEvent;
use crate::manager::rate_limit::{FRAMES_MAX, WINDOW};

impl fmt::Display for BusEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BusEvent::DeviceUp { node } => write!(f, "node {node} is operational"),
            BusEvent::DeviceLost { node, silent_for } => {
                write!(f, "node {node} is lost: silent for {} ms", silent_for.as_millis())
            }
            BusEvent::DeviceRebooted { node } => write!(f, "node {node} has rebooted"),
            BusEvent::DeviceLeft { node, state } => {
                write!(f, "node {node} has left the operational state (now {:02X}h)", state.code())
            }
            BusEvent::NoSync { node, silent_for } => {
                write!(f, "node {node} hears no SYNC: its inputs have not come for {} ms", silent_for.as_millis())
            }
            BusEvent::ChannelFault { node, fault } => write!(f, "node {node} is not trusted: {fault}"),
            BusEvent::FramesUp { id } => write!(f, "the sender of {id} is live"),
            BusEvent::FramesLost { id, silent_for, why } => {
                write!(f, "the sender of {id} is lost: nothing of it for {} ms: {why}", silent_for.as_millis())
            }
            BusEvent::BootFailed { node, why } => write!(f, "node {node} is not started: {why}"),
            BusEvent::Emergency { node, emergency, profile } => {
                write!(f, "node {node} reports {}", emergency.text(*profile))
            }
            BusEvent::ErrorRegister { node, register: 0 } => {
                write!(f, "node {node} is in error no longer: its error register 1001h = 00h")
            }
            BusEvent::ErrorRegister { node, register } => {
                write!(
                    f,
                    "node {node} is in error: its error register 1001h = {register:02X}h ({})",
                    error_register_text(*register)
                )
            }
            BusEvent::Babbles { node } => write!(
                f,
                "node {node} babbles: more than {FRAMES_MAX} frames within {} ms; it is not listened to",
                WINDOW.as_millis()
            ),
            BusEvent::InputsChanged { owner: Owner::Station(id) } => write!(f, "inputs of station {} changed", id.0),
            BusEvent::InputsChanged { owner: Owner::Console } => f.write_str("inputs of the console changed"),
            BusEvent::Answered { number } => write!(f, "request {number} is answered"),
            BusEvent::AnotherManager => {
                write!(f, "another CANopen manager (node {MANAGER_NODE}, heartbeat 77Fh) is on this bus: nothing moves")
            }
            BusEvent::AloneAgain => {
                write!(f, "the other CANopen manager (node {MANAGER_NODE}) is silent: the devices are brought up")
            }
            BusEvent::BusError { class } if class & BUS_OFF != 0 => f.write_str("the bus is off"),
            BusEvent::BusError { class } if class & RESTARTED != 0 => f.write_str("the bus is on again"),
            BusEvent::BusError { class } => write!(f, "bus error, classes {class:#X}"),
            BusEvent::Ignored { reason, frame } => write!(f, "ignored {frame}: {reason}"),
        }
    }
}
