//! Result of a check, as data: the JSON of `--json`, and the source of the tables.

use std::collections::HashSet;

use linewright_line::{Line, ParsedLine, Problem, Problems, StationId};
use linewright_proof::cell::APART;
use linewright_proof::explore::{LineExploration, LineNotExplorable};
use linewright_proof::structure::chart::{RunAhead, run_ahead};
use linewright_proof::structure::{Check, StructureReport, judge_line, judge_stations};
use serde::Serialize;

use super::barriers::{self, Barriers};
use super::cell::{self, CellReport};
use super::explored::{Exploration, ExploreOptions, PART};

/// Question that no exploration decides; printed with every result so that it is not taken for more than it is.
const DEVICES: &str = "whether mechanisms and devices behave as the description says";
/// Without a conflict there is nothing to be kept apart, and no state to be looked for.
const NO_CONFLICTS: &str = "whether mechanisms can collide: the description names no conflict, so nothing was explored; describe what must \
     not be at one place together, also of a table or conveyor that turns under a tool, as [[conflict]]";
/// Questions that structure alone leaves open.
const NOT_EXPLORED: [&str; 2] = [
    "whether a conflict can be reached through faults, undone operations, recovery paths and late messages: explore for \
     that, without --structure",
    "whether every wait ends outside the normal cycle: a live net can be blocked by a condition that never holds",
];
/// Question that one report on its way over each link leaves open.
const RING: &str = "what a report can do that arrives after newer ones were sent: stations of this line wait for each \
     other in a ring of three or more, where that may matter";
/// Question that parts leave open.
const IN_PARTS: &str = "whether every wait ends, stations stay within the cycles of their arrows, and home can be reached, from every state of the whole line: \
     parts decide conflicts and each station alone";
/// Reported as not decided for a line without its cell that has conflicts of tasks.
const TASKS: &str = "whether tasks in conflict are ordered at once: a cell's description says what is ordered";

/// Everything that was found.
#[derive(Debug, Serialize)]
pub struct CheckReport {
    /// The line's name; none if there is none, or its description could not be understood.
    pub line: Option<String>,
    /// All checks, explorations and barriers hold.
    pub ok: bool,
    pub stations: Vec<StructureReport>,
    /// Checks of the whole line.
    pub line_checks: Vec<Check>,
    /// Barriers of each conflict on the machine.
    pub barriers: Vec<Barriers>,
    /// Results of exploring the composed line.
    pub explorations: Vec<Exploration>,
    /// Result for the flexible cell, if the description has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<CellReport>,
    /// Questions that the checks leave open.
    pub not_decided: Vec<String>,
    /// Warnings on the text, with their places; then those on what follows from it, without.
    pub warnings: Vec<TextPlace>,
    /// Errors in the text.
    pub problems: Vec<TextPlace>,
}

/// A problem of the text with its place.
#[derive(Debug, Serialize)]
pub struct TextPlace {
    /// The line of the text, from 1; none if the text could not even be read.
    pub line: Option<usize>,
    /// The column, in characters, from 1.
    pub column: Option<usize>,
    pub message: String,
    /// Remedy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl From<&Problem> for TextPlace {
    fn from(problem: &Problem) -> Self {
        TextPlace {
            line: Some(problem.line),
            column: Some(problem.column),
            message: problem.message.clone(),
            help: problem.hint.clone(),
        }
    }
}

impl From<RunAhead> for TextPlace {
    fn from(RunAhead { text, help }: RunAhead) -> Self {
        TextPlace { line: None, column: None, message: text, help: Some(help) }
    }
}

impl CheckReport {
    /// A description that is not one.
    pub fn of_problems(problems: &Problems) -> Self {
        let (warnings, errors): (Vec<_>, Vec<_>) = problems.iter().partition(|problem| problem.is_warning);
        CheckReport {
            warnings: warnings.into_iter().map(TextPlace::from).collect(),
            problems: errors.into_iter().map(TextPlace::from).collect(),
            ..CheckReport::nothing()
        }
    }

    /// A description that could not be read.
    pub fn unreadable(message: String) -> Self {
        let place = TextPlace { line: None, column: None, message, help: None };
        CheckReport { problems: vec![place], ..CheckReport::nothing() }
    }

