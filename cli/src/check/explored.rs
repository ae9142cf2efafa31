//! What exploring a line found, as data.

use linewright_proof::explore::{LineExplored, LinePath, LineProperty, Verdict};
use serde::Serialize;

use super::options::MEMORY;

/// One exploration, for people and programs.
#[derive(Debug, Serialize)]
pub struct Exploration {
    /// Scope: the line or some of its stations, and the modes and rules.
    pub scope: String,
    /// States seen.
    pub states: u64,
    /// States that were kept and looked at; each stands for all that differ only in what stations come and go between by
    /// themselves.
    pub kept: usize,
    /// Moves from state to state.
    pub arcs: u64,
    /// Memory it took, about.
    pub bytes: usize,
    /// Every state was seen.
    pub exhausted: bool,
    /// What ended it before that, and what lets it look further.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
    /// Of a part: the stations of the line that are not in it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Of a part that leaves a conflict open: the arrows, as they are written, that arrows of left-out stations stand for, and that keep the
    /// conflict's states apart in the part as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub direct_arrows: Vec<String>,
    /// The names of the properties that these arrows are for.
    #[serde(skip)]
    pub kept_apart: Vec<String>,
    /// It has more states than were looked at, and what must never be is decided by smaller parts. The rest is open, and not listed.
    #[serde(skip)]
    pub is_left_to_parts: bool,
    /// Stations are restarted in it, and lose their memories.
    #[serde(skip)]
    pub is_restarted: bool,
    /// One by one.
    pub properties: Vec<LineFinding>,
}

/// One property.
#[derive(Debug, Serialize)]
pub struct LineFinding {
    /// Name of the property.
    pub name: String,
    /// `holds`, `fails`, `undecided` or `remark`.
    pub verdict: &'static str,
    /// Reason of the verdict.
    pub reason: String,
    /// Path to the violation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterexample: Option<LineCounterexample>,
    /// It holds of a line if it holds of its parts.
    #[serde(skip)]
    pub holds_by_parts: bool,
    /// It fails in a part of the line, which does not decide it.
    #[serde(skip)]
    pub is_left_open: bool,
}

/// A story as data.
#[derive(Debug, Serialize)]
pub struct LineCounterexample {
    /// Steps, in order.
    pub steps: Vec<String>,
    /// Violation at the end.
    pub end: String,
    /// The bar chart, a line of text each.
    pub chart: Vec<String>,
}

impl Exploration {
    pub fn of(scope: String, explored: LineExplored) -> Self {
        let LineExplored { states, kept, arcs, bytes, exhausted, properties, .. } = explored;
        let properties = properties.into_iter().map(LineFinding::from).collect();
        Exploration {
            scope,
            states,
            kept,
            arcs,
            bytes,
            exhausted,
            help: None,
            left_out: Vec::new(),
            direct_arrows: Vec::new(),
            kept_apart: Vec::new(),
            is_left_to_parts: false,
            is_restarted: false,
            properties,
        }
    }

    /// Leaves open what fails in a part of the line: a part has more freedom than the line, so it may be prevented by what was left out.
    pub fn open_outside(&mut self) {
        let is_part = !self.left_out.is_empty();
        for property in self.properties.iter_mut().filter(|property| is_part && property.verdict == "fails") {
            property.verdict = "undecided";
            property.reason = format!("undecided: in this part {}", property.reason);
            property.is_left_open = true;
        }
        // What its search had not seen when it ended, and no part decides.
        if self.properties.iter().any(|property| property.is_left_open) {
            self.properties.retain(|property| property.verdict != "undecided" || property.holds_by_parts);
        }
    }

    /// Help below a property that fails in a part of the line, and so is left open: the stations outside the part, and what decides it. None
    /// where there is no such property.
    pub fn outside_text(&self) -> Option<String> {
        /// More names are no help to read.
        const NAMES_MAX: usize = 8;
        if self.left_out.is_empty() || !self.properties.iter().any(|property| property.is_left_open) {
            return None;
        }
        let mut names = self.left_out.iter().take(NAMES_MAX).cloned().collect::<Vec<_>>().join(", ");
        let more = self.left_out.len().saturating_sub(NAMES_MAX);
        if more > 0 {
            names += &format!(" and {more} more");
        }
        let prevented = format!("this part leaves out {names}, with arrows that may prevent this in the line");
        let arrows: String = self.direct_arrows.iter().map(|arrow| format!("\n        {arrow}")).collect();
        Some(match arrows.is_empty() {
            true => format!(
                "{prevented}: `--whole` explores all of it. Where the line is too large for that, add arrows directly between the stations of this part that keep them apart: they count in it"
            ),
            false => format!(
                "{prevented}. To decide it, write as [[arrow]] what these come to between the stations of this part; where nothing fails, they delay nothing:{arrows}"
            ),
        })
    }

    /// Whether a property has this verdict.
    pub fn has(&self, verdict: &str) -> bool {
        self.properties.iter().any(|property| property.verdict == verdict)
    }

    /// Leaves out the properties that this exploration does not decide, where smaller parts decide the conflicts: of lines that are explored in
    /// parts alone they are not listed either. `expected`: about how many states are kept of all of it.
    pub fn leave_open(&mut self, expected: u64) {
        self.properties.retain(|property| property.verdict != "undecided");
        if !self.exhausted {
            self.is_left_to_parts = true;
            // Where there are more than expected, nothing is known of how many more.
            let (size, end) = match expected > self.kept as u64 {
                true => {
                    (format!("about {} kept states are expected of the whole", rounded(expected)), "looks at them all")
                }
                false => (
                    format!("fewer kept states were expected of the whole than the {} seen", self.kept),
                    "looks further",
                ),
            };
            let states = rounded(expected.max(self.kept as u64).saturating_mul(2));
            let memory = states.saturating_mul((self.bytes / self.kept.max(1)) as u64) >> 20;
            self.help = Some(format!(
                "conflicts and each station are decided by the parts below, from which {size}; `--whole --states {states} --memory {}` {end}, if the memory suffices",
                memory.max(MEMORY as u64)
            ));
        }
    }

    /// Whether every property holds; a remark does not speak against the line.
    pub fn holds(&self) -> bool {
        self.properties.iter().all(|property| matches!(property.verdict, "holds" | "remark"))
    }
}

/// To two digits: more are not known of an expected number.
fn rounded(number: u64) -> u64 {
    let unit = 10_u64.pow(number.checked_ilog10().unwrap_or(0).saturating_sub(1));
    number / unit * unit
}

impl LineFinding {
    /// It is not decided to hold, and larger parts may decide that.
    pub fn is_open_by_parts(&self) -> bool {
        self.holds_by_parts && matches!(self.verdict, "fails" | "undecided")
    }
}

impl From<LineProperty> for LineFinding {
    fn from(property: LineProperty) -> Self {
        let verdict = match property.verdict {
            Verdict::Holds => "holds",
            Verdict::Fails => "fails",
            Verdict::Undecided => "undecided",
            Verdict::Remark => "remark",
        };
        let counterexample = property.counterexample.map(LineCounterexample::from);
        let LineProperty { name, reason, holds_by_parts, .. } = property;
        LineFinding { name, verdict, reason, counterexample, holds_by_parts, is_left_open: false }
    }
}

impl From<LinePath> for LineCounterexample {
    fn from(LinePath { steps, end, chart }: LinePath) -> Self {
        LineCounterexample { steps, end, chart }
    }
}
