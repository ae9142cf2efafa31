//! The log of a cell on a disk that fails, or is full: what is acknowledged is on it.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use linewright_coordinator_cell::compile::dispatcher;
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_coordinator_cell::{
    AlarmId, CellTable, Coordination, PlayerInput, PlayerOutbox, PlayerState, ProductionCommand, Record, RecordKind,
    TaskReport,
};
use linewright_coordinator_node::cell::{CellLog, CellLogKeeper, RECORDS_MAX, ROOM_BYTES};
use linewright_line::{StationId, Tick};
use linewright_node_shell::log::{Disk, DiskFaults, DiskOperation};
use linewright_simulation::cell::{CellSim, CellSimOptions};

use super::shipped::{Shipped, directory, shipped, with_production_orders};

/// Notes operations, and lets some of them fail.
#[derive(Debug, Default)]
struct Bad {
    done: Mutex<Vec<DiskOperation>>,
    /// From this one on, for so many.
    fails: Mutex<Option<(usize, usize)>>,
}

impl Bad {
    fn count(&self) -> usize {
        self.done.lock().expect("no panic").len()
    }

    fn since(&self, from: usize) -> Vec<DiskOperation> {
        self.done.lock().expect("no panic")[from..].to_vec()
    }

    fn fail(&self, from: usize, count: usize) {
        *self.fails.lock().expect("no panic") = Some((from, count));
    }
}

impl DiskFaults for Bad {
    fn before(&self, operation: DiskOperation, _: &File) -> io::Result<()> {
        let mut done = self.done.lock().expect("no panic");
        done.push(operation);
        let nth = done.len() - 1;
        let fails = self.fails.lock().expect("no panic").is_some_and(|(from, count)| nth >= from && nth - from < count);
        if fails { Err(io::ErrorKind::ReadOnlyFilesystem.into()) } else { Ok(()) }
    }
}

fn keeper(bad: &Arc<Bad>, path: &Path, table: &Arc<CellTable>) -> Option<CellLogKeeper> {
    let opened = CellLog::open_on(Disk::with_faults(bad.clone()), path, "cell", table).ok()?;
    Some(CellLogKeeper::new(opened.log, Tick::ZERO))
}

fn coordination(of: &Shipped, out: &mut PlayerOutbox) -> Coordination {
    Coordination::begin(PlayerState::new(of.table.clone()), Tick::from_millis(1), 1, out).expect("a new life")
}

const AT: fn(u64) -> Tick = |seconds| Tick::from_millis(seconds * 1000);

