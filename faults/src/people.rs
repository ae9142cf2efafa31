//! An operator that brings the line back after all faults have ended, by what the manual says and without a plan.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{AxisId, StationId};
use linewright_station_logic::{Controller, RejoinAt};

use crate::world::World;

/// The beginning of a text that says that stations could not be led home.
pub(crate) const NOT_HOME: &str = "not all stations are home";
/// Steps in which stations are led home.
const ROUNDS: usize = 60;
/// Steps after which a station that is in none of its operations is put home by hand.
const TRIED: usize = 12;
/// Places on the way of an axis that is pushed by hand at which is looked whether another station is in its way, the last one included.
const PASSED: usize = 16;

impl World {
    pub(crate) fn controller(&self, at: usize) -> Option<&Controller> {
        self.stations[at].shell.as_ref().map(|shell| shell.controller())
    }

    pub(crate) fn mode(&self) -> Option<ControlMode> {
        self.coordinators[0].mode()
    }

    /// Runs until something holds, at most so long.
    fn wait_for(&mut self, time: Duration, holds: impl Fn(&World) -> bool) -> bool {
        let end = self.now + time;
        while !holds(self) {
            if self.now >= end || self.observer.finding.is_some() {
                return false;
            }
            self.run_for(Duration::from_millis(10));
        }
        true
    }

    /// Gives a command; the refusal, if it is not obeyed.
    pub(crate) fn ask(&mut self, command: ModeCommand) -> Result<(), String> {
        let before = self.coordinators[0].answers;
        self.say_command(command);
        if !self.wait_for(Duration::from_secs(2), |world| world.coordinators[0].answers > before) {
            return Err(format!("{}: no answer", command.name()));
        }
        self.run_for(Duration::from_millis(60));
        self.coordinators[0].refusal.take().map_or(Ok(()), Err)
    }

    fn ask_until(&mut self, command: ModeCommand, times: usize) -> Result<(), String> {
        let mut outcome = Ok(());
        for _ in 0..times {
            outcome = self.ask(command);
            if outcome.is_ok() || self.observer.finding.is_some() {
                break;
            }
            self.run_for(Duration::from_millis(200));
        }
        outcome
    }

    fn all_stand(&self) -> bool {
        (0..self.stations.len()).all(|at| self.controller(at).is_some_and(|c| !c.marking().any(|p| p.is_operating())))
    }

    /// Brings the line to auto and waits for a whole cycle.
    ///
    /// # Errors
    /// What did not succeed.
    pub(crate) fn bring_back(&mut self) -> Result<(), String> {
        self.run_for(Duration::from_secs(3));
        let mut outcome = Ok(());
        for _ in 0..4 {
            outcome = self.bring_to_auto().and_then(|()| self.one_cycle());
            if outcome.is_ok() || self.observer.finding.is_some() {
                return Ok(());
            }
            let _ = self.ask(ModeCommand::EStop);
            self.run_for(Duration::from_secs(1));
            self.start_again();
        }
        outcome
    }

    /// A station that the coordinator does not receive though it runs is started again, as its log asks for after an epoch that
    /// no coordinator can have given.
    pub(crate) fn start_again(&mut self) {
        for at in 0..self.stations.len() {
            let coordinator = self.coordinators[0].shell.as_ref();
            if coordinator.is_some_and(|shell| !shell.coordinator().hears(StationId::at(at))) {
                self.note(format!("{} is started again by the operator", self.name(at)));
                self.kill(at);
                self.run_for(Duration::from_millis(600));
                self.start(at, true);
            }
        }
        self.run_for(Duration::from_secs(1));
    }

    /// Brings the line to auto without a plan.
    pub(crate) fn bring_to_auto(&mut self) -> Result<(), String> {
        if self.mode() == Some(ControlMode::Auto) {
            return Ok(());
        }
        for at in 0..self.stations.len() {
            self.say_selector(at, false);
        }
        self.run_for(Duration::from_millis(200));
        match self.mode() {
            Some(ControlMode::EStop) => self.ask_until(ModeCommand::Reset, 5)?,
            Some(ControlMode::Hand) => self.ask(ModeCommand::Stop)?,
            _ => {}
        }
        if self.mode() == Some(ControlMode::Home) {
            let _ = self.ask(ModeCommand::Start);
        }
        self.wait_for(Duration::from_secs(20), World::all_stand);
        if self.mode() != Some(ControlMode::Manual) {
            self.ask_until(ModeCommand::Manual, 20)?;
        }
        let manual = |world: &World| {
            (0..world.stations.len()).all(|at| world.controller(at).is_some_and(|c| c.mode() == ControlMode::Manual))
        };
        if !self.wait_for(Duration::from_secs(40), manual) {
            return Err(format!("manual is not granted: {}", self.situation()));
        }
        self.lead_on();
        // Where all remember what they have done, the chart goes on from where it stands.
        if self.has_common_counts() && self.ask_until(ModeCommand::Auto, 3).is_ok() {
            return Ok(());
        }
        self.lead_home()?;
        self.ask_until(ModeCommand::Auto, 10)
    }

