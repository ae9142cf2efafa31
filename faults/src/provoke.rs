//! Faults and people that look first: chosen by where the line stands when they begin.
//!
//! Some rules alone matter for a few milliseconds in one situation of the line. Faults drawn without looking at it come
//! there once in many thousand seeds. What is planned here follows from the situation and a number of the plan, so that the
//! same seed is the same run.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{Block, ControlMode, MotionStage, StationPlace};
use linewright_line::{Arrow, InputId, OpId, OperationModule, Owner, StationId};
use linewright_plant::MotionFault;
use linewright_simulation::Rng;

use crate::plan::{FaultEvent, PlannedFault};
use crate::world::{Event, World};

/// What is looked for, and made use of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Provocation {
    /// In manual: one station is led back, and another one on, which waits for what the first one has done; over slow ways.
    TwoPanels,
    /// The same; the first one is started again in between, and received by the other one as late as can be.
    TwoLives,
    /// In auto: a station that waits for another one stands, and nothing reaches it until it goes on.
    Standstill,
    /// In auto: a station is cut off from one other alone, for which it is going to wait.
    CutOff,
    /// An irreversible motion fails, and its station is led home.
    WayHome,
    /// Two stations in conflict without a generation in common, at both of whose panels people press.
    NoGeneration,
    /// At home the switch of a mechanism is off, and auto is commanded.
    OffAtHome,
    /// A switch that is on stays on.
    StaysOn,
}

impl World {
    pub(crate) fn provoke(&mut self, what: Provocation, draw: u64) {
        let mut rng = Rng::new(draw);
        match what {
            Provocation::TwoPanels => self.two_panels(&mut rng),
            Provocation::TwoLives => self.two_lives(&mut rng),
            Provocation::Standstill => self.standstill(&mut rng),
            Provocation::CutOff => self.cut_off(&mut rng),
            Provocation::WayHome => self.way_home(&mut rng),
            Provocation::NoGeneration => self.no_generation(&mut rng),
            Provocation::OffAtHome => self.off_at_home(&mut rng),
            Provocation::StaysOn => self.stays_on(&mut rng),
        }
    }

    /// Plans a fault that begins some time from now; both times in µs.
    fn also(&mut self, after: u64, lasts: u64, event: FaultEvent) {
        let at = self.plan.len();
        let after = Duration::from_micros(after);
        self.plan.push(PlannedFault { at: self.now + after, lasts: Duration::from_micros(lasts), event });
        self.active.push(false);
        self.after(after, Event::Fault(at));
    }

    /// One of the arrows that fit best, each judged by a number.
    fn arrow(&self, rng: &mut Rng, fit: impl Fn(&Arrow) -> u32) -> Option<Arrow> {
        let best = self.line.arrows.iter().map(&fit).max()?;
        let fitting: Vec<Arrow> = self.line.arrows.iter().filter(|arrow| fit(arrow) == best).copied().collect();
        Some(*rng.pick(&fitting))
    }

    /// Whether a station stands where `op` is the last that was done.
    fn has_done(&self, (station, op): (StationId, OpId)) -> bool {
        self.controller(station.index())
            .is_some_and(|at| at.marking().all(|place| place == StationPlace::completed(op)))
    }

    /// Whether a station stands where `op` is the next to be done.
    fn does_next(&self, (station, op): (StationId, OpId)) -> bool {
        let described = self.line.station(station);
        let count = described.steps.len();
        let is_there = |place: StationPlace| {
            let step = described.step_of(place.op) + usize::from(place.block == Block::Normal);
            place.stage == MotionStage::Completed && step % count == described.step_of(op)
        };
        self.controller(station.index()).is_some_and(|at| at.marking().all(is_there))
    }

    /// An arrow in manual whose first station is where it can be led back, and whose second one is where it can be led on. Where
    /// there is none, people lead the two of one there, and look again.
    fn contended(&mut self, what: Provocation, rng: &mut Rng) -> Option<(usize, usize)> {
        let fit = |arrow: &Arrow| {
            u32::from(arrow.manual) * (1 + u32::from(self.has_done(arrow.from)) + u32::from(self.does_next(arrow.to)))
        };
        let arrow = self.arrow(rng, fit)?;
        let (first, second) = (arrow.from.0.index(), arrow.to.0.index());
        let (is_done, is_next) = (self.has_done(arrow.from), self.does_next(arrow.to));
        if (is_done && is_next) || rng.chance(100) {
            return Some((first, second));
        }
        if !is_done {
            self.also(1_000, 800_000, FaultEvent::Press(first, rng.chance(500)));
        }
        if !is_next {
            self.also(1_000, 800_000, FaultEvent::Press(second, rng.chance(400)));
        }
        self.also(900_000, 1_000, FaultEvent::Provoked(what, rng.next()));
        None
    }

