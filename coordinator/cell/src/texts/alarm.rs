//! Alarms of a cell: what failed, how the stations stand, and what to answer.

use std::fmt::Write;

use linewright_line::{StationId, Tick};
use linewright_orders::TaskFailure;

use crate::exception::{
    Alarm, AlarmSubject, LeadDirection, LeadReason, RecoveryDecision, RecoveryPolicy, SensorMismatch, StationsToLead,
    Strategy, Whereabouts,
};
use crate::firing::{OngoingActivity, OngoingOrder, OrderProgress};
use crate::ids::{ModeId, PartId, ResourceId};
use crate::player::Coordination;
use crate::record::{ActivityFailure, OrderFailure};
use crate::state::PlayerState;
use crate::texts::limit;
use crate::texts::resource::{difference, refused_there};
pub use crate::texts::standing::StationStanding;

/// The answer that a resource is as the model has it.
pub(crate) const UP: &str = "up";
/// The answer that the part which a resource should have was removed.
pub(crate) const GONE: &str = "gone";

/// An alarm of an activity that failed, as its stations stand now: the text of its rule, and the facts.
pub(crate) fn alarm(of: &Coordination, firing: &OngoingActivity, cause: ActivityFailure, now: Tick) -> String {
    let state = of.state();
    let handling = state.table().handling();
    let tell = handling.rule(firing.mode, cause).map(|rule| filled(&rule.tell, state, firing.mode, firing.part));
    // The usual text names the activity, and those that are to be led stand between two rests: once is enough.
    let activity = tell.as_ref().map(|_| state.table().called(firing.mode));
    let tell = tell.unwrap_or_else(|| {
        let part = firing.part.map(|part| super::part(state, part));
        AlarmText::Failed { activity: state.table().called(firing.mode), part: part.as_deref() }.text()
    });
    let StationsToLead { lead, reset, reason, at_order: _ } = of.stations_to_lead(now, firing);
    let facts = facts(of, firing, cause, now, (activity, &lead));
    let names = |ids: Vec<StationId>| -> Vec<String> { ids.into_iter().map(|id| handling.station_name(id)).collect() };
    let (held, stopped) = (names(lead), names(reset));
    let text = AlarmText::WithFacts { tell: &tell, facts: &facts }.text();
    if held.is_empty() {
        text
    } else {
        let why = reason.map(|reason| (reason.direction(), because(handling, reason)));
        let why = why.as_ref().map(|(direction, because)| (*direction, because.as_str()));
        AlarmText::LeadFirst { stopped: &stopped, stations: &held, why, then: &text }.text()
    }
}

/// Why the stations of a failed activity are led on, or back.
pub fn because(handling: &RecoveryPolicy, reason: LeadReason) -> String {
    match reason {
        LeadReason::Completed(station) => AlarmText::Completed { station: &handling.station_name(station) }.text(),
        LeadReason::LedToEnd(station) => AlarmText::AtEnd { station: &handling.station_name(station) }.text(),
        LeadReason::AtBeginning(station) => AlarmText::AtBeginning { station: &handling.station_name(station) }.text(),
        LeadReason::OnlyDone => AlarmText::OnlyDone.text(),
        LeadReason::OnlyBefore => AlarmText::OnlyBefore.text(),
    }
}

/// The alarm again, behind what was found after an answer.
pub(crate) fn again(finding: &str, alarm: &str) -> String {
    if finding.is_empty() { alarm.to_owned() } else { format!("{finding} {alarm}") }
}

