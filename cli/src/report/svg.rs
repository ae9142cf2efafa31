//! The Gantt chart as SVG: resources down, time across, the plan above what was done, what had failed hatched.

use std::fmt::Write as _;

use super::gantt::{GanttBar, GanttChart};
use super::story::ReportSource;
use crate::drawing::{escaped, steps};

/// The margin for names, at least.
const LABELS_MIN: f64 = 80.0;
/// What a letter takes on average, in bold type.
const LETTER: f64 = 8.0;
const CHART: f64 = 1000.0;
const ROW: f64 = 34.0;
const TOP: f64 = 70.0;
const PLAN: f64 = 9.0;
const BAR: f64 = 15.0;
const PLANNED: &str = "#b8c4d0";
/// By product, again from the first where there are more.
const COLOURS: [&str; 8] = ["#2f6fb0", "#3a923a", "#b8860b", "#7a4fa3", "#1f8a8a", "#a0522d", "#5b6b7b", "#9c3d6b"];

pub fn draw(story: &ReportSource, chart: &GanttChart) -> String {
    let letters = chart.rows.iter().map(|row| row.name.chars().count() as f64 * LETTER + 24.0);
    let labels = letters.fold(LABELS_MIN, f64::max);
    let (width, height) = (labels + CHART + 28.0, TOP + ROW * chart.rows.len() as f64 + 24.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n\
         <defs><pattern id=\"down\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" \
         patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"#f4d3cf\"/>\
         <rect width=\"2.5\" height=\"6\" fill=\"#c0392b\"/></pattern></defs>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let (from, to) = (story.show(story.from), story.show(story.to));
    // Writing to a string does not fail.
    let _ =
        writeln!(svg, "<text x=\"8\" y=\"20\" font-size=\"15\">{}, {from} to {to}</text>", escaped(&story.about.title));
    legend(&mut svg, story);
    let x = |at: f64| labels + at / chart.span * CHART;
    for at in steps(chart.span) {
        let (x, top, bottom) = (x(at), TOP - 4.0, height - 18.0);
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{top:.1}\" x2=\"{x:.1}\" y2=\"{bottom:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#777\">{at} s</text>",
            height - 6.0
        );
    }
    for (number, row) in chart.rows.iter().enumerate() {
        let y = TOP + ROW * number as f64;
        let _ = writeln!(
            svg,
            "<line x1=\"0\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\" stroke=\"#999\"/>\
             <text x=\"8\" y=\"{:.1}\" font-weight=\"bold\">{}</text>",
            labels + CHART,
            y + 21.0,
            escaped(&row.name)
        );
        row.bars.iter().for_each(|bar| draw_bar(&mut svg, bar, y, x));
    }
    svg.push_str("</svg>\n");
    svg
}

fn legend(svg: &mut String, story: &ReportSource) {
    let products = story.about.sheet.products.iter().zip(COLOURS.iter().cycle());
    let marks = [("planned", PLANNED), ("failed, down", "url(#down)")].into_iter();
    let mut left = 8.0;
    for (name, colour) in marks.chain(products.map(|(name, colour)| (name.as_str(), *colour))) {
        let _ = writeln!(
            svg,
            "<rect x=\"{left:.1}\" y=\"32\" width=\"18\" height=\"9\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"41\">{}</text>",
            left + 24.0,
            escaped(name)
        );
        left += 40.0 + name.chars().count() as f64 * LETTER;
    }
}

fn draw_bar(svg: &mut String, bar: &GanttBar, y: f64, x: impl Fn(f64) -> f64) {
    let part = bar.part.map(|part| format!(", part {part}")).unwrap_or_default();
    let mut rectangle = |(from, to): (f64, f64), (top, height): (f64, f64), fill: &str, what: &str| {
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height}\" fill=\"{fill}\" stroke=\"white\" \
             stroke-width=\"0.5\"><title>{}{part}: {}{from:.3} – {to:.3} s</title></rect>",
            x(from.max(0.0)),
            y + top,
            (x(to) - x(from.max(0.0))).max(1.0),
            escaped(&bar.name),
            escaped(what)
        );
    };
    if let Some(planned) = bar.planned {
        rectangle(planned, (4.0, PLAN), PLANNED, "planned ");
    }
    let (from, to) = bar.actual;
    let colour = bar.product.map_or(COLOURS[6], |product| COLOURS[product % COLOURS.len()]);
    let sound_until = bar.failed.as_ref().map_or(to, |(at, _)| at.max(from));
    rectangle((from, sound_until), (5.0 + PLAN, BAR), colour, "");
    if let Some((at, cause)) = &bar.failed {
        rectangle((*at, to), (5.0 + PLAN, BAR), "url(#down)", &format!("{cause} "));
    }
    // The number where there is room for it.
    if let Some(part) = bar.part.filter(|_| x(sound_until) - x(from.max(0.0)) > 18.0) {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"10\" fill=\"white\">{part}</text>",
            x(from.max(0.0)) + 3.0,
            y + 16.0 + PLAN
        );
    }
}
