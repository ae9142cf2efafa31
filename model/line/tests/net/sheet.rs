//! The drawing of a station's net: every node and arc is there, no two nodes touch, and no arc passes through a node that is not
//! its own.

use linewright_line::net::{NODE_RADIUS, NetSheet, SheetPoint, StationNet};
use linewright_line::{Line, StationId, parse};
use linewright_nets::{Net, NetBuilder};
use proptest::prelude::*;

use super::generate::station_alone;
use linewright_testkit::built::{alone, beside, r, transfer_line};

fn distance(a: SheetPoint, b: SheetPoint) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

fn from_segment(at: SheetPoint, (a, b): (SheetPoint, SheetPoint)) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let long = dx * dx + dy * dy;
    let along = if long == 0.0 { 0.0 } else { (((at.x - a.x) * dx + (at.y - a.y) * dy) / long).clamp(0.0, 1.0) };
    distance(at, SheetPoint { x: a.x + along * dx, y: a.y + along * dy })
}

fn check(line: &Line, station: StationId) {
    let net = StationNet::of(line, station);
    check_sheet(net.net(), &NetSheet::of(line, station, &net));
}

fn check_sheet(net: &Net, sheet: &NetSheet) {
    assert_eq!((sheet.places.len(), sheet.transitions.len()), (net.place_count(), net.transition_count()));
    let nodes: Vec<SheetPoint> = sheet.places.iter().chain(&sheet.transitions).copied().collect();
    for (number, &at) in nodes.iter().enumerate() {
        let is_within = |at: f64, size: f64| at >= 2.0 * NODE_RADIUS && at <= size - 2.0 * NODE_RADIUS;
        assert!(is_within(at.x, sheet.size.x) && is_within(at.y, sheet.size.y), "{at:?} in {:?}", sheet.size);
        for &other in &nodes[..number] {
            assert!(distance(at, other) > 2.0 * NODE_RADIUS, "{at:?} {other:?} of {}", net.name());
        }
    }
    for arc in &sheet.arcs {
        let own = [arc.place, sheet.places.len() + arc.transition];
        let points: Vec<SheetPoint> =
            [nodes[own[0]]].into_iter().chain(arc.bends.iter().copied()).chain([nodes[own[1]]]).collect();
        for (number, &at) in nodes.iter().enumerate().filter(|(number, _)| !own.contains(number)) {
            let near = points.windows(2).map(|ends| from_segment(at, (ends[0], ends[1]))).fold(f64::MAX, f64::min);
            let name = |index: usize| match index.checked_sub(sheet.places.len()) {
                None => net.place_name(net.places().nth(index).expect("a place")).to_owned(),
                Some(t) => net.transition_name(net.transitions().nth(t).expect("a transition")).to_owned(),
            };
            assert!(
                near > NODE_RADIUS,
                "the arc {} - {} at {points:?} passes {} at {at:?}",
                name(own[0]),
                name(own[1]),
                name(number)
            );
        }
    }
    let mut drawn: Vec<_> = sheet.arcs.iter().map(|arc| (arc.transition, arc.place, arc.is_output)).collect();
    drawn.sort_unstable();
    let places = |of: &[(linewright_nets::PlaceId, u32)]| of.iter().map(|&(p, _)| p.index()).collect::<Vec<_>>();
    let mut expected = Vec::new();
    for t in net.transitions() {
        expected.extend(places(net.preset(t)).into_iter().map(|p| (t.index(), p, false)));
        expected.extend(places(net.postset(t)).into_iter().map(|p| (t.index(), p, true)));
    }
    expected.sort_unstable();
    assert_eq!(drawn, expected);
}

#[test]
fn of_the_shipped_stations() {
    let cell = |text| parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let lines = [
        transfer_line(),
        cell(include_str!("../../../../launch-config/lines/workcell-c1/line.toml")),
        cell(include_str!("../../../../launch-config/lines/assembly-cell/line.toml")),
    ];
    for line in &lines {
        line.station_ids().for_each(|id| check(line, id));
    }
}

/// Every place from every other one.
#[test]
fn of_a_ring() {
    for count in 2..=6 {
        let mut builder = NetBuilder::new("ring");
        let places: Vec<_> = (0..count).map(|number| builder.place(format!("p{number}"), 0)).collect();
        for (from, &before) in places.iter().enumerate() {
            for (to, &after) in places.iter().enumerate().filter(|&(to, _)| to != from) {
                let transition = builder.transition(format!("{from} -> {to}"));
                builder.input(transition, before, 1);
                builder.output(transition, after, 1);
            }
        }
        let net = builder.build().expect("a net");
        check_sheet(&net, &NetSheet::ring(&net).expect("one place before and one after each transition"));
    }
    let forks = alone(3, &[r(6), r(6), beside(6), r(6)]);
    let joins = StationNet::of(&forks, StationId(0));
    assert_eq!(NetSheet::ring(joins.net()).map(|sheet| sheet.places.len()), None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn of_any_station(line in station_alone()) {
        check(&line, StationId(0));
    }
}