#[test]
fn every_request_of_a_person_is_on_the_disk_before_its_reply() {
    let of = with_production_orders("assembly-cell", 5);
    let dir = directory();
    let good = Arc::new(Bad::default());
    let mut log = keeper(&good, &dir.path().join("cell.log"), &of.table).expect("opens");
    let mut out = PlayerOutbox::default();
    let mut coordination = coordination(&of, &mut out);
    assert!(log.write(AT(1), &mut out));
    let order = |key: u128, name: &str| {
        [ProductionOrderRequest {
            key,
            name: name.to_owned(),
            product: "1".to_owned(),
            quantity: 1,
            ..ProductionOrderRequest::default()
        }]
    };
    let (first, second) = (order(1, "first"), order(2, "second"));
    let resource = of.table.handling().resource_ids().next().expect("one at least");
    // Each service of a cell; whether it changes anything.
    let table = [
        (PlayerInput::Production(1, ProductionCommand::Submit(&first)), true),
        (PlayerInput::Production(2, ProductionCommand::Submit(&second)), true),
        (PlayerInput::Production(3, ProductionCommand::Cancel("first")), true),
        (PlayerInput::Production(4, ProductionCommand::Withdraw("second")), true),
        (PlayerInput::Resource { resource, up: false }, true),
        (PlayerInput::Resource { resource, up: true }, true),
        (PlayerInput::Alarm { resource, text: "it smokes" }, true),
        (PlayerInput::Answer { alarm: AlarmId(1), word: "scrap" }, false),
        (PlayerInput::Reset(StationId(0)), false),
    ];
    let mut takes = |coordination: &mut Coordination, at: Tick, input: PlayerInput<'_>, changes: bool| {
        let before = good.count();
        let mut out = PlayerOutbox::default();
        coordination.step(at, &[input], &mut dispatcher(&of.cell, &of.table), &mut out);
        assert_eq!(!out.records.is_empty(), changes, "{input:?}: {out:?}");
        let mut again = out.clone();
        assert!(log.write(at, &mut out), "{input:?}");
        if !input.is_request() {
            return;
        }
        let expected: &[DiskOperation] = if changes { &[DiskOperation::Write, DiskOperation::Sync] } else { &[] };
        assert_eq!(good.since(before), expected, "{input:?}");
        // Where the disk takes the write, and not the sync, there is no reply.
        let (dir, bad) = (directory(), Arc::new(Bad::default()));
        let mut refuses = keeper(&bad, &dir.path().join("cell.log"), &of.table).expect("opens");
        bad.fail(bad.count() + 1, usize::MAX);
        assert_eq!(refuses.write(at, &mut again), !changes, "{input:?}");
    };
    for (at, (input, changes)) in (2..).zip(table) {
        takes(&mut coordination, AT(at), input, changes);
    }
    // An alarm to be answered: of an activity in progress.
    takes(&mut coordination, AT(20), PlayerInput::Resource { resource, up: true }, true);
    let report = TaskReport { memory: 1, ..TaskReport::default() };
    for station in 0..of.stations {
        let station = StationId(u16::try_from(station).expect("few"));
        takes(&mut coordination, AT(21), PlayerInput::Station(station, &report), true);
    }
    let third = order(3, "third");
    takes(&mut coordination, AT(22), PlayerInput::Production(5, ProductionCommand::Submit(&third)), true);
    takes(&mut coordination, AT(23), PlayerInput::Starts(true), true);
    let mode = coordination.state().firings().next().expect("one has started").mode;
    let of_it = of.table.handling().mode(mode).resources().next().expect("one at least");
    takes(&mut coordination, AT(24), PlayerInput::Alarm { resource: of_it, text: "" }, true);
    takes(&mut coordination, AT(600), PlayerInput::Starts(true), true);
    let alarm = coordination.state().exceptions().alarms().next().expect("an alarm");
    let (alarm, word) = (alarm.id, alarm.words.last().expect("an answer").clone());
    takes(&mut coordination, AT(601), PlayerInput::Answer { alarm, word: &word }, true);
    drop(log);
    let found = CellLog::open(&dir.path().join("cell.log"), "cell", &of.table).expect("opens");
    assert_eq!(found.state.snapshot(), coordination.state().snapshot());
}

/// Steps of a small production, each with the state after it.
fn steps(of: &Shipped) -> Vec<(PlayerOutbox, PlayerState)> {
    let mut sim = CellSim::new(of.table.clone(), of.stations, CellSimOptions::default());
    sim.run(&mut dispatcher(&of.cell, &of.table), Tick::from_millis(600_000));
    let mut state = PlayerState::new(of.table.clone());
    let chunks = sim.log.chunks(3).enumerate();
    let step = |(nth, records): (usize, &[Record])| {
        records.iter().for_each(|record| state.apply(record).expect("fits"));
        // Every second is acknowledged.
        let out = PlayerOutbox { records: records.to_vec(), is_requested: nth % 2 == 0, ..PlayerOutbox::default() };
        (out, state.clone())
    };
    chunks.map(step).collect()
}

