//! Requests of operators about alarms and resources, and why one is refused.

use linewright_line::StationId;

use super::super::ids::{AlarmId, ResourceId};

/// Presence of a part, by a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Presence {
    /// No sensor.
    #[default]
    NoSensor,
    /// A sensor whose image is not valid.
    Unread,
    /// The sensor sees a part.
    On,
    /// It sees none.
    Off,
}

impl Presence {
    /// Whether a sensor says something.
    pub fn is_known(self) -> bool {
        match self {
            Presence::On | Presence::Off => true,
            Presence::NoSensor | Presence::Unread => false,
        }
    }
}

/// Why a station could not do anything now. The mode of the line is none of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationUnavailable {
    /// Its node is not active: it follows no order.
    Inactive,
    /// Its devices are not there.
    Devices,
    /// An operation was stopped before its end.
    Incomplete,
    /// People move it.
    ByHand,
    /// A person leads it in manual while the others are in auto.
    InManual,
}

/// Request of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResourceRequest {
    /// To take an answer.
    Answer(AlarmId),
    /// To take an alarm of a resource.
    Alarm(ResourceId),
    /// To leave a resource out.
    Down(ResourceId),
    /// To count on a resource again.
    Up(ResourceId),
    /// To reset a station that is in emergency stop by itself.
    Reset(StationId),
}

/// Reason of its refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlarmAnswerRefusal {
    /// There is no such alarm, or not any more.
    NoSuchAlarm,
    /// It cannot be answered with this word.
    NoSuchWord,
    /// There is no such resource.
    NoSuchResource,
    /// It is already as requested.
    AlreadySo,
    /// A station is still at it.
    Moves(StationId),
    /// The resource has a part by its sensor, and by the answer it has none.
    HasPart(ResourceId),
    /// The resource has no part by its sensor, and by the answer it has one.
    HasNoPart(ResourceId),
    /// The station is not heard.
    NotHeard(StationId),
    /// A task-driven station of the activity is not heard, and this resource, by which it can be left out, is in service.
    Unheard(StationId, ResourceId),
    /// The station stands between two rests.
    NotAtRest(StationId),
    /// The station could not do anything.
    CannotWork(StationId, StationUnavailable),
    /// The resource's station stands at a rest from which nothing can be done with the resource as the model has it.
    WrongRest(ResourceId),
    /// The resource's sensor contradicts the model; it has an alarm.
    Contradicted(ResourceId),
    /// The resource's activity is open: its alarm has to be answered first.
    Open(ResourceId),
    /// The station is in emergency stop, and has to be reset first.
    EmergencyStop(StationId),
}
