//! What comes next while a position is to be confirmed, by the plan of `recover`.

use linewright_console_view::{NextStep, asks_to_confirm};

use super::WatchState;
use crate::cell::CellClient;
use crate::client::OperatorClient;
use crate::recover::NewestPlan;

/// Looks what comes next, where a station asks for a confirmation. While that is not known, none is offered.
pub fn look(newest: &mut NewestPlan, client: &OperatorClient, cell: Option<&CellClient>) -> Option<NextStep> {
    let line = client.line();
    let is_asked = line.station_ids().any(|id| client.station(id).is_some_and(asks_to_confirm));
    match is_asked.then(|| newest.look(client, cell)) {
        Some(Some(found)) => NextStep::of(line, &found.plan),
        Some(None) => Some(NextStep::searching()),
        None => None,
    }
}

impl WatchState {
    /// Looks what comes next, where a station asks for a confirmation. While that is not known, none is offered.
    pub fn look(&mut self, client: &OperatorClient, cell: Option<&CellClient>) {
        self.next = look(&mut self.newest, client, cell);
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