    /// Whatever was stopped in the middle is led to its end, or back.
    fn lead_on(&mut self) {
        for at in 0..self.stations.len() {
            for _ in 0..6 {
                let report = self.controller(at).map(Controller::report);
                if report.is_some_and(|report| !report.incomplete.is_empty() || report.recovering_home)
                    && !self.jog(at, true)
                {
                    self.jog(at, false);
                }
            }
        }
    }

    fn has_common_counts(&self) -> bool {
        let generations: Vec<u64> =
            (0..self.stations.len()).map(|at| self.controller(at).map_or(0, Controller::generation)).collect();
        generations[0] != 0 && generations.iter().all(|generation| *generation == generations[0])
    }

    fn is_home(&self, at: usize) -> bool {
        self.controller(at).is_some_and(|c| c.is_at_home() && c.report().position_lost.is_none())
    }

    /// Leads every station home: forward where that goes, back where it does not, and again, since one may wait for another.
    fn lead_home(&mut self) -> Result<(), String> {
        let mut back = vec![false; self.stations.len()];
        for round in 0..ROUNDS {
            let away: Vec<usize> = (0..self.stations.len()).filter(|&at| !self.is_home(at)).collect();
            if away.is_empty() {
                return Ok(());
            }
            // One that is home may be in the way, and one may have to be led back before another can go on.
            let any = round > 6;
            for away in away {
                let at = if any { self.rng.below(self.stations.len() as u64) as usize } else { away };
                if any {
                    back[at] = self.rng.chance(400);
                }
                if self.asks_to_confirm(at) {
                    let is_nowhere = self.operations_that_fit(StationId::at(at)).is_empty();
                    if round > if is_nowhere { TRIED } else { 2 * TRIED } {
                        self.put_home(at)?;
                    }
                    self.confirm(at, round);
                }
                if !self.jog(at, !back[at]) {
                    back[at] = !back[at];
                }
                if self.observer.finding.is_some() {
                    return Ok(());
                }
            }
        }
        Err(format!("{NOT_HOME}: {}", self.situation()))
    }

    /// Puts the axes of a station that stands to where it has them at home, by hand: it is in no operation of its own.
    ///
    /// # Errors
    /// Where another station is in the way there, which a person sees.
    fn put_home(&mut self, at: usize) -> Result<(), String> {
        let id = StationId::at(at);
        if self.controller(at).is_none_or(|c| c.marking().any(|place| place.is_operating())) {
            return Ok(());
        }
        let home = self.line.station(id).positions_before_steps().into_iter().next().unwrap_or_default();
        let places: Vec<(AxisId, f64)> =
            home.into_iter().enumerate().map(|(axis, at)| (AxisId::at(axis), at)).collect();
        self.note(format!("{} is put to its home place by hand", self.name(at)));
        self.put_by_hand(at, &places)
    }

    /// Puts axes of a station to these places by hand. A person does not push one to where another station is in its way, nor past it.
    ///
    /// # Errors
    /// Where that is so; they stand where they stood.
    pub(crate) fn put_by_hand(&mut self, at: usize, places: &[(AxisId, f64)]) -> Result<(), String> {
        let (id, now) = (StationId::at(at), self.now);
        let before: Vec<f64> = places.iter().map(|&(axis, _)| self.plant.position(id, axis)).collect();
        let meets = |passed: usize| {
            let way = places.iter().zip(&before);
            way.for_each(|(&(axis, to), from)| {
                let at = from + (to - from) * passed as f64 / PASSED as f64;
                self.plant.place(now, id, axis, at);
            });
            self.observer.would_meet(&self.line, &self.plant, at)
        };
        if !(1..=PASSED).any(meets) {
            self.look_at_devices(at);
            return Ok(());
        }
        places.iter().zip(before).for_each(|(&(axis, _), to)| self.plant.place(now, id, axis, to));
        Err(format!("{NOT_HOME}: another station is in the way of {}", self.name(at)))
    }