    /// A line of which nothing was judged, since the cell beside it has errors in its text.
    pub fn unjudged(parsed: &ParsedLine) -> Self {
        CheckReport {
            line: Some(parsed.line.name.clone()),
            warnings: parsed.warnings.iter().map(TextPlace::from).collect(),
            ..CheckReport::nothing()
        }
    }

    /// There is no line, which is nothing wrong.
    pub fn of_no_line() -> Self {
        CheckReport { ok: true, ..CheckReport::nothing() }
    }

    /// Adds what was found of the cell.
    pub fn add(&mut self, cell: CellReport) {
        self.ok &= cell.ok;
        if cell.properties.iter().any(|property| property.name == APART) {
            self.not_decided.retain(|open| open != TASKS);
        }
        if cell.name.is_some() {
            let open = if cell.sound_parts.is_some() { cell::BREAKDOWN } else { cell::NOT_EXPLORED };
            self.not_decided.push(open.to_owned());
        }
        self.cell = Some(cell);
    }

    fn nothing() -> Self {
        CheckReport {
            line: None,
            ok: false,
            stations: Vec::new(),
            line_checks: Vec::new(),
            barriers: Vec::new(),
            explorations: Vec::new(),
            cell: None,
            not_decided: Vec::new(),
            warnings: Vec::new(),
            problems: Vec::new(),
        }
    }
}

/// The pairs of stations that no conflict joins, so that one that was forgotten is noticed. None where there is no conflict, or each
/// pair has one.
fn pairs_without_conflict(line: &Line) -> Option<String> {
    /// More are no help to read.
    const PAIRS_MAX: usize = 8;
    let joined: HashSet<(StationId, StationId)> =
        line.conflicts.iter().map(|of| (of.a.station.min(of.b.station), of.a.station.max(of.b.station))).collect();
    let later = |a: StationId| line.station_ids().skip_while(move |&b| b != a).skip(1);
    let mut pairs =
        line.station_ids().flat_map(|a| later(a).map(move |b| (a, b))).filter(|pair| !joined.contains(pair));
    let name = |id: StationId| &line.station(id).name;
    let mut named: Vec<String> =
        pairs.by_ref().take(PAIRS_MAX).map(|(a, b)| format!("{} and {}", name(a), name(b))).collect();
    let more = pairs.count();
    if line.conflicts.is_empty() || named.is_empty() {
        return None;
    }
    if more > 0 {
        named.push(format!("{more} more pairs"));
    }
    Some(format!("whether stations can collide between which there is no [[conflict]]: {}", named.join(", ")))
}

/// Checks a description that parses: by structure, then by exploring it by `options`.
///
/// # Errors
/// When the line cannot be explored at all.
pub fn judge(parsed: &ParsedLine, options: &ExploreOptions) -> Result<CheckReport, LineNotExplorable> {
    let ParsedLine { line, warnings } = parsed;
    let stations: Vec<StructureReport> = judge_stations(line);
    let line_checks = judge_line(line);
    let sound = stations.iter().all(StructureReport::ok) && line_checks.iter().all(|check| check.ok);
    let explorations = options.explore(line)?;
    let barriers = barriers::of(line, options.measured())?;
    let mut open = Vec::new();
    if !options.asks_to_explore() {
        open.extend(NOT_EXPLORED);
    } else if explorations.iter().all(|exploration| exploration.scope.starts_with(PART))
        || explorations.iter().any(|exploration| exploration.is_left_to_parts)
    {
        open.push(IN_PARTS);
    }
    if options.asks_to_explore() && !LineExploration::new(line).covers_every_delay() {
        open.push(RING);
    }
    if line.conflicts.iter().any(|conflict| line.is_of_tasks(conflict)) {
        open.push(TASKS);
    }
    open.push(DEVICES);
    if line.conflicts.is_empty() {
        open.push(NO_CONFLICTS);
    }
    let not_decided = open.into_iter().map(str::to_owned).chain(pairs_without_conflict(line)).collect();
    Ok(CheckReport {
        line: Some(line.name.clone()),
        ok: sound && explorations.iter().all(Exploration::holds) && barriers.iter().all(Barriers::holds),
        stations,
        line_checks,
        barriers,
        explorations,
        cell: None,
        not_decided,
        warnings: warnings
            .iter()
            .map(TextPlace::from)
            .chain(run_ahead(line).into_iter().map(TextPlace::from))
            .collect(),
        problems: Vec::new(),
    })
}
