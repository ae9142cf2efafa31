//! The shipped cells: sound as they are, and with a counterexample where they are not. And verdicts on cells that no
//! text describes: broken after parsing.

use linewright_cell::ActivityKind;
use linewright_nets::explicit::ExplorationLimits;
use linewright_proof::cell::{CellExploration, Verdict, check};

use super::{ASSEMBLY, C1, cell, checked, edited, failing, verdicts};

#[test]
fn the_shipped_cells_are_sound() {
    for (text, states, arcs) in [(C1, 14_952, 63_770), (ASSEMBLY, 2_394, 9_534)] {
        let cell = cell(text);
        let checked = checked(&cell);
        assert!(checked.holds(), "{checked:#?}");
        assert_eq!((checked.sound, checked.groups.len()), (cell.limits.wip_max, 1));
        assert_eq!((checked.groups[0].states, checked.groups[0].arcs), (states, arcs));
    }
}

/// The first property that fails: the reason, the steps, and the needs in the end.
#[track_caller]
fn story(text: &str) -> (String, Vec<String>, Vec<String>) {
    let checked = checked(&cell(text));
    let property = failing(&checked).clone();
    let story = property.counterexample.expect("it is told");
    let parts = story.resources.iter().flat_map(|resource| resource.parts.iter().map(move |part| (resource, part)));
    let needs = parts.map(|(resource, part)| {
        let at = part.at.as_ref().map(|at| format!(", {at}")).unwrap_or_default();
        format!("{}: {} ({}){at}: {}", resource.name, part.part, part.stage, part.needs.join(", or "))
    });
    (format!("{}. {}", property.reason, property.help.expect("it can be helped")), story.steps, needs.collect())
}

/// A8, seed 000, L1432-1439: robot 1 grasps a part of type 1 while robot 2 has one. It is what the reservation prevents.
#[test]
fn without_the_reservation_the_assembly_cell_gets_stuck_as_printed() {
    let (reason, steps, needs) = story(&edited(ASSEMBLY, &[("reserve = true", "reserve = false")]));
    assert_eq!(
        reason,
        "not with 2 parts in the cell at once, after 6 steps; with up to 1 it holds. `reserve = true` in `[cell]`: a part \
         is then grasped only if the place for it is reserved; or `wip_max = 1` in `[cell]`: with no more parts at once \
         nothing is wrong"
    );
    assert_eq!(
        steps,
        [
            "arrive: 1 #1 comes to input",
            "load robot_2: robot_1 grasps 1 #1, at input",
            "load robot_2: robot_1 puts 1 #1 into robot_2",
            "arrive: 1 #2 comes to input",
            "load robot_2: robot_1 grasps 1 #2, at input",
            "robot_2.process: work of 1 #1",
        ]
    );
    assert_eq!(
        needs,
        [
            "robot_1: 1 #2 (1.new), for `load robot_2`: `load robot_2` needs room in robot_2",
            "robot_2: 1 #1 (1.done): `unload robot_2` needs robot_1 free",
        ]
    );
}

#[test]
fn without_the_reservation_c1_gets_stuck() {
    let (_, steps, needs) = story(&edited(C1, &[("reserve = true", "reserve = false")]));
    assert_eq!(steps.last().map(String::as_str), Some("M1.process: turn of A #1"));
    assert_eq!(
        needs,
        ["M1: A #1 (A.turn): `unload M1` needs R free", "R: A #2 (A.new), for `load M1`: `load M1` needs room in M1"]
    );
}

/// The reservation alone does not prevent it: with one part more than the store holds there may be no room to unload to.
#[test]
fn more_parts_than_the_store_holds_get_stuck() {
    let (reason, steps, needs) =
        story(&edited(C1, &[("capacity = 6", "capacity = 4"), ("wip_max = 6", "wip_max = 9")]));
    assert_eq!(
        reason,
        "not with 5 parts in the cell at once, after 7 steps; with up to 4 it holds. `wip_max = 4` in `[cell]`: with no \
         more parts at once nothing is wrong"
    );
    assert_eq!(steps.len(), 7);
    assert_eq!(needs.len(), 5);
    assert_eq!(needs[0], "ST: B #2 (B.new): `load M3` needs room in M3");
    assert_eq!(needs[4], "M3: B #1 (B.grind): `unload M3` needs room in ST");
}

