//! Reasons why an operator's answer or request about a resource is not accepted.

use linewright_line::{Line, StationId};

use crate::exception::{AlarmAnswerRefusal, AlarmSubject, ResourceRequest, StationUnavailable};
use crate::ids::{AlarmId, ResourceId};
use crate::rehearsal::AnswerVerdict;
use crate::state::PlayerState;
use crate::texts::resource::difference;

/// The reason, with the names of the description.
pub fn answer_refused(line: &Line, state: &PlayerState, asked: ResourceRequest, why: AlarmAnswerRefusal) -> String {
    let station = |id: StationId| line.station(id).name.clone();
    let resource = |id: ResourceId| state.table().handling().resource_name(id).to_owned();
    let answers = |request| {
        let alarm = state.exceptions().alarms().find(|alarm| request == ResourceRequest::Answer(alarm.id));
        alarm.map(|alarm| alarm.words.join(", ")).unwrap_or_default()
    };
    why.text(asked, station, resource, answers)
}

/// Whether sensors confirm an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerFit {
    Fits,
    /// No sensor sees what it claims.
    NotMeasured,
    /// A station whose sensors would show it is not received.
    NotKnown,
    Contradicts,
    /// It would be refused if it were given now.
    Refused,
}

/// What the newest reports of sensors say of an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnswerRemark {
    pub fit: AnswerFit,
    /// Where to look, which station is not received, the sensors that contradict it, or why it is refused; empty where it fits.
    pub why: String,
}

/// A permitted answer to an alarm, as operators read it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedAnswer {
    pub word: String,
    /// Effect of the answer on its activity, and the place of the part afterwards; empty if unknown.
    pub meaning: String,
    /// None where sensors say nothing of it.
    pub remark: Option<AnswerRemark>,
}

/// An answer of which nothing more is known.
impl From<&str> for ListedAnswer {
    fn from(word: &str) -> Self {
        ListedAnswer { word: word.to_owned(), meaning: String::new(), remark: None }
    }
}

impl ListedAnswer {
    /// Those that fit the sensors first, what would not be taken last; else as they are.
    pub fn in_order(mut answers: Vec<ListedAnswer>) -> Vec<ListedAnswer> {
        answers.sort_by_key(|answer| match answer.remark.as_ref().map(|remark| remark.fit) {
            Some(AnswerFit::Fits) => 0,
            Some(AnswerFit::NotMeasured | AnswerFit::NotKnown) | None => 1,
            Some(AnswerFit::Contradicts | AnswerFit::Refused) => 2,
        });
        answers
    }

    /// Whether sensors say otherwise now.
    pub fn is_contradicted(&self) -> bool {
        self.remark.as_ref().is_some_and(|remark| remark.fit == AnswerFit::Contradicts)
    }

    /// The answer, with its meaning and the remark in parentheses.
    pub fn text(&self) -> String {
        let remark = self.remark.as_ref().map(AnswerRemark::text).unwrap_or_default();
        let known: Vec<&str> = [self.meaning.as_str(), &remark].into_iter().filter(|of| !of.is_empty()).collect();
        if known.is_empty() { self.word.clone() } else { format!("{} ({})", self.word, known.join("; ")) }
    }
}

impl AnswerRemark {
    /// Of an answer to an alarm behind so many others that its answers are not compared yet.
    pub fn behind_others() -> Self {
        let why = "compared with the sensors when earlier alarms are answered".to_owned();
        AnswerRemark { fit: AnswerFit::NotKnown, why }
    }

    fn text(&self) -> String {
        match self.fit {
            AnswerFit::Fits => "fits the sensors".to_owned(),
            AnswerFit::NotMeasured => format!("not measured: {}", self.why),
            AnswerFit::NotKnown => format!("not known: {}", self.why),
            AnswerFit::Contradicts => format!("contradicts the sensors: {}", self.why),
            AnswerFit::Refused => format!("refused now: {}", self.why),
        }
    }

