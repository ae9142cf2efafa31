//! Messages as they arrive, and hands that hold buttons.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{StationId, Tick};
use linewright_station_logic::PanelCommand;

use crate::checks::SeenState;
use crate::message::Message;
use crate::mutants::Mutant;
use crate::world::{Event, World};

/// Messages that may wait for a process that stands; those of topics that are repeated are replaced sooner.
const WAITING_MAX: usize = 200;
/// Number of repetitions of a release.
const RELEASES: u8 = 5;

/// Number of a forged order: no coordinator gives as many.
pub(crate) const FORGED_NUMBER: u64 = u64::MAX;

impl World {
    pub(crate) fn deliver(&mut self, to: usize, life: u64, message: Message) {
        let stations = self.stations.len();
        let now = self.now;
        let process = self.process(to);
        if !process.is_up || process.life != life {
            return;
        }
        let runs = process.runs();
        let is_stop = matches!(&message, Message::Order { order, .. } if order.mode == ControlMode::EStop);
        if process.inbox.len() < WAITING_MAX || message.topic().is_none() || is_stop {
            process.inbox.push_back((message.clone(), now, runs));
        }
        if !runs {
            return;
        }
        self.arrives(to, &message, now);
        if to < stations {
            if is_stop {
                self.interrupt_station(to);
            }
        } else if self.is_awaiting(to - stations) {
            self.arrives_while_writing(to - stations, &message);
        }
        self.run_node(to);
    }

    fn selects_manual(&self, at: usize) -> bool {
        self.controller(at).is_some_and(|of| of.report().selector_manual)
    }

    /// A process that runs has received a message, whatever it does at the moment. What has waited for a process that stood, for
    /// longer than a standstill may last without being noticed, counts from when it was `delivered`.
    pub(crate) fn arrives(&mut self, to: usize, message: &Message, delivered: Tick) {
        let timing = self.line.timing;
        let has_waited = self.now > delivered + timing.refresh + timing.stale;
        let since = if has_waited { delivered } else { self.now };
        let soon = Duration::from_millis(20);
        if to < self.stations.len()
            && let Message::State { station, sequence, report, .. } = message
        {
            let seen = SeenState::of(self.now, *sequence, report);
            self.observer.state_arrived(to, station.index(), seen, since);
        }
        match message {
            Message::Order { order, sequence } if to < self.stations.len() => {
                let coordinator = self.coordinators[0].shell.as_ref().map(|shell| shell.coordinator());
                let in_stop = coordinator.is_some_and(|of| of.mode() == ControlMode::EStop);
                let by_selector = || (0..self.stations.len()).any(|at| self.selects_manual(at));
                let manual_waits = coordinator
                    .filter(|_| in_stop)
                    .is_some_and(|of| of.order().manual_all || (!of.standing().is_latched && by_selector()));
                let stop = self.observer.ordered((self.now, since), to, order, (in_stop, manual_waits));
                // One with a longer lease is not taken, and its number neither.
                if *sequence == FORGED_NUMBER && order.lease <= timing.lease {
                    self.observer.deafened(to, self.now + timing.lease.max(timing.stale) + 2 * timing.refresh);
                    self.observer.forget_lives(to);
                }
                if let Some(stop) = stop {
                    let behind = self.is_behind_gateway(to);
                    let bound = if behind { 2 * timing.stale + timing.heartbeat_timeout } else { Duration::ZERO };
                    self.after(bound + soon, Event::LooksForOff { station: to, stop });
                }
            }
            Message::Command(command) if to >= self.stations.len() => {
                let shell = self.coordinators[to - self.stations.len()].shell.as_ref();
                let is_stopped = shell.is_some_and(|shell| shell.coordinator().mode() == ControlMode::EStop);
                self.observer.commanded(to, *command, is_stopped);
                let is_manual = match command {
                    ModeCommand::Manual => true,
                    // One that is not at manual any more, and that the coordinator has not received so, counts there.
                    ModeCommand::Reset => {
                        (0..self.stations.len()).any(|at| self.selects_manual(at))
                            || shell.is_some_and(|shell| shell.coordinator().any_selector())
                    }
                    _ => false,
                };
                if is_manual {
                    self.manual_is_wanted();
                }
                if *command == ModeCommand::EStop {
                    let (which, since) = (to - self.stations.len(), self.now);
                    let life = self.process(to).life;
                    self.after(soon, Event::LooksForStop { which, life, since });
                }
                if *command == ModeCommand::EStop && to == self.stations.len() {
                    let stop = self.observer.stop_number();
                    for station in self.behind_gateway() {
                        self.after(soon, Event::LooksForOff { station, stop });
                    }
                }
            }
            Message::Outputs { station, sequence, image } if to == self.stations.len() => {
                let at = station.index();
                let newest = (image.bits, image.mode_epoch);
                self.observer.image_arrived(self.now, at, (image.boot_id, *sequence), newest);
                if self.mutant_is(Mutant::ImagesDrivenAtOnce) {
                    self.put(at, image.bits);
                }
            }
            Message::Panel(PanelCommand::Selector(true)) => self.manual_is_wanted(),
            _ => {}
        }
    }

