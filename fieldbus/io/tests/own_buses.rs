//! Directories of buses of one run: found while somebody is on them, and swept when their run was killed.

use std::fs;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};

use linewright_fieldbus::bus::find_bus_in;
use linewright_fieldbus::{Bus, BusDirectory, BusOptions, OwnBuses, Transport};

/// The directory of a run with somebody on its bus.
fn run(base: &Path, number: &str, about: &str) -> (UnixDatagram, PathBuf) {
    let dir = base.join(format!("run-{number}"));
    fs::create_dir_all(dir.join("vcan0")).expect("a directory");
    fs::write(dir.join("about"), about).expect("a file");
    (UnixDatagram::bind(dir.join("vcan0/a.can")).expect("a socket"), dir)
}

#[test]
fn a_bus_is_found_where_somebody_is_on_it() {
    let base = tempfile::tempdir().expect("a directory");
    let (member, mill) = run(base.path(), "1-0", "mill");
    let (other, rotary) = run(base.path(), "2-0", "rotary");
    let of = |dir: &Path, about: &str| BusDirectory { about: Some(about.to_owned()), dir: dir.to_owned() };
    let mut both = find_bus_in(base.path(), "vcan0", None);
    both.sort_by_key(|found| found.about.clone());
    assert_eq!(both, [of(&mill, "mill"), of(&rotary, "rotary")]);
    assert_eq!(find_bus_in(base.path(), "vcan0", Some("rotary")), [of(&rotary, "rotary")]);
    assert_eq!(find_bus_in(base.path(), "vcan1", None), []);
    drop(member);
    assert_eq!(find_bus_in(base.path(), "vcan0", None), [of(&rotary, "rotary")], "a socket that was left behind");
    drop(other);
    assert_eq!(find_bus_in(base.path(), "vcan0", None), []);
}

#[test]
fn a_directory_that_cannot_be_made_is_named() {
    let base = tempfile::tempdir().expect("a directory");
    let file = base.path().join("a file");
    fs::write(&file, "").expect("a file");
    let error = OwnBuses::create_in(&file, "mill").expect_err("a file has no directories");
    assert!(error.to_string().starts_with(&file.display().to_string()), "{error}");
    let options = BusOptions { transport: Transport::Virtual, dir: Some(file.clone()) };
    let error = Bus::open("vcan0", &options).err().expect("nor buses");
    assert!(error.to_string().contains(&file.display().to_string()), "{error}");
}

#[test]
fn what_killed_runs_leave_is_swept_and_what_is_in_use_is_not() {
    let base = tempfile::tempdir().expect("a directory");
    // No process has this number: it is above the kernel's limit.
    let (gone, left) = run(base.path(), "7fffffff-0", "killed");
    let (_member, used) = run(base.path(), "7ffffffe-0", "killed, its plant not yet");
    let (_, ours) = run(base.path(), &format!("{:x}-0", std::process::id()), "this one, before its devices are up");
    drop(gone);
    let new = OwnBuses::create_in(base.path(), "another").expect("a directory");
    assert_eq!([left, used, ours].map(|dir| dir.exists()), [false, true, true]);
    assert!(new.dir().exists());
}
