//! The net made from `assembly-cell/cell.toml` is the published one, seed 000, Figs. 17 and 18, L1428-1544.
//!
//! The published net has the way of the robot in two places each (p3, p4 and p7, p8) and the work in one step (t4); ours
//! has one place for what is in progress, and a start and an end for the work too. With t2 and t6 hidden there, and the
//! start of the work here, the two are the same graph. What follows for deadlocks (A8) is in `counts`, and with its counterexample in
//! `proof/tests/cells/shipped.rs`.

use std::collections::{BTreeMap, BTreeSet};

use linewright_cell::net::{CellInstances, Detail, net, parts};
use linewright_nets::StateId;
use linewright_nets::coloured::flow::TransitionFlow;
use linewright_nets::coloured::{ColouredNet, ColouredReachability, Colours, Fusion, explore, fuse, unfold};

use super::{mode, names};
use linewright_testkit::cells::{ASSEMBLY, cell};
use linewright_testkit::published_cell::{self, PublishedCellVariant};

/// Places of the tokens, in terms that both nets have.
type Class = BTreeMap<String, u32>;

/// Event, in terms that both nets have; hidden steps have none.
type Label = Option<String>;

fn ours(waiting: &[u32]) -> ColouredNet {
    net(&cell(ASSEMBLY), Detail::Expanded, waiting).expect("it is small").net().clone()
}

/// A name with its colours taken apart: `p5<m1,p2>`.
fn apart(name: &str) -> (&str, Vec<&str>) {
    let (name, tones) = name.split_once('<').unwrap_or((name, ">"));
    (name, tones.trim_end_matches('>').split(',').filter(|tone| !tone.is_empty()).collect())
}

/// m1 is robot 2, m2 the human.
fn machine(name: &str) -> &'static str {
    if name.contains("robot_2") { "m1" } else { "m2" }
}

/// Of the published net.
fn source_cell(name: &str) -> Option<String> {
    let (place, tones) = apart(name);
    Some(match (place, tones.as_slice()) {
        ("p3" | "p4", [m, _, p]) => format!("p3,4 {m} {p}"),
        ("p7" | "p8", [m, _, p]) => format!("p7,8 {m} {p}"),
        (place, tones) => format!("{place} {}", tones.join(" ")),
    })
}

/// Of ours. What has no match: what stores have room for, how many parts may come in, and the human's token.
fn our_cell(name: &str) -> Option<String> {
    let (place, tones) = apart(name);
    let part = tones.first().map_or(String::new(), |stage| format!("p{}", &stage[..1]));
    let m = machine(place);
    Some(match place {
        "robot_2.available-capacity" | "human.available-capacity" => format!("p1 {m}"),
        "robot_1.free" => "p2 r1".to_owned(),
        "running.load robot_2" | "running.load human" => format!("p3,4 {m} {part}"),
        "robot_2.loaded" | "human.loaded" | "running.robot_2.process" | "running.human.process" => {
            format!("p5 {m} {part}")
        }
        "robot_2.unload-ready" | "human.unload-ready" => format!("p6 {m} {part}"),
        "running.unload robot_2" | "running.unload human" => format!("p7,8 {m} {part}"),
        "input.stored-parts" => format!("p9 {part}"),
        "output.stored-parts" => format!("p10 {part}"),
        "outside.waiting" => format!("outside {part}"),
        "input.available-capacity" | "output.available-capacity" | "outside.room" | "human.free" => return None,
        other => panic!("{other} is not expected"),
    })
}

fn source_label(name: &str) -> Label {
    let (t, tones) = apart(name);
    match (t, tones.as_slice()) {
        ("t2" | "t6", _) => None,
        ("t4", [m, p]) | (_, [m, _, p]) => Some(format!("{t} {m} {p}")),
        (t, tones) => Some(format!("{t} {}", tones.join(" "))),
    }
}

