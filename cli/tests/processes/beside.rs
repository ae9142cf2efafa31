//! Two runs on one machine: each has buses of its own, and what is there already is not started again.
//!
//! ```text
//!   run of line a ── its own vcan0, own0 ──▶ cycles done        run of line a ── goes on
//!   run of line b ── its own vcan0, own0 ──▶ cycles done        run of line a again ── refused: process 4711 is that
//! ```

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use crate::support::rig::{ended, free_domain, line, send_signal};
use crate::support::turn::{Turn, alone};
use crate::support::{PATIENCE, wait_for};

/// A runtime directory of its own, as on another machine. LINEWRIGHT_BUS_DIR is not set.
struct Machine {
    directory: TempDir,
    _alone: Turn,
}

/// A command that runs; killed when dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    /// Its exit code and its report.
    fn ended(mut self) -> (i32, Value) {
        ended(&mut self.0, PATIENCE * 2)
    }
}

impl Machine {
    fn new() -> Self {
        let directory = tempfile::Builder::new().prefix("lw").tempdir().expect("a directory");
        Machine { directory, _alone: alone() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// A line of this name, with a mill on a bus named by hand.
    fn line(&self, name: &str) -> PathBuf {
        let text = line(0.3).replacen("name = \"transfer_line\"", &format!("name = \"{name}\""), 1);
        let text = text.replacen("name = \"mill_1\"\n", "name = \"mill_1\"\nbus = \"rig-own0\"\n", 1);
        assert!(text.contains(name) && text.contains("rig-own0"));
        fs::create_dir_all(self.path(name)).expect("a directory");
        fs::write(self.path(name).join("line.toml"), text).expect("a description");
        self.path(name)
    }

    fn command(&self, domain: u16, words: &[&str], line: &Path, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
        command.args(words).arg(line).args(more).stdin(Stdio::null());
        for other in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "RUST_LOG", "LINEWRIGHT_BUS_DIR"] {
            command.env_remove(other);
        }
        command.env("ROS_DOMAIN_ID", domain.to_string()).env("XDG_RUNTIME_DIR", self.directory.path());
        command
    }

    /// No CAN interface has that name, so the bus is a virtual one on any machine.
    fn run(&self, domain: u16, line: &Path, more: &[&str]) -> Running {
        let mut command = self.command(domain, &["run", "--bus", "rig-line"], line, more);
        Running(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts"))
    }

    fn ends(&self, domain: u16, words: &[&str], line: &Path, more: &[&str]) -> Output {
        self.command(domain, words, line, more).output().expect("the command starts")
    }
}

fn refusal(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    // Broken into lines for a terminal.
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

fn both_complete(first: Running, second: Running) {
    for run in [first, second] {
        let (code, report) = run.ended();
        let faults = ["transfer", "clamp_1", "mill_1"].map(|name| report["stations"][name]["faults"].clone());
        // A node that its middleware blocks while topics open is started again; that is no matter of the other run.
        assert_eq!((code, &report["cycles"]), (0, &2.into()), "{report}");
        assert_eq!(faults, [0, 0, 0], "{report}");
        assert_eq!(report["conflicts_seen"], Value::Array(Vec::new()));
    }
}

#[test]
fn two_lines_at_once_both_complete_their_cycles() {
    let machine = Machine::new();
    let (domain, options) = (free_domain(), ["--cycles", "2", "--json"]);
    let lines = ["first_line", "second_line"].map(|name| machine.line(name));
    both_complete(machine.run(domain, &lines[0], &options), machine.run(domain, &lines[1], &options));
    let left: Vec<_> = fs::read_dir(machine.path("linewright-bus")).expect("a directory").flatten().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn one_line_in_two_domains_completes_in_both() {
    let machine = Machine::new();
    let line = machine.line("one_line");
    let domain = free_domain();
    let options = ["--cycles", "2", "--json"];
    let first = machine.run(domain, &line, &options);
    both_complete(first, machine.run(free_domain(), &line, &options));
}

#[test]
fn what_runs_already_is_refused_with_the_process_that_is_it() {
    let machine = Machine::new();
    let (domain, line) = (free_domain(), machine.line("one_line"));
    let state = machine.path("state").display().to_string();
    let mut first = machine.run(domain, &line, &["--no-auto", "--state-dir", &state]);
    let mut said = BufReader::new(first.0.stdout.take().expect("its output"));
    let mut head = String::new();
    said.read_line(&mut head).expect("text");
    assert!(head.contains("run-"), "a bus of its own: {head}");
    // The run itself checks that they are free, before it starts the processes that keep them.
    let by_itself = format!("process {},", first.0.id());
    let kept = |name: &str| {
        let text = fs::read_to_string(machine.path("state").join(name)).unwrap_or_default();
        text.contains("process") && !text.contains(&by_itself)
    };
    assert!(wait_for(PATIENCE, || ["coordinator.lock", "clamp_1.lock", "mill_1.lock"].into_iter().all(kept)));

    let again = refusal(&machine.ends(domain, &["run", "--cycles", "1"], &line, &[]));
    let by =
        format!("a run of line /one_line in ROS domain {domain} is already running: process {}, since", first.0.id());
    assert!(again.contains(&by), "{again}");

    // One that is not refused ends by itself: its standard input has ended.
    let alone = ["--end-with-stdin"];
    for (words, name) in
        [(&["station", "--station", "clamp_1"][..], "clamp_1"), (&["coordinator", "--bus", "other"], "coordinator")]
    {
        let again = refusal(&machine.ends(domain, words, &line, &alone));
        assert!(
            again.contains(&format!("node /one_line/{name} in ROS domain {domain} is already running: process")),
            "{again}"
        );
    }
    let other = if domain == 90 { 34 } else { domain + 1 };
    let there = ["--end-with-stdin", "--state-dir", &state];
    let again = refusal(&machine.ends(other, &["station", "--station", "clamp_1"], &line, &there));
    assert!(
        again.contains("a process that keeps its state in") && again.contains("is already running: process"),
        "{again}"
    );

    // Commands for the simulated devices find their bus by the line, and those for another line do not.
    let stuck = ["clamp_1", "stick", "--operation", "advance clamp"];
    let told = machine.ends(domain, &["fail"], &line, &stuck);
    assert!(told.status.success(), "{told:?}");
    // Its manager may still come up, and its devices be started.
    let mut table = String::new();
    let is_managed = || {
        table = String::from_utf8_lossy(&machine.ends(domain, &["can", "status"], &line, &[]).stdout).into_owned();
        table.contains("✓ rig-line 7Fh  the manager")
    };
    assert!(wait_for(PATIENCE, is_managed), "{table}");
    let other_line = machine.line("other_line");
    let told = refusal(&machine.ends(domain, &["can", "--bus", "rig-line", "status"], &other_line, &[]));
    let both = format!(
        "bus rig-line is that of line /one_line in ROS domain {domain}, and this command is for line /other_line"
    );
    assert!(told.contains(&both), "{told}");

    let mut lines = BufReader::new(first.0.stderr.take().expect("its errors")).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains(" s  mode: home")), "without a terminal, a line for each change");
    send_signal("INT", first.0.id());
    assert_eq!(first.0.wait().expect("a child").code(), Some(0));
    let log = fs::read_to_string(machine.path("state").join("coordinator.log")).expect("a log");
    assert!(!log.is_empty() && !log.contains('\u{1b}'), "no colours in a file: {log}");
    let next = machine.run(domain, &line, &["--cycles", "1", "--json"]);
    let (code, report) = next.ended();
    assert_eq!(code, 0, "{report}");
}
