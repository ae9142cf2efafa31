//! The texts of a station for operators and logs. All of them are here, one file for each kind of text.
//!
//! A cause or a reason names the signal, and what to do where that is not plain. Events follow the station's name
//! (`clamp_1 completed close`); reasons to wait follow `waits for` and are noun phrases. Texts fit a screen of 80 columns
//! where the names of a description allow it. `tests/texts.rs` keeps a list of all of them.

mod blocked;
mod cause;
mod compile;
mod event;
mod ignored;
pub(crate) mod place;

pub use blocked::{DEVICES_INVALID, NUMBERS_LOST, NoReturn, PanelChoice, PositionDoubt, RejoinAdvice, StationWait};
pub(crate) use blocked::{HOMING, REJOIN_WAY, numbers_text};
pub(crate) use cause::{SwitchTense, signal_now_text, stuck_text};
