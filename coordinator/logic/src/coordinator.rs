//! Playing the mode decision: commands, console and reports in; the order for every station out.
//!
//! The order carries an epoch, which grows with every change of mode, and a lease. A mode that enables motion is
//! *enabled* only when every station has acknowledged its epoch, so no station moves while another still acts on the
//! mode before. The same holds for rest: a station counts as standing only once it has acknowledged an epoch in which
//! nothing starts by itself. A master stop begins such an epoch too. Everything unknown counts against motion: a station
//! that is not received is trouble, and a console that was received and no longer is counts as a pressed emergency stop.

mod alone;
mod console;
mod cycle;
mod entry;
mod exchange;
mod founding;
mod inactive;
mod obey;
mod single;
mod standing;
mod stop;

pub use cycle::CompletedCycle;
pub use exchange::{ModeGrant, ModeInput, ModeOutbox, StationView};
pub use single::ManualPermit;
pub use standing::ModeStanding;
pub use stop::EStopCause;

use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick};

use crate::buttons::Buttons;
use crate::decision::{ModeCommand, ModeFacts, next};
use crate::refusal::{ModeRefusal, OperatorCommand, RefusedCommand};
use crate::resume::ResumeButton;
use entry::StationEntry;

#[derive(Clone, Debug)]
pub struct Coordinator {
    line: Line,
    boot_id: u64,
    now: Tick,
    mode: ControlMode,
    epoch: u64,
    enabled: bool,
    stopping: bool,
    /// The first epoch in which no station leaves its place by itself: one that has not acknowledged it may be moving.
    quiet: u64,
    /// The emergency stop that is latched: why, and since when.
    estop: Option<(EStopCause, Tick)>,
    founding: Option<founding::OpenFounding>,
    /// Generations drawn in this life.
    drawn: u64,
    /// The epoch in which the emergency stop was left last: a station in it that has acknowledged this was stopped anew.
    released: u64,
    /// The epoch in which the emergency stop was entered last; 0 if it never was. Earlier decisions are not acted on after it.
    stopped_in: u64,
    /// The journal cannot be written.
    journal_lost: bool,
    /// State of this coordinator's node, if it is not active.
    inactive: Option<LifecycleState>,
    /// Another coordinator, and until when it counts as there.
    rival: Option<(u64, Tick)>,
    /// "Manual" was commanded: as if every selector stood at manual.
    manual_all: bool,
    /// When a manual that was commanded and is not in force yet is given up.
    manual_until: Tick,
    stations: Vec<StationEntry>,
    console: (u128, bool),
    console_was_heard: bool,
    /// Wired hand-mode buttons that were down when the console was received again, and have not been up since.
    unreleased: u32,
    buttons: Buttons,
    resume: ResumeButton,
    /// The last order had it held.
    has_resumed: bool,
    changed: bool,
    modes: Vec<ControlMode>,
    refusals: Vec<RefusedCommand>,
    /// The last command since the last step was obeyed.
    obeyed: bool,
    cycle: cycle::OpenCycle,
    cycles: Vec<CompletedCycle>,
    /// The mode that ended by itself, and why; until the next command.
    ended: Option<(ControlMode, Vec<ModeRefusal>)>,
    /// Stand-by stands for home, where a station is away from it: start is still to be given.
    is_unstarted: bool,
    /// A station was found away from home when home was the mode, as after a restart; until the next command.
    found_away: bool,
}

impl Coordinator {
    /// A coordinator for `line`. `boot_id` is unique per start. Its epochs start above `last_epoch`, the highest one that
    /// its predecessor used (0 if none). It comes up in the home mode, in which nothing moves.
    pub fn new(line: Line, boot_id: u64, last_epoch: u64) -> Self {
        Coordinator {
            stations: line.station_ids().map(|id| StationEntry::of(&line, id)).collect(),
            line,
            boot_id,
            now: Tick::ZERO,
            mode: ControlMode::Home,
            epoch: last_epoch.saturating_add(1),
            enabled: false,
            stopping: false,
            quiet: last_epoch.saturating_add(1),
            estop: None,
            founding: None,
            drawn: 0,
            released: 0,
            stopped_in: 0,
            journal_lost: false,
            inactive: None,
            rival: None,
            manual_all: false,
            manual_until: Tick::ZERO,
            console: (0, false),
            console_was_heard: false,
            unreleased: 0,
            buttons: Buttons::default(),
            resume: ResumeButton::default(),
            has_resumed: false,
            changed: true,
            modes: Vec::new(),
            refusals: Vec::new(),
            obeyed: false,
            cycle: cycle::OpenCycle::default(),
            cycles: Vec::new(),
            ended: None,
            is_unstarted: false,
            found_away: false,
        }
    }

