//! A coordinator's process: its shell, and its effects performed one after another.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, StationView};
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord, CoordinatorShell, heard};
use linewright_line::net::ControlMode;
use linewright_line::{Owner, StationId, Tick};
use linewright_station_shell::InputsMessage;

use crate::devices::SeenImage;
use crate::disk::SimulatedDisk;
use crate::message::{CONSOLE, Message};
use crate::mutants::Mutant;
use crate::process::{Process, Writing};
use crate::world::{Event, World};

/// Orders kept of those that were sent: of some three seconds.
const ORDERS_KEPT: usize = 64;

pub(crate) struct CoordinatorProcess {
    /// The line's devices are on its bus.
    has_bus: bool,
    pub(crate) process: Process,
    pub(crate) shell: Option<CoordinatorShell>,
    pub(crate) disk: SimulatedDisk<CoordinatorRecord>,
    effects: VecDeque<CoordinatorEffect>,
    /// The record that is being written.
    under_way: Option<CoordinatorRecord>,
    /// The record it waits for.
    awaited: Option<CoordinatorRecord>,
    /// By owner: the image as last taken.
    pub(crate) seen: Vec<Option<SeenImage>>,
    /// Refusal of the last command that was answered, and the number of answers.
    pub(crate) refusal: Option<String>,
    pub(crate) answers: u64,
    /// It ordered the emergency stop last then.
    pub(crate) stopped: Tick,
}

impl CoordinatorProcess {
    pub(crate) fn new(has_bus: bool) -> Self {
        CoordinatorProcess {
            has_bus,
            process: Process::new(),
            shell: None,
            disk: SimulatedDisk::new(),
            effects: VecDeque::new(),
            under_way: None,
            awaited: None,
            seen: vec![None; 128],
            refusal: None,
            answers: 0,
            stopped: Tick::ZERO,
        }
    }

    pub(crate) fn die(&mut self, record_is_there: bool) {
        if let Some(record) = self.under_way.take()
            && record_is_there
        {
            self.disk.store(record);
        }
        self.process.end();
        (self.shell, self.awaited) = (None, None);
        self.effects.clear();
        self.seen.fill(None);
    }

    fn store(&mut self, mutant: Option<Mutant>, record: CoordinatorRecord) {
        let estop = record.estop && mutant != Some(Mutant::StopNotRecorded);
        let epoch = if mutant == Some(Mutant::EpochNotRecorded) { 0 } else { record.epoch };
        if mutant != Some(Mutant::CoordinatorRecordNotKept) {
            self.disk.store(CoordinatorRecord { epoch, estop });
        }
    }

    pub(crate) fn mode(&self) -> Option<ControlMode> {
        self.shell.as_ref().map(|shell| shell.coordinator().mode())
    }
}

impl World {
    pub(crate) fn start_coordinator(&mut self, which: usize, remembers: bool) {
        let node = self.coordinator_node() + which;
        let (life, boot_id) = self.next_life();
        let origin = self.rng.within(86_400_000_000, 90_000_000_000);
        let coordinator = &mut self.coordinators[which];
        if !remembers {
            coordinator.disk.lose();
        }
        let record = coordinator.disk.newest().map(|(record, _)| *record).unwrap_or_default();
        let shell = CoordinatorShell::new(&self.line, boot_id, record);
        coordinator.shell = Some(match self.mutant {
            Some(mutant) => shell.with_shell_rules(mutant.shell_rules()),
            None => shell,
        });
        coordinator.process.begin(life, origin);
        self.take_devices(node);
        self.run_coordinator(which);
    }

    pub(crate) fn run_coordinator(&mut self, which: usize) {
        let node = self.coordinator_node() + which;
        // Once more after a record that failed: the emergency stop.
        for _ in 0..8 {
            let coordinator = &self.coordinators[which];
            if !coordinator.process.runs() || coordinator.awaited.is_some() {
                return;
            }
            while let Some((message, delivered, is_seen)) = self.coordinators[which].process.inbox.pop_front() {
                if !is_seen {
                    self.arrives(node, &message, delivered);
                }
                self.take_at_coordinator(which, message);
            }
            self.look(which);
            let now = self.now;
            let coordinator = &mut self.coordinators[which];
            let Some(shell) = &mut coordinator.shell else { return };
            let mut effects = Vec::new();
            shell.act(coordinator.process.clock(now), &mut effects);
            if self.mutant == Some(Mutant::OrderBeforeRecord) {
                effects.sort_by_key(|effect| matches!(effect, CoordinatorEffect::Remember(_)));
            }
            coordinator.effects = effects.into();
            if self.perform_coordinator(which) {
                break;
            }
        }
        let now = self.now;
        let coordinator = &self.coordinators[which];
        let Some(shell) = &coordinator.shell else { return };
        let local = coordinator.process.clock(now);
        if shell.gives_way_to(local).is_some() {
            self.note(format!("{} ends: it came second", self.name(node)));
            self.kill(node);
            if which == 0 {
                self.after(Duration::from_millis(800), Event::Restart { node, remembers: true });
            }
            return;
        }
        let deadline = shell.next_deadline(local);
        self.wake(node, deadline);
    }

