//! The project's own commands: `cargo xtask test`, `set-up`, `tidy`, `bench`, `faults`, `fuzz`.
//!
//! They only start programs that could be started by hand, in the right order, and add up their results. Nothing here
//! is needed to build or to run a line, and there is nothing outside the standard library to download for it.

mod bench;
mod faults;
mod fuzz;
mod part;
mod setup;
mod suite;
mod tally;
mod tidy;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask COMMAND

  test [--quick]     format, house rules, spelling, lints, all tests, documentation; ends with `N passed, N failed`
                     --quick: of the tests only short ones that need no socket, process or clock; no documentation
                     fetches first what tests need of the machine: CAN sockets, foreign stacks (see set-up)
  test --long        the long tests alone, optimised, with four times the cases that each states; LINEWRIGHT_CASES is that in percent
  set-up             that alone: Debian packages, as root; Python packages, below the target directory
  tidy               the house rules alone
  bench [FILTER]...  every benchmark; what follows goes to the benchmarks
  faults [OPTION]... whole lines under faults, from seeds: --seeds N, --from S, --shard I/N, --shrink, --mutants
  fuzz TARGET SECS   a target of fuzz/README.md: inputs that nobody would write (nightly toolchain, cargo install cargo-fuzz)";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let root = root();
    let good = match words[..] {
        ["test"] => suite::run(&root, suite::Extent::Everything),
        ["test", "--quick"] => suite::run(&root, suite::Extent::Quick),
        ["test", "--long"] => suite::run(&root, suite::Extent::Long),
        ["set-up"] => {
            let setup = setup::run(&root);
            setup.missing.iter().for_each(|missing| println!("set-up: {missing}"));
            setup.missing.is_empty()
        }
        ["tidy"] => tidy::run(&root),
        ["bench", ref rest @ ..] => bench::run(&root, rest),
        ["faults", ref rest @ ..] => faults::run(&root, rest),
        ["fuzz", target, seconds] => fuzz::run(&root, target, seconds),
        ["help" | "-h" | "--help"] => {
            println!("{USAGE}");
            true
        }
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The workspace: the directory above this crate's, or the current one if cargo did not start us.
fn root() -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR")
        .and_then(|crate_dir| Path::new(&crate_dir).parent().map(Path::to_owned))
        .unwrap_or_else(|| PathBuf::from("."))
}
