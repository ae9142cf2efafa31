//! Checks of single rules, by what has arrived, what was written and what is driven.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, Owner, StationId, Tick};
use linewright_plant::Plant;
use linewright_station_logic::{ModeOrder, StationReport};
use linewright_station_shell::EPOCH_JUMP_MAX;

use crate::observer::Observer;

/// Time of a message and a step.
const SLACK: Duration = Duration::from_millis(60);

/// What a station has sent for so long is known to a coordinator that receives it at all.
const KNOWN: Duration = Duration::from_millis(450);
/// A message overtakes fewer than this many others of its writer.
const OVERTAKEN_MAX: u64 = 1000;
/// Orders of one life that come one after another are not further apart.
const CLOSE: Duration = Duration::from_millis(80);

/// A life of a coordinator whose orders arrive at a station.
#[derive(Debug)]
pub(crate) struct OrderingLife {
    life: u64,
    epoch: u64,
    /// Arrivals of those that came close behind each other.
    first: Tick,
    last: Tick,
    count: u32,
}

/// A station's state as it was sent, by what others rely on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SeenState {
    arrived: Tick,
    /// It has been like that since then.
    since: Tick,
    /// Life of the station, and since when it is this one: readers stay with the life before for a while.
    life: u64,
    life_since: Tick,
    /// Number of the message, of those of this life.
    sequence: u64,
    is_lost: bool,
    has_devices: bool,
    is_incomplete: bool,
    moves: bool,
}

impl SeenState {
    pub(crate) fn of(now: Tick, sequence: u64, report: &StationReport) -> Self {
        SeenState {
            arrived: now,
            since: now,
            life: report.boot_id,
            life_since: now,
            sequence,
            is_lost: report.position_lost.is_some(),
            has_devices: report.devices_valid,
            is_incomplete: !report.incomplete.is_empty(),
            moves: !report.stopped,
        }
    }

    /// Whether `newer` was sent after this one, by its number. The number of a forged message is too far away to count.
    fn was_overtaken_by(&self, newer: &SeenState) -> bool {
        let by = newer.sequence.checked_sub(self.sequence);
        self.life == newer.life && by.is_some_and(|by| (1..OVERTAKEN_MAX).contains(&by))
    }

    pub(crate) fn is_like(&self, other: &SeenState) -> bool {
        let all = |of: &SeenState| (of.is_lost, of.has_devices, of.is_incomplete, of.moves);
        all(self) == all(other)
    }
}

impl Observer {
    /// A station was restarted; `number` is that of its record. With a generation it goes on from its counts.
    pub(crate) fn restarted(&mut self, line: &Line, now: Tick, at: usize, (generation, number): (u64, u64)) {
        let station = &mut self.stations[at];
        station.generation = generation;
        if generation != 0 && number < station.sent {
            let name = &line.stations[at].name;
            self.find(now, format!("{name}: restarted from an older record than that of its last state"));
        } else {
            station.sent = number;
        }
    }

    /// A coordinator founds a generation, and names the life of the station that it means.
    pub(crate) fn founds(&mut self, at: usize, named: (u64, u64)) {
        let founded = &mut self.stations[at].founded;
        if !founded.contains(&named) {
            founded.push(named);
        }
    }

    /// A station counts in a generation from now on: it was founded for this life of it.
    pub(crate) fn takes_generation(&mut self, line: &Line, now: Tick, at: usize, report: &StationReport) {
        let station = &mut self.stations[at];
        let is_new = std::mem::replace(&mut station.generation, report.generation) != report.generation;
        if is_new && report.generation != 0 && !station.founded.contains(&(report.generation, report.boot_id)) {
            let name = &line.stations[at].name;
            self.find(now, format!("{name}: takes a generation that was founded for another life of it"));
        }
    }

    /// A state of one station has arrived at another; it counts as known there from `arrived` on.
    pub(crate) fn state_arrived(&mut self, at: usize, from: usize, seen: SeenState, arrived: Tick) {
        if let Some(view) = self.stations[at].views.get_mut(from) {
            if seen.was_overtaken_by(view) {
                return;
            }
            let since = if view.is_like(&seen) { view.since } else { seen.since };
            let life_since = if view.life == seen.life || view.life == 0 { view.life_since } else { seen.life_since };
            *view = SeenState { since, arrived, life_since, ..seen };
        }
    }

