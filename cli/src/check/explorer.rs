//! The exploration of a line as part of a check: which stations are explored together, and in which order.

use linewright_line::Line;
use linewright_line::net::ControlMode;
use linewright_proof::explore::{LineExploration, LineNotExplorable, SearchLimits, explore_watched};
use linewright_proof::parts::{self, cyclic, smallest_parts, task_driven};

use super::explored::Exploration;
use super::larger::PartFound;
use super::options::{ExploreOptions, MANY_MORE, STATES, STATES_TOGETHER, STATES_TOGETHER_FEW};
use super::progress::CheckProgress;

/// What the scope of a part begins with.
pub const PART: &str = "part";
/// A line of more stations than this is explored in parts.
const WHOLE_STATIONS_MAX: usize = 3;

/// Explores by options, and shows how far it is.
#[derive(Clone, Copy)]
pub struct Explorer<'a> {
    pub options: &'a ExploreOptions,
    pub progress: &'a CheckProgress,
}

impl Explorer<'_> {
    /// Explores by the options. The first failure ends it, as one is enough.
    ///
    /// # Errors
    /// When the line cannot be explored at all.
    pub fn explore(&self, line: &Line) -> Result<Vec<Exploration>, LineNotExplorable> {
        let mut found = self.all(line)?;
        found.iter_mut().for_each(Exploration::open_outside);
        Ok(found)
    }

    fn all(&self, line: &Line) -> Result<Vec<Exploration>, LineNotExplorable> {
        let mut found = Vec::new();
        if !self.options.asks_to_explore() {
            return Ok(found);
        }
        if self.options.whole {
            // Any orders are given there, so nothing keeps tasks apart.
            return self.together(&line.without_conflicts_of_tasks());
        }
        let alone = task_driven(line);
        if alone.is_empty() {
            return self.together(line);
        }
        let others = cyclic(line);
        found.extend(self.by_parts(line, alone, "alone", Explorer::each)?.0);
        if !others.stations.is_empty() {
            found.extend(self.together(&others)?);
        }
        Ok(found)
    }

    /// Stations that are joined by arrows: all at once, or conflict by conflict where they are many.
    fn together(&self, line: &Line) -> Result<Vec<Exploration>, LineNotExplorable> {
        let mut found = Vec::new();
        if self.options.whole || line.stations.len() <= WHOLE_STATIONS_MAX {
            if self.options.has_all_modes() {
                found.push(self.undisturbed(line)?);
            }
            found.extend(self.both(line, "the whole line")?);
            return Ok(found);
        }
        Ok(self.by_parts(line, parts::parts(line), PART, Explorer::both)?.0)
    }

    /// The exploration with intact memories, then the one with restarts and lost memories; only the first where a property fails
    /// in it.
    ///
    /// What must never be is decided by the smallest parts, with and without restarts: where they hold, the line holds; where one fails, that
    /// may come of what was left out of it. They are few states, and from them follows how many the whole has, so they come first.
    fn both(&self, line: &Line, what: &str) -> Result<Vec<Exploration>, LineNotExplorable> {
        let restarts = !self.options.lost_memories(line).modes.is_empty();
        let small = if self.options.whole { Vec::new() } else { smallest_parts(line) };
        let (mut of_parts, parts) = self.by_parts(line, small, PART, Explorer::both)?;
        let decided = !of_parts.is_empty() && of_parts.iter().all(Exploration::holds);
        let expected = if decided { self.expected(line, &parts)? } else { 0 };
        let states = match of_parts.is_empty() {
            true => STATES,
            false if expected > MANY_MORE * STATES_TOGETHER as u64 => STATES_TOGETHER_FEW,
            false => STATES_TOGETHER,
        };
        let mut whole = self.one(&self.options.setting(line), what, self.options.limits(states))?;
        if whole.has("fails") || !restarts && !decided {
            return Ok(vec![whole]);
        }
        let holds = whole.holds();
        if decided {
            whole.leave_open(expected);
        }
        let mut found = vec![whole];
        if holds && !decided {
            found.extend(self.restarted(line, what)?);
            return Ok(found);
        }
        if holds {
            // Without restarts the whole has more to it than they; what is like another part has no states of its own.
            of_parts.retain(|part| restarts && (part.is_restarted || part.states == 0));
        }
        found.extend(of_parts);
        Ok(found)
    }

    /// About how many states are kept of a line, from those of its parts and of the stations that these have in common: as if what a station
    /// does with one neighbour had nothing to do with what it does with another.
    fn expected(&self, line: &Line, parts: &[PartFound]) -> Result<u64, LineNotExplorable> {
        let mut expected: f64 = parts.iter().map(|part| part.kept as f64).product();
        for id in line.station_ids() {
            let parts_with = parts.iter().filter(|of| of.part.stations.contains(&id)).count();
            if parts_with > 1 {
                let alone = parts::alone(line, id);
                let kept =
                    self.one(&self.options.setting(&alone.line), &alone.names(), self.options.limits(STATES))?.kept;
                expected /= (kept.max(1) as f64).powi(parts_with as i32 - 1);
            }
        }
        Ok(expected as u64)
    }

    fn restarted(&self, line: &Line, what: &str) -> Result<Vec<Exploration>, LineNotExplorable> {
        let what = format!("{what}, restarted with memories, and in auto and hand without");
        let found = self.one(&self.options.lost_memories(line), &what, self.options.limits(STATES))?;
        Ok(vec![Exploration { is_restarted: true, ..found }])
    }

    fn each(&self, line: &Line, what: &str) -> Result<Vec<Exploration>, LineNotExplorable> {
        Ok(vec![self.one(&self.options.setting(line), what, self.options.limits(STATES))?])
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
        self.progress.shows(&scope);
        let explored = explore_watched(setting, limits, &self.progress.search)?;
        let help = explored.limit.map(|limit| self.options.further(limit, explored.kept, limits.states));
        Ok(Exploration { help, ..Exploration::of(scope, explored) })
    }

    /// Auto mode alone, with nothing failing: whether every wait of the normal cycle ends.
    fn undisturbed(&self, line: &Line) -> Result<Exploration, LineNotExplorable> {
        let mut setting = self.options.setting(line);
        (setting.modes, setting.faults) = (vec![ControlMode::Auto], false);
        self.explored("the whole line in auto, undisturbed".to_owned(), &setting, self.options.limits(STATES))
    }
}
