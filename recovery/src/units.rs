//! The stations of a line as they are played: real controllers that exchange their reports at once, while time stands still.

use std::hash::{Hash, Hasher};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use linewright_line::net::{ControlMode, MotionStage, StationPlace};
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_station_logic::{
    Controller, Handled, ModeOrder, NO_DELAY, PanelCommand, RejoinAt, StationInput, StationOutbox, StationReport,
};

use crate::image::{self, SeenAxes};
use crate::step::PanelButton;

/// The moment at which everything happens: nothing expires.
pub(crate) const NOW: Tick = Tick::from_millis(1);
/// Steps of one controller on one input, and rounds of reports: more would be a loop.
const ROUNDS_MAX: usize = 10_000;

/// A station.
#[derive(Clone)]
pub(crate) struct PlayedStation {
    pub controller: Controller,
    pub report: StationReport,
    /// Whatever tells its states apart in a search.
    pub key: u64,
}

impl PlayedStation {
    pub fn new(controller: Controller) -> Self {
        let mut unit = PlayedStation { report: controller.report(), controller, key: 0 };
        unit.note();
        unit
    }

    fn note(&mut self) {
        self.controller.report_into(&mut self.report);
        let of = &self.report;
        let mut hasher = rustc_hash::FxHasher::default();
        (&of.places, &of.done, &of.started, of.cycle, of.generation, of.measured).hash(&mut hasher);
        (of.recovering_home, of.position_lost.is_some(), of.selector_manual, of.mode.map(|m| m as u8))
            .hash(&mut hasher);
        self.key = hasher.finish();
    }

    /// Takes an input and plays until nothing follows; whether the report has changed.
    pub fn take(&mut self, input: StationInput<'_>) -> (Handled, bool) {
        let is_image = matches!(input, StationInput::Inputs { .. });
        let handled = self.controller.handle(NOW, input);
        let changed = self.play();
        // Not every switch is news to others.
        if changed || is_image {
            self.note();
        }
        (handled, changed)
    }

    /// The numbers of a confirmation: the motions that follow are the same whichever a person gives.
    pub fn any_numbers(&self, at: RejoinAt) -> Vec<(Arc<str>, i32)> {
        self.controller.numbers_to_confirm(at).iter().map(|of| (of.name.as_str().into(), 0)).collect()
    }

    fn play(&mut self) -> bool {
        let mut out = StationOutbox::default();
        let mut changed = false;
        for _ in 0..ROUNDS_MAX {
            self.controller.step(NOW, &mut out);
            if !out.changed {
                break;
            }
            changed = true;
        }
        changed
    }

    /// What moves.
    pub fn motions(&self) -> Vec<StationPlace> {
        self.controller.marking().filter(|place| place.is_operating()).collect()
    }

    /// Whether nothing of it speaks against motion in auto.
    pub fn is_in_order(&self, is_task_driven: bool) -> bool {
        let of = &self.report;
        let whole = of.incomplete.is_empty() && !of.recovering_home && of.position_lost.is_none();
        whole && (!is_task_driven || of.at_home)
    }
}

/// All stations. A copy shares those that are not changed.
pub(crate) type PlayedStations = Vec<Rc<PlayedStation>>;

/// A press that moves something.
pub(crate) struct Pressed {
    pub units: PlayedStations,
    pub motions: Vec<StationPlace>,
    pub time: Duration,
    /// Its switch is on already, and has to be believed for it to count. The report does not have whether it was on from before
    /// the motion; where it was, the machine's controller takes it for the arrival after its watchdog has reported it, and no
    /// sooner.
    pub is_doubtful: bool,
    /// The motion is the homing of the drive of an index, at a rest.
    pub homes: bool,
}

/// *Resume* held at the console, where it leads on more than one station.
pub(crate) struct Resumed {
    pub units: PlayedStations,
    pub motions: Vec<(StationId, StationPlace)>,
    /// Of all motions, one after the other.
    pub time: Duration,
}

/// A line, with the readers of each station's reports.
pub(crate) struct PlayedLine<'l> {
    pub line: &'l Line,
    readers: Vec<Vec<usize>>,
    seen: Vec<SeenAxes>,
}

