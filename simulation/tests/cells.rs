//! The shipped cells with the real controllers of their stations and the plant behind them. The truth is counted in the
//! plant's parts, which neither the coordinator nor any station sees: none is lost, none is made twice, each is where it is
//! by the records, and each has had the work of its plan.

mod alarm;
mod emergency;
mod expiry;
mod queues;
mod scenarios;
mod single;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_cell::{Cell, Role};
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell, dispatcher};
use linewright_coordinator_cell::exception::ExceptionStep;
use linewright_coordinator_cell::{CellTable, FiringId, ModeId, PartId, PlayerInput, RecordKind};
use linewright_line::{HolderId, Line, StationId, Tick};
use linewright_plant::{MotionFault, PlantOptions};
use linewright_simulation::Rng;
use linewright_simulation::cell::{CellSim, CellSimOptions, ShopFloor, nests};

const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
const LONG: Tick = Tick::from_millis(24 * 3_600_000);

/// A cell, its line, and a production of so many parts of each type.
struct Shipped {
    cell: Cell,
    line: Line,
    table: Arc<CellTable>,
    parts: u32,
}

/// The robot of C1 misses what it grasps for M1 or M2, or does not any more.
fn grasps(of: &Shipped, sim: &mut CellSim, fault: Option<MotionFault>) {
    let robot = of.line.station_named("robot").expect("there");
    let now = sim.now;
    let plant = sim.floor.as_mut().expect("real stations").plant_mut();
    for machine in ["m1", "m2"] {
        let grasp = of.line.station(robot).operation_named(&format!("grasp for {machine}"));
        plant.inject(now, robot, grasp.expect("it does that"), fault);
    }
}

fn shipped(name: &str, parts: &[u32]) -> Shipped {
    shipped_but(name, parts, |text| text)
}

/// The same, described otherwise.
fn shipped_but(name: &str, parts: &[u32], change: impl Fn(String) -> String) -> Shipped {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines").join(name);
    let text = |file: &str| std::fs::read_to_string(dir.join(file)).expect("it is there");
    let line = linewright_line::parse("line.toml", &text("line.toml")).unwrap_or_else(|why| panic!("{why:#}")).line;
    let cell = linewright_cell::parse("cell.toml", &change(text("cell.toml")), Some(&line));
    let cell = cell.unwrap_or_else(|why| panic!("{why:#}")).cell;
    let made = compile_cell(&cell, Some(&line), Supply::Batch(parts), PACE).unwrap_or_else(|why| panic!("{why}"));
    Shipped { table: Arc::new(made.table), cell, line, parts: parts.iter().sum() }
}

impl Shipped {
    fn nests(&self) -> Vec<(&str, HolderId)> {
        nests(&self.cell, &self.line)
    }

    fn sim(&self, options: CellSimOptions, variation: f64) -> CellSim {
        let plant = PlantOptions { seed: options.seed, variation, people: false };
        let mut floor = ShopFloor::new(&self.line, &self.table, &self.nests(), plant).expect("the stations compile");
        for (station, operation) in
            [("m1", "cut"), ("m2", "cut"), ("m3", "cut"), ("robot_2", "assemble"), ("human", "work on the part")]
        {
            let Some(id) = self.line.station_named(station) else { continue };
            let op = self.line.station(id).operation_named(operation).expect("it does that");
            let (_, nest) = self
                .nests()
                .into_iter()
                .find(|(_, nest)| self.line.handling.holder(*nest).name.starts_with(&format!("{station}.")))
                .expect("it has a nest");
            floor.watch(id, op, nest);
        }
        let mut sim = CellSim::new(self.table.clone(), self.line.stations.len(), options);
        sim.floor = Some(floor);
        sim
    }

    fn play(&self, options: CellSimOptions) -> CellSim {
        let mut sim = self.sim(options, 0.1);
        sim.run(&mut dispatcher(&self.cell, &self.table), LONG);
        self.is_done(&sim);
        sim
    }

