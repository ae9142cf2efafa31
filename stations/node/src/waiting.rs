//! Arrivals while a record is being written, which takes as long as a disk takes.
//!
//! It waits: what follows the record was decided without it. An emergency stop alone turns the outputs off at once, and a request that ends
//! the activity of the node.

use linewright_line::StationId;
use linewright_line::net::ControlMode;

use linewright_node_line::order_from_message;
use linewright_node_shell::ChangeRequest;

use crate::journal::to_record;
use crate::node::{StationLoop, StationNodeError, next_news};
use crate::topics::StationInbound;

impl StationLoop {
    /// Writes the shell's record. An emergency stop that arrives meanwhile turns the outputs off at once, and so does a record
    /// that takes longer than received state is valid.
    pub(crate) async fn remember(&mut self) -> Result<(), StationNodeError> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        journal.begin(to_record(&self.line, self.station, &self.shell.snapshot(), &self.host));
        let mut due = Some(self.clock.now() + self.line.timing.stale);
        let mut must_stop = self.ends_activity();
        loop {
            if must_stop && due.take().is_some() {
                let off = self.shell.interrupt();
                self.drive(off);
            }
            let ends_activity = self.ends_activity();
            let Some(journal) = &mut self.journal else { return Ok(()) };
            must_stop = tokio::select! {
                biased;
                written = journal.written() => return Ok(written?),
                arrived = self.from.recv() => match arrived {
                    Some(arrived) => {
                        let is_stop = is_emergency_stop(&arrived, (self.station, &self.name));
                        self.waiting.arrived.push_back(arrived);
                        is_stop
                    }
                    None => return Err(self.cut_off()),
                },
                // One at a time: more wait in the middleware. Only one that ends activity stands in the way of others while the node is active,
                // since no other is possible then.
                asked = self.lifecycle.next(), if !ends_activity => {
                    let is_stop = asked.may_end_activity();
                    if let Some(impossible) = self.asked.replace(asked) {
                        impossible.answer(false);
                    }
                    is_stop
                }
                () = self.clock.sleep_until(due) => {
                    tracing::warn!(station = self.name, "the journal is slow: outputs off until it is written");
                    true
                }
                news = next_news(&mut self.buses) => match news {
                    Ok(news) => {
                        self.waiting.news.extend(news);
                        false
                    }
                    Err(error) => return Err(StationNodeError::BusLost { station: self.name.clone(), error }),
                },
            };
        }
    }

    /// Whether a request is waiting that ends the activity of the node.
    fn ends_activity(&self) -> bool {
        self.asked.as_ref().is_some_and(ChangeRequest::may_end_activity)
    }
}

fn is_emergency_stop(arrived: &StationInbound, own: (StationId, &str)) -> bool {
    let StationInbound::Order(order, _) = arrived else { return false };
    order_from_message(order, own).is_ok_and(|order| order.mode == ControlMode::EStop)
}
