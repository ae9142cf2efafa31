//! What comes next while a position is to be confirmed, by the plan of `recover`.
//!
//! A station by itself names the confirmation wherever its switches permit one. Whether that is the way back follows from all stations: where
//! every memory is lost, axes that are brought home by hand need none, and a confirmation elsewhere closes that way.

use std::borrow::Cow;

use linewright_line::{Line, StationId};
use linewright_msgs::StationState;
use linewright_recovery::{RecoveryAction, RecoveryEnd, RecoveryPlan};

/// Begin of a wait that a confirmation ends.
const REJOIN: &str = "rejoin: ";
/// While the plan is not known.
const SEARCHING: &str = "is looked for, by the states that are received";

/// The step that comes next.
#[derive(Debug)]
pub struct NextStep {
    text: String,
    /// The station that is to be confirmed by it.
    confirms: Option<StationId>,
}

impl NextStep {
    /// The next step of a plan; none where there is nothing to do.
    pub fn of(line: &Line, plan: &RecoveryPlan) -> Option<Self> {
        let no_way = matches!(plan.end, RecoveryEnd::NoWay { .. }).then(|| plan.end_text(line).into_iter().next());
        let step = plan.behind_signals().map(|at| &plan.steps[at]);
        let confirms = step.and_then(|step| match step.action {
            RecoveryAction::Rejoin { station, .. } => Some(station),
            _ => None,
        });
        match no_way.flatten() {
            Some(text) => Some(NextStep { text, confirms: None }),
            None => Some(NextStep { text: step?.text(line), confirms }),
        }
    }

    /// While the plan is looked for: no confirmation is offered.
    pub fn searching() -> Self {
        NextStep { text: SEARCHING.to_owned(), confirms: None }
    }

    /// The step alone.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The step in one line.
    pub fn line(&self) -> String {
        format!("next: {} (all: `linewright recover`)", self.text)
    }

    /// A station's state with what it waits for as far as that is the way back.
    pub fn shown<'s>(&self, id: StationId, state: &'s StationState) -> Cow<'s, StationState> {
        if self.confirms == Some(id) || !asks_to_confirm(state) {
            return Cow::Borrowed(state);
        }
        let mut shown = state.clone();
        let asks = shown.blocked_by.iter_mut().filter(|why| why.starts_with(REJOIN));
        // In its place, since that is not what comes next.
        asks.for_each(|why| {
            *why = format!("the confirmation of its position, which does not come next: {}", self.text)
        });
        Cow::Owned(shown)
    }
}

/// Whether a station asks for the confirmation of where it stands.
pub fn asks_to_confirm(state: &StationState) -> bool {
    state.blocked_by.iter().any(|why| why.starts_with(REJOIN))
}
