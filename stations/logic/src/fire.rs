//! Effect of firing a transition: the token, the counts, the cycle.
//!
//! This is the whole of the bookkeeping (compare seed 002 §5.3, which keeps one Boolean per operation):
//!
//! | transition | done | started | cycle |
//! |---|---|---|---|
//! | t11, t9 into an operation | | := cycle | + 1 first, if it is the first one listed |
//! | t3 complete | := started | | |
//! | t4, t12, onto a recovery path | − 1, before the motion | | |
//! | onto a recovery path, for what it skips | | := its cycle | |
//! | t8 undone | | := done | − 1, if it is the first one listed |
//! | t3 of home, on a recovery path | of the previous round's end | := done | of the previous round's end |
//!
//! Undoing the first operation listed thus leads back into the cycle before, and doing it again into the same cycle
//! as the first time: reset and undo agree across the cycle boundary.
//!
//! A task-driven station has no cycle that others could build on. There `cycle` counts the tasks that were begun,
//! `done` how often an operation was done and not taken back, and `started` is one more while it is under way. A
//! recovery path takes back what the task has done before, and the end of the path is that of the task not done.

use std::sync::Arc;
use std::time::Duration;

use linewright_line::net::{Block, ControlMode, MotionStage, StationPlace, TransitionKind};
use linewright_line::{InputId, OpId, Tick};

use crate::controller::{Controller, NO_DELAY};
use crate::event::{HappeningKind, StopCause};
use crate::parts::{IndexProgress, RunCommand, StuckSwitch, Token};
use crate::program::path_index;

impl Controller {
    /// Fires a transition whose places are marked and whose condition holds.
    pub(crate) fn fire(&mut self, transition: u16) {
        self.fired.push(transition);
        let kind = self.program.actions[transition as usize].kind;
        match kind {
            TransitionKind::Stop(op, block) => {
                let index = self.token_of(op);
                let cause = self.cause_of_stop(index);
                debug_assert_eq!(self.place(&self.marking.tokens[index]).block, block);
                self.stop(index, cause);
            }
            TransitionKind::Resume(op, block) => {
                // It may have coasted to its end; but a switch that has been on all the time proves nothing now either, unless
                // that was reported as its fault: the person who goes on has looked at it. Then it counts where the switch of
                // the other end is off (see `put`).
                let stopped = &self.marking.tokens[self.token_of(op)];
                let cause = self.marking.causes_of_stop[op.index()];
                let is_reported = matches!(cause, StopCause::SwitchStuck | StopCause::BothSwitchesOn { .. });
                let counts = stopped.left_start || stopped.awaits_image || is_reported;
                if is_reported {
                    self.trust_other_end(StationPlace { op, block, stage: MotionStage::Operating });
                }
                self.note_resumed(op);
                self.go(op, StationPlace { op, block, stage: MotionStage::Operating }, counts)
            }
            TransitionKind::Retract(op) => self.go(op, StationPlace::undoing(op), true),
            TransitionKind::Again(op) => self.go(op, StationPlace::operating(op), true),
            TransitionKind::Complete(op, Block::Normal) => self.completed(op),
            TransitionKind::Complete(op, Block::Recovery) => self.undone(op),
            TransitionKind::Undo(op) => {
                self.withdraw_first(1 << op.0);
                self.go(op, StationPlace::undoing(op), false);
            }
            TransitionKind::Restart(op) => {
                self.begin_cycle_with(op);
                self.counts.started[op.index()] = self.count_of_start(op);
                self.go(op, StationPlace::operating(op), false);
            }
            TransitionKind::Next { to, .. } => {
                self.counts.cycle = self.cycle_of_start(to as u8);
                self.order_begins(to as u8);
                self.spread(transition, |controller, op| {
                    controller.counts.started[op.index()] = controller.count_of_start(op);
                });
            }
            TransitionKind::GiveUp(_) => {
                // The same position by another name, and nothing is counted by it.
                self.marking.tokens[0].place = self.program.actions[transition as usize].to[0];
            }
            TransitionKind::Back { .. } => {
                self.withdraw_first(self.taken_back(kind));
                self.spread(transition, |_, _| {});
            }
            TransitionKind::EnterPath(failed) => {
                self.withdraw_first(self.taken_back(kind));
                self.marking.path = Some(failed);
                self.claim_way_home(failed);
                self.spread(transition, |_, _| {});
                self.refresh_path();
            }
            TransitionKind::FollowPath { .. } => self.spread(transition, |_, _| {}),
        }
    }

