//! The result for people: a table with a row for each station, a list for the line, the cell's, and what is not decided.

use std::fmt::Write;

use linewright_proof::explore::counted;
use linewright_proof::structure::{Check, StructureReport};

use super::barriers::Barriers;
use super::cell;
use super::explored::{Exploration, LineCounterexample, LineFinding};
use super::report::CheckReport;

/// Column headings for the checks of a station, in the order of the table.
const COLUMNS: [(&str, &str); 10] = [
    ("places", "places"),
    ("token", "token"),
    ("state machine", "machine"),
    ("strongly connected", "connected"),
    ("live", "live"),
    ("safe", "safe"),
    ("reversible", "reversible"),
    ("exclusive", "exclusive"),
    ("conditions", "conditions"),
    ("tables", "tables"),
];

/// The warnings and the results of the structure, as lines of text: they need no exploration, and are printed before it begins.
pub fn structure(report: &CheckReport) -> String {
    written(report, of_structure)
}

/// The results of the exploration and what is left undecided, as lines of text; the last of them sums up the whole check.
pub fn explored(report: &CheckReport) -> String {
    written(report, of_rest)
}

fn written(report: &CheckReport, write: fn(&CheckReport, &mut String) -> std::fmt::Result) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    write(report, &mut out).expect("a string accepts every write");
    out
}

fn of_rest(report: &CheckReport, out: &mut String) -> std::fmt::Result {
    for barriers in &report.barriers {
        writeln!(out, "{} {}: {}", barriers.verdict().map_or("-", sign), barriers.why, barriers.text())?;
        if !barriers.steps().is_empty() {
            steps(barriers.steps(), &barriers.why, out)?;
        }
        barriers.help.iter().try_for_each(|help| writeln!(out, "  help: {help}"))?;
    }
    report.explorations.iter().try_for_each(|exploration| of_exploration(exploration, out))?;
    if let Some(cell) = &report.cell {
        cell::write(cell, out)?;
    }
    if !report.not_decided.is_empty() {
        writeln!(out, "\nnot decided here:")?;
    }
    for open in &report.not_decided {
        writeln!(out, "- {open}")?;
    }
    summary(report, out)
}

fn of_structure(report: &CheckReport, out: &mut String) -> std::fmt::Result {
    stations(&report.stations, out)?;
    for station in &report.stations {
        for check in station.checks.iter().filter(|check| !check.ok) {
            writeln!(out, "  ✗ {}: {}: {}", station.name, check.name, check.reason)?;
        }
    }
    writeln!(out)?;
    for Check { name, ok, reason, .. } in &report.line_checks {
        writeln!(out, "{} {name}: {reason}", mark(*ok))?;
    }
    // Those of the text are drawn in it.
    for warning in report.warnings.iter().filter(|warning| warning.line.is_none()) {
        writeln!(out, "! {}", warning.message)?;
        warning.help.iter().try_for_each(|help| writeln!(out, "  help: {help}"))?;
    }
    Ok(())
}

/// What the checks that hold leave out, behind their number.
fn left_out(report: &CheckReport) -> &'static str {
    if report.is_by_parts {
        "; by parts: conflicts and each station are decided, the whole line is left open"
    } else if report.is_structure_alone {
        "; by structure alone: nothing was explored"
    } else {
        ""
    }
}

/// Number of checks that hold, and what was decided by them.
fn summary(report: &CheckReport, out: &mut String) -> std::fmt::Result {
    let checks = || report.stations.iter().flat_map(|station| &station.checks).chain(&report.line_checks);
    let of_stations = report.explorations.iter().flat_map(|exploration| &exploration.properties).map(|p| p.verdict);
    let of_cell = report.cell.iter().flat_map(|cell| &cell.properties).map(|property| property.verdict);
    let of_barriers = report.barriers.iter().filter_map(Barriers::verdict);
    let verdicts: Vec<&str> = of_stations.chain(of_cell).chain(of_barriers).collect();
    let with = |verdict: &str| verdicts.iter().filter(|known| **known == verdict).count();
    let problems = report.problems.len() + report.cell.as_ref().map_or(0, |cell| cell.problems.len());
    let all = checks().count() + verdicts.len();
    let failed = checks().filter(|check| !check.ok).count() + with("fails");
    let open = with("undecided");
    let cell = report.cell.as_ref().and_then(|cell| cell.name.as_deref());
    let name = report.line.as_deref().or(cell).unwrap_or("the description");
    if problems > 0 {
        let s = if problems == 1 { "" } else { "s" };
        return writeln!(out, "\n✗ {name}: {problems} problem{s} of the text");
    }
    // Those of the text too, which are drawn far above.
    let (sign, warnings) = match report.warnings.len() + report.cell.as_ref().map_or(0, |cell| cell.warnings.len()) {
        0 => ("✓", String::new()),
        1 => ("!", ", 1 warning".to_owned()),
        number => ("!", format!(", {number} warnings")),
    };
    match (failed, open) {
        (0, 0) => writeln!(out, "\n{sign} {name}: {all} checks hold{warnings}{}", left_out(report)),
        (0, open) => {
            let has_arrows = report.explorations.iter().any(|exploration| !exploration.direct_arrows.is_empty());
            let remedy = if has_arrows { "; arrows named below the parts decide some of them" } else { "" };
            writeln!(out, "\n? {name}: {open} of {all} checks are undecided{warnings}{remedy}")
        }
        (failed, 0) => writeln!(out, "\n✗ {name}: {failed} of {all} checks do not hold{warnings}"),
        (failed, open) => {
            writeln!(out, "\n✗ {name}: {failed} of {all} checks do not hold, {open} are undecided{warnings}")
        }
    }
}

