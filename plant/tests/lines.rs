//! The lines this project ships, moved through their cycles by hand: what the description promises, the plant does.

use std::time::Duration;

use linewright_line::{Line, MotionSignals, OpId, OperationModule, Owner, StationId, Tick};
use linewright_plant::{Plant, PlantOptions};

fn lines() -> Vec<(String, Line)> {
    let dir = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines");
    let files = std::fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path().join("line.toml"));
    let parse = |file: std::path::PathBuf| {
        let name = file.display().to_string();
        let text = std::fs::read_to_string(&file).unwrap();
        let parsed = linewright_line::parse(&name, &text).map_err(|_| name.clone()).expect("a shipped line parses");
        (name, parsed.line)
    };
    files.filter(|file| file.exists()).map(parse).collect()
}

/// Drives one motion and expects its switch in its time.
fn run(plant: &mut Plant, station: StationId, signals: MotionSignals, takes: Duration, what: &str) {
    let owner = Owner::Station(station);
    let start = plant.now();
    plant.set_outputs(start, owner, 1 << signals.actuator.0);
    let complete = |plant: &Plant| plant.inputs(owner) >> signals.complete.0 & 1 == 1;
    plant.advance(start + takes.mul_f64(0.99));
    assert!(!complete(plant), "{what} is complete too early");
    plant.advance(start + takes);
    assert!(complete(plant), "{what} is not complete after {takes:?}");
    // Held on, it stays where it is.
    plant.advance(start + takes * 2);
    assert!(complete(plant), "{what} overshoots");
    plant.set_outputs(start + takes * 2, owner, 0);
}

#[test]
fn every_cycle_of_a_shipped_line_can_be_driven_and_every_motion_taken_back() {
    let lines = lines();
    assert!(!lines.is_empty());
    for (name, line) in lines {
        let mut plant = Plant::new(&line, PlantOptions::default());
        for id in line.station_ids() {
            let station = line.station(id);
            // From home: what is listed after the home operation, then the chart from its start; two rounds.
            let count = station.operations.len();
            let after_home = (1..=2 * count).map(|step| OpId::at((station.home.index() + step) % count));
            for op in after_home {
                let operation = line.operation((id, op));
                let what = format!("{name}: {} / {}", station.name, operation.name);
                // A task may begin at another rest than the one before it has ended at.
                let is_there = plant.inputs(Owner::Station(id)) >> operation.normal.complete.0 & 1 == 1;
                if let OperationModule::Reversible { recovery, recovery_duration, .. } = &operation.module
                    && is_there
                    && !station.tasks.is_empty()
                {
                    run(&mut plant, id, *recovery, *recovery_duration, &format!("{what}, from its other end"));
                }
                run(&mut plant, id, operation.normal, operation.duration, &what);
                if let OperationModule::Reversible { recovery, recovery_duration, .. } = &operation.module {
                    run(&mut plant, id, *recovery, *recovery_duration, &format!("{what}, taken back"));
                    run(&mut plant, id, operation.normal, operation.duration, &format!("{what}, again"));
                }
            }
        }
        assert_eq!(plant.alarms(), 0);
        plant.advance(plant.now() + Duration::from_secs(1));
        assert!(plant.next_change().is_none_or(|at| at == Tick::NEVER));
    }
}
