//! The two barriers before the motions of each conflict: counts, which `check` explores, and measured positions.

use linewright_line::{Conflict, Line, StateSpan};
use linewright_proof::parts::SubLine;
use linewright_proof::positions::{PositionRules, explore_positions};
use linewright_station_logic::CompileError;
use serde::Serialize;

/// Most states of an exploration of measured positions. The shipped line has 6,930.
const STATES_MAX: usize = 1_000_000;

/// Barriers of one conflict.
#[derive(Debug, Serialize)]
pub struct Barriers {
    /// The conflict.
    pub why: String,
    /// It is of tasks: orders keep them apart, and no counts.
    #[serde(skip)]
    is_of_tasks: bool,
    /// For each side, the station and the limit switches that are all on only outside its state.
    pub measured: Vec<Clearance>,
    /// Why switches do not hold it; empty where they do.
    pub not_measured: Vec<String>,
    /// Result for measured positions by themselves; none where they do not hold it.
    pub by_themselves: Option<ByThemselves>,
}

/// Result with any motion commanded at any moment, and measured positions alone against it.
#[derive(Clone, Debug, Serialize)]
pub struct ByThemselves {
    /// Number of states seen.
    pub states: usize,
    /// `holds`, `fails` or `undecided`.
    pub verdict: &'static str,
    /// Path to both states of the conflict.
    pub counterexample: Vec<String>,
}

/// The switches of one side.
#[derive(Debug, Serialize)]
pub struct Clearance {
    pub station: String,
    pub inputs: Vec<String>,
}

/// The barriers of every conflict of a line, explored under these rules; not explored without.
///
/// # Errors
/// When a station does not compile.
pub fn of(line: &Line, rules: Option<PositionRules>) -> Result<Vec<Barriers>, CompileError> {
    let mut known = Vec::new();
    line.conflicts.iter().map(|conflict| of_conflict(line, conflict, rules, &mut known)).collect()
}

/// Conflicts of two stations that have been explored: the two alone, and what was found.
type Known = Vec<(SubLine, ByThemselves)>;

fn of_conflict(
    line: &Line,
    conflict: &Conflict,
    rules: Option<PositionRules>,
    known: &mut Known,
) -> Result<Barriers, CompileError> {
    let mut barriers = Barriers {
        why: conflict.why.clone(),
        is_of_tasks: line.is_of_tasks(conflict),
        measured: Vec::new(),
        not_measured: Vec::new(),
        by_themselves: None,
    };
    for span in [&conflict.a, &conflict.b] {
        let station = line.station(span.station);
        match line.clearance(span) {
            Ok(inputs) => {
                barriers.measured.push(Clearance { station: station.name.clone(), inputs: named(line, span, inputs) })
            }
            Err(why) => barriers.not_measured.push(why.text(station)),
        }
    }
    if let Some(rules) = rules.filter(|_| barriers.not_measured.is_empty()) {
        let alone = SubLine::of_conflict(line, conflict);
        if let Some((_, found)) = known.iter().find(|(other, found)| found.verdict == "holds" && alone.is_like(other)) {
            barriers.by_themselves = Some(found.clone());
            return Ok(barriers);
        }
        let found = explore_positions(line, conflict, rules, STATES_MAX)?;
        let verdict = match (&found.counterexample, found.exhausted) {
            (Some(_), _) => "fails",
            (None, true) => "holds",
            (None, false) => "undecided",
        };
        let counterexample = found.counterexample.unwrap_or_default();
        let found = ByThemselves { states: found.states, verdict, counterexample };
        known.push((alone, found.clone()));
        barriers.by_themselves = Some(found);
    }
    Ok(barriers)
}

fn named(line: &Line, span: &StateSpan, inputs: u128) -> Vec<String> {
    let names = line.station(span.station).inputs.iter().enumerate();
    names.filter(|(bit, _)| inputs & (1 << bit) != 0).map(|(_, name)| name.clone()).collect()
}

impl Barriers {
    /// Measured positions exclude what they are derived to exclude, as far as that was looked at.
    pub fn holds(&self) -> bool {
        self.by_themselves.as_ref().is_none_or(|found| found.verdict != "fails")
    }

    /// A line for a person; more where measured positions fail.
    pub fn text(&self) -> String {
        let first = if self.is_of_tasks { "orders" } else { "counts" };
        match (&self.not_measured[..], &self.measured[..]) {
            ([], _) => (),
            ([why], [side]) if self.is_of_tasks => {
                let inputs = side.inputs.join(" and ");
                return format!("orders, and one way measured positions ({inputs} of {}): {why}", side.station);
            }
            (whys, _) => return format!("one barrier, {first}: {}", whys.join("; ")),
        }
        let sides: Vec<String> =
            self.measured.iter().map(|side| format!("{} of {}", side.inputs.join(" and "), side.station)).collect();
        let sides = format!("{first} and measured positions ({})", sides.join(", "));
        let Some(ByThemselves { states, verdict, counterexample }) = &self.by_themselves else { return sides };
        match *verdict {
            "holds" => format!(
                "{sides}; excluded by measured positions alone, for every command and memory ({states} states), \
                 except two starts within one report delay"
            ),
            "fails" => {
                format!("{sides}; ✗ positions by themselves do not exclude it:\n    {}", counterexample.join("\n    "))
            }
            _ => format!("{sides}; positions by themselves: undecided after {states} states"),
        }
    }
}
