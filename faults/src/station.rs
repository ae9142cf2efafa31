//! A station's process: its shell, and its effects performed one after another.

use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

use linewright_coordinator_logic::OutputImage;
use linewright_line::StationId;
use linewright_station_logic::{Restore, StationSnapshot};
use linewright_station_shell::{Driven, StationArrival, StationEffect, StationShell};

use crate::devices::SeenImage;
use crate::disk::SimulatedDisk;
use crate::message::{CONSOLE, Message};
use crate::mutants::Mutant;
use crate::process::{Process, Writing};
use crate::world::{Event, World};

pub(crate) struct StationProcess {
    id: StationId,
    pub(crate) process: Process,
    pub(crate) shell: Option<StationShell>,
    pub(crate) disk: SimulatedDisk<StationSnapshot>,
    effects: VecDeque<StationEffect>,
    /// The record before the effects that are left took long.
    is_late: bool,
    /// Image of its own devices, as last taken.
    pub(crate) seen: Option<SeenImage>,
    /// Outputs put out last, but for interruptions.
    pub(crate) driven: u128,
    /// The record that is being written.
    under_way: Option<StationSnapshot>,
}

impl StationProcess {
    pub(crate) fn new(id: StationId) -> Self {
        StationProcess {
            id,
            process: Process::new(),
            shell: None,
            disk: SimulatedDisk::new(),
            effects: VecDeque::new(),
            is_late: false,
            seen: None,
            driven: 0,
            under_way: None,
        }
    }

    pub(crate) fn die(&mut self, record_is_there: bool) {
        if let Some(record) = self.under_way.take()
            && record_is_there
        {
            self.disk.store(record);
        }
        self.process.end();
        self.shell = None;
        self.effects.clear();
    }
}

impl World {
    pub(crate) fn start_station(&mut self, at: usize, remembers: bool) {
        if !self.stations[at].disk.write_takes().1 {
            // A disk that takes nothing keeps the journal from being opened.
            self.after(Duration::from_millis(500), Event::Restart { node: at, remembers });
            return;
        }
        let (life, boot_id) = self.next_life();
        let origin = self.rng.within(86_400_000_000, 90_000_000_000);
        if !remembers {
            self.stations[at].disk.lose();
        }
        if self.mutant == Some(Mutant::RecordBeforeLastRead) {
            self.stations[at].disk.skip_newest();
        }
        let id = StationId::at(at);
        let believes = self.mutant == Some(Mutant::HostStartIgnored);
        let keeps_counts = self.mutant == Some(Mutant::GenerationAfterPowerCut);
        let restore = match self.stations[at].disk.newest() {
            Some((record, is_of_this_start)) => {
                let mut record = record.clone();
                // As the node does with a record from before the last start of the host.
                if !is_of_this_start && !believes {
                    record.placed = false;
                    record.generation = if keeps_counts { record.generation } else { 0 };
                }
                // Either alone keeps agreements apart: a number that is never used again, and the life that it belongs to.
                if self.mutant == Some(Mutant::AgreementsOfEarlierLives) {
                    record.next_request = 1;
                }
                Restore::From(record)
            }
            None => self.without_memory(id, boot_id),
        };
        match StationShell::new(&self.line, id, boot_id, restore) {
            Ok(shell) => {
                let station = &mut self.stations[at];
                station.shell = Some(match self.mutant {
                    Some(mutant) => shell.with_rules(mutant.rules()).with_shell_rules(mutant.shell_rules()),
                    None => shell,
                });
                station.process.begin(life, origin);
                (station.seen, station.driven, station.is_late) = (None, 0, false);
                let generation = station.shell.as_ref().map_or(0, |shell| shell.controller().generation());
                self.observer.restarted(&self.line, self.now, at, (generation, station.disk.number()));
            }
            Err(error) => {
                let text = format!("{} does not start from its own record: {error}", self.name(at));
                return self.observer.find(self.now, text);
            }
        }
        self.take_devices(at);
        self.run_station(at);
    }

    /// What a station without a journal begins with.
    fn without_memory(&self, id: StationId, boot_id: u64) -> Restore {
        if self.mutant == Some(Mutant::MemorylessBelieved)
            && let Some(other) = self.stations.iter().find_map(|other| other.shell.as_ref())
            && let Ok(fresh) = StationShell::new(&self.line, id, boot_id, Restore::Fresh)
        {
            let mut record = fresh.snapshot();
            (record.generation, record.placed) = (other.controller().generation(), true);
            return Restore::From(record);
        }
        if self.mutant == Some(Mutant::HomeUnconfirmed)
            && let Ok(fresh) = StationShell::new(&self.line, id, boot_id, Restore::Fresh)
        {
            return Restore::From(StationSnapshot { placed: true, ..fresh.snapshot() });
        }
        Restore::Fresh
    }

