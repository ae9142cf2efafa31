//! A station's process: its shell, and a disk.
//!
//! A crash may fall between any two events of the simulation, and between the record and everything that should have
//! followed it.

use std::rc::Rc;

use linewright_line::{Line, StationId, Tick};
use linewright_station_logic::{Controller, Event, Restore, Snapshot};
use linewright_station_shell::{InputsMessage, StationArrival, StationEffect, StationShell};

use crate::network::{Image, Message, Node};

/// A station's process.
pub(crate) struct StationProcess {
    shell: StationShell,
    /// What its disk holds.
    pub(crate) journal: Snapshot,
    effects: Vec<StationEffect>,
    /// Dies at the next change, after the record is written and before anything is said.
    pub(crate) dies_at_next_record: bool,
    pub(crate) dead: bool,
}

/// What it sends, and what happened.
#[derive(Default)]
pub(crate) struct StationPerformed {
    pub(crate) messages: Vec<(Node, Message)>,
    pub(crate) events: Vec<Event>,
}

impl StationProcess {
    pub(crate) fn start(line: &Line, station: StationId, boot_id: u64, restore: Restore) -> Self {
        let shell = StationShell::new(line, station, boot_id, restore)
            .unwrap_or_else(|error| panic!("the line of a test compiles: {error}"));
        StationProcess {
            journal: shell.snapshot(),
            shell,
            effects: Vec::new(),
            dies_at_next_record: false,
            dead: false,
        }
    }

    pub(crate) fn controller(&self) -> &Controller {
        self.shell.controller()
    }

    pub(crate) fn boot_id(&self) -> u64 {
        self.shell.boot_id()
    }

    /// Takes a message.
    pub(crate) fn hear(&mut self, now: Tick, from: Node, message: &Message, said: &mut StationPerformed) {
        let arrival = match (from, message) {
            (Node::Station(station), Message::Report(sequence, report)) => {
                Some(StationArrival::State { station, sequence: *sequence, report })
            }
            (_, Message::Order(sequence, order)) => Some(StationArrival::Order { sequence: *sequence, order: *order }),
            (_, Message::Inputs(image)) => Some(StationArrival::Inputs(InputsMessage {
                boot_id: image.boot_id,
                sequence: image.sequence,
                bits: image.bits,
                valid: image.valid,
                lives: image.losses,
                under: image.under,
            })),
            (_, Message::Panel(command)) => Some(StationArrival::Panel(*command)),
            (_, Message::Rejoin(within)) => Some(StationArrival::Rejoin(*within)),
            _ => None,
        };
        if let Some(arrival) = arrival {
            self.shell.handle(now, arrival, &mut self.effects);
        }
        self.step(now, said);
    }

    /// Plays the station one step further and performs what follows.
    pub(crate) fn step(&mut self, now: Tick, said: &mut StationPerformed) {
        self.shell.act(now, &mut self.effects);
        let mut effects = std::mem::take(&mut self.effects);
        for effect in effects.drain(..) {
            self.perform(effect, said);
        }
        self.effects = effects;
    }

    fn perform(&mut self, effect: StationEffect, said: &mut StationPerformed) {
        match effect {
            StationEffect::Remember => {
                self.journal = self.shell.snapshot();
                self.dead |= self.dies_at_next_record;
            }
            // Not sent, but done: the journal has it, so the ledger needs it.
            StationEffect::Happened(event) => said.events.push(event),
            _ if self.dead => {}
            StationEffect::Drive(image) => {
                let boot_id = self.shell.boot_id();
                let (under, losses) = ((boot_id, image.number), image.lives);
                let image = Image {
                    boot_id,
                    sequence: image.sequence,
                    bits: image.bits,
                    valid: true,
                    losses,
                    under,
                    mode_epoch: image.mode_epoch,
                };
                said.messages.push((Node::Coordinator, Message::Outputs(image)));
            }
            // To everybody who reads its state; the simulation knows who does.
            StationEffect::Tell { sequence } => {
                let report = Rc::new(self.shell.controller().report());
                said.messages.push((Node::Operator, Message::Report(sequence, report)));
            }
            StationEffect::Reply(..) | StationEffect::Ignored { .. } => {}
        }
    }

    pub(crate) fn next_deadline(&self) -> Tick {
        self.shell.next_deadline()
    }
}
