//! Manual of single stations of a cell, while the others are in auto.
//!
//! It is requested by command or by the station's own selector, and ended by the same. What makes it safe, in short (decision
//! 0033): such a station is left out of auto and of dispatch; between two rests it is led only in a task whose failed activity
//! keeps all it has taken, so that no activity with a task in conflict with it is in progress; where a task has ended its panel
//! moves nothing.
//!
//! Two states of it, both of an epoch of its own:
//! * *single*: the station is not in auto. It stands by; the cell gives it no order. No condition ends this but a command, a
//!   selector turned back, or the end of auto: it never goes over to auto by itself.
//! * *led*: its panel acts. Every condition holds now, and all have acknowledged the epoch. It ends with the first that does not.

use linewright_line::net::ControlMode;
use linewright_line::{StationId, Tick};

use super::{Coordinator, StationEntry};
use crate::refusal::{ModeRefusal, OperatorCommand, RefusedCommand};

/// What a cell permits at one of its stations while the others are in auto.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ManualPermit {
    /// It takes part in auto.
    InService,
    /// Stations of its failed activity have still to come to rest.
    Securing,
    /// The cell decides nothing now, and raises no alarm.
    Unattended,
    /// It is left out, and may be led on in these tasks, a bit each: their activities have failed, and keep what they have taken.
    LeftOut {
        tasks: u64,
        /// Epoch in which the present period of manual began, once the cell has received it: from then on the cell closes none of these
        /// activities until the period ends. An older epoch is that of an earlier period, and does not count.
        kept_in: Option<u64>,
    },
}

/// Manual of one station by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Single {
    /// It is in manual by itself, since an epoch of its own.
    pub in_force: bool,
    /// Requested by a command, by its selector.
    by_command: bool,
    by_selector: bool,
    /// Life of the station that reported its selector at manual last; none once it was turned back.
    selector_life: Option<u64>,
    /// Its panel acts.
    is_led: bool,
    /// The epoch in which it went into manual by itself last, or back.
    since: u64,
    /// When the orders before that have run out.
    run_out: Tick,
}

impl Coordinator {
    /// Sets what the cell permits at each station; none on a line without one. Call it whenever that changes, before
    /// [`Coordinator::step`].
    pub fn permit_manual(&mut self, permits: impl Fn(StationId) -> Option<ManualPermit>) {
        for (id, station) in self.line.station_ids().zip(&mut self.stations) {
            station.permit = permits(id).filter(|_| station.task_driven);
        }
    }

    /// Whether a station is not in auto with the others, but in manual by itself, or to be as soon as every condition holds.
    pub fn is_single(&self, station: StationId) -> bool {
        self.stations.get(station.index()).is_some_and(|station| station.single.in_force)
    }

    /// Whether a person may still move a station: it is in manual by itself, or has not acknowledged yet that it is no more.
    /// Not heard, it has stood still since the last order of that ran out. Its cell gives it no order until then.
    pub fn is_by_hand(&self, station: StationId) -> bool {
        let Some(of) = self.stations.get(station.index()) else { return false };
        let Single { since, run_out, .. } = of.single;
        let is_past = if self.is_known(of) { of.heard.acknowledges(self.boot_id, since) } else { self.now >= run_out };
        of.single.in_force || !is_past
    }

    /// The epoch with which a station went into manual by itself, or has left it since.
    pub fn single_epoch(&self, station: StationId) -> u64 {
        self.stations.get(station.index()).map_or(0, |station| station.single.since)
    }

    /// Whether a station is in manual by itself, and its panel acts.
    pub fn is_led(&self, station: StationId) -> bool {
        self.stations.get(station.index()).is_some_and(|station| station.single.is_led)
    }

