//! `cargo xtask fuzz`: a fuzz target for so many seconds, with its seeds and its dictionary.
//!
//! Slow and never finished, so it is no part of `cargo xtask test`. It needs the nightly toolchain and `cargo-fuzz`.

use std::path::Path;
use std::process::Command;

use crate::part::lines;

/// The fuzz targets, with the directories that their seeds are in besides `fuzz/seeds`.
const TARGETS: [(&str, &[&str]); 8] = [
    ("description", &["model/line/tests/descriptions", "launch-config/lines/transfer-line"]),
    ("cell", &["launch-config/lines/workcell-c1", "launch-config/lines/assembly-cell"]),
    ("pnml", &[]),
    ("eds", &["model/eds/tests/devices", "launch-config/devices"]),
    ("dbc", &[]),
    ("parameters", &[]),
    ("sdo", &[]),
    ("frames", &[]),
];

/// Runs one target; true if nothing was found.
pub fn run(root: &Path, target: &str, seconds: &str) -> bool {
    let Some((_, seeds)) = TARGETS.iter().find(|(known, _)| *known == target) else {
        eprintln!("there is no fuzz target {target}; there is {}", TARGETS.map(|(name, _)| name).join(", "));
        return false;
    };
    if seconds.parse::<u32>().is_err() {
        eprintln!("{seconds} is no number of seconds");
        return false;
    }
    let corpus = format!("fuzz/corpus/{target}");
    if let Err(error) = std::fs::create_dir_all(root.join(&corpus)) {
        eprintln!("cannot make {corpus}: {error}");
        return false;
    }
    // Not the cargo that started this, which is the pinned toolchain's.
    let mut command = Command::new("rustup");
    command.current_dir(root).args(["run", "nightly", "cargo", "fuzz", "run", "--features", "engine", target]);
    // The places in a report of what was found.
    command.env("CARGO_PROFILE_RELEASE_DEBUG", "line-tables-only");
    command.arg(corpus).arg(format!("fuzz/seeds/{target}")).args(*seeds);
    command.args(["--", "-rss_limit_mb=2048", "-timeout=10", "-max_len=16384", "-print_final_stats=1"]);
    command.arg(format!("-max_total_time={seconds}")).arg(format!("-dict=fuzz/dictionaries/{target}.dict"));
    match lines(command, |_, line| println!("{line}")) {
        Ok(code) => code == Some(0),
        Err(error) => {
            eprintln!("cannot start rustup: {error}; it brings the nightly toolchain that fuzzing needs");
            false
        }
    }
}
