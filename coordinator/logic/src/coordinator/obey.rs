//! Effect of each command in each mode, and reasons of refusal.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{StationId, Tick};

use super::{Coordinator, EStopCause};
use crate::decision::ModeCommand;
use crate::refusal::{ModeRefusal, OperatorCommand, RefusedCommand};

/// Longest wait of a commanded manual for stations to stand. That takes a moment; minutes later the mode must not change by itself.
const MANUAL_WAIT_MAX: Duration = Duration::from_secs(30);

impl Coordinator {
    pub(super) fn command(&mut self, command: ModeCommand) {
        self.changed = true;
        if self.mode != ControlMode::Manual {
            // A later command replaces a manual that still waits for stations to stand, also one that is refused.
            self.manual_all = false;
        }
        let ended = (self.ended.take(), self.found_away);
        let reasons = match self.inactive {
            Some(state) if command != ModeCommand::EStop => vec![ModeRefusal::CoordinatorInactive(state)],
            _ => self.obey(command),
        };
        self.obeyed = reasons.is_empty();
        if reasons.is_empty() {
            self.found_away = false;
        } else {
            (self.ended, self.found_away) = ended;
            self.refusals.push(RefusedCommand { command: OperatorCommand::Mode(command), mode: self.mode, reasons });
        }
    }

    /// Obeys a command or gives the reasons against it. Every pair of mode and command is decided here.
    fn obey(&mut self, command: ModeCommand) -> Vec<ModeRefusal> {
        use ControlMode as M;
        use ModeCommand as C;
        match (self.mode, command) {
            (_, C::EStop) => {
                self.stop(EStopCause::Commanded);
                self.decide(None);
                Vec::new()
            }
            (M::EStop, C::Reset) => self.reset(),
            (M::EStop, C::Manual) if self.estop.is_some() => vec![ModeRefusal::EStop],
            (M::EStop, C::Manual) | (M::StandBy, C::Manual) => self.go_manual(),
            (M::EStop, C::Stop) if self.estop.is_none() => wrong_mode(&[C::Manual], &[]),
            (M::EStop, C::Start | C::Auto | C::Hand) if self.estop.is_none() => {
                wrong_mode(&[C::Manual], &[C::Manual, command])
            }
            (M::EStop, C::Start | C::Stop | C::Auto | C::Hand) => vec![ModeRefusal::EStop],
            (M::Home, C::Start) => {
                self.found();
                self.ask(command, Vec::new())
            }
            (M::Home, C::Stop) => vec![ModeRefusal::Already],
            (M::Home, C::Manual) => self.manual_from_home(),
            (M::Home, C::Auto | C::Hand) => wrong_mode(&[C::Start, C::Manual], &[C::Start, command]),
            (M::StandBy, C::Start) => {
                // Start in stand-by confirms that an operator has looked at a restarted station.
                let founds = self.found();
                let reasons = self.acknowledge_restarts();
                if founds { Vec::new() } else { reasons }
            }
            (M::StandBy, C::Stop) => self.ask(command, self.against_home()),
            (M::StandBy | M::Hand, C::Auto) => {
                self.found();
                let reasons = self.against(M::Auto);
                if reasons.is_empty() { self.ask(command, self.against_motion(self.mode)) } else { reasons }
            }
            (M::StandBy, C::Hand) => {
                self.found();
                // Judged by all stations: with one that is left out hand would end as soon as it is entered.
                let reasons = self.against(M::Hand);
                if reasons.is_empty() { self.ask(command, reasons) } else { reasons }
            }
            (M::Home | M::StandBy | M::Auto | M::Hand | M::Manual, C::Reset) => vec![ModeRefusal::NothingToReset],
            (M::Auto, C::Start) => {
                self.stopping = false;
                Vec::new()
            }
            (M::Auto, C::Stop) => {
                if !self.stopping {
                    // Of an epoch of its own, so that stations acknowledge it: a station at home may begin its next
                    // round before it does. The mode stays, and goes on meanwhile.
                    self.epoch = self.epoch.saturating_add(1);
                    self.quiet = self.epoch;
                }
                self.stopping = true;
                self.decide(None);
                Vec::new()
            }
            (M::Auto, C::Auto) if self.stopping => vec![ModeRefusal::Stopping],
            (M::Auto, C::Auto) | (M::Hand, C::Hand) | (M::Manual, C::Manual) => vec![ModeRefusal::Already],
            (M::Auto, C::Hand) => wrong_mode(&[C::Stop, C::EStop], &[C::Stop, C::Start, C::Hand]),
            (M::Auto, C::Manual) => wrong_mode(&[C::Stop, C::EStop], &[C::Stop, C::Manual]),
            (M::Hand, C::Stop) => self.ask(command, Vec::new()),
            (M::Hand, C::Start) => wrong_mode(&[C::Auto, C::Stop, C::EStop], &[]),
            (M::Hand, C::Manual) => wrong_mode(&[C::Auto, C::Stop, C::EStop], &[C::Stop, C::Manual]),
            (M::Manual, C::Auto | C::Hand | C::Start | C::Stop) => self.leave_manual(command),
        }
    }