    /// Manual for one station, or auto again.
    pub(super) fn command_single(&mut self, id: StationId, is_manual: bool) {
        self.changed = true;
        let Some(station) = self.stations.get(id.index()) else { return };
        let reasons = if let Some(state) = self.inactive {
            vec![ModeRefusal::CoordinatorInactive(state)]
        } else if is_manual {
            match self.mode {
                _ if station.permit.is_none() => vec![ModeRefusal::NoSingleManual(id)],
                ControlMode::Manual => vec![ModeRefusal::Already],
                ControlMode::EStop => vec![ModeRefusal::EStop],
                ControlMode::Auto if station.single.by_command => vec![ModeRefusal::Already],
                ControlMode::Auto if station.single.by_selector && station.heard.selector_manual => {
                    vec![ModeRefusal::Already]
                }
                ControlMode::Auto => self.against_single(id),
                ControlMode::Home | ControlMode::StandBy | ControlMode::Hand => vec![ModeRefusal::NotInAuto(id)],
            }
        } else if !station.single.in_force {
            vec![ModeRefusal::NotSingle(id)]
        } else if station.heard.selector_manual {
            vec![ModeRefusal::SelectorManual(id)]
        } else {
            self.against_joining(id)
        };
        self.obeyed = reasons.is_empty();
        if reasons.is_empty() {
            let single = &mut self.stations[id.index()].single;
            single.by_command = is_manual;
            single.by_selector &= is_manual;
            self.follow_single();
        } else {
            let command = OperatorCommand::Single(id, is_manual);
            self.refusals.push(RefusedCommand { command, mode: self.mode, reasons });
        }
    }

    /// Reasons why a station cannot go back to auto with the others: where its cell does not leave it out, what would end auto.
    fn against_joining(&self, id: StationId) -> Vec<ModeRefusal> {
        let (station, mut reasons) = (&self.stations[id.index()], Vec::new());
        if !station.isolated {
            self.troubles_of(id, station, &mut reasons);
            reasons.extend(station.held.then_some(ModeRefusal::BetweenRests(id)));
        }
        reasons
    }

    /// Reasons why a station cannot be in manual while the others are in auto.
    pub(super) fn against_single(&self, id: StationId) -> Vec<ModeRefusal> {
        let station = &self.stations[id.index()];
        let mut reasons = Vec::new();
        match station.permit {
            None => reasons.push(ModeRefusal::NoSingleManual(id)),
            Some(ManualPermit::InService) => reasons.push(ModeRefusal::InService(id)),
            Some(ManualPermit::Securing) => reasons.push(ModeRefusal::Securing(id)),
            Some(ManualPermit::Unattended) => reasons.push(ModeRefusal::Unattended(id)),
            Some(ManualPermit::LeftOut { tasks, .. }) if !self.stands_in_one_of(id, tasks) => {
                reasons.push(ModeRefusal::OutsideTask(id));
            }
            Some(ManualPermit::LeftOut { .. }) => {}
        }
        // A table at rest is homed in manual: that motion is of no task, so no activity keeps others apart from it.
        let described = self.line.station(id);
        if described.op_ids().any(|op| described.index_of(op).is_some()) {
            reasons.push(ModeRefusal::Turns(id));
        }
        if station.stopped {
            reasons.push(ModeRefusal::StoppedByCell(id));
        }
        if !self.is_known(station) {
            reasons.push(self.silence(id));
        }
        reasons.extend(self.rival().map(ModeRefusal::OtherCoordinator));
        if self.console_is_unknown() {
            reasons.push(ModeRefusal::ConsoleNeverHeard);
        }
        reasons
    }

    /// Whether manual leads a station on in one of these tasks only. Where a task has ended it leads nowhere; where one was taken
    /// back to its beginning, *advance* begins it again.
    fn stands_in_one_of(&self, id: StationId, tasks: u64) -> bool {
        let heard = &self.stations[id.index()].heard;
        match heard.stands_in {
            None => heard.at_home,
            Some(op) => {
                let task = self.line.station(id).task_of(op).map(linewright_line::TaskId::index);
                task.is_some_and(|task| task < 64 && tasks & (1 << task) != 0)
            }
        }
    }

    /// Leads stations into manual by themselves and back to auto, as commands and selectors have it. Each change begins an epoch;
    /// the others go on meanwhile.
    pub(super) fn follow_single(&mut self) {
        if self.mode != ControlMode::Auto {
            return;
        }
        for id in self.line.station_ids() {
            let was = self.stations[id.index()].single;
            let mut single = self.by_selector(id, was);
            if self.stations[id.index()].stopped {
                (single.by_command, single.by_selector) = (false, false);
            }
            single.in_force = single.by_command || single.by_selector;
            single.is_led &= single.in_force;
            if single.in_force != was.in_force {
                self.epoch = self.epoch.saturating_add(1);
                self.changed = true;
                (single.since, single.run_out) = (self.epoch, self.orders_run_out());
            }
            self.stations[id.index()].single = single;
        }
        for id in self.line.station_ids() {
            if !self.is_single(id) {
                continue;
            }
            let is_led = self.against_panel(id).is_empty();
            self.changed |= std::mem::replace(&mut self.stations[id.index()].single.is_led, is_led) != is_led;
            if is_led {
                self.looked_at(id);
            }
        }
    }

