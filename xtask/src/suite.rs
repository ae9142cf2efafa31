//! `cargo xtask test`: everything a change has to pass.
//!
//! No part stops at another's failure, so that one run shows all failures. Format, house rules, lints and documentation
//! count as one test each in the sum. The output of parts that run beside others is printed whole at their end.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::Instant;

use crate::part::{Stream, cargo, lines};
use crate::setup::{self, Setup};
use crate::tally::TestTally;
use crate::tidy;

/// Extent of a run.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// All parts.
    Everything,
    /// Parts that take seconds once they are built.
    Quick,
    /// The long tests alone, with more cases than are waited for elsewhere.
    Long,
}

/// The environment variable for the cases of generated tests, in percent of what each states: `testkit/src/cases.rs`.
const CASES: &str = "LINEWRIGHT_CASES";
/// For a run that is waited for, and for one that is not. What the environment has goes before.
const FEW_CASES: &str = "25";
const MANY_CASES: &str = "400";

/// Parts of the names of long tests, of one package where its name stands before. Most of them explore or play generated
/// lines and cells.
const LONG: [&str; 19] = [
    "linewright-coordinator-cell planning::",
    "linewright-faults every_rule_that",
    "linewright-faults whatever_happens",
    "linewright-tests ::",
    "linewright-recovery brute_force::",
    "linewright-recovery random_plays::",
    "linewright-proof agreement::",
    "broken::",
    "cells::protocol::",
    "cells::random::",
    "expiry::",
    "generated::",
    "lumped::",
    "linewright-proof parts::",
    "cells::queues::",
    "linewright-proof recovery::",
    "restarts::",
    "siphons::commoners",
    "tnces_random::",
];

/// Exit code of `vcan_uml.sh` when it could not run.
const SKIPPED: i32 = 77;

/// Runs the parts and prints the sum; true if nothing failed.
pub fn run(root: &Path, extent: Extent) -> bool {
    let mut tally = TestTally::default();
    match extent {
        Extent::Everything => everything(root, &mut tally),
        Extent::Quick => quick(root, &mut tally),
        Extent::Long => long(root, &mut tally),
    }
    println!();
    tally.skipped.iter().for_each(|skipped| println!("{skipped}"));
    println!("{} passed, {} failed", tally.passed, tally.failed);
    tally.failed == 0
}

fn everything(root: &Path, tally: &mut TestTally) {
    // While packages are fetched, the rest is built.
    let (setup, programs) = thread::scope(|scope| {
        let setup = scope.spawn(|| setup::run(root));
        format_and_rules(root, tally);
        let programs = build(root);
        (setup.join().unwrap_or_default(), programs)
    });
    heading("set-up");
    setup.missing.iter().for_each(|missing| tally.skip(&format!("SKIPPED what needs it: {missing}")));
    println!("set-up: {}", if setup.missing.is_empty() { "all there" } else { "not all is to be had, see the end" });

    spelling(root, &setup, tally);
    dependencies(root, tally);

    // Lines of processes and guests with CAN sockets mostly wait, and are patient; what computes runs beside them.
    let beside = thread::scope(|scope| {
        let beside = scope.spawn(|| {
            let mut stage = Stage::default();
            processes(root, &setup, &mut stage);
            vcan(root, &programs, &setup, &mut stage);
            stage
        });
        let mut command = cargo(root, &["test", "--workspace", "--no-fail-fast", "--", "--show-output"]);
        command.env(CASES, cases_or(FEW_CASES));
        setup.apply(command.args(["--skip", PROCESSES]));
        tests(tally, command);
        lints(root, tally);
        let mut doc = cargo(root, &["doc", "--workspace", "--no-deps", "--quiet"]);
        doc.env("RUSTDOCFLAGS", "-D warnings");
        one(tally, "documentation", doc);
        beside.join()
    });
    match beside {
        Ok(stage) => {
            stage.shown.iter().for_each(|line| println!("{line}"));
            tally.add(stage.tally);
        }
        Err(_) => tally.failed += 1,
    }
}

/// Output of parts that ran beside others, to be printed at their end.
#[derive(Default)]
struct Stage {
    shown: Vec<String>,
    tally: TestTally,
}

/// The module with the tests that start lines of processes.
const PROCESSES: &str = "processes::";

