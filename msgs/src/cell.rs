//! What people and programs say to the coordinator of a flexible cell, and what it says of it.
//!
//! Production orders are asked for, changed and explained by services. Everything that is known of the cell goes out as one
//! whole state, again and again, so that nothing depends on a single message. Lists are cut off rather than sent in parts:
//! a cell with more than a hundred parts is looked at in its database.

use crate::describe::{Bounded, RosMessage};
use crate::invalid::{present, within};
use crate::macros::{message, service};
use crate::{Header, Time};

/// The most entries of each list of a [`CellState`].
pub const LISTED_MAX: usize = 100;

message! {
    /// Something that is to be made in a cell.
    "linewright_msgs" / ProductionRequest
    fields {
        /// Drawn at random by whoever asks, 16 bytes: the same request twice is one order. Empty: one is drawn.
        key: Bounded<u8, 16>,
        /// What people call it.
        name: String,
        /// One of the part types of the cell.
        product: String,
        /// Number of parts, from 1.
        quantity: u32,
        /// Nothing of it enters before this; 0: at once.
        release: Time,
        /// When all of it is to be finished; 0: it does not matter.
        due: Time,
        /// More comes first.
        priority: i32,
        /// Orders that have to be over before anything of it enters, by name.
        after: Vec<String>,
    }
    // What is wrong with it is answered, with all else that is.
    ros name "ProductionRequest", meaning |_| Ok(())
}

message! {
    /// A production order, and what has become of it.
    "linewright_msgs" / ProductionState
    constants {
        /// Nothing of it may enter yet.
        const STATUS_WAITING: u8 = 1;
        /// Its parts may enter.
        const STATUS_RELEASED: u8 = 2;
        /// Some have.
        const STATUS_IN_WORK: u8 = 3;
        /// All of it has left.
        const STATUS_DONE: u8 = 4;
        /// Nothing more of it enters.
        const STATUS_CANCELLED: u8 = 5;
        /// As if it had never been.
        const STATUS_WITHDRAWN: u8 = 6;
    }
    fields {
        /// Number of the production order.
        id: u64,
        /// What people call it.
        name: String,
        /// What is made.
        product: String,
        /// Number of parts, from 1.
        quantity: u32,
        /// How many are inside or have left.
        entered: u32,
        /// How many have left.
        done: u32,
        /// How many were lost, and are replaced.
        lost: u32,
        /// State, one of the constants.
        status: u8,
        /// The same for people.
        text: String,
        /// When it is due; 0: never.
        due: Time,
        /// When it was over; 0: not yet.
        ended: Time,
    }
    ros name "ProductionState", meaning |m| {
        within("status", m.status, ProductionState::STATUS_WAITING, ProductionState::STATUS_WITHDRAWN)
    }
}

message! {
    /// A part in a cell.
    "linewright_msgs" / PartState
    fields {
        /// Number of the part.
        id: u64,
        /// How far it is.
        stage: String,
        /// Where it is, for people.
        place: String,
        /// Time since which it is there.
        since: Time,
        /// The production order it counts to; 0: none.
        order: u64,
    }
    ros name "PartState", meaning |_| Ok(())
}

message! {
    /// An activity in progress in a cell.
    "linewright_msgs" / ActivityState
    fields {
        /// Number of the activity.
        id: u64,
        /// Name of the activity.
        name: String,
        /// Its part; 0: none.
        part: u64,
        /// When it started.
        began: Time,
        /// It goes on; else somebody has to see to it.
        running: bool,
        /// What it waits for, for people.
        text: String,
    }
    ros name "ActivityState", meaning |_| Ok(())
}

message! {
    /// Something that a person has to see to.
    "linewright_msgs" / AlarmState
    fields {
        /// Number of the alarm.
        id: u64,
        /// Time at which it was raised.
        raised: Time,
        /// What has happened, and what to do.
        text: String,
        /// What can be answered, when it is done.
        answers: Vec<String>,
    }
    ros name "AlarmState", meaning |_| Ok(())
}

message! {
    /// All of a flexible cell: latched, sent on change and at a fixed rate.
    "linewright_msgs" / CellState
    fields {
        /// Stamp of the sender.
        header: Header,
        /// New with every start of the process; never 0.
        boot_id: u64,
        /// Of the message within that life.
        sequence: u64,
        /// Name of the cell.
        cell: String,
        /// The coordinator's life, from 1, rising over its restarts.
        epoch: u64,
        /// Activities may start.
        starting: bool,
        /// How many parts are in it.
        parts_inside: u32,
        /// How many have left.
        parts_left: u64,
        /// How many production orders are not over.
        orders_open: u32,
        /// Those of longest standing first.
        parts: Bounded<PartState, 100>,
        /// What is in progress.
        activities: Bounded<ActivityState, 100>,
        /// Those that are not over first, then those that were over last.
        orders: Bounded<ProductionState, 100>,
        /// What somebody has to see to.
        alarms: Bounded<AlarmState, 100>,
        /// Resources that are out of use.
        down: Bounded<String, 100>,
    }
    ros name "CellState", meaning |m| {
        present("boot_id", m.boot_id != 0)?;
        present("cell", !m.cell.is_empty())?;
        m.orders.as_slice().iter().try_for_each(RosMessage::validate)
    }
}

