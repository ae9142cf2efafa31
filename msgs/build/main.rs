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
    let mut all = Interfaces::default();
    all.package(Path::new("."), PACKAGE)?;
    for dir in sorted(Path::new("standard"))? {
        all.package(&dir, &name_of(&dir))?;
    }
    let mut list = String::new();
    for (name, path) in &all.files {
        let (type_hash, path) = (all.types.hash(name)?, path.display());
        list += &format!(
            "    crate::Interface {{ name: {name:?}, type_hash: {type_hash:?}, definition: \
             include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{path}\")) }},\n"
        );
    }
    Ok(all.rust
        + &format!(
            "/// All interfaces, in the order of their packages and kinds.\npub const INTERFACES: &[crate::Interface] = &[\n{list}];\n"
        ))
}

/// What is read of all files.
#[derive(Default)]
struct Interfaces {
    rust: String,
    /// `package/kind/Name`, and the file.
    files: Vec<(String, PathBuf)>,
    types: generate::TypeDescriptions,
}

impl Interfaces {
    /// The interfaces below a directory, of which some kinds may be missing.
    fn package(&mut self, dir: &Path, package: &str) -> Result<(), String> {
        for kind in ["msg", "srv", "action"] {
            let of_kind = dir.join(kind);
            if !of_kind.is_dir() {
                continue;
            }
            for file in sorted(&of_kind)? {
                let at = |problem: String| format!("{}: {problem}", file.display());
                let read = fs::read_to_string(&file).map_err(|e| at(e.to_string()))?;
                self.rust += &generate::rust(package, &name_of(&file), &read, &mut self.types).map_err(at)?;
                let name = file.file_stem().unwrap_or_default().to_string_lossy();
                self.files.push((format!("{package}/{kind}/{name}"), file));
            }
        }
        Ok(())
    }
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
