//! The two barriers before the motions of each conflict: counts, which `check` explores, and measured positions.

use linewright_line::{Conflict, Line, OpId, OperationModule, StateSpan};
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
    /// What to change where measured positions do not exclude it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
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
        help: None,
    };
    for span in [&conflict.a, &conflict.b] {
        let station = line.station(span.station);
        match line.clearance(span) {
            Ok(inputs) => barriers
                .measured
                .push(Clearance { station: station.name.clone(), inputs: named(line, span, inputs.on) }),
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
        if verdict == "fails" && rules == PositionRules::ALL {
            barriers.help = Some(what_to_change(line, conflict));
        }
        known.push((alone, found.clone()));
        barriers.by_themselves = Some(found);
    }
    Ok(barriers)
}

/// Remedy where switches that are all on outside a state are all on within it as well.
fn what_to_change(line: &Line, conflict: &Conflict) -> String {
    let ends = [&conflict.a, &conflict.b].into_iter().flat_map(|span| [(span, "from"), (span, "until")]);
    ends.filter_map(|(span, key)| beside_measured(line, span, key)).next().unwrap_or_else(|| {
        "begin and end each state with motions of the mechanism that is in the way, so that its switch is on all the time \
         outside the state and at no moment within it; as it is, counts alone exclude the conflict where switches are not enough"
            .to_owned()
    })
}

/// A state that begins or ends with one operation of a group, while the switches are those of another one of it.
fn beside_measured(line: &Line, span: &StateSpan, key: &str) -> Option<String> {
    let station = line.station(span.station);
    let inputs = line.clearance(span).ok()?.on;
    let end = if key == "from" { span.from } else { span.until };
    let is_measured = |op: OpId| {
        let operation = &station.operations[op.index()];
        let outside = match (&operation.module, key) {
            (OperationModule::Reversible { recovery, .. }, "from") => recovery.complete,
            _ => operation.normal.complete,
        };
        inputs & outside.bit() != 0
    };
    let group = &station.steps[station.step_of(end)];
    let measured = *group.iter().find(|&&op| op != end && is_measured(op)).filter(|_| !is_measured(end))?;
    let (name, of) = (&station.operations[end.index()].name, &station.name);
    let other = &station.operations[measured.index()].name;
    let inputs = named(line, span, inputs).join(" and ");
    Some(format!(
        "`{name}` of {of} runs side by side with `{other}`, and {inputs} may be on while it moves: `{key} = \"{other}\"` \
         if `{name}` is in nobody's way, or else `{name}` in a step of its own"
    ))
}

fn named(line: &Line, span: &StateSpan, inputs: u128) -> Vec<String> {
    let names = line.station(span.station).inputs.iter().enumerate();
    names.filter(|(bit, _)| inputs & (1 << bit) != 0).map(|(_, name)| name.clone()).collect()
}

impl Barriers {
    /// Verdict on measured positions by themselves; none where that was not looked at.
    pub fn verdict(&self) -> Option<&'static str> {
        self.by_themselves.as_ref().map(|found| found.verdict)
    }

    /// Measured positions exclude what they are derived to exclude, as far as that was looked at.
    pub fn holds(&self) -> bool {
        self.verdict().is_none_or(|verdict| verdict == "holds")
    }

    /// Path to both states of the conflict; empty where measured positions exclude it.
    pub fn steps(&self) -> &[String] {
        self.by_themselves.as_ref().map_or(&[], |found| &found.counterexample)
    }

    /// A line for a person.
    pub fn text(&self) -> String {
        let first = if self.is_of_tasks { "orders" } else { "counts" };
        match (&self.not_measured[..], &self.measured[..]) {
            ([], _) => (),
            ([why], [side]) if self.is_of_tasks => {
                let inputs = side.inputs.join(" and ");
                return format!("orders, and one way measured positions ({inputs} of {}): {why}", side.station);
            }
            (whys, _) if self.is_of_tasks => return format!("one barrier, {first}: {}", whys.join("; ")),
            (whys, _) => {
                let lost =
                    "after the loss of a journal panels may lead nowhere: the stations are brought home by hand then";
                return format!("one barrier, {first}: {}; {lost}", whys.join("; "));
            }
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
                let steps = counterexample.len();
                format!("{sides}; positions by themselves do not exclude it: after {steps} steps")
            }
            _ => format!("{sides}; positions by themselves: undecided after {states} states"),
        }
    }
}