/// The same programs hold other tests too, so the module is named; in a program without that module there is nothing to run.
fn processes(root: &Path, setup: &Setup, stage: &mut Stage) {
    stage.shown.push("\n== tests of lines of processes".to_owned());
    let start = Instant::now();
    let args = ["test", "--workspace", "--no-fail-fast", "--test", "all", "--", "--show-output", PROCESSES];
    let mut command = cargo(root, &args);
    setup.apply(&mut command);
    let Stage { shown, tally } = stage;
    counted(tally, "tests of lines of processes", command, &[0], |line| {
        let is_empty = line.contains("test result: ok. 0 passed") || line.trim_start().starts_with("Running ");
        shown.extend((!is_empty).then(|| line.to_owned()));
    });
    shown.push(format!("tests of lines of processes: {:.0?}", start.elapsed()));
}

/// The test programs of everything are built at once, because packages built by themselves have other features and with
/// them most of their dependencies once more; those of the pure crates are run.
fn quick(root: &Path, tally: &mut TestTally) {
    format_and_rules(root, tally);
    spelling(root, &setup::find(root), tally);
    lints(root, tally);
    let is_quick = |name: &str| tidy::PURE.contains(&name) || ["linewright-msgs", "xtask"].contains(&name);
    let setup = setup::find(root);
    let programs = test_programs(root, tally, &[]);
    heading("tests");
    let start = Instant::now();
    for program in programs.iter().filter(|program| is_quick(&program.package)) {
        let skipped = long_of(&program.package).flat_map(|name| ["--skip", name]);
        let mut command = program.command();
        command.args(skipped).env(CASES, cases_or(FEW_CASES));
        setup.apply(&mut command);
        counted(tally, &program.path, command, &[0], |line| println!("{line}"));
    }
    println!("tests: {:.0?}", start.elapsed());
    tally.skip("SKIPPED tests of the crates with sockets and processes, long tests, and documentation: --quick");
}

/// Long tests, also those that are ignored elsewhere. Optimised: they compute for minutes.
fn long(root: &Path, tally: &mut TestTally) {
    let programs = test_programs(root, tally, &["--release"]);
    heading("long tests");
    for program in &programs {
        let start = Instant::now();
        let names: Vec<&str> = long_of(&program.package).collect();
        // Then those that no other run has. In crates that start processes what is ignored is such a process.
        let ignored = tidy::PURE.contains(&program.package.as_str()).then_some(&["--ignored"][..]);
        for extent in [&names[..]].into_iter().chain(ignored) {
            let mut command = program.command();
            command.args(extent).env(CASES, cases_or(MANY_CASES));
            counted(tally, &program.path, command, &[0], |line| {
                if !line.contains("test result: ok. 0 passed") {
                    println!("{line}");
                }
            });
        }
        println!("{}: {:.0?}", program.package, start.elapsed());
    }
}

/// Cases in percent: what the environment has, or these.
fn cases_or(percent: &str) -> String {
    std::env::var(CASES).unwrap_or_else(|_| percent.to_owned())
}

/// The names of a package's long tests, or parts of them.
fn long_of(package: &str) -> impl Iterator<Item = &'static str> {
    LONG.iter().filter_map(move |long| match long.split_once(' ') {
        Some((of, name)) => (of == package).then_some(name),
        None => Some(*long),
    })
}

/// Builds the programs with tests.
fn test_programs(root: &Path, tally: &mut TestTally, more: &[&str]) -> Vec<TestProgram> {
    heading("build");
    let mut programs = Vec::new();
    let args = ["test", "--workspace", "--no-run", "--quiet", "--message-format=json-render-diagnostics"];
    let mut command = cargo(root, &args);
    command.args(more);
    // What is optimised for long tests is checked as in the others.
    for check in ["DEBUG_ASSERTIONS", "OVERFLOW_CHECKS"] {
        command.env(format!("CARGO_PROFILE_RELEASE_{check}"), "true");
    }
    let ended = lines(command, |stream, line| match stream {
        Stream::Out => programs.extend(TestProgram::of(line)),
        Stream::Err => println!("{line}"),
    });
    println!("build: {}", if matches!(ended, Ok(Some(0))) { "ok".to_owned() } else { how(&ended) });
    if !matches!(ended, Ok(Some(0))) {
        tally.failed += 1;
    }
    programs
}

