//! The built command as a user meets it: its arguments, its output, and a directory of the test's own.
//!
//! For tests of commands that end by themselves. It starts no nodes; the rest of this directory does.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use super::turn::beside_no_rig;

/// Runs the command to its end.
pub fn linewright(args: &[&str]) -> Output {
    let _no_rig = beside_no_rig();
    Command::new(env!("CARGO_BIN_EXE_linewright")).args(args).output().expect("the command starts")
}

/// Runs the command to its end in a directory, where it may leave files, with nothing to read.
pub fn linewright_in(directory: &str, args: &[&str]) -> Output {
    let _no_rig = beside_no_rig();
    let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
    let command = command.current_dir(directory).args(args).stdin(std::process::Stdio::null());
    command.output().expect("the command starts")
}

/// Runs the command with a reader that has gone, as `| head` has once it has enough.
pub fn unread(args: &[&str]) -> Output {
    let _no_rig = beside_no_rig();
    let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    command.args(args).stdout(writer).output().expect("the command starts")
}

/// Runs the command with its output on a full disk.
pub fn into_full_disk(args: &[&str]) -> Output {
    let _no_rig = beside_no_rig();
    let full = std::fs::File::options().write(true).open("/dev/full").expect("Linux has it");
    let mut command = Command::new(env!("CARGO_BIN_EXE_linewright"));
    command.args(args).stdout(full).output().expect("the command starts")
}

/// The shipped line's directory.
pub fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines/transfer-line")
}

/// Output as text.
pub fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("output is text")
}

/// Whether nothing was printed beside the output of a check, but for how long it has been at work on a busy machine.
pub fn is_quiet(output: &Output) -> bool {
    text(&output.stderr).lines().all(|line| line.contains("visiting") && line.contains("state"))
}

/// Output as one JSON object.
pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

/// A directory of this test's own, removed when it ends.
pub struct Scratch(tempfile::TempDir);

impl Scratch {
    /// An empty one.
    pub fn new() -> Self {
        Scratch(tempfile::tempdir().expect("a directory for temporary files"))
    }

    /// The path of a file in it, which need not be there.
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("a plain path").to_owned()
    }

    /// Writes a file; gives its path.
    pub fn file(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).expect("a scratch file");
        path
    }

    /// Text of a file.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The shipped line with the first such text replaced.
    pub fn changed(&self, from: &str, to: &str) -> String {
        let text = std::fs::read_to_string(shipped().join("line.toml")).expect("the shipped line is there");
        assert!(text.contains(from), "nothing to replace: {from}");
        self.file("line.toml", &text.replacen(from, to, 1))
    }
}
