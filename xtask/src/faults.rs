//! `cargo xtask faults`: the fault simulation, compiled for speed.

use std::path::Path;

use crate::part::{cargo, lines};

/// Plays seeds with these options; true if nothing was found.
pub fn run(root: &Path, args: &[&str]) -> bool {
    let mut all =
        vec!["run", "--profile", "faults", "--quiet", "--package", "linewright-faults", "--example", "faults", "--"];
    all.extend(args);
    matches!(lines(cargo(root, &all), |_, line| println!("{line}")), Ok(Some(0)))
}
