//! The step: plays the station's net one image further.
//!
//! Every token is judged on the state before the pass; at most one transition of a token fires for an edge. A
//! transition that takes counts back is handed to [`crate::withdraw`] instead of being fired.

use linewright_line::net::{ControlMode, MotionStage, TransitionKind};
use linewright_line::{BRANCHES_MAX, InputId, Tick};

use crate::controller::{Controller, NO_DELAY, StationOutbox};
use crate::event::{HappeningKind, StopCause};
use crate::parts::{IndexProgress, PASSES_MAX, PendingAgreement, RunCommand, Token};
use crate::program::{Causal, ConditionRow, bit};
use crate::withdraw::AgreementState;

impl Controller {
    /// Plays the net one image further. Call it after every [`Controller::handle`] and at every deadline.
    ///
    /// Each rising edge since the last step fires at most one transition of a token; what follows without a command
    /// (a completed operation leading on in auto) follows in the same step. Allocates nothing.
    #[inline]
    pub fn step(&mut self, now: Tick, out: &mut StationOutbox) {
        self.now = self.now.max(now);
        if self.now >= self.due.deadline {
            self.refresh();
        } else if self.due.settled {
            debug_assert!(!self.due.report && self.events.is_empty(), "whatever says something new unsettles");
            out.outputs = self.output.bits;
            out.changed = false;
            return;
        }
        self.play(out);
    }

    /// Time of the last step or input.
    pub fn stepped(&self) -> Tick {
        self.now
    }

    /// Boot id of the coordinator whose order it took last; 0 for none.
    pub fn followed(&self) -> u64 {
        self.commands.followed()
    }

    fn play(&mut self, out: &mut StationOutbox) {
        self.look();
        out.outputs = self.output.bits;
        out.number = self.output.number;
        out.changed = std::mem::take(&mut self.due.report);
        if !self.events.is_empty() {
            out.events.append(&mut self.events);
        }
        if let Some(orders) = self.orders.as_mut().filter(|orders| !orders.replies.is_empty()) {
            out.replies.append(&mut orders.replies);
        }
    }

    /// Notes that a position is lost, or measured again.
    fn follow_position(&mut self) {
        let lost = self.position_lost();
        // An axis that is on its way is missed nowhere; whether it is where it should be shows when it has come to rest, in an
        // image that is valid.
        let moves = self.tokens().iter().any(|token| self.place(token).is_operating());
        if lost != self.marking.lost_position && (lost.is_some() || (!moves && self.image.valid)) {
            self.marking.lost_position = lost;
            self.due.report = true;
            self.note(match lost {
                None => HappeningKind::PositionFound,
                Some((op, input)) if self.doubtful_index().is_some() => {
                    HappeningKind::IndexDoubtful(op, input, self.places_apart())
                }
                Some((op, input)) => HappeningKind::PositionLost(op, input),
            });
        }
    }

    fn look(&mut self) {
        self.due.settled = true;
        self.follow_stuck();
        self.fired.clear();
        let edges = bit::edges(self.levels.now & !self.levels.before);
        self.levels.before = self.levels.now;
        let unanswered = !self.views.unanswered().is_empty();
        if unanswered {
            self.answer_entries();
        }
        let mut fired = self.agreement.pending.is_some() && self.settle();
        fired |= self.pass(self.levels.now | edges);
        let is_free = !fired && self.agreement.pending.is_none();
        self.follow_homing(if is_free { edges } else { 0 });
        if edges != 0 && is_free && !self.homing.is_driven {
            self.refuse(edges);
        }
        let mut ended = true;
        if fired {
            ended = (1..PASSES_MAX).any(|_| !self.pass(self.levels.now));
            self.due.report = true;
            self.agreement.refusal = None;
        }
        self.watch_result();
        self.follow_given_up();
        self.follow_position();
        if fired || self.due.outputs {
            self.drive();
        }
        // What an edge has held back, or a request, or a chain cut short, is looked at again.
        self.due.settled &= edges == 0 && self.agreement.pending.is_none() && !unanswered && ended;
        if !ended {
            self.due.deadline = Tick::ZERO;
        }
    }