    /// The same coordinator with the emergency stop latched, as its predecessor left it: being replaced is no way out
    /// of the emergency stop.
    #[must_use]
    pub fn with_estop(mut self) -> Self {
        self.stop(EStopCause::Restarted);
        self.decide(None);
        self
    }

    /// Whether the emergency stop is latched, or was and has not been left through manual: part of the record for a
    /// successor.
    pub fn is_estopped(&self) -> bool {
        self.estop.is_some() || self.mode == ControlMode::EStop
    }

    pub fn mode(&self) -> ControlMode {
        self.mode
    }

    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// The order as it stands.
    pub fn order(&self) -> ModeGrant {
        ModeGrant {
            epoch: self.epoch,
            mode: self.mode,
            enabled: self.enabled || !self.mode.enables_motion(),
            master_stop: self.stopping.then(|| self.latest_round()),
            manual_all: self.manual_all,
            buttons: self.buttons.held(self.now) | self.wired_buttons(),
            resume: self.resumes(),
            lease: self.line.timing.lease,
        }
    }

    /// The latest round that any station has begun. It may still rise after the stop was given, until every station has
    /// received it; then all follow.
    fn latest_round(&self) -> i32 {
        self.stations.iter().filter(|s| !s.task_driven).map(|s| s.heard.round).max().unwrap_or(0)
    }

    /// Rounds of different generations are not compared: what counts then is that all are at home.
    fn all_in(&self, round: i32) -> bool {
        !self.is_of_one_generation() || !self.stations.iter().any(|station| station.is_behind(round))
    }

    /// Takes an arrival and acts on it. Follow with [`Coordinator::step`].
    pub fn handle(&mut self, now: Tick, input: ModeInput) {
        self.now = self.now.max(now);
        match input {
            ModeInput::Command(command) => self.command(command),
            ModeInput::Single(station, is_manual) => self.command_single(station, is_manual),
            ModeInput::Console { bits, valid } => self.hear_console(bits, valid),
            ModeInput::Buttons(held) => self.changed |= self.buttons.hear(self.now, held, self.line.timing.stale),
            ModeInput::LateButtons(held) => {
                self.buttons.hear_late(self.now, held, self.line.timing.stale);
                self.changed = true;
            }
            ModeInput::TwoConsoles => {
                let reasons = vec![ModeRefusal::TwoConsoles];
                self.refusals.push(RefusedCommand { command: OperatorCommand::Buttons, mode: self.mode, reasons });
                self.changed = true;
            }
            ModeInput::Resume(console, held) => self.hear_resume(console, held),
            ModeInput::LateResume(console, held) => {
                self.resume.hear_late(self.now, console, held, self.line.timing.stale);
            }
            ModeInput::Station(id, heard) => self.hear_station(id, heard),
            ModeInput::Rival(life, until) => {
                self.changed |= self.rival() != Some(life);
                self.rival = Some((life, until));
            }
            ModeInput::Journal(is_written) => {
                self.changed |= self.journal_lost == is_written;
                self.journal_lost = !is_written;
                if self.journal_lost {
                    self.stop(EStopCause::JournalLost);
                }
            }
            ModeInput::StationStopped(id) => self.stop(EStopCause::Station(id)),
            ModeInput::Lifecycle(state) => self.take_lifecycle(state),
        }
    }

    /// Boot id in the last state of a station; 0 if none was received. An order is for it alone.
    pub fn life_of(&self, station: StationId) -> u64 {
        self.stations.get(station.index()).map_or(0, |station| station.heard.boot_id)
    }

    fn hear_station(&mut self, id: StationId, heard: StationView) {
        if let Some(state) = heard.inactive {
            // The last report of a life may have this as well.
            if self.is_stopped_by_another(id, heard) {
                self.stop(EStopCause::Station(id));
            }
            return self.hear_inactive(id, state);
        }
        let (now, knew_rounds) = (self.now, self.knows_rounds());
        let Some(station) = self.stations.get_mut(id.index()) else { return };
        let rebooted = station.heard.boot_id != 0 && station.heard.boot_id != heard.boot_id;
        let news = station.heard != heard || now >= station.known_until;
        // In manual a person stands at the panel and holds every motion: there is nothing left to be looked at.
        let moved = std::mem::take(&mut station.missed) || matches!(self.mode, ControlMode::Auto | ControlMode::Hand);
        station.restarted |= rebooted && moved;
        station.had_devices = heard.devices_valid || station.had_devices && !rebooted;
        station.heard = heard;
        station.known_until = now + self.line.timing.stale;
        station.inactive = None;
        self.changed |= news;
        self.follow_founding();
        self.follow_cycle(knew_rounds);
        if self.is_stopped_by_another(id, heard) {
            self.stop(EStopCause::Station(id));
        }
        // The stations have obeyed a later epoch than ours: that of a former coordinator. Go above it, and to a mode in
        // which nothing starts.
        if heard.mode_epoch > self.epoch {
            self.epoch = heard.mode_epoch.saturating_add(1);
            self.quiet = self.epoch;
            self.enabled = false;
            self.changed = true;
            self.manual_all = false;
            if self.mode.enables_motion() {
                self.enter(ControlMode::StandBy);
            }
        }
    }