    /// All parts have left, each once, and nothing that should not have happened has.
    fn is_done(&self, sim: &CellSim) {
        let floor = sim.floor.as_ref().expect("real stations");
        let firing = sim.state().firings().next();
        if firing.is_some() {
            for id in self.line.station_ids() {
                let controller = floor.controller(id);
                let (doing, waits) =
                    (controller.operation_text(&self.line), controller.blocked_by(&self.line, sim.now));
                println!("{}: {doing}, waits for {waits:?}", self.line.station(id).name);
            }
            println!("{:?}", floor.plant().parts().collect::<Vec<_>>());
        }
        assert_eq!((&sim.events[..], firing), (&[][..], None), "at {}", sim.now);
        assert_eq!((&floor.trouble[..], floor.plant().mishaps().1), (&[][..], 0));
        assert_eq!(sim.state().left(), u64::from(self.parts));
        let mut left = floor.left.clone();
        left.sort_unstable();
        left.dedup();
        assert_eq!((left.len(), floor.left.len()), (self.parts as usize, self.parts as usize), "each has left once");
        assert_eq!(floor.plant().parts().count(), 0, "none is left over");
        assert_eq!(floor.plant().alarms(), 0);
    }

    /// Work really done on each part: station and program, in order; sorted over all parts.
    fn works(&self, sim: &CellSim) -> Vec<Vec<(&str, Vec<i32>)>> {
        let mut of_part: BTreeMap<PartId, Vec<(&str, Vec<i32>)>> = BTreeMap::new();
        for work in &sim.floor.as_ref().expect("real stations").done {
            let part = work.part.unwrap_or_else(|| panic!("{work:?} on nothing"));
            let station = self.line.station(work.station).name.as_str();
            of_part.entry(part).or_default().push((station, work.numbers.clone()));
        }
        let mut all: Vec<_> = of_part.into_values().collect();
        all.sort();
        all
    }
}

fn options(seed: u64, bad_luck: u64, crash_at: Vec<usize>) -> CellSimOptions {
    let millis = Duration::from_millis;
    CellSimOptions {
        seed,
        bad_luck,
        crash_at,
        delay: (millis(1), millis(20)),
        period: millis(100),
        ..CellSimOptions::default()
    }
}

/// Seed 000, L1455-1485: robot 2 works on parts 1, the human on parts 2 and 3; each part once.
fn is_assembled(of: &Shipped, sim: &CellSim, counts: [usize; 2]) {
    let expected = [vec![("human", vec![])]].into_iter().cycle().take(counts[1]);
    let expected: Vec<_> = expected.chain([vec![("robot_2", vec![])]].into_iter().cycle().take(counts[0])).collect();
    assert_eq!(of.works(sim), expected);
}

/// C1's plans: A is turned on M1 or M2 with program 1, then ground on M3 with 2; B is ground with 3, then drilled on M2 with 4.
fn is_machined(of: &Shipped, sim: &CellSim, counts: [usize; 2]) {
    let mut seen = [0, 0];
    for work in of.works(sim) {
        let work: Vec<(&str, &[i32])> = work.iter().map(|(station, numbers)| (*station, &numbers[..])).collect();
        match work[..] {
            [("m1" | "m2", [1]), ("m3", [2])] => seen[0] += 1,
            [("m3", [3]), ("m2", [4])] => seen[1] += 1,
            _ => panic!("no plan says {work:?}"),
        }
    }
    assert_eq!(seen, counts);
}

#[test]
fn the_assembly_cell_makes_its_parts_with_real_stations() {
    let of = shipped("assembly-cell", &[2, 2, 1]);
    let sim = of.play(options(1, 0, Vec::new()));
    is_assembled(&of, &sim, [2, 3]);
    for seed in 2..6 {
        is_assembled(&of, &of.play(options(seed, 8, Vec::new())), [2, 3]);
    }
}

#[test]
fn workcell_c1_makes_its_parts_with_real_stations() {
    let of = shipped("workcell-c1", &[3, 3]);
    is_machined(&of, &of.play(options(1, 0, Vec::new())), [3, 3]);
    for seed in 2..4 {
        is_machined(&of, &of.play(options(seed, 8, Vec::new())), [3, 3]);
    }
}

