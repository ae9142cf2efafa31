//! Events of a step, as values: the node logs and publishes them, a test compares them.

use linewright_line::net::{Block, ControlMode};
use linewright_line::{InputId, OpId, StationId, TaskId};

use crate::order::{TaskFailure, TaskRefusal};

/// Two different places of an axis with numbered places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlacesApart {
    /// The place it is measured at, or has left last.
    pub measured: u16,
    /// The place at which it stood last, or from which its index began.
    pub known: u16,
}

/// Reason why a motion stopped before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopCause {
    /// Its fault input came on.
    Signal,
    /// It took longer than its watchdog allows.
    Watchdog,
    /// It took longer than its watchdog allows, and its completion signal was on from the start: the switch is stuck.
    SwitchStuck,
    /// The same, and the switch of the end that it was to leave is still on.
    BothSwitchesOn {
        /// The switch of the end to be left.
        behind: InputId,
    },
    /// The station lost its devices.
    Devices,
    /// The button that held it was released, or manual mode ended under it.
    Released,
    /// Emergency stop.
    EStop,
    /// By an order to stop.
    Ordered,
    /// The controller was restarted in the middle of it.
    Restart,
    /// The station was switched on away from its home position.
    NotAtHome,
    /// Another station is not measured to be where this motion needs it.
    Interlock {
        /// The other station.
        station: StationId,
        /// Its switch that is off, or on at another place of the same axis; none where its image is not known.
        input: Option<InputId>,
        /// Whether that switch is on.
        is_on: bool,
    },
    /// An axis that should stand still is not measured where it should be.
    PositionLost {
        /// The operation whose place requires it.
        op: OpId,
        /// The switch that is off.
        input: InputId,
    },
    /// Whether an index is done is not known: its switch is on, and was not seen all the time, or came on too soon; or a drive
    /// measures another place.
    IndexDoubtful {
        /// The index.
        op: OpId,
        /// Its switch.
        input: InputId,
        /// Where a drive measures that its axis is at another place.
        places: Option<PlacesApart>,
    },
    /// Two exclusive transitions were both allowed: a bug of the controller, stopped rather than guessed at.
    Ambiguous,
}

impl StopCause {
    /// Whether it is a fault to the mode decision, or merely a stop by the operator.
    pub const fn is_fault(self) -> bool {
        !matches!(self, StopCause::Released)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HappeningKind {
    /// A motion started or went on.
    Started(OpId, Block),
    /// A motion is complete.
    Completed(OpId, Block),
    /// A motion stopped before its end.
    Stopped(OpId, Block, StopCause),
    /// The counts of these operations (a bit each) were taken back.
    Withdrawn(u64),
    /// The station is home after a recovery path: at the end of the previous cycle; if task-driven, at the rest where
    /// the task began.
    HomeAgain,
    /// A generation was founded: the station counts anew from home, together with the others.
    Founded,
    /// The marking was read off the switches, on an operator's confirmation.
    Rejoined,
    /// An axis that stands still by the chart is not measured there: the operation at whose place, and the switch.
    PositionLost(OpId, InputId),
    /// Whether an index is done is not known: the operation, its switch, and where it is measured at another place.
    IndexDoubtful(OpId, InputId, Option<PlacesApart>),
    /// All axes are measured where the chart has them again.
    PositionFound,
    /// Agreement was asked for, under this number.
    Asked(u64),
    /// A station did not agree, because this operation of its own has started.
    NotAgreed {
        /// Station that does not agree.
        by: StationId,
        /// Its operation.
        in_the_way: OpId,
    },
    /// A command had no effect in this state.
    Refused,
    /// The mode in force changed.
    Mode(ControlMode),
    /// The station's devices came back (true) or were lost (false).
    Devices(bool),
    /// It has taken on an order for a task.
    Ordered(TaskId),
    /// It has not, and will not.
    OrderRefused(TaskRefusal),
    /// It has done the task it was ordered to do.
    OrderDone(TaskId),
    /// It has not.
    OrderFailed(TaskId, TaskFailure),
    /// It was left on request, within its time, while it waited for inputs with this code.
    OrderLeft(TaskId, u16),
    /// It goes back to where the task began, as far as it can by itself.
    Securing(TaskId),
}

/// A happening and the cycle it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StationHappening {
    /// The station's cycle after it.
    pub cycle: i32,
    pub what: HappeningKind,
}
