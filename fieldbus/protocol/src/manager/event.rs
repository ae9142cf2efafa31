//! Events that the manager reports, and its outbox.

use std::time::Duration;

use linewright_line::{FrameId, Owner};

use super::boot::BootError;
use super::device_request::RequestResult;
use super::fault::{ChannelFault, FrameFault, IgnoreReason};
use crate::codec::{Emergency, NmtState, NodeId, Profile};
use crate::frame::Frame;

/// Frames to send, in order, and events to report, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BusOutbox {
    /// To be sent on the manager's bus.
    pub frames: Vec<Frame>,
    pub events: Vec<BusEvent>,
    /// Results of requests ([`Manager::ask`](super::Manager::ask)), each with a [`BusEvent::Answered`].
    pub answers: Vec<(u64, RequestResult)>,
}

/// Event for the owner of a manager.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusEvent {
    /// The device is configured and operational; it exchanges process data from here on.
    DeviceUp {
        node: NodeId,
    },
    /// The device has not sent a heartbeat for too long.
    DeviceLost {
        node: NodeId,
        silent_for: Duration,
    },
    /// The device receives no SYNC: the inputs that come with it have not come for too long.
    NoSync {
        node: NodeId,
        silent_for: Duration,
    },
    /// Nothing follows any more from an analogue channel of the device, and with it from the device.
    ChannelFault {
        node: NodeId,
        fault: ChannelFault,
    },
    /// A device without CANopen is live: all its messages come.
    FramesUp {
        /// The last of its messages that came.
        id: FrameId,
    },
    /// It is lost: a message of it has not come in time.
    FramesLost {
        /// Frame identifier of the sender.
        id: FrameId,
        silent_for: Duration,
        /// Fault of those that come.
        why: FrameFault,
    },
    /// The device has booted while it counted as running.
    DeviceRebooted {
        node: NodeId,
    },
    /// The device has left the operational state without booting.
    DeviceLeft {
        node: NodeId,
        state: NmtState,
    },
    /// The device is not started: it is another one than expected, or does not accept a setting. A device that does not
    /// watch the manager's heartbeat would keep its outputs when the manager is gone.
    BootFailed {
        node: NodeId,
        why: BootError,
    },
    /// The device reports an error, or that its errors are gone.
    Emergency {
        node: NodeId,
        emergency: Emergency,
        /// Device kind, by the description.
        profile: Profile,
    },
    /// The device's error register has changed: an error stands that no emergency has reported, or the last one is gone
    /// and its emergency was not received.
    ErrorRegister {
        node: NodeId,
        /// Object 1001h; 0 is no error.
        register: u8,
    },
    /// The device sends so much that its frames are ignored.
    Babbles {
        node: NodeId,
    },
    /// An owner's input image has changed, or whether it can be trusted has.
    InputsChanged {
        owner: Owner,
    },
    Answered {
        number: u64,
    },
    /// Another node sends the manager's heartbeat: two managers are on this bus. Reported every few seconds.
    AnotherManager,
    /// The other manager is silent; the devices are brought up anew.
    AloneAgain,
    /// The kernel reports trouble on the bus.
    BusError {
        /// Class bits of `linux/can/error.h`; 0x40 is bus-off, 0x100 that the interface is on the bus again.
        class: u32,
    },
    Ignored {
        reason: IgnoreReason,
        frame: Frame,
    },
}
