//! The description as written: every value with the place it was written at, no name resolved yet.
//!
//! A field is `None` when it is missing or could not be read; whoever read it has reported that, so that no later rule
//! has to. The keys themselves are known to [`super::read`] alone.

use std::time::Duration;

use linewright_text::{At, Name, Where};

use crate::{DispatchRule, Strategy, Whereabouts};

#[derive(Debug)]
pub(super) struct RawCell {
    pub name: Option<Name>,
    pub title: Option<Name>,
    /// Its header, or the beginning of the text.
    pub at: Where,
    pub wip_max: Option<At<i64>>,
    pub reserve: bool,
    pub safety: f64,
    pub dispatch: RawDispatch,
    pub resources: Vec<RawResource>,
    pub syncs: Vec<RawSync>,
    pub actions: Vec<RawCellAction>,
    pub parts: Vec<RawPart>,
    pub exceptions: Vec<RawException>,
}

#[derive(Debug, Default)]
pub(super) struct RawDispatch {
    pub rules: Option<At<Vec<Name>>>,
    pub look_ahead: Option<At<f64>>,
    pub patience: Option<At<Duration>>,
    pub window: Option<At<f64>>,
}

#[derive(Debug)]
pub(super) struct RawResource {
    /// Its header.
    pub at: Where,
    pub name: Option<Name>,
    pub prototype: Option<Name>,
    pub capacity: Option<At<i64>>,
    pub station: Option<Name>,
    pub presence: Option<Name>,
}

#[derive(Debug)]
pub(super) struct RawSync {
    pub at: Where,
    pub name: Option<Name>,
    pub actions: Option<At<Vec<Name>>>,
    pub time: Option<At<Duration>>,
    pub orders: Vec<RawOrder>,
}

#[derive(Debug)]
pub(super) struct RawCellAction {
    pub of: Option<Name>,
    pub orders: Vec<RawOrder>,
}

#[derive(Debug)]
pub(super) struct RawOrder {
    pub at: Where,
    pub station: Option<Name>,
    pub task: Option<Name>,
    pub parameters: Vec<(Name, At<linewright_text::Scalar>)>,
    pub limit: Option<At<Duration>>,
}

#[derive(Debug)]
pub(super) struct RawPart {
    pub at: Where,
    pub name: Option<Name>,
    pub steps: Vec<RawStep>,
}

#[derive(Debug)]
pub(super) struct RawStep {
    pub at: Where,
    pub name: Option<Name>,
    pub or: Option<Name>,
    pub then: Option<Name>,
    pub on: Vec<RawOn>,
}

#[derive(Debug)]
pub(super) struct RawOn {
    pub at: Where,
    pub resource: Option<Name>,
    pub time: Option<At<Duration>>,
    pub program: Option<At<i64>>,
    /// Whether one is written, whatever it is.
    pub has_program: bool,
}

#[derive(Debug)]
pub(super) struct RawException {
    pub at: Where,
    pub within: Option<Name>,
    pub code: Option<Name>,
    pub tell: Option<Name>,
    pub retries: i64,
    pub automatic: bool,
    pub emergency_stop: Option<At<Vec<Name>>>,
    pub down: Option<At<Vec<Name>>>,
    pub answers: Vec<RawAnswer>,
}

#[derive(Debug)]
pub(super) struct RawAnswer {
    pub word: Option<Name>,
    pub part: Option<At<Whereabouts>>,
    pub then: Option<At<Strategy>>,
    pub down: Option<At<Vec<Name>>>,
}

impl RawDispatch {
    /// The rules that exist, each with its place.
    pub fn known_rules(&self) -> impl Iterator<Item = At<DispatchRule>> + '_ {
        let names = self.rules.iter().flat_map(|rules| &rules.value);
        names.filter_map(|name| {
            let (_, rule) = DispatchRule::ALL.iter().find(|(known, _)| *known == name.value)?;
            Some(At::new(*rule, name.at.clone()))
        })
    }
}