/// A program with tests, as cargo describes it.
#[derive(Debug, PartialEq, Eq)]
struct TestProgram {
    package: String,
    /// Directory of the package; its tests are run there.
    dir: PathBuf,
    path: String,
}

impl TestProgram {
    /// Runs it in the directory of its package.
    fn command(&self) -> Command {
        let mut command = Command::new(&self.path);
        command.current_dir(&self.dir).arg("--show-output");
        command
    }

    /// From one of cargo's messages in JSON; `None` for any other message, and for programs that are built but are no tests.
    fn of(line: &str) -> Option<Self> {
        let text = |key: &str| {
            let (_, rest) = line.split_once(&format!("\"{key}\":\""))?;
            rest.split_once('"').map(|(value, _)| value)
        };
        let path = text("executable").filter(|_| line.contains("\"test\":true},\"features\":"))?;
        let dir = Path::new(text("manifest_path")?).parent()?.to_owned();
        // `path+file:///line#linewright-line@0.1.0`, without the name where the directory has it.
        let (place, named) = text("package_id")?.split_once('#')?;
        let package = named.split_once('@').map_or(place.rsplit('/').next()?, |(name, _)| name);
        Some(TestProgram { package: package.to_owned(), dir, path: path.to_owned() })
    }
}

fn format_and_rules(root: &Path, tally: &mut TestTally) {
    one(tally, "format", cargo(root, &["fmt", "--all", "--check"]));
    heading("house rules");
    if tidy::run(root) { tally.passed += 1 } else { tally.failed += 1 }
}

/// `typos`, with the words of `typos.toml`.
fn spelling(root: &Path, setup: &Setup, tally: &mut TestTally) {
    match setup.program("typos") {
        Some(typos) => {
            let mut command = Command::new(typos);
            command.current_dir(root).args(["--format", "brief"]);
            one(tally, "spelling", command);
        }
        None => tally.skip("SKIPPED spelling: there is no `typos`; see the set-up"),
    }
}

/// Licences, second versions and sources of packages, by `deny.toml`. Advisories change by the day, without a change here: they
/// are for `cargo deny check`.
fn dependencies(root: &Path, tally: &mut TestTally) {
    let is_installed = lines(cargo(root, &["deny", "--version"]), |_, _| {}).is_ok_and(|code| code == Some(0));
    if is_installed {
        let deny = ["deny", "--offline", "check", "--hide-inclusion-graph", "licenses", "bans", "sources"];
        one(tally, "dependencies", cargo(root, &deny));
    } else {
        tally.skip("SKIPPED licences and versions of dependencies: cargo install --locked cargo-deny");
    }
}

/// Every target, benches by name: `--all-targets` would check each library once more, as one that may have benches inside.
fn lints(root: &Path, tally: &mut TestTally) {
    let targets = ["--lib", "--bins", "--tests", "--examples", "--bench", "*"];
    let mut clippy = cargo(root, &["clippy", "--workspace"]);
    clippy.args(targets).args(["--keep-going", "--quiet", "--", "-D", "warnings"]);
    one(tally, "lints", clippy);
}

/// Builds all tests; what does not build is counted when they are run. Gives cargo's lines that name the programs.
fn build(root: &Path) -> Vec<String> {
    heading("build");
    let start = Instant::now();
    let mut programs = Vec::new();
    let ended = lines(cargo(root, &["test", "--workspace", "--no-run"]), |_, line| {
        if line.trim_start().starts_with("Executable ") {
            programs.push(line.to_owned());
        } else if !line.trim_start().starts_with("Compiling ") {
            println!("{line}");
        }
    });
    match ended {
        Ok(Some(0)) => println!("build: ok, {:.0?}", start.elapsed()),
        ended => println!("build: FAILED ({})", how(&ended)),
    }
    programs
}