    /// Whether a station acts on another mode than that of the newest order that has arrived at it from its coordinator.
    pub(crate) fn acts_on_another_order(&self, line: &Line, now: Tick, at: usize, mode: ControlMode) -> bool {
        let station = &self.stations[at];
        let (newest, since) = station.newest_mode;
        let soon = 2 * line.timing.refresh + SLACK + station.held_up;
        // By itself it may always fall back to stand-by, and end there what a record that took long has under way.
        let is_by_itself = mode == ControlMode::StandBy && station.held_up > Duration::ZERO;
        let is_deaf = now <= station.deaf_until;
        station.lives.len() == 1 && mode != newest && !is_by_itself && !is_deaf && now > since + soon
    }

    /// In auto a motion starts only where the states of those that it waits for are not too old.
    pub(crate) fn starts_on_what_it_knows(
        &mut self,
        line: &Line,
        (now, at): (Tick, usize),
        rising: u128,
        mode: ControlMode,
    ) {
        let id = StationId::at(at);
        let station = &self.stations[at];
        let oldest = line.timing.stale + SLACK + station.held_up;
        let starts = |op: linewright_line::OpId| line.operation((id, op)).normal.actuator.bit() & rising != 0;
        let waits = line.arrows.iter().filter(|arrow| arrow.auto && arrow.to.0 == id && starts(arrow.to.1));
        let waited_for: Vec<StationId> = waits.map(|arrow| arrow.from.0).collect();
        let view = |from: &&StationId| &station.views[from.index()];
        let soon = SLACK + station.held_up;
        let is_taken = |view: &SeenState| now > view.since + soon && now > view.life_since + oldest;
        let lost = waited_for.iter().find(|from| view(from).is_lost && is_taken(view(from))).copied();
        if let (Some(from), ControlMode::Auto) = (lost, mode) {
            let (name, from) = (&line.stations[at].name, &line.station(from).name);
            return self.find(now, format!("{name}: a motion starts on a count of {from}, whose position is lost"));
        }
        let unmeasured = line.station(id).op_ids().filter(|&op| starts(op)).find_map(|op| {
            let step = line.station(id).step_of(op);
            line.conflicts.iter().find_map(|conflict| {
                let (own, other) = match (&conflict.a, &conflict.b) {
                    (own, other) if own.station == id => (own, other),
                    (other, own) if own.station == id => (own, other),
                    _ => return None,
                };
                let view = &station.views[other.station.index()];
                let is_inside = line.station(id).steps_of_span(own).contains(&step);
                let is_dark = !view.has_devices && is_taken(view);
                (is_inside && is_dark && line.clearance(other).is_ok()).then_some(other.station)
            })
        });
        if let (Some(other), ControlMode::Auto) = (unmeasured, mode) {
            let (name, other) = (&line.stations[at].name, &line.station(other).name);
            return self.find(now, format!("{name}: a motion starts though nothing measures where {other} stands"));
        }
        let unheard = waited_for.iter().find(|from| now > view(from).arrived + oldest).copied();
        if let (Some(from), ControlMode::Auto) = (unheard, mode) {
            let (name, from) = (&line.stations[at].name, &line.station(from).name);
            self.find(now, format!("{name}: a motion starts though no state of {from} has arrived for long"));
        }
    }

    /// The coordinator gives an order: its record is written, and every station that acts on it has acknowledged it.
    pub(crate) fn order_sent(&mut self, now: Tick, which: usize, order: &ModeOrder, is_kept: bool) {
        let moves = matches!(order.mode, ControlMode::Auto | ControlMode::Hand | ControlMode::Manual);
        if order.mode != ControlMode::EStop && !is_kept {
            self.find(now, format!("an order of epoch {} is given before its record is written", order.epoch));
        }
        if which != 0 {
            return;
        }
        if order.mode == ControlMode::EStop {
            self.stop_epoch = order.epoch;
        }
        if self.ordered_mode.0 != order.mode {
            if self.ordered_mode.0 == ControlMode::EStop && self.stop.is_none() {
                // What orders the stop in its life and in an epoch before this one is ended by this one.
                self.ended = self.ended.max(order.epoch.saturating_sub(1));
            }
            self.ordered_mode = (order.mode, order.epoch);
            self.enters(now, order.mode);
        }
        let is_dark = |at: &crate::observer::ObservedStation| !at.own.has_devices && now > at.own.since + 2 * KNOWN;
        if order.mode == ControlMode::Auto
            && order.enabled
            && let Some(at) = self.stations.iter().position(is_dark)
        {
            return self.find(now, format!("auto goes on, and station {at} has no devices for long"));
        }
        // Within a mode its epoch grows, as when the line is to stop at home.
        let since = self.ordered_mode.1;
        if moves && order.enabled && self.stations.iter().any(|at| at.acknowledged < since) {
            self.find(now, format!("{} is enabled before every station has acknowledged it", order.mode));
        }
    }

