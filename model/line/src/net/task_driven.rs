//! The transitions of a task-driven station, where they differ from those of one that goes round a cycle.
//!
//! Its tasks are stretches of the list, and a rest is the place p3 of the last operation of any task that ends there:
//! one physical position, so the net has no place that operations do not have. From a rest t11 leads to the first step of
//! each task that begins there. Five rules make the rest:
//!
//! 1. In auto t11 waits for the order: for its own task's alone.
//! 2. A station that is to go back ([`Var::Secure`]) takes back what is complete, operation by operation, by t4 and t12,
//!    as far as everything is reversible. On a task's last operation it does not: that is a rest, and the task is done.
//! 3. When the first operation of a task has been undone, the station is where the task began. The token goes on to the
//!    place that stands for that rest ([`TransitionKind::GiveUp`]), so that any task can begin there, and the net stays strongly
//!    connected.
//! 4. What a fault has stopped, t2, t5, t7, t10 and recovery paths are for, waits for a person, as everywhere.
//! 5. In manual neither t11 nor t4 leads out of a rest: a task is chosen, by its order or by its button in hand mode. The
//!    panel's one button for advance, held once too often, would begin any; its return would take back one that ended there,
//!    which need not be the one that was done last. A first operation that *return* has just undone is done again by
//!    *advance* (t9), as within a task.
//!
//! t12 is there between any two reversible operations of a task, and the panel's return leads over it: going back needs
//! it, and in manual there is no reason to go back less far. In hand mode it follows the hand type.

use crate::net::condition::{Conjunction, ControlMode, Literal, Var, off, on};
use crate::net::connect::{StationNetBuilder, TransitionKind};
use crate::net::module::{StationPlace, is_reversible};
use crate::{ButtonId, OpId, RestId};

impl StationNetBuilder<'_> {
    /// t4 in auto: operations that the station takes back by itself when it is to go back.
    pub(super) fn secured(&self, op: OpId) -> Option<Conjunction> {
        let station = self.station;
        let within = station.is_task_driven() && station.rest_after(op).is_none();
        within.then(|| vec![on(Var::Secure)])
    }

    /// t4 in hand mode where a task ends: by the operation's own button, unless one is pressed that leads on. Forward
    /// wins, as everywhere. None where no task ends; `Some(None)` where the hand type begins no reverse motion.
    pub(super) fn reversed_at_rest(&self, op: OpId) -> Option<Option<Conjunction>> {
        let rest = self.station.rest_after(op)?;
        let back = self.station.operations[op.index()].hand.reverses_from_its_end();
        Some(back.map(|back| {
            let forward = self.forwards(rest).map(|button| off(Var::Pressed(button)));
            std::iter::once(on(Var::Pressed(back))).chain(forward).collect()
        }))
    }

    /// The buttons that begin the tasks of a rest.
    fn forwards(&self, rest: RestId) -> impl Iterator<Item = ButtonId> + '_ {
        let station = self.station;
        station.tasks_from(rest).map(|task| station.operations[station.first_of(task).index()].hand.forward())
    }

    /// t11: within a task to its next step, at its end to the first step of each task that begins there.
    pub(super) fn next_of_task(&mut self, step: usize) {
        let station = self.station;
        let op = station.steps[step][0];
        let Some(task) = station.task_of(op) else { return };
        let Some(rest) = station.rest_after(op) else {
            let hand = station.operations[op.index()].hand;
            let by_hand = hand.lead_on(step + 1);
            return self.lead(step, step + 1, on(Var::Ordered(task)), by_hand, true);
        };
        let mut earlier: Vec<Literal> = Vec::new();
        for task in station.tasks_from(rest) {
            let (to, first) = (station.task(task).steps.start, station.first_of(task));
            let forward = station.operations[first.index()].hand.forward();
            let mut by_hand = vec![on(Var::Pressed(forward)), on(Var::Causal(to))];
            by_hand.extend(&earlier);
            earlier.push(off(Var::Pressed(forward)));
            self.lead(step, to, on(Var::Ordered(task)), by_hand, false);
        }
    }

    fn lead(&mut self, step: usize, to: usize, ordered: Literal, by_hand: Conjunction, by_panel: bool) {
        let [from, first] = [step, to].map(|step| self.station.steps[step][0]);
        let places = (vec![StationPlace::completed(from)], vec![StationPlace::operating(first)]);
        let t11 = self.add(TransitionKind::Next { from: step, to }, places.0, places.1);
        t11.when(ControlMode::Auto, [vec![ordered, on(Var::Causal(to))]]);
        t11.when(ControlMode::Hand, [by_hand]);
        t11.when(ControlMode::Manual, by_panel.then(|| vec![on(Var::AdvancePressed), on(Var::Causal(to))]));
    }

    /// t12 within a task, and what follows when its first operation has been undone.
    pub(super) fn back_in_task(&mut self, step: usize) {
        let station = self.station;
        let op = station.steps[step][0];
        let Some(task) = station.task_of(op).filter(|_| is_reversible(station, op)) else { return };
        let by_panel = vec![on(Var::RetractPressed), off(Var::OnAnyPath)];
        if let Some(rest) = station.rest_before(op) {
            let Some(arrival) = station.arrival_at(rest) else { return };
            let places = (vec![StationPlace::undone(op)], vec![StationPlace::completed(arrival)]);
            let give_up = self.add(TransitionKind::GiveUp(task), places.0, places.1);
            give_up.when(ControlMode::Auto, [vec![off(Var::OnAnyPath)]]);
            give_up.when(ControlMode::Manual, [by_panel]);
            return;
        }
        let previous = station.steps[step - 1][0];
        if !is_reversible(station, previous) {
            return;
        }
        let by_hand = station.operations[op.index()].hand.reverse_on();
        let places = (vec![StationPlace::undone(op)], vec![StationPlace::undoing(previous)]);
        let t12 = self.add(TransitionKind::Back { from: step, to: step - 1 }, places.0, places.1);
        t12.when(ControlMode::Auto, [vec![on(Var::Secure), off(Var::OnAnyPath)]]);
        t12.when(ControlMode::Hand, by_hand.map(|back| vec![on(Var::Held(back)), off(Var::OnAnyPath)]));
        t12.when(ControlMode::Manual, [by_panel]);
    }
}
