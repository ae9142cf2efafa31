//! State of a cell as a message.
//!
//! Names of the net become an operator's terms: a part is *in M1, loaded*, or *in `load M1`*.

use std::collections::BTreeMap;
use std::sync::Arc;

use linewright_coordinator_cell::exception::{Alarm, LeadDirection, StationsToLead};
use linewright_coordinator_cell::production::{Production, ProductionOrder, ProductionStatus};
use linewright_coordinator_cell::texts::{AnswerFit, AnswerRemark, ListedAnswer};
use linewright_coordinator_cell::{
    ActivityPhase, CellTable, Coordination, ModeId, OngoingActivity, OngoingOrder as StationOrder, OrderFailure,
    OrderProgress, Part, PartPlace, PlayerState, ProductionId, TaskReport, texts,
};
use linewright_line::{Line, RestId, StationId, Tick};
use linewright_msgs::{ActivityState, AlarmState, Bounded, CellState, LISTED_MAX, PartState, ProductionState, fitting};
use linewright_node_line::quoted;

use super::wire::time;

/// Alarms whose answers are rehearsed for a message: each costs a copy of the state.
const REHEARSED_MAX: usize = 5;

/// The newest reports of stations, with the times of their arrival.
pub type NewestReports = BTreeMap<StationId, (Tick, TaskReport)>;

/// Fills the message, but for its header and numbers.
pub fn describe(
    line: &Line,
    coordination: &Coordination,
    reports: &NewestReports,
    starting: bool,
    now: Tick,
    message: &mut CellState,
) {
    let state = coordination.state();
    let (table, production) = (state.table(), state.production());
    message.epoch = state.epoch();
    message.starting = starting;
    message.parts_inside = count(state.parts().len());
    message.parts_left = state.left();
    message.orders_open = count(production.orders().filter(|order| order.ended.is_none()).count());
    let names = |ids: Vec<StationId>| ids.into_iter().map(|id| line.station(id).name.clone()).collect();
    let alarm = |(at, alarm): (usize, &Alarm)| {
        let answers = answers(line, coordination, reports, now, (alarm, at < REHEARSED_MAX));
        let StationsToLead { lead, reset, at_order, reason } = coordination.alarm_leads(now, alarm);
        let direction = |direction| match direction {
            LeadDirection::On => AlarmState::LEAD_ON,
            LeadDirection::Back => AlarmState::LEAD_BACK,
        };
        let brings = coordination.alarm_brings(now, alarm);
        let to_rest = |(station, rest): (StationId, RestId)| {
            let of = line.station(station).rests.get(rest.index());
            of.map(|rest| rest.name.clone()).unwrap_or_default()
        };
        AlarmState {
            id: alarm.id.0,
            raised: time(alarm.since),
            text: fitting(coordination.alarm_text(now, alarm)),
            verdicts: answers.iter().map(|of| verdict_code(&of.remark)).collect(),
            verdict_reasons: answers.iter().map(verdict_reason).collect(),
            meanings: answers.iter().map(|of| of.meaning.clone()).collect(),
            answers: answers.into_iter().map(|of| of.word).collect(),
            lead: names(lead),
            reset: names(reset),
            at_order: names(at_order),
            lead_to: reason.map_or(AlarmState::LEAD_EITHER, |reason| direction(reason.direction())),
            lead_because: reason.map(|reason| texts::alarm::because(table.handling(), reason)).unwrap_or_default(),
            bring: brings.map(|(station, _)| line.station(station).name.clone()).unwrap_or_default(),
            to_rest: brings.map(to_rest).unwrap_or_default(),
        }
    };
    message.alarms = listed(state.exceptions().alarms().enumerate().map(alarm));
    let name = |id| table.handling().resource(id).map(|resource| resource.name.to_string()).unwrap_or_default();
    message.down = listed(state.exceptions().down().map(|(id, _)| name(id)));
    let mut parts: Vec<&Part> = state.parts().collect();
    parts.sort_by_key(|part| (part.since, part.id));
    message.parts = listed(parts.into_iter().map(|part| self::part(table, state, part)));
    message.activities = listed(state.firings().map(|firing| activity(line, state, firing, now)));
    let (open, over): (Vec<&ProductionOrder>, Vec<&ProductionOrder>) =
        production.orders().partition(|order| order.ended.is_none());
    message.orders =
        listed(open.into_iter().chain(over.into_iter().rev()).map(|order| ordered(production, order, now)));
}

