//! Orders for stations that a person has led to another rest than their tasks begin at.

use linewright_coordinator_cell::dispatch::{Reasons, ShortestRoutes, why_not};
use linewright_coordinator_cell::exception::AlarmSubject;
use linewright_coordinator_cell::{PartId, StationUnavailable};
use linewright_line::RestId;

use super::bench::CellBench;

const OPEN: RestId = RestId(0);
const CLAMPED: RestId = RestId(1);
const LOAD: &str = "load M1<A.new>";

/// Why the first part does not go on.
fn why(bench: &CellBench) -> String {
    let ways = ShortestRoutes::new(&bench.table);
    why_not(&ways, &Reasons::default(), &bench.sim.coordination, bench.sim.now, PartId(1)).join("\n")
}

/// A person has led a station to another rest in hand mode, and auto is given: its order would be refused each time. Nothing is
/// ordered, and the alarm names both rests and the way.
#[test]
fn nothing_is_ordered_of_a_station_that_stands_at_another_rest() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    bench.at("m1").unable = Some(StationUnavailable::ByHand);
    bench.at("m2").unable = Some(StationUnavailable::ByHand);
    bench.hear();
    let m1 = bench.resource("M1");
    // The part is let in, and waits.
    bench.at("m1").rest = Some(CLAMPED);
    bench.at("m1").unable = None;
    bench.hear();
    let alarm = bench.alarm().clone();
    assert_eq!(alarm.about, AlarmSubject::Resource(m1));
    let text = "m1 stands at rest \"clamped\", but M1 has no part, and load M1 begins at \"open\": M1 is not used.";
    assert!(alarm.text.starts_with(text) && alarm.text.contains("in hand mode hold PB_clear_1"), "{}", alarm.text);
    assert!(bench.firing(LOAD).is_none());
    let why = why(&bench);
    assert!(why.contains("M1 out of service"), "{why}");
    // Brought back, it is counted on again, and loaded.
    bench.at("m1").rest = Some(OPEN);
    bench.hear();
    bench.answer("up");
    bench.until_that(|bench| bench.firing(LOAD).is_some());
}

/// A carrier is not left out for where it stands. It is ordered, as its refusal raises an alarm; nothing would report an order that waits.
#[test]
fn a_carrier_that_stands_at_another_rest_is_ordered() {
    let mut bench = CellBench::c1_of_its_line(&[1, 0]);
    // One that the description does not have is another one as well.
    bench.at("robot").rest = Some(RestId(1));
    bench.hear();
    assert!(bench.state().firings().any(|firing| !firing.orders.is_empty()));
}
