//! The transitions of a station: inside its operation modules and between them (seed 002 §5.2.1, steps 1 to 4).
//!
//! Numbers in comments are those of Figures 12, 13, 20 and 22. Departures from the figures:
//!
//! 1. A fault stops a motion in every mode, and is looked for as a level. The figures look for its edge, in hand mode
//!    only while the button is held, and not at all in manual mode.
//! 2. Released buttons are conditions on the level, not on the falling edge: an edge can be lost with a message, a
//!    level that stays off cannot.
//! 3. t9 also has an auto condition, so that auto resumes from wherever a recovery ended; p6 of an operation is the
//!    same position as p3 of the one before it, and t9 waits for the same arrows as t11 would.
//! 4. Running motions, recovery motions among them, finish in stand-by and auto, and every motion stops on the
//!    emergency stop.
//! 5. In manual mode a motion completes under the button that drives it. The figures accept either, but the other one
//!    has stopped the motion by then.
//! 6. On a recovery path the return button drives the home operation's normal motion, and nothing turns forward.
//! 7. A recovery path is entered only if the arrows hold into everything it skips, the home operation among it. The
//!    home motion is a normal motion like any other: without its arrows it would run into a neighbour's stretch.

use crate::net::condition::{Conjunction, ControlMode, Literal, Var, off, on};
use crate::net::module::{Block, StationPlace, is_reversible};
use crate::{OpId, OperationModule, Station, TaskId};

/// Effect of a transition on its operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransitionKind {
    /// t1, t6: a motion stops before its end.
    Stop(OpId, Block),
    /// t2, t7: a stopped motion goes on.
    Resume(OpId, Block),
    /// t3, t8: a motion is complete.
    Complete(OpId, Block),
    /// t4: a completed operation starts to be taken back. Withdraws its count.
    Undo(OpId),
    /// t5: a stopped operation starts to be taken back.
    Retract(OpId),
    /// t9: an operation that has been undone starts again.
    Restart(OpId),
    /// t10: a stopped recovery turns forward again.
    Again(OpId),
    /// t11: from one step of the cycle to the next.
    Next {
        /// Index of the completed step.
        from: usize,
        /// Index of the step that starts.
        to: usize,
    },
    /// t12: from an undone step to undoing the one before it. Withdraws the latter's counts.
    Back {
        /// Index of the undone step.
        from: usize,
        /// Index of the step to be undone.
        to: usize,
    },
    /// The first operation of a task has been undone, so the station is at the rest where the task begins: on to the place
    /// that stands for that rest. At task-driven stations only.
    GiveUp(TaskId),
    /// t5 of an I-module: onto its recovery path. Withdraws every count of the round.
    EnterPath(OpId),
    /// From one operation of a recovery path to the next; the last one leads to the home operation's normal motion, at a
    /// task-driven station to that of the task's last operation.
    FollowPath {
        /// The operation whose recovery motion has ended.
        from: OpId,
        /// The operation that moves next.
        to: OpId,
    },
}

/// One transition of a station's net with its conditions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationTransition {
    /// Effect.
    pub kind: TransitionKind,
    /// Places it takes a token from.
    pub from: Vec<StationPlace>,
    /// Places it puts a token into.
    pub to: Vec<StationPlace>,
    /// For each mode of [`ControlMode::ALL`], the terms any one of which lets it fire; none: never in that mode.
    pub conditions: [Vec<Conjunction>; 6],
}

impl StationTransition {
    /// The terms for one mode.
    pub fn terms(&self, mode: ControlMode) -> &[Conjunction] {
        &self.conditions[mode as usize]
    }
}

/// The modes in which running motions finish by themselves.
const UNATTENDED: [ControlMode; 3] = [ControlMode::Home, ControlMode::StandBy, ControlMode::Auto];

pub(super) struct StationNetBuilder<'a> {
    pub station: &'a Station,
    out: Vec<StationTransition>,
}

/// All transitions of a station.
pub(super) fn transitions_of(station: &Station) -> Vec<StationTransition> {
    let mut builder = StationNetBuilder { station, out: Vec::new() };
    // Step 1: an operation module for each operation.
    for op in station.op_ids() {
        builder.normal_block(op);
        if is_reversible(station, op) {
            builder.recovery_block(op);
        }
    }
    // Step 2: the normal cycle. Step 3: the reverse sequences.
    for step in 0..station.steps.len() {
        if station.is_task_driven() {
            builder.next_of_task(step);
            builder.back_in_task(step);
        } else {
            builder.next(step);
            builder.back(step);
        }
    }
    // Step 4: the recovery paths of the irreversible operations.
    for op in station.op_ids() {
        builder.recovery_path(op);
    }
    builder.out
}