impl<'l> PlayedLine<'l> {
    pub fn new(line: &'l Line, units: &PlayedStations) -> Self {
        let mut readers = vec![Vec::new(); units.len()];
        for (reader, unit) in units.iter().enumerate() {
            unit.controller.peers().iter().for_each(|peer| readers[peer.index()].push(reader));
        }
        PlayedLine { line, readers, seen: SeenAxes::of_line(line) }
    }

    /// Every station receives every report.
    pub fn meet(&self, units: &mut PlayedStations) {
        self.spread(units, (0..units.len()).collect());
    }

    /// The reports of these stations go to their readers, and what follows.
    fn spread(&self, units: &mut PlayedStations, mut from: Vec<usize>) {
        for _ in 0..ROUNDS_MAX {
            let Some(writer) = from.pop() else { return };
            let sent = Rc::clone(&units[writer]);
            for &reader in &self.readers[writer] {
                let input = StationInput::View(StationId::at(writer), &sent.report);
                let (_, changed) = Rc::make_mut(&mut units[reader]).take(input);
                if changed && !from.contains(&reader) {
                    from.push(reader);
                }
            }
        }
    }

    /// A station takes an input; whatever follows at all of them follows.
    pub fn give(&self, units: &mut PlayedStations, station: usize, input: StationInput<'_>) -> Handled {
        let (handled, changed) = Rc::make_mut(&mut units[station]).take(input);
        if changed {
            self.spread(units, vec![station]);
        }
        handled
    }

    pub fn order(&self, units: &mut PlayedStations, station: usize, order: ModeOrder) {
        self.give(units, station, StationInput::Order(order));
    }

    /// A station has this image. An input that sees its axes changes where they come to be seen, or leave; else it stays as it is measured.
    fn image(&self, units: &mut PlayedStations, station: usize, bits: u128) {
        let on = |units: &PlayedStations| -> Vec<bool> {
            self.seen.iter().map(|seen| seen.is_on(|id| units[id.index()].report.measured)).collect()
        };
        let before = on(units);
        self.give(units, station, whole_image(bits));
        for (at, (was_on, is_on)) in before.into_iter().zip(on(units)).enumerate() {
            if was_on != is_on {
                let SeenAxes { reader, input, .. } = self.seen[at];
                let measured = units[reader.index()].report.measured & !input;
                let image = if is_on { measured | input } else { measured };
                self.give(units, reader.index(), whole_image(image));
            }
        }
    }

    /// Holds a panel button until what it starts has arrived. None where it starts nothing that arrives.
    pub fn press(&self, before: &PlayedStations, station: usize, button: PanelButton) -> Option<Pressed> {
        let mut units = before.clone();
        let command = |held| match button {
            PanelButton::Advance => PanelCommand::Advance(held),
            PanelButton::Return => PanelCommand::Retract(held),
        };
        self.give(&mut units, station, StationInput::Panel(command(true)));
        let motions = units[station].motions();
        if let Some(index) = units[station].controller.homes() {
            return self.homed(units, station, index);
        }
        if motions.is_empty() {
            // What stands at its end already is done without a motion, as on a recovery path.
            self.give(&mut units, station, StationInput::Panel(command(false)));
            let is_counted = units[station].report.places != before[station].report.places;
            let is_doubtful = self.believes_a_switch(&before[station], &units[station], &motions);
            return is_counted.then_some(Pressed { units, motions, time: Duration::ZERO, is_doubtful, homes: false });
        }
        let id = StationId::at(station);
        let (described, bits) = (self.line.station(id), units[station].report.measured);
        self.image(&mut units, station, image::under_way(described, bits, &motions));
        self.image(&mut units, station, image::arrived(self.line, id, bits, &motions));
        self.give(&mut units, station, StationInput::Panel(command(false)));
        let unit = &units[station];
        let has_stopped =
            |place: &StationPlace| unit.controller.marking().any(|at| at == place.stopped() || at == *place);
        if motions.iter().any(has_stopped) {
            return None;
        }
        let time = motions.iter().map(|&place| image::motion(described, place).1).max().unwrap_or_default();
        let is_on = |place: &StationPlace| image::is_at_end(described, bits, *place);
        let is_doubtful =
            motions.iter().any(is_on) || self.believes_a_switch(&before[station], &units[station], &motions);
        Some(Pressed { units, motions, time, is_doubtful, homes: false })
    }

