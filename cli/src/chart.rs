//! Bar charts: rows down, time across. One description, drawn as text for a terminal and as SVG.
//!
//! An activity has up to two bars, when it was planned and when it was done, and may have failed on its way. What the rows
//! stand for, their callers know.

pub mod svg;
pub mod text;

/// A chart.
pub struct BarChart {
    /// From top to bottom.
    pub rows: Vec<BarRow>,
    /// How long it is, in seconds.
    pub span: f64,
}

/// One line of bars.
pub struct BarRow {
    /// What this row and those after it belong to, if it is the first of them.
    pub group: Option<String>,
    /// What it is itself; empty where the group says enough.
    pub name: String,
    /// In the order in which they started.
    pub bars: Vec<ActivityBar>,
}

/// From and to, in seconds from the beginning of the chart.
pub type TimeSpan = (f64, f64);

/// An activity.
pub struct ActivityBar {
    /// What is written before its times, for people.
    pub about: String,
    /// What is written into it, where there is room.
    pub number: Option<u64>,
    /// When it was planned.
    pub planned: Option<TimeSpan>,
    /// When it was done; until the end of the chart if it goes on.
    pub actual: Option<TimeSpan>,
    /// From when on it had failed, and why.
    pub failed: Option<(f64, String)>,
    /// Of what was done, in SVG.
    pub colour: &'static str,
}

impl BarChart {
    /// A chart that is as long as its bars, and at least as this.
    pub fn new(rows: Vec<BarRow>, least: f64) -> Self {
        let bars = rows.iter().flat_map(|row| &row.bars).flat_map(|bar| [bar.planned, bar.actual]).flatten();
        let span = bars.map(|(_, to)| to).fold(least, f64::max).max(1e-6);
        BarChart { rows, span }
    }

    /// Something of it was planned.
    pub fn has_plan(&self) -> bool {
        self.rows.iter().flat_map(|row| &row.bars).any(|bar| bar.planned.is_some())
    }
}
