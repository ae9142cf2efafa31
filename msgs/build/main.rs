//! Writes the Rust types of all interfaces: `.msg`, `.srv` and `.action` files in, one file of Rust text out.
//!
//! Our own interfaces stand in `msg/`, `srv/` and `action/`, those of other ROS 2 packages in `standard/<package>/`.

mod generate;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Package of the interfaces that stand beside this script.
const PACKAGE: &str = "linewright_msgs";

fn main() -> ExitCode {
    for dir in ["build", "msg", "srv", "action", "standard"] {
        println!("cargo::rerun-if-changed={dir}");
    }
    match all().and_then(|text| fs::write(out(), text).map_err(|e| format!("{}: {e}", out().display()))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}

fn out() -> PathBuf {
    PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default()).join("interfaces.rs")
}

fn all() -> Result<String, String> {
    let mut text = package(Path::new("."), PACKAGE)?;
    for dir in sorted(Path::new("standard"))? {
        text += &package(&dir, &name_of(&dir))?;
    }
    Ok(text)
}

/// The interfaces below a directory, of which some kinds may be missing.
fn package(dir: &Path, package: &str) -> Result<String, String> {
    let mut text = String::new();
    for kind in ["msg", "srv", "action"].map(|kind| dir.join(kind)).iter().filter(|dir| dir.is_dir()) {
        for file in sorted(kind)? {
            let path = file.display();
            let read = fs::read_to_string(&file).map_err(|e| format!("{path}: {e}"))?;
            text += &generate::rust(package, &name_of(&file), &read).map_err(|problem| format!("{path}: {problem}"))?;
        }
    }
    Ok(text)
}

/// Content of a directory, in the order of names: the same text on every machine.
fn sorted(dir: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(dir).map_err(|e| format!("{}: {e}", dir.display()))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
