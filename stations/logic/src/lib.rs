//! One station's controller: process image, views of other stations and commands in; outputs and events out.
//!
//! [`Controller::handle`] takes what has arrived, [`Controller::step`] plays the station's net one image further and
//! gives the output image, [`Controller::next_deadline`] says when to step again if nothing arrives. There is no
//! clock, no thread and no message format here: the same code runs in a node, in a simulation and under a checker.
//!
//! The net comes from [`linewright_line::net`]; here it is compiled to tables (`program`) and played.
//! What the paper does not have — counted internal variables, and taking a count back only when every station that
//! could build on it has agreed — is in `views` and `withdraw`; which counts may be compared, in `generation`; the check of
//! measured positions, which needs no memory, in `interlock`. A station that works on order has `slot` besides.

mod controller;
mod drive;
mod event;
mod explain;
mod fire;
mod generation;
mod interlock;
mod order;
mod order_words;
mod panel;
mod program;
mod report;
mod restore;
mod rules;
mod situation;
mod slot;
mod step;
mod tasks;
mod views;
mod withdraw;
mod words;

pub use controller::{Controller, Input, NO_DELAY, Outbox};
pub use event::{Cause, Event, Happening};
pub use explain::DEVICES_INVALID;
pub use generation::Founding;
pub use interlock::{OwnSide, PositionGuard, PositionsKnown};
pub use order::{
    Failure, OrderKey, OrderMemory, OrderReport, Outcome, RESULTS_MAX, Refusal, Reply, SlotReport, TaskCommand,
    TaskOrder,
};
pub use panel::{Contest, ModeOrder, PanelCommand};
pub use program::{CompileError, Program};
pub use report::{Answer, Report, Request, Restore, Snapshot};
pub use rules::{OrderRules, Rules};
pub use situation::{Held, Writer};