    /// Computes what depends on time or on input: mode, levels, the outputs' holders, deadlines.
    fn refresh(&mut self) {
        if self.image.valid && self.now >= self.image.until {
            self.take_image(0, false);
        }
        let levels = self.commands.refresh(self.now);
        let path = self.marking.path.map_or(0, |op| bit::ANY_PATH | crate::program::path_bit(&self.program.paths, op));
        self.watch_order();
        let levels = levels | path | self.stop_bit() | self.order_bits();
        self.due.outputs |= levels != self.levels.now;
        self.follow_resume(levels);
        self.levels.now = levels;
        let mode = self.commands.mode();
        if mode != self.levels.mode {
            self.levels.mode = mode;
            // No edge reaches over a change of mode.
            self.levels.before = levels;
            self.enter_mode(mode);
        }
        self.due.outputs = true;
    }

    fn enter_mode(&mut self, mode: ControlMode) {
        self.note(HappeningKind::Mode(mode));
        self.agreement.refusal = None;
        self.order_in_mode(mode);
        self.due.report = true;
        for token in &mut self.marking.tokens[..self.marking.count] {
            // Auto takes over what a hand-mode button has started, for the operator has commanded it; hand mode takes
            // over what auto has left running, and drives it when its button is held.
            match (mode, token.run) {
                (ControlMode::Auto, RunCommand::Hand) => token.run = RunCommand::Auto,
                (ControlMode::Hand, RunCommand::Auto) => token.run = RunCommand::Hand,
                _ => {}
            }
        }
    }

    /// Follows up an open request.
    fn settle(&mut self) -> bool {
        let Some(pending) = self.agreement.pending.take() else { return false };
        // The token may have moved on a command given meanwhile. The request then has no meaning any more, and must
        // not come back to one: an agreement is to a count that was, not to the next one in the same place.
        if !self.are_enabled(&pending) {
            self.due.report = true;
            if self.are_marked(&pending) {
                self.note(HappeningKind::Refused);
            }
            return false;
        }
        match self.standing(&pending, self.levels.now, self.commands.mode()) {
            AgreementState::Waiting => {
                self.agreement.pending = Some(pending);
                false
            }
            AgreementState::Agreed => {
                for row in pending.rows() {
                    self.fire(self.program.rows[usize::from(*row)].transition);
                }
                true
            }
            AgreementState::GivenUp => {
                self.due.report = true;
                false
            }
            AgreementState::NotAgreed(refusal) => {
                self.reject(&pending, refusal);
                false
            }
        }
    }

    /// Whether the tokens still stand where the command found them, and the arrows it reads still hold: while others
    /// were agreeing to our request, we may have agreed to theirs.
    fn are_enabled(&self, pending: &PendingAgreement) -> bool {
        let is_resumed = pending.hold & bit::RESUME != 0;
        let mut rows = pending.rows().iter().map(|&row| &self.program.rows[usize::from(row)]);
        self.are_marked(pending)
            && rows.all(|row| {
                let resumed = match self.program.actions[usize::from(row.transition)].kind {
                    TransitionKind::Resume(op, _) if is_resumed => self.may_be_resumed(op),
                    _ => true,
                };
                resumed && self.allows(row, pending.mode)
            })
    }

    fn are_marked(&self, pending: &PendingAgreement) -> bool {
        let marked = |place: &u16| self.tokens().iter().any(|t| t.place == *place);
        let rows = pending.rows().iter().map(|&row| &self.program.rows[usize::from(row)]);
        rows.flat_map(|row| &self.program.actions[usize::from(row.transition)].from).all(marked)
    }

    /// Looks at every token once, on the state before the pass, then fires what may fire.
    fn pass(&mut self, word: u128) -> bool {
        let mode = self.commands.mode();
        if self.marking.count == 1 {
            return match self.choose(0, word, mode) {
                Some(row) => self.act(&[row], mode),
                None => false,
            };
        }
        let mut chosen = [0; BRANCHES_MAX];
        let mut count = 0;
        for index in 0..self.marking.count {
            if let Some(row) = self.choose(index, word, mode) {
                chosen[count] = row;
                count += 1;
            }
        }
        self.act(&chosen[..count], mode)
    }

    /// Whether its watchdog has run out.
    pub(crate) fn is_late(&self, token: &Token) -> bool {
        token.driven && self.now >= token.deadline
    }

