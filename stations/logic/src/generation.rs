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
use crate::event::{HappeningKind, StopCause};
use crate::ignored::Ignored;
use crate::panel::Founding;
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
    pub(crate) fn found(&mut self, founding: Founding) {
        let rests =
            !matches!(self.commands.granted(self.now), ControlMode::Auto | ControlMode::Hand | ControlMode::Manual);
        let stands = rests
            && self.image.valid
            && !self.marking.unconfirmed
            && self.agreement.pending.is_none()
            && self.is_at_home()
            && self.position_lost().is_none()
            && self.is_home_measured();
        let meant = founding.boot_id == self.boot_id && founding.generation != 0;
        if !meant || !stands || self.program.tasks.is_some() || founding.generation == self.views.generation {
            return;
        }
        self.count_from_home();
        self.views.generation = founding.generation;
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

    fn count_from_home(&mut self) {
        self.stand_at(&[StationPlace::completed(self.program.home)]);
        self.counts.cycle = self.counts.initial_round;
        for (op, home) in self.counts.at_home.iter().enumerate() {
            self.counts.done[op] = home + self.counts.initial_round;
        }
        self.counts.started.clone_from(&self.counts.done);
        self.refresh_stop();
    }

    fn stand_at(&mut self, places: &[StationPlace]) {
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
    fn stands_after(&self, step: usize) -> bool {
        let expected = self.program.measured_after[step];
        self.image.valid && expected.is_some_and(|expected| self.image.bits & self.program.switches == expected)
    }

    /// Whether the station can have been stopped in this operation: all other axes are measured where the chart has them,
    /// and its own one at no switch.
    pub(crate) fn stands_within(&self, op: OpId) -> bool {
        let alone = self.ops_of_step(usize::from(self.program.step_of[op.index()])).count() == 1;
        let expected = self.program.measured_within[op.index()].filter(|_| alone && self.image.valid);
        expected.is_some_and(|expected| self.image.bits & self.program.switches == expected)
    }

    pub(crate) fn ops_of_step(&self, step: usize) -> impl Iterator<Item = OpId> + '_ {
        let of_step = move |&(_, &at): &(usize, &u8)| usize::from(at) == step;
        self.program.step_of.iter().enumerate().filter(of_step).map(|(op, _)| OpId::at(op))
    }

    /// Puts the marking where the switches measure the station, on an operator's confirmation; between two switches, into
    /// the operation that the operator names. For a station that goes round a cycle and has no generation, or whose axes are
    /// not where its chart has them. It has no generation from then on: its counts are compared again once it has been at
    /// home with the others.
    ///
    /// # Errors
    /// Where the switches contradict or leave a doubt, or anything moves; nothing has changed.
    pub(crate) fn rejoin(&mut self, within: Option<OpId>) -> Result<(), Ignored> {
        let moves = self.tokens().iter().any(|token| self.place(token).is_operating());
        let is_lost = self.views.generation == 0 || self.position_lost().is_some();
        if self.program.tasks.is_some() {
            return Err(Ignored::NoRejoin);
        }
        if moves {
            return Err(Ignored::Moving);
        }
        if !is_lost {
            return Err(Ignored::NotLost);
        }
        let known = within.filter(|op| op.index() < self.counts.done.len());
        let after = match known {
            None => self.read_off(),
            Some(op) => Some(usize::from(self.program.step_of[op.index()])).filter(|&step| self.stands_after(step)),
        };
        match (after, known) {
            (Some(step), _) if usize::from(self.program.step_of[self.program.home.index()]) == step => {
                self.count_from_home();
            }
            (Some(step), _) => {
                let places: Vec<StationPlace> = self.ops_of_step(step).map(StationPlace::completed).collect();
                self.stand_at(&places);
                self.count_as_done(step);
                self.counts.started.clone_from(&self.counts.done);
            }
            (None, Some(op)) if self.stands_within(op) => {
                self.stand_at(&[StationPlace::incomplete(op)]);
                self.marking.causes_of_stop[op.index()] = StopCause::Restart;
                self.count_as_done(usize::from(self.program.step_of[op.index()]));
                self.counts.started.clone_from(&self.counts.done);
                self.counts.done[op.index()] -= 1;
            }
            (None, _) => return Err(Ignored::PositionUnclear),
        }
        self.views.generation = 0;
        self.marking.path = None;
        self.marking.doubtful = None;
        // Where it stands now is what the person has confirmed.
        self.marking.axis_place = 0;
        self.refresh_path();
        self.agreement.pending = None;
        (self.marking.unconfirmed, self.marking.placed) = (false, true);
        self.due.report = true;
        self.due.outputs = true;
        self.note(HappeningKind::Rejoined);
        Ok(())
    }

    /// The first cycle, as far as this step.
    fn count_as_done(&mut self, step: usize) {
        self.counts.cycle = 1;
        for (done, &at) in self.counts.done.iter_mut().zip(&self.program.step_of) {
            *done = i32::from(usize::from(at) <= step);
        }
    }
}