/// A5: seed 000, L2736: t2(m₂∧p₂) ∥ t4(m₁∧p₁), the human is loaded while robot 2 works.
#[test]
fn loading_and_working_are_concurrent_with_real_stations() {
    let of = shipped("assembly-cell", &[1, 2, 0]);
    let mut sim = of.sim(options(1, 0, Vec::new()), 0.0);
    let mut dispatcher = dispatcher(&of.cell, &of.table);
    let [robot_1, robot_2] = ["robot_1", "robot_2"].map(|name| of.line.station_named(name).expect("there"));
    let mut together = false;
    let doing = |sim: &CellSim, station: StationId| -> Option<String> {
        let report = sim.floor.as_ref()?.controller(station).report().order?;
        Some(of.line.station(station).task(report.slot?.task).name.clone())
    };
    for step in 1..6_000 {
        sim.run(&mut dispatcher, Tick::from_millis(step * 10));
        together |=
            doing(&sim, robot_1).as_deref() == Some("load human") && doing(&sim, robot_2).as_deref() == Some("work");
        let differences = sim.floor.as_ref().map(|floor| floor.differences(sim.state())).unwrap_or_default();
        assert_eq!(differences, [""; 0], "at {}", sim.now);
    }
    assert!(together, "both controllers had their orders at once");
    of.is_done(&sim);
    let mut open: BTreeMap<FiringId, &str> = BTreeMap::new();
    let mut pairs = Vec::new();
    for record in &sim.log {
        match &record.fact {
            RecordKind::Started { firing, mode, .. } => {
                open.insert(*firing, &of.table.activity(*mode).name);
                pairs.push(open.values().copied().collect::<Vec<_>>());
            }
            RecordKind::Ended { firing } => _ = open.remove(firing),
            _ => {}
        }
    }
    assert!(pairs.iter().any(|now| now.contains(&"load human") && now.contains(&"robot_2.process")), "{pairs:?}");
}

/// The same production, whichever record or message of its coordinator is its last.
#[test]
fn the_assembly_cell_makes_the_same_whichever_step_its_coordinator_is_killed_at() {
    let of = shipped("assembly-cell", &[1, 1, 1]);
    let calm = of.play(options(3, 0, Vec::new()));
    is_assembled(&of, &calm, [1, 2]);
    assert!(calm.steps > 60, "{}", calm.steps);
    for at in 0..calm.steps {
        let sim = of.play(options(3, 0, vec![at]));
        assert_eq!(sim.lives, 2, "at {at}");
        is_assembled(&of, &sim, [1, 2]);
    }
}

#[test]
fn a_coordinator_that_is_killed_again_and_again_loses_no_part() {
    let mut rng = Rng::new(8);
    for (name, parts) in [("assembly-cell", &[2, 2, 1][..]), ("workcell-c1", &[2, 2])] {
        let of = shipped(name, parts);
        for seed in 0..4 {
            let mut at = 0;
            let crash_at = (0..8).map(|_| {
                at += 1 + rng.below(30) as usize;
                at
            });
            let sim = of.play(options(seed, 8, crash_at.collect()));
            assert!(sim.lives > 4, "{}", sim.lives);
        }
    }
}

/// A station's process is killed while it rests, and starts from its journal, which has every order it has had.
#[test]
fn stations_that_are_killed_and_restarted_do_nothing_twice() {
    for (name, parts) in [("assembly-cell", &[2, 2, 1][..]), ("workcell-c1", &[2, 1])] {
        let of = shipped(name, parts);
        let mut rng = Rng::new(3);
        let mut killed = 0;
        for seed in 0..3 {
            let mut sim = of.sim(options(seed, 8, Vec::new()), 0.1);
            let mut dispatcher = dispatcher(&of.cell, &of.table);
            let mut now = Tick::ZERO;
            while sim.state().left() < u64::from(of.parts) {
                now = now + Duration::from_millis(rng.within(100, 1500));
                assert!(now < LONG, "{:?}", sim.state().firings().collect::<Vec<_>>());
                sim.run(&mut dispatcher, now);
                let floor = sim.floor.as_mut().expect("real stations");
                let at = StationId::at(rng.below(of.line.stations.len() as u64) as usize);
                let order = floor.controller(at).report().order.expect("it is task-driven");
                if order.slot.is_none() && order.rest.is_some() {
                    floor.kill(at);
                    killed += 1;
                    now = now + Duration::from_millis(rng.within(10, 400));
                    sim.run(&mut dispatcher, now);
                    sim.floor.as_mut().expect("real stations").restart(at).expect("it compiles");
                }
            }
            sim.run(&mut dispatcher, LONG);
            of.is_done(&sim);
        }
        assert!(killed > 20, "{killed}");
    }
}

/// Agreement of the descriptions of a cell and of its line.
#[test]
fn every_resource_that_works_has_a_nest_in_the_line() {
    for name in ["assembly-cell", "workcell-c1"] {
        let of = shipped(name, &[1, 1, 1][..if name == "workcell-c1" { 2 } else { 3 }]);
        let nests = of.nests();
        for activity in &of.cell.activities {
            let worker = activity.used(Role::Worker).and_then(|part| part.of).map(|id| of.cell.resource(id));
            let known = worker.is_none_or(|worker| nests.iter().any(|(name, _)| *name == worker.name));
            assert!(known, "{name}: {}", activity.name);
        }
    }
}

