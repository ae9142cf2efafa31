//! The flexible production cell, seed 000, Figs. 17 and 18, L1428-1544.
//!
//! Robot 1 (r1) loads and unloads robot 2 (m1) and a human operator (m2); parts of three kinds. Printed: the places and
//! transitions with their meanings, the guards of t1 and t5, m₀, that t1 takes from p1 (L2767) and t1 and t5 from p2
//! (L2762), the arcs around t2 (L2497-2501) and t3 (L1974). The other arcs are rebuilt from the meanings. What p9 and p10
//! hold is lost; here it is the kind of the part. m₀(p9) is printed as 0, so parts come from outside.

use linewright_nets::TransitionId;
use linewright_nets::coloured::{Clause, ColouredBuilder, ColouredNet, Domain, Guard, colour, id, proj};

/// What is different from the printed net.
#[derive(Clone, Default)]
pub struct PublishedCellVariant {
    /// Parts of each kind that wait on p9.
    pub waiting: [u32; 3],
    /// Parts of each kind outside: they arrive on p9, and leave from p10 to come again.
    pub outside: [u32; 3],
    /// Robot 1 grasps a part without reserving the place for it.
    pub unreserved: bool,
}

/// (m1∧p1) ∨ (m2∧p2) ∨ (m2∧p3) (L1534), with the components that M and P are; the dispatcher decides (L2893).
pub fn work_plan(machine: u32, part: u32) -> Guard {
    let clause = |m, p| Clause::all([colour(machine, m), colour(part, p)]).scheduled();
    Guard::any([clause(1, 1), clause(2, 2), clause(2, 3)])
}

pub fn cell(variant: &PublishedCellVariant) -> ColouredNet {
    let mut b = ColouredBuilder::new("cell");
    let m = b.named_basic("M", ["m1", "m2"]);
    let r = b.named_basic("R", ["r1"]);
    let p = b.named_basic("P", ["p1", "p2", "p3"]);
    let (p1, p2) = (b.place("p1", m), b.place("p2", r));
    let [p3, p4] = ["p3", "p4"].map(|name| b.place(name, Domain::Universal));
    let [p5, p6] = ["p5", "p6"].map(|name| b.place(name, [m, p]));
    let [p7, p8] = ["p7", "p8"].map(|name| b.place(name, Domain::Universal));
    let [p9, p10] = ["p9", "p10"].map(|name| b.place(name, p));
    b.tokens(p1, &[1], 1).tokens(p1, &[2], 1).tokens(p2, &[1], 1);
    (1..).zip(variant.waiting).for_each(|(kind, count)| _ = b.tokens(p9, &[kind], count));

    let [t1, t2, t3, t4, t5, t6, t7] =
        ["t1", "t2", "t3", "t4", "t5", "t6", "t7"].map(|name| b.transition(name, Domain::Universal));
    let reserves = if variant.unreserved { t3 } else { t1 };
    b.input(reserves, p1, proj([1]));
    b.input(t1, p2, proj([2])).input(t1, p9, proj([3])).output(t1, p3, id());
    b.input(t2, p3, id()).output(t2, p4, id());
    b.input(t3, p4, id()).output(t3, p2, proj([2])).output(t3, p5, proj([1, 3]));
    b.input(t4, p5, proj([1, 3])).output(t4, p6, proj([1, 3]));
    b.input(t5, p6, proj([1, 3])).input(t5, p2, proj([2])).output(t5, p7, id());
    b.input(t6, p7, id()).output(t6, p8, id());
    b.input(t7, p8, id()).output(t7, p1, proj([1])).output(t7, p2, proj([2])).output(t7, p10, proj([3]));
    b.guard(t1, work_plan(1, 3)).guard(t5, work_plan(1, 3));
    if variant.outside != [0; 3] {
        let outside = b.place("outside", p);
        (1..).zip(variant.outside).for_each(|(kind, count)| _ = b.tokens(outside, &[kind], count));
        let (arrive, leave) = (b.transition("arrive", p), b.transition("leave", p));
        b.input(arrive, outside, id()).output(arrive, p9, id());
        b.input(leave, p10, id()).output(leave, outside, id());
    }
    b.build().unwrap()
}

/// The transitions of a list of names.
pub fn transitions(net: &ColouredNet, names: &[&str]) -> Vec<TransitionId> {
    names.iter().map(|name| net.transition_named(name).unwrap()).collect()
}
