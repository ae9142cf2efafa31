//! Rules about crates: which way they depend on each other, what the pure ones do without, and that all share lints.

use std::collections::BTreeMap;
use std::path::Path;

use super::WorkspaceMember;
use crate::part::{Stream, cargo, lines};

/// Crates that decide and never act: called with the time and their inputs, they return outputs.
pub const PURE: [&str; 28] = [
    "linewright-random",
    "linewright-nets",
    "linewright-diagnostics",
    "linewright-text",
    "linewright-pnml",
    "linewright-eds",
    "linewright-line",
    "linewright-cell",
    "linewright-relations",
    "linewright-dbc",
    "linewright-orders",
    "linewright-parameters",
    "linewright-lifecycle",
    "linewright-station-logic",
    "linewright-station-shell",
    "linewright-coordinator-logic",
    "linewright-coordinator-cell",
    "linewright-coordinator-shell",
    "linewright-fieldbus-seam",
    "linewright-canopen",
    "linewright-modbus",
    "linewright-plant",
    "linewright-proof",
    "linewright-simulation",
    "linewright-recovery",
    "linewright-synthesis",
    "linewright-faults",
    "linewright-console-view",
];

/// Dependencies that neither they nor the messages may have, at any distance.
const IMPURE: [&str; 4] = ["ros2-client", "rustdds", "tokio", "socketcan"];

/// Words that the sources of a pure crate must not contain: clocks, threads that outlive a call, sockets, files, the
/// environment. `thread::scope` is allowed: what it starts has ended when the call returns.
const FORBIDDEN: [&str; 9] = [
    "Instant::now",
    "SystemTime",
    "thread::spawn",
    "thread::sleep",
    "std::net",
    "std::fs",
    "std::process",
    "std::env",
    "async fn",
];

