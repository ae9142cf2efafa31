//! Concurrent groups, taken as one place each (seed 002, Appendix).
//!
//! A net with branches side by side is not a state machine: a fork puts a token into each branch, a join takes one out of
//! each. Let a group consist of branches such that
//! * each branch is strongly connected by transitions of its own, one place in and one place out;
//! * every other transition takes from, or gives to, a group all or nothing: one place of every branch.
//!
//! Then between fork and join each branch is a state machine with one token that goes its way without the others, and
//! whatever they are doing, all of them can come to the places that a given join needs. So the group behaves as one
//! place does, and the net is live, safe and reversible if the one with a place for each group is. This takes linear
//! time, where playing the branches out would take the product of their sizes.

use thiserror::Error;

use super::NotConnected;
use crate::{NamedId, Net, NetBuilder, PlaceId, TransitionId};

/// The places of a group, branch by branch.
pub type PlaceGroup = Vec<Vec<PlaceId>>;

/// Why groups cannot be taken as places.
#[derive(Debug, PartialEq, Eq, Error)]
pub enum NotReducible {
    /// A transition takes from or gives to several places that are not one whole row across a group.
    #[error("{transition} touches places that neither stand alone nor make one row across a concurrent group")]
    Mixed { transition: NamedId<TransitionId> },
    /// Tokens start in some branches of a group only.
    #[error("the concurrent group of {first} starts with tokens in some of its branches only")]
    Uneven {
        /// The group's first place.
        first: NamedId<PlaceId>,
    },
    /// A branch cannot go everywhere on its own.
    #[error("within its concurrent branch, {0}")]
    Branch(NotConnected),
}

/// An arc's end once groups are places.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Unit {
    Alone(PlaceId),
    Group(usize),
}

struct Groups<'a> {
    net: &'a Net,
    groups: &'a [PlaceGroup],
    /// For each place, its group and branch.
    membership: Vec<Option<(usize, usize)>>,
}

/// The net with one place for each group; the net itself where there are none.
///
/// # Errors
/// When a branch is not strongly connected by itself, or another transition takes from or gives to a part of a group.
pub fn reduce(net: &Net, groups: &[PlaceGroup]) -> Result<Net, NotReducible> {
    if groups.is_empty() {
        return Ok(net.clone());
    }
    let mut membership = vec![None; net.place_count()];
    for (g, group) in groups.iter().enumerate() {
        for (b, branch) in group.iter().enumerate() {
            branch.iter().for_each(|place| membership[place.index()] = Some((g, b)));
        }
    }
    let groups = Groups { net, groups, membership };
    groups.branches_are_connected()?;
    groups.reduced()
}