/// The answers to an alarm, each with what sensors say of it now.
fn answers(
    line: &Line,
    coordination: &Coordination,
    reports: &NewestReports,
    now: Tick,
    (alarm, is_rehearsed): (&Alarm, bool),
) -> Vec<ListedAnswer> {
    let state = coordination.state();
    // A station that is not heard any more may have been moved since.
    let is_fresh = |at: Tick| now < at + state.table().repeat_interval();
    let fresh = reports.iter().filter(|(_, (at, _))| is_fresh(*at));
    let fresh: Vec<(StationId, &TaskReport)> = fresh.map(|(&id, (_, report))| (id, report)).collect();
    let remark = |word: &String| {
        if !is_rehearsed {
            return Some(AnswerRemark::behind_others());
        }
        AnswerRemark::of(line, state, alarm.id, &coordination.rehearsed(now, alarm.id, word, &fresh))
    };
    let meanings = texts::alarm::meanings(coordination, alarm).into_iter().chain(std::iter::repeat(String::new()));
    let answer = |(word, meaning): (&String, String)| {
        let remark = remark(word);
        ListedAnswer { word: word.clone(), meaning, remark }
    };
    ListedAnswer::in_order(alarm.words.iter().zip(meanings).map(answer).collect())
}

fn verdict_reason(answer: &ListedAnswer) -> String {
    answer.remark.as_ref().map(|remark| fitting(remark.why.clone())).unwrap_or_default()
}

fn verdict_code(remark: &Option<AnswerRemark>) -> u8 {
    match remark.as_ref().map(|remark| remark.fit) {
        None => AlarmState::VERDICT_NONE,
        Some(AnswerFit::Fits) => AlarmState::VERDICT_FITS,
        Some(AnswerFit::Contradicts) => AlarmState::VERDICT_CONTRADICTS,
        Some(AnswerFit::Refused) => AlarmState::VERDICT_REFUSED,
        Some(AnswerFit::NotMeasured) => AlarmState::VERDICT_NOT_MEASURED,
        Some(AnswerFit::NotKnown) => AlarmState::VERDICT_NOT_KNOWN,
    }
}

fn count(of: usize) -> u32 {
    u32::try_from(of).unwrap_or(u32::MAX)
}

fn listed<T: Default, const N: usize>(all: impl Iterator<Item = T>) -> Bounded<T, N> {
    Bounded::new(all.take(LISTED_MAX.min(N)).collect()).unwrap_or_default()
}

fn part(table: &CellTable, state: &PlayerState, part: &Part) -> PartState {
    let (cell, place) = match part.place {
        PartPlace::On { cell, arrival: _ } => {
            let owner = table.cell_name(cell).split('<').next().unwrap_or_default();
            let place = match part.position {
                Some(position) => format!("{owner}, position {position}"),
                None => owner.to_owned(),
            };
            (Some(cell), place)
        }
        PartPlace::In(id) => match state.firing(id).map(|firing| firing.mode) {
            Some(mode) => (table.part_in(mode).or(table.part_out(mode)), format!("in `{}`", table.activity(mode).name)),
            None => (None, String::new()),
        },
    };
    // A cell of parts is called by its place, and by the stage of its parts in angles.
    let stage = cell.and_then(|cell| table.cell_name(cell).split_once('<'));
    PartState {
        id: part.id.0,
        stage: stage.map(|(_, stage)| stage.trim_end_matches('>').to_owned()).unwrap_or_default(),
        place: fitting(place),
        since: time(part.since),
        order: state.production().order_of(part.id).map_or(0, |order| order.id.0),
    }
}

