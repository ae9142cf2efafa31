//! Playing a coloured net out, on coloured markings: [`crate::reach`] with modes for transitions.
//!
//! From each state modes are played in their order. That is the order in which [`crate::explore`] goes through the
//! unfolding of all colours, so the two number the same states the same way; the tests hold them against each other.

use super::bind;
use super::game::ColouredFireError;
use super::marking::{ColouredMarking, count_in};
use super::net::{ColouredNet, NetMode};
use crate::reach::{ReachUndecided, Reachability, explore_by};
use crate::{NamedId, PlaceId};

/// All reachable coloured markings and the steps between them.
pub type ColouredReachability = Reachability<ColouredMarking, NetMode>;

/// Finds all reachable markings, unless there are more than `limit_states`.
pub fn explore(
    net: &ColouredNet,
    limit_states: usize,
) -> Result<ColouredReachability, ReachUndecided<ColouredFireError>> {
    let modes = net.transitions().flat_map(|transition| net.modes(transition)).collect();
    let enabled = |here: &ColouredMarking| net.enabled(here);
    explore_by(net.initial_marking(), modes, limit_states, enabled, |marking, mode| net.fire(marking, mode))
}

impl ColouredReachability {
    /// The most tokens of any colour that a place ever holds together.
    pub fn bound_of(&self, net: &ColouredNet, place: PlaceId) -> u64 {
        let place = &net.places[place.index()];
        let held = |marking: &ColouredMarking| {
            bind::on_place(marking.entries(), place).iter().map(|&(_, count)| u64::from(count)).sum()
        };
        self.states().iter().map(held).max().unwrap_or(0)
    }

    /// The most tokens of one colour that a place ever holds.
    pub fn bound_of_cell(&self, cell: u32) -> u32 {
        self.states().iter().map(|marking| count_in(marking.entries(), cell)).max().unwrap_or(0)
    }

    /// The places that come to hold more tokens than they are declared to, with the most they hold.
    pub fn over_capacity(&self, net: &ColouredNet) -> Vec<(NamedId<PlaceId>, u64)> {
        let over = |place: PlaceId| {
            let most = net.max_tokens(place)?;
            let bound = self.bound_of(net, place);
            (bound > u64::from(most)).then(|| (net.place(place), bound))
        };
        net.places().filter_map(over).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StateId;
    use crate::coloured::{ColouredBuilder, Domain, Guard, Operand, compare, component, id, proj, succ};

    /// A token that goes around a ring of `size`, and with `trace` leaves one.
    fn ring(size: u32, trace: bool) -> ColouredNet {
        let mut b = ColouredBuilder::new("ring");
        let at = b.basic("at", size);
        let here = b.place("here", at);
        let step = b.transition("step", at);
        b.tokens(here, &[1], 1).input(step, here, id()).output(step, here, succ(1, 1));
        if trace {
            let seen = b.place("seen", at);
            b.output(step, seen, proj([1]));
        }
        b.build().unwrap()
    }

    #[test]
    fn a_ring_is_live_and_reversible() {
        let net = ring(5, false);
        let r = explore(&net, 10).unwrap();
        assert_eq!((r.states().len(), r.steps().len(), r.deadlocks().count()), (5, 5, 0));
        assert_eq!((r.is_live(), r.is_reversible()), (true, Ok(())));
        let last: Vec<_> = r.path_to(StateId(4)).into_iter().map(|mode| net.mode_name(mode)).collect();
        assert_eq!(last, ["step<1>", "step<2>", "step<3>", "step<4>"]);
        assert_eq!(net.describe(r.marking(StateId(4))), "here<5>");
        assert_eq!(r.find(r.marking(StateId(3))), Some(StateId(3)));
    }

    #[test]
    fn what_does_not_end_is_undecided() {
        let net = ring(3, true);
        let stopped = explore(&net, 100).unwrap_err();
        assert_eq!(stopped.to_string(), "undecided after 100 states: there are more than allowed");
        assert_eq!(explore(&net, 0).unwrap_err().states, 0);
    }

    #[test]
    fn capacities_are_claims_that_are_checked() {
        let mut b = ColouredBuilder::new("gather");
        let kind = b.basic("kind", 3);
        let (loose, boxed) = (b.place("loose", kind), b.place("boxed", kind));
        b.max_tokens(boxed, 2);
        (1..=3).for_each(|tone| _ = b.tokens(loose, &[tone], 1));
        let pack = b.transition("pack", Domain::Universal);
        b.input(pack, loose, id()).output(pack, boxed, id());
        b.guard(pack, Guard::all([compare(component(1), crate::coloured::Comparison::Less, Operand::Number(9))]));
        let net = b.build().unwrap();
        let r = explore(&net, 100).unwrap();
        assert_eq!(r.states().len(), 8);
        let over: Vec<_> = r.over_capacity(&net).iter().map(|(place, bound)| format!("{place}: {bound}")).collect();
        assert_eq!(over, ["place `boxed`: 3"]);
        assert_eq!((r.bound_of_cell(net.cell_of(boxed, &[2]).unwrap()), r.deadlocks().count()), (1, 1));
    }
}
