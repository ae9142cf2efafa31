//! The cell put together from its resources, seed 000, §3.2.3 and §3.3.4.
//!
//! Robot 1 and the work positions are nets of their own; what they do together is a fused transition (L1420-1422). Which
//! transitions each resource takes part in is printed (L1956-1960); the nets of the resources (Fig. 19) are lost and
//! rebuilt from that.

use linewright_nets::coloured::flow::TransitionFlow;
use linewright_nets::coloured::{
    ColouredBuilder, ColouredNet, Colours, Domain, Fusion, explore, fuse, id, proj, unfold,
};

use super::names;
use linewright_testkit::published_cell::{PublishedCellVariant, cell, transitions, work_plan};

/// Robot 1: free, or on one of its two ways, loading or unloading.
fn robot() -> ColouredNet {
    let mut b = ColouredBuilder::new("robot 1");
    b.named_basic("M", ["m1", "m2"]);
    let r = b.named_basic("R", ["r1"]);
    b.named_basic("P", ["p1", "p2", "p3"]);
    let p2 = b.place("p2", r);
    b.tokens(p2, &[1], 1);
    let [p3, p4, p7, p8] = ["p3", "p4", "p7", "p8"].map(|name| b.place(name, Domain::Universal));
    for ([start, middle, end], [first, second]) in [(["t1", "t2", "t3"], [p3, p4]), (["t5", "t6", "t7"], [p7, p8])] {
        let [start, middle, end] = [start, middle, end].map(|name| b.transition(name, Domain::Universal));
        b.input(start, p2, proj([2])).output(start, first, id());
        b.input(middle, first, id()).output(middle, second, id());
        b.input(end, second, id()).output(end, p2, proj([2]));
        b.guard(start, work_plan(1, 3));
    }
    b.build().unwrap()
}

/// A work position for each of `machines`: free, then a part goes through it.
fn positions(machines: &[u32]) -> ColouredNet {
    let mut b = ColouredBuilder::new("positions");
    let m = b.named_basic("M", ["m1", "m2"]);
    let p = b.named_basic("P", ["p1", "p2", "p3"]);
    let free = b.place("p1", m);
    machines.iter().for_each(|&machine| _ = b.tokens(free, &[machine], 1));
    let steps = ["p3", "p4", "p5", "p6", "p7", "p8"].map(|name| b.place(name, [m, p]));
    let t = ["t1", "t2", "t3", "t4", "t5", "t6", "t7"].map(|name| b.transition(name, [m, p]));
    b.input(t[0], free, proj([1])).output(t[6], free, proj([1]));
    for (step, place) in steps.into_iter().enumerate() {
        b.output(t[step], place, id()).input(t[step + 1], place, id());
    }
    b.guard(t[0], work_plan(1, 2)).guard(t[4], work_plan(1, 2));
    b.build().unwrap()
}

/// Parts outside, waiting and done.
fn parts(outside: [u32; 3]) -> ColouredNet {
    let mut b = ColouredBuilder::new("parts");
    let p = b.named_basic("P", ["p1", "p2", "p3"]);
    let [waiting, done, away] = ["p9", "p10", "outside"].map(|name| b.place(name, p));
    (1..).zip(outside).for_each(|(kind, count)| _ = b.tokens(away, &[kind], count));
    let [t1, t7, arrive, leave] = ["t1", "t7", "arrive", "leave"].map(|name| b.transition(name, p));
    b.input(t1, waiting, id()).output(t7, done, id());
    b.input(arrive, away, id()).output(arrive, waiting, id());
    b.input(leave, done, id()).output(leave, away, id());
    b.build().unwrap()
}

/// L1956-1960: robot 1 has the t-supports {t1,t2,t3} and {t5,t6,t7}, the human {t1, …, t7}; no others.
#[test]
fn the_supports_of_the_resources_are_the_printed_ones() {
    let supports = |net: &ColouredNet| {
        let unfolded = unfold(net, Colours::Reachable, 1000).unwrap();
        let flows = TransitionFlow::minimal(&unfolded, &Default::default()).unwrap();
        for flow in &flows {
            assert_eq!(flow.check(net), Ok(()));
            assert!(flow.modes().all(|(_, times)| times == 1));
        }
        let mut supports: Vec<_> = flows.iter().map(TransitionFlow::transitions).collect();
        let found = supports.len();
        supports.sort();
        supports.dedup();
        (found, supports)
    };
    let robot = robot();
    let ways = [["t1", "t2", "t3"], ["t5", "t6", "t7"]].map(|way| transitions(&robot, &way));
    let (found, seen) = supports(&robot);
    // One for each way and each case of the work plan. For a robot without its surroundings it may be any of them; t2
    // to t7 of other colours are not reachable.
    assert_eq!((found, seen), (2 * 3, ways.to_vec()));
    let human = positions(&[2]);
    let (found, seen) = supports(&human);
    assert_eq!((found, seen), (2, vec![transitions(&human, &["t1", "t2", "t3", "t4", "t5", "t6", "t7"])]));
}