impl StationNetBuilder<'_> {
    pub(super) fn add(
        &mut self,
        kind: TransitionKind,
        from: Vec<StationPlace>,
        to: Vec<StationPlace>,
    ) -> &mut StationTransition {
        self.out.push(StationTransition { kind, from, to, conditions: Default::default() });
        self.out.last_mut().expect("just pushed")
    }

    fn following(&self, step: usize) -> usize {
        (step + 1) % self.station.steps.len()
    }

    fn preceding(&self, step: usize) -> usize {
        (step + self.station.steps.len() - 1) % self.station.steps.len()
    }

    fn neighbours(&self, op: OpId) -> Vec<Literal> {
        let step = &self.station.steps[self.station.step_of(op)];
        step.iter().filter(|&&n| n != op).map(|&n| on(Var::NeighbourSettled(n))).collect()
    }

    /// Master stop holds the station at its home place: the condition of that place's output transition.
    fn unless_stopped(&self, from_step: usize) -> Option<Literal> {
        let home = self.station.step_of(self.station.home);
        (from_step == home).then_some(off(Var::MasterStop))
    }

    fn normal_block(&mut self, op: OpId) {
        let hand = self.station.operations[op.index()].hand;
        let (p1, p2, p3) = (StationPlace::operating(op), StationPlace::incomplete(op), StationPlace::completed(op));
        let fault = Var::Fault(op, Block::Normal);
        let arrived = Var::Arrived(op, Block::Normal);

        let t1 = self.add(TransitionKind::Stop(op, Block::Normal), vec![p1], vec![p2]);
        t1.stops_on(fault);
        t1.when(
            ControlMode::Manual,
            [
                vec![off(Var::Advance), off(Var::OnAnyPath)],
                // On a recovery path the home operation's normal motion is held by the return button that led to it.
                vec![off(Var::Advance), off(Var::Retract), on(Var::OnAnyPath)],
            ],
        );

        let t2 = self.add(TransitionKind::Resume(op, Block::Normal), vec![p2], vec![p1]);
        t2.when(
            ControlMode::Manual,
            [vec![on(Var::AdvancePressed)], vec![on(Var::RetractPressed), on(Var::OnAnyPath)]],
        );

        let t3 = self.add(TransitionKind::Complete(op, Block::Normal), vec![p1], vec![p3]);
        t3.completes_on(arrived, fault);
        t3.when(ControlMode::Hand, [vec![on(arrived), off(fault), off(Var::HoldLost), on(Var::Held(hand.forward()))]]);
        t3.when(
            ControlMode::Manual,
            [
                vec![on(arrived), off(fault), on(Var::Advance)],
                vec![on(arrived), off(fault), on(Var::Retract), on(Var::OnAnyPath)],
            ],
        );
    }

    fn recovery_block(&mut self, op: OpId) {
        let hand = self.station.operations[op.index()].hand;
        let step = self.station.step_of(op);
        let next = self.following(step);
        let settled = self.neighbours(op);
        let back_by_itself = self.secured(op);
        let back_by_hand = self.reversed_at_rest(op).unwrap_or_else(|| hand.reverse(next));
        let task_driven = self.station.is_task_driven();
        let held_at_home = self.unless_stopped(self.preceding(step));
        let (p1, p2, p3) = (StationPlace::operating(op), StationPlace::incomplete(op), StationPlace::completed(op));
        let (p4, p5, p6) = (StationPlace::undoing(op), StationPlace::undo_incomplete(op), StationPlace::undone(op));
        let fault = Var::Fault(op, Block::Recovery);
        let arrived = Var::Arrived(op, Block::Recovery);

        // At a rest the panel takes back no task that is done: as one is begun, so it is taken back by choice.
        let back_by_panel = self.station.rest_after(op).is_none().then(|| vec![on(Var::RetractPressed)]);
        if back_by_itself.is_some() || back_by_hand.is_some() || back_by_panel.is_some() {
            let t4 = self.add(TransitionKind::Undo(op), vec![p3], vec![p4]);
            t4.when(ControlMode::Auto, back_by_itself);
            t4.when(ControlMode::Hand, back_by_hand.map(|term| and(term, &settled)));
            t4.when(ControlMode::Manual, back_by_panel.map(|term| and(term, &settled)));
        }

        let t5 = self.add(TransitionKind::Retract(op), vec![p2], vec![p4]);
        t5.when(ControlMode::Manual, [vec![on(Var::RetractPressed), off(Var::OnAnyPath)]]);

        let t6 = self.add(TransitionKind::Stop(op, Block::Recovery), vec![p4], vec![p5]);
        t6.stops_on(fault);
        t6.when(ControlMode::Manual, [vec![off(Var::Retract)]]);

        let t7 = self.add(TransitionKind::Resume(op, Block::Recovery), vec![p5], vec![p4]);
        t7.when(ControlMode::Manual, [vec![on(Var::RetractPressed)]]);

        let t8 = self.add(TransitionKind::Complete(op, Block::Recovery), vec![p4], vec![p6]);
        t8.completes_on(arrived, fault);
        let mut by_hand = vec![on(arrived), off(fault), off(Var::HoldLost)];
        by_hand.extend(hand.back().map(|back| on(Var::Held(back))));
        t8.when(ControlMode::Hand, [by_hand]);
        t8.when(ControlMode::Manual, [vec![on(arrived), off(fault), on(Var::Retract)]]);

        let t9 = self.add(TransitionKind::Restart(op), vec![p6], vec![p1]);
        let may_start = [on(Var::Causal(step)), off(Var::OnAnyPath)];
        let mut by_itself = may_start.to_vec();
        by_itself.extend(held_at_home);
        // At a task-driven station nothing is begun again by itself: the order has failed.
        t9.when(ControlMode::Auto, (!task_driven).then_some(by_itself));
        t9.when(ControlMode::Hand, hand.restart().map(|term| and(and(term, &may_start), &settled)));
        t9.when(ControlMode::Manual, [and(and(vec![on(Var::AdvancePressed)], &may_start), &settled)]);

        // On a recovery path the only way is home: turning forward half-way would leave operations done that have
        // been taken back for the line.
        let t10 = self.add(TransitionKind::Again(op), vec![p5], vec![p1]);
        t10.when(ControlMode::Manual, [vec![on(Var::AdvancePressed), off(Var::OnAnyPath)]]);
    }

    /// t11 (t4 of an I-module): a fork where the next step has several operations, a join where this one has.
    fn next(&mut self, step: usize) {
        let next = self.following(step);
        let ops = &self.station.steps[step];
        let hand = self.station.operations[ops[0].index()].hand;
        let held_at_home = self.unless_stopped(step);
        let from = ops.iter().copied().map(StationPlace::completed).collect();
        let to = self.station.steps[next].iter().copied().map(StationPlace::operating).collect();

        let t11 = self.add(TransitionKind::Next { from: step, to: next }, from, to);
        let mut by_itself = vec![on(Var::Causal(next))];
        by_itself.extend(held_at_home);
        t11.when(ControlMode::Auto, [by_itself]);
        t11.when(ControlMode::Hand, [hand.lead_on(next)]);
        t11.when(ControlMode::Manual, [vec![on(Var::AdvancePressed), on(Var::Causal(next))]]);
    }

    /// t12, where the hand-mode type continues a reverse sequence.
    fn back(&mut self, step: usize) {
        let ops = &self.station.steps[step];
        let Some(back) = self.station.operations[ops[0].index()].hand.reverse_on() else { return };
        let previous = self.preceding(step);
        let from = ops.iter().copied().map(StationPlace::undone).collect();
        let to = self.station.steps[previous].iter().copied().map(StationPlace::undoing).collect();

        let t12 = self.add(TransitionKind::Back { from: step, to: previous }, from, to);
        t12.when(ControlMode::Hand, [vec![on(Var::Held(back)), off(Var::OnAnyPath)]]);
        t12.when(ControlMode::Manual, [vec![on(Var::RetractPressed), off(Var::OnAnyPath)]]);
    }

    fn recovery_path(&mut self, failed: OpId) {
        let OperationModule::Irreversible { recovery_path } = &self.station.operations[failed.index()].module else {
            return;
        };
        let Some(&first) = recovery_path.first() else { return };
        let enter = self.add(
            TransitionKind::EnterPath(failed),
            vec![StationPlace::incomplete(failed)],
            vec![StationPlace::undoing(first)],
        );
        let free = [on(Var::RetractPressed), off(Var::OnAnyPath), on(Var::WayHome(failed))];
        enter.when(ControlMode::Manual, [free.to_vec()]);

        let home = self.station.path_end(failed);
        let hops = recovery_path.windows(2).map(|pair| (pair[0], pair[1], StationPlace::undoing(pair[1])));
        let last = recovery_path.last().map(|&last| (last, home, StationPlace::operating(home)));
        for (from, to, place) in hops.chain(last) {
            let term = vec![on(Var::RetractPressed), on(Var::OnPath(failed))];
            let kind = TransitionKind::FollowPath { from, to };
            // Irreversible operations usually share their way home; a shared hop is one transition.
            match self.out.iter_mut().find(|t| t.kind == kind) {
                Some(shared) => shared.when(ControlMode::Manual, [term]),
                None => self.add(kind, vec![StationPlace::undone(from)], vec![place]).when(ControlMode::Manual, [term]),
            }
        }
    }
}

impl StationTransition {
    pub(super) fn when(&mut self, mode: ControlMode, terms: impl IntoIterator<Item = Conjunction>) {
        self.conditions[mode as usize].extend(terms);
    }

    /// t1 and t6: the conditions that stop a motion whatever else holds.
    fn stops_on(&mut self, fault: Var) {
        for mode in UNATTENDED.into_iter().chain([ControlMode::Hand]) {
            self.when(mode, [vec![on(fault)], vec![on(Var::HoldLost)]]);
        }
        self.when(ControlMode::Manual, [vec![on(fault)]]);
        self.when(ControlMode::EStop, [vec![]]);
    }

    /// t3 and t8: a motion that needs no held button is complete when it has arrived. A fault in the same image wins.
    fn completes_on(&mut self, arrived: Var, fault: Var) {
        for mode in UNATTENDED {
            self.when(mode, [vec![on(arrived), off(fault), off(Var::HoldLost)]]);
        }
    }
}

fn and(mut term: Conjunction, more: &[Literal]) -> Conjunction {
    term.extend_from_slice(more);
    term
}
