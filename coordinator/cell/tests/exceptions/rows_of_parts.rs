//! Rows, of which a sensor sees the end only; and a coordinator without its log, which has no part that is there.

use linewright_coordinator_cell::exception::{ExceptionStep, OutOfServiceReason};
use linewright_coordinator_cell::{PartId, Presence};

use super::bench::CellBench;

/// A part clamped in a machine without a record is seen before another is loaded upon it.
#[test]
fn a_part_that_no_log_knows_of_keeps_its_machine_from_being_loaded() {
    let mut bench = CellBench::c1(&[1, 0]);
    let m1 = bench.resource("M1");
    bench.sim.truth.put(PartId(99), Some(m1));
    bench.until_that(|bench| bench.state().left() == 1);
    assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Mismatch)]);
    assert!(bench.alarm().text.contains("M1"), "{}", bench.alarm().text);
    // It is taken out.
    bench.sim.truth.put(PartId(99), None);
    bench.seconds_later(2.0);
    bench.answer("up");
    assert_eq!(bench.down(), []);
}

/// Parts come in by a row, whose end a sensor of the robot's watches.
fn row() -> String {
    let belt = "[[resource]]\nname = \"belt\"\nprototype = \"fifo-buffer\"\ncapacity = 3\nstation = \"belt\"\n\
                presence = \"part_at_end\"\n[[resource]]\nname = \"M1\"";
    let text = super::bench::workcell();
    let text = text.replacen("[[resource]]\nname = \"M1\"", belt, 1);
    let text =
        text.replacen("actions = [\"outside.in\", \"ST.store\"]", "actions = [\"outside.in\", \"belt.store\"]", 1);
    text.replacen(
        "[[sync]]\nname = \"leave\"",
        "[[sync]]\nname = \"fetch\"\nactions = [\"belt.retrieve\", \"R.pick-and-place\", \"ST.store\"]\ntime_s = 8\n\
         orders = [{ station = \"belt\", task = \"give\" }]\n[[sync]]\nname = \"leave\"",
        1,
    )
}

#[test]
fn a_part_at_the_end_of_a_row_that_no_log_knows_of_is_found() {
    let mut bench = CellBench::new(&row(), &[1, 0]);
    let belt = bench.resource("belt");
    bench.sim.truth.put(PartId(99), Some(belt));
    bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
    assert_eq!(bench.down(), [("belt".to_owned(), OutOfServiceReason::Mismatch)]);
    assert_eq!(bench.state().parts().len(), 0, "nothing is put behind what is not known");
    bench.sim.truth.put(PartId(99), None);
    bench.seconds_later(2.0);
    bench.answer("up");
    bench.all_leave(1);
}

/// With parts behind, the end may be empty or not when one was fetched, and the sensor proves nothing. With none behind
/// it does: a part seen there has not been fetched.
#[test]
fn the_end_of_a_row_is_compared_only_where_it_is_known() {
    for (parts, seen, differs) in [(3, true, false), (3, false, false), (1, false, false), (1, true, true)] {
        let mut bench = CellBench::new(&row(), &[parts, 0]);
        bench.at("belt").is_stuck = true;
        bench.until_that(|bench| bench.state().exceptions().alarms().len() > 0);
        let fetched = bench.firing("fetch<A.new>").expect("it has failed").clone();
        let (belt, store) = (bench.resource("belt"), bench.resource("ST"));
        let others: Vec<PartId> = bench.sim.truth.parts().collect();
        others.iter().for_each(|&part| bench.sim.truth.put(part, None));
        if seen {
            bench.sim.truth.put(PartId(99), Some(belt));
        }
        bench.sim.truth.put(fetched.part.expect("it has one"), Some(store));
        bench.at("belt").is_stuck = false;
        bench.seconds_later(2.0);
        assert_eq!(bench.presence("belt"), if seen { Presence::On } else { Presence::Off });
        bench.answer("as-done");
        bench.seconds_later(15.0);
        let found = bench.steps().iter().any(|step| matches!(step, ExceptionStep::Mismatch { .. }));
        assert_eq!(found, differs, "{parts} {seen}: {:#?}", bench.steps());
        assert_eq!(bench.firing("fetch<A.new>").is_some_and(|of| of.id == fetched.id), differs, "{parts} {seen}");
    }
}