impl Groups<'_> {
    /// The branch that a transition stays inside, if it does.
    fn branch_of(&self, t: TransitionId) -> Option<(usize, usize)> {
        match (self.net.preset(t), self.net.postset(t)) {
            ([(from, 1)], [(to, 1)]) if self.membership[from.index()] == self.membership[to.index()] => {
                self.membership[from.index()]
            }
            _ => None,
        }
    }

    fn branches_are_connected(&self) -> Result<(), NotReducible> {
        for (g, group) in self.groups.iter().enumerate() {
            for (b, branch) in group.iter().enumerate() {
                let mut builder = NetBuilder::new("branch");
                let ids: Vec<_> = branch.iter().map(|&p| builder.place(self.net.place_name(p), 0)).collect();
                let id = |place: PlaceId| branch.iter().position(|&p| p == place).map(|index| ids[index]);
                for t in self.net.transitions().filter(|&t| self.branch_of(t) == Some((g, b))) {
                    let own = builder.transition(self.net.transition_name(t));
                    let ends = (id(self.net.preset(t)[0].0), id(self.net.postset(t)[0].0));
                    if let (Some(from), Some(to)) = ends {
                        builder.input(own, from, 1).output(own, to, 1);
                    }
                }
                built(builder).is_strongly_connected().map_err(NotReducible::Branch)?;
            }
        }
        Ok(())
    }

    fn reduced(&self) -> Result<Net, NotReducible> {
        let initial = self.net.initial_marking();
        let mut builder = NetBuilder::new(self.net.name());
        let mut alone = vec![None; self.net.place_count()];
        for place in self.net.places().filter(|place| self.membership[place.index()].is_none()) {
            alone[place.index()] = Some(builder.place(self.net.place_name(place), initial.tokens(place)));
        }
        let mut together = Vec::new();
        for (g, group) in self.groups.iter().enumerate() {
            let tokens = |branch: &Vec<PlaceId>| branch.iter().map(|&p| initial.tokens(p)).sum::<u32>();
            let in_first = group.first().map_or(0, tokens);
            if group.iter().any(|branch| tokens(branch) != in_first) {
                return Err(NotReducible::Uneven { first: self.net.place(group[0][0]) });
            }
            together.push(builder.place(format!("concurrent group {}", g + 1), in_first));
        }
        let id = |unit: Unit| match unit {
            Unit::Alone(place) => alone[place.index()].expect("a place outside all groups was declared above"),
            Unit::Group(group) => together[group],
        };
        for t in self.net.transitions().filter(|&t| self.branch_of(t).is_none()) {
            let mixed = || NotReducible::Mixed { transition: self.net.transition(t) };
            let from = self.unit(self.net.preset(t)).ok_or_else(mixed)?;
            let to = self.unit(self.net.postset(t)).ok_or_else(mixed)?;
            let own = builder.transition(self.net.transition_name(t));
            builder.input(own, id(from), 1).output(own, id(to), 1);
        }
        Ok(built(builder))
    }

    /// One place outside all groups, or one place of every branch of one group.
    fn unit(&self, arcs: &[(PlaceId, u32)]) -> Option<Unit> {
        if arcs.iter().any(|&(_, weight)| weight != 1) {
            return None;
        }
        let (first, _) = *arcs.first()?;
        let Some((group, _)) = self.membership[first.index()] else {
            return (arcs.len() == 1).then_some(Unit::Alone(first));
        };
        let mut branches: Vec<usize> = Vec::with_capacity(arcs.len());
        for &(place, _) in arcs {
            match self.membership[place.index()] {
                Some((g, branch)) if g == group => branches.push(branch),
                Some(_) | None => return None,
            }
        }
        branches.sort_unstable();
        branches.iter().copied().eq(0..self.groups[group].len()).then_some(Unit::Group(group))
    }
}

fn built(builder: NetBuilder) -> Net {
    match builder.build() {
        Ok(net) => net,
        Err(errors) => unreachable!("names and arcs were taken from a sound net: {errors:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Start, then two branches of two places each, then back to the start.
    fn fork_and_join(back_in: [bool; 2], join: [bool; 2]) -> (Net, Vec<PlaceGroup>) {
        let mut b = NetBuilder::new("pair");
        let start = b.place("start", 1);
        let (fork, joined) = (b.transition("fork"), b.transition("join"));
        b.input(fork, start, 1).output(joined, start, 1);
        let mut group = Vec::new();
        for (branch, name) in ["left", "right"].into_iter().enumerate() {
            let (on, off) = (b.place(format!("{name} on"), 0), b.place(format!("{name} off"), 0));
            let done = b.transition(format!("{name} done"));
            b.output(fork, on, 1).input(done, on, 1).output(done, off, 1);
            if back_in[branch] {
                let again = b.transition(format!("{name} again"));
                b.input(again, off, 1).output(again, on, 1);
            }
            if join[branch] {
                b.input(joined, off, 1);
            }
            group.push(vec![on, off]);
        }
        (b.build().unwrap(), vec![group])
    }

    #[test]
    fn a_group_becomes_a_place() {
        let (net, groups) = fork_and_join([true; 2], [true; 2]);
        let reduced = reduce(&net, &groups).unwrap();
        assert_eq!((reduced.place_count(), reduced.transition_count()), (2, 2));
        assert!(reduced.is_state_machine().is_ok() && reduced.is_strongly_connected().is_ok());
    }

    #[test]
    fn a_join_that_leaves_a_branch_out_is_found() {
        let (net, groups) = fork_and_join([true; 2], [true, false]);
        let error = reduce(&net, &groups).unwrap_err();
        assert!(error.to_string().contains("`join`"), "{error}");
    }

    #[test]
    fn a_branch_with_a_dead_end_is_found() {
        let (net, groups) = fork_and_join([true, false], [true; 2]);
        let error = reduce(&net, &groups).unwrap_err();
        assert!(matches!(&error, NotReducible::Branch(_)) && error.to_string().contains("right"), "{error}");
    }
}
