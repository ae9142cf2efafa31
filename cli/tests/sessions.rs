//! The console sessions in README and `docs/`: every block ```` ```console ```` is typed and its output compared.
//!
//! The blocks of one file are one session, in a directory of its own in which `launch-config` is found. A line that begins
//! with `$ ` is a command; what follows is its whole output, errors included. Of it `...` alone on a line stands for any
//! lines, and `[..]` for any text within a line. A block ```` ```toml FILE ```` is written into that file. A block that needs a
//! running line is ```` ```console running ````, and not typed here.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::command::Scratch;
use crate::support::turn::beside_no_rig;

/// Something that a reader of a document does, in this order.
enum Step {
    /// Writes a file.
    Write { file: String, text: String },
    /// Types a command, and sees its output.
    Type { line: usize, command: String, output: Vec<String> },
}

#[test]
fn what_documents_show_of_the_command_is_what_it_prints() {
    let mut wrong = String::new();
    let mut typed = 0;
    for document in documents() {
        let text = std::fs::read_to_string(&document).expect("a document");
        let scratch = Scratch::new();
        let launch_config = root().join("launch-config");
        std::os::unix::fs::symlink(launch_config, scratch.path("launch-config")).expect("a link");
        for step in steps(&text) {
            match step {
                Step::Write { file, text } => {
                    let path = PathBuf::from(scratch.path(&file));
                    std::fs::create_dir_all(path.parent().expect("a directory")).expect("a directory");
                    std::fs::write(path, text).expect("a file");
                }
                Step::Type { line, command, output } => {
                    typed += 1;
                    let printed = typed_in(&scratch.path("."), &command);
                    if !is_matched(&output, &printed) {
                        let place = format!("{}:{line}", document.display());
                        let _ = writeln!(wrong, "{place}: `{command}` prints\n{}", printed.join("\n"));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    assert!(typed >= 18, "only {typed} commands were found");
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace")
}

fn documents() -> Vec<PathBuf> {
    let mut all = vec![root().join("README.md")];
    let mut dirs = vec![root().join("docs")];
    while let Some(dir) = dirs.pop() {
        for entry in std::fs::read_dir(&dir).expect("a directory").map(|entry| entry.expect("an entry").path()) {
            match entry.is_dir() {
                true => dirs.push(entry),
                false => all.extend(entry.extension().is_some_and(|kind| kind == "md").then_some(entry)),
            }
        }
    }
    all.sort();
    all
}

fn steps(document: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut lines = document.lines().enumerate();
    while let Some((_, line)) = lines.next() {
        let block = lines.by_ref().take_while(|(_, line)| *line != "```");
        if line == "```console" {
            for (index, line) in block {
                match (line.strip_prefix("$ "), steps.last_mut()) {
                    (Some(command), _) => {
                        steps.push(Step::Type { line: index + 1, command: command.to_owned(), output: Vec::new() });
                    }
                    (None, Some(Step::Type { output, .. })) => output.push(line.to_owned()),
                    (None, _) => panic!("line {}: an output before any command: {line}", index + 1),
                }
            }
        } else if let Some(file) = line.strip_prefix("```toml ") {
            let text = block.map(|(_, line)| format!("{line}\n")).collect();
            steps.push(Step::Write { file: file.to_owned(), text });
        }
    }
    steps
}

/// Both outputs of a command, as a terminal shows them, without blanks at the ends of lines.
fn typed_in(dir: &str, command: &str) -> Vec<String> {
    let _no_rig = beside_no_rig();
    let programs = Path::new(env!("CARGO_BIN_EXE_linewright")).parent().expect("its directory");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    let script = format!("exec 2>&1\n{command}");
    let output = Command::new("sh").args(["-c", &script]).current_dir(dir).env("PATH", path).output().expect("a shell");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    printed.trim_end().lines().map(|line| line.trim_end().to_owned()).collect()
}

fn is_matched(shown: &[String], printed: &[String]) -> bool {
    match shown {
        [] => printed.is_empty(),
        [all, rest @ ..] if all == "..." => (0..=printed.len()).any(|skipped| is_matched(rest, &printed[skipped..])),
        [line, rest @ ..] => match printed {
            [first, others @ ..] => is_line_matched(line.trim_end(), first) && is_matched(rest, others),
            [] => rest.is_empty() && line.is_empty(),
        },
    }
}

fn is_line_matched(shown: &str, printed: &str) -> bool {
    match shown.split_once("[..]") {
        None => shown == printed,
        Some((before, after)) => printed.strip_prefix(before).is_some_and(|rest| {
            let ends = rest.char_indices().map(|(at, _)| at).chain([rest.len()]);
            ends.into_iter().any(|at| is_line_matched(after, &rest[at..]))
        }),
    }
}

#[test]
fn another_output_is_noticed() {
    let lines = |text: &str| -> Vec<String> { text.lines().map(str::to_owned).collect() };
    let is_matched = |shown: &str, printed: &str| is_matched(&lines(shown), &lines(printed));
    assert!(is_matched("a\n...\nz", "a\nb\nc\nz"));
    assert!(is_matched("done in [..] s, [..]", "done in 1.5 s, well"));
    assert!(!is_matched("a\n...\nz", "a\nb\nc"));
    assert!(!is_matched("done in [..] s", "done in 1.5 min"));
    assert!(!is_matched("a", "a\nb"));
    assert!(!is_matched("a\nb", "a"));
}
