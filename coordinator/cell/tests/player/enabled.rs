//! The enabled set after each of 10⁵ firings, against [`ColouredNet::enabled`], which starts anew each time; and what
//! keeping it up to date costs.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::{
    CellKind, CellTable, FiringId, ModeId, PlanError, PlayPlan, PlayedActivity, PlayerState, Record, RecordKind,
};
use linewright_line::Tick;
use linewright_nets::coloured::{
    ColouredBuilder, ColouredNet, Colours, Domain, Function, Guard, abs, colour, id, not_colour, proj, ring, succ,
};
use linewright_nets::{Marking, NetBuilder};

use super::plans::{Compiled, TOKENS, alone, immediate};
use super::printed::{Variant, cell};
use linewright_random::Random as Dice;

/// A net of two basic domains whose arcs move one colour, the next one, or all of them; some of its modes are guarded.
fn random_net(dice: &mut Dice) -> ColouredNet {
    let mut b = ColouredBuilder::new("random");
    let basics = [b.basic("A", 2 + dice.below(2) as u32), b.basic("B", 1 + dice.below(3) as u32)];
    let kinds: Vec<usize> = (0..4 + dice.below(5)).map(|_| dice.below(4)).collect();
    let domain = |kind: usize| match kind {
        0 => Domain::Uncoloured,
        1 => basics[0].into(),
        2 => basics[1].into(),
        _ => basics.into(),
    };
    let places: Vec<_> = kinds.iter().enumerate().map(|(i, &kind)| b.place(format!("p{i}"), domain(kind))).collect();
    for (&place, &kind) in places.iter().zip(&kinds) {
        for _ in 0..dice.below(4) {
            let tones: &[u32] = &[1 + dice.below(2) as u32, 1];
            let tones = [&[][..], &tones[..1], &tones[1..], tones][kind];
            b.tokens(place, tones, 1 + dice.below(3) as u32);
        }
    }
    for t in 0..4 + dice.below(6) {
        let t = b.transition(format!("t{t}"), basics);
        let function = |kind: usize, dice: &mut Dice| -> Function {
            match (kind, dice.below(4)) {
                (0, 0) => 2 * abs(),
                (0, _) => abs(),
                (1, 0) => proj([1]).of(succ(1, 1)),
                (1, 1) => 2 * proj([1]),
                (1, _) => proj([1]),
                (2, 0) => proj([2]).of(ring(2)),
                (2, _) => proj([2]),
                (_, 0) => succ(2, 1),
                (_, _) => id(),
            }
        };
        let (mut from, mut to) = (BTreeSet::new(), BTreeSet::new());
        for _ in 0..1 + dice.below(3) {
            from.insert(dice.below(places.len()));
            to.insert(dice.below(places.len()));
        }
        from.into_iter().for_each(|at| _ = b.input(t, places[at], function(kinds[at], dice)));
        to.into_iter().for_each(|at| _ = b.output(t, places[at], function(kinds[at], dice)));
        if dice.one_in(3) {
            b.guard(t, Guard::all([if dice.one_in(2) { colour(1, 1) } else { not_colour(1, 1) }]));
        }
    }
    b.build().unwrap()
}

/// Tokens that a mode takes and gives in the long form, by the coloured net.
pub fn moves(it: &Compiled) -> Vec<[Vec<(usize, u32)>; 2]> {
    let of_mode = |t| {
        let mode = it.long.mode(t);
        let mut sides = [Vec::new(), Vec::new()];
        for place in it.net.places() {
            for (side, moved) in sides.iter_mut().zip(it.net.moves(mode, place)) {
                side.extend(moved.into_iter().map(|(tones, count)| {
                    let cell = it.net.cell_of(place, &tones).unwrap();
                    (it.long.place_of(cell).unwrap().index(), count)
                }));
            }
        }
        sides
    };
    it.long.net().transitions().map(of_mode).collect()
}

