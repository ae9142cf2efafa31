//! Random task-driven stations: well formed, sound as seed 002 requires of every station, and never stuck, whatever
//! they are ordered to do or to leave, and whatever fails meanwhile.

use linewright_line::net::{StationNet, StationPlace, TransitionKind};
use linewright_line::{Line, parse};
use linewright_nets::explore;
use linewright_proof::explore::{LineExploration, Verdict};
use linewright_proof::generate::{self, LineShape};
use linewright_proof::structure::judge_stations;

use crate::common::{DEADLOCK, HOME, REVERSIBLE, SOUND, explored, undisturbed, verdict};

fn lines() -> impl Iterator<Item = Line> {
    (0..150).map(|seed| generate::task_driven(&LineShape { irreversible: 60, ..LineShape::default() }, 1, seed))
}

#[test]
fn generated_ones_read_back_the_same() {
    let (mut irreversible, mut several_rests, mut parameters, mut waits) = (0, 0, 0, 0);
    for line in lines() {
        let text = generate::text(&line);
        let parsed = parse("generated.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}\n{text}"));
        // The only warning is the missing console.
        let said: Vec<&str> = parsed.warnings.iter().map(|warning| warning.message.as_str()).collect();
        assert!(said.iter().all(|message| message.contains("console")), "{said:?}");
        assert_eq!(parsed.line, line);
        let station = &line.stations[0];
        let is_irreversible =
            |op: &linewright_line::Operation| !matches!(op.module, linewright_line::OperationModule::Reversible { .. });
        irreversible += usize::from(station.operations.iter().any(is_irreversible));
        several_rests += usize::from(station.rests.len() > 1);
        parameters += usize::from(station.tasks.iter().any(|task| !task.parameters.is_empty()));
        waits += usize::from(station.operations.iter().any(|op| !op.waits.is_empty()));
    }
    let seen = [irreversible, several_rests, parameters, waits];
    assert!(seen.iter().all(|&lines| lines > 20), "the generator has become one-sided: {seen:?}");
}

#[test]
fn their_nets_are_live_safe_reversible_state_machines_of_6j_and_3k_places() {
    for line in lines() {
        for report in judge_stations(&line) {
            let wrong: Vec<_> = report.checks.iter().filter(|check| !check.ok).collect();
            assert!(wrong.is_empty(), "{}: {wrong:?}\n{}", line.title, generate::text(&line));
        }
    }
}

/// The same from the token game, and what a rest is: from the place that stands for it, each of its tasks begins.
#[test]
fn playing_them_out_agrees_and_every_rest_leads_to_its_tasks() {
    for line in lines() {
        let (station, net) = (&line.stations[0], StationNet::of(&line, linewright_line::StationId(0)));
        let played = explore(net.net(), 10_000).expect("a station is small");
        assert!(played.is_live() && played.is_safe() && played.is_reversible().is_ok(), "{}", line.title);
        for (nth, task) in station.tasks.iter().enumerate() {
            let last = StationPlace::completed(station.steps[task.steps.end - 1][0]);
            let leads: Vec<_> = net
                .transitions()
                .iter()
                .filter(|t| t.from == [last] && matches!(t.kind, TransitionKind::Next { .. }))
                .map(|t| t.to[0])
                .collect();
            let begins = station.tasks.iter().filter(|next| next.from == task.to);
            let begins: Vec<_> =
                begins.map(|next| StationPlace::operating(station.steps[next.steps.start][0])).collect();
            assert_eq!(leads, begins, "{} task {nth}", line.title);
        }
    }
}

const BASE: &str = include_str!("../../model/line/tests/descriptions/task_driven.toml");

/// The stations of the base description, each by itself: nothing joins them.
fn base() -> Vec<Line> {
    let line = parse("task_driven.toml", BASE).expect("the base is sound").line;
    line.stations.iter().map(|station| Line { stations: vec![station.clone()], ..line.clone() }).collect()
}

#[test]
fn whatever_is_ordered_left_and_fails_no_station_gets_stuck() {
    let generated =
        (0..12).map(|seed| generate::task_driven(&LineShape { irreversible: 60, ..LineShape::default() }, 1, seed));
    for line in base().into_iter().chain(generated) {
        let found = explored(&LineExploration::new(&line), 2_000_000);
        assert!(found.exhausted, "{}", line.title);
        for name in [SOUND, DEADLOCK, HOME, REVERSIBLE, "every transition fires"] {
            let property =
                found.properties.iter().find(|property| property.name.starts_with(name)).expect("it is asked");
            let story = property.counterexample.as_ref().map(ToString::to_string).unwrap_or_default();
            let is_fine = match property.verdict {
                Verdict::Holds => true,
                // Hand types may leave a way without a button.
                Verdict::Remark => line.title.starts_with("Generated"),
                Verdict::Fails | Verdict::Undecided => false,
            };
            assert!(
                is_fine,
                "{}: {}: {}\n{story}\n{}",
                line.title,
                property.name,
                property.reason,
                generate::text(&line)
            );
        }
    }
}

/// Without intervention or failure: from wherever an order was left the station comes back to a rest by itself, except
/// past irreversible operations.
#[test]
fn in_auto_alone_every_order_that_is_left_leads_back_to_a_rest_unless_something_is_irreversible() {
    for (irreversible, expected) in [(0, Verdict::Holds), (100, Verdict::Fails)] {
        let mut seen = 0;
        for seed in 0..60 {
            let line = generate::task_driven(&LineShape { irreversible, ..LineShape::default() }, 1, seed);
            let ops = &line.stations[0].operations;
            let all_reversible =
                ops.iter().all(|op| matches!(op.module, linewright_line::OperationModule::Reversible { .. }));
            if all_reversible != (irreversible == 0) {
                continue;
            }
            seen += 1;
            let found = explored(&undisturbed(&line), 200_000);
            assert_eq!(verdict(&found, HOME), expected, "{}", generate::text(&line));
        }
        assert!(seen >= 5, "{seen} of them");
    }
}

#[test]
fn two_task_driven_stations_are_explored_together_as_each_by_itself() {
    let line = parse("task_driven.toml", BASE).expect("the base is sound").line;
    let found = explored(&LineExploration::new(&line), 2_000_000);
    assert!(found.exhausted && found.holds(), "{:?}", found.properties);
    let alone: Vec<usize> =
        base().iter().map(|line| explored(&LineExploration::new(line), 2_000_000).situations[0]).collect();
    assert_eq!(found.situations, alone);
}