    fn manual_is_wanted(&mut self) {
        let epoch = self.coordinators[0].shell.as_ref().map_or(0, |shell| shell.coordinator().epoch());
        self.observer.manual_is_wanted(self.now, epoch);
    }

    pub(crate) fn press(&mut self, station: usize, advance: bool, down: bool) {
        if down {
            self.hands.panel.insert((station, advance), None);
        } else if self.hands.panel.contains_key(&(station, advance)) {
            self.hands.panel.insert((station, advance), Some(RELEASES));
        }
        self.say_panel(station, advance, down);
    }

    fn say_panel(&mut self, station: usize, advance: bool, down: bool) {
        let command = if advance { PanelCommand::Advance(down) } else { PanelCommand::Retract(down) };
        self.send(self.operator_node(), station, Message::Panel(command));
    }

    pub(crate) fn hold_buttons(&mut self, held: u32) {
        (self.hands.buttons, self.hands.releases) = (held, RELEASES);
        self.send(self.operator_node(), self.coordinator_node(), Message::Buttons(held));
    }

    pub(crate) fn hold_resume(&mut self, held: bool) {
        (self.hands.resume, self.hands.resume_releases) = (held, RELEASES);
        self.send(self.operator_node(), self.coordinator_node(), Message::Resume(held));
    }

    /// Held buttons are sent again, and recent releases.
    pub(crate) fn hands_again(&mut self) {
        let held: Vec<((usize, bool), Option<u8>)> = self.hands.panel.iter().map(|(key, left)| (*key, *left)).collect();
        for ((station, advance), left) in held {
            self.say_panel(station, advance, left.is_none());
        }
        self.hands.panel.retain(|_, left| {
            *left = left.map(|left| left - 1);
            *left != Some(0)
        });
        if self.hands.buttons != 0 || self.hands.releases > 0 {
            self.hands.releases = self.hands.releases.saturating_sub(1);
            let held = self.hands.buttons;
            self.send(self.operator_node(), self.coordinator_node(), Message::Buttons(held));
        }
        if self.hands.resume || self.hands.resume_releases > 0 {
            self.hands.resume_releases = self.hands.resume_releases.saturating_sub(1);
            let held = self.hands.resume;
            self.send(self.operator_node(), self.coordinator_node(), Message::Resume(held));
        }
        self.renew();
        if self.coordinators[0].process.runs() {
            let reached: Vec<usize> =
                self.behind_gateway().into_iter().filter(|&at| self.io[at].unreached.is_none()).collect();
            for at in reached {
                self.observer.look_at_age(&self.line, &self.plant, self.now, at);
            }
        }
        self.plant.advance(self.now);
        for at in (0..self.stations.len()).filter(|&at| self.io[at].is_lost(self.now)) {
            self.observer.has_no_manager(&self.line, &self.plant, at);
        }
        self.after(self.line.timing.refresh, Event::Hands);
    }

    pub(crate) fn say_selector(&mut self, station: usize, manual: bool) {
        self.send(self.operator_node(), station, Message::Panel(PanelCommand::Selector(manual)));
    }

    /// A command, to every coordinator that is there.
    pub(crate) fn say_command(&mut self, command: ModeCommand) {
        for node in [self.coordinator_node(), self.coordinator_node() + 1] {
            self.send(self.operator_node(), node, Message::Command(command));
        }
    }

    pub(crate) fn say_rejoin(&mut self, station: usize, place: linewright_station_logic::RejoinAt) {
        self.send(self.operator_node(), StationId::at(station).index(), Message::Rejoin(place));
    }
}
