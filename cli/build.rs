//! Text of `linewright --version`: the version, and of a release build the commit it was built from.
//!
//! A development build does not name its commit: it would have to be linked anew after each one.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let built = match env::var("PROFILE").as_deref() {
        Ok("release") => commit().unwrap_or_else(|| "commit unknown".to_owned()),
        _ => "development build".to_owned(),
    };
    println!("cargo::rustc-env=LINEWRIGHT_VERSION={version} ({built})");
}

/// The commit and its day; `None` without git, and for sources that are no repository of their own.
fn commit() -> Option<String> {
    let root = Path::new(&env::var_os("CARGO_MANIFEST_DIR")?).parent()?.canonicalize().ok()?;
    if Path::new(&git(&["rev-parse", "--show-toplevel"])?).canonicalize().ok()? != root {
        return None;
    }
    for file in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--path-format=absolute", "--git-path", file])?;
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    git(&["log", "-1", "--format=%h, %cs"])
}

fn git(args: &[&str]) -> Option<String> {
    let output = Command::new("git").args(args).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
