//! Playing the mode decision: commands, console and reports in; the order for every station out.
//!
//! The order carries an epoch, which grows with every change of mode, and a lease. A mode that enables motion is
//! *enabled* only when every station has acknowledged its epoch, so no station moves while another still acts on the
//! mode before. The same holds for rest: a station that was last heard standing stands for sure only once it has
//! acknowledged an epoch in which nothing starts by itself; master stop is of such an epoch, too. Everything unknown counts against motion: a station that is not heard is trouble, a console that was
//! heard and is no longer counts as a pressed emergency stop.

mod obey;

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, StationId, Tick};

use crate::buttons::Buttons;
use crate::decision::{Command, Facts, next};
use crate::refusal::{Reason, Refusal};

/// What the coordinator needs of a station's report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    /// Which life of the station.
    pub boot_id: u64,
    /// The newest epoch it has heard.
    pub mode_epoch: u64,
    /// At its home place.
    pub at_home: bool,
    /// The round it is in, or at the end of which it stands at home.
    pub round: i32,
    /// Nothing moves.
    pub stopped: bool,
    /// Some operation was stopped before its end.
    pub incomplete: bool,
    /// Its selector stands at manual.
    pub selector_manual: bool,
    /// Its devices are heard and operational.
    pub devices_valid: bool,
}

/// What the coordinator is told.
#[derive(Clone, Copy, Debug)]
pub enum Input {
    /// An operator's command, by message.
    Command(Command),
    /// The console's input image, and whether its devices vouch for it.
    Console {
        /// Bit `i` is input `i` of the console.
        bits: u128,
        /// False when a device is lost or has not yet spoken.
        valid: bool,
    },
    /// Hand-mode buttons held, by message, a bit each; replaces what was held before. Must be refreshed.
    Buttons(u32),
    /// A newer report of a station.
    Station(StationId, Heard),
}

/// The order for every station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// Grows with every change of mode.
    pub epoch: u64,
    /// The mode.
    pub mode: ControlMode,
    /// Every station has acknowledged the epoch.
    pub enabled: bool,
    /// Master stop: halt at the home place at the end of this round, the latest that any station has begun. All are at
    /// home together then, as they were at the beginning; a station that halted at home at once could leave another
    /// waiting for it, away from home, for ever.
    pub master_stop: Option<i32>,
    /// Every station's panel counts as switched to manual.
    pub manual_all: bool,
    /// Hand-mode buttons held.
    pub buttons: u32,
    /// How long the order holds after it is heard.
    pub lease: Duration,
}

/// What a step gives.
#[derive(Clone, Debug, Default)]
pub struct Outbox {
    /// Send the order and the state now.
    pub changed: bool,
    /// The console's output image: the lamps.
    pub lamps: u128,
    /// Modes entered, in order. The caller drains it.
    pub modes: Vec<ControlMode>,
    /// Commands refused, in order. The caller drains it.
    pub refusals: Vec<Refusal>,
}

#[derive(Clone, Debug, Default)]
struct Station {
    heard: Heard,
    known_until: Tick,
    /// Came up anew while the line was in auto or hand, and nobody has looked at it since.
    restarted: bool,
    /// Works on order: it has no rounds, and is at home at any rest.
    on_order: bool,
    /// What is wrong with it is an exception of its order (see [`Coordinator::isolate`]).
    isolated: bool,
}

impl Station {
    fn of(described: &linewright_line::Station) -> Self {
        Station { on_order: described.works_on_order(), ..Station::default() }
    }

    /// Whether it is not in the latest round, or at the end of it.
    fn is_behind(&self, latest_round: i32) -> bool {
        !self.on_order && self.heard.round != latest_round
    }
}

/// The coordinator.
#[derive(Clone, Debug)]
pub struct Coordinator {
    line: Line,
    now: Tick,
    mode: ControlMode,
    epoch: u64,
    enabled: bool,
    stopping: bool,
    /// The first epoch in which no station leaves its place by itself. Who has not acknowledged it may be on its way
    /// though it was last heard at rest.
    quiet: u64,
    estop: bool,
    /// "Manual" was commanded: as if every selector stood at manual.
    manual_all: bool,
    stations: Vec<Station>,
    console: (u128, bool),
    console_was_heard: bool,
    buttons: Buttons,
    changed: bool,
    modes: Vec<ControlMode>,
    refusals: Vec<Refusal>,
}

