//! Decisions in sentences, with the names of the table.
//!
//! What was started before what, and why, stands with what was held; so the sentence about a start is made from the
//! reasons of those it was started before.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ids::{ModeId, PartId};
use super::super::reason::{DecidingRule, Gain, HoldReason, LostDecision, ProgressComparison};
use super::super::record::{Record, RecordKind};
use super::super::table::CellTable;

/// A mode by its own name, and with which part.
pub fn named(table: &CellTable, mode: ModeId, part: Option<PartId>) -> String {
    with(table.mode_name(mode), part)
}

/// A mode as people call it, which does not say of which stage it is: where its part is known.
pub fn called(table: &CellTable, mode: ModeId, part: Option<PartId>) -> String {
    with(table.called(mode), part)
}

fn with(name: &str, part: Option<PartId>) -> String {
    part.map_or_else(|| format!("`{name}`"), |part| format!("`{name}` with {part}"))
}

fn whom(part: Option<PartId>) -> String {
    part.map_or_else(|| "a part outside".to_owned(), |part| part.to_string())
}

/// Why the other comes first.
fn ground(by: &DecidingRule) -> String {
    match by {
        DecidingRule::Waited => "it has waited too long".to_owned(),
        DecidingRule::Helps { part } => format!("it makes way for {}, which has waited too long", whom(*part)),
        DecidingRule::Inside => "it is in the cell already".to_owned(),
        DecidingRule::Rule { rule, theirs, ours } => format!("by {rule} ({theirs}; the other {ours})"),
        DecidingRule::Order => "it has waited longer, or has the smaller number".to_owned(),
    }
}

/// What is better about a future.
fn leads(gain: &Gain) -> String {
    let s = |span: &Duration| span.as_secs_f64();
    match gain {
        Gain::Tardiness(by) => format!("makes parts less late, by {} s", s(by)),
        Gain::Work(by) => format!("leaves less to be done, by {} s", s(by)),
        Gain::Makespan(by) => format!("finishes all earlier, by {} s", s(by)),
        Gain::Flow(by) => format!("finishes parts earlier, by {} s in all", s(by)),
        Gain::Nothing => "is as good, and was begun".to_owned(),
    }
}

/// Why something was held.
pub fn reason(table: &CellTable, reason: &HoldReason) -> String {
    match reason {
        HoldReason::LostTo(LostDecision { to, with, own: _, by }) => {
            format!("{} goes first: {}", named(table, *to, *with), ground(by))
        }
        HoldReason::NotYet(until) => format!("it is too early, not before {until}"),
        HoldReason::ReservedFor { part, mode } => {
            format!("what it needs is kept for {}: {} has waited too long", named(table, *mode, None), whom(*part))
        }
        HoldReason::NotOrdered => "no production order wants another such part now".to_owned(),
        HoldReason::PlannedOtherwise(next) => format!("the schedule has {} next", named(table, *next, None)),
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
            let _ = write!(line, "{joint} before {}: {}", named(table, loser, lost.own), ground(&lost.by));
            joint = ";";
        }
        if joint == "," {
            line.push_str(": nothing else wanted what it takes");
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

/// For each mode why it was last held, if it has not started since. It follows from the records.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reasons {
    last: BTreeMap<ModeId, (Tick, HoldReason)>,
}

impl Reasons {
    /// Takes a record; the older ones first.
    pub fn note(&mut self, record: &Record) {
        match &record.fact {
            RecordKind::Decided { question: _, started, held } => {
                started.iter().for_each(|(mode, _)| _ = self.last.remove(mode));
                self.last.extend(held.iter().map(|&(mode, reason)| (mode, (record.at, reason))));
            }
            RecordKind::Epoch { .. }
            | RecordKind::Memory { .. }
            | RecordKind::Started { .. }
            | RecordKind::Acknowledged { .. }
            | RecordKind::OrderEnded { .. }
            | RecordKind::OrderFailed { .. }
            | RecordKind::Raised { .. }
            | RecordKind::Production { .. }
            | RecordKind::Ended { .. }
            | RecordKind::Fired { .. }
            | RecordKind::Exception(_) => (),
        }
    }

    /// When a mode was last held, and why.
    pub fn of(&self, mode: ModeId) -> Option<(Tick, &HoldReason)> {
        self.last.get(&mode).map(|(at, reason)| (*at, reason))
    }
}
