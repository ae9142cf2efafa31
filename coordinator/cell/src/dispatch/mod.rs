//! The dispatcher: answers the player's questions, by rules, so that no part waits for ever, with its reasons.
//!
//! # Map
//! - [`DispatchRule`], [`Measure`]: the rules and what they measure; [`PartPriorities`], [`Timetable`]: their data on parts.
//! - [`RuleDispatcher`]: the dispatcher.
//! - [`Fairness`]: urgency, reservation and inheritance, with the argument in the head of `urgency.rs`.
//! - [`ShortestRoutes`]: remaining work and processing times, from the table.
//! - [`Reasons`], [`why_not`], [`why_resource`]: what was held and why, what a part waits for, and how a resource is, and what keeps it
//!   from work, in sentences.
//!
//! A dispatcher chooses among what the player has found possible, and the player checks the answer: nothing here can
//! make a cell do what its net forbids. Rules measure a whole question, so a dispatcher that simulates can apply the
//! same rules to a simulated state.

mod by_rules;
mod measure;
mod priorities;
mod reasons;
mod rule;
mod urgency;
mod ways;
mod why;

pub use by_rules::RuleDispatcher;
pub use linewright_cell::DispatchRule;
pub use measure::Measure;
pub use priorities::{Admission, EntryCandidate, PartPriorities, PartPriority, Timetable, Window};
pub use reasons::Reasons;
pub use urgency::Fairness;
pub use ways::ShortestRoutes;
pub(super) use ways::{shortest, time};
pub use why::{why_not, why_resource};
