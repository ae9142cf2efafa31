//! The two levels of detail agree, every prototype works, and modes lead back to the description.

use std::time::Duration;

use linewright_cell::net::{CellNet, Detail, Origin, Supply, TransitionPhase, net};
use linewright_nets::coloured::{ColouredNet, explore};

use super::{mode, names, play};
use linewright_testkit::cells::{ASSEMBLY, C1, cell, edited};

fn made(text: &str, detail: Detail, waiting: &[u32]) -> CellNet {
    net(&cell(text), detail, waiting).expect("it is small")
}

/// What starts takes and what ends gives, so activities in progress side by side lead nowhere that they would not lead one
/// after the other: where nothing is in progress, both nets have the same markings.
#[test]
fn both_details_reach_the_same_markings() {
    for (text, waiting) in [(C1, &[2, 1][..]), (ASSEMBLY, &[2, 1, 1])] {
        let markings = |detail| {
            let net = made(text, detail, waiting).net().clone();
            let graph = explore(&net, 100_000).expect("it is small");
            let all = graph.numbers().map(|state| net.describe(graph.marking(state)));
            let mut idle: Vec<String> = all.filter(|marking| !marking.contains("running.")).collect();
            idle.sort();
            (idle, graph.states().len())
        };
        let (coordination, all) = markings(Detail::Coordination);
        let (expanded, more) = markings(Detail::Expanded);
        assert!(all == coordination.len() && more > all);
        assert!(coordination == expanded);
    }
}

/// Fused names are the synchronisations' names, as in seed 001, L77; a load is enabled by a free robot, the part in the
/// store and room in the machine (L210-212), and by nothing less.
#[test]
fn a_load_needs_robot_part_and_room() {
    let made = made(C1, Detail::Coordination, &[1, 1]);
    let net = made.net();
    let t = net.transition_named("load M1").expect("it is there");
    assert_eq!(names(net, net.modes(t)), ["load M1<A.new>"]);
    let load = mode(net, "load M1<A.new>");
    let takes: Vec<_> =
        net.places().filter(|&p| !net.moves(load, p)[0].is_empty()).map(|p| net.place(p).name.to_string()).collect();
    assert_eq!(takes, ["ST.stored-parts", "M1.available-capacity", "R.free"]);
    assert!(!net.is_enabled(&net.initial_marking(), load));
    let mut marking = net.initial_marking();
    play(net, &mut marking, &["enter<A.new>"]);
    assert!(net.is_enabled(&marking, load));
    let (id, phase) = match made.origin(t) {
        Origin::Activity { id, phase, .. } => (id, phase),
        Origin::Shift => panic!("it is no shift"),
    };
    assert_eq!((id, phase), (cell(C1).activity_named("load M1").expect("it is there"), TransitionPhase::Whole));
}

/// Every mode leads back to its part of the description.
#[test]
fn modes_lead_back_to_the_description() {
    let cell = cell(C1);
    for detail in [Detail::Coordination, Detail::Expanded] {
        let made = net(&cell, detail, &[1, 1]).expect("it is small");
        let of = |name: &str| {
            let (activity, of) = made.move_of(&cell, mode(made.net(), name)).expect("it is a move");
            (activity.name.clone(), cell.stages[of.to.index()].name.clone(), of.time, of.program)
        };
        let end = if detail == Detail::Expanded { ".end" } else { "" };
        let second = |n| Some(Duration::from_secs(n));
        assert_eq!(of(&format!("M2.process{end}<A.new>")), ("M2.process".into(), "A.turn".into(), second(55), Some(1)));
        assert_eq!(
            of(&format!("M2.process{end}<B.grind>")),
            ("M2.process".into(), "B.done".into(), second(35), Some(4))
        );
        assert_eq!(of(&format!("unload M3{end}<B.grind>")), ("unload M3".into(), "B.grind".into(), second(12), None));
        assert_eq!(of("leave<B.done>"), ("leave".into(), "B.new".into(), None, None));
        let parts = ["ST.stored-parts", "M1.loaded", "M1.unload-ready", "outside.waiting"];
        let tokens = ["ST.available-capacity", "M1.available-capacity", "R.free", "outside.room"];
        let holds = |name: &&str| made.holds_parts(made.net().place_named(name).expect("it is there"));
        assert!(parts.iter().all(&holds) && !tokens.iter().any(holds));
    }
}

/// Plays the first enabled mode that is not excluded until there is none; the names of what left the cell, in order.
fn leaving(net: &ColouredNet, order: &[&str]) -> Vec<String> {
    let mut marking = net.initial_marking();
    let mut left = Vec::new();
    for name in order {
        play(net, &mut marking, &[name]);
    }
    loop {
        let next = net.enabled(&marking).into_iter().find(|&mode| !net.mode_name(mode).starts_with("enter"));
        let Some(next) = next else { return left };
        net.fire(&mut marking, next).expect("it is enabled");
        let name = net.mode_name(next);
        left.extend(name.starts_with("work.process").then_some(name));
    }
}