/// One exploration: its size, its properties, and how the first that fails comes to be.
fn of_exploration(exploration: &Exploration, out: &mut String) -> std::fmt::Result {
    let Exploration { scope, states, kept, arcs, bytes, .. } = exploration;
    let mebibytes = bytes.div_ceil(1 << 20);
    match states {
        0 => writeln!(out, "\n{scope}")?,
        _ => {
            let (states, arcs) = (counted(*states), counted(*arcs));
            writeln!(out, "\n{scope}\n  {states} states ({kept} kept), {arcs} arcs, {mebibytes} MiB")?;
        }
    }
    let alike = |a: &LineFinding, b: &LineFinding| {
        a.verdict == "undecided" && b.verdict == "undecided" && a.reason == b.reason && b.counterexample.is_none()
    };
    for group in exploration.properties.chunk_by(alike) {
        let (names, last) = group.split_at(group.len() - 1);
        names.iter().try_for_each(|LineFinding { name, verdict, .. }| writeln!(out, "{} {name}", sign(verdict)))?;
        for LineFinding { name, verdict, reason, counterexample, .. } in last {
            match names.is_empty() {
                true => writeln!(out, "{} {name}: {reason}", sign(verdict))?,
                false => writeln!(out, "{} {name}\n  each of these: {reason}", sign(verdict))?,
            }
            // Where arrows to be written exclude it, the way to it is of no line.
            if let Some(counterexample) = counterexample.as_ref().filter(|_| !exploration.kept_apart.contains(name)) {
                story(counterexample, out)?;
            }
        }
    }
    let helps = exploration.help.iter().cloned().chain(exploration.outside_text());
    helps.into_iter().try_for_each(|help| writeln!(out, "  help: {help}"))
}

fn steps(steps: &[String], end: &str, out: &mut String) -> std::fmt::Result {
    writeln!(out)?;
    for (nth, step) in steps.iter().enumerate() {
        writeln!(out, "{:6}. {step}", nth + 1)?;
    }
    writeln!(out, "        and so: {end}\n")
}

fn story(counterexample: &LineCounterexample, out: &mut String) -> std::fmt::Result {
    steps(&counterexample.steps, &counterexample.end, out)?;
    counterexample.chart.iter().try_for_each(|row| writeln!(out, "    {row}"))?;
    writeln!(out)
}

fn stations(stations: &[StructureReport], out: &mut String) -> std::fmt::Result {
    let width = stations.iter().map(|station| station.name.len()).max().unwrap_or(0).max("station".len());
    write!(out, "{:width$}   R   I  places  transitions", "station")?;
    COLUMNS.iter().try_for_each(|(_, heading)| write!(out, "  {heading}"))?;
    writeln!(out)?;
    for s in stations {
        write!(out, "{:width$} {:3} {:3}  {:6}  {:11}", s.name, s.reversible, s.irreversible, s.places, s.transitions)?;
        for (name, heading) in COLUMNS {
            // A check that another one's failure left no ground for is not there.
            let shown = s.checks.iter().find(|check| check.name == name).map_or("-", |check| mark(check.ok));
            write!(out, "  {shown:^0$}", heading.len())?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Sign before a property.
pub fn sign(verdict: &str) -> &'static str {
    match verdict {
        "holds" => "✓",
        "fails" => "✗",
        "remark" => "!",
        _ => "?",
    }
}

const fn mark(ok: bool) -> &'static str {
    if ok { "✓" } else { "✗" }
}