/// Facts: `load M1: m1: time limit exceeded, after 26 s; robot: order done`. Of a station at a rest, or to be led to one, nothing is to be
/// known beside that.
fn facts(
    of: &Coordination,
    firing: &OngoingActivity,
    cause: ActivityFailure,
    now: Tick,
    (activity, led): (Option<&str>, &[StationId]),
) -> String {
    let state = of.state();
    let handling = state.table().handling();
    let failed_after = state.exceptions().trouble(firing.id).map_or(now, |trouble| trouble.since).since(firing.began);
    let mut text = AlarmText::Facts {
        activity,
        cause: &cause_of(of, firing, cause),
        seconds: failed_after.as_millis() as f64 / 1e3,
    }
    .text();
    // Writing to a string does not fail.
    if let Some(repeated) = limit::repeated(state, handling, firing, cause) {
        let _ = write!(text, "; {repeated}");
    }
    let first = match cause {
        ActivityFailure::Order { key, .. } => Some(key),
        ActivityFailure::TimedOut | ActivityFailure::ByHand { .. } => None,
    };
    for order in firing.orders.iter().filter(|order| Some(order.key) != first) {
        if let OrderProgress::Failed(failure) = order.state
            && is_told(failure)
        {
            let of_another = first.is_some() || matches!(cause, ActivityFailure::ByHand { .. });
            let left = of_another.then(|| left_waiting(of, firing, order, failure)).flatten();
            let _ = write!(text, "; {}", left.unwrap_or_else(|| order_failed(of, firing, order, failure)));
        }
    }
    let mut joint = ";";
    for order in &firing.orders {
        let standing = of.standing_now(now, firing.id, order);
        let is_plain = match standing {
            StationStanding::AtRest => true,
            StationStanding::Held => led.contains(&order.station),
            _ => false,
        };
        if is_plain {
            continue;
        }
        let _ = write!(text, "{joint} {}: {}", handling.station_name(order.station), standing.text());
        joint = ",";
    }
    let others = state.exceptions().stopped().filter(|id| firing.orders.iter().all(|order| order.station != *id));
    for station in others {
        let _ = write!(text, "{joint} {}: {}", handling.station_name(station), StationStanding::EmergencyStop.text());
        joint = ",";
    }
    text
}

/// Reason why an activity failed, with the names of the description.
fn cause_of(of: &Coordination, firing: &OngoingActivity, cause: ActivityFailure) -> String {
    let handling = of.state().table().handling();
    match cause {
        ActivityFailure::TimedOut => cause.text_of("a station", "?"),
        ActivityFailure::ByHand { resource } => cause.text_of("a station", handling.resource_name(resource)),
        ActivityFailure::Order { key, failure } => match firing.orders.iter().find(|order| order.key == key) {
            Some(order) => order_failed(of, firing, order, failure),
            None => cause.text_of("a station", "?"),
        },
    }
}

/// Whether a failure tells more than how its station stands: that an order was left or was not begun, the other one's failure causes.
fn is_told(failure: OrderFailure) -> bool {
    match failure {
        OrderFailure::Code(code) => {
            ![TaskFailure::Cancelled, TaskFailure::Held, TaskFailure::Stopped].contains(&TaskFailure::from_code(code))
        }
        OrderFailure::TimedOut | OrderFailure::Lost | OrderFailure::DevicesLost => true,
        OrderFailure::Refused(_) | OrderFailure::Forgotten => false,
    }
}

/// Failure of an order with the names of its station and of the inputs that were waited for.
fn order_failed(of: &Coordination, firing: &OngoingActivity, order: &OngoingOrder, failure: OrderFailure) -> String {
    let text = failure.text_of(&of.state().table().handling().station_label(order.station));
    if failure == OrderFailure::TimedOut {
        return limit::time(of.state(), firing, order, &text);
    }
    let detail = awaited(of, firing, order, failure)
        .or_else(|| fault_of_order(of, firing, order, failure))
        .or_else(|| refused_there(of, firing, order.station, failure));
    detail.map_or_else(|| text.clone(), |detail| AlarmText::Because { failure: &text, detail: &detail }.text())
}