    /// The row that lets a token move, if there is one.
    #[inline]
    fn choose(&mut self, index: usize, word: u128, mode: ControlMode) -> Option<u16> {
        let token = self.marking.tokens[index];
        let mut word = word;
        self.follow_index(index);
        let table = &self.program.places[token.place as usize];
        if table.complete != 0 {
            word |= self.motion_bits(index);
        }
        if word & bit::RESUME != 0 {
            word |= self.resume_bits(index);
        }
        let table = &self.program.places[token.place as usize];
        let (start, end) = table.rows[mode as usize];
        let rows = &self.program.rows[start as usize..end as usize];
        let mut found: Option<u16> = None;
        for (offset, row) in rows.iter().enumerate() {
            if word & row.need == row.need && word & row.forbid == 0 && self.allows(row, mode) {
                match found {
                    None => found = Some(start + offset as u16),
                    Some(first) if self.program.rows[first as usize].transition != row.transition => {
                        return self.ambiguous(index);
                    }
                    Some(_) => {}
                }
            }
        }
        found
    }

    /// Fault, arrival and loss of hold of an operating token.
    #[inline]
    fn motion_bits(&mut self, index: usize) -> u128 {
        let is_unsafe = self.marking.doubtful.is_some() || self.unsafe_motion(index).is_some();
        let late = self.is_late(&self.marking.tokens[index]);
        let has_left = self.switch_behind(self.marking.tokens[index].place).is_none();
        let token = &mut self.marking.tokens[index];
        let table = &self.program.places[token.place as usize];
        let on = self.image.bits & table.complete != 0;
        // An image from before this motion proves nothing about it, neither that its switch was off nor that it is on.
        let own = self.image.under == NO_DELAY || (token.driven_since != 0 && self.image.under >= token.driven_since);
        if own {
            token.left_start |= !on || (token.awaits_image && token.driven && has_left);
            token.awaits_image &= !token.driven;
        }
        let has_arrived = match table.turns {
            // A switch that comes on while the motion is still measured where it began has not been reached: it flickers, or the
            // ranges of the two overlap, and then the one behind goes off further on.
            0 => on && own && (token.left_start || !self.rules.seen_off) && has_left,
            _ => token.progress == IndexProgress::Arrived && self.marking.doubtful.is_none(),
        };
        let mut bits = if has_arrived { bit::ARRIVED } else { 0 };
        if is_unsafe || !self.image.valid || late || self.image.bits & table.fault != 0 {
            bits |= bit::FAULT;
        }
        if token.run == RunCommand::Manual && self.commands.mode() != ControlMode::Manual {
            bits |= bit::HOLD_LOST;
        }
        bits
    }

    /// The switch of the end that a motion leaves, while it is on. Both ends' switches are on then if the motion's own one is:
    /// one of the two sticks, or their ranges overlap, and neither says that the motion has arrived.
    #[inline]
    pub(crate) fn switch_behind(&self, place: u16) -> Option<InputId> {
        let on = self.program.places[usize::from(place)].behind & self.image.bits;
        (on != 0 && self.rules.positions).then(|| InputId(on.trailing_zeros() as u16))
    }

    #[inline]
    fn allows(&self, row: &ConditionRow, mode: ControlMode) -> bool {
        if row.causal == Causal::Free && row.settled == 0 && !row.join && !row.starts {
            return true;
        }
        let causal = match row.causal {
            Causal::Free => true,
            Causal::Holds(step) => self.image.valid && self.causes_hold(step, mode),
            Causal::WayHome(path) => !self.rules.home_waits || self.way_home_is_free(path, mode),
            Causal::Fails(step) => self.causes_known(step, mode) && !self.causes_hold(step, mode),
        };
        causal
            && self.neighbours_settled(row.settled)
            && (!row.join || self.joined())
            && (!row.starts || self.unsafe_start(&self.program.actions[usize::from(row.transition)], mode).is_none())
    }

    fn causes_hold(&self, step: u8, mode: ControlMode) -> bool {
        let causes = &self.program.causes[step as usize];
        self.missing(step) == 0 && self.views.all_hold(causes, mode, self.cycle_of_start(step), self.now)
    }