    /// Auto and manual are entered only where nothing that stations have sent for long speaks against it.
    fn enters(&mut self, now: Tick, mode: ControlMode) {
        let against = |at: &crate::observer::ObservedStation| {
            let in_auto = mode == ControlMode::Auto;
            let reasons = [
                (in_auto && at.own.is_lost, "its position is lost"),
                (in_auto && !at.own.has_devices, "its devices are not received"),
                (in_auto && at.own.is_incomplete, "an operation of it is incomplete"),
                (mode == ControlMode::Manual && at.own.moves, "it moves"),
            ];
            let is_known = now > at.own.since + KNOWN;
            reasons.into_iter().find(|(is, _)| *is && is_known).map(|(_, why)| why)
        };
        let found = self.stations.iter().enumerate().find_map(|(at, station)| Some((at, against(station)?)));
        if let Some((at, why)) = found {
            self.find(now, format!("{mode} is entered, and of station {at} it is known for long: {why}"));
        }
    }

    /// Outputs are put on the bus of a station behind the gateway: none that its newest image does not have.
    pub(crate) fn energised(&mut self, line: &Line, now: Tick, station: StationId, bits: u128) {
        let seen = &self.stations[station.index()];
        let (_, (newest, epoch), since) = seen.newest;
        if bits & seen.actuators != 0 && epoch < self.stop_epoch {
            let name = &line.station(station).name;
            return self.find(now, format!("{name}: an image from before an emergency stop is put out ({bits:#x})"));
        }
        let too_many = bits & seen.actuators & !newest;
        if too_many != 0 && now > since + 2 * line.timing.stale {
            let name = &line.station(station).name;
            self.find(now, format!("{name}: an output is put out that its newest image does not have ({too_many:#x})"));
        }
    }

    /// No output is on that no manager has given since the devices started or were lost.
    pub(crate) fn look_at_given(&mut self, line: &Line, plant: &Plant, at: usize, given: u128) {
        let bits = plant.outputs(Owner::Station(StationId::at(at))) & self.stations[at].actuators & !given;
        if bits != 0 {
            let name = &line.stations[at].name;
            self.find(
                plant.now(),
                format!("{name}: a motion is driven that was not ordered since a restart ({bits:#x})"),
            );
        }
    }

    /// Devices without their manager are off.
    pub(crate) fn has_no_manager(&mut self, line: &Line, plant: &Plant, at: usize) {
        let bits = plant.outputs(Owner::Station(StationId::at(at))) & self.stations[at].actuators;
        if bits != 0 {
            let name = &line.stations[at].name;
            self.find(
                plant.now(),
                format!("{name}: a motion is driven though its devices have no manager ({bits:#x})"),
            );
        }
    }

    /// A record takes time: no output waits for it to go off.
    pub(crate) fn waits_to_go_off(&mut self, line: &Line, (now, at): (Tick, usize), bits: u128) {
        if bits & self.stations[at].actuators != 0 {
            let name = &line.stations[at].name;
            self.find(now, format!("{name}: an output that is to go off waits for a record ({bits:#x})"));
        }
    }

    /// An order of a coordinator, not of a stranger, has arrived at a station. False if a newer one was there before.
    pub(crate) fn is_newest(&mut self, now: Tick, at: usize, order: &ModeOrder) -> bool {
        let lives = &mut self.stations[at].lives;
        let Some(known) = lives.iter_mut().find(|known| known.life == order.boot_id) else {
            lives.push(OrderingLife { life: order.boot_id, epoch: order.epoch, first: now, last: now, count: 1 });
            return true;
        };
        // Older, or an epoch that it cannot have given.
        if order.epoch < known.epoch || order.epoch > known.epoch.saturating_add(EPOCH_JUMP_MAX) {
            return false;
        }
        if now > known.last + CLOSE {
            (known.first, known.count) = (now, 0);
        }
        (known.epoch, known.last, known.count) = (order.epoch, now, known.count + 1);
        true
    }

    /// Whether two coordinators have given orders beside each other for a while.
    pub(crate) fn are_two(&self, line: &Line, now: Tick, at: usize) -> bool {
        let lasts = |life: &&OrderingLife| {
            life.count >= 5 && now <= life.last + CLOSE && life.last >= life.first + 4 * line.timing.refresh
        };
        self.stations[at].lives.iter().filter(lasts).count() >= 2
    }

    /// An emergency stop was given to a coordinator that runs: it has ordered it.
    pub(crate) fn passes_stop_on(&mut self, now: Tick, has_ordered: bool) {
        // Reset in the same moment, as after a standstill in which people went on, it is over.
        if !has_ordered && self.stop.is_some_and(|stop| !stop.is_reset) {
            self.find(now, "an emergency stop has arrived at the coordinator, and no order of it was given".to_owned());
        }
    }
}
