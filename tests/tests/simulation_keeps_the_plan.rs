//! On random lines, with concurrent groups, arrows of one mode and lags: the controllers' behaviour in auto is the
//! plan, and the record of it is true.
//!
//! Without the time that messages take, every start and end is where the earliest schedule has it, but for the thousandth
//! by which a switch is early. The two have nothing in common: one is a longest path, the other whole controllers.

use std::time::Duration;

use linewright_line::net::Block;
use linewright_line::{Line, Tick};
use linewright_proof::generate::{LineShape, line};
use linewright_simulation::{CriticalPath, LastWait, LinePlan, LineSim, Network, RunEnd, RunGoal, SimOptions, run};

const CYCLES: usize = 40;

/// A line in auto whose messages take no time.
fn played(line: &Line) -> LineSim {
    let network = Network { delay: Duration::ZERO, ..Network::default() };
    let options = SimOptions { network, keeps_log: true, ..SimOptions::default() };
    let (sim, end) = run(line, options, &RunGoal::cycles(CYCLES)).expect("the line compiles");
    assert_eq!(end, RunEnd::Done, "{}: {}", line.title, sim.log().tail(line, 40));
    sim
}

fn starts_and_ends_where_planned(line: &Line, sim: &LineSim) {
    let (plan, began) = (LinePlan::of(line), sim.record().began().expect("it ran"));
    let schedule = plan.schedule(CYCLES + 2);
    for motion in sim.record().motions() {
        assert_eq!(motion.block, Block::Normal);
        let planned = plan.planned(&schedule, (motion.station, motion.op), motion.cycle).expect("within the schedule");
        let near = |at: Tick, planned: u64| {
            let at = at.since(began).as_micros() as u64;
            at <= planned + 1000 && planned <= at + at / 400 + 1000
        };
        assert!(near(motion.start, planned.start), "{}: {motion:?}, {planned:?}", line.title);
        assert!(motion.end == motion.start || near(motion.end, planned.end), "{}: {motion:?}, {planned:?}", line.title);
    }
}

#[test]
fn every_start_is_where_the_plan_has_it_and_has_its_cause() {
    for seed in 1..=400 {
        let line = line(&LineShape { stations: 2..=4, more_arrows: 4, ..LineShape::default() }, seed);
        let sim = played(&line);
        starts_and_ends_where_planned(&line, &sim);
        let began = sim.record().began();
        for motion in sim.record().motions() {
            assert!(motion.by != LastWait::Person || Some(motion.start) == began, "{}: {motion:?}", line.title);
            if let LastWait::Arrow(arrow) = motion.by {
                assert!(line.arrows[arrow].auto, "{}: {motion:?}", line.title);
            }
        }
        let path = CriticalPath::of(&line, sim.record()).unwrap_or_else(|| panic!("{}: no path", line.title));
        let planned = LinePlan::of(&line).cycle_time() / 1e6;
        let found = path.cycle_time_s();
        assert!((planned * 0.995..=planned * 1.001).contains(&found), "{}: {found} against {planned}", line.title);
    }
}
