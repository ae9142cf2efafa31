//! Decisions as sentences, with the names of the table.
//!
//! The reason of a start stands with the modes that were held; so the sentence about a start is made from the reasons
//! of those.

use std::fmt::{self, Write as _};
use std::time::Duration;

use linewright_line::Tick;

use crate::dispatch::{DispatchRule, Measure};
use crate::ids::{ModeId, PartId};
use crate::question::BadAnswer;
use crate::reason::{DecidingRule, Gain, HoldReason, LostDecision, ProgressComparison};
use crate::schedule::RevisionReason;
use crate::table::CellTable;

/// A mode by the name of its activity, and with which part; without one, with which product.
pub fn named(table: &CellTable, mode: ModeId, part: Option<PartId>) -> String {
    match (&*table.handling().mode(mode).part_type, part) {
        ("", None) | (_, Some(_)) => called(table, mode, part),
        (product, None) => format!("{} of {product}", called(table, mode, part)),
    }
}

/// A mode by the name of its activity, where its part is known.
pub fn called(table: &CellTable, mode: ModeId, part: Option<PartId>) -> String {
    // Activities of one name are numbered: `leave/2`.
    let name = table.called(mode);
    let name = name.rsplit_once('/').filter(|(_, n)| n.parse::<u32>().is_ok()).map_or(name, |(name, _)| name);
    part.map_or_else(|| format!("`{name}`"), |part| format!("`{name}` with {part}"))
}

/// Seconds for operators, in tenths.
pub(crate) fn tenths(seconds: f64) -> f64 {
    // Never minus zero.
    (seconds * 10.0).round() / 10.0 + 0.0
}

/// A time for operators, in tenths of a second.
fn moment(at: Tick) -> String {
    format!("{} s", tenths(at.as_secs_f64()))
}

fn whom(part: Option<PartId>) -> String {
    part.map_or_else(|| "a part outside".to_owned(), |part| part.to_string())
}

/// Reason why the other comes first.
fn ground(lost: &LostDecision) -> String {
    match &lost.by {
        DecidingRule::Waited => "waited longer than patience_s".to_owned(),
        DecidingRule::Helps { part } => {
            format!("clears the way for {}, which waited longer than patience_s", whom(*part))
        }
        DecidingRule::Inside => "already in the cell".to_owned(),
        DecidingRule::Rule { rule, theirs, ours } => format!("by {rule} ({theirs}; the other {ours})"),
        DecidingRule::Order if lost.with.is_some() && lost.with == lost.own => {
            "equal for the same part; described earlier".to_owned()
        }
        DecidingRule::Order => "waited longer, or lower part number".to_owned(),
    }
}

/// Advantage in a forecast.
fn leads(gain: &Gain) -> String {
    let s = |span: &Duration| tenths(span.as_secs_f64());
    match gain {
        Gain::Tardiness(by) => format!("makes parts less late, by {} s", s(by)),
        Gain::Work(by) => format!("leaves less to be done, by {} s", s(by)),
        Gain::Makespan(by) => format!("finishes all earlier, by {} s", s(by)),
        Gain::Flow(by) => format!("finishes parts earlier, by {} s in all", s(by)),
        Gain::Nothing => "is equal, and already begun".to_owned(),
    }
}

/// Reason why something was held.
pub fn reason(table: &CellTable, reason: &HoldReason) -> String {
    match reason {
        HoldReason::LostTo(lost) => {
            format!("{} goes first: {}", named(table, lost.to, lost.with), ground(lost))
        }
        HoldReason::NotYet(until) => format!("scheduled not before {}", moment(*until)),
        HoldReason::ReservedFor { part, mode } => {
            format!(
                "resources reserved for {}: {} waited longer than patience_s",
                named(table, *mode, None),
                whom(*part)
            )
        }
        HoldReason::NotOrdered => "no released production order for this product".to_owned(),
        HoldReason::PlannedOtherwise(next) => format!("scheduled next: {}", named(table, *next, None)),
        HoldReason::LooksWorse(ProgressComparison { instead, gain }) => {
            let what = instead.map_or_else(|| "waiting".to_owned(), |(mode, part)| named(table, mode, part));
            format!("looking ahead, {what} {}", leads(gain))
        }
    }
}