fn our_label(name: &str) -> Label {
    let (t, tones) = apart(name);
    let part = format!("p{}", &tones[0][..1]);
    let m = machine(t);
    let what = match t
        .trim_start_matches("unload ")
        .trim_start_matches("load ")
        .trim_start_matches("robot_2")
        .trim_start_matches("human")
    {
        ".process.start" => return None,
        ".process.end" => "t4",
        ".start" if t.starts_with("load") => "t1",
        ".end" if t.starts_with("load") => "t3",
        ".start" => "t5",
        ".end" => "t7",
        "arrive" => return Some(format!("arrive {part}")),
        "depart" => return Some(format!("leave {part}")),
        other => panic!("{other} is not expected"),
    };
    Some(format!("{what} {m} {part}"))
}

fn class(net: &ColouredNet, entries: &[(u32, u32)], of: fn(&str) -> Option<String>) -> Class {
    let mut class = Class::new();
    for &(cell, count) in entries {
        if let Some(name) = of(&net.cell_name(cell)) {
            *class.entry(name).or_default() += count;
        }
    }
    class
}

/// Visible steps: from which class, by which label, to which class. Hidden steps stay within a class and take nothing
/// away: what a state could do before, it can do after them.
fn seen(
    net: &ColouredNet,
    cells: fn(&str) -> Option<String>,
    labels: fn(&str) -> Label,
) -> BTreeMap<Class, BTreeSet<(String, Class)>> {
    let graph = explore(net, 100_000).expect("it is small");
    let classes: Vec<Class> = graph.numbers().map(|state| class(net, graph.marking(state).entries(), cells)).collect();
    let steps = |state: StateId, graph: &ColouredReachability| -> Vec<(Label, StateId)> {
        graph.steps_from(state).iter().map(|step| (labels(&net.mode_name(step.transition)), step.to)).collect()
    };
    let visible = |state: StateId| -> BTreeSet<(String, Class)> {
        let steps = steps(state, &graph).into_iter();
        steps.filter_map(|(label, to)| Some((label?, classes[to.index()].clone()))).collect()
    };
    let mut all = BTreeMap::new();
    for state in graph.numbers() {
        let mut last = state;
        while let Some((_, next)) = steps(last, &graph).into_iter().find(|(label, _)| label.is_none()) {
            assert_eq!(classes[next.index()], classes[last.index()], "a hidden step is not seen");
            assert!(visible(last).is_subset(&visible(next)), "a hidden step takes nothing away");
            last = next;
        }
        let after = visible(last);
        let known = all.entry(classes[state.index()].clone()).or_insert_with(|| after.clone());
        assert_eq!(*known, after, "the class says what can happen");
    }
    all
}

/// A2, seed 000, L1490-1536: |T| = 7, |P| = 10, m₀(p1) = m1 + m2, m₀(p2) = r1, the rest 0; and the whole behaviour.
#[test]
fn the_generated_net_is_the_published_one() {
    let empty = ours(&[]);
    let start = class(&empty, empty.initial_marking().entries(), our_cell);
    assert_eq!(start, ["p1 m1", "p1 m2", "p2 r1"].map(|place| (place.to_owned(), 1)).into());

    for outside in [[1, 1, 1], [2, 2, 1]] {
        let published = published_cell::cell(&PublishedCellVariant { outside, ..PublishedCellVariant::default() });
        assert_eq!((published.transition_count(), published.place_count()), (7 + 2, 10 + 1));
        let there = seen(&published, source_cell, source_label);
        let here = seen(&ours(&outside), our_cell, our_label);
        assert!(there.len() > 100);
        assert!(there == here, "{} classes there, {} here", there.len(), here.len());
        let labels: BTreeSet<&str> =
            here.values().flatten().map(|(label, _)| label.split_once(' ').expect("a label has a part").0).collect();
        assert_eq!(labels, ["arrive", "leave", "t1", "t3", "t4", "t5", "t7"].into());
    }
}

