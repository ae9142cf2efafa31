//! From any situation of a line, the shortest list of operator actions back to auto.
//!
//! A [`LineSituation`] is what a console sees: the mode, and each station's report. [`plan`] builds the real controllers and the
//! real mode decision from it, as after a restart with memory, and plays them: each press of a panel, each confirmation and each
//! command is a call of theirs. What a controller refuses is no step of a plan, so agreements, conflicts, interlocks and
//! irreversible operations are obeyed without being described again.
//!
//! One thing is assumed: a motion that starts while its button is held arrives. What no command can do (a device that is lost, a
//! fault signal, a released button) stands in the list as something to be done first.
//!
//! # Search
//! The mode's commands are tried in order of their number (`desk`). Where auto cannot be reached by commands alone, the
//! stations are moved in manual (`search`): shortest by number of presses, then by time of motion. *Resume* at the console, where
//! it leads on several stations, is one press. Only stations that keep auto
//! from being accepted are moved at first. Another one is added where a press is refused that reads its state, and where a way
//! through that could still be shorter. A lower bound for each station (`distance`) is its own way without the others.
//! The stations of one failed activity of a cell are led to the same end of it (`ends`), in the order in which they do their
//! operations or its reverse (`order`).
//! In auto a single one of them is led by itself, while the others go on (`beside`).
//! A station that an alarm asks to be brought to another rest is brought there by a button of hand mode (`bring`).
//! Stations whose part is left as it is on the way back are named, with their other way (`led_back`).
//! Why a found plan has its presses follows from playing it again (`reason`).
//! [`TRIED_MAX`] bounds the search; beyond it any plan is taken, and says that it may not be the shortest.

mod beside;
mod bring;
mod by_hand;
mod confirm;
mod desk;
mod distance;
mod ends;
mod first;
mod grouped;
mod image;
mod led_back;
mod order;
mod plan;
mod reason;
mod restore;
mod search;
mod situation;
mod step;
mod texts;
mod units;

pub use ends::{EndsReached, LedActivity, LedOrder};
pub use led_back::LedBack;
pub use plan::{RecoveryEnd, RecoveryPlan, plan};
pub use reason::StepReason;
pub use restore::RestoreMisfit;
pub use search::{TRIED_FOR_ANY_MAX, TRIED_MAX};
pub use situation::{
    ActivityEnd, ConsoleSituation, DecidedEnd, InterruptedTask, LineSituation, StandingAlarm, as_received,
};
pub use step::{
    ConfirmedNumber, Need, PanelButton, PlannedMotion, RecoveryAction, RecoveryStep, RejoinChoice, StationAfter,
};