/// A decision: a sentence for everything that was started, and for everything that was held.
pub fn decision(table: &CellTable, started: &[(ModeId, Option<PartId>)], held: &[(ModeId, HoldReason)]) -> Vec<String> {
    let mut lines = Vec::new();
    for &(mode, part) in started {
        let mut line = format!("{} starts", named(table, mode, part));
        let lost = held.iter().filter_map(|(loser, reason)| match reason {
            HoldReason::LostTo(lost) if (lost.to, lost.with) == (mode, part) => Some((*loser, lost)),
            HoldReason::LostTo(_)
            | HoldReason::NotYet(_)
            | HoldReason::ReservedFor { .. }
            | HoldReason::NotOrdered
            | HoldReason::PlannedOtherwise(_)
            | HoldReason::LooksWorse(_) => None,
        });
        let mut joint = ",";
        for (loser, lost) in lost {
            // Writing to a string does not fail.
            let _ = write!(line, "{joint} before {}: {}", named(table, loser, lost.own), ground(lost));
            joint = ";";
        }
        if joint == "," {
            line.push_str(": no competing candidate");
        }
        lines.push(line + ".");
    }
    for (mode, why) in held {
        let own = match why {
            HoldReason::LostTo(lost) => lost.own,
            HoldReason::NotYet(_)
            | HoldReason::ReservedFor { .. }
            | HoldReason::NotOrdered
            | HoldReason::PlannedOtherwise(_)
            | HoldReason::LooksWorse(_) => None,
        };
        lines.push(format!("{} is held: {}.", named(table, *mode, own), reason(table, why)));
    }
    lines
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = tenths(self.value as f64 / 1e6);
        let when = |f: &mut fmt::Formatter<'_>, what: &str| match self.value {
            0.. => write!(f, "{what} in {seconds} s"),
            _ => write!(f, "{what} {} s ago", -seconds),
        };
        match (self.rule, self.class) {
            (DispatchRule::Fifo, 0) => write!(f, "waited {} s", tenths(-seconds)),
            (DispatchRule::Fifo, _) => f.write_str("not in the cell yet"),
            (DispatchRule::ShortestProcessingTime, _) => write!(f, "takes {seconds} s"),
            (DispatchRule::EarliestDueDate, 0) => when(f, "due"),
            (DispatchRule::LeastSlack, 0) => write!(f, "slack {seconds} s"),
            (DispatchRule::CriticalRatio, 0) => write!(f, "ratio {:.2}", self.value as f64 / self.over as f64),
            (DispatchRule::EarliestDueDate | DispatchRule::LeastSlack | DispatchRule::CriticalRatio, _) => {
                f.write_str("never due")
            }
            (DispatchRule::Priority, _) => write!(f, "priority {}", self.value.saturating_neg()),
            (DispatchRule::Schedule, 0) => when(f, "late: planned"),
            (DispatchRule::Schedule, 1) => when(f, "planned"),
            (DispatchRule::Schedule, _) => f.write_str("not planned"),
        }
    }
}

impl fmt::Display for BadAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BadAnswer::NoCandidate(number) => write!(f, "candidate {number} is not in the question"),
            BadAnswer::Part { mode, part: Some(part) } => write!(f, "{mode} cannot start with {part}"),
            BadAnswer::Part { mode, part: None } => write!(f, "{mode} cannot start without a part"),
            BadAnswer::PartTwice(part) => write!(f, "{part} would start twice"),
            BadAnswer::TooOften(mode) => write!(f, "{mode} cannot start so often at once"),
            BadAnswer::NotCovered(cell) => write!(f, "{cell} has fewer tokens than the decision takes"),
        }
    }
}

impl std::error::Error for BadAnswer {}

impl RevisionReason {
    /// Reason why a schedule is made anew, with the names of the table.
    pub fn text(&self, table: &CellTable) -> String {
        match self {
            RevisionReason::First => "no schedule yet".to_owned(),
            RevisionReason::Orders => "production orders changed".to_owned(),
            RevisionReason::Failed(firing) => format!("{firing} failed"),
            RevisionReason::Down(resource) => format!("{} out of service", table.handling().resource_name(*resource)),
            RevisionReason::Restored => "an exception was closed, or a resource returned to service".to_owned(),
            RevisionReason::Late { mode, part, by } => {
                let by = match tenths(by.as_secs_f64()) {
                    0.0 => "less than 0.1 s".to_owned(),
                    seconds => format!("{seconds} s"),
                };
                format!("{} later than tolerated, by {by}", named(table, *mode, *part))
            }
            RevisionReason::Ahead => "half of the time looked ahead has passed".to_owned(),
            RevisionReason::Over => "all scheduled activities started".to_owned(),
            RevisionReason::Stray(mode, part) => format!("{} started unscheduled", named(table, *mode, *part)),
        }
    }
}