fn activity(line: &Line, state: &PlayerState, firing: &OngoingActivity, now: Tick) -> ActivityState {
    let (table, mode): (&CellTable, ModeId) = (state.table(), firing.mode);
    let text = match firing.phase {
        ActivityPhase::Running => {
            let open = firing.orders.iter().filter(|order| order.is_open());
            let open: Vec<String> = open.map(|order| waits(line, order, now)).collect();
            open.join("; ")
        }
        ActivityPhase::Failed(_) => {
            let trouble = state.exceptions().trouble(firing.id);
            format!("failed, waits for {}", texts::recovery(trouble.map(|trouble| &trouble.stage)))
        }
    };
    let is_at_it = |order: &&StationOrder| match order.state {
        OrderProgress::Running => true,
        OrderProgress::Failed(failure) => !matches!(failure, OrderFailure::Refused(_)),
        OrderProgress::Written | OrderProgress::Ended => false,
    };
    let at_it = firing.orders.iter().filter(is_at_it);
    let ordered = at_it.filter_map(|order| Some((order.station, state.ordered_task(order.key)?)));
    let numbers = |all: &[(Arc<str>, i32)]| {
        all.iter().map(|(name, number)| format!("{name}={number}")).collect::<Vec<_>>().join("\n")
    };
    let mut message = ActivityState {
        id: firing.id.0,
        name: table.activity(mode).name.to_string(),
        part: firing.part.map_or(0, |part| part.0),
        began: time(firing.began),
        running: firing.phase == ActivityPhase::Running,
        text: fitting(text),
        ..ActivityState::default()
    };
    for (station, (task, all)) in ordered {
        message.stations.push(line.station(station).name.clone());
        message.tasks.push(task.to_string());
        message.numbers.push(numbers(&all));
    }
    message
}

fn waits(line: &Line, order: &StationOrder, now: Tick) -> String {
    let left = order.limit.since(now).as_secs();
    let doing = match order.state {
        OrderProgress::Written => "order not acknowledged",
        OrderProgress::Running | OrderProgress::Ended | OrderProgress::Failed(_) => "order in progress",
    };
    format!("{}: {doing}, {left} s left", line.station(order.station).name)
}

/// Operators' names of the production orders of these numbers.
pub fn names(production: &Production, ids: &[ProductionId]) -> impl Iterator<Item = String> {
    ids.iter().filter_map(|&id| production.order(id)).map(|order| format!("`{}`", order.request.name))
}

/// The sender of a request, behind it; empty where none is named.
pub fn by_whom(by: &str) -> String {
    let by = quoted(by.trim());
    if by.is_empty() { by } else { format!(" by {by}") }
}

/// Number of parts, in words.
pub fn parts(count: u32) -> String {
    if count == 1 { "1 part".to_owned() } else { format!("{count} parts") }
}

/// A production order as a message.
pub fn ordered(production: &Production, order: &ProductionOrder, now: Tick) -> ProductionState {
    let status = production.status(order, now);
    let (number, text) = match &status {
        ProductionStatus::Waiting { on, until } => {
            let on: Vec<String> = names(production, on).chain(until.map(|_| "its release".to_owned())).collect();
            (ProductionState::STATUS_WAITING, format!("waits for {}", on.join(", ")))
        }
        ProductionStatus::Released => (ProductionState::STATUS_RELEASED, "released".to_owned()),
        ProductionStatus::InWork { .. } => (ProductionState::STATUS_IN_WORK, "in work".to_owned()),
        ProductionStatus::Done { .. } => (ProductionState::STATUS_DONE, late(order)),
        ProductionStatus::Cancelled { inside: 0, .. } => (ProductionState::STATUS_CANCELLED, "cancelled".to_owned()),
        ProductionStatus::Cancelled { inside, .. } => {
            (ProductionState::STATUS_CANCELLED, format!("cancelled, {} still in the cell", parts(*inside)))
        }
        ProductionStatus::Withdrawn => (ProductionState::STATUS_WITHDRAWN, "withdrawn".to_owned()),
    };
    ProductionState {
        id: order.id.0,
        name: order.request.name.clone(),
        product: order.request.product.clone(),
        quantity: order.request.quantity,
        entered: order.entered,
        done: order.done,
        lost: order.lost,
        status: number,
        text: fitting(text),
        due: order.request.due.map(time).unwrap_or_default(),
        ended: order.ended.map(time).unwrap_or_default(),
    }
}

fn late(order: &ProductionOrder) -> String {
    match order.lateness() {
        Some(micros) if micros > 0 => format!("done, {} s late", micros / 1_000_000),
        Some(_) | None => "done".to_owned(),
    }
}
