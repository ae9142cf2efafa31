//! Faults of a plan: how each begins and ends.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{InputId, OpId, Owner, StationId, Tick};
use linewright_plant::MotionFault;
use linewright_station_logic::ModeOrder;
use linewright_station_shell::EPOCH_JUMP_MAX;

use crate::deliver::FORGED_NUMBER;
use crate::disk::DiskState;
use crate::message::Message;
use crate::mutants::Mutant;
use crate::network::Weather;
use crate::observer::TOLERANCE;
use crate::plan::{FaultEvent, ForgedEpoch};
use crate::world::{Event, World};

/// Nothing comes back sooner than this: a process takes longer to start.
const START: Duration = Duration::from_millis(20);

impl World {
    pub(crate) fn begin_fault(&mut self, at: usize) {
        if self.is_mended {
            return;
        }
        let fault = self.plan[at];
        let (now, stations) = (self.now, self.stations.len());
        let text = self.text_of(&fault.event, fault.lasts);
        self.note(text);
        let mut lasts = fault.lasts;
        match fault.event {
            FaultEvent::Kill { node, after, .. } => {
                lasts = lasts.max(START);
                if after == 0 || !self.process(node).is_up {
                    self.kill(node);
                } else {
                    self.process(node).dies_after = Some(after);
                }
            }
            FaultEvent::KillAll => {
                lasts = lasts.max(START);
                (0..=stations).for_each(|node| self.kill(node));
            }
            FaultEvent::PowerCut(node) => {
                lasts = lasts.max(START);
                self.kill(node);
                let rng = &mut self.rng;
                match self.stations.get_mut(node) {
                    Some(station) => station.disk.power_cut(rng),
                    None => self.coordinators[0].disk.power_cut(rng),
                }
                if node == stations {
                    let keeps = self.coordinators[0].disk.newest().is_some_and(|(record, _)| record.estop);
                    self.observer.disk_keeps(keeps);
                }
            }
            FaultEvent::Stall { node, suspends } => {
                let process = self.process(node);
                process.stalls += 1;
                if suspends {
                    process.suspend(now);
                }
                for owner in self.managed(node) {
                    self.io[owner].lose(now, &self.plant);
                    self.after_plant(owner);
                }
            }
            FaultEvent::Disk(node, state) => self.set_disk(node, state),
            FaultEvent::Cut { from, to, .. } => self.network.cut(from, to),
            FaultEvent::Slow { from, to, by, is_even } => self.network.slow((from, to), by, is_even),
            FaultEvent::Provoked(what, draw) => self.provoke(what, draw),
            FaultEvent::Network(weather) => self.network.weather = weather,
            FaultEvent::OldOrder { station, age } => {
                let old = self.orders[station].iter().rev().find(|(at, _)| *at + age <= now);
                if let Some(message) = old.or(self.orders[station].front()).map(|(_, message)| message.clone()) {
                    self.send(self.operator_node(), station, message);
                }
            }
            FaultEvent::ForgedOrder { station, mode, epoch, is_followed, is_long } => {
                self.forge_order((station, mode), epoch, (is_followed, is_long));
            }
            FaultEvent::ForgedState { station, to, boot_id, sequence, epoch } => {
                self.forge_state((station, to), (boot_id, sequence, epoch));
            }
            FaultEvent::Reboot(owner) => {
                self.io[owner].reboot(now, &mut self.plant);
                self.look_at_devices(owner);
            }
            FaultEvent::BusOff(owner) => {
                self.io[owner].lose(now, &self.plant);
                self.after_plant(owner);
            }
            // No controller keeps a mechanism from coming back into a conflict by itself, just after it has been seen outside and
            // another station has begun on that. Where nothing begins it slips all the same.
            FaultEvent::Motion(station, op, normal, MotionFault::SlipBack)
                if self.may_begin() && self.has_left((station, op), normal) => {}
            FaultEvent::Motion(station, op, normal, fault) => {
                if normal {
                    self.plant.inject(now, station, op, Some(fault));
                } else {
                    self.plant.inject_recovery(now, station, op, Some(fault));
                }
                self.look_at_devices(station.index());
            }
            FaultEvent::SwitchOff(station, input) => self.force(station, input, Some(false)),
            FaultEvent::SwitchOn(station, input) => {
                if self.plant.inputs(Owner::Station(station)) & input.bit() != 0 {
                    self.force(station, input, Some(true));
                }
            }
            FaultEvent::Rival => self.start(stations + 1, false),
            FaultEvent::Command(command) => self.say_command(command),
            FaultEvent::Press(station, advance) => self.press(station, advance, true),
            FaultEvent::Buttons(held) => self.hold_buttons(held),
            FaultEvent::Selector(station) => self.say_selector(station, true),
            FaultEvent::Resume => self.hold_resume(true),
        }
        self.active[at] = true;
        self.after(lasts, Event::FaultEnds(at));
    }

