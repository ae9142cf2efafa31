//! Tables for which there is no supervisor: rows that contradict each other, and none that do not.

use linewright_relations::{ConditionId, Relations};
use linewright_synthesis::{Contradiction, Restriction, Synthesis, SynthesisLimits, Texts, synthesise};

use crate::generate::read;

const TABLE: &str = include_str!("../../launch-config/lines/two-robot-cell/relations.csv");

/// The cell with two robots, whose R1 keeps the gripper until the clamps are open, for which R2 needs the gripper.
fn contradictory() -> String {
    let table = TABLE.replace("R1,25,,", "R1,25,33,").replace("R2,53,26,", "R2,53,24,");
    assert_ne!(table, TABLE);
    table
}

fn relations(table: &str) -> Relations {
    read(&[
        ("relations.toml", include_str!("../../launch-config/lines/two-robot-cell/relations.toml")),
        ("operations.csv", include_str!("../../launch-config/lines/two-robot-cell/operations.csv")),
        ("relations.csv", table),
    ])
}

fn found(relations: &Relations) -> Synthesis {
    synthesise(relations, &[ConditionId(0)], &SynthesisLimits::default()).expect("it is small")
}

fn contradiction(relations: &Relations) -> Contradiction {
    match found(relations) {
        Synthesis::Supervisor(_) => panic!("there is a supervisor"),
        Synthesis::Contradiction(found) => *found,
    }
}

#[test]
fn the_rows_that_contradict_each_other_are_named_and_no_others() {
    let relations = relations(&contradictory());
    let found = contradiction(&relations);
    let texts = Texts { relations: &relations, composition: &found.composition };
    let rows: Vec<String> = found.conflict.iter().map(|row| texts.restriction(row)).collect();
    assert_eq!(
        rows,
        [
            "relations.csv:10: 25 after 33",
            "relations.csv:15: 33 after 53",
            "relations.csv:21: 51 after 24",
            "relations.csv:22: R2 takes zone gripper in 52, 53, 54, 55, 56",
        ]
    );
    let trap = found.trap.expect("there is a way into it");
    assert!(trap.is_shortest);
    assert_eq!(texts.way(&trap).len(), 5, "{:?}", texts.way(&trap));
    assert_eq!(texts.way(&trap)[4], "24(P1) release part in F1");
    assert_eq!(
        texts.trap(&trap),
        [
            "R1 cannot start 25(P1) get weld gun: it waits for 33(P1) of F1",
            "F1 cannot start 33(P1) open all clamps: it waits for 53(P1) of R2",
            "R2 cannot start 52(P1) get gripper: it waits for zone gripper, which R1 has",
        ]
    );
}

/// The table with nothing that restricts but these.
fn only(table: &str, relations_of: &Relations, kept: &[&Restriction]) -> String {
    let machine = |name: &str| relations_of.machines.iter().position(|machine| machine.name == name);
    let lines = table.lines().enumerate().map(|(nth, line)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        let has_row = |restriction: &&&Restriction| matches!(restriction, Restriction::Predecessors(row) if row.line as usize == nth + 1);
        let has_zone =
            |restriction: &&&Restriction| matches!(restriction, Restriction::Booking(of, _) if Some(of.0) == machine(cells[0]));
        let (is_after, is_booked) = (kept.iter().any(|r| has_row(&r)), kept.iter().any(|r| has_zone(&r)));
        // What an operator does is no restriction.
        if nth > 0 && !is_after && cells[3] != "uncontrolled" {
            cells[2] = "";
        }
        if nth > 0 && !is_booked {
            (cells[4], cells[5]) = ("", "");
        }
        cells.join(",")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Of zones this is not so row by row: a machine that does not wait for one may still have it, and others wait.
#[test]
fn without_any_one_predecessor_of_a_conflict_there_is_a_supervisor() {
    let table = contradictory();
    let relations_of = relations(&table);
    let conflict = contradiction(&relations_of).conflict;
    let all: Vec<&Restriction> = conflict.iter().collect();
    let rows = all.iter().filter(|restriction| matches!(restriction, Restriction::Predecessors(_)));
    let mut tried = 0;
    for restriction in rows {
        let fewer: Vec<&Restriction> = all.iter().copied().filter(|other| other != restriction).collect();
        let less = relations(&only(&table, &relations_of, &fewer));
        assert!(matches!(found(&less), Synthesis::Supervisor(_)), "{restriction:?}");
        tried += 1;
    }
    assert!(tried >= 2, "{conflict:?}");
}