    /// The switch of a motion that goes on was reported to be stuck, and still is on: the one at the other end is believed.
    fn trust_other_end(&mut self, place: StationPlace) {
        let table = &self.program.places[usize::from(self.program.index_of(place))];
        if table.turns != 0 || table.complete & self.image.bits == 0 {
            return;
        }
        let input = |bits: u128| InputId(bits.trailing_zeros() as u16);
        let behind = (table.behind != 0).then(|| input(table.behind));
        self.marking.stuck = Some(StuckSwitch { op: place.op, input: input(table.complete), behind });
    }

    /// A switch that is seen off does not stick.
    pub(crate) fn follow_stuck(&mut self) {
        let is_off = |stuck: &StuckSwitch| self.image.bits & stuck.input.bit() == 0;
        if self.image.valid && self.marking.stuck.as_ref().is_some_and(is_off) {
            self.marking.stuck = None;
            self.due.report = true;
        }
    }

    fn token_of(&self, op: OpId) -> usize {
        let of_op = |t: &Token| self.place(t).op == op;
        self.tokens().iter().position(of_op).expect("a transition fires only from a marked place")
    }

    /// Puts the token of `op` into an operating place. `from_between` is true when the motion need not have started at its
    /// other end: its completion signal then counts as it stands, unless the switch of the other end is on.
    fn go(&mut self, op: OpId, place: StationPlace, from_between: bool) {
        let index = self.token_of(op);
        self.put(index, place, from_between);
    }

    fn put(&mut self, index: usize, place: StationPlace, from_between: bool) {
        let table = self.program.index_of(place);
        let run = match self.commands.mode() {
            ControlMode::Hand => RunCommand::Hand,
            ControlMode::Manual => RunCommand::Manual,
            ControlMode::Home | ControlMode::StandBy | ControlMode::Auto | ControlMode::EStop => RunCommand::Auto,
        };
        // This axis has not been driven towards this switch since an image that was taken under the outputs still in force
        // (a neighbour's has another axis, and the operation before has just arrived elsewhere by this image): if it shows
        // the switch off, the motion starts with it off, and need not be seen under way. Of a short motion on a slow
        // network no image may arrive but the one from its end.
        let just_seen = self.image.under != NO_DELAY && self.image.under >= self.output.number;
        let off = just_seen && self.image.bits & self.program.places[table as usize].complete == 0;
        let counts = from_between && self.switch_behind(table).is_none();
        // An index that goes on is the one that was stopped.
        let stopped = self.marking.tokens[index];
        let goes_on = self.program.places[usize::from(stopped.place)].turns != 0;
        let (progress, turned) =
            if goes_on { (stopped.progress, stopped.turned) } else { (IndexProgress::AtStart, Duration::ZERO) };
        self.marking.tokens[index] = Token {
            place: table,
            run,
            left_start: if self.image.under == NO_DELAY { counts } else { off && !from_between },
            awaits_image: from_between && self.image.under != NO_DELAY,
            driven_since: 0,
            driven: false,
            deadline: Tick::NEVER,
            remaining: self.program.places[table as usize].watchdog,
            progress,
            turned,
            last_driven: if goes_on { stopped.last_driven } else { Tick::ZERO },
        };
        self.note(HappeningKind::Started(place.op, place.block));
    }

    /// A fork, a join or a plain hop: tokens leave all places of one step and enter all of another.
    fn spread(&mut self, transition: u16, mut started: impl FnMut(&mut Self, OpId)) {
        let count = self.program.actions[transition as usize].to.len();
        for index in 0..count {
            let place = self.program.places[self.program.actions[transition as usize].to[index] as usize].place;
            started(self, place.op);
            // Motions on a recovery path start wherever the fault left the mechanism.
            self.put(index, place, self.marking.path.is_some());
        }
        self.marking.count = count;
    }

    fn begin_cycle_with(&mut self, op: OpId) {
        if self.program.tasks.is_none() && op == self.program.first {
            self.counts.cycle += 1;
        }
    }

    /// Count of an operation that starts now, when it is done.
    fn count_of_start(&self, op: OpId) -> i32 {
        if self.program.tasks.is_some() { self.counts.done[op.index()] + 1 } else { self.counts.cycle }
    }

    /// At a task-driven station: operations done of a task when one of its operations is stopped.
    pub(crate) fn done_in_task_before(&self, failed: OpId) -> u64 {
        self.program.tasks.as_ref().map_or(0, |tasks| {
            let first = tasks.task(tasks.task_of[failed.index()]).first;
            (first.0..failed.0).fold(0, |bits, op| bits | 1 << op)
        })
    }

    fn arrive(&mut self, index: usize, place: StationPlace) {
        let token = &mut self.marking.tokens[index];
        token.place = self.program.index_of(place);
        token.driven = false;
        token.deadline = Tick::NEVER;
        token.remaining = Duration::ZERO;
    }