    /// Gives the command to the net; if no arc takes it, these are the reasons.
    fn ask(&mut self, command: ModeCommand, reasons: Vec<ModeRefusal>) -> Vec<ModeRefusal> {
        let before = self.mode;
        self.decide(Some(command));
        if self.mode != before {
            return Vec::new();
        }
        if reasons.is_empty() { wrong_mode(&[], &[]) } else { reasons }
    }

    /// What keeps a line that stands by from being off, at home.
    fn against_home(&self) -> Vec<ModeRefusal> {
        let mut reasons = self.unheard();
        let stations = self.line.station_ids().zip(&self.stations).filter(|(_, s)| self.is_known(s));
        let latest = self.latest_round();
        let behind = stations.filter(|(_, s)| s.heard.at_home && s.is_behind(latest));
        reasons.extend(behind.map(|(id, _)| ModeRefusal::Behind(id)));
        reasons.extend(self.which(|h| !h.at_home, ModeRefusal::NotAtHome));
        reasons.extend(self.left_out_away());
        reasons.extend(self.against_rest(self.mode));
        reasons.extend(self.which(|h| h.selector_manual, ModeRefusal::SelectorManual));
        reasons
    }

    fn against_motion(&self, mode: ControlMode) -> Vec<ModeRefusal> {
        let mut reasons = self.troubles_in(mode);
        reasons.extend(self.which_in(mode, |h| h.selector_manual, ModeRefusal::SelectorManual));
        reasons
    }

    /// Reasons against auto or hand, the same from every mode that they follow from.
    fn against(&self, mode: ControlMode) -> Vec<ModeRefusal> {
        let mut reasons = self.against_motion(mode);
        reasons.extend(match mode {
            ControlMode::Auto => self.between_rests(),
            _ => self.against_rest(mode),
        });
        reasons
    }

    /// Stations that auto would leave where they stand.
    fn between_rests(&self) -> Vec<ModeRefusal> {
        let is_out = |id: StationId| self.stations[id.index()].isolated || self.stations[id.index()].stopped;
        let held = self.line.station_ids().filter(|id| self.stations[id.index()].held && !is_out(*id));
        held.map(ModeRefusal::BetweenRests).collect()
    }

    fn against_rest(&self, mode: ControlMode) -> Vec<ModeRefusal> {
        let mut reasons = self.which_in(mode, |h| !h.stopped, ModeRefusal::Moving);
        reasons.extend(self.which_in(mode, |h| h.stopped && !self.is_at_rest(h), ModeRefusal::Unaware));
        reasons
    }

    fn reset(&mut self) -> Vec<ModeRefusal> {
        if self.journal_lost {
            return vec![ModeRefusal::JournalLost];
        }
        if self.estop_is_pressed() {
            return vec![ModeRefusal::EStopPressed];
        }
        if self.line.console.estop.is_some() && self.console_was_heard && !self.console.1 {
            return vec![ModeRefusal::ConsoleLost];
        }
        if self.line.console.estop.is_some() && self.console_is_unknown() {
            return vec![ModeRefusal::ConsoleNeverHeard];
        }
        self.estop = None;
        self.decide(None);
        Vec::new()
    }

    fn against_manual(&self) -> Vec<ModeRefusal> {
        let mut reasons = self.which(|h| !h.stopped, ModeRefusal::Moving);
        reasons.extend(self.unheard());
        reasons.extend(self.rival().map(ModeRefusal::OtherCoordinator));
        if self.console_is_unknown() {
            reasons.push(ModeRefusal::ConsoleNeverHeard);
        }
        reasons
    }