/// Two machines' worth of parts through one buffer.
fn buffered(prototype: &str) -> String {
    format!(
        "name = \"buffered\"\n[cell]\nwip_max = 4\n\
         [[resource]]\nname = \"B\"\nprototype = \"{prototype}\"\ncapacity = 3\n\
         [[resource]]\nname = \"work\"\nprototype = \"machine\"\n\
         [[sync]]\nname = \"enter\"\nactions = [\"outside.in\", \"B.store\"]\n\
         [[sync]]\nname = \"load\"\nactions = [\"B.retrieve\", \"work.load\"]\n\
         [[sync]]\nname = \"leave\"\nactions = [\"work.unload\", \"outside.out\"]\n\
         [[part]]\nname = \"x\"\nstep = [{{ name = \"w\", on = [{{ resource = \"work\", time_s = 1 }}] }}]\n\
         [[part]]\nname = \"y\"\nstep = [{{ name = \"w\", on = [{{ resource = \"work\", time_s = 1 }}] }}]\n\
         [[part]]\nname = \"z\"\nstep = [{{ name = \"w\", on = [{{ resource = \"work\", time_s = 1 }}] }}]\n"
    )
}

#[test]
fn a_row_keeps_the_order_and_a_stack_turns_it_round() {
    let fifo = made(&buffered("fifo-buffer"), Detail::Coordination, &[1, 1, 1]);
    let filled =
        ["enter<x.new>", "B.shift 1<x.new>", "B.shift 2<x.new>", "enter<y.new>", "B.shift 1<y.new>", "enter<z.new>"];
    let worked = ["work.process<x.new>", "work.process<y.new>", "work.process<z.new>"];
    assert_eq!(leaving(fifo.net(), &filled), worked);
    let lifo = made(&buffered("lifo-buffer"), Detail::Coordination, &[1, 1, 1]);
    let filled = ["enter<x.new,1>", "enter<y.new,2>", "enter<z.new,3>"];
    let mut turned = worked;
    turned.reverse();
    assert_eq!(leaving(lifo.net(), &filled), turned);
    // Full is full.
    for (net, fill) in [(lifo.net(), &filled[..]), (fifo.net(), &["enter<x.new>"])] {
        let mut marking = net.initial_marking();
        play(net, &mut marking, fill);
        assert!(!net.enabled(&marking).iter().any(|&mode| net.mode_name(mode).starts_with("enter")));
    }
}

/// Both details of a cell with buffers, a conveyor and a human that carries: nothing is lost, nothing gets stuck.
#[test]
fn all_prototypes_together_get_nothing_stuck() {
    for prototype in ["fifo-buffer", "lifo-buffer", "random-access-store"] {
        let text = buffered(prototype)
            .replace(
                "[\"B.retrieve\", \"work.load\"]",
                "[\"B.retrieve\", \"belt.pick-and-place\", \"work.load\"]\ntime_s = 2",
            )
            .replace(
                "[\"work.unload\", \"outside.out\"]",
                "[\"work.unload\", \"ann.pick-and-place\", \"outside.out\"]\ntime_s = 2",
            )
            .replace(
                "[[sync]]\nname = \"enter\"",
                "[[resource]]\nname = \"belt\"\nprototype = \"conveyor\"\ncapacity = 2\n\
                 [[resource]]\nname = \"ann\"\nprototype = \"human\"\n[[sync]]\nname = \"enter\"",
            )
            .replace("\"B.store\"]", "\"B.store\"]\ntime_s = 1");
        for detail in [Detail::Coordination, Detail::Expanded] {
            let made = made(&text, detail, &[1, 1, 1]);
            let graph = explore(made.net(), 200_000).expect("it is small");
            assert_eq!((graph.deadlocks().count(), graph.is_reversible()), (0, Ok(())), "{prototype}");
            let parts = |state| -> u32 {
                let tokens = graph.marking(state).entries().iter();
                tokens.filter(|(cell, _)| made.holds_parts(made.net().cell(*cell).place)).map(|(_, count)| count).sum()
            };
            assert!(graph.numbers().all(|state| parts(state) == 3), "no part is lost or doubled");
        }
    }
}

