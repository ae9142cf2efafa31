//! What stations that work on order are told and tell: the action `RunTask`, and `OrderState`.
//!
//! The action is the door, the state is the truth: whoever gives orders gives them until the state shows that they have
//! been heard, and reads from the state how they ended. So nothing depends on a single message.

use crate::describe::{Bounded, RosMessage};
use crate::invalid::{parallel, present, within};
use crate::macros::message;
use crate::{Header, Invalid};

/// A ROS 2 action: what is wanted, how it ended, and how far it is.
pub trait RosAction: Send + Sync + 'static {
    /// ROS 2 package.
    const PACKAGE: &'static str;
    /// Name within the package.
    const NAME: &'static str;
    /// What is wanted.
    type Goal: RosMessage + Clone;
    /// How it ended.
    type Result: RosMessage + Clone + Default;
    /// How far it is.
    type Feedback: RosMessage + Clone;
}

/// `linewright_msgs/RunTask`.
#[derive(Debug, Clone, Copy)]
pub struct RunTask;

impl RosAction for RunTask {
    const PACKAGE: &'static str = crate::PACKAGE;
    const NAME: &'static str = "RunTask";
    type Goal = RunTaskGoal;
    type Result = RunTaskResult;
    type Feedback = RunTaskFeedback;
}

message! {
    /// An order to a station: do one task, from one rest of the station to another.
    "linewright_msgs" / RunTaskGoal
    fields {
        /// The memory of the station that it is meant for ([`OrderState::memory`]).
        memory: u64,
        /// The life of whoever gives it, from 1.
        epoch: u64,
        /// Its number, from 1, never used twice.
        id: u64,
        /// Which task of the station's description.
        task: String,
        /// Names of its parameters.
        parameter_names: Vec<String>,
        /// Their values.
        parameters: Vec<i32>,
        /// The part it is about, for people.
        part: String,
        /// How much time is left until it must have ended, from when it is heard, in milliseconds.
        limit_ms: u32,
    }
    ros name "RunTask_Goal", meaning |m| {
        present("epoch", m.epoch != 0)?;
        present("id", m.id != 0)?;
        present("task", !m.task.is_empty())?;
        parallel(("parameters", m.parameters.len()), ("parameter_names", m.parameter_names.len()))
    }
}

message! {
    /// How an order has ended.
    "linewright_msgs" / RunTaskResult
    constants {
        /// The task is done: the activity-end of seed 001 (L131-185).
        const END_DONE: u8 = 0;
        /// It ended with an error code.
        const END_FAILED: u8 = 1;
        /// It was cancelled, and nothing is left half-way.
        const END_SECURED: u8 = 2;
        /// It was not taken on.
        const END_REFUSED: u8 = 3;
        /// Another order is being done.
        const REFUSED_BUSY: u16 = 1;
        /// The station is not in auto, or not enabled.
        const REFUSED_MODE: u16 = 2;
        /// Its memory is not the one the order was meant for.
        const REFUSED_OTHER_MEMORY: u16 = 3;
        /// It knows a later epoch.
        const REFUSED_OLD_EPOCH: u16 = 4;
        /// It has had the order and no longer knows how it ended.
        const REFUSED_OLD: u16 = 5;
        /// There is no time left to do it in.
        const REFUSED_LATE: u16 = 6;
        /// The station does not stand where the task begins.
        const REFUSED_NOT_THERE: u16 = 7;
        /// Its devices are not there.
        const REFUSED_DEVICES: u16 = 8;
        /// It has no such task, or the task no such parameter.
        const REFUSED_UNKNOWN: u16 = 9;
        /// An operation was stopped before its end.
        const REFUSED_INCOMPLETE: u16 = 10;
        /// The station is left out until somebody has looked after it.
        const REFUSED_ISOLATED: u16 = 11;
    }
    fields {
        /// The order's epoch.
        epoch: u64,
        /// Id part of the task order's key.
        id: u64,
        /// How it has ended.
        end: u8,
        /// Failed: up to 999 the code of the description, above that why. Refused: why. Else 0.
        code: u16,
        /// The same for people.
        text: String,
    }
    ros name "RunTask_Result", meaning |m| ending(m.end, m.code)
}