    pub(crate) fn run_station(&mut self, at: usize) {
        let now = self.now;
        let is_own = !self.is_behind_gateway(at);
        if !self.stations[at].process.runs() || self.stations[at].process.writing.is_some() {
            return;
        }
        while let Some((message, delivered, is_seen)) = self.stations[at].process.inbox.pop_front() {
            if !is_seen {
                self.arrives(at, &message, delivered);
            }
            self.take_at_station(at, message);
        }
        let image = self.io[at].image(now, &self.plant);
        let station = &mut self.stations[at];
        let Some(shell) = &mut station.shell else { return };
        let local = station.process.clock(now);
        let mut effects = Vec::new();
        let is_lost = is_own && station.seen.is_some_and(|seen| seen.losses != image.losses);
        let under_way = motions(shell);
        if is_own && station.seen != Some(image) {
            station.seen = Some(image);
            let SeenImage { bits, valid, losses } = image;
            let losses = if self.mutant == Some(Mutant::LossesUnseen) { 0 } else { losses };
            shell.handle(local, StationArrival::Devices { bits, valid, losses }, &mut effects);
        }
        shell.act(local, &mut effects);
        let goes_on = motions(shell) & under_way;
        if is_lost && goes_on != 0 {
            let name = &self.line.stations[at].name;
            self.observer.find(now, format!("{name}: a motion goes on across a loss of its devices"));
        }
        if self.mutant == Some(Mutant::RecordAfterEffects) {
            effects.sort_by_key(|effect| matches!(effect, StationEffect::Remember));
        }
        if effects.iter().any(|effect| matches!(effect, StationEffect::Remember)) {
            let snapshot = shell.snapshot();
            let mode = shell.controller().mode();
            let stations = &self.stations;
            self.observer.counted(&self.line, &self.plant, (self.now, at, mode), snapshot, &|other| {
                let other = &stations[other];
                // What was lost with the power is not known any more.
                let of_disk = || other.disk.newest().filter(|(_, is_new)| *is_new).map(|(record, _)| record.clone());
                other.shell.as_ref().map(StationShell::snapshot).or_else(of_disk)
            });
        }
        self.stations[at].effects.extend(effects);
        self.stations[at].is_late = false;
        self.perform_station(at);
    }

    fn take_at_station(&mut self, at: usize, message: Message) {
        let message = self.mutated(at, message);
        self.hand_to_station(at, &message);
    }

    /// Gives a message to the shell.
    pub(crate) fn hand_to_station(&mut self, at: usize, message: &Message) {
        let local = self.stations[at].process.clock(self.now);
        let Some(shell) = &mut self.stations[at].shell else { return };
        let mut effects = Vec::new();
        match message {
            Message::Order { sequence, order } => {
                let (sequence, order) = (*sequence, *order);
                shell.handle(local, StationArrival::Order { sequence, from: [0; 12], order }, &mut effects);
            }
            Message::State { station, sequence, report, .. } => {
                let (station, sequence) = (*station, *sequence);
                shell.handle(local, StationArrival::State { station, sequence, report }, &mut effects);
            }
            Message::Inputs(image) => shell.handle(local, StationArrival::Inputs(*image), &mut effects),
            Message::Panel(command) => {
                shell.handle(local, StationArrival::Panel { console: CONSOLE, command: *command }, &mut effects);
            }
            Message::Rejoin(place) => shell.handle(local, StationArrival::Rejoin(*place, &[]), &mut effects),
            Message::Outputs { .. } | Message::Command(_) | Message::Buttons(_) | Message::Resume(_) => {}
        }
    }

    fn perform_station(&mut self, at: usize) {
        while let Some(effect) = self.stations[at].effects.pop_front() {
            match &mut self.stations[at].process.dies_after {
                Some(0) => {
                    self.note(format!("{} dies before {}", self.name(at), kind(&effect)));
                    return self.kill(at);
                }
                Some(left) => *left -= 1,
                None => {}
            }
            match effect {
                StationEffect::Remember => {
                    if !self.station_remembers(at) {
                        return;
                    }
                }
                StationEffect::Drive(_) if self.stations[at].is_late => {}
                StationEffect::Drive(image) => self.drive(at, image, true),
                StationEffect::Tell { sequence } => self.tell(at, sequence),
                StationEffect::Reply(..) | StationEffect::Happened(_) | StationEffect::Ignored { .. } => {}
            }
        }
        if let Some(shell) = &self.stations[at].shell {
            self.wake(at, shell.next_deadline());
        }
    }