    /// Whether manual holds by command, or follows by it now: not before a generation that is being founded is taken, since what
    /// is moved before could not be counted.
    pub(super) fn is_manual_commanded(&self) -> bool {
        self.manual_all && (self.mode == ControlMode::Manual || self.now >= self.manual_waits_until())
    }

    fn go_manual(&mut self) -> Vec<ModeRefusal> {
        let reasons = self.against_manual();
        if reasons.is_empty() {
            // A station that has not acknowledged stand-by yet does so in a moment, and the mode follows then.
            self.manual_all = true;
            self.manual_until = self.now + MANUAL_WAIT_MAX;
            self.decide(None);
        }
        reasons
    }

    /// When a commanded manual that still waits is given up; 0 while none does.
    pub(super) fn manual_given_up_at(&self) -> Tick {
        if self.manual_all && self.mode != ControlMode::Manual { self.manual_until } else { Tick::ZERO }
    }

    /// Ends a commanded manual that has waited too long, as for a station that was lost after the command: what comes back
    /// minutes later must not change the mode by itself.
    pub(super) fn give_up_manual(&mut self) {
        let at = self.manual_given_up_at();
        if at == Tick::ZERO || self.now < at {
            return;
        }
        self.manual_all = false;
        self.changed = true;
        let mut reasons = self.against_manual();
        reasons.extend(self.which(|h| h.stopped && !self.is_at_rest(h), ModeRefusal::Unaware));
        reasons.push(ModeRefusal::GivenUp(MANUAL_WAIT_MAX));
        self.refusals.push(RefusedCommand {
            command: OperatorCommand::Mode(ModeCommand::Manual),
            mode: self.mode,
            reasons,
        });
    }

    /// From home to stand-by and on to manual, as by start and manual one after the other. A generation that is missing is
    /// founded before: what is moved without one is not counted. Where it cannot be founded, *start* has to be given first,
    /// as an operator's decision. Manual moves nothing by itself: each motion is held at a panel.
    fn manual_from_home(&mut self) -> Vec<ModeRefusal> {
        let mut reasons = self.against_manual();
        // Nothing is founded before all have acknowledged that they stand.
        reasons.extend(self.which(|h| h.stopped && !self.is_at_rest(h), ModeRefusal::Unaware));
        if reasons.is_empty() && !self.found() {
            reasons = self.apart().map(|(id, cause)| ModeRefusal::NotFounded(id, cause)).collect();
        }
        if !reasons.is_empty() {
            return reasons;
        }
        self.decide(Some(ModeCommand::Start));
        self.go_manual()
    }

    /// Out of manual by command, if only a command led in: back to stand-by, and at once to the commanded mode.
    fn leave_manual(&mut self, command: ModeCommand) -> Vec<ModeRefusal> {
        let selectors = self.which(|h| h.selector_manual, ModeRefusal::SelectorManual);
        if !selectors.is_empty() {
            return selectors;
        }
        let commanded = match command {
            ModeCommand::Auto => Some(ControlMode::Auto),
            ModeCommand::Hand => Some(ControlMode::Hand),
            _ => None,
        };
        if let Some(mode) = commanded {
            self.found();
            let reasons = self.against(mode);
            if !reasons.is_empty() {
                return reasons;
            }
        }
        self.manual_all = false;
        self.decide(None);
        match command {
            // Away from home it ends in stand-by, as it does out of hand mode.
            ModeCommand::Stop => {
                self.decide(Some(command));
                Vec::new()
            }
            ModeCommand::Start => Vec::new(),
            _ => self.obey(command),
        }
    }

    fn acknowledge_restarts(&mut self) -> Vec<ModeRefusal> {
        let was_unstarted = std::mem::take(&mut self.is_unstarted);
        if !self.stations.iter().any(|s| s.restarted) {
            return if was_unstarted { Vec::new() } else { vec![ModeRefusal::Already] };
        }
        for station in &mut self.stations {
            station.restarted = false;
        }
        Vec::new()
    }
}

fn wrong_mode(takes: &[ModeCommand], way: &[ModeCommand]) -> Vec<ModeRefusal> {
    vec![ModeRefusal::WrongMode { takes: takes.to_vec(), way: way.to_vec() }]
}