    /// The other coordinator that gives orders to this line, if there is one.
    pub(super) fn rival(&self) -> Option<u64> {
        self.rival.filter(|(_, until)| self.now < *until).map(|(life, _)| life)
    }

    fn is_known(&self, station: &StationEntry) -> bool {
        self.now < station.known_until
    }

    fn all(&self, what: impl Fn(&StationView) -> bool) -> bool {
        self.counted().all(|(_, s)| self.is_known(s) && what(&s.heard))
    }

    fn facts(&self, command: Option<ModeCommand>) -> ModeFacts {
        let counted_home = self.is_counted_home();
        let all_home = counted_home && self.left_out_away().is_empty();
        ModeFacts {
            command,
            estop: self.estop.is_some(),
            // A stop that cannot end at home, since a station that is left out is away from it, ends in stand-by.
            trouble: !self.troubles_in(self.mode).is_empty() || (self.stopping && counted_home && !all_home),
            stopping: self.stopping,
            all_home,
            away: self.stations.iter().any(|s| self.is_known(s) && !s.heard.at_home),
            all_stopped: self.all(|h| self.is_at_rest(h)),
            any_manual: self.inactive.is_none() && (self.is_manual_commanded() || self.any_selector()),
        }
    }

    /// Nothing moves, and nothing will by an order received before.
    fn is_at_rest(&self, heard: &StationView) -> bool {
        heard.stopped && heard.mode_epoch >= self.quiet
    }

    /// Whether a selector stands at manual, by the states received.
    pub fn any_selector(&self) -> bool {
        self.counted().any(|(_, s)| self.is_known(s) && s.heard.selector_manual)
    }

    /// Reasons against motion in auto and hand, as they count in a mode.
    fn troubles_in(&self, mode: ControlMode) -> Vec<ModeRefusal> {
        let mut reasons = Vec::new();
        if self.journal_lost {
            reasons.push(ModeRefusal::JournalLost);
        }
        reasons.extend(self.inactive.map(ModeRefusal::CoordinatorInactive));
        reasons.extend(self.rival().map(ModeRefusal::OtherCoordinator));
        if self.console_was_heard && !self.console.1 {
            reasons.push(ModeRefusal::ConsoleLost);
        }
        if self.console_is_unknown() {
            reasons.push(ModeRefusal::ConsoleNeverHeard);
        }
        for (id, station) in self.counted_in(mode) {
            self.troubles_of(id, station, &mut reasons);
        }
        // At home nothing moves, and the start that leads out founds what is missing.
        if self.mode != ControlMode::Home {
            reasons.extend(self.without_common_start());
        }
        reasons
    }

    fn which(
        &self,
        what: impl Fn(&StationView) -> bool,
        reason: impl Fn(StationId) -> ModeRefusal,
    ) -> Vec<ModeRefusal> {
        self.which_in(self.mode, what, reason)
    }

    fn which_in(
        &self,
        mode: ControlMode,
        what: impl Fn(&StationView) -> bool,
        reason: impl Fn(StationId) -> ModeRefusal,
    ) -> Vec<ModeRefusal> {
        self.counted_in(mode).filter(|(_, s)| self.is_known(s) && what(&s.heard)).map(|(id, _)| reason(id)).collect()
    }

    /// Reasons why auto or hand ends now.
    fn why_ended(&self) -> Vec<ModeRefusal> {
        let mut reasons = self.troubles_in(self.mode);
        reasons.extend(self.which(|h| h.selector_manual, ModeRefusal::SelectorManual));
        if reasons.is_empty() {
            reasons = self.left_out_away();
        }
        reasons
    }

    /// A person stands at the panel of a station: that it was restarted, or not received, keeps no mode any more, and is no reason to
    /// name for one that has ended.
    fn looked_at(&mut self, id: StationId) {
        if let Some(station) = self.stations.get_mut(id.index()) {
            (station.restarted, station.missed) = (false, false);
        }
        let is_over = |reasons: &mut Vec<ModeRefusal>| {
            let count = reasons.len();
            reasons.retain(|reason| *reason != ModeRefusal::Restarted(id));
            reasons.len() < count && reasons.is_empty()
        };
        self.ended.take_if(|(_, reasons)| is_over(reasons));
    }

