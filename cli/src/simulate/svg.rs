//! The timing bar chart as SVG, in the style it is published in: operations down, time across, arrows between them.
//!
//! Each operation has two bars, the plan's above the simulation's. Operations of the critical path are marked, arrows
//! are drawn from the end of the one to the start of the other as the simulation has it. The names of the line decide
//! how wide the left margin is, by the width of an average letter: who draws the text is not known here.

use std::fmt::Write;

use linewright_line::{Line, OpId, Station};

use super::report::{OperationRow, SimulationReport};
use crate::drawing::{escaped, steps};

/// The margin for names, at least: the legend wants this much.
const LABELS_MIN: f64 = 320.0;
/// What a letter takes on average, in plain and in bold type.
const LETTER: f64 = 6.8;
const BOLD: f64 = 8.0;
const CHART: f64 = 720.0;
const ROW: f64 = 26.0;
const TOP: f64 = 64.0;
const BAR: f64 = 9.0;

/// Draws the report's cycle.
pub fn draw(line: &Line, report: &SimulationReport) -> String {
    let bars = report.rows.iter().flat_map(|row| [row.planned, row.simulated]).flatten();
    let scale = Scale { labels: labels(line), span: bars.map(|bar| bar.1).fold(1e-6, f64::max) };
    let (width, height) = (scale.labels + CHART + 28.0, TOP + ROW * report.rows.len() as f64 + 20.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n\
         <defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"8\" refY=\"4\" markerWidth=\"7\" markerHeight=\"7\" \
         orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"#555\"/></marker></defs>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let time = report.cycle_time_s.map_or(String::new(), |time| format!(", cycle time {time:.3} s"));
    let _ = writeln!(
        svg,
        "<text x=\"8\" y=\"20\" font-size=\"15\">{}: cycle {}{time} (planned {:.3} s)</text>",
        escaped(&line.title),
        report.drawn,
        report.planned_s
    );
    let _ = writeln!(
        svg,
        "<rect x=\"8\" y=\"30\" width=\"18\" height=\"{BAR}\" fill=\"#b8c4d0\"/><text x=\"32\" y=\"39\">planned</text>\
         <rect x=\"96\" y=\"30\" width=\"18\" height=\"{BAR}\" fill=\"#2f6fb0\"/><text x=\"120\" y=\"39\">simulated</text>\
         <rect x=\"196\" y=\"30\" width=\"18\" height=\"{BAR}\" fill=\"#c0392b\"/><text x=\"220\" y=\"39\">simulated, \
         critical</text>\
         <path d=\"M348 35h24\" stroke=\"#555\"/><text x=\"378\" y=\"39\">arrow</text>\
         <path d=\"M430 35h24\" stroke=\"#555\" stroke-dasharray=\"4 3\"/>\
         <text x=\"460\" y=\"39\">arrow from an earlier cycle</text><text x=\"646\" y=\"39\">* home</text>"
    );
    grid(&mut svg, scale, height);
    for (number, row) in report.rows.iter().enumerate() {
        draw_row(&mut svg, line, row, number, scale);
    }
    arrows(&mut svg, line, report, scale);
    svg.push_str("</svg>\n");
    svg
}

/// Where time is: how wide the margin before it is, and how long it lasts.
#[derive(Clone, Copy)]
struct Scale {
    labels: f64,
    span: f64,
}

impl Scale {
    fn x(self, at: f64) -> f64 {
        self.labels + at / self.span * CHART
    }
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

fn y(row: usize) -> f64 {
    TOP + ROW * row as f64
}

/// Lines at round times, at most a dozen of them.
fn grid(svg: &mut String, scale: Scale, height: f64) {
    let span = scale.span;
    for at in steps(span) {
        let x = scale.x(at);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#777\">{} s</text>",
            TOP - 4.0,
            height - 16.0,
            TOP - 8.0,
            at
        );
    }
}

fn draw_row(svg: &mut String, line: &Line, row: &OperationRow, number: usize, scale: Scale) {
    let station = line.station(row.station);
    let y = y(number);
    if row.op == OpId(0) {
        let _ = writeln!(
            svg,
            "<line x1=\"0\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\" stroke=\"#999\"/>\
             <text x=\"8\" y=\"{:.1}\" font-weight=\"bold\">{}</text>",
            scale.labels + CHART,
            y + 17.0,
            escaped(&station.name)
        );
    }
    let star = if row.op == station.home { " *" } else { "" };
    let name = escaped(&station.operations[row.op.index()].name);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}{star}</text>",
        scale.labels - 8.0,
        y + 17.0
    );
    let simulated = if row.is_critical { "#c0392b" } else { "#2f6fb0" };
    for (bar, top, colour) in [(row.planned, 4.0, "#b8c4d0"), (row.simulated, 4.0 + BAR, simulated)] {
        let Some((start, end)) = bar else { continue };
        let (from, to) = (scale.x(start), scale.x(end));
        let _ = writeln!(
            svg,
            "<rect x=\"{from:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{BAR}\" fill=\"{colour}\">\
             <title>{start:.3} – {end:.3} s</title></rect>",
            y + top,
            (to - from).max(1.0)
        );
    }
}

/// Arrows within the drawn cycle; those carried over from the cycle before come from outside of it.
fn arrows(svg: &mut String, line: &Line, report: &SimulationReport, scale: Scale) {
    for arrow in &line.arrows {
        let row =
            |op: (linewright_line::StationId, OpId)| report.rows.iter().position(|row| (row.station, row.op) == op);
        let (Some(from), Some(to)) = (row(arrow.from), row(arrow.to)) else { continue };
        let (Some(tail), Some(head)) = (report.rows[from].simulated, report.rows[to].simulated) else { continue };
        let start = if arrow.lag == 0 { scale.x(tail.1) } else { scale.labels };
        let (from, to) = (y(from) + 4.0 + 1.5 * BAR, y(to) + 4.0 + 1.5 * BAR);
        let dash = if arrow.lag == 0 { "" } else { " stroke-dasharray=\"4 3\"" };
        let _ = writeln!(
            svg,
            "<line x1=\"{start:.1}\" y1=\"{from:.1}\" x2=\"{:.1}\" y2=\"{to:.1}\" stroke=\"#555\"{dash} \
             marker-end=\"url(#tip)\"/>",
            scale.x(head.0)
        );
    }
}