/// Proposition 13 (L1948-1962): the path of a part through the cell is made of the paths of its resources.
#[test]
fn the_support_of_a_part_in_the_cell_is_all_of_it() {
    let net = cell(&PublishedCellVariant { outside: [1, 1, 1], ..PublishedCellVariant::default() });
    let unfolded = unfold(&net, Colours::Reachable, 1000).unwrap();
    let flows = TransitionFlow::minimal(&unfolded, &Default::default()).unwrap();
    assert_eq!(flows.len(), 3, "one for each kind of part");
    assert!(flows.iter().all(|flow| flow.transitions().len() == 9 && flow.modes().all(|(_, times)| times == 1)));
    let third = flows.iter().find(|flow| flow.modes().any(|(mode, _)| net.mode_name(mode) == "t1<m2,r1,p3>")).unwrap();
    let path = names(&net, third.modes().map(|(mode, _)| mode));
    let expected = [
        "t1<m2,r1,p3>",
        "t2<m2,r1,p3>",
        "t3<m2,r1,p3>",
        "t4<m2,p3>",
        "t5<m2,r1,p3>",
        "t6<m2,r1,p3>",
        "t7<m2,r1,p3>",
        "arrive<p3>",
        "leave<p3>",
    ];
    assert_eq!(path, expected);
}

/// The resources, fused, do what the cell does: state by state as many steps, of the same names.
#[test]
fn the_fused_resources_are_the_cell() {
    let outside = [2, 1, 1];
    let (robot, positions, parts) = (robot(), positions(&[1, 2]), parts(outside));
    let nets = [("robot", &robot), ("positions", &positions), ("parts", &parts)];
    let part = |net: usize, name: &'static str| (net, name);
    let mut fusions: Vec<Fusion> = ["t2", "t3", "t5", "t6"].map(|t| Fusion::new(t, [part(0, t), part(1, t)])).into();
    fusions.extend(["t1", "t7"].map(|t| Fusion::new(t, [part(0, t), part(1, t), part(2, t)])));
    let fused = fuse("cell", &nets, &fusions).unwrap();
    assert_eq!((fused.transition_count(), fused.place_count()), (9, 5 + 7 + 3));

    let whole = cell(&PublishedCellVariant { outside, ..PublishedCellVariant::default() });
    let (a, b) = (explore(&fused, 100_000).unwrap(), explore(&whole, 100_000).unwrap());
    assert_eq!((a.states().len(), a.steps().len()), (b.states().len(), b.steps().len()));

    // Walk both side by side; modes have the same tones, up to their order.
    let key = |net: &ColouredNet, mode: linewright_nets::coloured::NetMode| {
        let name = net.transition(mode.transition).name.to_string();
        let name = name.rsplit('.').next().unwrap().to_owned();
        let domain = net.transition_domain(mode.transition).iter().map(|basic| net.basics()[basic.index()].name());
        let mut tones: Vec<_> = domain.map(str::to_owned).zip(net.mode_tones(mode)).collect();
        tones.sort();
        (name, tones)
    };
    let mut twin = vec![None; a.states().len()];
    twin[0] = Some(linewright_nets::StateId::INITIAL);
    for state in a.numbers() {
        let other = twin[state.index()].expect("states are numbered breadth first, so it has been met");
        let mut left: Vec<_> = a.steps_from(state).iter().map(|step| (key(&fused, step.transition), step.to)).collect();
        let mut right: Vec<_> =
            b.steps_from(other).iter().map(|step| (key(&whole, step.transition), step.to)).collect();
        left.sort();
        right.sort();
        assert_eq!(left.len(), right.len());
        for ((mode, to), (same, there)) in left.into_iter().zip(right) {
            assert_eq!(mode, same);
            assert_eq!(*twin[to.index()].get_or_insert(there), there);
        }
    }
}
