//! Generations: which counts may be compared.
//!
//! Counts mean something only among stations that stood at home together when an operator confirmed it. Such a moment founds a
//! *generation*: the coordinator draws a number, every station that stands at home takes it and begins to count anew. From then
//! on a station keeps it with its counts and reports it. Counts of another generation are unknown. A station without its memory
//! has none.
//!
//! A founding order names the life of each station that it is meant for. One that arrives late, at a station that has been
//! restarted since and stands at home by chance, founds nothing.
//!
//! The way back of a station without a generation: where its switches measure where it stands, [`Controller::rejoin`] puts
//! the marking there; manual mode then leads it home under the second barrier; and the next founding takes it in.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, Tick};

use crate::controller::Controller;
use crate::event::HappeningKind;
use crate::parts::{IndexProgress, RunCommand, Token};

impl Token {
    /// It stands in this place, and nothing of its motion has been driven.
    pub fn at(place: u16) -> Self {
        Token {
            place,
            run: RunCommand::Auto,
            left_start: true,
            awaits_image: false,
            driven_since: 0,
            driven: false,
            deadline: Tick::NEVER,
            remaining: std::time::Duration::ZERO,
            progress: IndexProgress::Unseen,
            turned: std::time::Duration::ZERO,
            last_driven: Tick::ZERO,
        }
    }
}

impl Controller {
    /// The generation its counts belong to; 0 for none.
    pub fn generation(&self) -> u64 {
        self.views.generation
    }

    /// Begins to count anew in this generation, if it stands at home and nothing moves.
    pub(crate) fn found(&mut self, generation: u64) {
        let rests =
            !matches!(self.commands.granted(self.now), ControlMode::Auto | ControlMode::Hand | ControlMode::Manual);
        let stands = rests
            && self.image.valid
            && !self.marking.unconfirmed
            && self.agreement.pending.is_none()
            && self.is_at_home()
            && self.position_lost().is_none()
            && self.is_home_measured();
        if generation == 0 || !stands || self.program.tasks.is_some() || generation == self.views.generation {
            return;
        }
        self.count_from_home();
        self.views.generation = generation;
        self.marking.placed = true;
        self.due.report = true;
        self.due.outputs = true;
        self.note(HappeningKind::Founded);
    }

    /// Whether the switch of the home operation is on.
    fn is_home_measured(&self) -> bool {
        let needed = self.home_switch();
        !self.rules.positions || self.image.bits & needed == needed
    }

    /// The completion input of the home operation.
    pub(crate) fn home_switch(&self) -> u128 {
        self.program.places[usize::from(self.program.index_of(StationPlace::operating(self.program.home)))].complete
    }

    pub(crate) fn count_from_home(&mut self) {
        self.stand_at(&[StationPlace::completed(self.program.home)]);
        self.counts.cycle = self.counts.initial_round;
        for (op, home) in self.counts.at_home.iter().enumerate() {
            self.counts.done[op] = home + self.counts.initial_round;
        }
        self.counts.started.clone_from(&self.counts.done);
        self.refresh_stop();
    }

    pub(crate) fn stand_at(&mut self, places: &[StationPlace]) {
        for (index, place) in places.iter().enumerate() {
            self.marking.tokens[index] = Token::at(self.program.index_of(*place));
        }
        self.marking.count = places.len();
    }

    /// Place of the station by its switches: the step whose operations are complete there. None where they fit no place
    /// of the chart, or more than one.
    pub fn read_off(&self) -> Option<usize> {
        let mut steps = self.steps_read_off();
        let step = steps.next()?;
        steps.next().is_none().then_some(step)
    }

    /// All steps at whose end the switches would be as they are.
    pub(crate) fn steps_read_off(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.program.causes.len()).filter(|&step| self.stands_after(step))
    }

    /// Whether every axis is measured where the chart has it after a step, and nowhere else.
    pub(crate) fn stands_after(&self, step: usize) -> bool {
        let expected = self.program.measured_after[step];
        self.image.valid && expected.is_some_and(|expected| self.fits(expected))
    }

    /// Whether these switches are on and no other. One that says nothing is left out, if there are others.
    fn fits(&self, expected: u128) -> bool {
        let silent = self.unreferenced();
        let silent = if expected & !silent == 0 { 0 } else { silent };
        self.image.bits & self.program.switches & !silent == expected & !silent
    }

    /// Whether the station can have been stopped in this operation: all other axes are measured where the chart has them,
    /// and its own one at no switch.
    pub(crate) fn stands_within(&self, op: OpId) -> bool {
        let alone = self.ops_of_step(usize::from(self.program.step_of[op.index()])).count() == 1;
        let expected = self.program.measured_within[op.index()].filter(|_| alone && self.image.valid);
        expected.is_some_and(|expected| self.fits(expected))
    }

    pub(crate) fn ops_of_step(&self, step: usize) -> impl Iterator<Item = OpId> + '_ {
        let of_step = move |&(_, &at): &(usize, &u8)| usize::from(at) == step;
        self.program.step_of.iter().enumerate().filter(of_step).map(|(op, _)| OpId::at(op))
    }
}
