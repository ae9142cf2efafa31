//! Whether home, and the start, can be reached from every state of an exhausted search.

use linewright_line::net::ControlMode;

use super::search::LineSearch;
use super::setting::{Grants, LineExploration};

impl<const N: usize> LineSearch<N> {
    /// Of an exhausted search: a state from which home cannot be reached, if there is one.
    ///
    /// With manual mode among the modes, by manual mode alone: no station takes up any other on the way. The mode
    /// decision lets an operator come to manual from everywhere, whatever the fault; auto and hand are refused while
    /// there is one.
    pub fn stranded(&self) -> Option<u32> {
        match self.home_by_manual() {
            None => self.cut_off_from(self.at_home.clone(), |_, _| true),
            Some(manual) => self.cut_off_from(self.at_home.clone(), |from, to| {
                let (from, to) = (self.grants[from as usize], self.grants[to as usize]);
                to.mode == manual || (to.mode == from.mode && to.acting & !from.acting == 0)
            }),
        }
    }

    /// The number of manual mode, if home is to be reached by it alone.
    pub fn home_by_manual(&self) -> Option<u8> {
        let LineExploration { modes, grants, .. } = &self.system.setting;
        let manual = modes.iter().position(|&mode| mode == ControlMode::Manual)?;
        (*grants == Grants::InEpochs).then_some(manual as u8)
    }

    /// Of an exhausted search: a state from which the start cannot be reached, if there is one.
    pub fn no_return(&self) -> Option<u32> {
        let mut goal = vec![false; self.kept()];
        goal[0] = true;
        self.cut_off_from(goal, |_, _| true)
    }

    /// The first state from which no way along these arcs leads to a goal.
    ///
    /// Sweeps over all arcs, to and fro, until nothing changes: a state from which one that leads to a goal follows
    /// leads there itself. Ways run with the numbers as well as against them, so few sweeps are enough.
    fn cut_off_from(&self, goal: Vec<bool>, may: impl Fn(u32, u32) -> bool) -> Option<u32> {
        let mut leads = goal;
        let mut left: Vec<u32> = (0..self.kept() as u32).filter(|&number| !leads[number as usize]).collect();
        loop {
            let before = left.len();
            left.reverse();
            left.retain(|&number| {
                let leading = |&next: &u32| leads[next as usize] && may(number, next);
                let found = self.store.followers(number).iter().any(leading);
                leads[number as usize] = found;
                !found
            });
            if left.is_empty() || left.len() == before {
                return left.iter().min().copied();
            }
        }
    }
}
