//! A line of five hundred stations in a row: judged by structure, which no exploration could do, and a mistake
//! anywhere in it is found.

use std::time::Instant;

use linewright_line::{Arrow, Line, OpId, StationId, TransferLine, parse};
use linewright_proof::explore::LineExploration;
use linewright_proof::generate::{self, Breakage, LineShape, break_it};
use linewright_proof::structure::{judge_line, judge_stations};

const STATIONS: usize = 500;

fn row() -> Line {
    generate::line(&LineShape::row(STATIONS), 1)
}

fn wrong(line: &Line) -> usize {
    judge_line(line).iter().filter(|check| !check.ok).count()
}

#[test]
fn five_hundred_stations_are_sound() {
    let line = row();
    let operations: usize = line.stations.iter().map(|station| station.operations.len()).sum();
    let began = Instant::now();
    let stations = judge_stations(&line);
    let after_stations = began.elapsed();
    let checks = judge_line(&line);
    let after_line = began.elapsed() - after_stations;
    println!(
        "{operations} operations, {} arrows, {} conflicts: the stations took {after_stations:?}, the line {after_line:?}",
        line.arrows.len(),
        line.conflicts.len()
    );
    assert!(line.conflicts.len() >= STATIONS - 1);
    for station in &stations {
        assert!(station.ok(), "{station:?}");
    }
    assert!(checks.iter().all(|check| check.ok));
}

#[test]
fn a_mistake_anywhere_in_five_hundred_stations_is_found() {
    let line = row();
    let is_of_pair = |nth: usize| {
        let arrow = &line.arrows[nth];
        let ends = |c: &linewright_line::Conflict| [(c.a, c.b), (c.b, c.a)];
        let joins = |(before, after): (linewright_line::StateSpan, linewright_line::StateSpan)| {
            arrow.from == (before.station, before.until) && arrow.to == (after.station, after.from)
        };
        line.conflicts.iter().flat_map(ends).any(joins)
    };
    let needed: Vec<usize> = (0..line.arrows.len()).filter(|&nth| is_of_pair(nth)).collect();
    let (mut found, mut harmless) = (0, 0);
    // Every so many arrows, the first and the last among them.
    for nth in (0..needed.len()).step_by(needed.len() / 12).chain([needed.len() - 1]) {
        for breakage in
            [Breakage::Removed(needed[nth]), Breakage::Reversed(needed[nth]), Breakage::LagMore(needed[nth])]
        {
            let broken = break_it(&line, breakage).expect("any arrow can be broken like this");
            if wrong(&broken) > 0 { found += 1 } else { harmless += 1 }
        }
    }
    println!("{found} mistakes found, {harmless} that another arrow makes up for");
    assert!(found >= 9 * harmless && found > 30);
}

#[test]
fn a_row_needs_one_report_for_each_link_and_a_ring_may_need_more() {
    let mut line = parse("line.toml", &TransferLine::default().text()).expect("the shipped line is sound").line;
    assert!(LineExploration::new(&line).covers_every_delay());
    let end = |station| (StationId(station), OpId(0));
    line.arrows.push(Arrow { from: end(2), to: end(0), lag: 1, auto: true, manual: true });
    assert!(!LineExploration::new(&line).covers_every_delay());
}
