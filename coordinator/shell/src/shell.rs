//! The coordinator's shell: arrivals in, effects out.
//!
//! Order of effects: record, outputs, order, state, and last what is only information, as a completed cycle. So no
//! station obeys an epoch that the coordinator could lose. The emergency stop alone turns this round: outputs go off
//! and the order goes out first, because a slow disk must not delay it. That is safe: a coordinator that has lost an
//! emergency stop finds the stations in it and adopts it, and an epoch that was used for nothing but a stop starts
//! nothing when it is used again. Outputs of stations go off before the record as well. After a record that took longer
//! than a period nothing is put out or ordered by what was decided before it: it is decided again.
//!
//! A record that cannot be written is itself an emergency stop: the line would otherwise act on what a successor cannot
//! read. It stays in force, and writing is tried again, until it succeeds and an operator resets.

mod health;

use std::time::Duration;

use linewright_coordinator_logic::{Coordinator, Gateway, ManualPermit, ModeInput, ModeOutbox, RefusedCommand};
use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;
use linewright_line::{DeviceBus, Line, StationId, Tick};
use linewright_station_logic::ModeOrder;
use linewright_station_shell::{EPOCH_JUMP_MAX, HeldByOne, HeldPass, NewestBySequence, RivalLife, Rivals, ShellRules};

use crate::effect::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord};
use crate::gateway_station::{GatewayStation, GatewayStop};

pub use health::{RefusalFacts, cell_check, commands_check, coordinator_checks};

/// Shortest time between two refusals that are sent.
const ANSWER_EVERY: Duration = Duration::from_millis(20);
/// Time until writing a record is tried again. A disk that is full stays so for longer.
const WRITE_AGAIN_EVERY: Duration = Duration::from_secs(1);

/// Longest jump to a station's epoch that is followed. The other stations follow no order beyond [`EPOCH_JUMP_MAX`], and the
/// orders after the jump must stay within that for those that have not received any of them.
const EPOCH_FOLLOWED_MAX: u64 = EPOCH_JUMP_MAX / 2;

/// A coordinator between its messages.
#[derive(Debug)]
pub struct CoordinatorShell {
    rules: ShellRules,
    coordinator: Coordinator,
    gateway: Gateway,
    boot_id: u64,
    outbox: ModeOutbox,
    behind: Vec<GatewayStation>,
    states: Vec<NewestBySequence>,
    /// Hand-mode buttons, and resume.
    buttons: HeldByOne,
    resume: HeldByOne,
    /// Other coordinators that give orders on this line.
    rivals: Rivals,
    /// A station has acknowledged an order of this life.
    is_followed: bool,
    /// A station has acknowledged orders, and none of this life.
    others_are_followed: bool,
    /// By station: it has reported that it has its devices.
    has_devices: Vec<bool>,
    /// By station: its last report has its devices or a position lost, or something stopped in the middle.
    in_trouble: Vec<bool>,
    /// In a cell: the stations whose faults are the cell's alone, and those that it has stopped.
    isolated: Option<Vec<StationId>>,
    stopped: Vec<StationId>,
    /// The cell decides nothing now, so nothing becomes of a fault.
    is_unattended: bool,
    /// Record that is certainly written.
    written: CoordinatorRecord,
    /// The last attempt to write failed; when the next is due.
    write_again: Option<Tick>,
    order_sequence: u64,
    state_sequence: u64,
    image_sequence: u64,
    refresh: Duration,
    refresh_due: Tick,
    stale: Duration,
    /// Time of the last order and state.
    told: Tick,
    /// Time of the last decision.
    acted: Tick,
    /// Time of the next call that it has requested.
    expected: Tick,
    /// Arrivals before this may have waited while the process stood still: their age is unknown.
    doubts_until: Tick,
}

