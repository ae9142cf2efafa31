//! A plan beside its predecessor: what was done since, and whether its first step is still held.

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId};
use linewright_recovery::{Need, RecoveryAction, RecoveryPlan, RecoveryStep};

/// Something that ends by itself.
fn is_wait(step: &RecoveryStep) -> bool {
    matches!(step.action, RecoveryAction::First(Need::Standstill(_) | Need::Acknowledged))
}

/// Whether what moves now is the first step of `before`, held at a panel or the console: it stays the first step until the motion
/// has ended, since the button has to be held so long.
pub fn is_still_held(before: &RecoveryPlan, now: &RecoveryPlan) -> bool {
    let Some(step) = before.steps.first() else { return false };
    let held = matches!(step.action, RecoveryAction::Press(..) | RecoveryAction::Resume);
    let led: Vec<StationId> = step.moves.iter().map(|motion| motion.station).collect();
    let moves = |step: &RecoveryStep| match step.action {
        RecoveryAction::First(Need::Standstill(station)) => step.mode == ControlMode::Manual && led.contains(&station),
        _ => false,
    };
    held && now.steps.first().is_some_and(moves)
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
    use linewright_line::OpId;
    use linewright_line::net::StationPlace;
    use linewright_recovery::{PanelButton, PlannedMotion, RecoveryEnd};

    use super::*;

    fn step(action: RecoveryAction, moves: Vec<PlannedMotion>, mode: ControlMode) -> RecoveryStep {
        RecoveryStep { action, moves, mode, after: None, is_doubtful: false }
    }

    fn plan(steps: Vec<RecoveryStep>) -> RecoveryPlan {
        RecoveryPlan { steps, end: RecoveryEnd::Auto, is_shortest: true, expanded: 0 }
    }

    fn press() -> RecoveryStep {
        let place = StationPlace::operating(OpId(0));
        let motion = PlannedMotion { station: StationId(0), place, time: Duration::from_secs(1) };
        step(RecoveryAction::Press(StationId(0), PanelButton::Advance), vec![motion], ControlMode::Manual)
    }

    fn auto() -> RecoveryStep {
        step(RecoveryAction::Command(ModeCommand::Auto), Vec::new(), ControlMode::Auto)
    }

    fn moves(station: u16) -> RecoveryStep {
        step(RecoveryAction::First(Need::Standstill(StationId(station))), Vec::new(), ControlMode::Manual)
    }

    #[test]
    fn a_step_that_is_held_stays_the_first_and_is_what_was_done_at_its_end() {
        let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
        let line = line.expect("parses").line;
        let before = plan(vec![press(), auto()]);
        let held = plan(vec![moves(0), auto()]);
        assert!(is_still_held(&before, &held));
        let done = newly_done(&line, &before, &plan(vec![auto()]));
        assert_eq!(done, [press().text(&line)]);
        // Another station that moves is waited for, and that is nothing that was done.
        let other = plan(vec![moves(1), press(), auto()]);
        assert!(!is_still_held(&before, &other));
        assert!(newly_done(&line, &other, &before).is_empty());
        assert!(!is_still_held(&plan(vec![auto()]), &held));
    }
}