/// A6, seed 000, L1972-1974: t3 with part 3 takes ω* from p4, and gives r1 to p2 and (m2, p3) to p5. Here the slot of the
/// input is free again as well, which the published net does not count.
#[test]
fn the_end_of_loading_moves_what_t3_does() {
    let net = ours(&[]);
    let end = mode(&net, "load human.end<3.new>");
    let moved: Vec<_> = net
        .places()
        .filter(|&place| net.moves(end, place) != [vec![], vec![]])
        .map(|place| (net.place(place).name.to_string(), net.moves(end, place).map(|side| side.len())))
        .collect();
    let expected = [
        ("input.available-capacity", [0, 1]),
        ("robot_1.free", [0, 1]),
        ("human.loaded", [0, 1]),
        ("running.load human", [1, 0]),
    ];
    assert_eq!(moved, expected.map(|(place, sides)| (place.to_owned(), sides)));
    let loaded = net.place_named("human.loaded").expect("it is there");
    let stage = net.basics()[0].tone_named("3.new").expect("it is there");
    assert_eq!(net.moves(end, loaded)[1], [(vec![stage], 1)]);
}

/// A7, seed 000, L1956-1960: robot 1 has the t-supports {t1,t2,t3} and {t5,t6,t7}, the human {t1, …, t7}. A resource here
/// is its instance with what is in progress; t1 to t3 are the start and the end of a load.
#[test]
fn the_supports_of_the_resources_are_the_printed_ones() {
    let CellInstances { instances, .. } = parts(&cell(ASSEMBLY), Detail::Expanded, &[]).expect("it is small");
    let instance = |name: &str| &instances.iter().find(|(known, _)| known == name).expect("it is there").1;
    let supports = |name: &str| -> BTreeSet<Vec<String>> {
        let (resource, running) = (instance(name), instance("running"));
        let own: Vec<String> = resource.transitions().map(|t| resource.transition(t).name.to_string()).collect();
        let fusions: Vec<Fusion> = own.iter().map(|t| Fusion::new(&**t, [(0, &**t), (1, &**t)])).collect();
        let net = fuse(name, &[(name, resource), ("running", running)], &fusions).expect("they fit");
        let long = unfold(&net, Colours::All, 10_000).expect("it is small");
        let flows = TransitionFlow::minimal(&long, &Default::default()).expect("it is small");
        // What is in progress elsewhere has flows of its own.
        let names = flows.iter().map(|flow| -> Vec<String> {
            flow.transitions().iter().map(|&t| net.transition(t).name.to_string()).collect()
        });
        names.filter(|names| names.iter().any(|name| own.contains(name))).collect()
    };
    let pair = |name: &str| [".start", ".end"].map(|end| format!("{name}{end}")).to_vec();
    let ways = ["load robot_2", "load human", "unload robot_2", "unload human"].map(pair);
    assert_eq!(supports("robot_1"), ways.into());
    let through = ["load human", "unload human", "human.process"].map(pair).concat();
    assert_eq!(supports("human"), [through].into());
}

/// The same for the cell as a whole (proposition 13, L1948-1962): one path for each kind of part, made of those of the
/// resources it goes through.
#[test]
fn the_support_of_a_part_goes_through_its_resources() {
    let net = ours(&[1, 1, 1]);
    let long = unfold(&net, Colours::Reachable, 10_000).expect("it is small");
    let flows = TransitionFlow::minimal(&long, &Default::default()).expect("it is small");
    assert_eq!(flows.len(), 3);
    assert!(flows.iter().all(|flow| flow.modes().count() == 8 && flow.modes().all(|(_, times)| times == 1)));
    let third = names(
        &net,
        flows
            .iter()
            .find(|flow| flow.modes().any(|(m, _)| net.mode_name(m) == "arrive<3.new>"))
            .expect("it is there")
            .modes()
            .map(|(mode, _)| mode),
    );
    let expected = [
        "load human.start<3.new>",
        "load human.end<3.new>",
        "unload human.start<3.done>",
        "unload human.end<3.done>",
        "arrive<3.new>",
        "depart<3.done>",
        "human.process.start<3.new>",
        "human.process.end<3.new>",
    ];
    assert_eq!(third, expected);
}
