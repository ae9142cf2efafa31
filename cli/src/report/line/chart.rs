//! A cycle of a line, planned and measured: operations down, time across.

use linewright_history::line::{CycleChart, PlannedRow};

use super::LineSource;
use crate::chart::svg::{BOLD, BY_OPERATION, LETTER, PLANNED, SvgChart, SvgStyle};
use crate::chart::{ActivityBar, BarChart, BarRow};

/// Characters for the time.
const WIDTH: usize = 80;
/// Least margin for names: the legend needs this much.
const LABELS_MIN: f64 = 240.0;
const MEASURED: &str = "#2f6fb0";
const STOPPED: &str = "#c0392b";

const STYLE: SvgStyle = SvgStyle { failed: STOPPED, planned: "planned ", ..BY_OPERATION };

fn chart(source: &LineSource, of: &CycleChart) -> BarChart {
    let row = |row: &PlannedRow| {
        let station = &source.about.stations[row.station];
        let name = station.operations[row.operation].name.clone();
        let bar = |planned, actual, colour| ActivityBar {
            about: format!("{}: {name}: ", station.name),
            number: None,
            planned,
            actual,
            failed: None,
            colour,
        };
        let measured = row
            .measured
            .iter()
            .map(|&(from, to, is_stopped)| bar(None, Some((from, to)), if is_stopped { STOPPED } else { MEASURED }));
        let bars = row.planned.map(|planned| bar(Some(planned), None, MEASURED)).into_iter().chain(measured).collect();
        BarRow { group: (row.operation == 0).then(|| station.name.clone()), name, bars }
    };
    BarChart::new(of.rows.iter().map(row).collect(), 0.0)
}

/// As text: planned bars in the upper half of a row, measured ones in the lower.
pub fn text(source: &LineSource, of: &CycleChart) -> String {
    let chart = chart(source, of);
    let groups = source.about.stations.iter().map(|station| station.name.chars().count()).max().unwrap_or(0);
    let names = chart.rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
    let mut lines = vec![format!("cycle {}, from {}:  ▀ planned  ▄ measured  █ both", of.cycle, source.show(of.began))];
    for (number, row) in chart.rows.iter().enumerate() {
        let (group, bars) = (row.group.as_deref().unwrap_or_default(), chart.halves(number, WIDTH));
        lines.push(format!("{group:groups$}  {:names$} │{bars}│", row.name));
    }
    let end = format!("{:.3} s", chart.span);
    lines.push(format!("{:1$}{end}", "", (groups + names + 4 + WIDTH).saturating_sub(end.len())));
    lines.join("\n")
}

/// As SVG.
pub fn svg(source: &LineSource, of: &CycleChart) -> String {
    let chart = chart(source, of);
    let widest = |names: &mut dyn Iterator<Item = &String>, letter: f64| {
        names.map(|name| name.chars().count() as f64 * letter).fold(0.0, f64::max)
    };
    let groups = widest(&mut chart.rows.iter().filter_map(|row| row.group.as_ref()), BOLD);
    let labels = (groups + widest(&mut chart.rows.iter().map(|row| &row.name), LETTER) + 40.0).max(LABELS_MIN);
    let title = format!("{}, cycle {} from {}", source.about.title, of.cycle, source.show(of.began));
    let mut svg = SvgChart::new(&chart, &STYLE, labels, &title);
    for (number, (name, colour)) in
        [("planned", PLANNED), ("measured", MEASURED), ("stopped", STOPPED)].into_iter().enumerate()
    {
        let left = 8.0 + 100.0 * number as f64;
        svg.line(format_args!(
            "<rect x=\"{left:.1}\" y=\"30\" width=\"18\" height=\"9\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"39\">{name}</text>",
            left + 24.0
        ));
    }
    svg.rows();
    svg.end()
}
