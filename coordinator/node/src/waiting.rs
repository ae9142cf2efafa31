//! Arrivals while a record is being written, which takes as long as a disk takes.
//!
//! It waits: what follows the record was decided without it. An emergency stop, by command or from the console, comes first:
//! what follows the record is dropped then, and decided again.

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::CoordinatorRecord;
use linewright_fieldbus_seam::News;
use linewright_line::net::ControlMode;
use linewright_line::{Owner, Tick};

use crate::cell::CellThread;
use crate::node::{CoordinatorLoop, CoordinatorNodeError, Recorded};
use crate::remembered::record_of;
use crate::topics::CoordinatorInbound;

/// Most messages taken between two steps, so that no flood of them keeps the bus waiting.
const TAKEN_AT_ONCE: usize = 256;

impl CoordinatorLoop {
    /// Takes in the arrivals, those that have waited first.
    pub(crate) fn take(&mut self) {
        if let Some(news) = self.waiting.take_news() {
            self.bus_news(&news);
        }
        self.waiting.fill(&mut self.from, TAKEN_AT_ONCE);
        // All of it: an emergency stop among it must not wait for another record.
        while let Some(arrived) = self.waiting.arrived.pop_front() {
            self.arrived(arrived);
        }
    }

    /// Writes a record down, after the one that may still be under way.
    pub(crate) async fn remember(&mut self, record: CoordinatorRecord) -> Result<Recorded, CoordinatorNodeError> {
        let Some(journal) = &self.journal else { return Ok(Recorded::Yes) };
        if journal.is_writing() && self.recorded().await? == Recorded::Interrupted {
            return Ok(Recorded::Interrupted);
        }
        if let Some(journal) = &mut self.journal {
            journal.begin(record_of(record));
        }
        self.recorded().await
    }

    /// Waits for the record that is being written. Where it takes longer than images are valid for, outputs of stations go
    /// off: what they follow from is not looked at meanwhile.
    async fn recorded(&mut self) -> Result<Recorded, CoordinatorNodeError> {
        let now = self.clock.now();
        let mut due = Some(self.shell.images_until(now).unwrap_or(Tick::NEVER).min(now + self.line.timing.stale));
        // An emergency stop that got lost on its way is given again, whatever the disk does.
        let in_stop = self.shell.coordinator().mode() == ControlMode::EStop;
        let mut repeat = in_stop.then(|| now + self.line.timing.refresh);
        while let Some(journal) = &mut self.journal {
            let may_stop = tokio::select! {
                biased;
                written = journal.written() => return Ok(match written {
                    Ok(()) => Recorded::Yes,
                    Err(error) => {
                        tracing::error!("{error}; emergency stop until it can be written");
                        Recorded::No
                    }
                }),
                // The cell may have put a station into emergency stop.
                news = CellThread::news(&mut self.cell) => {
                    news?;
                    true
                }
                arrived = self.from.recv() => {
                    let Some(arrived) = arrived else { return Err(CoordinatorNodeError::Middleware) };
                    let is_stop = is_emergency_stop(&arrived);
                    if let CoordinatorInbound::Outputs(station, image) = &arrived {
                        // Only what is on already stays on, so an image of another description switches nothing on.
                        let wanted = if image.valid { image.word() } else { 0 };
                        if let Some(staying) = self.shell.keep_only(*station, wanted) {
                            self.buses.set_outputs(Owner::Station(*station), staying);
                        }
                    }
                    self.waiting.arrived.push_back(arrived);
                    is_stop
                }
                // One at a time: more wait in the middleware. What an end of activity takes back is order and mode, decided after it.
                asked = self.lifecycle.next(), if self.asked.is_none() => {
                    self.asked = Some(asked);
                    false
                }
                () = self.clock.sleep_until(repeat) => {
                    repeat = Some(self.clock.now() + self.line.timing.refresh);
                    let sequence = self.shell.repeat_order();
                    self.send_order(sequence);
                    false
                }
                () = self.clock.sleep_until(due) => {
                    tracing::warn!("the journal is slow: outputs of stations off until it is written");
                    due = None;
                    for behind in &self.behind {
                        self.buses.set_outputs(Owner::Station(behind.station), 0);
                    }
                    false
                }
                news = self.buses.next_news() => {
                    let news = news?;
                    let of_console = |news: &News| matches!(news, News::InputsChanged { owner: Owner::Console });
                    let may_stop = news.iter().any(of_console);
                    self.waiting.news.extend(news);
                    may_stop
                }
            };
            // In the emergency stop the record comes last.
            if may_stop && !in_stop {
                return Ok(Recorded::Interrupted);
            }
        }
        Ok(Recorded::Yes)
    }
}

fn is_emergency_stop(arrived: &CoordinatorInbound) -> bool {
    match arrived {
        CoordinatorInbound::Command { words, .. } => ModeCommand::parse(words) == Some(ModeCommand::EStop),
        CoordinatorInbound::Asked(asked) => asked.is_emergency_stop(),
        _ => false,
    }
}