    /// Takes the inputs that the buses have now.
    fn look(&mut self, which: usize) {
        let now = self.now;
        let console = self.stations.len();
        let has_console = self.line.devices_of(Owner::Console).next().is_some();
        let owners = self.managed(console);
        let coordinator = &mut self.coordinators[which];
        let Some(shell) = &mut coordinator.shell else { return };
        let local = coordinator.process.clock(now);
        for at in owners {
            let image = match coordinator.has_bus {
                true => self.io[at].image(now, &self.plant),
                false => SeenImage { bits: 0, valid: at == console && !has_console, losses: 0 },
            };
            coordinator.seen[at] = Some(image);
            let SeenImage { bits, valid, losses } = image;
            let arrival = if at == console {
                CoordinatorArrival::Console { bits, valid }
            } else {
                let losses = if self.mutant == Some(Mutant::LossesUnseen) { 0 } else { losses };
                CoordinatorArrival::Devices { station: StationId::at(at), bits, valid, losses }
            };
            shell.handle(local, arrival);
        }
    }

    fn take_at_coordinator(&mut self, which: usize, message: Message) {
        let node = self.coordinator_node() + which;
        let message = self.mutated(node, message);
        if matches!(message, Message::Command(_)) {
            self.coordinators[which].answers += 1;
            self.coordinators[which].refusal = None;
        }
        self.hand_to_coordinator(which, &message);
    }

    /// Gives a message to the shell.
    pub(crate) fn hand_to_coordinator(&mut self, which: usize, message: &Message) {
        let view = match message {
            Message::State { station, follows, report, .. } => {
                let heard = StationView { follows: *follows, ..heard(report) };
                self.mutated_view(which, station.index(), heard)
            }
            _ => StationView::default(),
        };
        let before = match message {
            Message::Command(command) => self.commands_before(*command),
            _ => None,
        };
        let coordinator = &mut self.coordinators[which];
        let Some(shell) = &mut coordinator.shell else { return };
        let local = coordinator.process.clock(self.now);
        if let Some(before) = before {
            shell.handle(local, CoordinatorArrival::Command(before));
        }
        let arrival = match message {
            Message::Order { sequence, order } => {
                CoordinatorArrival::Order { boot_id: order.boot_id, sequence: *sequence }
            }
            Message::State { station, sequence, .. } => {
                CoordinatorArrival::State { station: *station, sequence: *sequence, heard: view }
            }
            Message::Outputs { station, sequence, image } => {
                CoordinatorArrival::Outputs { station: *station, sequence: *sequence, image: *image }
            }
            Message::Command(command) => CoordinatorArrival::Command(*command),
            Message::Buttons(held) => CoordinatorArrival::Buttons { console: CONSOLE, held: *held },
            Message::Resume(held) => CoordinatorArrival::Resume { console: CONSOLE, held: *held },
            Message::Inputs(_) | Message::Panel(_) | Message::Rejoin(_) => return,
        };
        shell.handle(local, arrival);
    }

    /// Performs what is left. False if it is to act again at once.
    fn perform_coordinator(&mut self, which: usize) -> bool {
        let node = self.coordinator_node() + which;
        while let Some(effect) = self.coordinators[which].effects.pop_front() {
            match &mut self.coordinators[which].process.dies_after {
                Some(0) => {
                    self.note(format!("{} dies in the middle of its effects", self.name(node)));
                    self.kill(node);
                    return true;
                }
                Some(left) => *left -= 1,
                None => {}
            }
            let CoordinatorEffect::Remember(record) = effect else {
                self.perform(which, effect);
                continue;
            };
            if self.coordinators[which].process.writing.is_some() {
                self.coordinators[which].awaited = Some(record);
                self.awaits(which);
                return true;
            }
            match self.coordinator_remembers(which, record) {
                None => return true,
                Some(true) => {}
                Some(false) => {
                    self.coordinators[which].effects.clear();
                    return false;
                }
            }
        }
        true
    }

