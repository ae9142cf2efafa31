//! The disk with a line's database is full for a while: the line goes on, it is logged once, and when there is room again the
//! database goes on by itself, with the gap in it.
//!
//! The disk is a small file system in memory, in a mount namespace of its own. Journals are elsewhere: a station whose journal
//! cannot be written stops, which is tested with the station.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::symlink;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::support::rig::{Rig, line};
use crate::support::wait_for;

/// A process that holds the mount namespace.
struct SmallDisk {
    holder: Child,
}

impl SmallDisk {
    /// One that is mounted at this directory. `None`: there is no right to do that.
    fn mount(at: &std::path::Path) -> Option<Self> {
        let script = "mount -t tmpfs -o size=16m none \"$0\" && echo mounted && exec sleep 600";
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", script]).arg(at).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut disk = SmallDisk { holder: command.spawn().ok()? };
        let mut said = String::new();
        BufReader::new(disk.holder.stdout.take()?).read_line(&mut said).ok()?;
        (said.trim() == "mounted").then_some(disk)
    }

    /// Command line by which another command is started that is to see this disk.
    fn prefix(&self) -> Vec<String> {
        let id = self.holder.id().to_string();
        ["nsenter", "--preserve-credentials", "-U", "-m", "-t", &id].map(str::to_owned).to_vec()
    }

    /// A file on it, as this process can reach it.
    fn file(&self, path: &std::path::Path) -> std::path::PathBuf {
        format!("/proc/{}/root{}", self.holder.id(), path.display()).into()
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = self.holder.kill();
        let _ = self.holder.wait();
    }
}

#[test]
fn a_full_disk_leaves_a_gap_in_the_database_and_nothing_else() {
    let mut rig = Rig::new(&line(0.3));
    let at = rig.state().with_file_name("disk");
    std::fs::create_dir_all(&at).expect("a directory");
    let Some(disk) = SmallDisk::mount(&at) else {
        println!("SKIPPED: no right to make a mount namespace with a file system in memory");
        return;
    };
    symlink(at.join("line.db"), rig.state().join("line.db")).expect("a link");
    rig.inside(disk.prefix());
    let operator = rig.in_auto();
    operator.cycles(1);
    assert!(disk.file(&at.join("line.db-wal")).exists(), "the database is on the small disk");

    let filler = disk.file(&at.join("filler"));
    let mut file = File::create(&filler).expect("a file");
    while file.write_all(&[0; 512]).is_ok() {}
    let failed = || rig.log("coordinator").contains("reports may lack what happens");
    assert!(wait_for(Duration::from_secs(20), failed), "it is logged: {}", rig.log("coordinator"));
    operator.cycles(3);
    drop(file);
    std::fs::remove_file(&filler).expect("it is there");
    let resumed = || rig.log("coordinator").contains("line.db is written again");
    assert!(wait_for(Duration::from_secs(40), resumed), "it goes on: {}", rig.log("coordinator"));
    operator.cycles(2);
    operator.go_home();
    let log = rig.log("coordinator");
    let warnings: Vec<&str> = log.lines().filter(|line| line.contains("reports may lack what happens")).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("line.db") && warnings[0].contains("make room"), "{log}");
    let reported: Value = serde_json::from_str(&rig.reported(&["--json"])).expect("JSON");
    let gaps = reported["gaps"].as_array().expect("a list");
    assert!(gaps.len() == 1 && gaps[0]["lost"].as_u64().is_some_and(|lost| lost > 0), "{reported}");
    assert!(reported["unrecorded_s"].as_f64().is_some_and(|span| span > 0.0), "{reported}");
    assert!(rig.reported(&[]).contains("could not be written"));
    rig.ends_well(0);
}
