//! Contents of the log of a cell, and refusals.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use linewright_coordinator_cell::compile::dispatcher;
use linewright_coordinator_cell::{CellTable, PlayerOutbox, PlayerState, Record, RecordKind};
use linewright_coordinator_node::cell::{CellLog, CellLogError, OpenedLog, RECORDS_MAX};
use linewright_line::Tick;
use linewright_node_shell::log::{LogError, RecordLog};
use linewright_simulation::cell::{CellSim, CellSimOptions};
use proptest::prelude::*;
use tempfile::TempDir;

use super::shipped::{Shipped, directory, shipped};

fn open(path: &Path, table: &Arc<CellTable>) -> Result<OpenedLog, CellLogError> {
    CellLog::open(path, "assembly_cell", table)
}

fn scratch() -> (TempDir, PathBuf) {
    let dir = directory();
    let path = dir.path().join("cell.log");
    (dir, path)
}

/// The records of a small production.
fn records(of: &Shipped) -> Vec<Record> {
    let mut sim = CellSim::new(of.table.clone(), of.stations, CellSimOptions::default());
    sim.run(&mut dispatcher(&of.cell, &of.table), Tick::from_millis(600_000));
    assert_eq!(sim.state().left(), u64::from(of.parts));
    sim.log
}

#[test]
fn at_whatever_byte_a_log_is_cut_off_it_says_what_the_whole_records_say() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let records = records(&of);
    let (_dir, path) = scratch();
    let mut log = open(&path, &of.table).expect("opens").log;
    // Where each record ends.
    let (file, begin) = log.file();
    let mut ends = vec![begin];
    for record in &records {
        log.append(std::slice::from_ref(record)).expect("appends");
        ends.push(log.file().1);
    }
    drop(log);
    let whole = std::fs::read(&file).expect("reads");
    assert!(records.len() > 20 && whole.len() as u64 == *ends.last().expect("one at least"));
    let mut state = PlayerState::new(of.table.clone());
    for (count, pair) in ends.windows(2).enumerate() {
        for length in pair[0]..pair[1] {
            std::fs::write(&file, &whole[..length as usize]).expect("writes");
            let found = open(&path, &of.table).expect("opens");
            // Zeros at the end are room for records.
            let torn = &whole[pair[0] as usize..length as usize];
            let cut = torn.iter().rposition(|&byte| byte != 0).map_or(0, |last| last as u64 + 1);
            assert_eq!((&found.state, found.cut), (&state, cut), "{length}");
        }
        state.apply(&records[count]).expect("fits");
    }
}

#[test]
fn a_snapshot_takes_the_place_of_the_records() {
    let of = shipped("assembly-cell", &[2, 1, 1]);
    let records = records(&of);
    let (_dir, path) = scratch();
    let mut log = open(&path, &of.table).expect("opens").log;
    let half = records.len() / 2;
    log.append(&records[..half]).expect("appends");
    let state = PlayerState::replay(of.table.clone(), &records[..half]).expect("fits");
    log.begin_anew(&state).expect("begins anew");
    log.append(&records[half..]).expect("appends");
    drop(log);
    let found = open(&path, &of.table).expect("opens");
    let all = PlayerState::replay(of.table.clone(), &records).expect("fits");
    assert_eq!((found.state.snapshot(), found.cut), (all.snapshot(), 0));
    assert!(!found.log.is_long());
}

#[test]
fn a_log_is_long_after_so_many_records_also_if_most_were_there_before() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let (_dir, path) = scratch();
    let mut log = open(&path, &of.table).expect("opens").log;
    let epochs = |range: std::ops::Range<u64>| -> Vec<Record> {
        range.map(|epoch| Record { at: Tick::ZERO, fact: RecordKind::Epoch { epoch } }).collect()
    };
    log.append(&epochs(1..RECORDS_MAX)).expect("appends");
    assert!(!log.is_long());
    drop(log);
    let mut log = open(&path, &of.table).expect("opens").log;
    let last = PlayerOutbox { records: epochs(RECORDS_MAX..RECORDS_MAX + 1), ..PlayerOutbox::default() };
    log.write(&last).expect("writes");
    assert!(log.is_long());
}

