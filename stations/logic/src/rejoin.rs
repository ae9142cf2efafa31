//! Rejoin: the marking of a station whose position is lost or unknown, set where a person confirms that it stands.
//!
//! The person looks; the switches must agree. Nothing moves by it, and the measured positions hold as before.
//!
//! | station | named | stands then |
//! |---|---|---|
//! | with a cycle | – | after the one step whose end the switches fit |
//! | task-driven | – | at the one rest that the switches fit; where they fit none, after the one step |
//! | task-driven | a rest | there, if no switch contradicts |
//! | either | an operation | after it, or within it, whichever the switches fit |
//!
//! **Parameters.** Within a task that has some, their numbers are a part of the confirmation: they are lost with the journal, and the next
//! motion of the task, onwards or back, leads to the place that their outputs choose. With all of them off that is a place as well, at which
//! a hand would open over nothing. So a confirmation there without every number is refused, and nothing is led before it: the switches do not
//! measure which slot was meant, and no number is guessed. A way is always left: a person sees at which slot the hand is, or takes out what
//! it carries and gives any number. A number that a person gave wrongly is confirmed anew, as long as the station stands within the task
//! without an order, until its next start. The numbers of an order, which its journal has, are known, and no person replaces them: by them the
//! coordinator counts where the part is.

use std::sync::Arc;

use linewright_line::net::StationPlace;
use linewright_line::{OpId, Parameter, RestId, TaskId};

use crate::controller::Controller;
use crate::event::{HappeningKind, StopCause};
use crate::ignored::Ignored;
use crate::tasks::NumberMisfit;

/// Position of a station that an operator confirms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RejoinAt {
    /// Where its switches measure it (see [`Controller::read_off`]).
    Measured,
    /// It was stopped in this operation, or this one was done last.
    Within(OpId),
    /// At this rest; for a task-driven station.
    Rest(RestId),
}

impl From<Option<OpId>> for RejoinAt {
    fn from(within: Option<OpId>) -> Self {
        within.map_or(RejoinAt::Measured, RejoinAt::Within)
    }
}

/// Position that a confirmation has come to.
#[derive(Clone, Copy)]
enum Confirmed {
    After(usize),
    Within(OpId),
    /// At a rest: the operation that stands for it.
    At(OpId),
}

impl Controller {
    /// Puts the marking where the switches measure the station, on an operator's confirmation; between two switches, into
    /// the operation that the operator names. For a station that goes round a cycle and has no generation, or whose axes are
    /// not where its chart has them. It has no generation from then on: its counts are compared again once it has been at
    /// home with the others. A task-driven station ends its order.
    ///
    /// # Errors
    /// Where the switches contradict or leave a doubt, numbers are not those of its task, or anything moves; nothing has changed.
    pub(crate) fn rejoin(&mut self, at: RejoinAt, numbers: &[(Arc<str>, i32)]) -> Result<(), Ignored> {
        if self.homing.is_driven || self.tokens().iter().any(|token| self.place(token).is_operating()) {
            return Err(Ignored::Moving);
        }
        if self.commands.is_single() {
            return Err(Ignored::InSingleManual);
        }
        if !self.is_to_be_confirmed() {
            return self.correct_numbers(at, numbers);
        }
        let confirmed = self.confirmed(at)?;
        let parameters = self.parameters_confirmed(self.task_within(confirmed), numbers)?;
        if self.program.tasks.is_some() {
            self.stand_in_tasks(confirmed);
        } else {
            self.stand_in_cycle(confirmed);
        }
        self.confirm_parameters(parameters);
        self.views.generation = 0;
        self.marking.path = None;
        self.marking.doubtful = None;
        self.marking.stuck = None;
        // Where it stands now is what the person has confirmed. A drive that is not homed does not say where that is, and its
        // homing turns the axis: the place where it ends is compared with the one that is known.
        if self.unreferenced() == 0 {
            self.marking.axis_place = 0;
        }
        self.refresh_path();
        self.agreement.pending = None;
        (self.marking.unconfirmed, self.marking.placed) = (false, true);
        self.due.report = true;
        self.due.outputs = true;
        self.note(HappeningKind::Rejoined);
        Ok(())
    }

    /// The position is known: the numbers alone are other ones, of the task within which it stands.
    fn correct_numbers(&mut self, at: RejoinAt, numbers: &[(Arc<str>, i32)]) -> Result<(), Ignored> {
        let place = self.marking().next().filter(|_| !numbers.is_empty() && self.rest().is_none() && !self.has_order());
        let is_there = |place: &StationPlace| at == RejoinAt::Measured || at == RejoinAt::Within(place.op);
        let place = place.filter(is_there).ok_or(Ignored::NotLost)?;
        if !self.has_confirmed_parameters() {
            return Err(Ignored::NumbersKnown);
        }
        let parameters = self.parameters_confirmed(self.task_of(place.op), numbers)?;
        self.confirm_parameters(parameters);
        self.due.report = true;
        self.due.outputs = true;
        self.note(HappeningKind::Rejoined);
        Ok(())
    }