impl CoordinatorShell {
    /// The shell of a line's coordinator in its life `boot_id`, with the record that its predecessor has written.
    pub fn new(line: &Line, boot_id: u64, remembered: CoordinatorRecord) -> Self {
        let (stations, stale) = (line.stations.len(), line.timing.stale);
        let coordinator = Coordinator::new(line.clone(), boot_id, remembered.epoch);
        let behind = line.station_ids().filter(|&id| line.station(id).bus == DeviceBus::Line);
        CoordinatorShell {
            rules: ShellRules::ALL,
            coordinator: if remembered.estop { coordinator.with_estop() } else { coordinator },
            gateway: Gateway::new(stations, stale),
            boot_id,
            outbox: ModeOutbox::default(),
            behind: behind.map(|id| GatewayStation::new(line, id)).collect(),
            states: vec![NewestBySequence::new(stale); stations],
            buttons: HeldByOne::default(),
            resume: HeldByOne::default(),
            rivals: Rivals::new(line.timing.refresh, stale),
            is_followed: false,
            others_are_followed: false,
            has_devices: vec![false; stations],
            in_trouble: vec![false; stations],
            isolated: None,
            stopped: Vec::new(),
            is_unattended: false,
            written: CoordinatorRecord::default(),
            write_again: None,
            order_sequence: 0,
            state_sequence: 0,
            image_sequence: 0,
            refresh: line.timing.refresh,
            refresh_due: Tick::ZERO,
            stale,
            told: Tick::ZERO,
            acted: Tick::ZERO,
            expected: Tick::NEVER,
            doubts_until: Tick::ZERO,
        }
    }

    /// The same without repetitions and without a gateway, for a simulation whose links repeat the last messages by
    /// themselves, and in which images reach the plant at once.
    #[must_use]
    pub fn without_refresh_and_gateway(mut self) -> Self {
        self.refresh_due = Tick::NEVER;
        self.behind = Vec::new();
        self
    }

    /// The same with some rules switched off.
    #[must_use]
    pub fn with_shell_rules(mut self, rules: ShellRules) -> Self {
        self.rules = rules;
        self
    }

    /// The mode decision, to look at.
    pub fn coordinator(&self) -> &Coordinator {
        &self.coordinator
    }

    /// Boot id of the coordinator.
    pub fn boot_id(&self) -> u64 {
        self.boot_id
    }

    /// Record for a successor.
    pub fn to_remember(&self) -> CoordinatorRecord {
        CoordinatorRecord { epoch: self.coordinator.epoch(), estop: self.coordinator.is_estopped() }
    }

    /// Whether a station was ever received.
    pub fn has_heard(&self, station: StationId) -> bool {
        self.states[station.index()].current().is_some()
    }

    /// Whether a station has reported last that it has its devices.
    pub fn has_devices(&self, station: StationId) -> bool {
        self.has_devices[station.index()]
    }

    /// A cell is played on this line; the faults of some stations are the cell's alone, and some it has put into emergency
    /// stop. Call it before anything is handled, and before [`CoordinatorShell::act`] whenever that changes.
    pub fn plays_cell(&mut self, isolated: impl Iterator<Item = StationId>, stopped: impl Iterator<Item = StationId>) {
        let known = self.isolated.get_or_insert_default();
        known.clear();
        known.extend(isolated);
        self.stopped.clear();
        self.stopped.extend(stopped);
        self.coordinator.stop_alone(|id| self.stopped.contains(&id));
    }

    /// The cell decides nothing, since its log cannot be written: no station is stopped, and no alarm raised, for what fails now.
    /// So whatever fails ends auto, as on a line. Call it whenever that changes.
    pub fn leaves_unattended(&mut self, is_unattended: bool) {
        self.is_unattended = is_unattended;
    }

    /// These stations of the cell stand between two rests, at no order. Call it whenever that changes.
    pub fn hold(&mut self, stations: impl Fn(StationId) -> bool) {
        self.coordinator.hold(stations);
    }

    /// What the cell permits at its stations while the others are in auto. Call it whenever that changes.
    pub fn permit_manual(&mut self, permits: impl Fn(StationId) -> Option<ManualPermit>) {
        self.coordinator.permit_manual(permits);
    }

    /// The stations that the cell has put into emergency stop.
    pub fn stopped(&self) -> &[StationId] {
        &self.stopped
    }

    /// The order as it stands.
    pub fn order(&self) -> ModeOrder {
        let order = self.coordinator.order();
        ModeOrder {
            boot_id: self.boot_id,
            epoch: order.epoch,
            mode: order.mode,
            enabled: order.enabled,
            master_stop: order.master_stop,
            manual_all: order.manual_all,
            buttons: order.buttons,
            resume: order.resume,
            lease: order.lease,
            found: self.coordinator.founding(),
            station_life: 0,
            single: false,
        }
    }