    fn perform(&mut self, which: usize, effect: CoordinatorEffect) {
        let node = self.coordinator_node() + which;
        let has_bus = self.coordinators[which].has_bus;
        match effect {
            CoordinatorEffect::Refused(refused) => {
                self.coordinators[which].refusal = Some(refused.text(&self.line));
            }
            CoordinatorEffect::Entered(mode) => self.note(format!("{}: mode {mode}", self.name(node))),
            CoordinatorEffect::Energise(station, bits) if has_bus => {
                self.observer.energised(&self.line, self.now, station, bits);
                self.put(station.index(), bits);
            }
            CoordinatorEffect::Inputs { station, sequence, image } => {
                let Some(shell) = &self.coordinators[which].shell else { return };
                let message = Message::Inputs(InputsMessage {
                    boot_id: shell.boot_id(),
                    sequence,
                    bits: image.bits,
                    valid: image.valid,
                    lives: image.lives,
                    under: image.under.unwrap_or_default(),
                });
                self.send(node, station.index(), message);
            }
            CoordinatorEffect::Order { sequence } => self.send_order(which, sequence),
            CoordinatorEffect::Lamps(_)
            | CoordinatorEffect::Energise(..)
            | CoordinatorEffect::Obeyed
            | CoordinatorEffect::Remember(_)
            | CoordinatorEffect::Tell { .. }
            | CoordinatorEffect::Completed(_) => {}
        }
    }

    fn send_order(&mut self, which: usize, sequence: u64) {
        let node = self.coordinator_node() + which;
        if let Some(shell) = &self.coordinators[which].shell {
            let kept = self.coordinators[which].disk.newest().map(|(record, _)| *record).unwrap_or_default();
            let is_kept = kept == shell.to_remember();
            let order = shell.order();
            self.observer.order_sent(self.now, which, &order, is_kept);
            if order.mode == ControlMode::EStop {
                self.coordinators[which].stopped = self.now;
            }
        }
        for at in 0..self.stations.len() {
            let Some(shell) = &self.coordinators[which].shell else { return };
            let order = shell.order_for(StationId::at(at));
            if let Some(generation) = order.found {
                self.observer.founds(at, (generation, order.station_life));
            }
            let message = Message::Order { sequence, order };
            if which == 0 {
                let kept = &mut self.orders[at];
                kept.push_back((self.now, message.clone()));
                while kept.len() > ORDERS_KEPT {
                    kept.pop_front();
                }
            }
            self.send(node, at, message);
        }
        let Some(shell) = &self.coordinators[which].shell else { return };
        let order = shell.order();
        self.send(node, self.coordinator_node() + 1 - which, Message::Order { sequence, order });
    }

    /// Begins to write a record. Gives whether it goes on; nothing while the record is being written.
    fn coordinator_remembers(&mut self, which: usize, record: CoordinatorRecord) -> Option<bool> {
        let now = self.now;
        let mutant = self.mutant;
        let believes_failure = mutant == Some(Mutant::FailedRecordIgnored);
        let is_early = mutant == Some(Mutant::CoordinatorAcknowledgedEarly);
        let coordinator = &mut self.coordinators[which];
        let local = coordinator.process.clock(now);
        let (takes, succeeds) = coordinator.disk.write_takes();
        if (takes.is_zero() || is_early) && succeeds || believes_failure && !succeeds {
            if succeeds && takes.is_zero() {
                coordinator.store(mutant, record);
            }
            if record.estop && which == 0 {
                self.observer.stop_is_recorded();
            }
            return coordinator.shell.as_mut().map(|shell| shell.remembered(local, record, true));
        }
        coordinator.under_way = Some(record);
        coordinator.awaited = Some(record);
        coordinator.process.writing = Some(Writing { takes, succeeds, is_off: false });
        let life = coordinator.process.life;
        let node = self.coordinator_node() + which;
        self.after(takes, Event::Written { node, life });
        self.awaits(which);
        None
    }

    /// It waits for a record: until images are too old, and in the emergency stop until the order is due again.
    fn awaits(&mut self, which: usize) {
        let (now, timing) = (self.now, self.line.timing);
        let node = self.coordinator_node() + which;
        let coordinator = &self.coordinators[which];
        let Some(shell) = &coordinator.shell else { return };
        let local = coordinator.process.clock(now);
        let in_stop = shell.coordinator().mode() == ControlMode::EStop;
        let until = shell.images_until(local).map_or(Tick::NEVER, |until| coordinator.process.world(until));
        let life = coordinator.process.life;
        let slow = until.min(now + timing.stale).max(now).since(now);
        self.after(slow, Event::SlowRecord { node, life });
        if in_stop {
            self.after(timing.refresh, Event::OrderAgain { life });
        }
    }

