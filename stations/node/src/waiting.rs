//! What arrives while a record is being written, which takes as long as a disk takes.
//!
//! It waits: what follows the record was decided without it. An emergency stop alone turns the outputs off at once.

use std::collections::VecDeque;

use linewright_canopen::Event as BusEvent;
use linewright_line::StationId;
use linewright_line::net::ControlMode;
use tokio::sync::mpsc;

use crate::convert::order_from_message;
use crate::journal::to_record;
use crate::node::{NodeError, Shell, next_bus_events};
use crate::topics::Arrived;

/// What has arrived and is not taken yet. A record that takes longer than [`linewright_node_shell::Watchdog::LIMIT`] ends the
/// process, so this does not grow for ever.
pub struct Waiting<A> {
    /// Messages, oldest first.
    pub arrived: VecDeque<A>,
    /// What the bus has brought.
    pub events: Vec<BusEvent>,
}

impl<A> Default for Waiting<A> {
    fn default() -> Self {
        Waiting { arrived: VecDeque::new(), events: Vec::new() }
    }
}

impl<A> Waiting<A> {
    /// Takes from the channel what has arrived there, at most so many messages: no flood of them keeps the bus waiting.
    pub fn fill(&mut self, from: &mut mpsc::Receiver<A>, at_most: usize) {
        self.arrived.extend(std::iter::from_fn(|| from.try_recv().ok()).take(at_most));
    }

    /// Nothing has arrived.
    pub fn is_empty(&self) -> bool {
        self.arrived.is_empty() && self.events.is_empty()
    }

    /// What the bus has brought, if anything.
    pub fn take_events(&mut self) -> Option<Vec<BusEvent>> {
        (!self.events.is_empty()).then(|| std::mem::take(&mut self.events))
    }
}

impl Shell {
    /// Writes down what the shell knows. An emergency stop that arrives meanwhile turns the outputs off at once, and so does a
    /// record that takes longer than what was heard is known for.
    pub(crate) async fn remember(&mut self) -> Result<(), NodeError> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        journal.begin(to_record(&self.line, self.station, &self.shell.snapshot(), &self.host));
        let mut due = Some(self.clock.now() + self.line.timing.stale);
        while let Some(journal) = &mut self.journal {
            let must_stop = tokio::select! {
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
                () = self.clock.sleep_until(due) => {
                    tracing::warn!(station = self.name, "the journal is slow: outputs off until it is written");
                    true
                }
                events = next_bus_events(&mut self.driver) => match events {
                    Ok(events) => {
                        self.waiting.events.extend(events);
                        false
                    }
                    Err(error) => return Err(NodeError::Driver { station: self.name.clone(), error }),
                },
            };
            if must_stop && due.take().is_some() {
                let off = self.shell.interrupt();
                self.drive(off);
            }
        }
        Ok(())
    }
}

fn is_emergency_stop(arrived: &Arrived, own: (StationId, &str)) -> bool {
    let Arrived::Order(order) = arrived else { return false };
    order_from_message(order, own).is_ok_and(|order| order.mode == ControlMode::EStop)
}
