//! The shape of the net: Propositions 1 and 2 of seed 002.

use linewright_line::net::{StationNet, StationPlace, TransitionKind, overlaps};
use linewright_line::{Line, OperationModule, StationId};
use linewright_nets::{explore, state_machine_verdict};
use proptest::prelude::*;

use super::generate::station_alone;
use linewright_testkit::built::{alone, beside, i, r, transfer_line};

/// More markings than any generated station has.
const MARKINGS_MAX: usize = 200_000;

fn has_groups(line: &Line, station: StationId) -> bool {
    line.station(station).steps.iter().any(|step| step.len() > 1)
}

fn check(line: &Line, station: StationId) {
    let described = line.station(station);
    let net = StationNet::of(line, station);
    let irreversible =
        described.operations.iter().filter(|op| matches!(op.module, OperationModule::Irreversible { .. })).count();
    let reversible = described.operations.len() - irreversible;
    assert_eq!(net.places().len(), 6 * reversible + 3 * irreversible, "6j + 3k places");
    assert_eq!(net.net().initial_marking().total(), 1, "one token");
    let home = net.place_index(StationPlace::completed(described.home)).expect("home is a place");
    assert_eq!(net.net().initial_marking().as_slice()[home], 1, "at home");
    assert_eq!(overlaps(&net), [], "output transitions of a place exclude each other");
    if has_groups(line, station) {
        let played = explore(net.net(), MARKINGS_MAX).expect("a station is small");
        assert!(played.is_live() && played.is_safe(), "{}", described.name);
        assert_eq!(played.is_reversible(), Ok(()));
    } else {
        assert_eq!(net.net().is_strongly_connected(), Ok(()));
        let verdict = state_machine_verdict(net.net()).expect("one token in, one token out");
        assert!(verdict.holds(), "{verdict}");
    }
}

#[test]
fn the_stations_of_the_transfer_line_are_live_safe_and_reversible() {
    let line = transfer_line();
    let places = line.station_ids().map(|s| StationNet::of(&line, s).places().len());
    assert_eq!(places.collect::<Vec<_>>(), [60, 12, 27]);
    for station in line.station_ids() {
        check(&line, station);
    }
}

#[test]
fn side_by_side_operations_fork_join_and_stay_live() {
    let line = alone(0, &[r(6), r(6), beside(6), beside(6), r(6)]);
    check(&line, StationId(0));
    let net = StationNet::of(&line, StationId(0));
    let widths: Vec<_> = net
        .transitions()
        .iter()
        .filter(|t| matches!(t.kind, TransitionKind::Next { .. }))
        .map(|t| (t.from.len(), t.to.len()))
        .collect();
    assert_eq!(widths, [(1, 3), (3, 1), (1, 1)]);
}

#[test]
fn irreversible_operations_share_the_hops_of_their_way_home() {
    let line = alone(5, &[r(1), r(1), i(1, &[1, 0]), i(1, &[0]), r(1), r(2)]);
    check(&line, StationId(0));
    let net = StationNet::of(&line, StationId(0));
    let hops: Vec<_> =
        net.transitions().iter().filter(|t| matches!(t.kind, TransitionKind::FollowPath { .. })).collect();
    assert_eq!(hops.len(), 2, "op 1 to op 0, and op 0 to home for both");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_well_formed_station_is_live_safe_and_reversible(line in station_alone()) {
        check(&line, StationId(0));
    }
}