    pub(crate) fn coordinator_written(&mut self, which: usize) {
        let now = self.now;
        let coordinator = &mut self.coordinators[which];
        let (Some(writing), Some(record)) = (coordinator.process.writing.take(), coordinator.under_way.take()) else {
            return;
        };
        if writing.succeeds {
            coordinator.store(self.mutant, record);
            if record.estop && which == 0 {
                self.observer.stop_is_recorded();
            }
        }
        let coordinator = &mut self.coordinators[which];
        let Some(awaited) = coordinator.awaited.take() else { return };
        let goes_on = if awaited == record {
            let local = coordinator.process.clock(now);
            coordinator.shell.as_mut().map(|shell| shell.remembered(local, record, writing.succeeds))
        } else {
            self.coordinator_remembers(which, awaited)
        };
        match goes_on {
            None => return,
            Some(true) => {
                if !self.perform_coordinator(which) {
                    self.coordinators[which].effects.clear();
                }
            }
            Some(false) => self.coordinators[which].effects.clear(),
        }
        self.run_coordinator(which);
    }

    /// While a record is being written something arrives that may not wait for it.
    pub(crate) fn arrives_while_writing(&mut self, which: usize, message: &Message) {
        match message {
            Message::Command(ModeCommand::EStop) => self.interrupt_coordinator(which),
            Message::Outputs { station, image, .. } => {
                let wanted = if image.valid { image.bits } else { 0 };
                let coordinator = &mut self.coordinators[which];
                let staying = coordinator.shell.as_mut().and_then(|shell| shell.keep_only(*station, wanted));
                if let (Some(staying), true) = (staying, coordinator.has_bus) {
                    self.put(station.index(), staying);
                }
            }
            _ => {}
        }
    }

    pub(crate) fn is_awaiting(&self, which: usize) -> bool {
        self.coordinators[which].awaited.is_some()
    }

    /// In the emergency stop the record comes last; otherwise what follows the record is decided again.
    fn interrupt_coordinator(&mut self, which: usize) {
        let now = self.now;
        let coordinator = &mut self.coordinators[which];
        let in_stop = coordinator.mode() == Some(ControlMode::EStop);
        if coordinator.awaited.is_none() || in_stop || self.mutant == Some(Mutant::StopWaitsForRecord) {
            return;
        }
        coordinator.awaited = None;
        coordinator.effects.clear();
        if let Some(shell) = &mut coordinator.shell {
            shell.interrupted(coordinator.process.clock(now));
        }
        self.run_coordinator(which);
    }

    /// The inputs of the console, or of a station behind the gateway, have changed.
    pub(crate) fn console_news(&mut self, at: usize) {
        if self.is_awaiting(0) && at == self.stations.len() && self.coordinators[0].process.runs() {
            self.interrupt_coordinator(0);
        }
        self.run_coordinator(0);
    }

    /// A record takes longer than images are valid: outputs of stations go off.
    pub(crate) fn slow_record(&mut self, which: usize) {
        let coordinator = &mut self.coordinators[which];
        let keeps = self.mutant == Some(Mutant::SlowRecordKeepsOutputs);
        if !coordinator.process.runs() || coordinator.awaited.is_none() || !coordinator.has_bus || keeps {
            return;
        }
        for at in self.behind_gateway() {
            self.put(at, 0);
        }
    }

    /// While a record is being written in the emergency stop the order is repeated.
    pub(crate) fn order_again(&mut self, life: u64) {
        let Some(which) = (0..2).find(|&which| self.coordinators[which].process.life == life) else { return };
        let coordinator = &mut self.coordinators[which];
        let in_stop = coordinator.mode() == Some(ControlMode::EStop);
        if coordinator.awaited.is_none() || !coordinator.process.is_up || !in_stop {
            return;
        }
        let runs = coordinator.process.runs();
        let sequence = coordinator.shell.as_mut().filter(|_| runs).map(CoordinatorShell::repeat_order);
        if let Some(sequence) = sequence {
            self.send_order(which, sequence);
        }
        // A timer that has run out while it stood rings when it runs again.
        let again = if runs { self.line.timing.refresh } else { Duration::from_millis(1) };
        self.after(again, Event::OrderAgain { life });
    }
}
