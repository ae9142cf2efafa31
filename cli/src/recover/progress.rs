//! A plan beside its predecessor: what was done since.

use linewright_line::{Line, StationId};
use linewright_recovery::{Need, PlannedMotion, RecoveryAction, RecoveryPlan, RecoveryStep};

/// Something that ends by itself.
fn is_wait(step: &RecoveryStep) -> bool {
    let is_wait =
        matches!(step.action, RecoveryAction::First(Need::Standstill(_) | Need::Acknowledged | Need::Settled { .. }));
    is_wait || step.is_fault_signal()
}

/// What was done while plans were followed.
#[derive(Debug, Default)]
pub struct DoneSteps {
    texts: Vec<String>,
    /// The plan that the next one is compared with.
    before: Option<RecoveryPlan>,
}

impl DoneSteps {
    /// The steps that were done, in their order.
    pub fn texts(&self) -> &[String] {
        &self.texts
    }

    /// Takes the newest plan. Whether an answer is taken shows when sensors were compared with it: until then nothing is counted.
    pub fn note(&mut self, line: &Line, now: &RecoveryPlan) {
        if let Some(before) = &self.before {
            let done = newly_done(before, now);
            let is_answer = |step: &RecoveryStep| matches!(step.action, RecoveryAction::First(Need::Answer(_)));
            if now.is_unsettled() && done.iter().any(is_answer) {
                return;
            }
            self.texts.extend(done.iter().map(|step| done_text(line, step)));
        }
        self.before = Some(now.clone());
    }
}

/// A step that was done. The text of an alarm is of before its answer.
fn done_text(line: &Line, step: &RecoveryStep) -> String {
    match &step.action {
        RecoveryAction::First(Need::Answer(alarm)) => format!("alarm {} was answered", alarm.id),
        _ => step.text(line),
    }
}

/// The first steps of a plan that its successor does not have any more, if the rest is the same.
fn newly_done(before: &RecoveryPlan, now: &RecoveryPlan) -> Vec<RecoveryStep> {
    let steps = |plan: &RecoveryPlan| -> Vec<RecoveryStep> {
        plan.steps.iter().filter(|step| !is_wait(step)).cloned().collect()
    };
    let (mut was, is) = (steps(before), steps(now));
    let Some(done) = was.len().checked_sub(is.len()).filter(|done| *done > 0) else { return Vec::new() };
    if !was[done..].iter().zip(&is).all(|(was, is)| is_same(&was.action, &is.action)) {
        return Vec::new();
    }
    was.truncate(done);
    was
}

/// Whether two actions are the same thing to do. The text of an alarm changes with what is done for it, as when a station has come to rest.
fn is_same(was: &RecoveryAction, is: &RecoveryAction) -> bool {
    match (was, is) {
        (RecoveryAction::First(Need::Answer(was)), RecoveryAction::First(Need::Answer(is))) => was.id == is.id,
        _ => was == is,
    }
}

/// Failures of the press that stays the first step of a plan.
#[derive(Debug, Default)]
pub struct PressFailures {
    press: Option<(RecoveryAction, Vec<PlannedMotion>)>,
    has_moved: bool,
    failed: u32,
}

impl PressFailures {
    /// Takes the first step of the newest plan behind fault signals; whether its station moves now, and whether it was stopped by
    /// what comes again.
    pub fn note(
        &mut self,
        first: Option<&RecoveryStep>,
        moves: impl Fn(StationId) -> bool,
        comes_again: impl Fn(StationId) -> bool,
    ) {
        let press = first.filter(|step| matches!(step.action, RecoveryAction::Press(..)));
        let press = press.map(|step| (step.action.clone(), step.moves.clone()));
        if self.press != press {
            *self = PressFailures { press, ..PressFailures::default() };
        }
        let Some(RecoveryAction::Press(station, _)) = self.press.as_ref().map(|(action, _)| action) else { return };
        if moves(*station) {
            self.has_moved = true;
        } else if std::mem::take(&mut self.has_moved) && comes_again(*station) {
            self.failed += 1;
        }
    }

    /// So often in a row.
    pub fn count(&self) -> u32 {
        self.failed
    }
}