service! {
    /// Makes orders of requests, all of them or none.
    "linewright_msgs" / SubmitOrders = SubmitOrdersRequest -> SubmitOrdersResponse
}

message! {
    /// What is asked for.
    "linewright_msgs" / SubmitOrdersRequest
    fields {
        /// Orders to be made, all or none.
        requests: Vec<ProductionRequest>,
    }
    ros name "SubmitOrders_Request", meaning |m| m.requests.iter().try_for_each(RosMessage::validate)
}

message! {
    /// Whether it is on order now.
    "linewright_msgs" / SubmitOrdersResponse
    fields {
        /// True if all orders were accepted.
        accepted: bool,
        /// The orders' numbers, in the order of the requests.
        ids: Vec<u64>,
        /// All that is wrong with any of them.
        problems: Vec<String>,
    }
    ros name "SubmitOrders_Response", meaning |_| Ok(())
}

service! {
    /// Cancels or withdraws a production order, whichever the service is called.
    "linewright_msgs" / ChangeOrder = ChangeOrderRequest -> ChangeOrderResponse
}

message! {
    /// Order to be changed.
    "linewright_msgs" / ChangeOrderRequest
    fields {
        /// What people call it.
        name: String,
    }
    ros name "ChangeOrder_Request", meaning |_| Ok(())
}

message! {
    /// Whether it was done.
    "linewright_msgs" / ChangeOrderResponse
    fields {
        /// It was.
        done: bool,
        /// Reason, for operators.
        reason: String,
    }
    ros name "ChangeOrder_Response", meaning |_| Ok(())
}

service! {
    /// Why a part or a production order does not go on, or a resource is left out.
    "linewright_msgs" / WhyNot = WhyNotRequest -> WhyNotResponse
}

message! {
    /// About what.
    "linewright_msgs" / WhyNotRequest
    fields {
        /// `part 7`, or a name.
        about: String,
    }
    ros name "WhyNot_Request", meaning |_| Ok(())
}

message! {
    /// Reasons, one a line.
    "linewright_msgs" / WhyNotResponse
    fields {
        /// There is such a thing.
        known: bool,
        /// One reason each.
        lines: Vec<String>,
    }
    ros name "WhyNot_Response", meaning |_| Ok(())
}

service! {
    /// What an alarm asked for has been done.
    "linewright_msgs" / AnswerAlarm = AnswerAlarmRequest -> AnswerAlarmResponse
}

message! {
    /// What is true now.
    "linewright_msgs" / AnswerAlarmRequest
    fields {
        /// The alarm's number.
        alarm: u64,
        /// One of its answers.
        word: String,
        /// Operator, free text.
        by: String,
    }
    ros name "AnswerAlarm_Request", meaning |_| Ok(())
}

message! {
    /// Whether it is believed.
    "linewright_msgs" / AnswerAlarmResponse
    fields {
        /// True if the request was carried out.
        accepted: bool,
        /// Reason, for operators.
        reason: String,
    }
    ros name "AnswerAlarm_Response", meaning |_| Ok(())
}

service! {
    /// What a person says of a resource.
    "linewright_msgs" / SetResource = SetResourceRequest -> SetResourceResponse
}

message! {
    /// What is true of it.
    "linewright_msgs" / SetResourceRequest
    constants {
        /// Something is wrong with it: what it is doing is stopped and has failed, and it is left out from then on.
        const ALARM: u8 = 0;
        /// It is left out from now on. What it is doing it finishes.
        const DOWN: u8 = 1;
        /// It is counted on again.
        const UP: u8 = 2;
        /// Its station, which went into emergency stop by itself when something failed, follows the line's mode again.
        const RESET: u8 = 3;
    }
    fields {
        /// Its name in the cell's description.
        resource: String,
        /// One of the above.
        what: u8,
        /// For an alarm: what is wrong.
        text: String,
        /// Operator, free text.
        by: String,
    }
    ros name "SetResource_Request", meaning |m| within("what", m.what, Self::ALARM, Self::RESET)
}

message! {
    /// Whether it is done.
    "linewright_msgs" / SetResourceResponse
    fields {
        /// True if the request was carried out.
        accepted: bool,
        /// Reason, for operators.
        reason: String,
    }
    ros name "SetResource_Response", meaning |_| Ok(())
}