    fn completed(&mut self, op: OpId) {
        let index = self.token_of(op);
        self.arrive(index, StationPlace::completed(op));
        self.index_completes(index);
        // Its switch has come on. Other axes are measured by the places' own switches.
        self.marking.placed |= op == self.program.home;
        match self.marking.path.take() {
            Some(failed) => self.home_again(failed),
            None => {
                self.counts.done[op.index()] = self.counts.started[op.index()];
                self.refresh_stop();
                self.note(HappeningKind::Completed(op, Block::Normal));
                self.order_completes(op);
            }
        }
    }

    /// Home by a recovery path: this is the end of the previous round, and the cycle will be done again.
    fn home_again(&mut self, failed: OpId) {
        self.refresh_path();
        if self.program.tasks.is_some() {
            self.counts.started.copy_from_slice(&self.counts.done);
            self.note(HappeningKind::HomeAgain);
            return;
        }
        let home = self.program.home.index();
        if self.rules.redo_round {
            if !self.rules.withdraw_first {
                self.withdraw(self.taken_back(TransitionKind::EnterPath(failed)));
            }
            let round = self.counts.done[home];
            for (op, home) in self.counts.at_home.iter().enumerate() {
                self.counts.started[op] = home + round;
            }
            self.counts.cycle = round;
        } else {
            self.counts.started[home] = self.counts.cycle;
            self.counts.done[home] = self.counts.cycle;
        }
        self.note(HappeningKind::HomeAgain);
    }

    fn undone(&mut self, op: OpId) {
        let index = self.token_of(op);
        self.arrive(index, StationPlace::undone(op));
        let late = if self.marking.path.is_none() { !self.rules.withdraw_first } else { !self.rules.redo_round };
        if late && self.counts.done[op.index()] == self.counts.started[op.index()] {
            self.withdraw(1 << op.0);
        }
        if self.marking.path.is_none() {
            self.counts.started[op.index()] = self.counts.done[op.index()];
            if self.program.tasks.is_none() && op == self.program.first {
                self.counts.cycle -= 1;
            }
        }
        self.note(HappeningKind::Completed(op, Block::Recovery));
    }

    /// Operations that the path skips count as started until the station is home, so that no station takes back what
    /// they wait for.
    fn claim_way_home(&mut self, failed: OpId) {
        // No counts are compared with those of a task-driven station.
        if !self.rules.home_waits || !self.rules.redo_round || self.program.tasks.is_some() {
            return;
        }
        let program = Arc::clone(&self.program);
        for &(step, ahead) in &program.ways_home[path_index(&program.paths, failed)] {
            for (op, _) in program.step_of.iter().enumerate().filter(|&(_, &s)| s == step) {
                self.counts.started[op] = self.counts.cycle + ahead;
            }
        }
    }

    /// Takes counts back before the motion, as the rule has it.
    fn withdraw_first(&mut self, ops: u64) {
        if self.rules.withdraw_first {
            self.withdraw(ops);
        }
    }

    fn withdraw(&mut self, ops: u64) {
        for (op, done) in self.counts.done.iter_mut().enumerate() {
            if ops & (1 << op) != 0 {
                *done -= 1;
            }
        }
        self.refresh_stop();
        self.note(HappeningKind::Withdrawn(ops));
    }

    pub(crate) fn stop(&mut self, index: usize, cause: StopCause) {
        let place = self.place(&self.marking.tokens[index]).stopped();
        self.index_stops(index);
        self.arrive(index, place);
        self.marking.causes_of_stop[place.op.index()] = cause;
        self.note(HappeningKind::Stopped(place.op, place.block, cause));
        self.order_stops(cause);
    }

    fn cause_of_stop(&self, index: usize) -> StopCause {
        let token = &self.marking.tokens[index];
        let table = &self.program.places[token.place as usize];
        if self.commands.mode() == ControlMode::EStop {
            StopCause::EStop
        } else if !self.image.valid {
            StopCause::Devices
        } else if self.image.bits & table.fault != 0 {
            StopCause::Signal
        } else if let Some((op, input)) = self.doubtful_index() {
            StopCause::IndexDoubtful { op, input, places: self.places_apart() }
        } else if let Some(cause) = self.unsafe_motion(index) {
            cause
        } else if self.is_late(token) {
            let has_left = if table.turns == 0 { token.left_start } else { token.progress != IndexProgress::AtStart };
            let is_on = self.image.bits & table.complete != 0;
            match self.switch_behind(token.place) {
                Some(behind) if is_on || !has_left => StopCause::BothSwitchesOn { behind },
                Some(_) | None if has_left => StopCause::Watchdog,
                Some(_) | None => StopCause::SwitchStuck,
            }
        } else {
            StopCause::Released
        }
    }
}
