//! The cell with two robots of Richardsson, P4: its printed oracles.

use linewright_relations::{ConditionId, Relations};
use linewright_synthesis::{Mark, Supervisor, Synthesis, SynthesisLimits, Texts, combinations, synthesise};

use crate::generate::read;

pub fn two_robots() -> Relations {
    read(&[
        ("relations.toml", include_str!("../../launch-config/lines/two-robot-cell/relations.toml")),
        ("operations.csv", include_str!("../../launch-config/lines/two-robot-cell/operations.csv")),
        ("relations.csv", include_str!("../../launch-config/lines/two-robot-cell/relations.csv")),
    ])
}

pub fn supervisor(relations: &Relations, products: usize) -> Supervisor {
    let products = vec![ConditionId(0); products];
    match synthesise(relations, &products, &SynthesisLimits::default()).expect("it is small") {
        Synthesis::Supervisor(found) => *found,
        Synthesis::Contradiction(found) => panic!("there is none: {found:?}"),
    }
}

#[test]
fn there_are_two_supervisors_and_three_cops_for_each_machine() {
    let relations = two_robots();
    let combinations = combinations(&relations, 100).expect("they are few");
    assert_eq!(combinations, [vec![ConditionId(0)], vec![ConditionId(0); 2]]);
    let found: Vec<Supervisor> = combinations.iter().map(|products| supervisor(&relations, products.len())).collect();
    for machine in 0..relations.machines.len() {
        let own = found.iter().flat_map(|found| &found.coordinated).filter(|cop| cop.machine.0 == machine);
        assert_eq!(own.count(), 3, "{}", relations.machines[machine].name);
    }
    assert!(found[0].added.is_empty(), "one product alone needs no more than its relations");
}

/// Without the added predecessor R1 takes the gripper for the second product, and R2 needs it to take the first one out.
#[test]
fn the_gripper_is_left_by_the_first_product_before_it_is_taken_for_the_second() {
    let relations = two_robots();
    let found = supervisor(&relations, 2);
    let texts = Texts { relations: &relations, composition: &found.composition };
    let added: Vec<String> = found
        .added
        .iter()
        .map(|added| format!("{} after {}", texts.operation(added.of), texts.guard(&added.guard)))
        .collect();
    assert_eq!(added, ["21(P2) after 56(P1) finished"]);
    let reason = texts.trap(&found.added[0].reason);
    assert_eq!(
        reason,
        [
            "R1 cannot start 23(P2) put part in F1: it waits for 31(P2) of F1",
            "F1 cannot start 33(P1) open all clamps: it waits for 53(P1) of R2",
            "R2 cannot start 52(P1) get gripper: it waits for zone gripper, which R1 has",
        ]
    );
    let cop = found.coordinated.iter().find(|cop| cop.instance == 1 && relations.machine(cop.machine).name == "R1");
    let cop = cop.expect("R1 works on the second product");
    let with_more: Vec<&str> = cop
        .steps
        .iter()
        .filter(|step| !step.added.is_empty())
        .map(|step| relations.operation(step.operation).id.as_str())
        .collect();
    assert_eq!(with_more, ["21"]);
}

#[test]
fn the_cell_locks_where_the_added_predecessor_is_taken_out() {
    let relations = two_robots();
    let found = supervisor(&relations, 2);
    // Everything that the tables allow, without what is added.
    assert!(found.sizes.reachable > found.sizes.supervised);
    let mut state = std::collections::BTreeSet::new();
    let start = |id: &str, instance: usize| {
        let operation = relations.operations.iter().position(|operation| operation.id == id).expect("it is declared");
        let of = &found.composition.operations;
        of.iter().position(|of| of.instance == instance && of.operations[0].0 == operation).expect("it is done")
    };
    let (early, delayed) = (start("21", 1), start("52", 0));
    // R2 is late, R1 takes the gripper for the second product; then anything: nothing is possible any more, and not all is done.
    loop {
        let is_held = |of: usize| of == delayed && !state.contains(&(early, Mark::Started));
        let Some(mark) =
            found.composition.enabled(&state).find(|event| !is_held(event.of)).map(|event| (event.of, event.mark))
        else {
            break;
        };
        state.insert(mark);
    }
    assert!(state.contains(&(early, Mark::Started)));
    let finished = state.iter().filter(|(_, mark)| *mark == Mark::Finished).count();
    assert!(finished < found.composition.operations.len(), "it did not lock");
}

#[test]
fn more_products_add_a_predecessor_for_each_but_the_first() {
    let relations = two_robots();
    let found = supervisor(&relations, 3);
    let texts = Texts { relations: &relations, composition: &found.composition };
    let added: Vec<String> = found
        .added
        .iter()
        .map(|added| format!("{} after {}", texts.operation(added.of), texts.guard(&added.guard)))
        .collect();
    let expected: Vec<String> =
        (2..=3).map(|product| format!("21(P{product}) after 56(P{}) finished", product - 1)).collect();
    assert_eq!(added, expected);
}
