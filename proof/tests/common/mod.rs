//! Common to several tests: the number of lines, a line's parts, and a property by its name.

use linewright_line::net::ControlMode;
use linewright_line::{Arrow, Conflict, Line};
use linewright_proof::explore::{Grants, LineExploration, LineExplored, SearchLimits, Verdict, explore};
use linewright_proof::structure::chart::{every_circuit_has_a_token, home_is_consistent, run_ahead};

/// As far as a test looks.
pub fn limit(states: usize) -> SearchLimits {
    SearchLimits { states, ..SearchLimits::default() }
}

/// The line as it is in auto mode alone.
pub fn in_auto(line: &Line) -> Line {
    let arrows = line.arrows.iter().filter(|arrow| arrow.auto);
    Line { arrows: arrows.map(|arrow| Arrow { manual: true, ..*arrow }).collect(), ..line.clone() }
}

pub fn with_conflict(line: &Line, conflict: &Conflict) -> Line {
    Line { conflicts: vec![conflict.clone()], ..line.clone() }
}

/// Auto mode, and nothing fails.
pub fn undisturbed(line: &Line) -> LineExploration {
    let mut setting = LineExploration::new(line);
    (setting.modes, setting.grants, setting.faults) = (vec![ControlMode::Auto], Grants::Anyhow, false);
    setting
}

/// Auto and manual, each station in whichever it receives.
pub fn auto_and_manual(line: &Line) -> LineExploration {
    let mut setting = LineExploration::new(line);
    (setting.modes, setting.grants) = (vec![ControlMode::Auto, ControlMode::Manual], Grants::Anyhow);
    setting
}

pub fn explored(setting: &LineExploration, states: usize) -> LineExplored {
    explore(setting, limit(states)).expect("a generated line can be explored")
}

/// The verdict on the property whose name begins like this.
pub fn verdict(explored: &LineExplored, name: &str) -> Verdict {
    let found = explored.properties.iter().find(|property| property.name.starts_with(name));
    found.unwrap_or_else(|| panic!("nothing was asked that begins with `{name}`")).verdict
}

pub const CONFLICT: &str = "never: ";
pub const APART: &str = "stations stay within";
pub const SOUND: &str = "stations sound";
pub const DEADLOCK: &str = "no deadlock";
pub const REVERSIBLE: &str = "reversible and live";
pub const HOME: &str = "home can be reached";

/// Whether some conflict was met.
pub fn met(explored: &LineExplored) -> bool {
    explored.properties.iter().any(|p| p.name.starts_with(CONFLICT) && p.verdict == Verdict::Fails)
}

/// Whether the chart may be taken at its word: home is consistent and the line is live.
pub fn begins_well(line: &Line) -> bool {
    home_is_consistent(line).is_ok() && every_circuit_has_a_token(line).is_ok()
}

/// Whether no station can run away from another.
pub fn keeps_together(line: &Line) -> bool {
    every_circuit_has_a_token(line).is_ok() && run_ahead(line).is_empty()
}