    fn two_panels(&mut self, rng: &mut Rng) {
        let Some((first, second)) = self.contended(Provocation::TwoPanels, rng) else { return };
        if rng.chance(400) {
            return self.overtaken((first, second), rng);
        }
        let (mut there, mut back) = (700, 700);
        let delays = [0, 5_000, 30_000, 90_000];
        for (from, to, time) in [(first, second, &mut there), (second, first, &mut back)] {
            let by = *rng.pick(&delays);
            *time += by;
            let by = Duration::from_micros(by);
            self.also(0, 1_500_000, FaultEvent::Slow { from, to, by, is_even: true });
        }
        // Led back, and given up before the other one has agreed.
        let (begins, held) = (5_000, rng.within(2_000, there + back + 20_000));
        self.also(begins, held, FaultEvent::Press(first, false));
        // Led on as soon as that is known there.
        let given_up = begins + held + there;
        for _ in 0..rng.within(1, 3) {
            self.also(given_up + rng.within(500, 50_000), rng.within(10_000, 300_000), FaultEvent::Press(second, true));
        }
        // Led back again before it is known that the other one goes on.
        let again = begins + held + rng.within(3_000, there + back + 20_000);
        self.also(again, rng.within(50_000, 400_000), FaultEvent::Press(first, false));
    }

    /// The last that the first one sends before it is led back arrives after all that follows, while the other one is to be led on
    /// again and again.
    fn overtaken(&mut self, (first, second): (usize, usize), rng: &mut Rng) {
        let by = Duration::from_micros(rng.within(60_000, 220_000));
        self.also(0, 49_000, FaultEvent::Slow { from: first, to: second, by, is_even: true });
        self.also(50_000, 600_000, FaultEvent::Press(first, false));
        let begins = 60_000 + rng.within(0, 30_000);
        for nth in 0..8 {
            self.also(begins + 30_000 * nth, 12_000, FaultEvent::Press(second, true));
        }
    }

    fn two_lives(&mut self, rng: &mut Rng) {
        let Some((first, second)) = self.contended(Provocation::TwoLives, rng) else { return };
        let back = rng.within(20_000, 90_000);
        self.also(
            0,
            300_000,
            FaultEvent::Slow { from: second, to: first, by: Duration::from_micros(back), is_even: true },
        );
        self.also(5_000, 100_000, FaultEvent::Press(first, false));
        // The request has arrived, and the answer has not.
        let ends = 5_000 + rng.within(2_500, back);
        self.also(ends, rng.within(20_000, 60_000), FaultEvent::Kill { node: first, after: 0, remembers: true });
        let known = ends + rng.within(900_000, 1_600_000);
        self.also(ends + 1_000, known - ends - 1_000, FaultEvent::Cut { from: first, to: second, late: false });
        for after in [350_000, 600_000] {
            self.also(ends + after, 1_000, FaultEvent::Command(ModeCommand::Manual));
        }
        // The other one knows of the new life; what it does then is known only later.
        self.also(known, 220_000, FaultEvent::Cut { from: second, to: first, late: false });
        self.also(known + rng.within(1_000, 70_000), 200_000, FaultEvent::Press(second, true));
        self.also(known + rng.within(3_000, 150_000), 300_000, FaultEvent::Press(first, false));
    }

    fn standstill(&mut self, rng: &mut Rng) {
        let moves =
            |at: StationId| self.controller(at.index()).is_none_or(|at| at.marking().any(|place| place.is_operating()));
        let fit = |arrow: &Arrow| {
            let waits = self.does_next(arrow.to) && !moves(arrow.to.0);
            u32::from(arrow.auto) * (1 + u32::from(waits) + u32::from(waits && moves(arrow.from.0)))
        };
        let Some(arrow) = self.arrow(rng, fit) else { return };
        let node = arrow.to.0.index();
        let (cut, stands) = (rng.within(10_000, 500_000), rng.within(700_000, 2_500_000));
        self.also(0, stands, FaultEvent::Stall { node, suspends: false });
        for from in (0..=self.stations.len()).filter(|&from| from != node) {
            self.also(cut, stands - cut + 150_000, FaultEvent::Cut { from, to: node, late: false });
        }
    }

    fn cut_off(&mut self, rng: &mut Rng) {
        // What it is going to wait for is done already, and something else comes before.
        let fit = |arrow: &Arrow| {
            let (from, to) = (self.controller(arrow.from.0.index()), &self.stations[arrow.to.0.index()].shell);
            let (Some(from), Some(to)) = (from, to) else { return 0 };
            let started = to.snapshot().started[arrow.to.1.index()];
            let is_done = from.done(arrow.from.1) + arrow.lag as i32 > started;
            u32::from(arrow.auto) * (1 + u32::from(is_done) + u32::from(is_done && !self.does_next(arrow.to)))
        };
        let Some(arrow) = self.arrow(rng, fit) else { return };
        let (from, to) = (arrow.from.0.index(), arrow.to.0.index());
        self.also(0, rng.within(400_000, 3_000_000), FaultEvent::Cut { from, to, late: false });
    }