message! {
    /// How far an order is.
    "linewright_msgs" / RunTaskFeedback
    constants {
        /// It is being done.
        const PHASE_RUNNING: u8 = 1;
        /// On its way to where nothing is left half-way.
        const PHASE_SECURING: u8 = 2;
    }
    fields {
        /// What it is doing of it.
        phase: u8,
        /// The operation under way, by its name in the description.
        operation: String,
        /// Which step of the task it is, from 1.
        step: u16,
        /// How many there are.
        steps: u16,
    }
    ros name "RunTask_Feedback", meaning |m| {
        within("phase", m.phase, RunTaskFeedback::PHASE_RUNNING, RunTaskFeedback::PHASE_SECURING)
    }
}

message! {
    /// How an order has ended, or why it was not taken on.
    "linewright_msgs" / OrderEnd
    fields {
        /// The order's epoch.
        epoch: u64,
        /// Id part of the task order's key.
        id: u64,
        /// How ([`RunTaskResult`]).
        end: u8,
        /// The code that goes with it.
        code: u16,
    }
    ros name "OrderEnd", meaning |m| {
        present("epoch", m.epoch != 0)?;
        present("id", m.id != 0)?;
        ending(m.end, m.code)
    }
}

message! {
    /// What a station that works on order knows of its orders: latched, sent on change and at a fixed rate.
    "linewright_msgs" / OrderState
    fields {
        /// Stamp of the sender.
        header: Header,
        /// New with every start of the process; never 0.
        boot_id: u64,
        /// Of the message within that life.
        sequence: u64,
        /// Station whose order is to be left.
        station: String,
        /// New when the station has forgotten the orders it had; never 0.
        memory: u64,
        /// Newest epoch in which it was given an order that it has taken on; 0: none yet.
        epoch: u64,
        /// The order it is doing; 0: none.
        doing_epoch: u64,
        /// Likewise.
        doing_id: u64,
        /// What it is doing of it ([`RunTaskFeedback`]); 0 if it is doing none.
        phase: u8,
        /// The order that it was last told to leave; 0: none since the process began. What the message says is from after
        /// that.
        secured_epoch: u64,
        /// Likewise.
        secured_id: u64,
        /// The rest it stands at; empty while it moves and between rests.
        rest: String,
        /// How the last orders that it took on have ended, the oldest first.
        ended: Bounded<OrderEnd, 16>,
        /// The last orders that it did not take on, and why not, the oldest first.
        refused: Bounded<OrderEnd, 16>,
        /// Its inputs, the first of the description in bit 0 of byte 0; empty while they are not known.
        inputs: Bounded<u8, 16>,
    }
    ros name "OrderState", meaning |m| {
        present("boot_id", m.boot_id != 0)?;
        present("station", !m.station.is_empty())?;
        present("memory", m.memory != 0)?;
        match (m.doing_epoch, m.doing_id) {
            (0, 0) => within("phase", m.phase, 0, 0)?,
            (epoch, id) => {
                present("doing_epoch", epoch != 0)?;
                present("doing_id", id != 0)?;
                within("phase", m.phase, RunTaskFeedback::PHASE_RUNNING, RunTaskFeedback::PHASE_SECURING)?;
            }
        }
        for end in m.ended.as_slice() {
            end.validate()?;
            within("ended: end", end.end, RunTaskResult::END_DONE, RunTaskResult::END_SECURED)?;
        }
        for end in m.refused.as_slice() {
            end.validate()?;
            within("refused: end", end.end, RunTaskResult::END_REFUSED, RunTaskResult::END_REFUSED)?;
        }
        Ok(())
    }
}

message! {
    /// To a station that works on order: leave this order be, and go back to the rest where its task began, as far as that
    /// goes by itself; or stop at once, and stand where it is.
    "linewright_msgs" / SecureOrder
    fields {
        /// The order's epoch.
        epoch: u64,
        /// Id part of the task order's key.
        id: u64,
        /// Nothing of it moves any more, neither on nor back.
        stop: bool,
    }
    ros name "SecureOrder", meaning |m| {
        present("epoch", m.epoch != 0)?;
        present("id", m.id != 0)
    }
}

/// An end that is known, with a code where one belongs.
fn ending(end: u8, code: u16) -> Result<(), Invalid> {
    within("end", end, RunTaskResult::END_DONE, RunTaskResult::END_REFUSED)?;
    let coded = [RunTaskResult::END_FAILED, RunTaskResult::END_REFUSED].contains(&end);
    present("code", !coded || code != 0)
}
