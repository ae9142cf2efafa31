//! The shell of a station, without its sockets: what the node does around its controller.
//!
//! In this order, like the node: journal record, output image, report, events. A crash may fall between any two
//! events of the simulation, and between the record and everything that should have followed it.

use std::rc::Rc;
use std::time::Duration;

use linewright_line::{Line, StationId, Tick};
use linewright_node_shell::NewestBySequence;
use linewright_station_logic::{Controller, Event, Input, Outbox, Report, Restore, Snapshot};

use crate::network::{Image, Message, Node};

/// A station's process.
pub(crate) struct StationNode {
    pub(crate) controller: Controller,
    /// What its disk holds.
    pub(crate) journal: Snapshot,
    pub(crate) boot_id: u64,
    sequence: u64,
    states: Vec<NewestBySequence>,
    orders: NewestBySequence,
    images: NewestBySequence,
    losses: Option<u64>,
    outbox: Outbox,
    outputs: u128,
    outputs_losses: u64,
    next_refresh: Tick,
    refresh: Duration,
    stale: Duration,
    /// Dies at the next change, after the record is written and before anything is said.
    pub(crate) dies_at_next_record: bool,
    pub(crate) dead: bool,
}

/// What it wants said, and what happened.
#[derive(Default)]
pub(crate) struct Said {
    pub(crate) messages: Vec<(Node, Message)>,
    pub(crate) events: Vec<Event>,
}

impl StationNode {
    pub(crate) fn start(now: Tick, line: &Line, station: StationId, boot_id: u64, restore: Restore) -> Self {
        let mut controller = Controller::new(line, station, boot_id, restore)
            .unwrap_or_else(|error| panic!("the line of a test compiles: {error}"));
        let mut outbox = Outbox::default();
        controller.step(now, &mut outbox);
        StationNode {
            journal: controller.snapshot(),
            controller,
            boot_id,
            sequence: 0,
            states: vec![NewestBySequence::new(); line.stations.len()],
            orders: NewestBySequence::new(),
            images: NewestBySequence::new(),
            losses: None,
            outbox,
            outputs: 0,
            outputs_losses: 0,
            next_refresh: now,
            refresh: line.timing.refresh,
            stale: line.timing.stale,
            dies_at_next_record: false,
            dead: false,
        }
    }

    /// Takes a message.
    pub(crate) fn hear(&mut self, now: Tick, from: Node, message: &Message, said: &mut Said) {
        if self.is_newest(from, message) {
            self.take(now, from, message);
        }
        self.step(now, said);
    }

    fn is_newest(&mut self, from: Node, message: &Message) -> bool {
        let verdict = match (from, message) {
            (Node::Station(id), Message::Report(sequence, report)) => {
                self.states[id.index()].offer(report.boot_id, *sequence)
            }
            (_, Message::Order(sequence, order)) => self.orders.offer(order.boot_id, *sequence),
            (_, Message::Inputs(image)) => self.images.offer(image.boot_id, image.sequence),
            // What people say carries no number.
            _ => return true,
        };
        verdict.is_newest()
    }

    fn take(&mut self, now: Tick, from: Node, message: &Message) {
        match (from, message) {
            (Node::Station(id), Message::Report(_, report)) => {
                self.controller.handle(now, Input::View(id, report));
            }
            (_, Message::Order(_, order)) => {
                self.controller.handle(now, Input::Order(*order));
            }
            (_, Message::Inputs(image)) => self.hear_inputs(now, *image),
            (_, Message::Panel(command)) => {
                self.controller.handle(now, Input::Panel(*command));
            }
            _ => {}
        }
    }

    fn hear_inputs(&mut self, now: Tick, image: Image) {
        let until = now + self.stale;
        // Lost and back between two images: the controller must see the loss.
        if self.losses.is_some_and(|losses| losses != image.losses) && image.valid {
            self.controller.handle(now, Input::Inputs { bits: 0, valid: false, until, under: 0 });
            let mut unseen = Outbox::default();
            self.controller.step(now, &mut unseen);
            self.outbox.changed |= unseen.changed;
            self.outbox.events.append(&mut unseen.events);
        }
        self.losses = Some(image.losses);
        // Numbers of a life before this one mean nothing to it.
        let (life, number) = image.under;
        let under = if life == self.boot_id { number } else { 0 };
        self.controller.handle(now, Input::Inputs { bits: image.bits, valid: image.valid, until, under });
    }

    /// Plays the controller one step further and says what there is to say.
    pub(crate) fn step(&mut self, now: Tick, said: &mut Said) {
        let changed_before = std::mem::take(&mut self.outbox.changed);
        self.controller.step(now, &mut self.outbox);
        let changed = self.outbox.changed || changed_before;
        self.outbox.changed = false;
        if changed {
            self.journal = self.controller.snapshot();
            if self.dies_at_next_record {
                self.dead = true;
                // Never said, but done: the ledger keeps what the journal knows.
                said.events.append(&mut self.outbox.events);
                return;
            }
        }
        let due = now >= self.next_refresh;
        if due {
            self.next_refresh = now + self.refresh;
        }
        let losses = self.losses.unwrap_or(0);
        if due || self.outbox.outputs != self.outputs || losses != self.outputs_losses {
            self.outputs = self.outbox.outputs;
            self.outputs_losses = losses;
            let sequence = self.number();
            let under = (self.boot_id, self.outbox.number);
            let image = Image { boot_id: self.boot_id, sequence, bits: self.outputs, valid: true, losses, under };
            said.messages.push((Node::Coordinator, Message::Outputs(image)));
        }
        if due || changed {
            let sequence = self.number();
            let report: Rc<Report> = Rc::new(self.controller.report());
            // To everybody who reads its state; the simulation knows who does.
            said.messages.push((Node::Operator, Message::Report(sequence, report)));
        }
        said.events.append(&mut self.outbox.events);
    }

    fn number(&mut self) -> u64 {
        self.sequence += 1;
        self.sequence
    }

    pub(crate) fn next_deadline(&self) -> Tick {
        self.controller.next_deadline().unwrap_or(Tick::NEVER).min(self.next_refresh)
    }
}
