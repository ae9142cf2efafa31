//! Plan and actual as a Gantt chart: resources down, time across.
//!
//! A row for each resource that works or carries; stores are left out, since they do nothing. Where anything was planned,
//! the plan is a line of its own above what was really done.

use std::fmt::Write as _;

use linewright_coordinator_cell::tracking::FinishedActivity;
use linewright_line::Tick;

use super::story::ReportSource;
use crate::chart::svg::{PLANNED, SvgChart, SvgStyle, TimeLabels, escaped};
use crate::chart::{ActivityBar, BarChart, BarRow};

/// Characters for the time.
const WIDTH: usize = 100;
/// The margin for names, at least.
const LABELS_MIN: f64 = 80.0;
/// Average width of a letter, in bold type.
const LETTER: f64 = 8.0;
/// By product, again from the first where there are more.
const COLOURS: [&str; 8] = ["#2f6fb0", "#3a923a", "#b8860b", "#7a4fa3", "#1f8a8a", "#a0522d", "#5b6b7b", "#9c3d6b"];
const FAILED: &str = "url(#down)";

const STYLE: SvgStyle = SvgStyle {
    defs: "<pattern id=\"down\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" \
           patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"#f4d3cf\"/>\
           <rect width=\"2.5\" height=\"6\" fill=\"#c0392b\"/></pattern>",
    width: 1000.0,
    row: 34.0,
    top: 70.0,
    bottom: 24.0,
    grid: 18.0,
    times: TimeLabels::Below,
    baseline: 21.0,
    plan: (4.0, 9.0),
    done: (14.0, 15.0),
    failed: FAILED,
    outline: " stroke=\"white\" stroke-width=\"0.5\"",
    planned: "planned ",
};

fn chart(story: &ReportSource) -> BarChart {
    let sheet = &story.about.sheet;
    let seconds = |tick: Tick| tick.since(story.from).as_secs_f64();
    let bar = |done: &FinishedActivity| {
        let entry = sheet.entry(done.mode);
        let name = entry.map(|entry| entry.name.as_str()).unwrap_or_default();
        let part = done.part.map(|part| format!(", {part}")).unwrap_or_default();
        let product = entry.and_then(|entry| entry.product);
        ActivityBar {
            about: format!("{name}{part}: "),
            number: done.part.map(|part| part.0),
            planned: story.planned.get(&done.firing).map(|&(from, to)| (seconds(from), seconds(to))),
            actual: Some((seconds(done.began), seconds(done.ended.unwrap_or(story.to).min(story.to)))),
            failed: done.failed.as_ref().map(|failed| (seconds(failed.at), failed.cause.clone())),
            colour: product.map_or(COLOURS[6], |product| COLOURS[product % COLOURS.len()]),
        }
    };
    let does = |done: &&FinishedActivity, resource: usize| {
        let entry = sheet.entry(done.mode);
        entry.is_some_and(|entry| [entry.worker, entry.carrier].contains(&Some(resource)))
    };
    let rows = sheet.resources.iter().enumerate().map(|(resource, of)| {
        let done = story.activities.iter().filter(|done| does(done, resource));
        // An activity without duration has no bar.
        let bars = done.filter(|done| done.ended != Some(done.began)).map(bar).collect();
        BarRow { group: Some(of.name.clone()), name: String::new(), bars }
    });
    BarChart::new(rows.filter(|row| !row.bars.is_empty()).collect(), seconds(story.to))
}

/// As text: the number of its part where a bar begins, `▒` what was planned, `█` what was done, `░` what had failed.
pub fn text(story: &ReportSource) -> String {
    let (chart, from, to) = (chart(story), story.show(story.from), story.show(story.to));
    let name = |row: &'_ BarRow| row.group.clone().unwrap_or_default();
    let label = chart.rows.iter().map(|row| name(row).chars().count()).max().unwrap_or(0);
    let mut text = format!("{:label$} {from}{:>width$}\n", "", to, width = WIDTH - from.chars().count() + 1);
    let has_plan = chart.has_plan();
    for (number, row) in chart.rows.iter().enumerate() {
        let (mut name, done) = (name(row), chart.done(number, WIDTH));
        // Writing to a string does not fail.
        if has_plan {
            let _ = writeln!(text, "{name:label$} │{}│", chart.plan(number, WIDTH));
            name.clear();
        }
        let _ = writeln!(text, "{name:label$} │{done}│");
    }
    text
}

/// As SVG: the plan above what was done, what had failed hatched.
pub fn svg(story: &ReportSource) -> String {
    let chart = chart(story);
    let letters = chart.rows.iter().flat_map(|row| &row.group).map(|name| name.chars().count() as f64 * LETTER + 24.0);
    let labels = letters.fold(LABELS_MIN, f64::max);
    let (from, to) = (story.show(story.from), story.show(story.to));
    let mut svg = SvgChart::new(&chart, &STYLE, labels, &format!("{}, {from} to {to}", story.about.title));
    legend(&mut svg, story);
    svg.rows();
    svg.end()
}

fn legend(svg: &mut SvgChart<'_>, story: &ReportSource) {
    let products = story.about.sheet.products.iter().zip(COLOURS.iter().cycle());
    let marks = [("planned", PLANNED), ("failed, down", FAILED)].into_iter();
    let mut left = 8.0;
    for (name, colour) in marks.chain(products.map(|(name, colour)| (name.as_str(), *colour))) {
        svg.line(format_args!(
            "<rect x=\"{left:.1}\" y=\"32\" width=\"18\" height=\"9\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"41\">{}</text>",
            left + 24.0,
            escaped(name)
        ));
        left += 40.0 + name.chars().count() as f64 * LETTER;
    }
}