/// Seed 001, §6 (L227-229): the robot has no part, both stations are led to a secure state, an alarm is raised, the operator puts
/// the part right and answers it, the marking from before is restored, and the loading is done again. The sensor in the hand
/// shows it at once: the robot has not been at the machine.
#[test]
fn the_story_of_a_part_that_was_not_grasped_with_real_stations() {
    let of = shipped("workcell-c1", &[1, 0]);
    let mut sim = of.sim(options(1, 0, Vec::new()), 0.0);
    let mut dispatcher = dispatcher(&of.cell, &of.table);
    let robot = of.line.station_named("robot").expect("there");
    grasps(&of, &mut sim, Some(MotionFault::Miss));

    // It has come to rest when it has gone back from the store, and what was loaded is where it was.
    sim.run(&mut dispatcher, LONG);
    let started = sim.log.iter().find_map(|record| match &record.fact {
        RecordKind::Started { mode, .. } if of.table.mode_name(*mode).starts_with("load ") => Some((record.at, *mode)),
        _ => None,
    });
    let (started, mode) = started.expect("a loading has started");
    let (alarm, text, since) = {
        let alarm = sim.state().exceptions().alarms().next().expect("somebody is told");
        (alarm.id, alarm.text.clone(), alarm.since)
    };
    let machine = of.table.handling().resource_name(of.table.handling().mode(mode).to.expect("a machine")).to_owned();
    let expected = "R grasped no part at slot 1 of ST. Put part 1 into that slot; if it lies there, look at the sensor in the hand. (";
    assert!(text.starts_with(expected), "{text}");
    assert!(text.contains(": robot: awaited input not on in time (code 24): part_in_hand at `grasp for m"), "{text}");
    let station = machine.to_lowercase();
    assert!(!text.contains("at rest"), "nothing is to be led: {text}");
    let waited = since.since(started);
    assert!((Duration::from_secs(4)..Duration::from_secs(10)).contains(&waited), "{waited:?}");
    for station in [robot, of.line.station_named(&station).expect("there")] {
        let order = sim.floor.as_ref().expect("real").controller(station).report().order.expect("it is task-driven");
        assert_eq!((order.slot, order.rest.is_some()), (None, true), "secured");
    }
    let lies = |sim: &CellSim| {
        let (_, whereabouts) = sim.floor.as_ref().expect("real").plant().parts().next().expect("it is there");
        format!("{whereabouts:?}")
    };
    let in_store = lies(&sim);
    assert!(sim.state().firings().next().is_some(), "the loading is open");

    // The gripper works again; the part has not left its slot. That is answered, and accepted.
    grasps(&of, &mut sim, None);
    let word = "in-store";
    sim.say(&mut dispatcher, &[PlayerInput::Answer { alarm, word }]);
    assert_eq!(lies(&sim), in_store);
    sim.run(&mut dispatcher, LONG);
    of.is_done(&sim);
    is_machined(&of, &sim, [1, 0]);
    let story: Vec<&str> = sim.log.iter().filter_map(|record| told(&record.fact, mode)).collect();
    assert_eq!(
        story,
        ["started", "raised", "secured", "secured", "alarmed", "answered", "restored", "started"],
        "and then it is loaded again"
    );
}

/// As the source tells it: the robot comes to the machine without the part, so that the clamp is never closed, and the watchdog
/// fires. The sensor in the hand has seen the part before it fell.
#[test]
fn a_part_that_falls_on_its_way_is_missed_at_the_machine() {
    let of = shipped("workcell-c1", &[1, 0]);
    let mut sim = of.sim(options(1, 0, Vec::new()), 0.0);
    let mut dispatcher = dispatcher(&of.cell, &of.table);
    grasps(&of, &mut sim, Some(MotionFault::Drop));
    sim.run(&mut dispatcher, LONG);
    let alarm = sim.state().exceptions().alarms().next().expect("somebody is told");
    assert!(alarm.text.starts_with("R came to M") && alarm.text.contains(" without part 1. "), "{}", alarm.text);
    assert!(alarm.since >= Tick::from_millis(24_000), "{:?}", alarm.since);
}

