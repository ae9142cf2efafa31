//! The exploration of a line as part of a check: what is explored, and what it found as data.

use clap::{Args, ValueEnum};
use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_proof::cell::protocol;
use linewright_proof::explore::{
    Grants, LimitReached, LineExploration, LineExplored, LineNotExplorable, LinePath, LineProperty, SearchLimits,
    Verdict, explore,
};
use linewright_proof::parts::{self, cyclic, smallest_parts, task_driven};
use linewright_proof::positions::PositionRules;
use serde::Serialize;

use crate::parts::{PartList, at_least_1};

/// What is explored, and how freely.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Exploration")]
pub struct ExploreOptions {
    /// Check structure only, without exploration.
    #[arg(long, conflicts_with_all = ["modes", "views", "no_faults", "any_grants", "flags", "without", "whole", "states", "memory", "parts", "expanded"])]
    structure: bool,
    /// Mode that may be granted; repeat it for several [default: all].
    #[arg(long = "mode", value_enum)]
    modes: Vec<GrantedMode>,
    /// Age of the reports that stations act on.
    #[arg(long, value_enum, default_value_t = ViewFreshness::Stale)]
    views: ViewFreshness,
    /// Explore without faults.
    #[arg(long)]
    no_faults: bool,
    /// Let stations receive modes in any order and mixture, without the rules of a coordinator.
    #[arg(long)]
    any_grants: bool,
    /// Use one Boolean per operation instead of counts, as the published controllers do.
    #[arg(long)]
    flags: bool,
    /// Safety rule to switch off, to show what it prevents; repeat it for several.
    #[arg(long, value_enum)]
    without: Vec<SafetyRule>,
    /// Explore the whole line at once instead of its parts.
    #[arg(long)]
    whole: bool,
    /// Most states to keep; beyond, the verdict is undecided, or left to parts of the line [default: 50000000, or 6000000 where
    /// there are smaller parts; of the orders of an activity 1000000].
    #[arg(long, value_parser = at_least_1)]
    states: Option<usize>,
    /// Most memory, about, in MiB; beyond, the verdict is undecided.
    #[arg(long, default_value_t = 3072, value_parser = at_least_1)]
    memory: usize,
    /// Of a cell: let in only so many parts of each type, as in `A=2,B=1`; others not at all. May be repeated.
    #[arg(long, value_name = "TYPE=N", value_parser = PartList::read)]
    pub parts: Vec<PartList>,
    /// Of a cell: count the states in which activities are in progress, too. The answers are the same.
    #[arg(long)]
    pub expanded: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GrantedMode {
    Auto,
    Hand,
    Manual,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ViewFreshness {
    /// Reports arrive late or are lost.
    Stale,
    /// Every report arrives at once.
    Fresh,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SafetyRule {
    /// Counts go back before the recovery motion starts, not when it is complete.
    WithdrawFirst,
    /// Counts go back only when every station whose operations depend on them agrees.
    Agreement,
    /// Every request has a number that was never used before.
    FreshNumbers,
    /// Going home on a recovery path takes the round's counts back; the home operation does not count.
    RedoRound,
    /// A recovery path waits for the arrows into every operation that it skips.
    WayHome,
    /// Counts of another generation, as after a lost memory, are unknown.
    Generations,
    /// A motion starts and goes on only while the other station of a conflict is measured clear.
    Measured,
    /// A motion stops while the other station of a conflict is measured not to be clear.
    MeasuredStop,
}

/// Most states to keep, if the options have none.
const STATES: usize = 50_000_000;
/// The same of stations that are explored together where smaller parts of them decide what must never be.
const STATES_TOGETHER: usize = 6_000_000;
/// What the scope of a part begins with.
pub const PART: &str = "part";
/// A line of more stations than this is explored in parts.
const WHOLE_STATIONS_MAX: usize = 3;

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

impl ExploreOptions {
    /// Whether anything is to be explored at all.
    pub fn asks_to_explore(&self) -> bool {
        !self.structure
    }

    /// The rules of measured positions that are explored by themselves; none if nothing is explored.
    pub fn measured(&self) -> Option<PositionRules> {
        let without = |rule| self.without.contains(&rule);
        let starts = !without(SafetyRule::Measured);
        self.asks_to_explore().then(|| PositionRules { starts, stops: starts && !without(SafetyRule::MeasuredStop) })
    }

    /// An option given that only a line's stations have.
    pub fn of_stations(&self) -> Option<&'static str> {
        let asked = [
            (!self.modes.is_empty(), "--mode"),
            (self.views != ViewFreshness::Stale, "--views"),
            (self.no_faults, "--no-faults"),
            (self.any_grants, "--any-grants"),
            (self.flags, "--flags"),
            (!self.without.is_empty(), "--without"),
            (self.whole, "--whole"),
        ];
        asked.into_iter().find_map(|(is_asked, name)| is_asked.then_some(name))
    }

    /// An option given that only a cell has.
    pub fn of_cells(&self) -> Option<&'static str> {
        let asked = [(!self.parts.is_empty(), "--parts"), (self.expanded, "--expanded")];
        asked.into_iter().find_map(|(is_asked, name)| is_asked.then_some(name))
    }

    /// Limits of a cell's exploration.
    pub fn cell_limits(&self) -> linewright_proof::cell::ExplorationLimits {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let SearchLimits { states, bytes } = self.limits(STATES);
        linewright_proof::cell::ExplorationLimits { states: states as u64, bytes, threads }
    }

    /// Limits of the exploration of an activity's orders, which takes more for each state.
    pub fn order_limits(&self) -> SearchLimits {
        self.limits(protocol::STATES)
    }

    /// Explores by the options. The first failure ends it, as one is enough.
    ///
    /// # Errors
    /// When the line cannot be explored at all.
    pub fn explore(&self, line: &Line) -> Result<Vec<Exploration>, LineNotExplorable> {
        let mut found = Vec::new();
        if self.structure {
            return Ok(found);
        }
        if self.whole {
            // Any orders are given there, so nothing keeps tasks apart.
            return self.together(&line.without_conflicts_of_tasks());
        }
        let alone = task_driven(line);
        if alone.is_empty() {
            return self.together(line);
        }
        let others = cyclic(line);
        found.extend(self.by_parts(line, alone, "alone", ExploreOptions::each)?);
        if !others.stations.is_empty() {
            found.extend(self.together(&others)?);
        }
        Ok(found)
    }

    /// Stations that are joined by arrows: all at once, or conflict by conflict where they are many.
    fn together(&self, line: &Line) -> Result<Vec<Exploration>, LineNotExplorable> {
        let mut found = Vec::new();
        if self.whole || line.stations.len() <= WHOLE_STATIONS_MAX {
            if self.modes.is_empty() {
                found.push(self.undisturbed(line)?);
            }
            found.extend(self.both(line, "the whole line")?);
            return Ok(found);
        }
        self.by_parts(line, parts::parts(line), PART, ExploreOptions::both)
    }

    fn setting(&self, line: &Line) -> LineExploration {
        let mut setting = LineExploration::new(line);
        if !self.modes.is_empty() {
            setting.modes.retain(|mode| self.modes.iter().any(|named| named.control() == *mode));
        }
        setting.faults = !self.no_faults;
        setting.lag = if self.views == ViewFreshness::Fresh { 0 } else { setting.lag };
        setting.grants = if self.any_grants { Grants::Anyhow } else { Grants::InEpochs };
        let rules = &mut setting.rules;
        rules.counted = !self.flags;
        for rule in &self.without {
            match rule {
                SafetyRule::WithdrawFirst => rules.withdraw_first = false,
                SafetyRule::Agreement => rules.ask = false,
                SafetyRule::FreshNumbers => rules.fresh_numbers = false,
                SafetyRule::RedoRound => rules.redo_round = false,
                SafetyRule::WayHome => rules.home_waits = false,
                // Of lost memories, and of the second barrier, which are explored by themselves.
                SafetyRule::Generations | SafetyRule::Measured | SafetyRule::MeasuredStop => {}
            }
        }
        setting
    }

    /// `states`: most of them, if the options have none.
    fn limits(&self, states: usize) -> SearchLimits {
        SearchLimits { states: self.states.unwrap_or(states), bytes: self.memory.saturating_mul(1 << 20) }
    }

    /// The exploration with intact memories, then the one with restarts and lost memories; only the first where a property fails
    /// in it.
    fn both(&self, line: &Line, what: &str) -> Result<Vec<Exploration>, LineNotExplorable> {
        let small = if self.whole { Vec::new() } else { smallest_parts(line) };
        let states = if small.is_empty() { STATES } else { STATES_TOGETHER };
        let mut found = vec![self.one(&self.setting(line), what, self.limits(states))?];
        let fails = found.iter().any(|exploration| exploration.has("fails"));
        if fails || self.lost_memories(line).modes.is_empty() {
            return Ok(found);
        }
        let open = !found.iter().all(Exploration::holds);
        // What must never be is decided by the smallest parts: where they hold, the line holds; where one fails, that may come of
        // what was left out of it.
        let each = if open { ExploreOptions::both } else { ExploreOptions::restarted };
        let of_parts = self.by_parts(line, small, PART, each)?;
        let decided = !of_parts.is_empty() && of_parts.iter().all(Exploration::holds);
        if decided {
            let further = self.whole_text();
            found.iter_mut().for_each(|exploration| exploration.leave_open(&further));
        }
        found.extend(if open || decided { of_parts } else { self.restarted(line, what)? });
        Ok(found)
    }

    fn restarted(&self, line: &Line, what: &str) -> Result<Vec<Exploration>, LineNotExplorable> {
        let what = format!("{what}, restarted with memories, and in auto and hand without");
        let found = self.one(&self.lost_memories(line), &what, self.limits(STATES))?;
        Ok(vec![Exploration { is_restarted: true, ..found }])
    }

    fn lost_memories(&self, line: &Line) -> LineExploration {
        let mut setting = self.setting(line).with_lost_memories();
        setting.rules.generations = !self.without.contains(&SafetyRule::Generations);
        setting
    }

    fn each(&self, line: &Line, what: &str) -> Result<Vec<Exploration>, LineNotExplorable> {
        Ok(vec![self.one(&self.setting(line), what, self.limits(STATES))?])
    }

    fn one(
        &self,
        setting: &LineExploration,
        what: &str,
        limits: SearchLimits,
    ) -> Result<Exploration, LineNotExplorable> {
        let modes: Vec<&str> = setting.modes.iter().map(|mode| mode.name()).collect();
        let faults = if setting.faults { "anything may fail" } else { "nothing fails" };
        let views = if setting.lag == 0 { "reports heard at once" } else { "late and lost reports" };
        let scope = format!("{what}: {}; {faults}; {views}", modes.join(", "));
        self.explored(scope, setting, limits)
    }

    fn explored(
        &self,
        scope: String,
        setting: &LineExploration,
        limits: SearchLimits,
    ) -> Result<Exploration, LineNotExplorable> {
        let explored = explore(setting, limits)?;
        let help = explored.limit.map(|limit| self.further(limit, explored.kept, limits.states));
        Ok(Exploration { help, ..Exploration::of(scope, explored) })
    }

    /// What lets a search look further. How much there is to see is not known before.
    fn further(&self, limit: LimitReached, kept: usize, states: usize) -> String {
        let more = self.more(limit, states);
        format!(
            "{kept} states are kept, and how many there are is not known. {more}; fewer modes (`--mode auto`) are fewer states"
        )
    }

    /// How the rest is looked at of stations whose conflicts are decided by parts.
    fn whole_text(&self) -> String {
        let states = self.limits(STATES).states;
        format!("for the rest `--whole --states {}` looks at more of them, which takes minutes", states.max(STATES))
    }

    /// Help below an undecided rule of an activity's orders: the option that looks further.
    pub fn further_orders(&self, limit: LimitReached) -> String {
        let more = self.more(limit, self.order_limits().states);
        format!("how many states the orders of an activity have is not known. {more}")
    }

    fn more(&self, limit: LimitReached, states: usize) -> String {
        match limit {
            LimitReached::States => {
                format!("`--states {}` looks at twice as many, if the memory suffices", states.saturating_mul(2))
            }
            LimitReached::Memory => {
                format!("`--memory {}` allows twice the {} MiB", self.memory.saturating_mul(2), self.memory)
            }
        }
    }

    /// Auto mode alone, with nothing failing: whether every wait of the normal cycle ends.
    fn undisturbed(&self, line: &Line) -> Result<Exploration, LineNotExplorable> {
        let mut setting = self.setting(line);
        (setting.modes, setting.faults) = (vec![ControlMode::Auto], false);
        self.explored("the whole line in auto, undisturbed".to_owned(), &setting, self.limits(STATES))
    }
}

impl GrantedMode {
    const fn control(self) -> ControlMode {
        match self {
            GrantedMode::Auto => ControlMode::Auto,
            GrantedMode::Hand => ControlMode::Hand,
            GrantedMode::Manual => ControlMode::Manual,
        }
    }
}

impl Exploration {
    fn of(scope: String, explored: LineExplored) -> Self {
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
            is_left_to_parts: false,
            is_restarted: false,
            properties,
        }
    }