    fn force(&mut self, station: StationId, input: InputId, value: Option<bool>) {
        self.plant.force(Owner::Station(station), input, value);
        self.look_at_devices(station.index());
    }

    /// Whether a station may begin a motion.
    fn may_begin(&self) -> bool {
        let rests = [ControlMode::Home, ControlMode::StandBy, ControlMode::EStop];
        (0..self.stations.len()).any(|at| self.controller(at).is_some_and(|it| !rests.contains(&it.mode())))
    }

    /// Whether a motion that leads out of a conflict has arrived, or is as near as a switch is.
    fn has_left(&self, (station, op): (StationId, OpId), normal: bool) -> bool {
        let motion = self.line.operation((station, op)).motion;
        let end = if normal { motion.to } else { motion.from };
        let left = (self.plant.position(station, motion.axis) - end).abs();
        let spans = self.line.conflicts.iter().flat_map(|conflict| [conflict.a, conflict.b]);
        let mut own = spans.filter(|span| span.station == station);
        let leads_out = own.any(|span| op == if normal { span.until } else { span.from });
        leads_out && left <= TOLERANCE * (motion.to - motion.from).abs()
    }

    pub(crate) fn end_fault(&mut self, at: usize) {
        if !std::mem::take(&mut self.active[at]) {
            return;
        }
        let fault = self.plan[at];
        let now = self.now;
        match fault.event {
            FaultEvent::Kill { node, remembers, .. } => {
                if self.process(node).is_up {
                    self.process(node).dies_after = None;
                } else {
                    self.start(node, remembers);
                }
            }
            FaultEvent::KillAll => (0..=self.stations.len()).for_each(|node| self.start(node, true)),
            FaultEvent::PowerCut(node) => self.start(node, true),
            FaultEvent::Stall { node, .. } => self.end_stall(node),
            FaultEvent::Disk(node, _) => self.set_disk(node, DiskState::Good),
            FaultEvent::Cut { from, to, late } => {
                for message in self.network.join(from, to) {
                    if late {
                        self.send(from, to, message);
                    }
                }
            }
            FaultEvent::Network(_) => self.network.weather = Weather::GOOD,
            FaultEvent::BusOff(owner) => {
                self.io[owner].find(now, &mut self.plant);
                self.look_at_devices(owner);
            }
            FaultEvent::SwitchOff(station, input) | FaultEvent::SwitchOn(station, input) => {
                self.force(station, input, None);
            }
            FaultEvent::Motion(station, op, normal, _) => {
                if normal {
                    self.plant.inject(now, station, op, None);
                } else {
                    self.plant.inject_recovery(now, station, op, None);
                }
                self.look_at_devices(station.index());
            }
            FaultEvent::Rival => self.kill(self.coordinator_node() + 1),
            FaultEvent::Press(station, advance) => self.press(station, advance, false),
            FaultEvent::Buttons(_) => self.hold_buttons(0),
            FaultEvent::Selector(station) => self.say_selector(station, false),
            FaultEvent::Resume => self.hold_resume(false),
            FaultEvent::Slow { from, to, .. } => self.network.slow((from, to), Duration::ZERO, true),
            FaultEvent::Command(_)
            | FaultEvent::Provoked(..)
            | FaultEvent::Reboot(_)
            | FaultEvent::OldOrder { .. }
            | FaultEvent::ForgedOrder { .. }
            | FaultEvent::ForgedState { .. } => {}
        }
    }

