//! What arrives at the coordinator, and who sent it where that is a command.

use linewright_coordinator_logic::{RefusedCommand, StationView};
use linewright_coordinator_shell::{CoordinatorArrival, heard};
use linewright_line::Owner;
use linewright_node_line::devices::in_words;
use linewright_node_line::{quoted, report_from_message};
use linewright_station_shell::ParticipantId;

use crate::command::command_of;
use crate::gateway_topics::outputs_from_message;
use crate::node::CoordinatorLoop;
use crate::refusals::participant_text;
use crate::topics::{CoordinatorInbound, inactive};

impl CoordinatorLoop {
    pub(crate) fn arrived(&mut self, arrived: CoordinatorInbound) {
        match arrived {
            CoordinatorInbound::Command { from, words } => {
                self.operated(from, &words, "");
            }
            CoordinatorInbound::Asked(asked) => self.mode_asked(asked),
            CoordinatorInbound::Buttons { console, names } => match self.buttons(&names) {
                Ok(held) => {
                    let arrival = CoordinatorArrival::Buttons { console: console.id, held };
                    self.command(console.from, arrival);
                }
                Err(unknown) => drop(self.refuse(console.from, unknown)),
            },
            CoordinatorInbound::Resume { console, held } => {
                let arrival = CoordinatorArrival::Resume { console: console.id, held };
                self.command(console.from, arrival);
            }
            CoordinatorInbound::Order { boot_id, sequence } => {
                self.handle(CoordinatorArrival::Order { boot_id, sequence })
            }
            CoordinatorInbound::State(message) => {
                match report_from_message((&self.line, self.descriptions.line), &message) {
                    Ok((station, report)) => {
                        let (sequence, follows) = (message.sequence, message.coordinator_boot_id);
                        if let Some(history) = &mut self.history {
                            history.state(self.clock.now(), station, &message);
                        }
                        let heard = StationView { follows, inactive: inactive(&message), ..heard(&report) };
                        if !self.shell.handle(self.clock.now(), CoordinatorArrival::State { station, sequence, heard })
                        {
                            let (epoch, name) = (heard.mode_epoch, &message.station);
                            self.ignore(format_args!("mode epoch {epoch} of {name} is beyond any: start it again"));
                        }
                    }
                    Err(error) => self.ignore(error),
                }
            }
            CoordinatorInbound::Trouble(station, text) => self.troubles[station.index()] = text,
            CoordinatorInbound::Outputs(station, message) => {
                match outputs_from_message(&self.line.station(station).name, self.descriptions.line, &message) {
                    Ok(image) => {
                        self.handle(CoordinatorArrival::Outputs { station, sequence: message.sequence, image });
                    }
                    Err(error) => self.ignore(error),
                }
            }
        }
    }

    fn buttons(&self, names: &str) -> Result<u32, String> {
        let mut held = 0;
        for name in names.split_whitespace() {
            let index = self.line.buttons.iter().position(|button| button == name);
            let known = || self.line.buttons.join(", ");
            let index = index.ok_or_else(|| format!("'{}' is no button; buttons are {}", quoted(name), known()))?;
            held |= 1 << index;
        }
        Ok(held)
    }

    /// Obeys or refuses a command that is written as on the topic `mode_cmd`. `remark`: operator and reason, for the log. Gives the text of the
    /// refusal; none if it is obeyed.
    pub(crate) fn operated(&mut self, from: ParticipantId, words: &str, remark: &str) -> Option<String> {
        let command = match command_of(&self.line, words) {
            Ok(command) => command,
            Err(unknown) => {
                return Some(self.refuse(from, unknown));
            }
        };
        tracing::info!(from = participant_text(&from), "operator: {}{remark}", quoted(words.trim()));
        self.command(from, command).map(|refusal| self.refusal_text(&refusal))
    }

    /// Takes a command or button; its refusal, if it is not obeyed. That is published with the effects.
    fn command(&mut self, from: ParticipantId, arrival: CoordinatorArrival) -> Option<RefusedCommand> {
        let refused = self.shell.command(self.clock.now(), arrival);
        if refused.is_some() {
            self.refusals.count_sender(from);
        }
        refused
    }

    /// Refuses what does not come as far as the decision; the text of the refusal.
    pub(crate) fn refuse(&mut self, from: ParticipantId, text: String) -> String {
        self.refusals.count_sender(from);
        self.refusals.refuse(self.clock.now(), text.clone(), String::new(), &[]);
        self.shell.answer_soon();
        text
    }

    /// Publishes the refusal of a command.
    pub(crate) fn refused(&mut self, refusal: &RefusedCommand) {
        let (text, command) = (self.refusal_text(refusal), refusal.command.words(&self.line));
        self.refusals.refuse(self.clock.now(), text, command, &refusal.reasons);
        self.shell.answer_soon();
    }

    fn refusal_text(&self, refusal: &RefusedCommand) -> String {
        refusal.text_with(&self.line, |owner| match owner {
            Owner::Station(id) if !self.troubles[id.index()].is_empty() => self.troubles[id.index()].clone(),
            owner => in_words(&self.buses, owner),
        })
    }
}
