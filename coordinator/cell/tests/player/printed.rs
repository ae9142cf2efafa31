//! The flexible production cell of seed 000 (Figs. 17 and 18, L1428-1544), played: the states and moves that are printed.
//!
//! The net is that of the coloured nets' own tests, which mark what is printed and what is rebuilt. Here t2 (robot 1
//! loads), t4 (a part is worked on) and t6 (robot 1 unloads) are done by stations; t1 and t5 are decided and take no time,
//! t3 and t7 happen by themselves.

use std::collections::BTreeMap;

use linewright_coordinator_cell::{
    CellKind, Coordination, DispatchDecision, Dispatcher, Fifo, HeldCandidate, HoldReason, OrderProgress,
    PlayedActivity, PlayerInput, PlayerOutbox, PlayerState, Question, Record, RecordKind, Start,
};
use linewright_line::{StationId, Tick};
use linewright_nets::coloured::{Clause, ColouredBuilder, ColouredNet, Domain, Guard, colour, id, proj};

use super::plans::{Compiled, PARTS, TOKENS, alone, immediate, ordered};
use super::world::World;

/// Differences from the printed net.
#[derive(Clone, Default)]
pub struct Variant {
    /// Parts of each kind that wait on p9.
    pub waiting: [u32; 3],
    /// Parts of each kind outside: they arrive on p9, and leave from p10 to come again.
    pub outside: [u32; 3],
    /// Robot 1 grasps a part without reserving the place for it.
    pub unreserved: bool,
}

/// (m1∧p1) ∨ (m2∧p2) ∨ (m2∧p3) (L1534).
fn work_plan() -> Guard {
    let clause = |m, p| Clause::all([colour(1, m), colour(3, p)]);
    Guard::any([clause(1, 1), clause(2, 2), clause(2, 3)])
}

pub fn cell(variant: &Variant) -> ColouredNet {
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
    b.input(if variant.unreserved { t3 } else { t1 }, p1, proj([1]));
    b.input(t1, p2, proj([2])).input(t1, p9, proj([3])).output(t1, p3, id());
    b.input(t2, p3, id()).output(t2, p4, id());
    b.input(t3, p4, id()).output(t3, p2, proj([2])).output(t3, p5, proj([1, 3]));
    b.input(t4, p5, proj([1, 3])).output(t4, p6, proj([1, 3]));
    b.input(t5, p6, proj([1, 3])).input(t5, p2, proj([2])).output(t5, p7, id());
    b.input(t6, p7, id()).output(t6, p8, id());
    b.input(t7, p8, id()).output(t7, p1, proj([1])).output(t7, p2, proj([2])).output(t7, p10, proj([3]));
    b.guard(t1, work_plan()).guard(t5, work_plan());
    if variant.outside != [0; 3] {
        let outside = b.place("outside", p);
        (1..).zip(variant.outside).for_each(|(kind, count)| _ = b.tokens(outside, &[kind], count));
        let (arrive, leave) = (b.transition("arrive", p), b.transition("leave", p));
        b.input(arrive, outside, id()).output(arrive, p9, id());
        b.input(leave, p10, id()).output(leave, outside, id());
    }
    b.build().unwrap()
}

/// p1 and p2 hold what is free; everything else is parts, each for itself.
pub fn kind(name: &str) -> CellKind {
    if name.starts_with("p1<") || name.starts_with("p2<") || name.starts_with("outside") { TOKENS } else { PARTS }
}

/// Stations: robot 1 is 0, robot 2 is 1, the human is 2.
pub fn activity(name: &str) -> PlayedActivity {
    let target = if name.contains("m1") { 1 } else { 2 };
    match name.split_once('<').map_or(name, |(transition, _)| transition) {
        "t1" | "t5" | "arrive" | "leave" => alone(0),
        "t2" => ordered("load", &[0, target], 10_000),
        "t4" => ordered("work", &[target], 20_000),
        "t6" => ordered("unload", &[0, target], 10_000),
        "t3" | "t7" => immediate(),
        other => panic!("{other} is no transition of the cell"),
    }
}

pub fn compiled(variant: &Variant) -> Compiled {
    Compiled::new(cell(variant), kind, activity)
}

/// Starts what is on its list, one after the other, and holds everything else; keeps the last question.
#[derive(Default)]
pub struct Script {
    pub starts: Vec<&'static str>,
    pub asked: Vec<String>,
    pub groups: Vec<Vec<usize>>,
    pub contested: Vec<String>,
}