impl Coordinator {
    /// A coordinator for `line` whose epochs start above `last_epoch`, the highest one its predecessor is known to
    /// have used (0 if none). It comes up at the home place of the decision, in which nothing moves.
    pub fn new(line: Line, last_epoch: u64) -> Self {
        Coordinator {
            stations: line.stations.iter().map(Station::of).collect(),
            line,
            now: Tick::ZERO,
            mode: ControlMode::Home,
            epoch: last_epoch.saturating_add(1),
            enabled: false,
            stopping: false,
            quiet: last_epoch.saturating_add(1),
            estop: false,
            manual_all: false,
            console: (0, false),
            console_was_heard: false,
            buttons: Buttons::default(),
            changed: true,
            modes: Vec::new(),
            refusals: Vec::new(),
        }
    }

    /// The same coordinator with the emergency stop latched, as its predecessor left it: being replaced is no way out
    /// of the emergency stop.
    #[must_use]
    pub fn with_estop(mut self) -> Self {
        self.estop = true;
        self.decide(None);
        self
    }

    /// Whether the emergency stop is latched, or was and has not been left through manual: what a successor must know.
    pub fn is_estopped(&self) -> bool {
        self.estop || self.mode == ControlMode::EStop
    }

    /// The mode of the line.
    pub fn mode(&self) -> ControlMode {
        self.mode
    }

    /// The epoch of that mode.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// The order as it stands.
    pub fn order(&self) -> Order {
        Order {
            epoch: self.epoch,
            mode: self.mode,
            enabled: self.enabled || !self.mode.enables_motion(),
            master_stop: self.stopping.then(|| self.latest_round()),
            manual_all: self.manual_all,
            buttons: self.buttons.held(self.now) | self.wired_buttons(),
            lease: self.line.timing.lease,
        }
    }

    /// The latest round that any station has begun. It may still rise after the stop was given, until every station
    /// has heard it; then all follow.
    fn latest_round(&self) -> i32 {
        self.stations.iter().filter(|s| !s.on_order).map(|s| s.heard.round).max().unwrap_or(0)
    }

    fn all_in(&self, round: i32) -> bool {
        !self.stations.iter().any(|station| station.is_behind(round))
    }

    fn wired_buttons(&self) -> u32 {
        let wired = self.line.console.buttons.iter().enumerate();
        wired.fold(0, |bits, (i, input)| bits | u32::from(self.wired(*input)) << i)
    }

    fn wired(&self, input: Option<InputId>) -> bool {
        let (bits, valid) = self.console;
        valid && input.is_some_and(|input| bits & (1 << input.0) != 0)
    }

    /// Takes what has arrived and acts on it. Follow with [`Coordinator::step`].
    pub fn handle(&mut self, now: Tick, input: Input) {
        self.now = self.now.max(now);
        match input {
            Input::Command(command) => self.command(command),
            Input::Console { bits, valid } => self.hear_console(bits, valid),
            Input::Buttons(held) => self.changed |= self.buttons.hear(self.now, held, self.line.timing.stale),
            Input::Station(id, heard) => self.hear_station(id, heard),
        }
    }

    /// Leaves these stations out, and no others: what is wrong with them is an exception of the cell they work in
    /// ([`crate::cell::exception::isolated`]), and the others work on. Only stations on order can be left out. Call it
    /// whenever that changes, before [`Coordinator::step`]. `stations` is told as well whether a station is heard.
    pub fn isolate(&mut self, stations: impl Fn(StationId, bool) -> bool) {
        for (id, station) in self.line.station_ids().zip(&mut self.stations) {
            let isolated = station.on_order && stations(id, self.now < station.known_until);
            self.changed |= station.isolated != isolated;
            station.isolated = isolated;
        }
    }

