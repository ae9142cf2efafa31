//! The texts of the mode decision for operators. All of them are here.
//!
//! A text names the station and what to do where that is not plain. `tests/texts.rs` keeps a list of all of them.

mod mode;
mod refusal;

pub use mode::{EStopButton, ModeText, left_out};
pub(crate) use refusal::reason_texts;