    /// Whether the arrows into the steps that a recovery path skips hold, each in the cycle it would be done in.
    fn way_home_is_free(&self, path: u8, mode: ControlMode) -> bool {
        self.program.ways_home[path as usize].iter().all(|&(step, ahead)| {
            let causes = &self.program.causes[step as usize];
            self.views.all_hold(causes, mode, self.counts.cycle + ahead, self.now)
        })
    }

    fn causes_known(&self, step: u8, mode: ControlMode) -> bool {
        self.views.all_known(&self.program.causes[step as usize], mode, self.cycle_of_start(step), self.now)
    }

    /// The inputs that a step waits for and that are off; in auto with the result of the step before it.
    pub(crate) fn missing(&self, step: u8) -> u128 {
        let Some(tasks) = &self.program.tasks else { return 0 };
        let result = tasks.results[usize::from(step)].filter(|_| self.commands.mode() == ControlMode::Auto);
        let result = result.map_or(0, |result| result.input.bit());
        (tasks.waits[usize::from(step)].0 | result) & !self.image.bits
    }

    /// The cycle in which a step would start: the first one listed starts a new one; if task-driven, the first of a task.
    pub(crate) fn cycle_of_start(&self, step: u8) -> i32 {
        let begins = self.program.tasks.as_ref().map_or(step == 0, |tasks| tasks.begins_with(step));
        self.counts.cycle + i32::from(begins)
    }

    fn neighbours_settled(&self, mask: u64) -> bool {
        mask == 0
            || self
                .tokens()
                .iter()
                .map(|t| self.place(t))
                .all(|place| mask & (1 << place.op.0) == 0 || place.stage == MotionStage::Completed)
    }

    fn joined(&self) -> bool {
        let first = self.place(&self.marking.tokens[0]);
        self.tokens().iter().all(|t| {
            let place = self.place(t);
            (place.block, place.stage) == (first.block, first.stage)
        })
    }

    /// Two exclusive transitions are both allowed. The checker proves this cannot happen; if it does, the controller
    /// does not guess: an operating token is stopped, any other stays where it is.
    #[cold]
    fn ambiguous(&mut self, index: usize) -> Option<u16> {
        self.due.settled = false;
        let place = self.place(&self.marking.tokens[index]);
        if place.is_operating() {
            self.stop(index, StopCause::Ambiguous);
            self.due.outputs = true;
            self.due.report = true;
        }
        None
    }

    /// The operations whose counts a transition takes back.
    pub(crate) fn taken_back(&self, kind: TransitionKind) -> u64 {
        match kind {
            TransitionKind::Undo(op) => 1 << op.0,
            TransitionKind::Back { to, .. } => {
                let ops = self.program.step_of.iter().enumerate().filter(|&(_, &step)| usize::from(step) == to);
                ops.fold(0, |bits, (op, _)| bits | 1 << op)
            }
            TransitionKind::EnterPath(_) if !self.rules.redo_round => 0,
            TransitionKind::EnterPath(failed) if self.program.tasks.is_some() => self.done_in_task_before(failed),
            TransitionKind::EnterPath(_) => {
                let round = self.counts.done[self.program.home.index()];
                let counted = |&(op, &done): &(usize, &i32)| done > self.counts.at_home[op] + round;
                self.counts.done.iter().enumerate().filter(counted).fold(0, |bits, (op, _)| bits | 1 << op)
            }
            TransitionKind::Stop(..)
            | TransitionKind::Resume(..)
            | TransitionKind::Complete(..)
            | TransitionKind::Retract(_)
            | TransitionKind::Restart(_)
            | TransitionKind::Again(_)
            | TransitionKind::Next { .. }
            | TransitionKind::GiveUp(_)
            | TransitionKind::FollowPath { .. } => 0,
        }
    }

    /// Reports that a press moved nothing, if it was meant for this station.
    #[cold]
    fn refuse(&mut self, edges: u128) {
        let pressed = bit::levels(edges);
        let mine = pressed & (bit::PANEL | self.program.buttons) != 0;
        if mine && self.commands.mode().enables_motion() {
            self.note(HappeningKind::Refused);
            self.due.report = true;
        }
    }
}