    /// The remark that follows from the verdict on an answer; none where sensors say nothing of it.
    pub fn of(line: &Line, state: &PlayerState, alarm: AlarmId, verdict: &AnswerVerdict) -> Option<Self> {
        let handling = state.table().handling();
        let about = state.exceptions().alarm(alarm).map(|alarm| alarm.about);
        let is_of_resource = matches!(about, Some(AlarmSubject::Resource(_)));
        let (fit, why) = match verdict {
            AnswerVerdict::Taken { unseen } if unseen.is_empty() => (AnswerFit::Fits, String::new()),
            AnswerVerdict::Taken { unseen } => {
                let names: Vec<&str> = unseen.iter().map(|&id| handling.resource_name(id)).collect();
                (AnswerFit::NotMeasured, format!("look at {}", names.join(" and ")))
            }
            AnswerVerdict::WorkUnseen { at } => {
                let name = handling.resource_name(*at);
                let why = format!("whether it was worked on; the sensor of {name} sees the part, look at it");
                (AnswerFit::NotMeasured, why)
            }
            AnswerVerdict::Open { silent } if !silent.is_empty() => {
                let names: Vec<&str> = silent.iter().map(|&id| line.station(id).name.as_str()).collect();
                let text = "start it again, or look at its host and network";
                (AnswerFit::NotKnown, format!("no state received from {}; {text}", names.join(" and ")))
            }
            AnswerVerdict::Contradicted(found) => {
                let found: Vec<String> = found.iter().map(|of| difference(handling, of)).collect();
                (AnswerFit::Contradicts, found.join(", "))
            }
            AnswerVerdict::Refused(
                why @ (AlarmAnswerRefusal::HasPart(_)
                | AlarmAnswerRefusal::HasNoPart(_)
                | AlarmAnswerRefusal::Contradicted(_)
                | AlarmAnswerRefusal::WrongRest(_)
                | AlarmAnswerRefusal::NotHeard(_)
                | AlarmAnswerRefusal::Unheard(..)),
            ) => (AnswerFit::Refused, answer_refused(line, state, ResourceRequest::Answer(alarm), *why)),
            // What is so of every answer is in the text of the alarm of an activity, which names the stations; of a resource it is not.
            AnswerVerdict::Refused(why) if is_of_resource => {
                (AnswerFit::Refused, answer_refused(line, state, ResourceRequest::Answer(alarm), *why))
            }
            AnswerVerdict::Refused(_) | AnswerVerdict::Open { .. } => return None,
        };
        Some(AnswerRemark { fit, why })
    }
}

impl AlarmAnswerRefusal {
    /// The reason, with the names of stations and resources, and the answers that are permitted.
    pub fn text(
        self,
        asked: ResourceRequest,
        station: impl Fn(StationId) -> String,
        resource: impl Fn(ResourceId) -> String,
        answers: impl Fn(ResourceRequest) -> String,
    ) -> String {
        let is_reset = matches!(asked, ResourceRequest::Reset(_));
        match self {
            AlarmAnswerRefusal::NoSuchAlarm => match asked {
                ResourceRequest::Answer(alarm) => format!("no active {alarm}"),
                ResourceRequest::Alarm(_)
                | ResourceRequest::Down(_)
                | ResourceRequest::Up(_)
                | ResourceRequest::Reset(_) => "no such alarm".to_owned(),
            },
            AlarmAnswerRefusal::NoSuchWord => format!("not a permitted answer; permitted: {}", answers(asked)),
            AlarmAnswerRefusal::NoSuchResource => "no such resource".to_owned(),
            AlarmAnswerRefusal::AlreadySo if is_reset => "not in emergency stop of its own".to_owned(),
            AlarmAnswerRefusal::AlreadySo => "already in that state".to_owned(),
            AlarmAnswerRefusal::Moves(id) if is_reset => format!("{}: standstill not confirmed", station(id)),
            AlarmAnswerRefusal::Moves(id) => {
                format!(
                    "{} is still at an order, which it ends by itself in auto; wait for standstill, check where the part is, then answer",
                    station(id)
                )
            }
            AlarmAnswerRefusal::HasPart(id) => {
                format!("{}: sensor on, but the answer states no part there", resource(id))
            }
            AlarmAnswerRefusal::HasNoPart(id) => {
                format!("{}: sensor off, but the answer states a part there", resource(id))
            }
            AlarmAnswerRefusal::NotHeard(id) => format!("{}: no state received", station(id)),
            AlarmAnswerRefusal::Unheard(id, of) => {
                let (station, resource) = (station(id), resource(of));
                format!(
                    "{station}: no state received, so it may stand anywhere; bring it back, then answer; or first take {resource} \
                     out of service (down), which leaves out all resources of the activity"
                )
            }
            AlarmAnswerRefusal::NotAtRest(id) => {
                format!("{}: between two rests; lead it to a rest in manual", station(id))
            }
            AlarmAnswerRefusal::WrongRest(id) => {
                format!("{}: its station stands at another rest; do what its alarm says, then answer", resource(id))
            }
            AlarmAnswerRefusal::Contradicted(id) => {
                format!("{}: its sensor contradicts the model; do what its alarm says, then answer", resource(id))
            }
            AlarmAnswerRefusal::CannotWork(id, why) => format!("{}: {}", station(id), why.text()),
            AlarmAnswerRefusal::EmergencyStop(id) => {
                let name = station(id);
                format!("{name}: in emergency stop; clear the cause, then `linewright resource … {name} reset`")
            }
            AlarmAnswerRefusal::Open(id) => {
                format!("{}: an activity with it failed; answer that alarm first", resource(id))
            }
        }
    }
}

impl StationUnavailable {
    /// The reason.
    pub const fn text(self) -> &'static str {
        match self {
            StationUnavailable::Inactive => "its node is not active; activate it (ros2 lifecycle set)",
            StationUnavailable::Devices => "I/O devices not operational",
            StationUnavailable::Incomplete => "operation incomplete; complete or undo it in manual",
            StationUnavailable::ByHand => "moved by hand (hand or manual mode)",
            StationUnavailable::InManual => "in manual by itself; give it auto again first",
        }
    }
}
