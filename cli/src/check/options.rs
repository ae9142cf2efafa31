//! The options of the exploration in a check: what is explored, and how far.

use clap::{Args, ValueEnum};
use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_proof::explore::{Grants, LimitReached, LineExploration, SearchLimits};
use linewright_proof::positions::PositionRules;

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
    pub whole: bool,
    /// Most states to keep; beyond, the verdict is undecided, or left to parts of the line [default: 50000000, or 6000000 and
    /// less where there are smaller parts; of the orders of an activity 10000000].
    #[arg(long, value_parser = at_least_1)]
    states: Option<usize>,
    /// Most memory, about, in MiB; beyond, the verdict is undecided.
    #[arg(long, default_value_t = MEMORY, value_parser = at_least_1)]
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

/// Most memory in MiB, if the options have none.
pub const MEMORY: usize = 3072;
/// Most states to keep, if the options have none.
pub const STATES: usize = 50_000_000;
/// The same of the orders of an activity: those of three stations may have six million and more, in which the memory that is usual ends
/// as well.
const STATES_OF_ORDERS: usize = 10_000_000;
/// The same of stations that are explored together where smaller parts of them decide what must never be.
pub const STATES_TOGETHER: usize = 6_000_000;
/// Most states to keep of stations that are explored together and are expected to have more than [`MANY_MORE`] times
/// [`STATES_TOGETHER`]: a violation within few steps of the start is found among these as well.
pub const STATES_TOGETHER_FEW: usize = 500_000;
/// Expected states, as a multiple of [`STATES_TOGETHER`], above which only [`STATES_TOGETHER_FEW`] are looked at. Of lines of three stations that were tried, one had three tenths fewer states
/// than expected, and one had more than three times as many.
pub const MANY_MORE: u64 = 4;

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

    /// Whether every mode may be granted.
    pub fn has_all_modes(&self) -> bool {
        self.modes.is_empty()
    }

    /// An option given that only a line's stations have.
    pub fn of_stations(&self) -> Option<&'static str> {
        let asked = [
            (!self.has_all_modes(), "--mode"),
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
        self.limits(STATES_OF_ORDERS)
    }

    pub fn setting(&self, line: &Line) -> LineExploration {
        let mut setting = LineExploration::new(line);
        if !self.has_all_modes() {
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
    pub fn limits(&self, states: usize) -> SearchLimits {
        SearchLimits { states: self.states.unwrap_or(states), bytes: self.memory.saturating_mul(1 << 20) }
    }

    /// With restarts and lost memories.
    pub fn lost_memories(&self, line: &Line) -> LineExploration {
        let mut setting = self.setting(line).with_lost_memories();
        setting.rules.generations = !self.without.contains(&SafetyRule::Generations);
        setting
    }

    /// What lets a search look further. How much there is to see is not known before.
    pub fn further(&self, limit: LimitReached, kept: usize, states: usize) -> String {
        let more = self.more(limit, states);
        format!(
            "{kept} states are kept, and how many there are is not known. {more}; fewer modes (`--mode auto`) are fewer states"
        )
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