    /// The stations that the mode depends on. Where people move stations, and in the emergency stop, that is all of them.
    fn counted(&self) -> impl Iterator<Item = (StationId, &Station)> {
        let leaves_out = match self.mode {
            ControlMode::Home | ControlMode::StandBy | ControlMode::Auto => true,
            ControlMode::Hand | ControlMode::Manual | ControlMode::EStop => false,
        };
        self.line.station_ids().zip(&self.stations).filter(move |(_, station)| !(leaves_out && station.isolated))
    }

    fn hear_console(&mut self, bits: u128, valid: bool) {
        let before = self.console;
        if before == (bits, valid) {
            return;
        }
        let lost = before.1 && !valid;
        self.console = (bits, valid);
        self.changed = true;
        let console = self.line.console.clone();
        // An emergency stop that cannot be heard counts as pressed.
        if self.wired(console.estop) || (lost && console.estop.is_some()) {
            self.estop = true;
        }
        // A button that was already down when the console came up was not pressed now.
        let first = !before.1;
        if valid && !first {
            let pressed = |input: Option<InputId>| input.is_some_and(|input| bits & !before.0 & (1 << input.0) != 0);
            let buttons = [
                (console.start, Command::Start),
                (console.stop, Command::Stop),
                (console.auto, Command::Auto),
                (console.hand, Command::Hand),
                (console.reset, Command::Reset),
            ];
            for (input, command) in buttons {
                if pressed(input) {
                    self.command(command);
                }
            }
        }
        self.console_was_heard |= valid;
    }