    /// Takes hand-mode buttons. They are held by one console at a time.
    fn buttons(&mut self, now: Tick, console: u64, held: u32) {
        let pass = self.buttons.offer(now, console, held != 0, self.stale);
        if pass == HeldPass::Second {
            self.coordinator.handle(now, ModeInput::TwoConsoles);
        }
        let held = if pass == HeldPass::Taken { held } else { 0 };
        self.coordinator.handle(now, ModeInput::Buttons(held));
    }

    /// The order as it goes to one station, with the life it is for. A station may be in emergency stop or in manual by itself; in manual it stands by until its panel is to act.
    pub fn order_for(&self, station: StationId) -> ModeOrder {
        let order = self.order();
        let single = self.coordinator.is_single(station);
        let (mode, manual_all) = match () {
            () if self.coordinator.is_stopped(station) => (ControlMode::EStop, order.manual_all),
            () if single && self.coordinator.is_led(station) => (ControlMode::Manual, true),
            () if single => (ControlMode::StandBy, false),
            () => (order.mode, order.manual_all),
        };
        ModeOrder { mode, manual_all, single, station_life: self.coordinator.life_of(station), ..order }
    }

    /// Takes what has arrived. Follow with [`CoordinatorShell::act`], once everything that waits has been taken. False if it is
    /// the state of a station with an epoch that no coordinator can have given, which counts as not received.
    pub fn handle(&mut self, now: Tick, arrival: CoordinatorArrival) -> bool {
        self.notice_gap(now);
        let is_doubtful = now < self.doubts_until;
        match arrival {
            CoordinatorArrival::Command(command) => self.coordinator.handle(now, ModeInput::Command(command)),
            CoordinatorArrival::Single(station, is_manual) => {
                self.coordinator.handle(now, ModeInput::Single(station, is_manual));
            }
            // Buttons that were held before the gap may have been released in it, or not.
            CoordinatorArrival::Buttons { console, held } if is_doubtful => {
                self.buttons.offer_late(now, console, held != 0, self.stale);
                self.coordinator.handle(now, ModeInput::LateButtons(held));
            }
            CoordinatorArrival::Buttons { console, held } => self.buttons(now, console, held),
            CoordinatorArrival::Resume { console, held } => {
                // It has rules of its own for two consoles; here only that a release is one of its own console alone.
                let pass = self.resume.offer(now, console, held, self.stale);
                let is_late = is_doubtful || pass == HeldPass::Unreleased;
                let input = if is_late { ModeInput::LateResume } else { ModeInput::Resume };
                self.coordinator.handle(now, input(console, held));
            }
            CoordinatorArrival::Order { boot_id, sequence } => {
                if boot_id != self.boot_id && !is_doubtful {
                    self.rivals.hear(now, (boot_id, sequence), now);
                }
                if let Some(rival) = self.rivals.there(now).filter(|_| self.rules.rivals) {
                    self.coordinator.handle(now, ModeInput::Rival(rival.life, rival.until));
                }
            }
            CoordinatorArrival::State { station, sequence, heard } => {
                let Some(states) = self.states.get_mut(station.index()) else { return true };
                // An epoch that no coordinator can have given: followed, it would leave none above it. The station counts as
                // not received. Its emergency stop is in force all the same.
                let is_possible = heard.mode_epoch <= self.coordinator.epoch().saturating_add(EPOCH_FOLLOWED_MAX);
                if !is_possible && self.rules.epochs {
                    if heard.estopped && !self.coordinator.is_estopped() {
                        self.coordinator.handle(now, ModeInput::StationStopped(station));
                    }
                    return false;
                }
                let is_newest = states.offer(now, heard.boot_id, sequence) || !self.rules.numbers;
                if is_newest && !is_doubtful {
                    self.has_devices[station.index()] = heard.devices_valid;
                    let lost = heard.position_lost || !heard.devices_valid;
                    self.in_trouble[station.index()] = heard.incomplete || lost;
                    self.coordinator.handle(now, ModeInput::Station(station, heard));
                    self.is_followed |= heard.follows == self.boot_id;
                    self.others_are_followed |= heard.follows != 0 && heard.follows != self.boot_id;
                }
            }
            CoordinatorArrival::Outputs { station, sequence, image } => {
                let Some(behind) = self.behind.iter_mut().find(|b| b.station == station) else { return true };
                let is_newest = behind.newest.offer(now, image.boot_id, sequence) || !self.rules.numbers;
                // Only of a start whose state was received, and so fits the description: to another one the bits mean other
                // outputs.
                let is_known = image.boot_id == self.coordinator.life_of(station);
                if is_newest && is_known && !is_doubtful {
                    self.gateway.hear(now, station, image);
                }
            }
            CoordinatorArrival::Console { bits, valid } => {
                self.coordinator.handle(now, ModeInput::Console { bits, valid });
            }
            CoordinatorArrival::Devices { station, bits, valid, losses } => {
                if let Some(behind) = self.behind.iter_mut().find(|b| b.station == station) {
                    behind.devices = (bits, valid, losses);
                }
            }
        }
        true
    }