    /// What the coordinator and the stations say of themselves.
    pub(crate) fn situation(&self) -> String {
        let mut why: Vec<String> = self.coordinators[0].shell.iter().map(|shell| shell.coordinator().text()).collect();
        why.extend(self.coordinators[0].refusal.clone());
        for at in 0..self.stations.len() {
            let clock = self.stations[at].process.clock(self.now);
            let Some(controller) = self.controller(at) else { continue };
            let (marking, waits) = (controller.marking().collect::<Vec<_>>(), controller.blocked_by(&self.line, clock));
            let (generation, mode) = (controller.generation(), controller.mode());
            let id = StationId::at(at);
            let axes = (0..self.line.station(id).axes.len()).map(|axis| self.plant.position(id, AxisId::at(axis)));
            let stands: Vec<String> = axes.map(|position| format!("{position:.2}")).collect();
            let stands = stands.join(", ");
            why.push(format!(
                "{} in {mode}, at {stands}, generation {generation}: {marking:?}: {waits:?}",
                self.name(at)
            ));
        }
        why.join("; ")
    }

    fn asks_to_confirm(&self, at: usize) -> bool {
        let clock = self.stations[at].process.clock(self.now);
        self.controller(at).is_some_and(|c| c.blocked_by(&self.line, clock).iter().any(|why| why.contains("rejoin")))
    }

    /// Confirms where a station stands: where its switches measure it, else within one of the operations that fit, one after
    /// another, as a person would who looks.
    fn confirm(&mut self, at: usize, round: usize) {
        let id = StationId::at(at);
        let measured = self.controller(at).is_some_and(|c| c.read_off().is_some());
        let place = if measured {
            RejoinAt::Measured
        } else {
            let fits = self.operations_that_fit(id);
            match fits.get(round % fits.len().max(1)) {
                Some(&op) => RejoinAt::Within(op),
                None => RejoinAt::Measured,
            }
        };
        self.say_rejoin(at, place);
        self.run_for(Duration::from_millis(150));
    }

    /// Operations in whose motion the mechanisms may stand, by their positions.
    pub(crate) fn operations_that_fit(&self, id: StationId) -> Vec<linewright_line::OpId> {
        let station = self.line.station(id);
        let mut fits = Vec::new();
        for (step, before) in station.positions_before_steps().into_iter().enumerate() {
            for &op in &station.steps[step] {
                let motion = &station.operations[op.index()].motion;
                let is_in = before.iter().enumerate().all(|(axis, &from)| {
                    let position = self.plant.position(id, AxisId::at(axis));
                    let of_axis =
                        |op: &&linewright_line::OpId| station.operations[op.index()].motion.axis.index() == axis;
                    let end = |op: &linewright_line::OpId| {
                        station.operations[op.index()].motion.to + station.index_of(*op).unwrap_or(0.0)
                    };
                    let to = station.steps[step].iter().find(of_axis).map_or(from, end);
                    let slack = 0.01 * (motion.to - motion.from).abs().max(1e-3);
                    from.min(to) - slack <= position && position <= from.max(to) + slack
                });
                if is_in {
                    fits.push(op);
                }
            }
        }
        fits
    }

    /// Holds a panel button until the operation under way ends. Gives whether anything moved.
    fn jog(&mut self, at: usize, advance: bool) -> bool {
        let marking = |world: &World| world.controller(at).map(|c| c.marking().collect::<Vec<_>>());
        let before = marking(self);
        self.press(at, advance, true);
        let moved = self.wait_for(Duration::from_millis(700), |world| marking(world) != before);
        if moved {
            self.wait_for(Duration::from_secs(10), |world| {
                world.controller(at).is_some_and(|c| !c.marking().any(|p| p.is_operating()))
            });
        }
        self.press(at, advance, false);
        self.run_for(Duration::from_millis(150));
        moved
    }

    /// Every station comes home twice in auto: the first time may end a cycle that had begun.
    pub(crate) fn one_cycle(&mut self) -> Result<(), String> {
        let homes = |world: &World| -> Vec<i32> {
            (0..world.stations.len())
                .map(|at| world.controller(at).map_or(0, |c| c.report().done[world.line.stations[at].home.index()]))
                .collect()
        };
        self.wait_for(Duration::from_secs(1), |world| world.mode() == Some(ControlMode::Auto));
        let before = homes(self);
        let all: Duration = self.line.stations.iter().flat_map(|s| &s.operations).map(|op| op.duration).sum();
        let time = 4 * all + Duration::from_secs(10);
        if self.wait_for(time, |world| homes(world).iter().zip(&before).all(|(now, before)| *now >= before + 2)) {
            return Ok(());
        }
        Err(format!("no whole cycle in auto: {before:?} → {:?}: {}", homes(self), self.situation()))
    }
}
