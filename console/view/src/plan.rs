//! The way back to auto as a list, with the button of the step that comes next.
//!
//! That button stands at one place and does another thing after each step. So it does nothing for [`INERT_FOR`] after its step has
//! changed, and what is done at it names the step that it was for: a second press never does what was not read.

use std::time::Duration;

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
    /// Its button, where it has one.
    pub button: Option<OperateButton>,
    /// Number of the step that comes next, named by what is done at its button. It grows with each change, and
    /// with whatever is given or released; 0 before it is shown.
    pub step: u64,
}

/// Time in which the button of the next step does nothing after its step has changed.
pub const INERT_FOR: Duration = Duration::from_secs(1);

const INERT: &str = "the step has just changed: read it, then press";
const FORMER: &str = "not given: another step comes next by now; read it, then press";

/// The button of the step that comes next, over all steps.
#[derive(Debug, Default)]
pub(crate) struct NextButton {
    /// Number of the step that is shown.
    step: u64,
    /// Text and button of that step.
    of: Option<(String, String)>,
    since: Duration,
}

impl NextButton {
    /// The steps as they are shown from now on. `is_current`: they are those of what is received now.
    pub fn shown(&mut self, now: Duration, plan: Option<PlanPart>, is_current: bool) -> Option<PlanPart> {
        let of = plan.as_ref().and_then(|plan| {
            let text = plan.steps.get(plan.next?)?.text.clone();
            Some((text, plan.button.as_ref()?.key.clone()))
        });
        if of != self.of || !is_current {
            self.of = of;
            self.begin_anew(now);
        }
        let mut plan = plan?;
        plan.step = self.step;
        if let Some(button) = &mut plan.button {
            button.why_not = self.is_inert(now).then(|| INERT.to_owned());
        }
        Some(plan)
    }

    /// Something was given or has ended: what comes next is known when states have come after it.
    pub fn begin_anew(&mut self, now: Duration) {
        self.since = now;
        self.step += 1;
    }

    fn is_inert(&self, now: Duration) -> bool {
        now.saturating_sub(self.since) < INERT_FOR
    }

    /// Why what is done at the button of this step is not given; none where it may be.
    pub fn why_not(&self, now: Duration, step: u64) -> Option<String> {
        match () {
            () if step != self.step || self.of.is_none() => Some(FORMER.to_owned()),
            () if self.is_inert(now) => Some(INERT.to_owned()),
            () => None,
        }
    }
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
            step: 0,
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
