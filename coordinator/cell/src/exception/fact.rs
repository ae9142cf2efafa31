//! Records of an exception.

use linewright_line::StationId;
use serde::{Deserialize, Serialize};

use super::super::ids::{AlarmId, FiringId, ModeId, OrderKey, PartId, ResourceId};
use super::super::serial;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ExceptionStep {
    /// A station does nothing for an order of a failed activity any more, or is not waited for.
    Secured {
        firing: FiringId,
        key: OrderKey,
        /// Standing of its station.
        standing: SecuredState,
        /// Fault text of the station at that moment, without what to do about it; empty if it had no fault.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        fault: String,
    },
    /// An alarm is raised.
    Alarmed {
        alarm: AlarmId,
        about: AlarmSubject,
        /// Text for operators.
        text: String,
        words: Vec<String>,
        /// Of an alarm with the text of its activity's failure: what was found after an answer, which stands before that; else none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        finding: Option<String>,
    },
    /// An operator or a rule has given the true places, and the strategy.
    Answered {
        /// Its activity.
        firing: FiringId,
        ruling: RecoveryDecision,
        /// Source of the answer: operator, rule or sensor.
        by: AnsweredBy,
    },
    /// The carrier has the part and an operator has to bring it on: the activity's tokens are not given yet.
    Carried {
        /// Its activity.
        firing: FiringId,
    },
    /// An activity is over: tokens and part are where the ruling puts them.
    Closed {
        firing: FiringId,
        /// Net mode of the closed activity.
        mode: ModeId,
        /// The part it had.
        part: Option<PartId>,
        ruling: RecoveryDecision,
        /// Resources without a sensor that confirms it.
        unchecked: Vec<ResourceId>,
    },
    /// Sensors contradict.
    Mismatch {
        /// Subject of the finding.
        about: AlarmSubject,
        /// Their contradictions.
        found: Vec<SensorMismatch>,
    },
    /// A part that rested at a resource is no more. The tokens of a mode that would take it from there are given back as for
    /// a lost part.
    Missing {
        /// Resource where the part was.
        resource: ResourceId,
        mode: ModeId,
        part: PartId,
    },
    /// A station goes into emergency stop, and stays in it until it is reset.
    Stopped {
        /// The failed activity with the rule.
        firing: FiringId,
        #[serde(with = "serial::station")]
        station: StationId,
    },
    /// Reset by an operator.
    Reset {
        #[serde(with = "serial::station")]
        station: StationId,
    },
    /// A resource is left out.
    Down {
        resource: ResourceId,
        why: OutOfServiceReason,
        /// Operators' name of the activity that the reason is about, with its part; may be empty.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        activity: String,
    },
    /// A resource is there again.
    Up {
        resource: ResourceId,
        /// No sensor confirms that its part is there.
        unchecked: bool,
    },
}

impl ExceptionStep {
    /// Whether it changes places of tokens and parts, or which resources are there: reports and schedules follow these steps.
    pub(in super::super) fn changes_the_cell(&self) -> bool {
        match self {
            ExceptionStep::Closed { .. }
            | ExceptionStep::Missing { .. }
            | ExceptionStep::Down { .. }
            | ExceptionStep::Up { .. } => true,
            ExceptionStep::Secured { .. }
            | ExceptionStep::Alarmed { .. }
            | ExceptionStep::Answered { .. }
            | ExceptionStep::Carried { .. }
            | ExceptionStep::Mismatch { .. }
            | ExceptionStep::Stopped { .. }
            | ExceptionStep::Reset { .. } => false,
        }
    }
}

/// Subject of an alarm or a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum AlarmSubject {
    /// An activity that has failed.
    Firing(FiringId),
    /// A resource by itself.
    Resource(ResourceId),
}

/// Standing of a station after the order to leave an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum SecuredState {
    AtRest,
    /// Between rests, from where it does not go on by itself.
    Held,
    /// It has not reported to have come to rest in time.
    Unknown,
}

/// Place of a part, and strategy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecoveryDecision {
    /// The word that was answered.
    pub word: String,
    pub part: Whereabouts,
    /// Strategy that follows.
    pub then: Strategy,
}

/// Place of a part after a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Whereabouts {
    /// At the resource it came from.
    From,
    /// Its destination.
    To,
    Carrier,
    /// Nowhere any more.
    Gone,
}

/// Continuation after a failure. The source names the three (seed 000, L3101-3104); their meaning here is ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The same once more, from its beginning.
    Redo,
    /// As it was before; then it is decided anew.
    Backward,
    /// As if it were done.
    Forward,
}

/// Source of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnsweredBy {
    /// The description, in which the rule is automatic.
    Rule,
    /// A person.
    Operator,
}

/// A sensor that contradicts the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorMismatch {
    /// Resource whose sensor disagrees.
    pub resource: ResourceId,
    /// Whether there should be a part.
    pub model: bool,
    /// Whether the sensor sees a part.
    pub plant: bool,
}

/// Reason why a resource is left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum OutOfServiceReason {
    /// Taken out by an operator.
    ByHand {
        /// Always empty; logs from before alarms had a cause of their own have a text.
        text: String,
    },
    /// Alarm given by an operator: nothing that it takes part in may move by itself.
    Alarm {
        /// Reason; empty if none was given.
        text: String,
    },
    /// By the rule by which an activity was closed.
    Rule(FiringId),
    /// Its station could not come to rest, or could not work, when an activity was closed.
    Station(FiringId),
    /// A task-driven station of this activity was not heard when it was closed: it may stand in the resource.
    Unheard(FiringId),
    /// Its sensor contradicts the model.
    Mismatch,
    /// Its station stands at a rest where nothing can be done with it as the model has it.
    Rest,
    /// Its station went into emergency stop when this activity failed.
    EmergencyStop(FiringId),
}

impl OutOfServiceReason {
    /// The activity by which the resource was left out.
    pub(super) fn firing(&self) -> Option<FiringId> {
        match *self {
            OutOfServiceReason::Rule(firing)
            | OutOfServiceReason::Station(firing)
            | OutOfServiceReason::Unheard(firing)
            | OutOfServiceReason::EmergencyStop(firing) => Some(firing),
            OutOfServiceReason::ByHand { .. }
            | OutOfServiceReason::Alarm { .. }
            | OutOfServiceReason::Mismatch
            | OutOfServiceReason::Rest => None,
        }
    }

    /// Alarm was given.
    pub fn is_alarm(&self) -> bool {
        match self {
            OutOfServiceReason::Alarm { .. } => true,
            OutOfServiceReason::ByHand { .. }
            | OutOfServiceReason::Rule(_)
            | OutOfServiceReason::Station(_)
            | OutOfServiceReason::Unheard(_)
            | OutOfServiceReason::Mismatch
            | OutOfServiceReason::Rest
            | OutOfServiceReason::EmergencyStop(_) => false,
        }
    }
}