    /// Help below a failed property of a part of the line: the stations outside the part, and the option that explores the whole line. None
    /// where no property of a part fails.
    pub fn outside_text(&self) -> Option<String> {
        /// More names are no help to read.
        const NAMES_MAX: usize = 8;
        if self.left_out.is_empty() || !self.has("fails") {
            return None;
        }
        let mut names = self.left_out.iter().take(NAMES_MAX).cloned().collect::<Vec<_>>().join(", ");
        let more = self.left_out.len().saturating_sub(NAMES_MAX);
        if more > 0 {
            names += &format!(" and {more} more");
        }
        Some(format!(
            "this part leaves out {names}, and their arrows, which may prevent this in the line; `--whole` explores all of it"
        ))
    }

    fn has(&self, verdict: &str) -> bool {
        self.properties.iter().any(|property| property.verdict == verdict)
    }

    /// Leaves out the properties that this exploration does not decide, where smaller parts decide the conflicts: of lines that are explored in
    /// parts alone they are not listed either. `further`: the options with which they are explored, as text.
    fn leave_open(&mut self, further: &str) {
        self.properties.retain(|property| property.verdict != "undecided");
        if !self.exhausted {
            self.is_left_to_parts = true;
            self.help = Some(format!(
                "{} states are kept, and how many there are is not known: conflicts and each station are decided by the parts below; {further}",
                self.kept
            ));
        }
    }

    /// Whether every property holds; a remark does not speak against the line.
    pub fn holds(&self) -> bool {
        self.properties.iter().all(|property| matches!(property.verdict, "holds" | "remark"))
    }
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
        LineFinding { name, verdict, reason, counterexample, holds_by_parts }
    }
}

impl From<LinePath> for LineCounterexample {
    fn from(LinePath { steps, end, chart }: LinePath) -> Self {
        LineCounterexample { steps, end, chart }
    }
}