/// In the assembly cell the hand is looked into where it has come to: nobody waits for a part that does not come.
#[test]
fn a_part_that_falls_on_its_way_is_missed_when_the_arm_is_there() {
    for (parts, way, grasp) in
        [([1, 0, 0], "robot_2", "grasp for robot 2"), ([0, 1, 0], "human", "grasp for the human")]
    {
        let of = shipped("assembly-cell", &parts);
        let mut sim = of.sim(options(1, 0, Vec::new()), 0.0);
        let mut dispatcher = dispatcher(&of.cell, &of.table);
        let robot = of.line.station_named("robot_1").expect("there");
        let grasp = of.line.station(robot).operation_named(grasp);
        let now = sim.now;
        let plant = sim.floor.as_mut().expect("real stations").plant_mut();
        plant.inject(now, robot, grasp.expect("it does that"), Some(MotionFault::Drop));
        sim.run(&mut dispatcher, LONG);
        let alarm = sim.state().exceptions().alarms().next().expect("somebody is told");
        let text = &alarm.text;
        assert!(text.starts_with(&format!("robot_1 has lost part 1 on its way from input to {way}. ")), "{text}");
        assert!(text.contains("(code 25): part_in_hand at `carry to "), "{text}");
        // It has waited 0.5 s at the end of its way, and gone back.
        assert!(alarm.since < Tick::from_millis(5000), "{:?}", alarm.since);
        assert!(!alarm.words.is_empty() && alarm.words[0] == "again", "{:?}", alarm.words);
    }
}

/// Kind of a record of exceptions or of the starts of one mode.
fn told(fact: &RecordKind, mode: ModeId) -> Option<&'static str> {
    Some(match fact {
        RecordKind::Started { mode: of, .. } if *of == mode => "started",
        RecordKind::Raised { .. } => "raised",
        RecordKind::Exception(ExceptionStep::Secured { .. }) => "secured",
        RecordKind::Exception(ExceptionStep::Alarmed { .. }) => "alarmed",
        RecordKind::Exception(ExceptionStep::Answered { .. }) => "answered",
        RecordKind::Exception(ExceptionStep::Closed { .. }) => "restored",
        RecordKind::Exception(_) => "something else",
        _ => return None,
    })
}

/// Two stores, and bringing parts from one to the other and back takes no time: all that happens happens at one moment.
#[test]
fn what_takes_no_time_and_goes_round_is_found_out() {
    let text = r#"
name = "round"
[cell]
wip_max = 2
reserve = true
[dispatch]
rules = ["shortest-processing-time"]
[[resource]]
name = "S1"
prototype = "random-access-store"
capacity = 2
[[resource]]
name = "S2"
prototype = "random-access-store"
capacity = 2
[[resource]]
name = "M"
prototype = "machine"
capacity = 1
[[resource]]
name = "R"
prototype = "robot"
[[sync]]
name = "enter"
actions = ["outside.in", "S1.store"]
[[sync]]
name = "there"
actions = ["S1.retrieve", "S2.store"]
[[sync]]
name = "back"
actions = ["S2.retrieve", "S1.store"]
[[sync]]
name = "load"
actions = ["S2.retrieve", "R.pick-and-place", "M.load"]
time_s = 5
[[sync]]
name = "leave"
actions = ["M.unload", "outside.out"]
[[part]]
name = "A"
step = [{ name = "work", on = [{ resource = "M", time_s = 5 }] }]
"#;
    let cell = linewright_cell::parse("cell.toml", text, None).unwrap_or_else(|why| panic!("{why:#}")).cell;
    let made = compile_cell(&cell, None, Supply::Batch(&[4]), PACE).unwrap_or_else(|why| panic!("{why}"));
    let table = Arc::new(made.table);
    let mut sim = CellSim::new(table.clone(), 0, CellSimOptions::default());
    sim.run(&mut dispatcher(&cell, &table), LONG);
    let spins = sim.spins().map(|mode| table.mode_name(mode).to_owned());
    assert!(spins.as_deref().is_some_and(|name| name.starts_with("there") || name.starts_with("back")), "{spins:?}");
    assert!(sim.state().left() < 4 && sim.log.len() < 200_000, "{}", sim.log.len());

    // With a time it goes on, if not wisely.
    let timed = text
        .replace("actions = [\"S2.retrieve\", \"S1.store\"]", "actions = [\"S2.retrieve\", \"S1.store\"]\ntime_s = 1");
    let cell = linewright_cell::parse("cell.toml", &timed, None).unwrap_or_else(|why| panic!("{why:#}")).cell;
    let made = compile_cell(&cell, None, Supply::Batch(&[4]), PACE).unwrap_or_else(|why| panic!("{why}"));
    let table = Arc::new(made.table);
    let mut sim = CellSim::new(table.clone(), 0, CellSimOptions::default());
    sim.run(&mut dispatcher(&cell, &table), Tick::from_millis(600_000));
    assert_eq!((sim.spins(), sim.now > Tick::from_millis(30_000)), (None, true));
}