/// Starts and ends what is enabled, at random, `firings` times; how many states were compared.
fn play(it: &Compiled, dice: &mut Dice, firings: usize) -> usize {
    let moves = moves(it);
    let mut counts: Vec<u32> = it.long.net().initial_marking().as_slice().to_vec();
    let mut state = PlayerState::new(it.table.clone());
    let (mut running, mut next, mut fired): (Vec<(FiringId, ModeId)>, _, _) = (Vec::new(), 0, 0);
    loop {
        let marking = it.long.coloured(&Marking::from_tokens(counts.iter().copied()));
        let expected: Vec<_> =
            it.net.enabled(&marking).iter().map(|&mode| it.long.transition_of(mode).unwrap().0).collect();
        assert!(state.enabled().iter().map(|mode| mode.0).eq(expected.iter().copied()), "{}", it.net);
        assert!(state.marking().counts().iter().map(|&count| count as u32).eq(counts.iter().copied()));
        if fired == firings || counts.iter().any(|&count| count > 1_000_000) {
            return fired;
        }
        let enabled = state.enabled();
        let fact = if enabled.is_empty() || (!running.is_empty() && dice.one_in(2)) {
            if running.is_empty() {
                return fired;
            }
            let (firing, mode) = running.swap_remove(dice.below(running.len()));
            moves[mode.index()][1].iter().for_each(|&(cell, count)| counts[cell] += count);
            RecordKind::Ended { firing }
        } else {
            let mode = *dice.pick(&enabled);
            moves[mode.index()][0].iter().for_each(|&(cell, count)| counts[cell] -= count);
            fired += 1;
            if it.table.is_immediate(mode) {
                moves[mode.index()][1].iter().for_each(|&(cell, count)| counts[cell] += count);
                RecordKind::Fired { mode, part: None }
            } else {
                next += 1;
                running.push((FiringId(next), mode));
                RecordKind::Started { firing: FiringId(next), mode, part: None, orders: Vec::new() }
            }
        };
        state.apply(&Record { at: Tick::ZERO, fact }).unwrap();
    }
}

/// Everything counted, any number of firings at once, some of them immediate.
fn counted(net: ColouredNet, dice: &mut Dice) -> Compiled {
    let salt = dice.below(7);
    Compiled::new(
        net,
        |_| TOKENS,
        |name| {
            let servers = u32::MAX;
            let base = if (name.len() + salt).is_multiple_of(3) { immediate() } else { alone(1) };
            PlayedActivity { servers, ..base }
        },
    )
}

#[test]
fn the_enabled_set_of_the_printed_cell_is_that_of_the_coloured_net() {
    let mut dice = Dice::new(1428);
    let mut fired = 0;
    for unreserved in [false, true, false, true] {
        let it = counted(cell(&Variant { outside: [2, 3, 2], unreserved, ..Variant::default() }), &mut dice);
        for _ in 0..4 {
            fired += play(&it, &mut dice, 3000);
        }
    }
    assert!(fired > 20_000, "{fired}");
}

#[test]
fn the_enabled_set_of_random_nets_is_that_of_the_coloured_net() {
    let mut dice = Dice::new(7);
    let (mut fired, mut long) = (0, 0);
    while fired < 100_000 {
        let net = random_net(&mut dice);
        if linewright_nets::coloured::unfold(&net, Colours::Reachable, 100_000).is_err() {
            continue;
        }
        let it = counted(net, &mut dice);
        for _ in 0..3 {
            let played = play(&it, &mut dice, 400);
            fired += played;
            long += usize::from(played == 400);
        }
    }
    assert!(long > 100, "most nets are over soon: {long}");
}

/// Robots that serve four machines each, one part for each machine; how many arcs are looked at for each firing.
fn looks_per_firing(machines: usize) -> f64 {
    let mut b = NetBuilder::new("wide");
    for robot in 0..machines / 4 {
        let free = b.place(format!("robot {robot}"), 1);
        for machine in 0..4 {
            let [capacity, waiting, loaded, done] = [("capacity", 1), ("waiting", 1), ("loaded", 0), ("done", 0)]
                .map(|(name, count)| b.place(format!("{name} {robot} {machine}"), count));
            let [load, process, unload] =
                ["load", "process", "unload"].map(|name| b.transition(format!("{name} {robot} {machine}")));
            b.input(load, free, 1).input(load, waiting, 1).input(load, capacity, 1);
            b.output(load, free, 1).output(load, loaded, 1);
            b.input(process, loaded, 1).output(process, done, 1);
            b.input(unload, free, 1).input(unload, done, 1);
            b.output(unload, free, 1).output(unload, waiting, 1).output(unload, capacity, 1);
        }
    }
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let it = Compiled::new(net, |_| TOKENS, |_| alone(1));
    let mut state = PlayerState::new(it.table.clone());
    let (before, firings, mut dice) = (state.enabling().looks(), 4000, Dice::new(3));
    let mut running = Vec::new();
    for firing in (1..=firings).map(FiringId) {
        while state.enabling().decided().is_empty() || running.len() > machines / 8 {
            let ended = running.swap_remove(dice.below(running.len()));
            state.apply(&Record { at: Tick::ZERO, fact: RecordKind::Ended { firing: ended } }).unwrap();
        }
        let mode = *dice.pick(state.enabling().decided());
        let fact = RecordKind::Started { firing, mode, part: None, orders: Vec::new() };
        state.apply(&Record { at: Tick::ZERO, fact }).unwrap();
        running.push(firing);
    }
    (state.enabling().looks() - before) as f64 / firings as f64
}