    /// The parameters of the task within which a station stands that a person has confirmed there, with their outputs.
    fn parameters_confirmed(
        &self,
        within: Option<TaskId>,
        numbers: &[(Arc<str>, i32)],
    ) -> Result<Option<(TaskId, u128)>, Ignored> {
        let tables = within.zip(self.program.tasks.as_ref()).map(|(task, tasks)| (task, tasks.task(task)));
        let Some((task, table)) = tables.filter(|(_, table)| !table.parameters.is_empty()) else {
            return if numbers.is_empty() { Ok(None) } else { Err(Ignored::NoSuchNumber) };
        };
        match self.known_parameters(task) {
            Some(kept) if numbers.is_empty() => return Ok(Some(kept)),
            Some(_) if !self.has_confirmed_parameters() => return Err(Ignored::NumbersKnown),
            Some(_) | None => {}
        }
        let image = table.image(numbers).map_err(|misfit| match misfit {
            NumberMisfit::Missing => Ignored::NumberMissing,
            NumberMisfit::NoParameter => Ignored::NoSuchNumber,
            NumberMisfit::OutOfRange => Ignored::NumberOutOfRange,
        })?;
        Ok(Some((task, image)))
    }

    /// The task within which a station stands that is confirmed so; none at a rest, and in a cycle.
    fn task_within(&self, confirmed: Confirmed) -> Option<TaskId> {
        let tasks = self.program.tasks.as_ref()?;
        let (op, is_done) = match confirmed {
            Confirmed::After(step) => (self.ops_of_step(step).next()?, true),
            Confirmed::Within(op) => (op, false),
            Confirmed::At(op) => (op, true),
        };
        let task = tasks.task_of[op.index()];
        (!is_done || tasks.task(task).last != op).then_some(task)
    }

    /// The parameters whose numbers are a part of a confirmation there: those of the task within which it stands then, unless they are known.
    pub fn numbers_to_confirm(&self, at: RejoinAt) -> &[Parameter] {
        let within = self.confirmed(at).ok().and_then(|confirmed| self.task_within(confirmed));
        let unknown = within.filter(|&task| self.known_parameters(task).is_none());
        let task = unknown.zip(self.program.tasks.as_ref()).map(|(task, tasks)| tasks.task(task));
        task.map_or(&[], |task| &task.parameters)
    }

    /// Whether this place is not to be taken back from. Switched on away from home the station is led home by its last operation; back from
    /// there leads through a task of which neither the place nor the parameters are known, until both are confirmed. So it stays whatever has
    /// stopped it since, and after another start.
    pub(crate) fn is_not_taken_back(&self, place: StationPlace) -> bool {
        let task = self.task_of(place.op).filter(|&task| self.known_parameters(task).is_none());
        let table = task.zip(self.program.tasks.as_ref()).map(|(task, tasks)| tasks.task(task));
        table.is_some_and(|table| !table.parameters.is_empty()) && !self.marking.placed
    }

    /// Whether its position is lost or unknown.
    pub(crate) fn is_to_be_confirmed(&self) -> bool {
        let is_unknown = match self.program.tasks {
            None => self.views.generation == 0,
            Some(_) => {
                self.is_not_at_home() || (self.rest().is_none() && self.marking().any(|at| self.is_not_taken_back(at)))
            }
        };
        is_unknown || self.position_lost().is_some()
    }

    /// Switched on away from home without a journal, and not led there since.
    pub(crate) fn is_not_at_home(&self) -> bool {
        let not_home = |place: StationPlace| self.marking.causes_of_stop[place.op.index()] == StopCause::NotAtHome;
        self.marking().any(|place| place.is_incomplete() && not_home(place))
    }