/// Starts and ends side by side are one step of the counterexample, others two.
#[test]
fn starts_and_ends_are_told_apart_only_where_something_is_between() {
    let cell = cell(&edited(C1, &[("reserve = true", "reserve = false")]));
    let checked =
        check(&CellExploration { detail: linewright_cell::net::Detail::Expanded, ..CellExploration::new(&cell) });
    let checked = checked.expect("it is small");
    let story = failing(&checked).counterexample.clone().expect("it is told");
    let steps = story.steps.iter().map(|step| step.replace(" begins:", ":").replace(" ends:", ":"));
    let distinct: std::collections::BTreeSet<String> = steps.collect();
    assert_eq!(distinct.len(), 6, "{:?}", story.steps);
    assert!(story.steps.iter().any(|step| step == "enter: A #1 comes to ST"), "{:?}", story.steps);
}

/// A cell from which no part may leave, and whose parts can go to and fro for ever: nothing is stuck, and all is in vain.
#[test]
fn what_goes_on_without_an_end_is_found() {
    let second = "[[resource]]\nname = \"T\"\nprototype = \"random-access-store\"\ncapacity = 6\n\
                  [[sync]]\nname = \"there\"\nactions = [\"ST.retrieve\", \"T.store\"]\n\
                  [[sync]]\nname = \"back\"\nactions = [\"T.retrieve\", \"ST.store\"]\n";
    let mut cell = cell(&format!("{C1}\n{second}"));
    assert!(checked(&cell).holds());
    cell.activities.iter_mut().filter(|activity| activity.kind == ActivityKind::Leave).for_each(|a| a.moves.clear());
    let found = checked(&cell);
    assert_eq!(verdicts(&found), [Verdict::Undecided, Verdict::Fails, Verdict::Holds], "{found:#?}");
    let property = failing(&found);
    assert!(property.reason.starts_with("not with 1 part in the cell"), "{property:?}");
    let story = property.counterexample.as_ref().expect("it is told");
    assert_eq!(story.steps.len(), 1);
    let parts: Vec<_> = story.resources.iter().flat_map(|resource| &resource.parts).collect();
    assert!(parts.len() == 1 && parts[0].needs.is_empty(), "it can go on: {story:?}");
}

/// M1 is not loaded any more: the activities for it and after it can never be done, and M2 does it all.
#[test]
fn what_can_never_be_done_is_said() {
    let mut cell = cell(C1);
    let load = cell.activity_named("load M1").expect("it is there");
    cell.activities[load.index()].moves.clear();
    let found = checked(&cell);
    assert_eq!(verdicts(&found), [Verdict::Holds, Verdict::Holds, Verdict::Remark]);
    assert_eq!(found.properties[2].reason, "never: `unload M1` of A.turn, `M1.process` of A.new");
    assert!(found.holds(), "a remark does not speak against the cell");
}

/// Limits: unseen states are not taken for right, and the extent is reported.
#[test]
fn what_is_too_much_is_undecided_from_there_on() {
    let cell = cell(C1);
    let limited = |states| {
        let limits = ExplorationLimits { states, ..ExplorationLimits::default() };
        check(&CellExploration { limits, ..CellExploration::new(&cell) }).expect("it has a net")
    };
    let found = limited(1_000);
    assert_eq!(verdicts(&found), [Verdict::Undecided, Verdict::Undecided, Verdict::Holds], "{found:#?}");
    assert!((1..6).contains(&found.sound) && !found.groups[0].exhausted && !found.holds());
    let reason = &found.properties[0].reason;
    let said =
        format!("it holds with up to {} parts in the cell at once; with more it is undecided after ", found.sound);
    assert!(reason.starts_with(&said), "{reason}");
    let nothing = limited(2);
    assert_eq!((nothing.sound, verdicts(&nothing)), (0, [Verdict::Undecided; 3]), "{nothing:#?}");

    // A violation within the limits is found all the same, whatever is beyond them.
    let stuck = super::cell(&edited(C1, &[("reserve = true", "reserve = false"), ("wip_max = 6", "wip_max = 10000")]));
    let limits = ExplorationLimits { states: 1_000, ..ExplorationLimits::default() };
    let found = check(&CellExploration { limits, ..CellExploration::new(&stuck) }).expect("it has a net");
    assert_eq!((verdicts(&found)[0], found.sound), (Verdict::Fails, 1), "{found:#?}");
}

/// More parts are let in than ever fit: all larger numbers are the same, and need not be tried.
#[test]
fn more_parts_than_ever_fit_are_as_many_as_fit() {
    let small = include_str!("../../../fuzz/seeds/cell/smallest.toml").replace("wip_max = 2", "wip_max = 10000");
    let found = checked(&cell(&small));
    assert!(found.holds() && found.sound == 10_000, "{found:#?}");
    assert!(found.groups[0].parts < 10, "{found:#?}");
}
