//! The timing bar chart, in the style it is published in: operations down, time across, planned against simulated; in SVG
//! with the critical path marked and arrows from the end of one operation to the start of another.

use std::fmt::Write as _;

use linewright_line::{Line, OpId, Station};

use super::report::{OperationRow, SimulationReport};
use crate::chart::svg::{BOLD, BY_OPERATION, LETTER, PLANNED, SvgChart, SvgStyle};
use crate::chart::{ActivityBar, BarChart, BarRow};

/// Characters for the time.
const WIDTH: usize = 60;
/// Least margin for names: the legend needs this much.
const LABELS_MIN: f64 = 320.0;
const BAR: f64 = 9.0;
const SIMULATED: &str = "#2f6fb0";
const CRITICAL: &str = "#c0392b";

const STYLE: SvgStyle = SvgStyle {
    defs: "<marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"8\" refY=\"4\" markerWidth=\"7\" markerHeight=\"7\" \
           orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"#555\"/></marker>",
    ..BY_OPERATION
};

fn chart(line: &Line, rows: &[OperationRow]) -> BarChart {
    let rows = rows.iter().map(|row| {
        let station = line.station(row.station);
        let star = if row.op == station.home { " *" } else { "" };
        let bar = ActivityBar {
            about: String::new(),
            number: None,
            planned: row.planned,
            actual: row.simulated,
            failed: None,
            colour: if row.is_critical { CRITICAL } else { SIMULATED },
        };
        BarRow {
            group: (row.op == OpId(0)).then(|| station.name.clone()),
            name: format!("{}{star}", station.operations[row.op.index()].name),
            bars: vec![bar],
        }
    });
    BarChart::new(rows.collect(), 0.0)
}

/// As text. A line is two halves high: the upper one is the bar of the plan, the lower one that of the simulation, so a
/// deviation shows as a step.
pub fn text(line: &Line, rows: &[OperationRow]) -> String {
    let chart = chart(line, rows);
    let widest = |names: &mut dyn Iterator<Item = &String>| names.map(|name| name.chars().count()).max().unwrap_or(0);
    let station_width = widest(&mut line.stations.iter().map(|station| &station.name));
    let operations = line.stations.iter().flat_map(|station| &station.operations);
    let operation_width = widest(&mut operations.map(|operation| &operation.name));
    let end = format!("{:.3} s", chart.span);
    let (label, pad) = (station_width + operation_width + 4, WIDTH.saturating_sub(end.chars().count() + 1));
    let mut text = format!("{:label$}│0{:pad$}{end}│\n", "", "");
    for (number, row) in rows.iter().enumerate() {
        let station = line.station(row.station);
        let name = chart.rows[number].group.as_deref().unwrap_or_default();
        let operation = &station.operations[row.op.index()].name;
        let star = if row.op == station.home { '*' } else { ' ' };
        let critical = if row.is_critical { '!' } else { ' ' };
        let cells = chart.halves(number, WIDTH);
        let times = row.simulated.map_or(String::new(), |(start, end)| format!(" {start:.3} – {end:.3}"));
        let cells = format!("{name:station_width$} {operation:operation_width$}{star}{critical} │{cells}│{times}");
        text.push_str(cells.trim_end());
        text.push('\n');
    }
    text
}

pub fn svg(line: &Line, report: &SimulationReport) -> String {
    let chart = chart(line, &report.rows);
    let mut title = format!("{}: cycle {}", line.title, report.drawn);
    // Writing to a string does not fail.
    if let Some(time) = report.cycle_time_s {
        let _ = write!(title, ", cycle time {time:.3} s");
    }
    let _ = write!(title, " (planned {:.3} s)", report.planned_s);
    let mut svg = SvgChart::new(&chart, &STYLE, labels(line), &title);
    svg.line(format_args!(
        "<rect x=\"8\" y=\"30\" width=\"18\" height=\"{BAR}\" fill=\"{PLANNED}\"/><text x=\"32\" y=\"39\">planned</text>\
         <rect x=\"96\" y=\"30\" width=\"18\" height=\"{BAR}\" fill=\"{SIMULATED}\"/><text x=\"120\" y=\"39\">simulated</text>\
         <rect x=\"196\" y=\"30\" width=\"18\" height=\"{BAR}\" fill=\"{CRITICAL}\"/><text x=\"220\" y=\"39\">simulated, \
         critical</text>\
         <path d=\"M348 35h24\" stroke=\"#555\"/><text x=\"378\" y=\"39\">arrow</text>\
         <path d=\"M430 35h24\" stroke=\"#555\" stroke-dasharray=\"4 3\"/>\
         <text x=\"460\" y=\"39\">arrow from an earlier cycle</text><text x=\"646\" y=\"39\">* home</text>"
    ));
    svg.rows();
    arrows(&mut svg, line, report);
    svg.end()
}

/// A margin in which no operation's name runs into its station's.
fn labels(line: &Line) -> f64 {
    let letters = |name: &str| name.chars().count() as f64;
    let station = |s: &Station| {
        let operations = s.operations.iter().map(|operation| letters(&operation.name) + 2.0);
        letters(&s.name) * BOLD + operations.fold(0.0, f64::max) * LETTER + 24.0
    };
    line.stations.iter().map(station).fold(LABELS_MIN, f64::max)
}

/// Arrows within the drawn cycle; those carried over from the cycle before come from outside of it.
fn arrows(svg: &mut SvgChart<'_>, line: &Line, report: &SimulationReport) {
    for arrow in &line.arrows {
        let row =
            |op: (linewright_line::StationId, OpId)| report.rows.iter().position(|row| (row.station, row.op) == op);
        let (Some(from), Some(to)) = (row(arrow.from), row(arrow.to)) else { continue };
        let (Some(tail), Some(head)) = (report.rows[from].simulated, report.rows[to].simulated) else { continue };
        let start = svg.x(if arrow.lag == 0 { tail.1 } else { 0.0 });
        let (from, to) = (svg.y(from) + 4.0 + 1.5 * BAR, svg.y(to) + 4.0 + 1.5 * BAR);
        let (end, dash) = (svg.x(head.0), if arrow.lag == 0 { "" } else { " stroke-dasharray=\"4 3\"" });
        svg.line(format_args!(
            "<line x1=\"{start:.1}\" y1=\"{from:.1}\" x2=\"{end:.1}\" y2=\"{to:.1}\" stroke=\"#555\"{dash} \
             marker-end=\"url(#tip)\"/>"
        ));
    }
}
