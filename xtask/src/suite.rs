//! `cargo xtask test`: everything a change has to pass, cheapest first.
//!
//! No part stops at another's failure, so that one run tells all. Format, house rules, lints and documentation count
//! as one test each in the sum.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use crate::part::{Stream, cargo, lines};
use crate::tally::Tally;
use crate::tidy;

/// How much of it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// All of it.
    Everything,
    /// What takes seconds once it is built.
    Quick,
}

/// What the exit code means with which `vcan_uml.sh` says that it could not run.
const SKIPPED: i32 = 77;

/// Runs the parts and prints the sum; true if nothing failed.
pub fn run(root: &Path, extent: Extent) -> bool {
    let mut tally = Tally::default();
    one(&mut tally, "format", cargo(root, &["fmt", "--all", "--check"]));
    house_rules(&mut tally, root);
    let clippy = ["clippy", "--workspace", "--all-targets", "--keep-going", "--quiet", "--", "-D", "warnings"];
    one(&mut tally, "lints", cargo(root, &clippy));
    match extent {
        Extent::Everything => {
            let args = ["test", "--workspace", "--no-fail-fast", "--", "--show-output"];
            let programs = tests(&mut tally, cargo(root, &args));
            vcan(&mut tally, root, &programs);
            let mut doc = cargo(root, &["doc", "--workspace", "--no-deps", "--quiet"]);
            doc.env("RUSTDOCFLAGS", "-D warnings");
            one(&mut tally, "documentation", doc);
        }
        Extent::Quick => {
            let mut args = vec!["test", "--no-fail-fast"];
            let names = tidy::PURE.iter().chain(&["linewright-msgs", "xtask"]);
            args.extend(names.flat_map(|name| ["--package", name]));
            args.extend(["--", "--show-output"]);
            tests(&mut tally, cargo(root, &args));
            tally.skip("SKIPPED tests of the crates with sockets and processes, and documentation: --quick");
        }
    }
    println!();
    tally.skipped.iter().for_each(|skipped| println!("{skipped}"));
    println!("{} passed, {} failed", tally.passed, tally.failed);
    tally.failed == 0
}

fn house_rules(tally: &mut Tally, root: &Path) {
    heading("house rules");
    if tidy::run(root) { tally.passed += 1 } else { tally.failed += 1 }
}

/// A program that passes or fails as a whole.
fn one(tally: &mut Tally, name: &str, command: Command) {
    heading(name);
    let start = Instant::now();
    match lines(command, |_, line| println!("{line}")) {
        Ok(Some(0)) => {
            tally.passed += 1;
            println!("{name}: ok, {:.0?}", start.elapsed());
        }
        ended => {
            tally.failed += 1;
            println!("{name}: FAILED ({})", how(&ended));
        }
    }
}

/// Cargo's tests, which are counted one by one. Gives cargo's lines that say which program it starts.
fn tests(tally: &mut Tally, command: Command) -> Vec<String> {
    heading("tests");
    let start = Instant::now();
    let failed_before = tally.failed;
    let mut programs = Vec::new();
    let ended = lines(command, |stream, line| {
        if tally.read(stream, line) {
            println!("{line}");
        }
        if stream == Stream::Err && line.trim_start().starts_with("Running ") {
            programs.push(line.to_owned());
        }
    });
    if !matches!(ended, Ok(Some(0))) && tally.failed == failed_before {
        // It did not build, or a test program died: no test was counted as failed, but something did.
        tally.failed += 1;
        println!("tests: FAILED ({})", how(&ended));
    }
    println!("tests: {:.0?}", start.elapsed());
    programs
}

/// The tests that want real CAN sockets: the bus itself, SDO against Python's `canopen`, and whole programs.
const ON_VCAN: [&str; 3] = ["tests/vcan.rs", "tests/sdo_python.rs", "tests/real_bus/main.rs"];

/// The CAN tests on real sockets, in a kernel of their own where this one has no CAN.
fn vcan(tally: &mut Tally, root: &Path, programs: &[String]) {
    if Path::new("/sys/class/net/vcan0").exists() {
        return;
    }
    for test in ON_VCAN {
        heading(&format!("CAN sockets in a user-mode Linux: {test}"));
        match programs.iter().find_map(|line| program_of(line, test)) {
            Some(program) => in_user_mode_linux(tally, root, program),
            None => tally.skip(&format!("SKIPPED {test} in a user-mode Linux: it was not built")),
        }
    }
}

/// It is given the program that has just been built: built by itself, the crate would have other features, and with them
/// most of its dependencies once more.
fn in_user_mode_linux(tally: &mut Tally, root: &Path, program: &str) {
    const SCRIPT: &str = "fieldbus/io/tests/vcan_uml.sh";
    let mut command = Command::new("sh");
    command.current_dir(root).args([SCRIPT, program]);
    let failed_before = tally.failed;
    let ended = lines(command, |stream, line| {
        if tally.read(stream, line) {
            println!("{line}");
        }
    });
    match ended {
        Ok(Some(0)) => {}
        Ok(Some(SKIPPED)) => tally.skip(&format!("SKIPPED {SCRIPT}: see above")),
        ended if tally.failed == failed_before => {
            tally.failed += 1;
            println!("{SCRIPT}: FAILED ({})", how(&ended));
        }
        _ => {}
    }
}

/// The program in a line like `     Running tests/vcan.rs (target/debug/deps/vcan-0123)`.
fn program_of<'a>(line: &'a str, test: &str) -> Option<&'a str> {
    line.trim_start().strip_prefix("Running ")?.strip_prefix(test)?.strip_prefix(" (")?.strip_suffix(')')
}

fn heading(name: &str) {
    println!("\n== {name}");
}

fn how(ended: &std::io::Result<Option<i32>>) -> String {
    match ended {
        Ok(Some(code)) => format!("exit code {code}"),
        Ok(None) => "killed by a signal".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_program_of_a_test_is_found_in_what_cargo_says() {
        let line = "     Running tests/vcan.rs (target/debug/deps/vcan-0123)";
        assert_eq!(super::program_of(line, "tests/vcan.rs"), Some("target/debug/deps/vcan-0123"));
        assert_eq!(super::program_of(line, "tests/other.rs"), None);
    }
}