/// The fault text of an order's station, where the order has ended by a fault of the station; none otherwise. It is that of the moment in
/// which the station had come to rest; until then, the present one.
fn fault_of_order(
    of: &Coordination,
    firing: &OngoingActivity,
    order: &OngoingOrder,
    failure: OrderFailure,
) -> Option<String> {
    if failure != OrderFailure::Code(TaskFailure::Fault.code()) {
        return None;
    }
    let kept =
        of.state().exceptions().trouble(firing.id).and_then(|trouble| {
            trouble.faults.iter().find(|(key, _)| *key == order.key).map(|(_, fault)| fault.as_str())
        });
    let fault = kept.unwrap_or_else(|| of.station_fault(order.station));
    (!fault.is_empty()).then(|| fault.to_owned())
}

/// The same where the order was left because of another one's failure: no time was over.
fn left_waiting(
    of: &Coordination,
    firing: &OngoingActivity,
    order: &OngoingOrder,
    failure: OrderFailure,
) -> Option<String> {
    let OrderFailure::Code(code) = failure else { return None };
    let TaskFailure::Waiting(_) = TaskFailure::from_code(code) else { return None };
    let station = of.state().table().handling().station_label(order.station);
    let inputs = awaited(of, firing, order, failure);
    Some(AlarmText::LeftWaiting { station: &station, inputs: inputs.as_deref(), code }.text())
}

/// The inputs that an order waited for when it failed; of several those that are off now.
fn awaited(of: &Coordination, firing: &OngoingActivity, order: &OngoingOrder, failure: OrderFailure) -> Option<String> {
    let (state, station) = (of.state(), order.station);
    let handling = state.table().handling();
    // Its orders are those of the activity, in their order.
    let at = firing.orders.iter().position(|of| of.key == order.key);
    let task = at.and_then(|at| state.table().activity(firing.mode).orders.get(at)).map(|of| &*of.task);
    match failure {
        OrderFailure::Code(code) => {
            task.and_then(|task| handling.awaited(station, task, code, of.awaited_off(station)))
        }
        OrderFailure::Refused(_)
        | OrderFailure::TimedOut
        | OrderFailure::Forgotten
        | OrderFailure::Lost
        | OrderFailure::DevicesLost => None,
    }
}

/// For each answer that an alarm permits, in their order: what becomes of the activity, and where its part is then. Empty for an answer
/// that no rule has.
pub fn meanings(of: &Coordination, alarm: &Alarm) -> Vec<String> {
    let state = of.state();
    let (handling, rulings) = (state.table().handling(), of.rulings(alarm.id));
    let mode = match alarm.about {
        AlarmSubject::Firing(firing) => state.firing(firing).map(|firing| handling.mode(firing.mode)),
        AlarmSubject::Resource(_) => None,
    };
    let name = |id: Option<ResourceId>| id.map_or("outside", |id| handling.resource_name(id));
    let meaning = |word: &String| match (rulings.iter().find(|ruling| ruling.word == *word), mode) {
        (Some(ruling), Some(mode)) => {
            let at = match ruling.part {
                Whereabouts::From => AlarmText::PartAt { place: name(mode.from) },
                Whereabouts::To => AlarmText::PartAt { place: name(mode.to) },
                Whereabouts::Carrier => AlarmText::PartAt { place: name(mode.carrier) },
                Whereabouts::Gone => AlarmText::PartGone,
            };
            AlarmText::Meaning { part: ruling.part, then: ruling.then, at: &at.text() }.text()
        }
        _ if word == UP => AlarmText::MeansUp.text(),
        _ if word == GONE => AlarmText::PartGone.text(),
        _ => String::new(),
    };
    alarm.words.iter().map(meaning).collect()
}

/// What was found when an answer was compared: sensors contradict it.
pub(crate) fn differs(state: &PlayerState, ruling: &RecoveryDecision, found: &[SensorMismatch]) -> String {
    let handling = state.table().handling();
    let found: Vec<String> = found.iter().map(|found| difference(handling, found)).collect();
    AlarmText::Contradicted { word: &ruling.word, found: &found.join("; ") }.text()
}

/// The same of a station that moved after the answer.
pub(crate) fn moved(state: &PlayerState, ruling: &RecoveryDecision, station: StationId) -> String {
    let name = state.table().handling().station_name(station);
    AlarmText::Moved { station: &name, word: &ruling.word }.text()
}