    fn end_stall(&mut self, node: usize) {
        let (now, clock_stands) = (self.now, self.mutant == Some(Mutant::ClockStands));
        let process = self.process(node);
        process.stalls -= 1;
        let runs = process.stalls == 0;
        let late = if runs { process.resume(now, clock_stands) } else { None };
        for owner in self.managed(node) {
            self.io[owner].find(now, &mut self.plant);
            self.after_plant(owner);
        }
        match late {
            Some(at) => {
                let local = self.process(node).clock(at);
                self.wake(node, local);
            }
            None if runs => self.run_node(node),
            None => {}
        }
    }

    fn set_disk(&mut self, node: usize, state: DiskState) {
        match self.stations.get_mut(node) {
            Some(station) => station.disk.state = state,
            None => self.coordinators[0].disk.state = state,
        }
    }

    fn forge_order(
        &mut self,
        (station, mode): (usize, ControlMode),
        epoch: ForgedEpoch,
        (is_followed, is_long): (bool, bool),
    ) {
        let Some(shell) = &self.stations[station].shell else { return };
        let (controller, station_life) = (shell.controller(), shell.boot_id());
        let (followed, newest) = (controller.followed(), controller.mode_epoch());
        // A stranger that takes the very life, epoch and number of the coordinator cannot be told from it.
        let epoch = match epoch {
            ForgedEpoch::Zero => 0,
            // It goes on while the message is under way.
            ForgedEpoch::Next if is_followed && !is_long => newest.saturating_add(2 * EPOCH_JUMP_MAX),
            ForgedEpoch::Next => newest.saturating_add(1),
            ForgedEpoch::Last => u64::MAX,
        };
        // A station that has followed none follows whatever epoch comes first; one in emergency stop is in none anew, and leaves both
        // by the end of the first, which it may not have received yet.
        if newest == 0 || (mode == ControlMode::EStop && controller.mode() == ControlMode::EStop) {
            return;
        }
        let boot_id = if is_followed { followed } else { 0xBAD };
        let lease = if is_long { ModeOrder::FOR_GOOD } else { self.line.timing.lease };
        let order = ModeOrder { station_life, ..ModeOrder::of(boot_id, epoch, mode, lease) };
        self.send(self.operator_node(), station, Message::Order { sequence: FORGED_NUMBER, order });
    }

    fn forge_state(&mut self, (station, to): (usize, usize), (boot_id, sequence, epoch): (bool, bool, bool)) {
        let Some(shell) = self.stations[station].shell.as_ref().filter(|_| station != to) else { return };
        let controller = shell.controller();
        let mut report = controller.report();
        // Known from outside is only what was sent: an acknowledgement is not sent before its record is written.
        report.mode_epoch = report.mode_epoch.min(self.observer.stations[station].acknowledged);
        let follows = controller.followed();
        if boot_id {
            report.boot_id = 0xBAD;
        }
        if epoch {
            report.mode_epoch = u64::MAX;
        }
        let sequence = if sequence { u64::MAX } else { 0 };
        let station = StationId::at(station);
        let report = std::rc::Rc::new(report);
        self.send(self.operator_node(), to, Message::State { station, sequence, follows, report });
    }

    /// An emergency stop has had the time to turn off what was on.
    pub(crate) fn look_for_off(&mut self, station: usize, stop: u64) {
        let timeout = self.line.timing.heartbeat_timeout;
        let owner = Owner::Station(StationId::at(station));
        let reads = if self.is_behind_gateway(station) { self.coordinator_node() } else { station };
        let is_cut_off = self.io[station].unreached.is_some() || !self.process(reads).runs();
        if is_cut_off && self.plant.outputs(owner) != 0 {
            // Its devices turn off by themselves, after their time.
            return self.after(timeout, Event::LooksForOff { station, stop });
        }
        self.plant.advance(self.now);
        self.observer.has_to_be_off(&self.line, &self.plant, station, stop);
    }

    /// A coordinator has had the time to order an emergency stop.
    pub(crate) fn look_for_stop(&mut self, which: usize, life: u64, since: Tick) {
        let process = &self.coordinators[which].process;
        if process.life == life && process.runs() && process.resumed <= since {
            // In the emergency stop the order is repeated with every period.
            let has_ordered = self.coordinators[which].stopped + self.line.timing.refresh >= since;
            self.observer.passes_stop_on(self.now, has_ordered);
        }
    }

