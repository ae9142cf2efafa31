//! The bar chart as it grows: operations down, time across, as engineers draw it.
//!
//! Pure: starts and ends of motions in, lines of text out.

use linewright_line::{Line, OpId, StationId};

use crate::chart::text::TextStrip;

/// One stretch of an operation.
#[derive(Clone, Copy, Debug)]
struct ChartStretch {
    row: usize,
    start: f64,
    end: Option<f64>,
    undoing: bool,
    failed: bool,
}

/// A bar chart over the last seconds.
#[derive(Clone, Debug)]
pub struct RollingChart {
    labels: Vec<String>,
    first_row: Vec<usize>,
    bars: Vec<ChartStretch>,
}

/// Enough for several cycles of a large line; older ones are forgotten.
const BARS_MAX: usize = 4096;

impl RollingChart {
    /// An empty chart of a line.
    pub fn new(line: &Line) -> Self {
        let mut labels = Vec::new();
        let mut first_row = Vec::new();
        let width = line.stations.iter().map(|s| s.name.chars().count()).max().unwrap_or(0);
        for station in &line.stations {
            first_row.push(labels.len());
            for (index, operation) in station.operations.iter().enumerate() {
                let name = if index == 0 { station.name.as_str() } else { "" };
                let star = if OpId::at(index) == station.home { "*" } else { " " };
                labels.push(format!("{name:width$} {}{star}", operation.name));
            }
        }
        RollingChart { labels, first_row, bars: Vec::new() }
    }

    fn row(&self, station: StationId, op: OpId) -> usize {
        self.first_row[station.index()] + op.index()
    }

    /// Whether nothing has moved since it was made.
    pub fn is_empty(&self) -> bool {
        self.bars.is_empty()
    }

    /// A motion started.
    pub fn started(&mut self, station: StationId, op: OpId, at: f64, undoing: bool) {
        let row = self.row(station, op);
        self.close(row, at, false);
        if self.bars.len() >= BARS_MAX {
            self.bars.drain(..BARS_MAX / 2);
        }
        self.bars.push(ChartStretch { row, start: at, end: None, undoing, failed: false });
    }

    /// A motion ended, completed or not.
    pub fn ended(&mut self, station: StationId, op: OpId, at: f64, failed: bool) {
        let row = self.row(station, op);
        self.close(row, at, failed);
    }

    fn close(&mut self, row: usize, at: f64, failed: bool) {
        if let Some(bar) = self.bars.iter_mut().rev().find(|bar| bar.row == row && bar.end.is_none()) {
            bar.end = Some(at);
            bar.failed = failed;
        }
    }

    /// Width of the names before the bars.
    pub fn label_width(&self) -> usize {
        self.labels.iter().map(|label| label.chars().count()).max().unwrap_or(0)
    }

    /// Draws the `seconds` before `now`, a line of text per operation, `width` characters for the time.
    pub fn draw(&self, now: f64, seconds: f64, width: usize) -> Vec<String> {
        let label_width = self.label_width();
        let begin = now - seconds;
        let column = |at: f64| (((at - begin) / seconds) * width as f64).floor().max(0.0) as usize;
        let mut strips: Vec<TextStrip> = self.labels.iter().map(|_| TextStrip::new(width)).collect();
        for bar in self.bars.iter().filter(|bar| bar.end.unwrap_or(now) >= begin) {
            let (from, to) = (column(bar.start), column(bar.end.unwrap_or(now)).min(width.saturating_sub(1)));
            let fill = if bar.undoing { '░' } else { '█' };
            strips[bar.row].fill(from..to + 1, |_| fill);
            if bar.failed {
                strips[bar.row].write(to, "✗");
            }
        }
        let rows = self.labels.iter().zip(strips);
        rows.map(|(label, strip)| format!("{label:label_width$} │{strip}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_line::TransferLine;

    #[test]
    fn a_bar_covers_its_time_and_a_fault_marks_its_end() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let mut chart = RollingChart::new(&line);
        let (clamp, op) = (StationId(1), OpId(0));
        chart.started(clamp, op, 2.0, false);
        chart.ended(clamp, op, 5.0, true);
        let rows = chart.draw(10.0, 10.0, 10);
        assert!(rows[10].ends_with("│  ███✗    "), "{:?}", rows[10]);
        chart.started(clamp, op, 8.0, true);
        assert!(chart.draw(10.0, 10.0, 10)[10].ends_with("│  ███✗  ░░"), "{:?}", chart.draw(10.0, 10.0, 10)[10]);
    }
}
