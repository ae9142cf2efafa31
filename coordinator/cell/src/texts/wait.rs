//! Reasons why a part does not go on, and places of the tokens it lacks.

use linewright_line::StationId;

use crate::exception::{AlarmAnswerRefusal, ExceptionStage, ResourceRequest};
use crate::ids::{AlarmId, PartId};
use crate::table::CellTable;

/// Reason why a part, or an activity with it, does not go on; with the names that the text contains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellWait<'a> {
    /// There is no such part.
    NotInCell(PartId),
    /// The part is in an activity.
    UnderWay { part: &'a str, activity: &'a str },
    /// The part rests, `in` a resource or `on` a place.
    Resting { part: &'a str, place: &'a str, seconds: f64 },
    /// No activity takes the part.
    NoWay,
    /// An activity that could take the part, and why it does not.
    Activity { activity: &'a str, why: &'a str },
    /// Another part is taken first.
    First(&'a str),
    /// Tokens are missing; where they are. Before, how many seconds ago, it was held for a reason.
    Tokens { owners: &'a str, held: Option<(f64, &'a str)> },
    /// All servers are in use.
    InProgress,
    /// Nothing is missing.
    Ready,
    /// The sensor of a resource was not compared with the model yet.
    Uncompared { resource: &'a str },
    /// A resource is out of service.
    OutOfService { resource: &'a str, seconds: f64, why: &'a str },
    /// A resource is not out of service.
    InService { resource: &'a str },
    /// The station of a resource in service has an order of an activity that failed: the mode of the line is without it.
    Failed,
    /// How a resource is counted on again that nothing keeps out of service.
    ToCountOn { resource: &'a str },
    /// What a resource takes part in.
    TakesPart { activity: &'a str },
}

impl CellWait<'_> {
    pub fn text(self) -> String {
        match self {
            CellWait::NotInCell(part) => format!("{part} is not in the cell."),
            CellWait::UnderWay { part, activity } => format!("{part} is under way: {activity}."),
            CellWait::Resting { part, place, seconds } => format!("{part} has been {place} for {seconds} s."),
            CellWait::NoWay => "No activity takes it from there.".to_owned(),
            CellWait::Activity { activity, why } => format!("{activity}: {why}."),
            CellWait::First(part) => format!("{part} has to be taken first"),
            CellWait::Tokens { owners, held: None } => owners.to_owned(),
            CellWait::Tokens { owners, held: Some((ago, why)) } => {
                format!("{owners}; held {ago} s ago: {why}")
            }
            CellWait::InProgress => "maximum number in progress".to_owned(),
            CellWait::Ready => "ready; starts in auto, when states of all its stations are received".to_owned(),
            CellWait::Uncompared { resource } => {
                format!(
                    "{resource}: its presence sensor is compared with the model first, after a restart and where it differs when an \
                     activity has ended"
                )
            }
            CellWait::OutOfService { resource, seconds, why } => {
                format!("{resource} out of service for {seconds} s: {why}")
            }
            CellWait::InService { resource } => format!("{resource} in service"),
            CellWait::Failed => {
                "An activity of its station failed: the line works without that station, which is given no work until the alarm \
                 is answered."
                    .to_owned()
            }
            CellWait::ToCountOn { resource } => format!("Nothing is against it now: `up` counts on {resource} again."),
            CellWait::TakesPart { activity } => format!("It takes part in {activity}."),
        }
    }
}

/// Place of tokens that something needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenOwner<'a> {
    /// With activities in progress.
    InUse { name: &'a str, by: &'a [String] },
    /// Activities give them that have not started.
    Returned { name: &'a str, by: &'a [String] },
    /// Activities give them, and no part waits for one.
    NotYet { name: &'a str },
    /// No activity gives them.
    Never { name: &'a str },
}

impl TokenOwner<'_> {
    pub fn text(self) -> String {
        match self {
            TokenOwner::InUse { name, by } => format!("`{name}` in use by {}", by.join(", and by ")),
            TokenOwner::Returned { name, by } => {
                format!("`{name}` is returned by {}, not started yet", by.join(", or by "))
            }
            TokenOwner::NotYet { name } => format!("no `{name}` yet"),
            TokenOwner::Never { name } => format!("no `{name}`, and no activity gives it"),
        }
    }
}

/// Remainder of an activity in progress.
pub(crate) fn remaining(activity: &str, seconds: f64) -> String {
    if seconds > 0.0 { format!("{activity}, {seconds} s left") } else { format!("{activity}, longer than planned") }
}

/// The station that keeps an activity from starting, and why.
pub(crate) fn unready(table: &CellTable, why: AlarmAnswerRefusal) -> String {
    let name = |station: StationId| {
        let known = table.handling().stations.iter().find(|(id, _)| *id == station);
        known.map_or_else(|| format!("station {}", station.0), |(_, name)| name.to_string())
    };
    match why {
        AlarmAnswerRefusal::Moves(station) => format!("{}: still at another task order", name(station)),
        // Its other reasons are about resources and answers; none of them keeps a station from an order.
        _ => why.text(ResourceRequest::Answer(AlarmId(0)), name, |_| String::new(), |_| String::new()),
    }
}

/// The wait of a failed activity: the next step of its recovery.
pub fn recovery(stage: Option<&ExceptionStage>) -> String {
    match stage {
        Some(ExceptionStage::Securing) => "its stations to come to rest".to_owned(),
        Some(ExceptionStage::Waiting(alarm)) => format!("an answer to {alarm}"),
        Some(ExceptionStage::Restoring { .. }) => "sensors to confirm the answer".to_owned(),
        None => "an operator".to_owned(),
    }
}

/// A failed activity, and what it waits for.
pub fn failed(activity: &str, stage: Option<&ExceptionStage>) -> String {
    format!("{activity}, which has failed and waits for {}", recovery(stage))
}
