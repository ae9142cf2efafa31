//! Whole programs on a real CAN interface, beside programs of others.
//!
//! Tests beyond the virtual bus: kernel, `candump` and a foreign CANopen stack decode our frames as we do. Needs an
//! interface `vcan0`; `cargo xtask test` boots a kernel that has one where this one has not. The tests with Python need
//! its packages `canopen` and `python-can`; `LINEWRIGHT_PYTHON` names the interpreter.
//!
//! The guest has one slow processor, so ages and leases are patient here.

#[path = "../support/mod.rs"]
mod support;

mod cycles;
mod python;

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// The interface.
const BUS: &str = "vcan0";
const TIMING: &str = "\n[timing]\nrefresh_ms = 250\nstale_ms = 5000\nlease_ms = 10000\nheartbeat_ms = 500\n\
                      heartbeat_timeout_ms = 5000\n";

/// A description for a machine that may stand still for seconds: its watchdogs wait for it.
fn patient(text: &str) -> String {
    let patient = text.replace("watchdog_s = 1.", "watchdog_s = 21.").replace("watchdog_s = 2.", "watchdog_s = 22.");
    assert_ne!(patient, text);
    patient + TIMING
}

/// Whether there is no bus to test on; prints it if so.
fn no_bus() -> bool {
    let missing = !PathBuf::from("/sys/class/net").join(BUS).exists();
    if missing {
        println!("SKIPPED: no {BUS} here");
    }
    missing
}

/// A line's directory with this description and these files beside it, and the directory around it.
fn line_of(text: &str, beside: &[&str]) -> (tempfile::TempDir, String) {
    let directory = tempfile::Builder::new().prefix("lw").tempdir().expect("a directory");
    let line = directory.path().join("line");
    fs::create_dir_all(&line).expect("a directory");
    fs::write(line.join("line.toml"), text).expect("a description");
    for name in beside {
        fs::copy(own(name), line.join(name)).expect("a file beside it");
    }
    let line = line.display().to_string();
    (directory, line)
}

/// A file of this test.
fn own(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/real_bus").join(name)
}

/// The built command, without inherited ROS settings.
fn linewright(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
    for other in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "RUST_LOG"] {
        command.env_remove(other);
    }
    command.env("ROS_DOMAIN_ID", "77").args(args);
    command
}

/// A program that is ended when it is no longer needed.
struct Beside(Child);

impl Beside {
    /// Starts it. Its standard input stays open as long as it is needed.
    fn start(command: &mut Command) -> Self {
        Beside(command.stdin(Stdio::piped()).spawn().expect("it starts"))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
