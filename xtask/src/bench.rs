//! `cargo xtask bench`: every benchmark of the workspace, and none of the tests that `cargo bench` would also start.

use std::path::Path;

use crate::part::{cargo, lines};
use crate::tidy;

/// Runs all benchmarks with the arguments given; true if they ran.
pub fn run(root: &Path, args: &[&str]) -> bool {
    let with_benches: Vec<String> =
        tidy::members(root).into_iter().filter(|member| member.dir.join("benches").is_dir()).map(|m| m.name).collect();
    if with_benches.is_empty() {
        println!("there are no benchmarks yet");
        return true;
    }
    let mut all = vec!["bench"];
    all.extend(with_benches.iter().flat_map(|name| ["--package", name.as_str()]));
    // Libraries and programs would bring their unit tests along, which refuse a benchmark's arguments.
    all.extend(["--bench", "*", "--"]);
    all.extend(args);
    matches!(lines(cargo(root, &all), |_, line| println!("{line}")), Ok(Some(0)))
}
