//! Draft → [`Cell`]: the last step, taken only when no rule has found an error.
//!
//! Every `?` here is a part that some earlier pass must have reported missing. Should that ever not be so, the caller
//! reports that instead of panicking: a description is a user's input, whatever the mistake is.

use std::time::Duration;

use super::draft::{DraftActivity, DraftCell, DraftException, DraftOrder, DraftPart, DraftResource};
use super::raw::{RawBounds, RawDispatch};
use super::rules::{Offsets, charted_time, offsets, transport};
use crate::routes::Routes;
use crate::{
    Activity, ActivityKind, AlarmAnswer, Cell, CellTimeouts, Dispatch, DispatchRule, ExceptionRule, OrderTemplate,
    PartType, PartTypeId, PlanStep, Resource, Stage, StageId, StageMove, Staying,
};

/// Default of the wait after which a part that could move goes first.
const PATIENCE: Duration = Duration::from_secs(600);

/// The cell a draft describes; `None` if a part is missing.
pub(super) fn finish(draft: &DraftCell<'_>, routes: &Routes) -> Option<Cell> {
    let raw = draft.raw;
    let name = raw.name.as_ref()?.value.clone();
    let offsets = offsets(draft);
    Some(Cell {
        title: raw.title.as_ref().map_or_else(|| name.clone(), |title| title.value.clone()),
        name,
        limits: limits(raw.cell.as_ref()?)?,
        dispatch: dispatch(&raw.dispatch),
        controllers: draft.controllers.names().map(str::to_owned).collect(),
        resources: draft.resources.iter().map(resource).collect::<Option<_>>()?,
        activities: draft.activities.iter().map(|a| activity(draft, a, routes, &offsets)).collect::<Option<_>>()?,
        part_types: draft.parts.iter().enumerate().map(|(at, part)| part_type(at, part, &offsets)).collect(),
        stages: draft.parts.iter().enumerate().flat_map(|(at, part)| stages(at, part)).collect(),
        exceptions: draft.exceptions.iter().map(|exception| self::exception(exception)).collect::<Option<_>>()?,
    })
}

fn limits(raw: &RawBounds) -> Option<CellTimeouts> {
    let wip_max = u32::try_from(raw.wip_max.as_ref()?.value).ok()?;
    Some(CellTimeouts { wip_max, reserve: raw.reserve, safety: raw.safety })
}

fn dispatch(raw: &RawDispatch) -> Dispatch {
    let rules: Vec<DispatchRule> = raw.known_rules().map(|rule| rule.value).collect();
    let seconds = |number: &Option<linewright_text::Located<f64>>| {
        number.as_ref().map_or(Duration::ZERO, |number| Duration::from_secs_f64(number.value))
    };
    Dispatch {
        rules: if rules.is_empty() { vec![DispatchRule::Fifo] } else { rules },
        look_ahead: seconds(&raw.look_ahead),
        patience: raw.patience.as_ref().map_or(PATIENCE, |patience| patience.value),
        window: seconds(&raw.window),
    }
}

fn resource(draft: &DraftResource<'_>) -> Option<Resource> {
    Some(Resource {
        name: draft.raw.name.as_ref()?.value.clone(),
        prototype: draft.prototype?,
        capacity: draft.capacity?,
        controller: draft.controller,
        presence: draft.raw.presence.as_ref().map(|presence| presence.value.clone()),
    })
}

fn activity(draft: &DraftCell<'_>, of: &DraftActivity<'_>, routes: &Routes, offsets: &Offsets) -> Option<Activity> {
    Some(Activity {
        name: of.name.clone(),
        kind: of.kind,
        uses: of.uses.iter().map(|part| part.value).collect(),
        orders: of.orders.iter().map(order).collect::<Option<_>>()?,
        moves: match of.kind {
            ActivityKind::Process => works(draft, of, offsets)?,
            ActivityKind::Leave => leaves(draft, of, routes, offsets)?,
            ActivityKind::Transport | ActivityKind::Enter => transports(draft, of, routes, offsets)?,
        },
    })
}