#[test]
fn the_log_of_another_cell_or_another_description_is_refused_with_what_is_different() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let (_dir, path) = scratch();
    drop(open(&path, &of.table).expect("opens"));
    let refused = |found: Result<OpenedLog, CellLogError>| found.expect_err("it is refused").to_string();
    let other = CellLog::open(&path, "workcell_c1", &of.table);
    let what = "is about cell `assembly_cell`, not about cell `workcell_c1`; empty the cell with that description, then remove ";
    assert!(refused(other).contains(what));
    let more = shipped("assembly-cell", &[1, 1, 0]);
    let why = refused(open(&path, &more.table));
    let (is, expected) = (of.table.digest(), more.table.digest());
    let what = format!("another description of cell `assembly_cell` ({is:016x}), not about this one ({expected:016x})");
    assert!(why.contains(&what), "{why}");
    // Of a program that wrote something else.
    let (_dir, path) = scratch();
    let identity = format!(r#"{{"format":2,"cell":"assembly_cell","table":"{is:016x}"}}"#);
    drop(RecordLog::open(&path, identity.as_bytes(), |_| Ok(())).expect("opens"));
    assert!(refused(open(&path, &of.table)).contains("records in form 2, not about records in form 1"));
    let (_dir, path) = scratch();
    drop(RecordLog::open(&path, b"a diary", |_| Ok(())).expect("opens"));
    assert!(refused(open(&path, &of.table)).ends_with("it is no log of a cell"));
}

#[test]
fn a_record_that_does_not_fit_is_named() {
    let of = shipped("assembly-cell", &[1, 0, 0]);
    let (_dir, path) = scratch();
    let mut log = open(&path, &of.table).expect("opens").log;
    let end = log.file().1;
    let ended = RecordKind::Ended { firing: linewright_coordinator_cell::FiringId(1) };
    log.append(&[Record { at: Tick::ZERO, fact: ended }]).expect("appends");
    drop(log);
    let why = open(&path, &of.table).expect_err("it does not fit").to_string();
    let what = format!("from byte {end} on: record 1 does not fit: firing 1 is not in progress");
    assert!(why.ends_with(&what), "{why}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Records written by hand, with the right checksums.
    #[test]
    fn whatever_records_say_they_are_refused_or_fit(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<u8>()), 1..6),
        snapshot: bool,
    ) {
        let of = shipped("assembly-cell", &[1, 0, 1]);
        let records = records(&of);
        let mut lines: Vec<Vec<u8>> = records.iter().map(|record| serde_json::to_vec(record).expect("text")).collect();
        let half = records.len() / 2;
        let state = PlayerState::replay(of.table.clone(), &records[..half]).expect("fits");
        let mut first = serde_json::to_vec(&state.snapshot()).expect("text");
        for (line, byte, to) in edits {
            let line = line.index(lines.len());
            let line = if snapshot { &mut first } else { &mut lines[line] };
            let byte = byte.index(line.len());
            // Mostly digits, so that it is still a record.
            line[byte] = if line[byte].is_ascii_digit() { b'0' + to % 10 } else { to };
        }
        let (_dir, path) = scratch();
        drop(open(&path, &of.table).expect("opens"));
        let mut log = RecordLog::open(&path, b"", |_| Ok(())).expect("opens").0;
        if snapshot {
            log.begin_anew(&first).expect("begins anew");
            lines.drain(..half);
        }
        log.append(lines.iter().map(Vec::as_slice)).expect("appends");
        drop(log);
        match open(&path, &of.table) {
            Ok(found) => prop_assert!(found.state.sequence() > 0),
            Err(CellLogError::Log(LogError::Refused { .. })) => (),
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        }
    }
}
