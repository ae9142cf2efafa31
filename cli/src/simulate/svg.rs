//! The timing bar chart as SVG, in the style it is published in: operations down, time across, arrows between them.
//!
//! Each operation has two bars, the plan's above the simulation's. Operations of the critical path are marked, arrows
//! are drawn from the end of the one to the start of the other as the simulation has it.

use std::fmt::Write;

use linewright_line::{Line, OpId};

use super::report::{Report, Row};

const LABELS: f64 = 320.0;
const CHART: f64 = 720.0;
const ROW: f64 = 26.0;
const TOP: f64 = 64.0;
const BAR: f64 = 9.0;

/// Draws the report's cycle.
pub fn draw(line: &Line, report: &Report) -> String {
    let bars = report.rows.iter().flat_map(|row| [row.planned, row.simulated]).flatten();
    let span = bars.map(|bar| bar.1).fold(1e-6, f64::max);
    let (width, height) = (LABELS + CHART + 20.0, TOP + ROW * report.rows.len() as f64 + 20.0);
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
         critical</text>"
    );
    grid(&mut svg, span, height);
    for (number, row) in report.rows.iter().enumerate() {
        draw_row(&mut svg, line, row, number, span);
    }
    arrows(&mut svg, line, report, span);
    svg.push_str("</svg>\n");
    svg
}

fn x(at: f64, span: f64) -> f64 {
    LABELS + at / span * CHART
}

fn y(row: usize) -> f64 {
    TOP + ROW * row as f64
}

/// Lines at round times, at most a dozen of them.
fn grid(svg: &mut String, span: f64, height: f64) {
    let magnitude = 10f64.powf((span / 10.0).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * magnitude).into_iter().find(|step| span / step <= 12.0);
    let step = step.unwrap_or(span);
    let mut at = 0.0;
    while at <= span {
        let x = x(at, span);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{:.1}\" x2=\"{x:.1}\" y2=\"{:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#777\">{}</text>",
            TOP - 4.0,
            height - 16.0,
            TOP - 8.0,
            (at * 1e6).round() / 1e6
        );
        at += step;
    }
}

fn draw_row(svg: &mut String, line: &Line, row: &Row, number: usize, span: f64) {
    let station = line.station(row.station);
    let y = y(number);
    if row.op == OpId(0) {
        let _ = writeln!(
            svg,
            "<line x1=\"0\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\" stroke=\"#999\"/>\
             <text x=\"8\" y=\"{:.1}\" font-weight=\"bold\">{}</text>",
            LABELS + CHART,
            y + 17.0,
            escaped(&station.name)
        );
    }
    let star = if row.op == station.home { " *" } else { "" };
    let name = escaped(&station.operations[row.op.index()].name);
    let _ =
        writeln!(svg, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}{star}</text>", LABELS - 8.0, y + 17.0);
    let simulated = if row.is_critical { "#c0392b" } else { "#2f6fb0" };
    for (bar, top, colour) in [(row.planned, 4.0, "#b8c4d0"), (row.simulated, 4.0 + BAR, simulated)] {
        let Some((start, end)) = bar else { continue };
        let (from, to) = (x(start, span), x(end, span));
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
fn arrows(svg: &mut String, line: &Line, report: &Report, span: f64) {
    for arrow in &line.arrows {
        let row =
            |op: (linewright_line::StationId, OpId)| report.rows.iter().position(|row| (row.station, row.op) == op);
        let (Some(from), Some(to)) = (row(arrow.from), row(arrow.to)) else { continue };
        let (Some(tail), Some(head)) = (report.rows[from].simulated, report.rows[to].simulated) else { continue };
        let start = if arrow.lag == 0 { x(tail.1, span) } else { LABELS };
        let (from, to) = (y(from) + 4.0 + 1.5 * BAR, y(to) + 4.0 + 1.5 * BAR);
        let dash = if arrow.lag == 0 { "" } else { " stroke-dasharray=\"4 3\"" };
        let _ = writeln!(
            svg,
            "<line x1=\"{start:.1}\" y1=\"{from:.1}\" x2=\"{:.1}\" y2=\"{to:.1}\" stroke=\"#555\"{dash} \
             marker-end=\"url(#tip)\"/>",
            x(head.0, span)
        );
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