    /// The homing under way is at its end, and *advance* is let go. How far the axis turns is not known before.
    fn homed(&self, mut units: PlayedStations, station: usize, index: OpId) -> Option<Pressed> {
        let (id, bits) = (StationId::at(station), units[station].report.measured);
        self.image(&mut units, station, image::homed(self.line, id, bits, index));
        self.give(&mut units, station, StationInput::Panel(PanelCommand::Advance(false)));
        let time = self.line.operation((id, index)).watchdog;
        let motions = vec![StationPlace::operating(index)];
        Some(Pressed { units, motions, time, is_doubtful: false, homes: true })
    }

    /// Whether an operation that was stopped is complete now, the same way, and has not moved.
    fn believes_a_switch(&self, before: &PlayedStation, after: &PlayedStation, motions: &[StationPlace]) -> bool {
        let completed = |place: StationPlace| StationPlace { stage: MotionStage::Completed, ..place };
        before.controller.marking().filter(|place| place.is_incomplete()).any(|stopped| {
            let has_moved = motions.iter().any(|place| place.op == stopped.op);
            !has_moved && after.controller.marking().any(|place| place == completed(stopped))
        })
    }

    /// Holds *resume* until all that goes on by it has arrived. None where it leads on less than two stations: at one of them
    /// the panel does as well. None, too, where something does not arrive.
    pub fn resume(&self, before: &PlayedStations) -> Option<Resumed> {
        if before.iter().filter(|unit| !unit.report.incomplete.is_empty()).count() < 2 {
            return None;
        }
        let mut units = before.clone();
        self.hold_resume(&mut units, true);
        let (mut motions, mut time) = (Vec::new(), Duration::ZERO);
        while let Some(station) = (0..units.len()).find(|&station| !units[station].motions().is_empty()) {
            let id = StationId::at(station);
            let (described, bits) = (self.line.station(id), units[station].report.measured);
            let moves = units[station].motions();
            if self.believes_a_switch(&before[station], &units[station], &moves) {
                return None;
            }
            self.image(&mut units, station, image::under_way(described, bits, &moves));
            self.image(&mut units, station, image::arrived(self.line, id, bits, &moves));
            // Each goes on once: no motion of these can be here again.
            if !units[station].motions().is_empty() || !units[station].report.incomplete.is_empty() {
                return None;
            }
            time += moves.iter().map(|&place| image::motion(described, place).1).max().unwrap_or_default();
            motions.extend(moves.into_iter().map(|place| (id, place)));
        }
        self.hold_resume(&mut units, false);
        let is_still = |at: usize| !motions.iter().any(|(id, _): &(StationId, _)| id.index() == at);
        let is_doubtful = |at: usize| is_still(at) && self.believes_a_switch(&before[at], &units[at], &[]);
        if (0..units.len()).any(is_doubtful) {
            return None;
        }
        let first = motions.first().map(|(id, _)| *id);
        let is_more = motions.iter().any(|(id, _)| Some(*id) != first);
        is_more.then_some(Resumed { units, motions, time })
    }

    fn hold_resume(&self, units: &mut PlayedStations, held: bool) {
        for station in 0..units.len() {
            let epoch = units[station].report.mode_epoch;
            self.order(units, station, ModeOrder { resume: held, ..in_manual(epoch) });
        }
    }

    /// A person confirms where a station stands. None where its switches contradict, or its position is known.
    pub fn rejoin(&self, before: &PlayedStations, station: usize, at: RejoinAt) -> Option<PlayedStations> {
        let mut units = before.clone();
        let numbers = before[station].any_numbers(at);
        self.give(&mut units, station, StationInput::Rejoin(at, &numbers)).is_taken().then_some(units)
    }
}

/// The order of a commanded manual.
pub(crate) fn in_manual(epoch: u64) -> ModeOrder {
    ModeOrder { manual_all: true, ..ModeOrder::of(1, epoch, ControlMode::Manual, ModeOrder::FOR_GOOD) }
}

/// An image that the devices vouch for.
pub(crate) const fn whole_image(bits: u128) -> StationInput<'static> {
    StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: NO_DELAY }
}