    /// Writes the record down; false if it is still being written.
    fn station_remembers(&mut self, at: usize) -> bool {
        let (now, stale) = (self.now, self.line.timing.stale);
        let is_dropped = self.mutant == Some(Mutant::RecordNotKept);
        let is_early = self.mutant == Some(Mutant::AcknowledgedBeforeWritten);
        let station = &mut self.stations[at];
        let Some(shell) = &mut station.shell else { return false };
        let record = shell.snapshot();
        let (takes, succeeds) = station.disk.write_takes();
        if succeeds && (takes.is_zero() || is_early) {
            if takes.is_zero() && !is_dropped {
                self.store(at, record);
            }
            let station = &mut self.stations[at];
            let Some(shell) = &mut station.shell else { return false };
            station.is_late = !shell.remembered(station.process.clock(now));
            return true;
        }
        let next = station.effects.iter().find_map(|effect| match effect {
            StationEffect::Drive(image) => Some(image.bits),
            _ => None,
        });
        let waiting = station.driven & !next.unwrap_or(station.driven);
        self.observer.waits_to_go_off(&self.line, (now, at), waiting);
        let station = &mut self.stations[at];
        station.under_way = Some(record);
        station.process.writing = Some(Writing { takes, succeeds, is_off: false });
        let life = station.process.life;
        self.after(takes, Event::Written { node: at, life });
        self.after(stale, Event::SlowRecord { node: at, life });
        false
    }

    fn store(&mut self, at: usize, record: StationSnapshot) {
        let record = self.mutated_record(at, record);
        self.stations[at].disk.store(record);
    }

    pub(crate) fn station_written(&mut self, at: usize) {
        let now = self.now;
        let station = &mut self.stations[at];
        let Some(writing) = station.process.writing.take() else { return };
        let record = station.under_way.take();
        if !writing.succeeds {
            // The node ends, with its outputs off, and its supervisor starts it again.
            let off = station.shell.as_mut().map(StationShell::off);
            if let Some(off) = off {
                self.drive(at, off, false);
            }
            self.note(format!("{} ends: its journal cannot be written", self.name(at)));
            self.kill(at);
            self.after(Duration::from_millis(700), Event::Restart { node: at, remembers: true });
            return;
        }
        if let Some(record) = record {
            self.store(at, record);
        }
        self.observer.held_up(at, writing.takes);
        let station = &mut self.stations[at];
        if let Some(shell) = &mut station.shell {
            station.is_late = !shell.remembered(station.process.clock(now));
        }
        self.perform_station(at);
        self.run_station(at);
    }

    /// An emergency stop has arrived while a record is being written, or the record takes long.
    pub(crate) fn interrupt_station(&mut self, at: usize) {
        let station = &mut self.stations[at];
        let runs = station.process.runs();
        let Some(writing) = &mut station.process.writing else { return };
        let waits = [Some(Mutant::StopWaitsForRecord), Some(Mutant::SlowRecordKeepsOutputs)].contains(&self.mutant);
        if !runs || std::mem::replace(&mut writing.is_off, true) || waits {
            return;
        }
        let off = station.shell.as_mut().map(StationShell::interrupt);
        if let Some(off) = off {
            self.drive(at, off, false);
        }
    }

    fn drive(&mut self, at: usize, image: Driven, is_decided: bool) {
        if is_decided {
            let rising = image.bits & !std::mem::replace(&mut self.stations[at].driven, image.bits);
            let station = &self.stations[at];
            if let Some(shell) = &station.shell {
                let record = || (shell.snapshot(), station.disk.newest().map(|(record, _)| record.clone()));
                let mode = shell.controller().mode();
                self.observer.driven(&self.line, (self.now, at), rising, mode, record);
            }
        } else {
            // Off without a decision: on again is a rise.
            self.stations[at].driven &= image.bits;
        }
        if !self.is_behind_gateway(at) {
            return self.put(at, image.bits);
        }
        let Some(shell) = &self.stations[at].shell else { return };
        let message = Message::Outputs {
            station: self.stations[at].id,
            sequence: image.sequence,
            image: OutputImage {
                bits: image.bits,
                valid: true,
                losses: image.lives,
                boot_id: shell.boot_id(),
                number: image.number,
                mode_epoch: image.mode_epoch,
            },
        };
        for node in [self.coordinator_node(), self.coordinator_node() + 1] {
            self.send(at, node, message.clone());
        }
    }

    fn tell(&mut self, at: usize, sequence: u64) {
        let station = &self.stations[at];
        let Some(shell) = &station.shell else { return };
        let controller = shell.controller();
        let mut report = controller.report();
        report.measured_age += station.process.clock(self.now).since(controller.stepped());
        let record = station.disk.newest().map(|(record, _)| record);
        self.observer.told(&self.line, (self.now, at), &report, &shell.snapshot(), record, station.disk.number());
        let (report, follows) = (Rc::new(report), controller.followed());
        let message = Message::State { station: station.id, sequence, follows, report };
        for node in 0..self.stations.len() + 2 {
            if node != at {
                self.send(at, node, message.clone());
            }
        }
    }
}

/// The operations under way, a bit each.
fn motions(shell: &StationShell) -> u64 {
    let moving = shell.controller().marking().filter(|place| place.is_operating());
    moving.fold(0, |bits, place| bits | 1 << place.op.index())
}

fn kind(effect: &StationEffect) -> &'static str {
    match effect {
        StationEffect::Remember => "its record",
        StationEffect::Drive(_) => "its outputs",
        StationEffect::Tell { .. } => "its state",
        StationEffect::Reply(..) => "an answer",
        StationEffect::Happened(_) | StationEffect::Ignored { .. } => "an event",
    }
}