#[test]
fn whichever_operation_of_the_disk_fails_a_restart_has_every_step_that_was_acknowledged() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let steps = steps(&of);
    let play = |bad: &Arc<Bad>, path: &Path| -> (u64, u64) {
        let Some(mut log) = keeper(bad, path, &of.table) else { return (0, 0) };
        let (mut now, mut acknowledged, mut reached) = (Tick::from_millis(1), 0, 0);
        for (out, state) in &steps {
            reached = state.sequence();
            let mut is_written = log.write(now, &mut out.clone());
            for _ in 0..3 {
                if !is_written {
                    now = now + Duration::from_secs(2);
                    is_written = log.try_again(now, state).is_some_and(|kept| kept == *out);
                }
            }
            if !is_written {
                assert!(log.refusal(now, false).is_some_and(|why| why.contains("cannot be written")));
                break;
            }
            acknowledged = if out.is_requested { reached } else { acknowledged };
            log.shorten(now, state, |_| true);
        }
        (acknowledged, reached)
    };
    let dir = directory();
    let bad = Arc::new(Bad::default());
    let all = steps.last().expect("steps").1.sequence();
    assert_eq!(play(&bad, &dir.path().join("cell.log")).1, all);
    let operations = bad.count();
    assert!(operations > 20, "{operations}");
    for count in [1, 2, usize::MAX] {
        for first in 0..operations {
            let dir = directory();
            let path = dir.path().join("cell.log");
            let bad = Arc::new(Bad::default());
            bad.fail(first, count);
            let (acknowledged, reached) = play(&bad, &path);
            let found = CellLog::open(&path, "cell", &of.table).expect("a log").state;
            let is_between = (acknowledged..=reached).contains(&found.sequence());
            assert!(is_between, "{first} {count}: {acknowledged} {} {reached}", found.sequence());
            let mut state = PlayerState::new(of.table.clone());
            let records = steps.iter().flat_map(|(out, _)| &out.records).take(found.sequence() as usize);
            records.for_each(|record| state.apply(record).expect("fits"));
            assert_eq!(found.snapshot(), state.snapshot(), "{first} {count}");
            assert!(count == usize::MAX || reached == 0 || reached == all, "{first} {count}: it goes on");
        }
    }
}

#[test]
fn without_room_production_orders_are_refused_and_what_runs_is_written_into_the_room_there_is() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let steps = steps(&of);
    let dir = directory();
    let bad = Arc::new(Bad::default());
    let mut log = keeper(&bad, &dir.path().join("cell.log"), &of.table).expect("opens");
    assert!(!log.is_short() && log.refusal(AT(1), true).is_none());
    let records: Vec<Record> = steps.iter().flat_map(|(out, _)| out.records.clone()).collect();
    let bytes: u64 = records.iter().map(|of| serde_json::to_vec(of).expect("text").len() as u64 + 32).sum();
    let (mut written, mut now) = (0, 10);
    // A full disk lets what is there be written, and no more be taken.
    while !log.is_short() {
        let before = bad.count();
        let mut out = PlayerOutbox { records: records.clone(), ..PlayerOutbox::default() };
        bad.fail(before + 1, 1);
        assert!(log.write(AT(now), &mut out), "{:?}", log.trouble());
        written += bytes;
        now += 1;
        assert!(written < 2 * ROOM_BYTES, "it is short by then");
    }
    bad.fail(0, 0);
    assert!(log.refusal(AT(now), true).is_some_and(|why| why.contains("no production order is taken")));
    assert_eq!(log.refusal(AT(now), false), None);
    assert!(!log.is_halted());
    log.make_room(AT(now + 2));
    assert!(!log.is_short() && log.refusal(AT(now + 2), true).is_none());
}

/// A database that is locked for some seconds, or cannot be written, still takes its records from the log.
#[test]
fn a_long_log_waits_for_a_database_that_fails_until_it_is_very_long() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let dir = directory();
    let mut log = keeper(&Arc::new(Bad::default()), &dir.path().join("cell.log"), &of.table).expect("opens");
    let mut state = PlayerState::new(of.table.clone());
    let mut append = |log: &mut CellLogKeeper, from: u64, to: u64| {
        let epoch = |epoch| Record { at: AT(1), fact: RecordKind::Epoch { epoch } };
        let mut out = PlayerOutbox { records: (from..to).map(epoch).collect(), ..PlayerOutbox::default() };
        out.records.iter().for_each(|record| state.apply(record).expect("fits"));
        assert!(log.write(AT(2), &mut out));
        state.clone()
    };
    let is_shortened = || dir.path().join("cell.log.2").exists();
    let state = append(&mut log, 1, RECORDS_MAX + 1);
    log.shorten(AT(3), &state, |is_very_long| is_very_long);
    assert!(!is_shortened(), "the database lacks them");
    let state = append(&mut log, RECORDS_MAX + 1, 10 * RECORDS_MAX + 1);
    log.shorten(AT(4), &state, |is_very_long| is_very_long);
    assert!(is_shortened(), "it is bounded");
}