    /// The process was stopped, or the machine stood still: the age of earlier arrivals is unknown. That has to be seen
    /// before anything newer hides it.
    fn notice_gap(&mut self, now: Tick) {
        if self.expected == Tick::NEVER || now <= self.expected + self.stale || !self.rules.gaps {
            return;
        }
        self.expected = Tick::NEVER;
        self.doubts_until = now + self.refresh;
        let changed = self.outbox.changed;
        self.coordinator.step(now, &mut self.outbox);
        self.outbox.changed |= changed;
    }

    /// Follows the state of the coordinator's own node. Call it whenever that changes.
    pub fn follow_lifecycle(&mut self, now: Tick, state: LifecycleState) {
        self.notice_gap(now);
        self.coordinator.handle(now, ModeInput::Lifecycle(state));
    }

    /// Reason why the node cannot be configured.
    pub fn against_configuring(&self) -> Option<&'static str> {
        self.write_again.map(|_| "the journal cannot be written")
    }

    /// Takes a command or button as [`CoordinatorShell::handle`] does, and gives its refusal; none if it is obeyed, or held. The refusal
    /// is among the next effects as well.
    pub fn command(&mut self, now: Tick, arrival: CoordinatorArrival) -> Option<RefusedCommand> {
        // What is decided by a gap is no answer to this command.
        self.notice_gap(now);
        let before = self.coordinator.refusals().len();
        self.handle(now, arrival);
        self.coordinator.refusals().get(before).cloned()
    }

    /// Reason why a request that may be from before a standstill of the process is not followed.
    pub fn against_requests(&mut self, now: Tick) -> Option<&'static str> {
        self.notice_gap(now);
        (now < self.doubts_until).then_some("the node stood still just before it; give it again")
    }

    /// A refusal is to be sent soon, but a flood of foolish commands no faster than reliable topics can bear.
    pub fn answer_soon(&mut self) {
        self.refresh_due = self.refresh_due.min(self.told + ANSWER_EVERY);
    }

    /// Brings everything up to `now` and returns the effects.
    pub fn act(&mut self, now: Tick, effects: &mut Vec<CoordinatorEffect>) {
        self.notice_gap(now);
        self.isolate();
        let changed = std::mem::take(&mut self.outbox.changed);
        self.coordinator.step(now, &mut self.outbox);
        let changed = std::mem::take(&mut self.outbox.changed) | changed;
        // A change of mode ends the refusals before it: one of the same step stands after it.
        effects.extend(self.outbox.modes.drain(..).map(CoordinatorEffect::Entered));
        effects.extend(self.outbox.refusals.drain(..).map(CoordinatorEffect::Refused));
        effects.extend(std::mem::take(&mut self.outbox.obeyed).then_some(CoordinatorEffect::Obeyed));
        let is_due = now >= self.refresh_due;
        if is_due {
            self.refresh_due = now + self.refresh;
        }
        let is_stopped = self.coordinator.mode() == ControlMode::EStop;
        self.acted = now;
        if !is_stopped {
            for behind in self.behind.iter_mut().filter(|_| self.rules.off_first) {
                let stop = stop_of(&self.coordinator, behind.station);
                behind.take_off(now, &self.gateway, (self.boot_id, stop), effects);
            }
            self.remember(now, effects);
        }
        effects.push(CoordinatorEffect::Lamps(self.outbox.lamps));
        for behind in &mut self.behind {
            let numbers = (self.boot_id, &mut self.image_sequence);
            let stop = stop_of(&self.coordinator, behind.station);
            behind.act(now, &self.gateway, numbers, (stop, is_due), effects);
        }
        if changed || is_due {
            self.told = now;
            self.order_sequence += 1;
            effects.push(CoordinatorEffect::Order { sequence: self.order_sequence });
            self.state_sequence += 1;
            effects.push(CoordinatorEffect::Tell { sequence: self.state_sequence });
        }
        if is_stopped {
            self.remember(now, effects);
        }
        self.expected = self.next_deadline(now).max(now);
    }

    /// The record, if there is something new to write. A completed cycle stands before it: what follows a record that takes long
    /// or fails is not performed, and a cycle is given once.
    fn remember(&mut self, now: Tick, effects: &mut Vec<CoordinatorEffect>) {
        effects.extend(self.outbox.cycles.drain(..).map(CoordinatorEffect::Completed));
        let record = self.to_remember();
        if record != self.written && self.write_again.is_none_or(|again| again <= now) {
            effects.push(CoordinatorEffect::Remember(record));
        }
    }

    /// Result of writing `record`. False if what follows in the same effects must not be performed: it was not written, or
    /// that took longer than a period. Act again at once then; after a failure the emergency stop is in force.
    pub fn remembered(&mut self, now: Tick, record: CoordinatorRecord, is_written: bool) -> bool {
        let is_late = self.rules.late && now > self.acted + self.refresh;
        if is_written {
            self.written = record;
            if self.write_again.take().is_some() {
                // The journal works again: published at once, and not with the next message that arrives.
                self.refresh_due = now;
            }
        } else {
            self.write_again = Some(now + WRITE_AGAIN_EVERY);
        }
        let goes_on = is_written && !is_late;
        if !goes_on {
            self.interrupted(now);
        }
        self.coordinator.handle(now, ModeInput::Journal(is_written));
        goes_on
    }

    /// Time until which the next of the output images in force is not too old.
    pub fn images_until(&self, now: Tick) -> Option<Tick> {
        self.gateway.next_deadline(now)
    }

    /// While a record is being written a newer image of a station has arrived: of the outputs on its bus only those of that
    /// image stay. Returns this where something is to go off.
    pub fn keep_only(&mut self, station: StationId, bits: u128) -> Option<u128> {
        self.behind.iter_mut().find(|behind| behind.station == station)?.keep_only(bits)
    }

    /// The order as it stands is given once more, in the emergency stop while a record is being written; its number.
    pub fn repeat_order(&mut self) -> u64 {
        self.order_sequence += 1;
        self.order_sequence
    }

    /// The effects after a record were not performed, since an emergency stop arrived while the record was being written. Act
    /// again at once; the record is given again.
    pub fn interrupted(&mut self, now: Tick) {
        self.behind.iter_mut().for_each(GatewayStation::forget);
        self.refresh_due = self.refresh_due.min(now);
    }

    /// In a cell a fault of a task-driven station is an exception of its order, and the others work on: faults that have
    /// become one, and in auto also those about to, since a station reports in two messages at once.
    fn isolate(&mut self) {
        let Some(isolated) = &self.isolated else { return };
        let in_auto = self.coordinator.order().mode == ControlMode::Auto && !self.is_unattended;
        let in_trouble = |id: StationId, is_heard: bool| in_auto && (self.in_trouble[id.index()] || !is_heard);
        self.coordinator.isolate(|id, is_heard| isolated.contains(&id) || in_trouble(id, is_heard));
    }

    /// The coordinator that was there first, if this one came second and has to end: another one gives orders, no station
    /// has ever acknowledged this one, and stations follow the other one or it has given more orders.
    pub fn gives_way_to(&self, now: Tick) -> Option<u64> {
        let RivalLife { life, sequence, .. } = self.rivals.there(now).filter(|_| self.rules.rivals)?;
        let is_second = self.others_are_followed || (sequence, life) > (self.order_sequence, self.boot_id);
        (is_second && !self.is_followed).then_some(life)
    }

    /// Time of the next call if nothing arrives before.
    pub fn next_deadline(&self, now: Tick) -> Tick {
        let deadlines = [self.coordinator.next_deadline(), self.gateway.next_deadline(now), self.write_again];
        deadlines.into_iter().flatten().fold(self.refresh_due, Tick::min)
    }
}

/// The emergency stop of a station, as the gateway sees it.
fn stop_of(coordinator: &Coordinator, station: StationId) -> GatewayStop {
    match coordinator.is_stopped(station) {
        true => GatewayStop::InForce,
        false => GatewayStop::Since(coordinator.stopped_until(station)),
    }
}
