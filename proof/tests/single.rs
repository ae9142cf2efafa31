//! What the argument for manual beside auto stands on (decision 0033), looked at in every station that there is: manual leads a
//! task-driven station from a place of one of its tasks to places of the same task, or to one where a task has ended, and from there
//! nowhere.
//!
//! Over nets, so over more than every controller does: whatever may fire in manual counts as firing, whatever else it waits for.

use std::collections::BTreeSet;

use linewright_coordinator_shell::heard;
use linewright_line::Line;
use linewright_line::net::{Block, ControlMode, MotionStage, StationNet, StationPlace};
use linewright_proof::generate::{self, LineShape};
use linewright_station_logic::StationReport;
use linewright_testkit::cells::{ASSEMBLY_LINE, C1_LINE};

fn lines() -> Vec<Line> {
    let parse = |text: &str| linewright_line::parse("line.toml", text).unwrap_or_else(|why| panic!("{why:#}")).line;
    let mut lines: Vec<Line> = [C1_LINE, ASSEMBLY_LINE].into_iter().map(parse).collect();
    let shape = LineShape { irreversible: 60, ..LineShape::default() };
    lines.extend((0..150).map(|seed| generate::task_driven(&shape, 1, seed)));
    lines
}

/// Places that manual leads to from one, over any number of transitions.
fn led_to(net: &StationNet, from: StationPlace) -> BTreeSet<(u16, u8)> {
    let key = |place: &StationPlace| (place.op.0, place.number());
    let (mut seen, mut next) = (BTreeSet::from([key(&from)]), vec![from]);
    while let Some(here) = next.pop() {
        let fires = |t: &&linewright_line::net::StationTransition| {
            t.from.contains(&here) && !t.terms(ControlMode::Manual).is_empty()
        };
        for to in net.transitions().iter().filter(fires).flat_map(|t| &t.to) {
            if seen.insert(key(to)) {
                next.push(*to);
            }
        }
    }
    seen
}

#[test]
fn manual_leads_within_one_task_and_out_of_no_end_of_one() {
    let (mut ends, mut places, mut begun_again) = (0, 0, 0);
    for line in lines() {
        for (id, station) in line.station_ids().map(|id| (id, line.station(id))).filter(|(_, of)| of.is_task_driven()) {
            let net = StationNet::of(&line, id);
            for &place in net.places() {
                let task = station.task_of(place.op).expect("each belongs to one");
                let led = led_to(&net, place);
                // Taken back to its beginning the token may go on to the place that stands for that rest. No motion does.
                let is_end = |op, number| number == 3 && station.rest_after(op).is_some();
                let outside = led.iter().find(|&&(op, number)| {
                    let op = linewright_line::OpId(op);
                    station.task_of(op) != Some(task) && !is_end(op, number)
                });
                assert_eq!(outside, None, "{}: {place:?} leads out of its task", station.name);
                places += 1;
                let last = station.rest_after(place.op).is_some();
                if last && place == StationPlace::completed(place.op) {
                    assert_eq!(led.len(), 1, "{}: manual moves it where {place:?}", station.name);
                    ends += 1;
                }
                // The other rest of a task is left by advance: that is why it is not enough to stand at a rest.
                let undone = (place.block, place.stage) == (Block::Recovery, MotionStage::Completed);
                begun_again += usize::from(undone && station.first_of(task) == place.op && led.len() > 1);
            }
        }
    }
    assert!(ends > 100 && places > 1000 && begun_again > 100, "{ends} {places} {begun_again}");
}

/// What the coordinator reads of a report is the place that this is about.
#[test]
fn a_report_names_the_task_unless_it_has_ended() {
    for line in lines() {
        for id in line.station_ids().filter(|&id| line.station(id).is_task_driven()) {
            let (station, net) = (line.station(id), StationNet::of(&line, id));
            for &place in net.places() {
                let mut places = vec![0; station.operations.len()];
                places[place.op.index()] = place.number();
                let has_ended = station.rest_after(place.op).is_some() && place == StationPlace::completed(place.op);
                let begins = place == StationPlace::undone(place.op)
                    && station.task_of(place.op).is_some_and(|task| station.first_of(task) == place.op);
                let report = StationReport { at_home: has_ended || begins, places, ..StationReport::default() };
                assert_eq!(heard(&report).stands_in, (!has_ended).then_some(place.op), "{} {place:?}", station.name);
            }
        }
    }
}
