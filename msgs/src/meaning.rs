//! Validity of a message besides its lengths.
//!
//! The list of the messages that are checked here is in `build/generate/write.rs`; all others are valid as they are.

use crate::invalid::{indices, parallel, present, within};
use crate::{
    Answer, CellState, Invalid, LineState, ModeOrder, OrderEnd, OrderState, ProcessImage, ProductionState, RosMessage,
    RunTaskFeedback, RunTaskGoal, RunTaskResult, SecureOrder, SetResourceRequest, StationEvent, StationState,
    SubmitOrdersRequest,
};

/// Checked when a message is received.
pub(crate) trait Meaning {
    /// Checks its meaning.
    fn meaning(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

impl Meaning for Answer {
    fn meaning(&self) -> Result<(), Invalid> {
        present("station", !self.station.is_empty())?;
        present("boot_id", self.boot_id != 0)?;
        present("request_number", self.request_number != 0)
    }
}

impl Meaning for StationState {
    fn meaning(&self) -> Result<(), Invalid> {
        present("boot_id", self.boot_id != 0)?;
        present("station", !self.station.is_empty())?;
        mode(self.mode)?;
        within("lifecycle", self.lifecycle, StationState::LIFECYCLE_UNCONFIGURED, StationState::LIFECYCLE_FINALIZED)?;
        parallel(("started", self.started.len()), ("done", self.done.len()))?;
        parallel(("places", self.places.len()), ("done", self.done.len()))?;
        for &place in &self.places {
            within("places", place, StationState::PLACE_NONE, StationState::PLACE_UNDONE)?;
        }
        indices("incomplete", &self.incomplete, self.done.len())?;
        parallel(("stop_causes", self.stop_causes.len()), ("incomplete", self.incomplete.len()))?;
        for &cause in &self.stop_causes {
            within("stop_causes", cause, StationState::CAUSE_SIGNAL, StationState::CAUSE_AMBIGUOUS)?;
        }
        indices("request_operations", &self.request_operations, self.done.len())?;
        self.answers.iter().try_for_each(RosMessage::validate)
    }
}

impl Meaning for StationEvent {
    fn meaning(&self) -> Result<(), Invalid> {
        present("station", !self.station.is_empty())
    }
}

impl Meaning for ProcessImage {
    fn meaning(&self) -> Result<(), Invalid> {
        present("boot_id", self.boot_id != 0)
    }
}

impl Meaning for ModeOrder {
    fn meaning(&self) -> Result<(), Invalid> {
        present("boot_id", self.boot_id != 0)?;
        mode(self.mode)
    }
}

impl Meaning for LineState {
    fn meaning(&self) -> Result<(), Invalid> {
        present("boot_id", self.boot_id != 0)?;
        mode(self.mode)?;
        parallel(("station_heard", self.station_heard.len()), ("stations", self.stations.len()))
    }
}

fn mode(mode: u8) -> Result<(), Invalid> {
    within("mode", mode, StationState::MODE_STANDBY, StationState::MODE_HOME)
}

impl Meaning for RunTaskGoal {
    fn meaning(&self) -> Result<(), Invalid> {
        present("epoch", self.epoch != 0)?;
        present("id", self.id != 0)?;
        present("task", !self.task.is_empty())?;
        parallel(("parameters", self.parameters.len()), ("parameter_names", self.parameter_names.len()))
    }
}

impl Meaning for RunTaskResult {
    fn meaning(&self) -> Result<(), Invalid> {
        ending(self.end, self.code)
    }
}

impl Meaning for RunTaskFeedback {
    fn meaning(&self) -> Result<(), Invalid> {
        phase(self.phase)
    }
}

fn phase(phase: u8) -> Result<(), Invalid> {
    within("phase", phase, RunTaskFeedback::PHASE_RUNNING, RunTaskFeedback::PHASE_SECURING)
}

impl Meaning for OrderEnd {
    fn meaning(&self) -> Result<(), Invalid> {
        present("epoch", self.epoch != 0)?;
        present("id", self.id != 0)?;
        ending(self.end, self.code)
    }
}

/// Checks that an end is known, with a code where one belongs.
fn ending(end: u8, code: u16) -> Result<(), Invalid> {
    within("end", end, RunTaskResult::END_DONE, RunTaskResult::END_REFUSED)?;
    let coded = [RunTaskResult::END_FAILED, RunTaskResult::END_REFUSED].contains(&end);
    present("code", !coded || code != 0)
}

impl Meaning for OrderState {
    fn meaning(&self) -> Result<(), Invalid> {
        present("boot_id", self.boot_id != 0)?;
        present("station", !self.station.is_empty())?;
        present("memory", self.memory != 0)?;
        match (self.doing_epoch, self.doing_id) {
            (0, 0) => within("phase", self.phase, 0, 0)?,
            (epoch, id) => {
                present("doing_epoch", epoch != 0)?;
                present("doing_id", id != 0)?;
                phase(self.phase)?;
            }
        }
        for end in self.ended.as_slice() {
            end.validate()?;
            within("ended: end", end.end, RunTaskResult::END_DONE, RunTaskResult::END_SECURED)?;
        }
        for end in self.refused.as_slice() {
            end.validate()?;
            within("refused: end", end.end, RunTaskResult::END_REFUSED, RunTaskResult::END_REFUSED)?;
        }
        Ok(())
    }
}

impl Meaning for SecureOrder {
    fn meaning(&self) -> Result<(), Invalid> {
        present("epoch", self.epoch != 0)?;
        present("id", self.id != 0)
    }
}

impl Meaning for ProductionState {
    fn meaning(&self) -> Result<(), Invalid> {
        within("status", self.status, Self::STATUS_WAITING, Self::STATUS_WITHDRAWN)
    }
}

impl Meaning for CellState {
    fn meaning(&self) -> Result<(), Invalid> {
        present("boot_id", self.boot_id != 0)?;
        present("cell", !self.cell.is_empty())?;
        self.orders.as_slice().iter().try_for_each(RosMessage::validate)
    }
}

/// Faults of a request are reported in the answer, all together.
impl Meaning for SubmitOrdersRequest {
    fn meaning(&self) -> Result<(), Invalid> {
        self.requests.iter().try_for_each(RosMessage::validate)
    }
}

impl Meaning for SetResourceRequest {
    fn meaning(&self) -> Result<(), Invalid> {
        within("what", self.what, Self::ALARM, Self::RESET)
    }
}