/// What stands in place of a press that has failed twice: another one ends in the same fault. `way_home`: the station that *return*
/// alone leads home.
pub fn instead_of_again(failed: u32, fault: &str, way_home: Option<&str>) -> Option<String> {
    const OFTEN: u32 = 2;
    (failed >= OFTEN && !fault.is_empty()).then(|| {
        let home = way_home.map_or_else(String::new, |name| format!(", or lead {name} home: hold return"));
        format!(
            "this press has failed {failed} times: {fault}. Remove the cause at the machine before the next one{home}"
        )
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use linewright_coordinator_logic::ModeCommand;
    use linewright_line::net::{ControlMode, StationPlace};
    use linewright_line::{InputId, OpId};
    use linewright_recovery::{PanelButton, RecoveryEnd, StandingAlarm};

    use super::*;

    fn step(action: RecoveryAction, moves: Vec<PlannedMotion>, mode: ControlMode) -> RecoveryStep {
        RecoveryStep { action, moves, mode, after: None, is_doubtful: false }
    }

    fn plan(steps: Vec<RecoveryStep>) -> RecoveryPlan {
        RecoveryPlan::ends(steps, RecoveryEnd::Auto)
    }

    fn press() -> RecoveryStep {
        let place = StationPlace::operating(OpId(0));
        let time = Duration::from_secs(1);
        let motion = PlannedMotion { station: StationId(0), place, to_place: None, homes: false, time };
        step(RecoveryAction::Press(StationId(0), PanelButton::Advance), vec![motion], ControlMode::Manual)
    }

    fn auto() -> RecoveryStep {
        step(RecoveryAction::Command(ModeCommand::Auto), Vec::new(), ControlMode::Auto)
    }

    fn alarm(id: u64, text: &str) -> RecoveryStep {
        let alarm = StandingAlarm {
            id,
            text: text.to_owned(),
            answers: Vec::new(),
            lead: Vec::new(),
            reset: Vec::new(),
            at_order: Vec::new(),
            end: None,
            bring: None,
        };
        step(RecoveryAction::First(Need::Answer(alarm)), Vec::new(), ControlMode::Manual)
    }

    fn moves(station: u16) -> RecoveryStep {
        step(RecoveryAction::First(Need::Standstill(StationId(station))), Vec::new(), ControlMode::Hand)
    }

    #[test]
    fn what_is_no_step_any_more_was_done_and_what_was_waited_for_was_not() {
        let before = plan(vec![press(), auto()]);
        // While it is held, and while more than that is to be done.
        assert!(newly_done(&before, &before).is_empty());
        let done = newly_done(&before, &plan(vec![auto()]));
        assert_eq!(done, [press()]);
        let other = plan(vec![moves(1), press(), auto()]);
        assert!(newly_done(&other, &before).is_empty());
        // The press has led the station to a rest, which the alarm says now.
        let before = plan(vec![press(), alarm(3, "First lead m1 to a rest."), auto()]);
        assert_eq!(newly_done(&before, &plan(vec![alarm(3, "m1 is at rest."), auto()])), done);
        assert!(newly_done(&before, &plan(vec![alarm(4, "m1 is at rest."), auto()])).is_empty());
    }

    #[test]
    fn an_answer_is_done_when_sensors_have_confirmed_it_and_not_where_they_contradict_it() {
        let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
        let line = line.expect("parses").line;
        let compared = || {
            let need = Need::Settled { activity: "`load M1` waits for sensors".to_owned(), stations: Vec::new() };
            plan(vec![step(RecoveryAction::First(need), Vec::new(), ControlMode::Auto)])
        };
        let asked = |id| plan(vec![alarm(id, "Answer where the part is.")]);
        let done_after = |plans: &[RecoveryPlan]| {
            let mut done = DoneSteps::default();
            plans.iter().for_each(|plan| done.note(&line, plan));
            done.texts().to_vec()
        };
        assert_eq!(done_after(&[asked(1), compared(), asked(2)]), [""; 0], "not taken: asked again");
        assert_eq!(done_after(&[asked(1), compared()]), [""; 0], "not known yet");
        assert_eq!(done_after(&[asked(1), compared(), plan(Vec::new())]), ["alarm 1 was answered"]);
    }

    fn signal() -> RecoveryStep {
        step(RecoveryAction::First(Need::FaultSignal(StationId(0), InputId(3))), Vec::new(), ControlMode::Manual)
    }

    /// A drive that stands reports no fault any more, and sticks as before.
    #[test]
    fn a_fault_signal_that_has_gone_off_is_nothing_that_was_done_and_no_other_press() {
        let (on, off) = (plan(vec![signal(), press(), auto()]), plan(vec![press(), auto()]));
        assert!(newly_done(&on, &off).is_empty());
        assert_eq!(newly_done(&on, &plan(vec![auto()])), [press()]);
        let mut failures = PressFailures::default();
        for _ in 0..2 {
            for (now, moves) in [(&off, true), (&off, true), (&on, false), (&off, false)] {
                failures.note(now.behind_signals().map(|at| &now.steps[at]), |_| moves, |_| true);
            }
        }
        assert_eq!(failures.count(), 2);
    }

    /// Holding the button longer would end in the same fault of the watchdog.
    #[test]
    fn a_press_that_fails_twice_is_not_proposed_again_without_its_cause() {
        let mut failures = PressFailures::default();
        let mut held = |first: &RecoveryStep, comes_again: bool| {
            for moves in [true, true, false, false] {
                failures.note(Some(first), |_| moves, |_| comes_again);
            }
            failures.count()
        };
        let other = step(RecoveryAction::Press(StationId(0), PanelButton::Return), Vec::new(), ControlMode::Manual);
        let counts = [held(&press(), true), held(&press(), false), held(&press(), true), held(&other, true)];
        assert_eq!(counts, [1, 1, 2, 1], "a button that was let go is no failure; another press is another one");
        let said = |failed| instead_of_again(failed, "feed: no arrival within 2 s", None);
        assert_eq!(said(1), None);
        let text = "this press has failed 2 times: feed: no arrival within 2 s. Remove the cause at the machine before the next one";
        assert_eq!(said(2).as_deref(), Some(text));
        let text = format!("{text}, or lead press home: hold return");
        assert_eq!(instead_of_again(2, "feed: no arrival within 2 s", Some("press")), Some(text));
        failures.note(Some(&auto()), |_| false, |_| true);
        assert_eq!(failures.count(), 0);
    }
}
