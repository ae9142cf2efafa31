//! One station's controller: process image, views of other stations and commands in; outputs and events out.
//!
//! # Contract
//! The caller owns the clock, the devices and the messages. In a loop it
//!
//! 1. hands over everything that has arrived: [`Controller::handle`],
//! 2. plays one step: [`Controller::step`],
//! 3. puts out [`StationOutbox::outputs`], sends [`Controller::report`] to the other stations if [`StationOutbox::changed`], and drains
//!    [`StationOutbox::events`] and [`StationOutbox::replies`],
//! 4. sleeps until something arrives, at most until [`Controller::next_deadline`].
//!
//! The same code runs in a node, in a simulation and under a checker. An input that does not apply changes nothing, and
//! [`Handled`] gives the reason. After a restart the caller restores [`Controller::snapshot`]; it has to be stored before the
//! outputs of the step are put out ([`Restore`]).
//!
//! ```
//! use std::time::Duration;
//! use linewright_line::{StationId, Tick, net::ControlMode, parse};
//! use linewright_station_logic::{Controller, StationInput, ModeOrder, NO_DELAY, StationOutbox, Restore};
//!
//! # let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/feeder.toml"));
//! // A cylinder that pushes and pulls: inputs 0 and 1 are its limit switches, outputs 0 and 1 pull and push.
//! let line = parse("feeder.toml", text).expect("a line without mistakes").line;
//! let mut controller = Controller::new(&line, StationId(0), 1, Restore::Fresh)?;
//! let mut out = StationOutbox::default();
//! let image = |bits| StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: NO_DELAY };
//!
//! // At home, and in auto for a second: the cylinder pushes.
//! controller.handle(Tick::ZERO, image(0b01));
//! controller.handle(Tick::ZERO, StationInput::Order(ModeOrder::of(1, 1, ControlMode::Auto, Duration::from_secs(1))));
//! controller.step(Tick::ZERO, &mut out);
//! assert_eq!(out.outputs, 0b10);
//!
//! // It has left one switch and reached the other: the chart goes on with the pull.
//! for bits in [0b00, 0b10] {
//!     controller.handle(Tick::from_micros(500_000), image(bits));
//!     controller.step(Tick::from_micros(500_000), &mut out);
//! }
//! assert_eq!(out.outputs, 0b01);
//!
//! // The mode command was not renewed: the outputs go off by themselves.
//! while let Some(deadline) = controller.next_deadline().filter(|_| out.outputs != 0) {
//!     controller.step(deadline, &mut out);
//! }
//! assert_eq!(controller.mode(), ControlMode::StandBy);
//! # Ok::<(), linewright_station_logic::CompileError>(())
//! ```
//!
//! # Inside
//! The net comes from [`linewright_line::net`]; here it is compiled to tables (`program`) and played (`step`, `fire`).
//! Counted internal variables are in `views`, taking a count back by agreement in `withdraw`, which counts may be compared
//! in `generation`; the check of measured positions, which needs no memory, in `interlock`, motions that rely on it
//! alone in `entry`; what a console may lead on in
//! `resume`. A task-driven station has `slot` besides. `texts` has what operators read. There is no clock, no thread and no message format here.

mod axis_place;
mod conflict_spans;
mod controller;
mod drive;
mod entry;
mod event;
mod explain;
mod explain_homing;
mod explain_order;
mod fire;
mod generation;
mod homing;
mod ignored;
mod index;
mod interlock;
mod order;
mod panel;
mod parts;
mod peer_set;
mod place_table;
mod position_guard;
mod program;
mod rejoin;
mod report;
mod restore;
mod resume;
mod rules;
mod situation;
mod slot;
mod step;
mod tasks;
mod texts;
mod views;
mod withdraw;

pub use controller::{Controller, NO_DELAY, StationInput, StationOutbox};
pub use event::{HappeningKind, PlacesApart, StationHappening, StopCause};
pub use ignored::{Handled, Ignored};
pub use order::{
    LeaveWay, OrderKey, OrderMemory, RESULTS_MAX, SlotReport, TaskCommand, TaskFailure, TaskOrder, TaskOrderReport,
    TaskOutcome, TaskRefusal, TaskReply,
};
pub use panel::{ModeOrder, PanelCommand, RivalCoordinators};
pub use position_guard::{OwnSide, PositionGuard, PositionsKnown};
pub use program::{CompileError, Program};
pub use rejoin::RejoinAt;
pub use report::{AgreementAnswer, AgreementRequest, Restore, StationReport, StationSnapshot};
pub use rules::{OrderRules, Rules};
pub use situation::{PeerSituation, RequestWriter};
pub use texts::{DEVICES_INVALID, NUMBERS_LOST, NoReturn, PanelChoice, PositionDoubt, RejoinAdvice, StationWait};
