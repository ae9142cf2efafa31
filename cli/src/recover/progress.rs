//! A plan beside its predecessor: what was done since.

use linewright_line::Line;
use linewright_recovery::{Need, RecoveryAction, RecoveryPlan, RecoveryStep};

/// Something that ends by itself.
fn is_wait(step: &RecoveryStep) -> bool {
    matches!(step.action, RecoveryAction::First(Need::Standstill(_) | Need::Acknowledged | Need::Settled { .. }))
}

/// The first steps of a plan that its successor does not have any more, if the rest is the same.
pub fn newly_done(line: &Line, before: &RecoveryPlan, now: &RecoveryPlan) -> Vec<String> {
    let steps = |plan: &RecoveryPlan| -> Vec<RecoveryStep> {
        plan.steps.iter().filter(|step| !is_wait(step)).cloned().collect()
    };
    let actions =
        |steps: &[RecoveryStep]| steps.iter().map(|step| step.action.clone()).collect::<Vec<RecoveryAction>>();
    let old = steps(before);
    let (was, is) = (actions(&old), actions(&steps(now)));
    if is.len() >= was.len() || !was.ends_with(&is) {
        return Vec::new();
    }
    old[..was.len() - is.len()].iter().map(|step| step.text(line)).collect()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use linewright_coordinator_logic::ModeCommand;
    use linewright_line::net::{ControlMode, StationPlace};
    use linewright_line::{OpId, StationId};
    use linewright_recovery::{PanelButton, PlannedMotion, RecoveryEnd};

    use super::*;

    fn step(action: RecoveryAction, moves: Vec<PlannedMotion>, mode: ControlMode) -> RecoveryStep {
        RecoveryStep { action, moves, mode, after: None, is_doubtful: false }
    }

    fn plan(steps: Vec<RecoveryStep>) -> RecoveryPlan {
        RecoveryPlan {
            steps,
            end: RecoveryEnd::Auto,
            is_shortest: true,
            begins_anew: false,
            led: Vec::new(),
            expanded: 0,
        }
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

    fn moves(station: u16) -> RecoveryStep {
        step(RecoveryAction::First(Need::Standstill(StationId(station))), Vec::new(), ControlMode::Hand)
    }

    #[test]
    fn what_is_no_step_any_more_was_done_and_what_was_waited_for_was_not() {
        let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
        let line = line.expect("parses").line;
        let before = plan(vec![press(), auto()]);
        // While it is held, and while more than that is to be done.
        assert!(newly_done(&line, &before, &before).is_empty());
        let done = newly_done(&line, &before, &plan(vec![auto()]));
        assert_eq!(done, [press().text(&line)]);
        let other = plan(vec![moves(1), press(), auto()]);
        assert!(newly_done(&line, &other, &before).is_empty());
    }
}