/// For each crate, those of the workspace it may build on. Dependencies point one way; a new crate gets a row here.
const MAY_USE: [(&str, &[&str]); 45] = [
    ("linewright-random", &[]),
    ("linewright-nets", &[]),
    ("linewright-diagnostics", &[]),
    // For tests alone.
    ("linewright-cases", &["linewright-diagnostics"]),
    ("linewright-testkit", EVERYTHING),
    ("linewright-text", &["linewright-diagnostics"]),
    ("linewright-pnml", &["linewright-nets", "linewright-diagnostics"]),
    ("linewright-eds", &["linewright-diagnostics"]),
    ("linewright-line", &["linewright-nets", "linewright-text"]),
    ("linewright-cell", &["linewright-nets", "linewright-text", "linewright-line"]),
    ("linewright-relations", &["linewright-text"]),
    ("linewright-synthesis", &["linewright-relations"]),
    ("linewright-dbc", &["linewright-line"]),
    ("linewright-orders", &["linewright-line"]),
    ("linewright-parameters", &["linewright-diagnostics", "linewright-text"]),
    ("linewright-lifecycle", &[]),
    ("linewright-station-logic", &["linewright-line", "linewright-orders"]),
    (
        "linewright-station-shell",
        &["linewright-line", "linewright-parameters", "linewright-lifecycle", "linewright-station-logic"],
    ),
    (
        "linewright-coordinator-logic",
        &["linewright-random", "linewright-nets", "linewright-line", "linewright-lifecycle"],
    ),
    ("linewright-coordinator-cell", &["linewright-nets", "linewright-line", "linewright-orders", "linewright-cell"]),
    (
        "linewright-coordinator-shell",
        &[
            "linewright-line",
            "linewright-cell",
            "linewright-station-logic",
            // The choice of the newer of two messages is made once, there, and the parameters of all nodes are declared.
            "linewright-station-shell",
            "linewright-coordinator-logic",
            "linewright-coordinator-cell",
            "linewright-parameters",
            "linewright-lifecycle",
        ],
    ),
    ("linewright-history", &["linewright-line", "linewright-coordinator-cell"]),
    ("linewright-msgs", &[]),
    ("linewright-node-shell", &["linewright-msgs", "linewright-parameters", "linewright-lifecycle"]),
    ("linewright-fieldbus-seam", &["linewright-line"]),
    ("linewright-canopen", &["linewright-line", "linewright-fieldbus-seam"]),
    ("linewright-modbus", &["linewright-line", "linewright-fieldbus-seam"]),
    ("linewright-fieldbus", &["linewright-line", "linewright-fieldbus-seam", "linewright-canopen"]),
    (
        "linewright-modbus-tcp",
        // The clock of a process is in the last.
        &["linewright-line", "linewright-fieldbus-seam", "linewright-modbus", "linewright-fieldbus"],
    ),
    ("linewright-plant", &["linewright-random", "linewright-line", "linewright-canopen"]),
    ("linewright-racks", &["linewright-line", "linewright-canopen", "linewright-fieldbus", "linewright-plant"]),
    (
        "linewright-proof",
        &[
            "linewright-random",
            "linewright-nets",
            "linewright-line",
            "linewright-orders",
            "linewright-cell",
            "linewright-station-logic",
            "linewright-coordinator-logic",
            "linewright-coordinator-cell",
            // The conversion of a station's report for the token player is written once, there.
            "linewright-coordinator-shell",
        ],
    ),
    (
        "linewright-simulation",
        &[
            "linewright-random",
            "linewright-text",
            "linewright-line",
            "linewright-cell",
            "linewright-orders",
            "linewright-station-logic",
            "linewright-station-shell",
            "linewright-coordinator-logic",
            "linewright-coordinator-cell",
            "linewright-coordinator-shell",
            "linewright-canopen",
            "linewright-plant",
        ],
    ),
    (
        "linewright-recovery",
        &[
            "linewright-line",
            "linewright-station-logic",
            "linewright-coordinator-logic",
            // Which button an alarm names.
            "linewright-coordinator-cell",
            // The part of a station's report that the coordinator uses is chosen once, there.
            "linewright-coordinator-shell",
        ],
    ),
    (
        "linewright-faults",
        &[
            "linewright-line",
            "linewright-cell",
            "linewright-coordinator-cell",
            "linewright-station-logic",
            "linewright-station-shell",
            "linewright-coordinator-logic",
            "linewright-coordinator-shell",
            "linewright-plant",
            // Generated lines are made there.
            "linewright-proof",
            // The operator who follows the recovery plan.
            "linewright-recovery",
            "linewright-simulation",
        ],
    ),
    (
        "linewright-node-line",
        &[
            "linewright-line",
            "linewright-station-logic",
            // The checks of a node are values, there.
            "linewright-station-shell",
            "linewright-msgs",
            "linewright-node-shell",
            "linewright-fieldbus-seam",
            "linewright-fieldbus",
            "linewright-modbus-tcp",
        ],
    ),
    (
        "linewright-station-node",
        &[
            "linewright-line",
            "linewright-station-logic",
            "linewright-station-shell",
            "linewright-parameters",
            "linewright-lifecycle",
            "linewright-msgs",
            "linewright-node-shell",
            "linewright-node-line",
            "linewright-fieldbus-seam",
            "linewright-fieldbus",
        ],
    ),
    (
        "linewright-coordinator-node",
        &[
            "linewright-line",
            "linewright-orders",
            "linewright-cell",
            "linewright-coordinator-logic",
            "linewright-coordinator-cell",
            "linewright-coordinator-shell",
            "linewright-history",
            // The planned times of a line, for the comparison in a report, are computed there.
            "linewright-simulation",
            "linewright-station-shell",
            "linewright-parameters",
            "linewright-lifecycle",
            "linewright-msgs",
            "linewright-node-shell",
            "linewright-node-line",
            "linewright-fieldbus-seam",
            "linewright-fieldbus",
        ],
    ),
    (
        "linewright-console-view",
        &[
            "linewright-line",
            // Which wait of a station is no obstacle.
            "linewright-station-logic",
            // The commands.
            "linewright-coordinator-logic",
            // Answers to an alarm, as operators read them.
            "linewright-coordinator-cell",
            "linewright-msgs",
            // The next step of a plan.
            "linewright-recovery",
        ],
    ),
    // It serves pages, and does not know what they are about.
    ("linewright-console-server", &["linewright-console-view"]),
    ("linewright", EVERYTHING),
    ("linewright-tests", EVERYTHING),
    ("linewright-examples", EVERYTHING),
    ("linewright-fuzz", EVERYTHING),
    ("xtask", &[]),
];

/// Everything but [`TOPS`].
const EVERYTHING: &[&str] = &["*"];