/// A hundred times as many resources, the same number of looks.
#[test]
fn a_firing_costs_the_same_in_a_cell_of_a_thousand_machines() {
    let [few, many] = [12, 1200].map(looks_per_firing);
    assert!(many < few * 1.2 && many < 20.0, "{few} {many}");
}

/// Of several cells it lacks, a mode watches the one that the fewest compete for; the robot wakes it last.
#[test]
fn a_mode_watches_what_is_its_own_rather_than_what_is_everybodys() {
    let mut b = NetBuilder::new("private");
    let robot = b.place("robot", 0);
    let machine = b.place("machine", 0);
    let parts: Vec<_> = (0..3).map(|kind| b.place(format!("part {kind}"), 0)).collect();
    for (name, place) in [("robot", robot), ("machine", machine), ("part", parts[0])] {
        let (come, away) = (b.transition(format!("{name} comes")), b.place(format!("{name} away"), 1));
        b.input(come, away, 1).output(come, place, 1);
    }
    for (kind, &part) in parts.iter().enumerate() {
        let (load, unload) = (b.transition(format!("load {kind}")), b.transition(format!("unload {kind}")));
        b.input(load, robot, 1).input(load, machine, 1).input(load, part, 1);
        b.input(unload, robot, 1);
    }
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let long = linewright_nets::coloured::unfold(&net, Colours::All, 1000).unwrap();
    let plan = PlayPlan {
        cells: vec![TOKENS; long.net().place_count()],
        activities: vec![immediate()],
        activity_of: vec![0; long.net().transition_count()],
        repeat_interval: Duration::ZERO,
        grace: Duration::ZERO,
        products: Vec::new(),
        stores: Vec::new(),
    };
    let table = Arc::new(CellTable::compile(&long, plan).unwrap());
    let named = |name: &str| table.modes().find(|&mode| table.mode_name(mode) == name).unwrap();
    let mut state = PlayerState::new(table.clone());
    let mut watched = Vec::new();
    for next in ["robot comes", "part comes", "machine comes"] {
        watched.push(table.cell_name(state.enabling().lacks(named("load 0")).unwrap()));
        state.apply(&Record { at: Tick::ZERO, fact: RecordKind::Fired { mode: named(next), part: None } }).unwrap();
    }
    assert_eq!(watched, ["part 0", "part 0", "machine"]);
    assert_eq!(state.enabling().lacks(named("load 0")), None);
    assert_eq!(table.consumers(state.enabling().lacks(named("load 1")).unwrap()), [named("load 1")]);
}

#[test]
fn a_plan_that_does_not_fit_its_net_says_why() {
    let it = Compiled::new(cell(&Variant { waiting: [1, 0, 0], ..Variant::default() }), |_| TOKENS, |_| alone(1));
    let (cells, modes) = (it.table.cell_count(), it.table.mode_count());
    let plan = |kinds: Vec<CellKind>, activity, activity_of: Vec<usize>| PlayPlan {
        cells: kinds,
        activities: vec![activity],
        activity_of,
        repeat_interval: Duration::ZERO,
        grace: Duration::ZERO,
        products: Vec::new(),
        stores: Vec::new(),
    };
    let why = |plan| CellTable::compile(&it.long, plan).unwrap_err().to_string();
    let all = |kind| vec![kind; cells];
    assert!(why(plan(vec![], alone(1), vec![0; modes])).starts_with("the plan has kinds for 0 cells"));
    assert!(why(plan(all(TOKENS), alone(1), vec![])).starts_with("the plan has activities for 0 modes"));
    assert!(why(plan(all(TOKENS), alone(1), vec![1; modes])).ends_with("names activity 1; there are 1"));
    assert!(why(plan(all(super::plans::PARTS), alone(1), vec![0; modes])).ends_with("a mode moves one at most"));
    let idle = PlayedActivity { servers: 0, ..alone(1) };
    assert!(matches!(
        CellTable::compile(&it.long, plan(all(TOKENS), idle, vec![0; modes])),
        Err(PlanError::NoServer { .. })
    ));
    let told = PlayedActivity { kind: immediate().kind, ..super::plans::ordered("x", &[0], 1) };
    assert!(why(plan(all(TOKENS), told, vec![0; modes])).contains("is immediate and has orders"));
}
