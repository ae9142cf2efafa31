//! Result of a check, as data: the JSON of `--json`, and the source of the tables.

use std::collections::HashSet;
use std::path::Path;

use linewright_line::{Line, ParsedLine, Problem, Problems, StationId};
use linewright_proof::cell::APART;
use linewright_proof::explore::{LineExploration, LineNotExplorable};
use linewright_proof::structure::chart::{RunAhead, run_ahead};
use linewright_proof::structure::{Check, StructureReport, judge_line, judge_stations};
use serde::Serialize;

use super::barriers::{self, Barriers};
use super::cell::{self, CellReport};
use super::explored::Exploration;
use super::explorer::{Explorer, PART};

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
    /// Conflicts and each station are decided by parts; what concerns the whole line is left open.
    #[serde(skip)]
    pub is_by_parts: bool,
    /// Nothing was explored, as was asked for.
    #[serde(skip)]
    pub is_structure_alone: bool,
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

    /// A line of which nothing has been judged.
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

    /// Adds what is known of a line without exploration. `file` and `arrow_lines`: where the line's arrows are written, in their order.
    pub fn add_structure(&mut self, line: &Line, file: &Path, arrow_lines: &[usize]) {
        self.stations = judge_stations(line);
        self.line_checks = judge_line(line);
        for check in &mut self.line_checks {
            let lines = check.arrows.iter().filter_map(|&arrow| arrow_lines.get(arrow));
            let places: Vec<String> = lines.map(|line| format!("{}:{line}", file.display())).collect();
            if !places.is_empty() {
                check.reason += &format!(" ({})", places.join(", "));
            }
        }
        self.ok = self.stations.iter().all(StructureReport::ok) && self.line_checks.iter().all(|check| check.ok);
        self.warnings.extend(run_ahead(line).into_iter().map(TextPlace::from));
    }

    /// Adds what is found by exploring a line, and what is left open.
    ///
    /// # Errors
    /// When the line cannot be explored at all.
    pub fn add_explored(&mut self, line: &Line, explorer: &Explorer<'_>) -> Result<(), LineNotExplorable> {
        self.explorations = explorer.explore(line)?;
        let asks_to_explore = explorer.options.asks_to_explore();
        if asks_to_explore {
            explorer.progress.shows("measured positions");
        }
        self.barriers = barriers::of(line, explorer.options.measured())?;
        self.ok &= self.explorations.iter().all(Exploration::holds) && self.barriers.iter().all(Barriers::holds);
        let mut open = Vec::new();
        self.is_structure_alone = !asks_to_explore;
        self.is_by_parts = asks_to_explore
            && (self.explorations.iter().all(|exploration| exploration.scope.starts_with(PART))
                || self.explorations.iter().any(|exploration| exploration.is_left_to_parts));
        if self.is_structure_alone {
            open.extend(NOT_EXPLORED);
        }
        if self.is_by_parts {
            open.push(IN_PARTS);
        }
        if asks_to_explore && !LineExploration::new(line).covers_every_delay() {
            open.push(RING);
        }
        if line.conflicts.iter().any(|conflict| line.is_of_tasks(conflict)) {
            open.push(TASKS);
        }
        open.push(DEVICES);
        if line.conflicts.is_empty() {
            open.push(NO_CONFLICTS);
        }
        self.not_decided = open.into_iter().map(str::to_owned).chain(pairs_without_conflict(line)).collect();
        Ok(())
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
            is_by_parts: false,
            is_structure_alone: false,
            not_decided: Vec::new(),
            warnings: Vec::new(),
            problems: Vec::new(),
        }
    }
}

/// The pairs of stations that no conflict joins, so that one that was forgotten is noticed; first those that arrows join, which hand on to each
/// other and so come near. None where there is no conflict, or each pair has one.
fn pairs_without_conflict(line: &Line) -> Option<String> {
    /// More are no help to read.
    const PAIRS_MAX: usize = 8;
    let joined: HashSet<(StationId, StationId)> =
        line.conflicts.iter().map(|of| (of.a.station.min(of.b.station), of.a.station.max(of.b.station))).collect();
    let later = |a: StationId| line.station_ids().skip_while(move |&b| b != a).skip(1);
    let pairs = line.station_ids().flat_map(|a| later(a).map(move |b| (a, b))).filter(|pair| !joined.contains(pair));
    let by_arrows: HashSet<(StationId, StationId)> =
        line.arrows.iter().map(|of| (of.from.0.min(of.to.0), of.from.0.max(of.to.0))).collect();
    let (near, others): (Vec<_>, Vec<_>) = pairs.partition(|pair| by_arrows.contains(pair));
    if line.conflicts.is_empty() || near.len() + others.len() == 0 {
        return None;
    }
    let named = |pairs: &[(StationId, StationId)], most: usize| {
        let name = |id: StationId| &line.station(id).name;
        let mut named: Vec<String> =
            pairs.iter().take(most).map(|&(a, b)| format!("{} and {}", name(a), name(b))).collect();
        if let Some(more @ 1..) = pairs.len().checked_sub(most) {
            named.push(format!("{more} more pairs"));
        }
        named.join(", ")
    };
    let question = "whether stations can collide between which there is no [[conflict]]";
    let left = PAIRS_MAX.saturating_sub(near.len());
    Some(match (near.len(), others.len()) {
        (0, _) => format!("{question}: {}", named(&others, PAIRS_MAX)),
        (_, 0) => format!("{question}, joined by arrows: {}", named(&near, PAIRS_MAX)),
        _ => {
            format!("{question}, joined by arrows: {}; others: {}", named(&near, PAIRS_MAX), named(&others, left))
        }
    })
}