/// Tests may use crates above them, but nothing of any kind builds on these.
const TOPS: [&str; 5] = ["linewright", "linewright-tests", "linewright-examples", "linewright-fuzz", "xtask"];

/// Checks every crate.
pub fn check(root: &Path, members: &[WorkspaceMember]) -> Vec<String> {
    let mut findings = Vec::new();
    let read = |name: &str| std::fs::read_to_string(root.join(name)).unwrap_or_default();
    findings.extend(minimum_version(&read("Cargo.toml"), &read("rust-toolchain.toml")));
    let names: Vec<&str> = members.iter().map(|m| m.name.as_str()).collect();
    let builds_on = direct(root, "normal").unwrap_or_else(|error| noted(error, &mut findings));
    let has_in_tests = direct(root, "normal,dev,build").unwrap_or_else(|error| noted(error, &mut findings));
    for member in members {
        if !inherits_lints(&member.manifest) {
            findings.push(format!("{}: does not inherit the lints; add `[lints] workspace = true`", member.name));
        }
        if let Some(direct) = builds_on.get(&member.name) {
            findings.extend(direction(&member.name, direct, &names));
        }
        if let Some(direct) = has_in_tests.get(&member.name) {
            findings.extend(tops(&member.name, direct));
        }
        let is_pure = PURE.contains(&member.name.as_str());
        if is_pure || member.name == "linewright-msgs" {
            // By itself: beside others it might have features that it does not request.
            match tree(root, &["--package", &member.name, "--edges", "normal", "--prefix", "none"]) {
                Ok(all) => findings.extend(purity(&member.name, &all[1..])),
                Err(error) => findings.push(error),
            }
        }
        if is_pure {
            sources(root, &member.dir.join("src"), &mut findings);
        }
    }
    findings
}

fn noted(error: String, findings: &mut Vec<String>) -> BTreeMap<String, Vec<String>> {
    findings.push(error);
    BTreeMap::new()
}

/// Direct dependencies of each crate of the workspace, by edges of these kinds.
fn direct(root: &Path, edges: &str) -> Result<BTreeMap<String, Vec<String>>, String> {
    let lines = tree(root, &["--workspace", "--edges", edges, "--prefix", "depth", "--depth", "1", "--no-dedupe"])?;
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut of = String::new();
    for line in lines {
        match line.split_at_checked(1) {
            Some(("0", name)) => {
                all.insert(name.to_owned(), Vec::new());
                of = name.to_owned();
            }
            Some((_, name)) => all.entry(of.clone()).or_default().push(name.to_owned()),
            None => {}
        }
    }
    Ok(all)
}

/// The names in a tree of dependencies, after what stands before each.
fn tree(root: &Path, args: &[&str]) -> Result<Vec<String>, String> {
    let mut all = vec!["tree", "--quiet", "--format", "{p}"];
    all.extend(args);
    let (mut found, mut said) = (Vec::new(), String::new());
    let ended = lines(cargo(root, &all), |stream, line| match stream {
        Stream::Out => found.extend(line.split(' ').next().filter(|word| !word.is_empty()).map(str::to_owned)),
        Stream::Err => said = line.to_owned(),
    });
    match ended {
        Ok(Some(0)) if !found.is_empty() => {
            found.retain(|found| !found.starts_with('['));
            Ok(found)
        }
        _ => Err(format!("cargo tree {} failed: {said}", args.join(" "))),
    }
}

fn direction(name: &str, direct: &[String], members: &[&str]) -> Vec<String> {
    let Some((_, may)) = MAY_USE.iter().find(|(known, _)| *known == name) else {
        return vec![format!("{name}: is new; say in xtask/src/tidy/crates.rs what it may build on")];
    };
    if *may == EVERYTHING {
        return Vec::new();
    }
    let ours = direct.iter().filter(|dep| members.contains(&dep.as_str()));
    let mut findings: Vec<String> =
        ours.filter(|dep| !may.contains(&dep.as_str())).map(|dep| format!("{name}: must not build on {dep}")).collect();
    let unused = may.iter().filter(|dep| !direct.iter().any(|used| used == *dep));
    findings.extend(unused.map(|dep| format!("{name}: may build on {dep} and does not; take that edge off the table")));
    findings
}

fn tops(name: &str, direct: &[String]) -> Vec<String> {
    let found = direct.iter().filter(|dep| TOPS.contains(&dep.as_str()));
    found.map(|dep| format!("{name}: builds on {dep}, which nothing does")).collect()
}

