//! State of exceptions: which are open and where they are, what is down, what is to be repeated.
//!
//! All of it follows from the records, like the rest of the state.

use std::collections::BTreeMap;

use linewright_line::{StationId, Tick};
use serde::{Deserialize, Serialize};

use super::super::ids::{AlarmId, FiringId, ModeId, OrderKey, PartId, ResourceId};
use super::super::serial;
use super::fact::{AlarmSubject, OutOfServiceReason, RecoveryDecision, SecuredState};

/// The exceptions of a cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exceptions {
    pub(super) open: BTreeMap<FiringId, FailedActivity>,
    pub(super) alarms: BTreeMap<AlarmId, Alarm>,
    pub(super) down: BTreeMap<ResourceId, OutOfService>,
    pub(super) retries: BTreeMap<(ModeId, Option<PartId>), Retry>,
    /// The stations in emergency stop, and because of which activity each went into it first.
    pub(super) stopped: BTreeMap<StationId, FiringId>,
    pub(super) last_alarm: u64,
    pub(super) scrapped: u64,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailedActivity {
    /// Time of entry into this state.
    #[serde(with = "serial::micros")]
    pub since: Tick,
    /// Standing of the stations that had to come to rest, where it is certain.
    pub standing: Vec<(OrderKey, SecuredState)>,
    /// The fault texts of stations at the moment in which they had come to rest. A station reports its fault no more when it has been led on, and
    /// alarms still name it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<(OrderKey, String)>,
    /// The stations that went into emergency stop because of it. Those that were reset since do not do so again.
    #[serde(default)]
    pub stopped: Vec<u16>,
    /// The stations that have come up without their memory since it failed: they may have completed their orders.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forgotten: Vec<u16>,
    /// Current stage.
    pub stage: ExceptionStage,
}

/// Stage of a failed activity.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ExceptionStage {
    /// Its stations are to come to rest.
    Securing,
    /// An alarm waits for its answer.
    Waiting(AlarmId),
    /// The answer is being compared with the sensors.
    Restoring {
        ruling: RecoveryDecision,
        /// Time at which the answer was accepted.
        #[serde(with = "serial::micros")]
        since: Tick,
    },
}

/// Something that a person has to look at. It stands until that is done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Alarm {
    /// Number of the alarm.
    pub id: AlarmId,
    /// Time of entry into this state.
    #[serde(with = "serial::micros")]
    pub since: Tick,
    pub about: AlarmSubject,
    /// Instruction as in ISA-18.2: what, where, consequence, action.
    /// As it was raised; [`super::super::Coordination::alarm_text`] is as things are now.
    pub text: String,
    pub words: Vec<String>,
    /// What was found after an answer, before the text of the failure; none where the text is another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finding: Option<String>,
}

/// A resource that is left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutOfService {
    /// Time of entry into this state.
    #[serde(with = "serial::micros")]
    pub since: Tick,
    pub why: OutOfServiceReason,
    /// Operators' name of the activity that the reason is about, with its part; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub activity: String,
}

/// Something that was done once more, or is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Retry {
    /// Number of repetitions begun, or due.
    pub times: u32,
    /// It has not started again yet.
    pub is_due: bool,
}

impl Exceptions {
    pub fn open(&self) -> impl ExactSizeIterator<Item = (FiringId, &FailedActivity)> {
        self.open.iter().map(|(&id, trouble)| (id, trouble))
    }

    pub fn trouble(&self, firing: FiringId) -> Option<&FailedActivity> {
        self.open.get(&firing)
    }

    /// Whether the stations of a failed activity are still to come to rest.
    pub(in super::super) fn is_securing(&self, firing: FiringId) -> bool {
        self.open.get(&firing).is_some_and(|trouble| trouble.stage == ExceptionStage::Securing)
    }

    /// The alarms that stand, by number.
    pub fn alarms(&self) -> impl ExactSizeIterator<Item = &Alarm> {
        self.alarms.values()
    }

    /// An alarm, if it stands.
    pub fn alarm(&self, alarm: AlarmId) -> Option<&Alarm> {
        self.alarms.get(&alarm)
    }

    /// The resources that are left out.
    pub fn down(&self) -> impl ExactSizeIterator<Item = (ResourceId, &OutOfService)> {
        self.down.iter().map(|(&id, down)| (id, down))
    }

    /// Reason why a resource is left out, if it is.
    pub fn is_down(&self, resource: ResourceId) -> Option<&OutOfService> {
        self.down.get(&resource)
    }

    /// The stations that are in emergency stop by themselves, whatever the mode of the line.
    pub fn stopped(&self) -> impl ExactSizeIterator<Item = StationId> {
        self.stopped.keys().copied()
    }

    /// Whether a station is in emergency stop by itself.
    pub fn is_stopped(&self, station: StationId) -> bool {
        self.stopped.contains_key(&station)
    }

    /// Number of parts scrapped.
    pub fn scrapped(&self) -> u64 {
        self.scrapped
    }

    /// Number of repetitions of a mode with a part since that came to where it is.
    pub fn times(&self, mode: ModeId, part: Option<PartId>) -> u32 {
        self.retries.get(&(mode, part)).map_or(0, |retry| retry.times)
    }

    /// Repetitions that are due and have not started yet.
    pub(in super::super) fn due_again(&self) -> impl Iterator<Item = (ModeId, Option<PartId>)> + '_ {
        self.retries.iter().filter(|(_, retry)| retry.is_due).map(|(&of, _)| of)
    }

    /// Whether stations of this order are not waited for to come to rest.
    pub(crate) fn stands(&self, firing: FiringId, key: OrderKey) -> Option<SecuredState> {
        let standing = &self.open.get(&firing)?.standing;
        standing.iter().find(|(of, _)| *of == key).map(|&(_, standing)| standing)
    }
}