impl Dispatcher for Script {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let table = question.state.table();
        self.asked = question.candidates.iter().map(|of| table.mode_name(of.mode).to_owned()).collect();
        self.groups = question.groups.iter().map(|group| group.candidates.clone()).collect();
        let contested = question.groups.iter().flat_map(|group| &group.contested);
        self.contested = contested.map(|&cell| table.cell_name(cell).to_owned()).collect();
        let mut answer = DispatchDecision::default();
        for (candidate, name) in self.asked.iter().enumerate() {
            match self.starts.iter().position(|wanted| wanted == name) {
                Some(0) => {
                    self.starts.remove(0);
                    let part = question.parts(&question.candidates[candidate]).next();
                    answer.start.push(Start { candidate, part });
                }
                Some(_) | None => {
                    answer.held.push(HeldCandidate { candidate, reason: HoldReason::NotYet(Tick::NEVER), until: None })
                }
            }
        }
        answer
    }
}

/// Plays the cell until it stands still in the state of Fig. 41: robot 2 has finished a part 1, the human is free, parts 2
/// and 3 wait (L2738-2740).
pub fn conflict_state() -> (World, Script) {
    let it = compiled(&Variant { waiting: [1, 1, 1], ..Variant::default() });
    let mut script = Script { starts: vec!["t1<m1,r1,p1>", "t2<m1,r1,p1>", "t4<m1,p1>"], ..Script::default() };
    let mut world = World::new(it, 3, 1);
    world.run(&mut script, Tick::from_millis(60_000));
    assert_eq!(script.starts, [""; 0], "all of it was played");
    (world, script)
}

/// A3, L2738-2740: enabled are exactly t1 in (m2,r1,p2) and (m2,r1,p3), and t5 in (m1,r1,p1). L2922: that is one request,
/// to one controller; L2746-2755: over <r1>, and over <m2>.
#[test]
fn the_conflict_of_figure_41_is_one_question_with_three_candidates() {
    let (world, script) = conflict_state();
    let three = ["t1<m2,r1,p2>", "t1<m2,r1,p3>", "t5<m1,r1,p1>"];
    assert_eq!(script.asked, three);
    assert_eq!(script.groups, [[0, 1, 2]]);
    assert_eq!(script.contested, ["p1<m2>", "p2<r1>"]);
    let state = world.state();
    assert_eq!(world.it.names(state.enabled()), three);
    assert_eq!(state.firings().len(), 0, "and nothing is in progress");
    let held: Vec<_> = state.held().iter().map(|&(mode, _)| mode).collect();
    assert_eq!(world.it.names(held), three, "the record says that all three were held");
}

/// Of the three, two need the robot, so no answer may start two of them; first come, first served starts one.
#[test]
fn an_answer_that_starts_two_of_them_is_not_followed() {
    struct Greedy;
    impl Dispatcher for Greedy {
        fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
            let start = |candidate| {
                let part = question.parts(&question.candidates[candidate]).next();
                Start { candidate, part }
            };
            DispatchDecision { start: (0..question.candidates.len()).map(start).collect(), held: Vec::new() }
        }
    }
    let (mut world, _) = conflict_state();
    let mut out = PlayerOutbox::default();
    let now = world.now;
    world.coordination.reconsider();
    world.coordination.step(now, &[], &mut Greedy, &mut out);
    assert!(matches!(out.events[..], [linewright_coordinator_cell::CellEvent::BadAnswer { .. }]));
    let started = out.records.iter().filter_map(|record| match record.fact {
        RecordKind::Started { mode, .. } => Some(world.it.table.mode_name(mode).to_owned()),
        _ => None,
    });
    // Parts 2 and 3 have waited since the beginning; part 2 has the smaller number. Then its loading is started.
    assert_eq!(started.collect::<Vec<_>>(), ["t1<m2,r1,p2>", "t2<m2,r1,p2>"]);
}

