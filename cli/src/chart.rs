//! Bar charts: a row for each resource or operation, time from left to right. Drawn as text ([`text`]) or as SVG ([`svg`]).
//!
//! A bar shows one activity: planned from … to …, done from … to …, and the time from which it had failed.

pub mod svg;
pub mod text;

pub struct BarChart {
    /// Top row first.
    pub rows: Vec<BarRow>,
    /// Length of the time axis, in seconds.
    pub span: f64,
}

/// One row.
pub struct BarRow {
    /// Name of the group that begins with this row, e.g. a station.
    pub group: Option<String>,
    /// Name of the row within its group, e.g. an operation; may be empty.
    pub name: String,
    /// Sorted by start.
    pub bars: Vec<ActivityBar>,
}

/// Start and end, in seconds from the left end of the chart.
pub type TimeSpan = (f64, f64);

/// One activity.
pub struct ActivityBar {
    /// Text before the times in the tool tip.
    pub about: String,
    /// Number drawn inside the bar where it fits, e.g. of a part.
    pub number: Option<u64>,
    pub planned: Option<TimeSpan>,
    /// Up to the end of the chart while it is in progress.
    pub actual: Option<TimeSpan>,
    /// Time of the failure, and its cause.
    pub failed: Option<(f64, String)>,
    /// Fill of the actual bar in SVG.
    pub colour: &'static str,
}

impl BarChart {
    /// A chart that ends with its last bar, and not before `least` seconds.
    pub fn new(rows: Vec<BarRow>, least: f64) -> Self {
        let bars = rows.iter().flat_map(|row| &row.bars).flat_map(|bar| [bar.planned, bar.actual]).flatten();
        let span = bars.map(|(_, to)| to).fold(least, f64::max).max(1e-6);
        BarChart { rows, span }
    }

    /// Whether any bar has planned times.
    pub fn has_plan(&self) -> bool {
        self.rows.iter().flat_map(|row| &row.bars).any(|bar| bar.planned.is_some())
    }
}
