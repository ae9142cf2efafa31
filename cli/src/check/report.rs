//! What a check finds, as data: the JSON of `--json`, and what the tables are made from.

use linewright_line::{Line, Module, Parsed, Problem, Problems, Station, StationId};
use serde::Serialize;

use super::{chart, modes, station};

/// What this command leaves open, in words; printed with every result so that nobody takes it for more than it is.
const NOT_DECIDED: [&str; 3] = [
    "whether a conflict can be reached through faults, undone operations, recovery paths, restarts and late messages: \
     that takes an exploration of the composed line, which this command does not do",
    "whether every wait ends outside the normal cycle: a live net can still be held by a condition that never comes true",
    "whether mechanisms and devices behave as the description says",
];

/// Everything that was found.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The line's name; none if the description could not be understood.
    pub line: Option<String>,
    /// Nothing speaks against running it.
    pub ok: bool,
    /// Station by station.
    pub stations: Vec<StationReport>,
    /// What concerns the whole line.
    pub line_checks: Vec<Check>,
    /// What the checks do not say.
    pub not_decided: Vec<&'static str>,
    /// What is suspicious about the text.
    pub warnings: Vec<Place>,
    /// What is wrong with the text.
    pub problems: Vec<Place>,
}

/// What was found about one station.
#[derive(Debug, Serialize)]
pub struct StationReport {
    /// Its name.
    pub name: String,
    /// Reversible operations, j.
    pub reversible: usize,
    /// Irreversible operations, k.
    pub irreversible: usize,
    /// Places of its net.
    pub places: usize,
    /// Transitions of its net.
    pub transitions: usize,
    /// One by one.
    pub checks: Vec<Check>,
}

/// One property, and why it holds or does not.
#[derive(Debug, Serialize)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// Whether it holds.
    pub ok: bool,
    /// Why, or why not.
    pub reason: String,
}

/// A problem of the text with its place.
#[derive(Debug, Serialize)]
pub struct Place {
    /// The line of the text, from 1; none if the text could not even be read.
    pub line: Option<usize>,
    /// The column, in characters, from 1.
    pub column: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Check {
    /// A property with what decided it: `Ok` is why it holds, `Err` why it does not.
    pub fn of(name: impl Into<String>, found: Result<String, String>) -> Self {
        let ok = found.is_ok();
        Check { name: name.into(), ok, reason: found.unwrap_or_else(|why_not| why_not) }
    }
}

impl StationReport {
    /// An empty report on a station.
    pub fn of(station: &Station, places: usize, transitions: usize) -> Self {
        let is_reversible = |module: &Module| matches!(module, Module::Reversible { .. });
        let reversible = station.operations.iter().filter(|op| is_reversible(&op.module)).count();
        StationReport {
            name: station.name.clone(),
            reversible,
            irreversible: station.operations.len() - reversible,
            places,
            transitions,
            checks: Vec::new(),
        }
    }

    /// Whether all its checks hold.
    pub fn ok(&self) -> bool {
        self.checks.iter().all(|check| check.ok)
    }
}

impl From<&Problem> for Place {
    fn from(problem: &Problem) -> Self {
        Place {
            line: Some(problem.line),
            column: Some(problem.column),
            message: problem.message.clone(),
            help: problem.hint.clone(),
        }
    }
}

impl Report {
    /// A description that is not one.
    pub fn of_problems(problems: &Problems) -> Self {
        let (warnings, errors): (Vec<_>, Vec<_>) = problems.iter().partition(|problem| problem.is_warning);
        Report {
            warnings: warnings.into_iter().map(Place::from).collect(),
            problems: errors.into_iter().map(Place::from).collect(),
            ..Report::nothing()
        }
    }

    /// A description that could not be read.
    pub fn unreadable(message: String) -> Self {
        let place = Place { line: None, column: None, message, help: None };
        Report { problems: vec![place], ..Report::nothing() }
    }

    fn nothing() -> Self {
        Report {
            line: None,
            ok: false,
            stations: Vec::new(),
            line_checks: Vec::new(),
            not_decided: Vec::new(),
            warnings: Vec::new(),
            problems: Vec::new(),
        }
    }
}

/// Checks everything that structure can say of a description that parses.
pub fn judge(parsed: &Parsed) -> Report {
    let Parsed { line, warnings } = parsed;
    let stations: Vec<StationReport> = line.station_ids().map(|id| station::judge(line, id)).collect();
    let line_checks = judge_line(line);
    Report {
        line: Some(line.name.clone()),
        ok: stations.iter().all(StationReport::ok) && line_checks.iter().all(|check| check.ok),
        stations,
        line_checks,
        not_decided: NOT_DECIDED.to_vec(),
        warnings: warnings.iter().map(Place::from).collect(),
        problems: Vec::new(),
    }
}

fn judge_line(line: &Line) -> Vec<Check> {
    let mut checks = vec![
        Check::of("home", chart::home_is_consistent(line)),
        Check::of("operation causality", chart::every_circuit_has_a_token(line)),
        Check::of("mode decision net", modes::verdict()),
        Check::of("mode decision exclusive", modes::at_most_one_arc()),
    ];
    let separated = line
        .conflicts
        .iter()
        .map(|conflict| Check::of(format!("separated: {}", conflict.why), chart::separated(line, conflict)));
    checks.extend(separated);
    checks
}

/// An operation's full name.
pub fn full_name(line: &Line, (station, op): (StationId, linewright_line::OpId)) -> String {
    format!("{}: {}", line.station(station).name, line.operation((station, op)).name)
}
