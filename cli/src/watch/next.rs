//! What comes next while a position is to be confirmed, by the plan of `recover`.
//!
//! A station by itself names the confirmation wherever its switches permit one. Whether that is the way back follows from all stations: where
//! every memory is lost, axes that are brought home by hand need none, and a confirmation elsewhere closes that way.

use std::borrow::Cow;

use linewright_line::{Line, StationId};
use linewright_msgs::StationState;
use linewright_recovery::{RecoveryAction, RecoveryEnd, RecoveryPlan};

use super::WatchState;
use crate::cell::CellClient;
use crate::client::OperatorClient;
use crate::recover::behind_signals;

/// Begin of a wait that a confirmation ends.
const REJOIN: &str = "rejoin: ";
/// In its place where that is not what comes next.
const NOT_YET: &str = "its position: first see `next`";
/// While the plan is not known.
const SEARCHING: &str = "is looked for, by the states that are received";

/// The step that comes next.
pub struct NextStep {
    text: String,
    /// The station that is to be confirmed by it.
    confirms: Option<StationId>,
}

impl NextStep {
    /// The next step of a plan; none where there is nothing to do.
    fn of(line: &Line, plan: &RecoveryPlan) -> Option<Self> {
        let no_way = matches!(plan.end, RecoveryEnd::NoWay { .. }).then(|| plan.end_text(line).into_iter().next());
        let step = behind_signals(plan).map(|at| &plan.steps[at]);
        let confirms = step.and_then(|step| match step.action {
            RecoveryAction::Rejoin { station, .. } => Some(station),
            _ => None,
        });
        match no_way.flatten() {
            Some(text) => Some(NextStep { text, confirms: None }),
            None => Some(NextStep { text: step?.text(line), confirms }),
        }
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
        asks.for_each(|why| NOT_YET.clone_into(why));
        Cow::Owned(shown)
    }
}

fn asks_to_confirm(state: &StationState) -> bool {
    state.blocked_by.iter().any(|why| why.starts_with(REJOIN))
}

impl WatchState {
    /// Looks what comes next, where a station asks for a confirmation. While that is not known, none is offered.
    pub fn look(&mut self, client: &OperatorClient, cell: Option<&CellClient>) {
        let is_asked = self.line.station_ids().any(|id| client.station(id).is_some_and(asks_to_confirm));
        self.next = match is_asked.then(|| self.newest.look(client, cell)) {
            Some(Some(found)) => NextStep::of(&self.line, &found.plan),
            Some(None) => Some(NextStep { text: SEARCHING.to_owned(), confirms: None }),
            None => None,
        };
    }

    /// Looks until that is known, and receives all the while.
    ///
    /// # Errors
    /// When the middleware has failed.
    pub async fn settle(&mut self, client: &mut OperatorClient, cell: &mut Option<CellClient>) -> miette::Result<()> {
        self.look(client, cell.as_ref());
        if self.next.is_some() {
            self.newest.settle(client, cell).await?;
            self.look(client, cell.as_ref());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use linewright_line::net::ControlMode;
    use linewright_recovery::{RecoveryStep, RejoinChoice};
    use linewright_station_logic::RejoinAt;

    use super::*;

    /// `watch` named rejoin where `recover` had another way, which rejoin closes.
    #[test]
    fn a_confirmation_is_offered_where_it_comes_next_and_nowhere_else() {
        let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
        let line = line.expect("parses").line;
        let [first, second] = [StationId(0), StationId(1)];
        let confirm = RecoveryStep {
            action: RecoveryAction::Rejoin {
                station: second,
                at: RejoinChoice {
                    at: RejoinAt::Measured,
                    places: Vec::new(),
                    on: 0,
                    numbers: Vec::new(),
                    activity: None,
                },
                or: Vec::new(),
            },
            moves: Vec::new(),
            is_doubtful: false,
            mode: ControlMode::Manual,
            after: None,
        };
        let plan = |steps, end| RecoveryPlan {
            steps,
            end,
            is_shortest: true,
            begins_anew: false,
            led: Vec::new(),
            expanded: 0,
        };
        let asks = StationState { blocked_by: vec!["rejoin: confirm it".to_owned()], ..StationState::default() };
        let waits = |next: &NextStep, id| next.shown(id, &asks).blocked_by.to_vec();
        let next = NextStep::of(&line, &plan(vec![confirm.clone()], RecoveryEnd::Auto)).expect("a step");
        assert_eq!((waits(&next, first), waits(&next, second)), (vec![NOT_YET.to_owned()], asks.blocked_by.to_vec()));
        assert!(next.line().starts_with(&format!("next: {}: look, and if", line.station(second).name)));
        let no_way = RecoveryEnd::NoWay { reasons: Vec::new(), is_certain: true };
        let next = NextStep::of(&line, &plan(vec![confirm], no_way)).expect("what is done by hand");
        assert_eq!((waits(&next, first), waits(&next, second)), (vec![NOT_YET.to_owned()], vec![NOT_YET.to_owned()]));
        assert!(next.line().contains("bring every station home by hand"), "{}", next.line());
        assert!(NextStep::of(&line, &plan(Vec::new(), RecoveryEnd::Auto)).is_none());
    }
}