    /// All faults end.
    pub(crate) fn mend(&mut self) {
        self.is_mended = true;
        for at in 0..self.plan.len() {
            self.end_fault(at);
        }
        let held: Vec<(usize, bool)> = self.hands.panel.keys().copied().collect();
        held.into_iter().for_each(|(station, advance)| self.press(station, advance, false));
        self.hold_buttons(0);
        self.hold_resume(false);
    }

    fn text_of(&self, event: &FaultEvent, lasts: Duration) -> String {
        let (name, time) = (|node: usize| self.name(node), format!("{} ms", lasts.as_micros() as f64 / 1000.0));
        let owner = |at: usize| if at < self.stations.len() { self.name(at) } else { "console" };
        match *event {
            FaultEvent::Kill { node, after, remembers } => {
                let memory = if remembers { "" } else { ", started again without its journal" };
                format!("{} is killed after {after} effects, for {time}{memory}", name(node))
            }
            FaultEvent::KillAll => format!("every process is killed, for {time}"),
            FaultEvent::PowerCut(node) => format!("the host of {} loses its power for {time}", name(node)),
            FaultEvent::Stall { node, suspends: true } => format!("the machine of {} sleeps for {time}", name(node)),
            FaultEvent::Stall { node, .. } => format!("{} stands for {time}", name(node)),
            FaultEvent::Disk(node, DiskState::Failing(takes)) => {
                format!("the disk of {} fails after {takes:?} for {time}", name(node))
            }
            FaultEvent::Disk(node, state) => format!("the disk of {}: {state:?} for {time}", name(node)),
            FaultEvent::Cut { from, to, late } => {
                let late = if late { ", the last arrives late" } else { "" };
                format!("nothing from {} reaches {} for {time}{late}", name(from), name(to))
            }
            FaultEvent::Network(weather) => format!("the network is bad for {time}: {weather:?}"),
            FaultEvent::Slow { from, to, by, is_even } => {
                let by = format!("{}{by:?}", if is_even { "" } else { "up to " });
                format!("what {} sends to {} takes {by} longer for {time}", name(from), name(to))
            }
            FaultEvent::Provoked(what, _) => format!("provoked: {what:?}"),
            FaultEvent::OldOrder { station, age } => {
                format!("an order to {} of {age:?} ago arrives again", name(station))
            }
            FaultEvent::ForgedOrder { station, mode, epoch, is_followed, is_long } => {
                let lease = if is_long { ", for good" } else { "" };
                let life = if is_followed { "its coordinator's life" } else { "another life" };
                format!("a forged order to {}: {mode}, epoch {epoch:?}, {life}{lease}", name(station))
            }
            FaultEvent::ForgedState { station, to, boot_id, sequence, epoch } => {
                let what = [(boot_id, "life"), (sequence, "sequence"), (epoch, "epoch")];
                let what: Vec<&str> = what.into_iter().filter(|(is, _)| *is).map(|(_, what)| what).collect();
                format!("a forged state of {} to {}: another {}", name(station), name(to), what.join(", "))
            }
            FaultEvent::Reboot(at) => format!("the devices of {} restart", owner(at)),
            FaultEvent::BusOff(at) => format!("the bus of {} is off for {time}", owner(at)),
            FaultEvent::Motion(station, op, normal, fault) => {
                let undoing = if normal { "" } else { "undoing " };
                let operation = &self.line.operation((station, op)).name;
                format!("{}: {undoing}{operation}: {fault:?} for {time}", name(station.index()))
            }
            FaultEvent::SwitchOff(station, input) | FaultEvent::SwitchOn(station, input) => {
                let switch = &self.line.station(station).inputs[input.index()];
                let stays = if matches!(event, FaultEvent::SwitchOn(..)) { "stays on" } else { "off" };
                format!("{}: {switch} {stays} for {time}", name(station.index()))
            }
            FaultEvent::Rival => format!("a second coordinator for {time}"),
            FaultEvent::Command(command) => format!("command {}", command.name()),
            FaultEvent::Press(station, advance) => {
                let way = if advance { "advance" } else { "return" };
                format!("{way} of {} held for {time}", name(station))
            }
            FaultEvent::Buttons(held) => format!("buttons {held:#b} held for {time}"),
            FaultEvent::Resume => format!("resume held for {time}"),
            FaultEvent::Selector(station) => format!("selector of {} at manual for {time}", name(station)),
        }
    }
}
