//! The timing bar chart as text: operations down, time across, planned over simulated.
//!
//! A line of text is two halves high. The upper one is the bar of the plan, the lower one that of the simulation, so a
//! deviation shows as a step.

use linewright_line::{Line, OpId};

use super::report::{OperationRow, OperationSpan};

/// Characters for the time.
const WIDTH: usize = 60;

pub fn draw(line: &Line, rows: &[OperationRow]) -> String {
    let station_width = line.stations.iter().map(|s| s.name.chars().count()).max().unwrap_or(0);
    let operations = line.stations.iter().flat_map(|s| &s.operations);
    let operation_width = operations.map(|o| o.name.chars().count()).max().unwrap_or(0);
    let bars = rows.iter().flat_map(|row| [row.planned, row.simulated]).flatten();
    let span = bars.map(|bar| bar.1).fold(1e-6, f64::max);
    let label = station_width + operation_width + 4;
    let mut text = scale(label, span);
    for row in rows {
        let station = line.station(row.station);
        let name = if row.op == OpId(0) { station.name.as_str() } else { "" };
        let operation = &station.operations[row.op.index()].name;
        let star = if row.op == station.home { '*' } else { ' ' };
        let critical = if row.is_critical { '!' } else { ' ' };
        let cells: String = (0..WIDTH).map(|cell| glyph(row, cell, span)).collect();
        let times = row.simulated.map_or(String::new(), |(start, end)| format!(" {start:.3} – {end:.3}"));
        let cells = format!("{name:station_width$} {operation:operation_width$}{star}{critical} │{cells}│{times}");
        text.push_str(cells.trim_end());
        text.push('\n');
    }
    text
}

fn scale(label: usize, span: f64) -> String {
    let end = format!("{span:.3} s");
    let pad = WIDTH.saturating_sub(end.chars().count() + 1);
    format!("{:label$}│0{:pad$}{end}│\n", "", "")
}

fn glyph(row: &OperationRow, cell: usize, span: f64) -> char {
    let covers = |bar: Option<OperationSpan>| {
        // To the nearest boundary of a cell, so that bars which follow each other do not overlap; at least one wide.
        let column = |at: f64| (at / span * WIDTH as f64).round() as usize;
        bar.is_some_and(|(start, end)| (column(start)..column(end).max(column(start) + 1)).contains(&cell))
    };
    match (covers(row.planned), covers(row.simulated)) {
        (true, true) => '█',
        (true, false) => '▀',
        (false, true) => '▄',
        (false, false) => ' ',
    }
}