/// The stages that are moved on a way to the end.
fn transports(
    draft: &DraftCell<'_>,
    of: &DraftActivity<'_>,
    routes: &Routes,
    offsets: &Offsets,
) -> Option<Vec<StageMove>> {
    let way = transport(of)?;
    let written = of.time.as_ref().map(|time| time.value);
    let charted = if written.is_none() { charted_time(draft, of) } else { None };
    let (time, charted) = (written.or(charted.map(|of| of.longest)), charted.map(|of| of.sum));
    let numbers = draft.parts.iter().enumerate().flat_map(|(at, part)| (0..part.stages.len()).map(move |s| (at, s)));
    let stages = numbers.map(|(at, stage)| offsets.stage(at, stage)).filter(|&stage| routes.is_of_use(way, stage));
    Some(
        stages
            .map(|stage| StageMove { from: stage, to: stage, time, charted, program: None, stays: Staying::No })
            .collect(),
    )
}

/// A part that leaves may come again, as a part on which nothing has been done.
fn leaves(draft: &DraftCell<'_>, of: &DraftActivity<'_>, routes: &Routes, offsets: &Offsets) -> Option<Vec<StageMove>> {
    let mut moves = transports(draft, of, routes, offsets)?;
    for (at, part) in draft.parts.iter().enumerate() {
        let done = offsets.stage(at, part.stages.len() - 1);
        moves.iter_mut().filter(|of| of.from == done).for_each(|of| of.to = offsets.stage(at, 0));
    }
    Some(moves)
}

/// Stage changes by a resource, in the order of the stages.
fn works(draft: &DraftCell<'_>, of: &DraftActivity<'_>, offsets: &Offsets) -> Option<Vec<StageMove>> {
    let resource = of.uses.first()?.value.of?;
    let charted = charted_time(draft, of);
    let mut moves = Vec::new();
    for (at, part) in draft.parts.iter().enumerate() {
        for step in &part.steps {
            let here = step.on.iter().zip(&step.raw.on).filter(|(on, _)| **on == Some(resource));
            moves.extend(here.map(|(_, raw)| StageMove {
                from: offsets.stage(at, step.from),
                to: offsets.stage(at, step.to),
                time: raw.time.as_ref().map(|time| time.value).or(charted.map(|of| of.longest)),
                charted: charted.filter(|_| raw.time.is_none()).map(|of| of.sum),
                program: raw.program.as_ref().and_then(|program| i32::try_from(program.value).ok()),
                stays: raw.staying(),
            }));
        }
    }
    moves.sort_by_key(|of| (of.from, of.to));
    Some(moves)
}

fn order(draft: &DraftOrder<'_>) -> Option<OrderTemplate> {
    Some(OrderTemplate {
        controller: draft.controller?,
        task: draft.raw.task.as_ref()?.value.clone(),
        parameters: draft.parameters.iter().map(|(name, source)| ((*name).to_owned(), *source)).collect(),
        limit: draft.raw.limit.as_ref().map(|limit| limit.value),
    })
}

fn part_type(at: usize, draft: &DraftPart<'_>, offsets: &Offsets) -> PartType {
    let first: StageId = offsets.stage(at, 0);
    let step = |step: &super::draft::DraftStep<'_>| PlanStep {
        name: step.name.to_owned(),
        from: offsets.stage(at, step.from),
        to: offsets.stage(at, step.to),
        on: step.on.iter().copied().flatten().collect(),
    };
    PartType {
        name: draft.name.to_owned(),
        stages: first.0..offsets.stage(at, draft.stages.len() - 1).0 + 1,
        steps: draft.steps.iter().map(step).collect(),
    }
}

fn stages<'d>(at: usize, draft: &'d DraftPart<'_>) -> impl Iterator<Item = Stage> + 'd {
    let named = move |stage: &String| Stage { name: format!("{}.{stage}", draft.name), part_type: PartTypeId::at(at) };
    draft.stages.iter().map(named)
}

fn exception(draft: &DraftException<'_>) -> Option<ExceptionRule> {
    let raw = draft.raw;
    let answers = raw.answers.iter().zip(&draft.down).map(|(answer, down)| {
        Some(AlarmAnswer {
            word: answer.word.as_ref()?.value.clone(),
            part: answer.part.as_ref()?.value,
            then: answer.then.as_ref()?.value,
            down: down.clone(),
        })
    });
    Some(ExceptionRule {
        activities: draft.activities.clone(),
        code: raw.code.as_ref()?.value.clone(),
        tell: raw.tell.as_ref()?.value.clone(),
        retries: u32::try_from(raw.retries).ok()?,
        automatic: raw.automatic,
        emergency_stop: draft.emergency_stop.clone(),
        answers: answers.collect::<Option<_>>()?,
    })
}