    /// The request of a selector. It is turned back only by a report of the life that had it at manual, with its inputs valid: after
    /// a restart, or without an image, the selector is unknown, and the station stays out of auto until a command. So it does
    /// where it cannot join the others when its selector is turned back: nothing that is refused takes effect later.
    fn by_selector(&self, id: StationId, was: Single) -> Single {
        let station = &self.stations[id.index()];
        let heard = &station.heard;
        if heard.selector_manual {
            // A selector of a station that takes part in auto leads the line to stand-by, as on every line.
            let is_request = was.in_force || (station.isolated && self.against_single(id).is_empty());
            return Single { by_selector: is_request, selector_life: Some(heard.boot_id), ..was };
        }
        let is_turned_back = self.is_known(station) && heard.devices_valid && was.selector_life == Some(heard.boot_id);
        if !was.by_selector || !is_turned_back {
            return was;
        }
        let stays = !self.against_joining(id).is_empty();
        Single { by_selector: stays, selector_life: None, ..was }
    }

    /// When the orders that are given now have run out.
    fn orders_run_out(&self) -> Tick {
        self.now + self.line.timing.lease + self.line.timing.stale
    }

    /// Reasons why the panel of a station in manual by itself does not act; each condition is evaluated in each step. The report that
    /// acknowledges the epoch also carries the place of the station, which no `rejoin` changes afterwards.
    fn against_panel(&self, id: StationId) -> Vec<ModeRefusal> {
        let mut reasons = self.against_single(id);
        let station = &self.stations[id.index()];
        let Single { by_command, since, .. } = station.single;
        if !by_command && !station.heard.selector_manual {
            reasons.push(ModeRefusal::SelectorUnclear(id));
        }
        // All that count, which is all but those in manual by themselves. That this one is not received is a reason already.
        for (other, of) in self.counted().chain([(id, station)]) {
            if !self.is_known(of) {
                reasons.extend((other != id).then(|| self.silence(other)));
            } else if !of.heard.acknowledges(self.boot_id, since) {
                reasons.push(ModeRefusal::ManualUnaware(other));
            }
        }
        let is_kept =
            matches!(station.permit, Some(ManualPermit::LeftOut { kept_in: Some(epoch), .. }) if epoch == since);
        if reasons.is_empty() && !(is_kept && self.enabled) {
            reasons.push(ModeRefusal::CellUnaware(id));
        }
        reasons
    }

    /// Auto is over: all follow the mode again.
    pub(super) fn end_single(&mut self) {
        let (since, run_out) = (self.epoch, self.orders_run_out());
        for station in &mut self.stations {
            let was = station.single;
            station.single = match was.in_force {
                true => Single { since, run_out, ..Single::default() },
                false => Single { since: was.since, run_out: was.run_out, ..Single::default() },
            };
        }
    }

    /// The stations in manual by themselves, each with the reasons why its panel does not act.
    pub(super) fn singles(&self) -> impl Iterator<Item = (StationId, Vec<ModeRefusal>)> {
        let all = self.line.station_ids().filter(|&id| self.is_single(id));
        all.map(|id| (id, if self.is_led(id) { Vec::new() } else { self.against_panel(id) }))
    }

    /// The stations left out whose selectors stand at manual without effect, each with the reasons.
    pub(super) fn idle_selectors(&self) -> impl Iterator<Item = (StationId, Vec<ModeRefusal>)> {
        let stands = |(_, s): &(StationId, &StationEntry)| {
            s.isolated && !s.single.in_force && self.is_known(s) && s.heard.selector_manual
        };
        let all = self.line.station_ids().zip(&self.stations).filter(|_| self.mode == ControlMode::Auto);
        all.filter(stands).map(|(id, _)| (id, self.against_single(id)))
    }
}