/// An open cell is a closed one with endless parts outside: from everywhere each type can come as long as there is room.
#[test]
fn an_open_cell_makes_parts_as_they_enter() {
    let text = edited(C1, &[("wip_max = 6", "wip_max = 2")]);
    let made = net(&cell(&text), Detail::Coordination, Supply::Open).expect("it is small");
    let net = made.net();
    assert_eq!(net.place_named("outside.waiting"), None);
    let open = explore(net, 100_000).expect("it is small");
    assert_eq!((open.deadlocks().count(), open.is_reversible()), (0, Ok(())));
    // With two of each type outside no activity waits for a part.
    let closed = self::made(&text, Detail::Coordination, &[2, 2]).net().clone();
    let graph = explore(&closed, 100_000).expect("it is small");
    assert_eq!(graph.states().len(), open.states().len());
    assert_eq!(graph.steps().len(), open.steps().len());
    let mut marking = net.initial_marking();
    play(net, &mut marking, &["enter<A.new>", "enter<A.new>"]);
    assert!(!net.enabled(&marking).iter().any(|&mode| net.mode_name(mode).starts_with("enter")));
}

/// A human has one token for all work: one that works carries nothing, and one that carries does not work.
#[test]
fn a_human_does_one_thing_at_a_time() {
    let text = "name = \"hands\"\n[cell]\nwip_max = 2\n\
         [[resource]]\nname = \"S\"\nprototype = \"random-access-store\"\ncapacity = 2\n\
         [[resource]]\nname = \"ann\"\nprototype = \"human\"\n\
         [[resource]]\nname = \"M\"\nprototype = \"machine\"\n\
         [[sync]]\nname = \"enter\"\nactions = [\"outside.in\", \"S.store\"]\n\
         [[sync]]\nname = \"take\"\nactions = [\"S.retrieve\", \"ann.load\"]\n\
         [[sync]]\nname = \"give\"\nactions = [\"ann.unload\", \"S.store\"]\n\
         [[sync]]\nname = \"carry\"\ntime_s = 1\nactions = [\"S.retrieve\", \"ann.pick-and-place\", \"M.load\"]\n\
         [[sync]]\nname = \"leave\"\nactions = [\"M.unload\", \"outside.out\"]\n\
         [[part]]\nname = \"x\"\nstep = [{ name = \"a\", on = [{ resource = \"ann\", time_s = 1 }] }, \
         { name = \"b\", on = [{ resource = \"M\", time_s = 1 }] }]\n";
    let made = made(text, Detail::Expanded, &[2]);
    let net = made.net();
    let mut marking = net.initial_marking();
    let first = ["enter<x.new>", "take<x.new>", "ann.process.start<x.new>", "ann.process.end<x.new>", "give<x.a>"];
    play(net, &mut marking, &first);
    play(net, &mut marking, &["enter<x.new>", "take<x.new>"]);
    let (work, carry) = (mode(net, "ann.process.start<x.new>"), mode(net, "carry.start<x.a>"));
    for (one, other, end) in [(work, carry, "ann.process.end<x.new>"), (carry, work, "carry.end<x.a>")] {
        let mut marking = marking.clone();
        assert!(net.is_enabled(&marking, one) && net.is_enabled(&marking, other));
        net.fire(&mut marking, one).expect("it is enabled");
        assert!(!net.is_enabled(&marking, other));
        play(net, &mut marking, &[end]);
        assert!(net.is_enabled(&marking, other));
    }
}

/// What takes time and has no capacity of its own happens once at a time for each stage (seed 000, proposition 15, L2385).
#[test]
fn a_stage_is_moved_once_at_a_time() {
    let text = edited(
        C1,
        &[("\"ST.store\"]\n\n[[sync]]\nname = \"leave\"", "\"ST.store\"]\ntime_s = 3\n\n[[sync]]\nname = \"leave\"")],
    );
    let made = made(&text, Detail::Expanded, &[2, 1]);
    let net = made.net();
    let mut marking = net.initial_marking();
    play(net, &mut marking, &["enter.start<A.new>", "enter.start<B.new>"]);
    assert!(!net.is_enabled(&marking, mode(net, "enter.start<A.new>")));
    play(net, &mut marking, &["enter.end<A.new>", "enter.start<A.new>"]);
    assert!(!made.holds_parts(net.place_named("running.enter.idle").expect("it is there")));
}

/// Parts of different plans leave by different numbers of stages, and alternatives lead on by different numbers.
#[test]
fn what_is_moved_on_differently_is_a_transition_of_its_own() {
    let text = edited(
        C1,
        &[(
            "[[part]]\nname = \"B\"",
            "[[part.step]]\nname = \"wash\"\non = [{ resource = \"M2\", time_s = 5, program = 7 }]\n\n[[part]]\nname = \"B\"",
        )],
    );
    let cell = cell(&text);
    let made = net(&cell, Detail::Coordination, &[1, 1]).expect("it is small");
    let modes = |name: &str| {
        let net = made.net();
        names(net, net.modes(net.transition_named(name).unwrap_or_else(|| panic!("there is no {name}"))))
    };
    assert_eq!([modes("leave"), modes("leave/2")].concat().len(), 2);
    let graph = explore(made.net(), 100_000).expect("it is small");
    assert_eq!((graph.deadlocks().count(), graph.is_reversible()), (0, Ok(())));
}
