//! The coordinator's decisions: the control mode of the line, permitted changes, and reasons of refusals.
//!
//! The mode decision is a net of six places (seed 002 §5.4, Figure 18). [`decision`] is that net with its conditions
//! as data; [`Coordinator`] plays it: it takes operator commands, the console's image and what the stations report,
//! and gives the order that goes out to every station. There is no clock and no message format here.

mod buttons;
mod coordinator;
pub mod decision;
mod gateway;
mod refusal;
mod resume;
mod texts;

pub use buttons::Buttons;
pub use coordinator::{
    CompletedCycle, Coordinator, EStopCause, ManualPermit, ModeGrant, ModeInput, ModeOutbox, ModeStanding, StationView,
};
pub use decision::ModeCommand;
pub use gateway::{AppliedImage, Gateway, OutputImage};
pub use refusal::{ApartCause, ModeRefusal, OperatorCommand, RefusedCommand};
pub use resume::ResumeButton;
pub use texts::{EStopButton, ModeText, left_out};
