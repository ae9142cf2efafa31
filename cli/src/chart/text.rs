//! Bar charts as text: a row is a line of characters.

use std::fmt::{self, Display};
use std::ops::Range;

use super::{ActivityBar, BarChart, TimeSpan};

/// A line of characters that bars are drawn into.
pub struct TextStrip {
    cells: Vec<char>,
}

impl TextStrip {
    /// All spaces.
    pub fn new(width: usize) -> Self {
        TextStrip { cells: vec![' '; width] }
    }

    /// Columns of a bar in a line of `span` seconds: rounded to character boundaries, so that successive bars do not
    /// overlap, and at least one wide.
    fn range(&self, span: f64, (from, to): TimeSpan) -> Range<usize> {
        let width = self.cells.len();
        let from = column(width, span, from).min(width.saturating_sub(1));
        from..column(width, span, to).max(from + 1)
    }

    /// Replaces each character of a range by `glyph` of it; the part of the range beyond the line is ignored.
    pub fn fill(&mut self, range: Range<usize>, glyph: impl Fn(char) -> char) {
        let count = range.len();
        self.cells.iter_mut().skip(range.start).take(count).for_each(|cell| *cell = glyph(*cell));
    }

    /// Overwrites from column `at`; the part beyond the line is ignored.
    pub fn write(&mut self, at: usize, text: &str) {
        self.cells.iter_mut().skip(at).zip(text.chars()).for_each(|(cell, letter)| *cell = letter);
    }
}

fn column(width: usize, span: f64, at: f64) -> usize {
    ((at / span * width as f64).round().max(0.0) as usize).min(width)
}

impl Display for TextStrip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.cells.iter().try_for_each(|cell| write!(f, "{cell}"))
    }
}

impl BarChart {
    /// A row in half-height blocks: planned bars in the upper half, actual bars in the lower.
    pub fn halves(&self, row: usize, width: usize) -> TextStrip {
        let mut strip = TextStrip::new(width);
        for bar in &self.rows[row].bars {
            let planned = bar.planned.map(|span| strip.range(self.span, span));
            strip.fill(planned.unwrap_or_default(), |_| '▀');
            let actual = bar.actual.map(|span| strip.range(self.span, span));
            strip.fill(actual.unwrap_or_default(), |cell| if cell == ' ' { '▄' } else { '█' });
        }
        strip
    }

    /// The planned bars of a row, as `▒`.
    pub fn plan(&self, row: usize, width: usize) -> TextStrip {
        let mut strip = TextStrip::new(width);
        for bar in &self.rows[row].bars {
            if let Some(planned) = bar.planned {
                let range = strip.range(self.span, planned);
                strip.fill(range.clone(), |_| '▒');
                strip.number(bar, range);
            }
        }
        strip
    }

    /// The actual bars of a row, as `█`, and as `░` after a failure.
    pub fn done(&self, row: usize, width: usize) -> TextStrip {
        let mut strip = TextStrip::new(width);
        for bar in &self.rows[row].bars {
            if let Some(actual) = bar.actual {
                let range = strip.range(self.span, actual);
                strip.fill(range.clone(), |_| '█');
                if let Some((at, _)) = bar.failed {
                    let from = column(width, self.span, at).max(range.start);
                    strip.fill(from..range.end.max(from), |_| '░');
                }
                strip.number(bar, range);
            }
        }
        strip
    }
}

impl TextStrip {
    /// Writes the bar's number at its start, if the bar is longer than that.
    fn number(&mut self, bar: &ActivityBar, range: Range<usize>) {
        let number = bar.number.map(|number| number.to_string()).unwrap_or_default();
        if number.len() < range.len() {
            self.write(range.start, &number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::BarRow;

    fn chart(planned: TimeSpan, actual: TimeSpan, failed: Option<f64>) -> BarChart {
        let failed = failed.map(|at| (at, "stuck".to_owned()));
        let (planned, actual) = (Some(planned), Some(actual));
        let bar = ActivityBar { about: String::new(), number: Some(7), planned, actual, failed, colour: "red" };
        BarChart::new(vec![BarRow { group: None, name: String::new(), bars: vec![bar] }], 10.0)
    }

    #[test]
    fn bars_are_where_their_times_are() {
        let chart = chart((1.0, 4.0), (2.0, 6.0), Some(4.0));
        assert_eq!(chart.halves(0, 10).to_string(), " ▀██▄▄    ");
        assert_eq!(chart.plan(0, 10).to_string(), " 7▒▒      ");
        assert_eq!(chart.done(0, 10).to_string(), "  7█░░    ");
    }

    #[test]
    fn a_bar_is_at_least_one_wide_and_within_the_line() {
        let chart = chart((0.0, 0.001), (9.999, 10.0), None);
        assert_eq!(chart.halves(0, 10).to_string(), "▀        ▄");
        assert_eq!(chart.done(0, 10).to_string(), "         █", "there is no room for its number");
        let mut strip = TextStrip::new(3);
        strip.fill(2..9, |_| 'x');
        strip.write(1, "abc");
        assert_eq!(strip.to_string(), " ab");
    }
}