/// The same of a station that went into manual by itself after the answer.
pub(crate) fn led_by_hand(state: &PlayerState, ruling: &RecoveryDecision, station: StationId) -> String {
    let name = state.table().handling().station_name(station);
    AlarmText::LedByHand { station: &name, word: &ruling.word }.text()
}

/// Whether an alarm says that the answer with this word was not taken.
pub fn takes_back(text: &str, word: &str) -> bool {
    let contradicted = AlarmText::Contradicted { word, found: "" }.text();
    let by_a_station = [AlarmText::Moved { station: "", word }, AlarmText::LedByHand { station: "", word }];
    text.starts_with(contradicted.trim_end_matches('.')) || by_a_station.iter().any(|of| text.contains(&of.text()))
}

/// The carrier holds the part.
pub(crate) fn carried(state: &PlayerState, mode: ModeId, of: Option<PartId>) -> String {
    filled(&AlarmText::Carried.text(), state, mode, of)
}

/// The sentences of alarms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlarmText<'a> {
    /// An activity failed, and its rule has no text.
    Failed { activity: &'a str, part: Option<&'a str> },
    /// Instruction, and the facts.
    WithFacts { tell: &'a str, facts: &'a str },
    /// Stations between two rests, those of them in an emergency stop of their own; the alarm follows.
    LeadFirst { stopped: &'a [String], stations: &'a [String], why: Option<(LeadDirection, &'a str)>, then: &'a str },
    /// A station whose order is completed: the others are led on.
    Completed { station: &'a str },
    /// A station that was led to the end of its task.
    AtEnd { station: &'a str },
    /// A station that has not begun, or has gone back: the others are led back.
    AtBeginning { station: &'a str },
    /// No answer leaves the part where it was.
    OnlyDone,
    /// No answer has the part where it was to go.
    OnlyBefore,
    /// Meaning of an answer: where the part is, and what becomes of its activity.
    Meaning { part: Whereabouts, then: Strategy, at: &'a str },
    /// Where the part is by an answer.
    PartAt { place: &'a str },
    /// The part is no more.
    PartGone,
    /// The resource is as the model has it.
    MeansUp,
    /// The facts of a failed activity, with its name where nothing before has it; how its stations stand follows.
    Facts { activity: Option<&'a str>, cause: &'a str, seconds: f64 },
    /// A failure with its cause: the inputs that did not come, or the fault text of the station.
    Because { failure: &'a str, detail: &'a str },
    /// An order that was left while it waited for inputs, since another one had failed.
    LeftWaiting { station: &'a str, inputs: Option<&'a str>, code: u16 },
    /// Sensors contradict an answer; the alarm follows again.
    Contradicted { word: &'a str, found: &'a str },
    /// A station moved after an answer; the alarm follows again.
    Moved { station: &'a str, word: &'a str },
    /// A station went into manual by itself after an answer, before the sensors were read.
    LedByHand { station: &'a str, word: &'a str },
    /// The carrier holds the part; with placeholders.
    Carried,
    /// A sensor contradicts the model; a part that is missing may have been removed; a station that is closed on a part that is not in the
    /// model has to be brought to another rest first.
    Mismatch { found: &'a str, missing: Option<&'a str>, bring: Option<&'a str> },
    /// A missing part is given up.
    PartGivenUp { resource: &'a str },
    /// The same, and why its resource cannot be counted on.
    GivenUp { found: &'a str, resource: &'a str, why: &'a str },
    /// A station that stands at another rest than its next task begins at, and how it is brought there.
    WrongRest {
        resource: &'a str,
        station: &'a str,
        stands: &'a str,
        wanted: &'a str,
        next: &'a str,
        has_part: bool,
        bring: &'a str,
    },
    /// A station that stands at another rest than the task of an order begins at.
    OtherRest { station: &'a str, stands: &'a str, wanted: &'a str, bring: &'a str },
    /// The button and the task of a way to a rest, and whether that waits for inputs; and the button that takes back the task that has led
    /// away from there.
    Bring {
        station: &'a str,
        wanted: &'a str,
        way: Option<(&'a str, &'a str, bool)>,
        back: Option<(&'a str, &'a str)>,
        too: &'a [String],
    },
    /// Another station that a button moves.
    MovesToo { button: &'a str, station: &'a str },
    /// What an alarm of a resource was about is so no longer.
    Agrees { resource: &'a str },
    /// A sensor that should be on.
    PartMissing { resource: &'a str },
    /// A sensor that should be off.
    PartUnexpected { resource: &'a str },
}

impl AlarmText<'_> {
    pub fn text(self) -> String {
        match self {
            AlarmText::Failed { activity, part: Some(part) } => {
                format!("{activity} with {part} failed. Answer where the part is.")
            }
            AlarmText::Failed { activity, part: None } => format!("{activity} failed. Answer where the part is."),
            AlarmText::WithFacts { tell, facts } => format!("{tell} ({facts})"),
            AlarmText::LeadFirst { stopped, stations, why, then } => {
                let reset: Vec<String> =
                    stopped.iter().map(|name| format!("`linewright resource … {name} reset`")).collect();
                let reset = if reset.is_empty() { String::new() } else { format!("{}, then ", reset.join(" and ")) };
                let lead = match why {
                    Some((LeadDirection::On, because)) => {
                        format!(": to the end of the task if there is a way, since {because}")
                    }
                    Some((LeadDirection::Back, because)) => {
                        format!(": back to where the task began if there is a way, since {because}")
                    }
                    None if stations.len() > 1 => ": all to the end or all back".to_owned(),
                    None => String::new(),
                };
                // Which way presses lead is found by a search, which is not done here.
                format!(
                    "First {reset}lead {} to a rest in manual, as `linewright recover` lists it{lead}. {then}",
                    stations.join(" and ")
                )
            }
            AlarmText::Completed { station } => format!("{station} has completed its order"),
            AlarmText::AtEnd { station } => format!("{station} stands at the end of its task"),
            AlarmText::AtBeginning { station } => format!("{station} stands where its order began"),
            AlarmText::OnlyDone => "no answer leaves the part where it was".to_owned(),
            AlarmText::OnlyBefore => "no answer has the part where it was to go".to_owned(),
            AlarmText::Meaning { part: Whereabouts::Carrier | Whereabouts::Gone, then: _, at } => at.to_owned(),
            AlarmText::Meaning { part: _, then, at } => match then {
                Strategy::Forward => format!("done, {at}"),
                Strategy::Backward => format!("not done, {at}"),
                Strategy::Redo => format!("once more, {at}"),
            },
            AlarmText::PartAt { place } => format!("part at {place}"),
            AlarmText::PartGone => "part gone".to_owned(),
            AlarmText::MeansUp => "as the model has it".to_owned(),
            AlarmText::Facts { activity, cause, seconds } => {
                let activity = activity.map(|activity| format!("{activity}: ")).unwrap_or_default();
                format!("{activity}{cause}, after {} s", limit::tenths(seconds))
            }
            AlarmText::Because { failure, detail } => format!("{failure}: {detail}"),
            AlarmText::LeftWaiting { station, inputs, code } => {
                let inputs = inputs.unwrap_or("an input");
                format!("{station}: its order was ended while it waited for {inputs} (code {code})")
            }
            AlarmText::Contradicted { word, found } => format!("Answer \"{word}\" contradicts the sensors: {found}."),
            AlarmText::Moved { station, word } => format!("{station} moved after the answer \"{word}\"."),
            AlarmText::LedByHand { station, word } => {
                format!("{station} went into manual after the answer \"{word}\". Give it auto again, then answer.")
            }
            AlarmText::Agrees { resource } => {
                format!(
                    "{resource} is out of service, but its station and sensor are as they should be. Answer \"{UP}\"."
                )
            }
            AlarmText::Carried => {
                "{carrier} holds part {part}. Move it to {to} or back to {from}, then answer which.".to_owned()
            }
            AlarmText::Mismatch { found, bring: Some(bring), .. } => {
                format!("{found}. {bring} Take the part out, then answer \"{UP}\".")
            }
            AlarmText::Mismatch { found, missing: None, .. } => format!("{found}. Correct it, then answer \"{UP}\"."),
            AlarmText::Mismatch { found, missing: Some(part), .. } => {
                format!("{found}. Correct it, then answer \"{UP}\"; if {part} was removed, answer \"{GONE}\".")
            }
            AlarmText::PartGivenUp { resource } => format!("The part of {resource} is given up."),
            AlarmText::GivenUp { found, resource, why } => {
                format!("{found} {resource} stays out of service: {why}. When that is put right, answer \"{UP}\".")
            }
            AlarmText::WrongRest { resource, station, stands, wanted, next, has_part, bring } => {
                let part = if has_part { "a part" } else { "no part" };
                format!(
                    "{station} stands at rest \"{stands}\", but {resource} has {part}, and {next} begins at \"{wanted}\": {resource} \
                     is not used. {bring} Then answer \"{UP}\"."
                )
            }
            AlarmText::OtherRest { station, stands, wanted, bring } => {
                format!("{station} stands at rest \"{stands}\", and its task begins at \"{wanted}\". {bring}")
            }
            AlarmText::Bring { station, wanted, way, back, too } => {
                let back =
                    back.map(|(button, task)| format!("{button} (takes task \"{task}\" back, if that was the last)"));
                let way = match (way, back) {
                    (Some((button, task, false)), _) => format!("in hand mode hold {button} (task \"{task}\")"),
                    (Some((button, task, true)), back) => {
                        let back = back.map(|back| format!("{back}, or ")).unwrap_or_default();
                        format!("in hand mode hold {back}{button} (task \"{task}\", which waits for inputs)")
                    }
                    (None, Some(back)) => format!("in hand mode hold {back}"),
                    (None, None) => "in hand mode run the tasks that lead there".to_owned(),
                };
                let too = too.iter().map(|too| format!(" {too}.")).collect::<String>();
                format!("Bring {station} to \"{wanted}\": {way} (stop, wait for the standstill, start, hand).{too}")
            }
            AlarmText::MovesToo { button, station } => format!("{button} moves {station} too"),
            AlarmText::PartMissing { resource } => format!("{resource}: part expected, sensor off"),
            AlarmText::PartUnexpected { resource } => format!("{resource}: no part expected, sensor on"),
        }
    }
}

/// A text with the names in braces replaced.
fn filled(text: &str, state: &PlayerState, mode: ModeId, of: Option<PartId>) -> String {
    let handling = state.table().handling();
    let handled = handling.mode(mode);
    let name =
        |id: Option<ResourceId>| id.map_or_else(|| "outside".to_owned(), |id| handling.resource_name(id).to_owned());
    let (mut filled, mut rest) = (String::with_capacity(text.len()), text);
    while let Some((before, behind)) = rest.split_once('{') {
        let Some((word, after)) = behind.split_once('}') else { break };
        filled.push_str(before);
        match word {
            // The text has "part" before it.
            "part" => filled.push_str(&of.map_or_else(|| "?".to_owned(), |part| super::part::number(state, part))),
            "type" => filled.push_str(&handled.part_type),
            "activity" => filled.push_str(state.table().called(mode)),
            "carrier" => filled.push_str(&name(handled.carrier)),
            "from" => filled.push_str(&name(handled.from)),
            "to" => filled.push_str(&name(handled.to)),
            "slot" => {
                let of = of.and_then(|part| state.part(part));
                let slot = of.and_then(|part| part.position.or(part.target));
                filled.push_str(&slot.map_or_else(|| "?".to_owned(), |slot| slot.to_string()));
            }
            other => {
                // A description with such a name is refused.
                let _ = write!(filled, "{{{other}}}");
            }
        }
        rest = after;
    }
    filled + rest
}
