//! An operator that brings the line back by the recovery plan: looks, does the first step, and looks again.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{AxisId, InputId, Line, OpId, StationId};
use linewright_recovery::{
    LineSituation, Need, PanelButton, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep, as_received, plan,
};
use linewright_station_logic::RejoinAt;

use crate::people::NOT_HOME;
use crate::world::World;

/// Longer than any mode, report or order takes.
const MOMENT: Duration = Duration::from_millis(600);
/// Steps of an operator. The longest plan has fewer.
const STEPS_MAX: usize = 150;
/// How often the same need is waited for before the station that it is about is started again, and before it is given up.
const WAITS: (usize, usize) = (3, 12);

impl World {
    /// What a console sees.
    fn situation_seen(&self) -> Option<LineSituation> {
        let shell = self.coordinators[0].shell.as_ref()?;
        let coordinator = shell.coordinator();
        let report = |id: StationId| {
            let controller = self.controller(id.index()).filter(|_| coordinator.hears(id))?;
            Some(as_received(controller.report()))
        };
        let stations = self.line.station_ids().map(report).collect();
        let (mode, enabled) = (coordinator.mode(), coordinator.order().enabled);
        Some(LineSituation::read(&self.line, mode, enabled, coordinator.standing(), stations))
    }

    /// Follows plans until auto is in force.
    ///
    /// # Errors
    /// What the plan does not lead out of.
    pub(crate) fn follow_plans(&mut self) -> Result<(), String> {
        let mut waits = 0;
        // Steps of the plan before, of which the first one was done.
        let mut left: Option<usize> = None;
        let mut confirmed: Option<StationId> = None;
        for _ in 0..STEPS_MAX {
            let Some(seen) = self.situation_seen() else {
                self.run_for(MOMENT);
                continue;
            };
            let plan = plan(&self.line, &seen);
            let Some(step) = plan.steps.first().cloned() else {
                return match plan.end {
                    RecoveryEnd::Auto => Ok(()),
                    end => Err(self.no_way(&end)),
                };
            };
            if let RecoveryAction::First(need) = &step.action {
                waits += 1;
                if waits > WAITS.1 {
                    return Err(format!("the plan waits without an end: {}", self.described(&plan)));
                }
                self.see_to(need, waits)?;
                left = None;
                continue;
            }
            if matches!(plan.end, RecoveryEnd::NoWay { .. } | RecoveryEnd::Misfit(_)) {
                return Err(self.no_way(&plan.end));
            }
            if left.is_some_and(|left| plan.steps.len() >= left) {
                // A report may have changed meanwhile: it is the same once more at the most.
                waits += 1;
                if waits > WAITS.0 {
                    return Err(format!("the plan does not get shorter: {}", self.described(&plan)));
                }
            }
            // A confirmation at the home operation cannot be seen in a report, and is asked for again.
            if let RecoveryAction::Rejoin { station, .. } = step.action
                && confirmed.replace(station) == Some(station)
            {
                return self.bring_to_auto();
            }
            left = Some(plan.steps.len());
            self.do_step(&step);
            if self.observer.finding.is_some() {
                return Ok(());
            }
        }
        Err("the plan does not end".to_owned())
    }

    fn no_way(&self, end: &RecoveryEnd) -> String {
        match end {
            RecoveryEnd::NoWay { reasons, .. } => format!("{NOT_HOME}: the plan has no way: {reasons:?}"),
            end => format!("the plan ends otherwise: {end:?}"),
        }
    }

    fn described(&self, plan: &RecoveryPlan) -> String {
        let steps: Vec<String> = plan.steps.iter().map(|step| step.text(&self.line)).collect();
        format!("{}; {:?}; {}", steps.join(" / "), plan.end, self.situation())
    }