/// A program that passes or fails as a whole.
fn one(tally: &mut TestTally, name: &str, command: Command) {
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

/// Cargo's tests, which are counted one by one.
fn tests(tally: &mut TestTally, command: Command) {
    heading("tests");
    let start = Instant::now();
    counted(tally, "tests", command, &[0], |line| println!("{line}"));
    println!("tests: {:.0?}", start.elapsed());
}

/// Programs whose tests are counted one by one. Gives the exit code; one that is not among these, without a test that failed,
/// counts as a failure: something did not build, or a program died.
fn counted(
    tally: &mut TestTally,
    name: &str,
    command: Command,
    good: &[i32],
    mut show: impl FnMut(&str),
) -> Option<i32> {
    let failed_before = tally.failed;
    let ended = lines(command, |stream, line| {
        if tally.read(stream, line) {
            show(line);
        }
    });
    let code = ended.as_ref().ok().copied().flatten();
    if !code.is_some_and(|code| good.contains(&code)) && tally.failed == failed_before {
        tally.failed += 1;
        show(&format!("{name}: FAILED ({})", how(&ended)));
    }
    code
}

/// The tests that need real CAN sockets: the bus itself, SDO against Python's `canopen`, and whole programs.
const ON_VCAN: [&str; 3] = ["tests/vcan.rs", "tests/sdo_python.rs", "tests/real_bus/main.rs"];

/// The CAN tests on real sockets, in a kernel of their own where this one has no CAN.
fn vcan(root: &Path, programs: &[String], setup: &Setup, stage: &mut Stage) {
    if Path::new("/sys/class/net/vcan0").exists() {
        return;
    }
    for test in ON_VCAN {
        let start = Instant::now();
        stage.shown.push(format!("\n== CAN sockets in a user-mode Linux: {test}"));
        match programs.iter().find_map(|line| program_of(line, test)) {
            Some(program) => in_user_mode_linux(root, program, setup, stage),
            None => stage.tally.skip(&format!("SKIPPED {test} in a user-mode Linux: it was not built")),
        }
        stage.shown.push(format!("{test}: {:.0?}", start.elapsed()));
    }
}

/// It is given the program that has just been built: built by itself, the crate would have other features, and with them
/// most of its dependencies once more.
fn in_user_mode_linux(root: &Path, program: &str, setup: &Setup, Stage { shown, tally }: &mut Stage) {
    const SCRIPT: &str = "fieldbus/io/tests/vcan_uml.sh";
    let mut command = Command::new("sh");
    command.current_dir(root).args([SCRIPT, program]);
    setup.apply(&mut command);
    let code = counted(tally, SCRIPT, command, &[0, SKIPPED], |line| shown.push(line.to_owned()));
    if code == Some(SKIPPED) {
        tally.skip(&format!("SKIPPED {SCRIPT}: see above"));
    }
}

/// The program in a line like `  Executable tests/vcan.rs (target/debug/deps/vcan-0123)`.
fn program_of<'a>(line: &'a str, test: &str) -> Option<&'a str> {
    line.trim_start().strip_prefix("Executable ")?.strip_prefix(test)?.strip_prefix(" (")?.strip_suffix(')')
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
    use super::*;

    #[test]
    fn the_program_of_a_test_is_found_in_what_cargo_says() {
        let line = "  Executable tests/vcan.rs (target/debug/deps/vcan-0123)";
        assert_eq!(program_of(line, "tests/vcan.rs"), Some("target/debug/deps/vcan-0123"));
        assert_eq!(program_of(line, "tests/other.rs"), None);
    }

    #[test]
    fn test_programs_are_found_in_cargos_messages() {
        let message = |id: &str, test: bool, program: &str| {
            format!(
                "{{\"reason\":\"compiler-artifact\",\"package_id\":\"path+file:///w/{id}\",\"manifest_path\":\"/w/m/line/Cargo.toml\",\
                 \"target\":{{\"name\":\"all\",\"test\":true}},\"profile\":{{\"opt_level\":\"1\",\"test\":{test}}},\"features\":[],\
                 \"executable\":{program},\"fresh\":true}}"
            )
        };
        let found = |id, test, program| TestProgram::of(&message(id, test, program));
        let program = |package: &str| {
            let (package, dir, path) = (package.to_owned(), PathBuf::from("/w/m/line"), "/w/target/all-1".to_owned());
            Some(TestProgram { package, dir, path })
        };
        assert_eq!(found("m/line#linewright-line@0.1.0", true, "\"/w/target/all-1\""), program("linewright-line"));
        assert_eq!(found("xtask#0.1.0", true, "\"/w/target/all-1\""), program("xtask"));
        assert_eq!(found("m/line#linewright-line@0.1.0", false, "\"/w/target/all-1\""), None);
        assert_eq!(found("m/line#linewright-line@0.1.0", true, "null"), None);
    }
}
