//! Descriptions and command lines as no person would write them: an answer that can be used, whatever comes.
//!
//! Never a panic, never silence, never success for what was not done. Drawn from fixed seeds, so a failure is repeated by
//! running the test again.

use std::path::Path;
use std::process::Output;

use linewright_random::Random;

use crate::support::command::{Scratch, linewright, linewright_in, text};

/// Descriptions tried; a line and two cells in turn.
const DESCRIPTIONS: u64 = 120;
/// Command lines tried.
const COMMAND_LINES: u64 = 200;

/// Values that a key or an option may meet by mistake.
const VALUES: [&str; 16] = [
    "0",
    "-1",
    "1",
    "7",
    "3.5",
    "1e300",
    "9223372036854775808",
    "nan",
    "true",
    "\"\"",
    "\"ü\"",
    "[]",
    "{}",
    "\"x\"",
    "",
    "128",
];

fn described(line: &str, file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch-config/lines").join(line).join(file);
    std::fs::read_to_string(path).expect("the shipped descriptions are there")
}

/// One to three mistakes, as a hand or an editor makes them.
fn mistaken(original: &str, random: &mut Random) -> String {
    let mut lines: Vec<String> = original.lines().map(str::to_owned).collect();
    for _ in 0..1 + random.below(3) {
        let at = random.below(lines.len());
        let other = random.below(lines.len());
        match random.below(7) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(other, lines[at].clone()),
            2 => lines.swap(at, other),
            3 => {
                let value = *random.pick(&VALUES);
                if let Some((key, _)) = lines[at].clone().split_once('=') {
                    lines[at] = format!("{key}= {value}");
                }
            }
            4 => lines[at] = other_word(&lines[at], &lines[other], random),
            5 => {
                let chars: Vec<char> = lines[at].chars().collect();
                let cut = random.below(chars.len() + 1);
                lines[at] = chars.iter().enumerate().filter(|&(nth, _)| nth != cut).map(|(_, c)| c).collect();
            }
            _ => lines.truncate(lines.len() - random.below(lines.len() / 2)),
        }
    }
    lines.join("\n") + "\n"
}

/// A line with one of its words replaced by one of another line.
fn other_word(line: &str, from: &str, random: &mut Random) -> String {
    let words = |text: &str| -> Vec<String> {
        text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty()).map(str::to_owned).collect()
    };
    let (here, there) = (words(line), words(from));
    if here.is_empty() || there.is_empty() {
        return line.to_owned();
    }
    let (word, other) = (random.pick::<String>(&here), random.pick::<String>(&there));
    line.replacen(word, other, 1)
}

/// Ended by itself, with an exit code for success or failure, and a text.
fn assert_answered(output: &Output, about: &str) {
    let (said, error) = (text(&output.stdout), text(&output.stderr));
    let code = output.status.code();
    assert!(matches!(code, Some(0..=2)), "{about}: ended with {:?}: {error}", output.status);
    assert!(!error.contains("panicked") && !said.contains("panicked"), "{about}: {error}");
    let silent =
        if code == Some(0) { said.trim().is_empty() } else { error.trim().is_empty() && said.trim().is_empty() };
    assert!(!silent, "{about}: ended with {code:?}, silently");
}