    fn confirmed(&self, at: RejoinAt) -> Result<Confirmed, Ignored> {
        let known = |op: OpId| op.index() < self.counts.done.len();
        let after = |step: Option<usize>| step.map(Confirmed::After).ok_or(Ignored::PositionUnclear);
        match at {
            RejoinAt::Measured if self.program.tasks.is_some() => {
                let mut rests = self.rests_read_off();
                match (rests.next(), rests.next()) {
                    (Some((_, op)), None) => Ok(Confirmed::At(op)),
                    (None, _) => after(self.read_off()),
                    (Some(_), Some(_)) => Err(Ignored::PositionUnclear),
                }
            }
            RejoinAt::Measured => after(self.read_off()),
            RejoinAt::Within(op) if !known(op) => after(self.read_off()),
            RejoinAt::Within(op) => {
                let step = usize::from(self.program.step_of[op.index()]);
                if self.stands_after(step) {
                    Ok(Confirmed::After(step))
                } else if self.stands_within(op) {
                    Ok(Confirmed::Within(op))
                } else {
                    Err(Ignored::PositionUnclear)
                }
            }
            RejoinAt::Rest(rest) => {
                let op = self.program.rest_arrivals.get(rest.index()).copied().flatten();
                let op = op.filter(|&op| self.may_rest_at(op));
                op.map(Confirmed::At).ok_or(Ignored::PositionUnclear)
            }
        }
    }

    /// Whether its switches fit a place of the chart.
    pub(crate) fn is_read_off(&self) -> bool {
        self.steps_read_off().next().is_some()
    }

    /// The rests whose switches are on, and no other; each with the operation that stands for it.
    pub(crate) fn rests_read_off(&self) -> impl Iterator<Item = (RestId, OpId)> + '_ {
        let arrivals = self.program.rest_arrivals.iter().enumerate();
        let rests = arrivals.filter_map(|(rest, op)| Some((RestId::at(rest), (*op)?)));
        rests.filter(|&(_, op)| self.stands_after(usize::from(self.program.step_of[op.index()])))
    }

    /// Whether no switch contradicts a rest that a person names. Where a place has no switch, or several, those of the other
    /// axes are looked at alone.
    fn may_rest_at(&self, arrival: OpId) -> bool {
        let step = usize::from(self.program.step_of[arrival.index()]);
        if self.program.measured_after[step].is_some() {
            return self.stands_after(step);
        }
        self.image.valid && self.program.off_at_rest(StationPlace::completed(arrival), self.image.bits) == 0
    }

    fn stand_in_cycle(&mut self, confirmed: Confirmed) {
        let home = usize::from(self.program.step_of[self.program.home.index()]);
        match confirmed {
            Confirmed::After(step) if step == home => self.count_from_home(),
            Confirmed::After(step) => {
                let places: Vec<StationPlace> = self.ops_of_step(step).map(StationPlace::completed).collect();
                self.stand_at(&places);
                self.count_as_done(step);
                self.counts.started.clone_from(&self.counts.done);
            }
            Confirmed::Within(op) => {
                self.stop_within(op);
                self.count_as_done(usize::from(self.program.step_of[op.index()]));
                self.counts.started.clone_from(&self.counts.done);
                self.counts.done[op.index()] -= 1;
            }
            // A station with a cycle has no rests.
            Confirmed::At(_) => {}
        }
    }

    fn stand_in_tasks(&mut self, confirmed: Confirmed) {
        self.order_in_mode(linewright_line::net::ControlMode::Manual);
        if self.is_not_at_home() {
            let home = self.program.home.index();
            self.counts.done[home] = self.counts.started[home];
        }
        self.counts.started.clone_from(&self.counts.done);
        let Some(tasks) = self.program.tasks.as_ref() else { return };
        let task_of = |op: OpId| tasks.task(tasks.task_of[op.index()]);
        match confirmed {
            Confirmed::At(op) => self.stand_at(&[StationPlace::completed(op)]),
            Confirmed::After(step) => {
                let Some(op) = self.ops_of_step(step).next() else { return };
                let done = task_of(op).first.0..=op.0;
                self.stand_at(&[StationPlace::completed(op)]);
                self.count_in_task(done);
            }
            Confirmed::Within(op) => {
                let first = task_of(op).first.0;
                self.stop_within(op);
                self.count_in_task(first..=op.0);
                self.counts.done[op.index()] -= 1;
            }
        }
    }

    fn stop_within(&mut self, op: OpId) {
        self.stand_at(&[StationPlace::incomplete(op)]);
        self.marking.causes_of_stop[op.index()] = StopCause::Restart;
    }

    /// The task was begun once more, and these of its operations were done.
    fn count_in_task(&mut self, ops: std::ops::RangeInclusive<u16>) {
        self.counts.cycle += 1;
        for op in ops {
            self.counts.done[usize::from(op)] += 1;
            self.counts.started[usize::from(op)] += 1;
        }
    }

    /// The first cycle, as far as this step.
    fn count_as_done(&mut self, step: usize) {
        self.counts.cycle = 1;
        for (done, &at) in self.counts.done.iter_mut().zip(&self.program.step_of) {
            *done = i32::from(usize::from(at) <= step);
        }
    }
}