    fn unheard(&self) -> Vec<ModeRefusal> {
        self.counted().filter(|(_, s)| !self.is_known(s)).map(|(id, _)| self.silence(id)).collect()
    }

    /// Plays the net until no arc is allowed. A command is used by the first arc that takes it.
    fn decide(&mut self, mut command: Option<ModeCommand>) {
        // Six places and exclusive arcs: more hops than places would be a loop among conditions that hold together.
        for _ in ControlMode::ALL {
            let Some(mode) = next(self.mode, &self.facts(command)) else { break };
            if mode == ControlMode::StandBy && command.is_none() {
                self.found_away |= self.mode == ControlMode::Home;
                self.is_unstarted = self.mode == ControlMode::Home || self.stopping;
                if matches!(self.mode, ControlMode::Auto | ControlMode::Hand) {
                    self.ended = Some((self.mode, self.why_ended()));
                }
            }
            command = None;
            self.enter(mode);
        }
    }

    fn enter(&mut self, mode: ControlMode) {
        self.epoch = self.epoch.saturating_add(1);
        if matches!(self.mode, ControlMode::Auto | ControlMode::Hand) {
            self.quiet = self.epoch;
            self.stations.iter_mut().for_each(|station| station.missed |= self.now >= station.known_until);
        }
        if self.mode == ControlMode::EStop {
            self.released = self.epoch;
        }
        if mode == ControlMode::EStop {
            self.stopped_in = self.epoch;
            // The reason of a stop is its own; what ended a mode before is not.
            self.ended = None;
        }
        self.mode = mode;
        self.enabled = false;
        self.changed = true;
        // Pressed in another mode it was not meant for this one.
        self.resume.disarm();
        self.modes.push(mode);
        if mode != ControlMode::Auto {
            self.stopping = false;
            self.end_single();
        }
        self.is_unstarted &= mode == ControlMode::StandBy;
        self.found_away &= mode == ControlMode::StandBy;
        if matches!(mode, ControlMode::Manual | ControlMode::EStop) {
            self.founding = None;
        }
        if mode == ControlMode::Manual {
            self.line.station_ids().for_each(|id| self.looked_at(id));
        }
        if mode != ControlMode::Manual && mode != ControlMode::StandBy {
            self.manual_all = false;
        }
    }

    /// Brings the decision up to `now`. Call it after every [`Coordinator::handle`] and at every deadline.
    pub fn step(&mut self, now: Tick, out: &mut ModeOutbox) {
        self.now = self.now.max(now);
        // Before the decision: after a standstill of this process a manual may be too old already.
        self.give_up_manual();
        self.decide(None);
        // In no mode, manual included, while it is not known whether the emergency stop button is pressed, or while another
        // coordinator gives orders as well.
        let is_alone = self.rival().is_none() && self.inactive.is_none();
        let enables = self.mode.enables_motion() && is_alone && !self.console_is_unknown() && self.founding.is_none();
        self.changed |= self.enabled && !is_alone;
        self.enabled &= is_alone;
        if enables && !self.enabled && self.all(|h| h.acknowledges(self.boot_id, self.epoch)) {
            self.enabled = true;
            self.changed = true;
            self.begin_cycle();
        }
        self.follow_single();
        let resumes = self.resumes();
        self.changed |= std::mem::replace(&mut self.has_resumed, resumes) != resumes;
        out.lamps = self.lamps();
        out.changed = std::mem::take(&mut self.changed);
        out.modes.append(&mut self.modes);
        out.obeyed = (out.obeyed && self.refusals.is_empty()) | std::mem::take(&mut self.obeyed);
        out.refusals.append(&mut self.refusals);
        out.cycles.append(&mut self.cycles);
    }

    /// Time of the next step if nothing arrives before.
    pub fn next_deadline(&self) -> Option<Tick> {
        let views = self.stations.iter().flat_map(|s| [s.known_until, s.inactive.map_or(Tick::ZERO, |of| of.1)]);
        let rival = self.rival.map_or(Tick::ZERO, |(_, until)| until);
        let manual = [self.manual_waits_until(), self.manual_given_up_at()];
        views.chain(manual).chain([self.buttons.until(), self.resume.until(), rival]).filter(|&t| t > self.now).min()
    }

    fn lamps(&self) -> u128 {
        let fault = self.stations.iter().any(|s| self.is_known(s) && s.heard.incomplete);
        let on = [
            self.mode == ControlMode::Auto,
            self.mode == ControlMode::Hand,
            self.mode == ControlMode::Manual,
            fault || self.estop.is_some(),
        ];
        let lamps = self.line.console.lamps.iter().zip(on);
        lamps.fold(0, |bits, (lamp, on)| bits | lamp.filter(|_| on).map_or(0, |lamp| 1 << lamp.0))
    }
}