#[test]
fn a_mistaken_description_is_answered_with_a_place() {
    let files = [
        ("line.toml", described("transfer-line", "line.toml"), None),
        (
            "cell.toml",
            described("workcell-c1", "cell.toml"),
            Some(("line.toml", described("workcell-c1", "line.toml"))),
        ),
        (
            "line.toml",
            described("assembly-cell", "line.toml"),
            Some(("cell.toml", described("assembly-cell", "cell.toml"))),
        ),
    ];
    let (mut refused, mut accepted) = (0, 0);
    for seed in 0..DESCRIPTIONS {
        let mut random = Random::new(seed);
        let (name, original, beside) = &files[usize::try_from(seed).expect("few") % files.len()];
        let scratch = Scratch::new();
        let mistaken = mistaken(original, &mut random);
        scratch.file(name, &mistaken);
        if let Some((name, text)) = beside {
            scratch.file(name, text);
        }
        let directory = scratch.path("");
        let checked = linewright(&["check", &directory, "--structure", "--json"]);
        let changed = mistaken.lines().filter(|line| !original.lines().any(|before| before == *line));
        let about = format!("seed {seed}:\n{}", changed.collect::<Vec<_>>().join("\n"));
        let found: serde_json::Value =
            serde_json::from_slice(&checked.stdout).unwrap_or_else(|error| panic!("{error}: {checked:?}\n{about}"));
        assert_eq!(found["ok"] == true, checked.status.success(), "{about}\n{found}");
        let failed =
            |checks: &serde_json::Value| checks.as_array().into_iter().flatten().any(|check| check["ok"] == false);
        if checked.status.success() {
            accepted += 1;
            continue;
        }
        refused += 1;
        let problems: Vec<_> = [&found["problems"], &found["cell"]["problems"]]
            .into_iter()
            .filter_map(|list| list.as_array())
            .flatten()
            .collect();
        let structural = failed(&found["line_checks"])
            || found["stations"].as_array().into_iter().flatten().any(|station| failed(&station["checks"]))
            || failed(&found["cell"]["checks"]);
        assert!(structural || !problems.is_empty(), "{about}\nnothing said to be wrong: {found}");
        for problem in &problems {
            let lines = u64::try_from(mistaken.lines().count().max(1_000)).expect("few");
            assert!(problem["line"].as_u64().is_some_and(|line| (1..=lines).contains(&line)), "{about}\n{problem}");
            assert!(problem["message"].as_str().is_some_and(|message| message.len() > 5), "{about}\n{problem}");
        }
        let shown = linewright(&["simulate", &directory]);
        assert_answered(&shown, &about);
        assert!(problems.is_empty() || !shown.status.success(), "{about}\nsimulated all the same");
    }
    println!("{refused} refused, {accepted} accepted");
    assert!(refused > 60 && accepted > 5, "{refused} refused, {accepted} accepted: too few of one kind to tell");
}

#[test]
fn a_mistaken_command_line_is_answered() {
    let scratch = Scratch::new();
    let here = [
        scratch.path("none"),
        scratch.file("empty.toml", ""),
        scratch.file("wrong.toml", "name = 7\n[["),
        scratch.file("text.txt", "\u{0}\u{1}ä"),
        scratch.path(""),
        scratch.path("none/deeper"),
    ];
    let commands = commands();
    let options: Vec<Vec<String>> = commands.iter().map(|command| options_of(command)).collect();
    let mut failed = 0;
    for seed in 0..COMMAND_LINES {
        let mut random = Random::new(1_000 + seed);
        let nth = random.below(commands.len());
        let mut args = vec![commands[nth].clone()];
        for _ in 0..random.below(5) {
            args.push(match random.below(6) {
                0 | 1 if !options[nth].is_empty() => random.pick(&options[nth]).clone(),
                0..=3 => random.pick(&here).clone(),
                4 => (*random.pick(&VALUES)).to_owned(),
                _ => random.pick(&commands).clone(),
            });
        }
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let output = linewright_in(&scratch.path(""), &args);
        assert_answered(&output, &format!("seed {seed}: {args:?}"));
        failed += u32::from(!output.status.success());
    }
    println!("{failed} of {COMMAND_LINES} refused");
    assert!(failed > 100, "{failed} of {COMMAND_LINES} refused: the others were hardly mistaken");
}

/// The subcommands, from the command's own help.
fn commands() -> Vec<String> {
    let help = linewright(&["--help"]);
    let list = text(&help.stdout).split_once("Commands:\n").expect("a list of commands").1;
    let list = list.split("\n\n").next().expect("the list ends");
    let names = list.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    // It listens until it is ended, whatever is on its bus.
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|&name| name != "candump");
    let names: Vec<String> = names.map(str::to_owned).collect();
    assert!(names.len() > 20, "{names:?}");
    names
}

fn options_of(command: &str) -> Vec<String> {
    let help = linewright(&[command, "--help"]);
    let words = text(&help.stdout).split_whitespace().filter(|word| word.starts_with("--") && word.len() > 3);
    words.map(|word| word.trim_matches(|c: char| !c.is_alphanumeric() && c != '-').to_owned()).collect()
}