    /// What the machine or a person beside it has to do.
    fn see_to(&mut self, need: &Need, waits: usize) -> Result<(), String> {
        self.note(format!("the operator sees to {need:?}"));
        if let Need::Axis { station, op, input, conflicts } = need {
            let put = self.put_back(*station, *op, *input);
            // The step names what to look at first.
            put.map_err(|text| if conflicts.is_empty() { format!("the plan does not name it: {text}") } else { text })?;
        }
        if let (Need::Heard(_), true) = (need, waits.is_multiple_of(WAITS.0)) {
            self.start_again();
        }
        self.run_for(Duration::from_secs(2));
        Ok(())
    }

    /// Puts an axis back onto a switch by hand.
    fn put_back(&mut self, station: StationId, op: OpId, input: InputId) -> Result<(), String> {
        let Some((axis, at)) = switch_at(&self.line, station, op, input) else { return Ok(()) };
        self.put_by_hand(station.index(), &[(axis, at)])
    }

    fn do_step(&mut self, step: &RecoveryStep) {
        let text = step.text(&self.line);
        self.note(format!("the operator: {text}"));
        match &step.action {
            RecoveryAction::First(_) => {}
            RecoveryAction::Command(command) => {
                let _ = self.ask(*command);
            }
            RecoveryAction::Press(station, button) => {
                let (at, advance) = (station.index(), *button == PanelButton::Advance);
                self.press(at, advance, true);
                self.run_for(step.hold(&self.line));
                self.press(at, advance, false);
            }
            RecoveryAction::Resume => {
                self.hold_resume(true);
                self.run_for(step.hold(&self.line));
                self.hold_resume(false);
            }
            RecoveryAction::ManualAlone(station)
            | RecoveryAction::AutoAgain(station)
            | RecoveryAction::Hold { station, .. } => {
                unreachable!("{station:?}: a line without a cell has no manual beside auto, and no alarm")
            }
            RecoveryAction::Selector(station, manual) => self.say_selector(station.index(), *manual),
            RecoveryAction::Rejoin { station, at, .. } => {
                let at = self.seen_place(*station, at.at, &step.action);
                self.say_rejoin(station.index(), at);
            }
        }
        self.run_for(MOMENT);
    }

    /// Which of the operations that the switches fit it is, the person sees.
    fn seen_place(&self, station: StationId, at: RejoinAt, action: &RecoveryAction) -> RejoinAt {
        let fits = self.operations_that_fit(station);
        let is_seen = |at: &RejoinAt| matches!(at, RejoinAt::Within(op) if fits.contains(op));
        action.choices().map(|choice| choice.at).find(is_seen).unwrap_or(at)
    }

    /// Brings the line to auto by plans, and waits for a whole cycle.
    ///
    /// # Errors
    /// What did not succeed.
    pub(crate) fn recover(&mut self) -> Result<(), String> {
        self.run_for(Duration::from_secs(3));
        for at in 0..self.stations.len() {
            self.say_selector(at, false);
        }
        self.run_for(Duration::from_millis(500));
        if self.mode() == Some(ControlMode::Hand) {
            // A running line that is worked by hand: its people stop it.
            let _ = self.ask(ModeCommand::Stop);
        }
        self.follow_plans()?;
        if self.observer.finding.is_some() {
            return Ok(());
        }
        self.one_cycle()
    }
}

/// Where an axis is on a switch.
fn switch_at(line: &Line, station: StationId, op: OpId, input: InputId) -> Option<(AxisId, f64)> {
    let described = line.station(station);
    let all = described.op_ids().filter_map(|at| {
        let operation = &described.operations[at.index()];
        let motion = operation.motion;
        let back = match &operation.module {
            linewright_line::OperationModule::Reversible { recovery, .. } => recovery.complete == input,
            linewright_line::OperationModule::Irreversible { .. } => false,
        };
        let to = (operation.normal.complete == input).then_some(motion.to).or(back.then_some(motion.from))?;
        Some((at == op, motion.axis, to))
    });
    let all: Vec<(bool, AxisId, f64)> = all.collect();
    all.iter().find(|(is_own, ..)| *is_own).or(all.first()).map(|&(_, axis, to)| (axis, to))
}
