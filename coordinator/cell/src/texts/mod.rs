//! The texts of a cell for operators, logs and reports. All of them are here, one file for each kind of text, but for what
//! is wrong with a log or a plan, which stands where it is found.
//!
//! A text gives the event, the place, and what to do where that is not plain. Activities, parts and resources have the
//! names of the description. `tests/texts.rs` keeps a list of all of them.

pub mod alarm;
mod answer;
pub(crate) mod decision;
mod failure;
mod limit;
mod part;
mod production;
pub(crate) mod resource;
mod service;
mod standing;
pub(crate) mod wait;

pub use answer::{AnswerFit, AnswerRemark, ListedAnswer, answer_refused};
pub use decision::{called, decision, named, reason};
pub use limit::{LimitText, TimeLimitOf};
pub use part::part;
pub use wait::{CellWait, TokenOwner, failed, recovery};
