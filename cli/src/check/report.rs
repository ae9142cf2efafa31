//! What a check finds, as data: the JSON of `--json`, and what the tables are made from.

use linewright_line::{Parsed, Problem, Problems};
use linewright_proof::structure::{Check, StationReport, judge_line, judge_stations};
use serde::Serialize;

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
    let stations: Vec<StationReport> = judge_stations(line);
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