    fn hear_station(&mut self, id: StationId, heard: Heard) {
        let now = self.now;
        let Some(station) = self.stations.get_mut(id.index()) else { return };
        let rebooted = station.heard.boot_id != 0 && station.heard.boot_id != heard.boot_id;
        let news = station.heard != heard || now >= station.known_until;
        // In manual a person stands at the panel and holds every motion: there is nothing left to be looked at.
        station.restarted |= rebooted && matches!(self.mode, ControlMode::Auto | ControlMode::Hand);
        station.heard = heard;
        station.known_until = now + self.line.timing.stale;
        self.changed |= news;
        // The stations have obeyed a later epoch than ours: somebody coordinated them before us. Go above it, and to
        // a mode in which nothing starts.
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

    fn is_known(&self, station: &Station) -> bool {
        self.now < station.known_until
    }

    fn all(&self, what: impl Fn(&Heard) -> bool) -> bool {
        self.counted().all(|(_, s)| self.is_known(s) && what(&s.heard))
    }

    fn facts(&self, command: Option<Command>) -> Facts {
        Facts {
            command,
            estop: self.estop,
            trouble: !self.troubles().is_empty(),
            stopping: self.stopping,
            all_home: self.all(|h| self.is_at_rest(h) && h.at_home) && self.all_in(self.latest_round()),
            all_stopped: self.all(|h| self.is_at_rest(h)),
            any_manual: self.manual_all || self.any_selector(),
        }
    }

    /// Nothing moves, and nothing will by an order that it heard before.
    fn is_at_rest(&self, heard: &Heard) -> bool {
        heard.stopped && heard.mode_epoch >= self.quiet
    }

    fn any_selector(&self) -> bool {
        self.counted().any(|(_, s)| self.is_known(s) && s.heard.selector_manual)
    }

    /// What speaks against motion in auto and hand.
    fn troubles(&self) -> Vec<Reason> {
        let mut reasons = Vec::new();
        if self.console_was_heard && !self.console.1 {
            reasons.push(Reason::ConsoleLost);
        }
        for (id, station) in self.counted() {
            if !self.is_known(station) {
                reasons.push(Reason::NotHeard(id));
                continue;
            }
            if !station.heard.devices_valid {
                reasons.push(Reason::DevicesLost(id));
            }
            if station.heard.incomplete {
                reasons.push(Reason::Incomplete(id));
            }
            if station.restarted {
                reasons.push(Reason::Restarted(id));
            }
        }
        reasons
    }

    fn which(&self, what: impl Fn(&Heard) -> bool, reason: impl Fn(StationId) -> Reason) -> Vec<Reason> {
        self.counted().filter(|(_, s)| self.is_known(s) && what(&s.heard)).map(|(id, _)| reason(id)).collect()
    }

    fn unheard(&self) -> Vec<Reason> {
        self.counted().filter(|(_, s)| !self.is_known(s)).map(|(id, _)| Reason::NotHeard(id)).collect()
    }

    /// Plays the net until no arc is allowed. A command is used by the first arc that takes it.
    fn decide(&mut self, mut command: Option<Command>) {
        // Six places and exclusive arcs: more hops than places would be a loop among conditions that hold together.
        for _ in ControlMode::ALL {
            let Some(mode) = next(self.mode, &self.facts(command)) else { break };
            command = None;
            self.enter(mode);
        }
    }

    fn enter(&mut self, mode: ControlMode) {
        self.epoch = self.epoch.saturating_add(1);
        if matches!(self.mode, ControlMode::Auto | ControlMode::Hand) {
            self.quiet = self.epoch;
        }
        self.mode = mode;
        self.enabled = false;
        self.changed = true;
        self.modes.push(mode);
        if mode != ControlMode::Auto {
            self.stopping = false;
        }
        if mode == ControlMode::Manual {
            for station in &mut self.stations {
                station.restarted = false;
            }
        }
        if mode != ControlMode::Manual && mode != ControlMode::StandBy {
            self.manual_all = false;
        }
    }

    /// Brings the decision up to `now`. Call it after every [`Coordinator::handle`] and at every deadline.
    pub fn step(&mut self, now: Tick, out: &mut Outbox) {
        self.now = self.now.max(now);
        self.decide(None);
        if self.mode.enables_motion() && !self.enabled && self.all(|h| h.mode_epoch >= self.epoch) {
            self.enabled = true;
            self.changed = true;
        }
        out.lamps = self.lamps();
        out.changed = std::mem::take(&mut self.changed);
        out.modes.append(&mut self.modes);
        out.refusals.append(&mut self.refusals);
    }

    /// When to step again if nothing arrives before.
    pub fn next_deadline(&self) -> Option<Tick> {
        let views = self.stations.iter().map(|s| s.known_until);
        views.chain([self.buttons.until()]).filter(|&t| t > self.now).min()
    }

    fn lamps(&self) -> u128 {
        let fault = self.stations.iter().any(|s| self.is_known(s) && s.heard.incomplete);
        let on = [
            self.mode == ControlMode::Auto,
            self.mode == ControlMode::Hand,
            self.mode == ControlMode::Manual,
            fault || self.estop,
        ];
        let lamps = self.line.console.lamps.iter().zip(on);
        lamps.fold(0, |bits, (lamp, on)| bits | lamp.filter(|_| on).map_or(0, |lamp| 1 << lamp.0))
    }

    /// Stations that have not acknowledged the epoch of a mode that enables motion.
    pub fn waiting_for(&self) -> Vec<StationId> {
        if !self.mode.enables_motion() || self.enabled {
            return Vec::new();
        }
        let waits = |s: &Station| !self.is_known(s) || s.heard.mode_epoch < self.epoch;
        self.counted().filter(|(_, s)| waits(s)).map(|(id, _)| id).collect()
    }

    /// Whether a station is heard.
    pub fn hears(&self, station: StationId) -> bool {
        self.stations.get(station.index()).is_some_and(|s| self.is_known(s))
    }

    /// The mode in words, with what keeps it: `auto`, `auto, stopping at home`, `stand-by: mill_1 is not heard`.
    pub fn text(&self) -> String {
        let mut text = self.mode.name().to_owned();
        if self.stopping {
            text.push_str(", stopping at home");
        }
        let waiting: Vec<&str> = self.waiting_for().iter().map(|&s| self.line.station(s).name.as_str()).collect();
        if !waiting.is_empty() {
            text.push_str(&format!(", waiting for {}", waiting.join(", ")));
        }
        let alone = self.line.station_ids().zip(&self.stations).filter(|(_, station)| station.isolated);
        let alone: Vec<&str> = alone.map(|(id, _)| self.line.station(id).name.as_str()).collect();
        if !alone.is_empty() {
            text.push_str(&format!(", without {}", alone.join(", ")));
        }
        let troubles: Vec<String> = self.troubles().iter().map(|reason| reason.text(&self.line)).collect();
        if !troubles.is_empty() {
            text.push_str(&format!(": {}", troubles.join("; ")));
        }
        text
    }
}