/// A5, L2736: robot 1 loads the human with a part 2 while robot 2 works on a part 1: t2 (m2∧p2) ∥ t4 (m1∧p1). Two
/// activities are in progress, and three stations have their orders.
#[test]
fn loading_and_working_are_in_progress_together() {
    let it = compiled(&Variant { waiting: [1, 1, 0], ..Variant::default() });
    let mut script = Script { starts: vec!["t1<m1,r1,p1>", "t2<m1,r1,p1>", "t1<m2,r1,p2>"], ..Script::default() };
    let mut world = World::new(it, 3, 1);
    world.run(&mut script, Tick::from_millis(60_000));
    assert_eq!(script.asked, ["t2<m2,r1,p2>", "t4<m1,p1>"]);
    assert_eq!(script.groups, [vec![0], vec![1]], "they do not compete");
    let (now, mut out) = (world.now, PlayerOutbox::default());
    world.coordination.reconsider();
    world.coordination.step(now, &[], &mut Fifo, &mut out);
    let state = world.state();
    assert_eq!(world.it.names(state.firings().map(|firing| firing.mode)), ["t4<m1,p1>", "t2<m2,r1,p2>"]);
    let open = state.firings().flat_map(|firing| &firing.orders);
    let mut stations: Vec<_> =
        open.filter(|order| order.state == OrderProgress::Written).map(|order| order.station).collect();
    stations.sort_unstable();
    assert_eq!(stations, [StationId(0), StationId(1), StationId(2)]);
    assert_eq!(out.sends.len(), 3);
}

/// Change of the marking by one record.
fn difference(it: &Compiled, records: &[Record], which: usize) -> BTreeMap<String, i64> {
    let [before, after] =
        [which, which + 1].map(|count| PlayerState::replay(it.table.clone(), &records[..count]).unwrap());
    let changed = it.table.cells().map(|cell| {
        let [before, after] = [&before, &after].map(|state| state.marking().count(cell) as i64);
        (it.table.cell_name(cell).to_owned(), after - before)
    });
    changed.filter(|&(_, change)| change != 0).collect()
}

/// A6, L1972-1974: t3 with part 3 takes ω* from p4, and gives <r1> to p2 and <m2,p3> to p5.
#[test]
fn what_t3_moves_is_as_printed() {
    let mut world = World::new(compiled(&Variant { waiting: [0, 0, 1], ..Variant::default() }), 3, 1);
    world.run(&mut Fifo, Tick::from_millis(60_000));
    let (t3, log) = (world.it.mode("t3<m2,r1,p3>"), &world.log);
    let fired = |record: &Record| matches!(record.fact, RecordKind::Fired { mode, .. } if mode == t3);
    let at = log.iter().position(fired).unwrap();
    let expected = [("p2<r1>", 1), ("p4<m2,r1,p3>", -1), ("p5<m2,p3>", 1)];
    assert_eq!(difference(&world.it, log, at), expected.map(|(name, change)| (name.to_owned(), change)).into());
    // And the part in it is the same all the time.
    assert_eq!(world.state().parts().count(), 1);
}

/// A6 where loading is one activity, t1 to t3 in three phases: its start takes <m2>, <r1> and the part; its end gives <r1>
/// and <m2,p3>. The robot is nowhere in between.
#[test]
fn the_end_of_a_loading_gives_what_t3_gives() {
    let it = super::crash::merged([0, 0, 1]);
    let mut world = World::new(it, 3, 1);
    world.run(&mut Fifo, Tick::from_millis(60_000));
    let load = world.it.mode("load<m2,r1,p3>");
    let start =
        world.log.iter().position(|r| matches!(r.fact, RecordKind::Started { mode, .. } if mode == load)).unwrap();
    let RecordKind::Started { firing, .. } = world.log[start].fact else { unreachable!() };
    let end = world.log.iter().position(|r| r.fact == RecordKind::Ended { firing }).unwrap();
    let named = |list: &[(&str, i64)]| -> BTreeMap<String, i64> {
        list.iter().map(|&(name, change)| (name.to_owned(), change)).collect()
    };
    let taken = [("free<m2>", -1), ("robot<r1>", -1), ("input<p3>", -1)];
    assert_eq!(difference(&world.it, &world.log, start), named(&taken));
    assert_eq!(difference(&world.it, &world.log, end), named(&[("robot<r1>", 1), ("loaded<m2,p3>", 1)]));
}

/// What does not start before its line is in auto.
#[test]
fn nothing_starts_before_it_may() {
    let it = compiled(&Variant { waiting: [1, 1, 1], ..Variant::default() });
    let mut out = PlayerOutbox::default();
    let mut player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
    player.step(Tick::ZERO, &[], &mut Fifo, &mut out);
    assert_eq!(player.state().firings().len(), 0);
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], &mut Fifo, &mut out);
    // t1 needs no station; t2 does, and none has been received.
    let started = out.records.iter().filter(|record| matches!(record.fact, RecordKind::Started { .. })).count();
    assert_eq!((started, player.state().firings().len()), (1, 0));
    assert_eq!(it.names(player.state().enabled()), ["t2<m1,r1,p1>"]);
    assert_eq!(out.sends, []);
}