    /// One of the two is started without its journal; what each knows of the other is some time old.
    fn no_generation(&mut self, rng: &mut Rng) {
        if self.line.conflicts.is_empty() {
            return;
        }
        let conflict = rng.pick(&self.line.conflicts);
        let mut pair = [conflict.a.station.index(), conflict.b.station.index()];
        if rng.chance(500) {
            pair.reverse();
        }
        let [first, second] = pair;
        self.also(0, 50_000, FaultEvent::Kill { node: first, after: 0, remembers: false });
        for after in [500_000, 800_000, 1_100_000] {
            self.also(after, 1_000, FaultEvent::Command(ModeCommand::Manual));
        }
        for (from, to) in [(first, second), (second, first)] {
            let by = Duration::from_micros(rng.within(5_000, 120_000));
            self.also(1_000_000, 3_000_000, FaultEvent::Slow { from, to, by, is_even: true });
        }
        // One of them is started once more, perhaps while it moves: its outputs outlive it.
        if rng.chance(400) {
            let (after, lasts, remembers) =
                (rng.within(1_250_000, 3_000_000), rng.within(10_000, 150_000), rng.chance(500));
            self.also(after, lasts, FaultEvent::Kill { node: *rng.pick(&pair), after: 0, remembers });
            self.also(after + lasts + 300_000, 1_000, FaultEvent::Command(ModeCommand::Manual));
        }
        for round in 0..5 {
            for node in pair {
                let (after, is_advance) = (1_200_000 + 450_000 * round + rng.within(0, 60_000), rng.chance(700));
                self.also(after, rng.within(50_000, 400_000), FaultEvent::Press(node, is_advance));
            }
        }
    }

    fn off_at_home(&mut self, rng: &mut Rng) {
        let rests = [ControlMode::Home, ControlMode::StandBy];
        if !self.mode().is_some_and(|mode| rests.contains(&mode)) {
            // Halted at home, if it gets there in time.
            self.also(0, 1_000, FaultEvent::Command(ModeCommand::Stop));
            self.also(rng.within(900_000, 2_500_000), 1_000, FaultEvent::Provoked(Provocation::OffAtHome, rng.next()));
            return;
        }
        let id = StationId::at(rng.below(self.stations.len() as u64) as usize);
        let switch = self.line.operation((id, self.line.station(id).home)).normal.complete;
        self.also(0, 1_500_000, FaultEvent::SwitchOff(id, switch));
        let commands = [(700_000, ModeCommand::Start), (710_000, ModeCommand::Auto), (1_400_000, ModeCommand::Auto)];
        for (after, command) in commands {
            self.also(after + rng.within(0, 5_000), 1_000, FaultEvent::Command(command));
        }
    }

    fn stays_on(&mut self, rng: &mut Rng) {
        let id = StationId::at(rng.below(self.stations.len() as u64) as usize);
        let image = self.plant.inputs(Owner::Station(id));
        let of_motions = self.line.station(id).operations.iter().flat_map(|op| {
            let recovery = match &op.module {
                OperationModule::Reversible { recovery, .. } => Some(recovery.complete),
                OperationModule::Irreversible { .. } => None,
            };
            [Some(op.normal.complete), recovery].into_iter().flatten()
        });
        let on: Vec<InputId> = of_motions.filter(|input| image & input.bit() != 0).collect();
        if !on.is_empty() {
            self.also(0, rng.within(1_000_000, 6_000_000), FaultEvent::SwitchOn(id, *rng.pick(&on)));
        }
    }

    fn way_home(&mut self, rng: &mut Rng) {
        let mut all = Vec::new();
        for id in self.line.station_ids() {
            let irreversible =
                |op: &OpId| matches!(self.line.operation((id, *op)).module, OperationModule::Irreversible { .. });
            all.extend(self.line.station(id).op_ids().filter(irreversible).map(|op| (id, op)));
        }
        if all.is_empty() {
            return;
        }
        let (id, op) = *rng.pick(&all);
        let fault = *rng.pick(&[MotionFault::Stick, MotionFault::Break]);
        self.also(0, 3_000_000, FaultEvent::Motion(id, op, true, fault));
        let manual = rng.within(100_000, 2_500_000);
        self.also(manual, 1_000, FaultEvent::Command(ModeCommand::Manual));
        let back = FaultEvent::Press(id.index(), false);
        let pressed = *rng.pick(&[back, back, FaultEvent::Resume]);
        self.also(manual + rng.within(400_000, 900_000), rng.within(200_000, 2_500_000), pressed);
        if rng.chance(500) {
            let other = rng.below(self.stations.len() as u64) as usize;
            let (after, advance) = (rng.within(400_000, 1_500_000), rng.chance(500));
            self.also(manual + after, rng.within(200_000, 1_500_000), FaultEvent::Press(other, advance));
        }
    }
}
