//! The way back to auto as a list, with the button of the step that comes next.

use linewright_line::Line;
use linewright_recovery::{RecoveryAction, RecoveryPlan};
use serde::Serialize;

use crate::bounds;
use crate::hold::HoldButton;
use crate::message::PageAct;
use crate::operate::OperateButton;

/// The steps from what is received now to auto, with the texts of `linewright recover`.
#[derive(Clone, Debug, Serialize)]
pub struct PlanPart {
    /// What is to be known before.
    pub begin: Vec<String>,
    /// 100 at most.
    pub steps: Vec<PlanStepPart>,
    /// What is to be known of the end, or why it is not auto.
    pub end: Vec<String>,
    /// The step that comes next, by its place in the list.
    pub next: Option<usize>,
    /// Its button, where it has one; whether that may be given now is known where it stands among the others.
    pub button: Option<OperateButton>,
}

/// A step.
#[derive(Clone, Debug, Serialize)]
pub struct PlanStepPart {
    pub text: String,
    /// Why this way.
    pub since: Option<String>,
    /// Of several places, how the station stands at each.
    pub stands: Vec<String>,
}

impl PlanPart {
    /// The list of a plan, with the reason of each step that needs one.
    pub fn of(line: &Line, plan: &RecoveryPlan, reasons: &[Option<String>]) -> Self {
        let led = plan.led.iter().map(|led| led.text(line)).chain(plan.begin_text(line));
        let begin = led.chain(plan.led_back.iter().map(|back| back.text(line))).collect::<Vec<_>>();
        let reasons = reasons.iter().cloned().chain(std::iter::repeat(None));
        let steps = plan.steps.iter().zip(reasons).take(bounds::LIST_MAX).map(|(step, since)| PlanStepPart {
            text: bounds::text(&step.text(line)),
            since: since.as_deref().map(bounds::text),
            stands: bounds::texts(&step.stands(line)),
        });
        let next = plan.behind_signals();
        let shortest = plan.shorter_text().map(str::to_owned);
        PlanPart {
            begin: bounds::texts(&begin),
            steps: steps.collect(),
            end: bounds::texts(&plan.end_text(line).into_iter().chain(shortest).collect::<Vec<_>>()),
            next,
            button: next.and_then(|at| button(line, &plan.steps[at].action)),
        }
    }
}

/// The button that does a step; none of a step that a person does elsewhere.
fn button(line: &Line, action: &RecoveryAction) -> Option<OperateButton> {
    let name = |id| line.station(id).name.clone();
    let command = |word: &str, station| PageAct::Command { word: word.to_owned(), station };
    let hold = |of: HoldButton| (of.name(line), of.act(line));
    let (label, act) = match *action {
        RecoveryAction::Command(of) => (of.name().to_owned(), command(of.name(), None)),
        RecoveryAction::ManualAlone(id) => (format!("manual {}", name(id)), command("manual", Some(name(id)))),
        RecoveryAction::AutoAgain(id) => (format!("auto {}", name(id)), command("auto", Some(name(id)))),
        RecoveryAction::Press(id, side) => hold(HoldButton::Panel(id, side)),
        RecoveryAction::Resume => hold(HoldButton::Resume),
        RecoveryAction::Hold { button, .. } => hold(HoldButton::Hand(button)),
        RecoveryAction::Selector(station, manual) => {
            let to = if manual { "manual" } else { "auto" };
            (format!("selector of {} to {to}", name(station)), PageAct::Select { station: name(station), manual })
        }
        RecoveryAction::First(_) | RecoveryAction::Rejoin { .. } => return None,
    };
    Some(OperateButton::of(&label, act, None))
}