fn purity(name: &str, all: &[String]) -> Vec<String> {
    let found = all.iter().filter(|dep| IMPURE.contains(&dep.as_str()));
    found.map(|dep| format!("{name}: is pure and must do without {dep}; see `cargo tree -i {dep} -p {name}`")).collect()
}

/// The declared minimum version is the one that builds and tests here; any other would be a claim without a check.
fn minimum_version(workspace: &str, toolchain: &str) -> Option<String> {
    let value = |text: &str, key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"'));
        line.unwrap_or("nothing").to_owned()
    };
    let (declared, used) = (value(workspace, "rust-version"), value(toolchain, "channel"));
    let is_same = used.rsplit_once('.').is_some_and(|(minor, _)| minor == declared);
    (!is_same).then(|| {
        format!("Cargo.toml: rust-version is {declared}, rust-toolchain.toml has {used}; make them the same version")
    })
}

fn inherits_lints(manifest: &str) -> bool {
    let mut lines = manifest.lines().map(str::trim).skip_while(|line| *line != "[lints]").skip(1);
    lines.find(|line| !line.is_empty()) == Some("workspace = true")
}

fn sources(root: &Path, dir: &Path, findings: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            sources(root, &path, findings);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().into_owned();
            findings.extend(pure_source(&name, &text));
        }
    }
}

fn pure_source(name: &str, text: &str) -> Vec<String> {
    let code = text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"));
    code.filter_map(|(index, line)| {
        let word = FORBIDDEN.iter().find(|word| line.contains(**word))?;
        Some(format!("{name}:{}: `{word}` in a pure crate; take it as an argument", index + 1))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(names: &[&str]) -> Vec<String> {
        names.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_dependency_against_the_direction_is_found() {
        let members = ["linewright-nets", "linewright-line", "linewright-extra"];
        let line = ["linewright-nets", "linewright-text", "miette"];
        assert!(direction("linewright-line", &list(&line), &members).is_empty());
        let unused = direction("linewright-line", &list(&line[1..]), &members);
        assert!(unused.len() == 1 && unused[0].contains("does not"), "{unused:?}");
        assert_eq!(
            direction("linewright-nets", &list(&["linewright-line"]), &members),
            ["linewright-nets: must not build on linewright-line"]
        );
        assert!(direction("linewright-extra", &[], &members)[0].contains("is new"));
        assert_eq!(tops("linewright-plant", &list(&["linewright"])).len(), 1);
    }

    #[test]
    fn a_minimum_version_that_is_not_built_is_found() {
        let finding = |declared: &str| minimum_version(declared, "[toolchain]\nchannel = \"1.95.0\"\n");
        assert_eq!(finding("rust-version = \"1.95\""), None);
        assert!(finding("rust-version = \"1.89\"").is_some_and(|finding| finding.contains("1.89")));
        assert!(finding("").is_some());
    }

    #[test]
    fn the_rows_point_one_way() {
        let row = |name: &str| MAY_USE.iter().position(|(known, _)| *known == name);
        for (index, (name, may)) in MAY_USE.iter().enumerate() {
            for dep in may.iter().filter(|_| *may != EVERYTHING) {
                assert!(row(dep).is_some_and(|at| at < index), "{name} may use {dep}, which comes after it");
            }
        }
    }

    #[test]
    fn a_socket_in_a_pure_crate_is_found_at_any_distance() {
        assert_eq!(purity("linewright-nets", &list(&["petgraph", "tokio"])).len(), 1);
        assert!(purity("linewright-nets", &list(&["petgraph"])).is_empty());
    }

    #[test]
    fn a_clock_in_a_pure_source_is_found_but_may_be_spoken_of() {
        let text = "//! No `Instant::now` here.\nlet t = Instant::now();\n";
        assert_eq!(pure_source("a.rs", text), ["a.rs:2: `Instant::now` in a pure crate; take it as an argument"]);
    }

    #[test]
    fn lints_are_inherited_or_not() {
        assert!(inherits_lints("[package]\n\n[lints]\nworkspace = true\n"));
        assert!(!inherits_lints("[package]\nname = \"a\"\n"));
        assert!(!inherits_lints("[lints.rust]\nworkspace = true\n"));
    }
}
