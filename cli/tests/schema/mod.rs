//! Schemas of the descriptions, completions, manual pages and the version: what the program writes about itself.

mod foreign;
mod mutants;

use std::path::{Path, PathBuf};

use crate::support::command::{Scratch, linewright, text};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the workspace")
}

/// The checked-in schema of a description: "line", "cell", "relations" or "scenario".
fn schema(of: &str) -> String {
    std::fs::read_to_string(root().join(format!("docs/schema/{of}.json"))).expect("a schema")
}

/// The shipped descriptions, each with "line", "cell" or, of a cell, "scenario".
fn shipped() -> Vec<(&'static str, PathBuf)> {
    let lines = std::fs::read_dir(root().join("launch-config/lines")).expect("lines are shipped");
    let mut found: Vec<(&str, PathBuf)> = lines
        .flat_map(|line| {
            let dir = line.expect("a directory").path();
            let scenario = ("scenario", dir.join("scenarios/production.toml"));
            ["line", "cell"].map(|of| (of, dir.join(format!("{of}.toml")))).into_iter().chain([scenario])
        })
        .filter(|(_, file)| file.is_file())
        .collect();
    found.sort();
    assert!(found.len() >= 6, "{found:?}");
    found
}

#[test]
fn schemas_are_as_the_readers_have_it() {
    for of in ["line", "cell", "relations", "scenario"] {
        let output = linewright(&["schema", of]);
        assert!(output.status.success(), "{output:?}");
        let advice = format!("linewright schema {of} > docs/schema/{of}.json");
        assert!(
            text(&output.stdout) == schema(of),
            "docs/schema/{of}.json is not what the reader reads; run:  {advice}"
        );
    }
}

#[test]
fn shipped_descriptions_name_their_schema() {
    let relations = ("relations", root().join("launch-config/lines/two-robot-cell/relations.toml"));
    for (of, file) in shipped().into_iter().chain([relations]) {
        let text = std::fs::read_to_string(&file).expect("a description");
        let path =
            text.lines().next().and_then(|line| line.strip_prefix("#:schema ")).expect("it begins with its schema");
        let found = file.parent().expect("a directory").join(path).canonicalize();
        assert_eq!(found.ok(), Some(root().join(format!("docs/schema/{of}.json"))), "{}", file.display());
    }
}

#[test]
fn every_subcommand_is_completed_and_has_its_page() {
    let help = linewright(&["--help"]);
    // The description of a command may go on in further lines, which are indented more.
    let lines = text(&help.stdout).lines().skip_while(|line| *line != "Commands:").skip(1);
    let commands = lines.take_while(|line| !line.is_empty()).filter_map(|line| line.strip_prefix("  "));
    let commands: Vec<&str> =
        commands.filter_map(|line| line.split(' ').next().filter(|word| !word.is_empty())).collect();
    assert!(commands.contains(&"check") && commands.contains(&"completions"), "{commands:?}");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = linewright(&["completions", shell]);
        assert!(output.status.success(), "{output:?}");
        let script = text(&output.stdout);
        assert!(commands.iter().all(|command| script.contains(command)), "{shell}");
    }
    let scratch = Scratch::new();
    let output = linewright(&["man", &scratch.path("man1")]);
    assert!(output.status.success(), "{output:?}");
    for command in commands.iter().filter(|command| **command != "help") {
        let page = scratch.read(&format!("man1/linewright-{command}.1"));
        assert!(page.contains(".SH SYNOPSIS") && page.contains(".SH OPTIONS"), "{page}");
    }
    assert!(scratch.read("man1/linewright.1").contains("linewright\\-check(1)"));
}

#[test]
fn the_version_names_the_build() {
    let output = linewright(&["--version"]);
    let version = concat!("linewright ", env!("CARGO_PKG_VERSION"), " (");
    let said = text(&output.stdout).trim_end();
    let built = said.strip_prefix(version).and_then(|rest| rest.strip_suffix(')')).unwrap_or_else(|| panic!("{said}"));
    match cfg!(debug_assertions) {
        true => assert_eq!(built, "development build"),
        false => assert_ne!(built, "development build"),
    }
}
