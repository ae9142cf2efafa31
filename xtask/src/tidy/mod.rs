//! The house rules that a program can check: `cargo xtask tidy`, and part of `cargo xtask test`.
//!
//! A rule is a function from the sources to findings, and a finding names the remedy. Rules that need judgement are not
//! here.

mod crates;
mod documents;
mod files;
mod switched_off;
mod unused;

use std::path::{Path, PathBuf};

pub use crates::PURE;

/// A crate of the workspace.
#[derive(Clone, Debug)]
pub struct WorkspaceMember {
    /// Package name.
    pub name: String,
    /// Its directory.
    pub dir: PathBuf,
    /// The text of its manifest.
    pub manifest: String,
}

/// Checks all rules and prints the findings; true if there are none.
pub fn run(root: &Path) -> bool {
    let members = members(root);
    let mut findings = files::check(root);
    findings.extend(crates::check(root, &members));
    findings.extend(documents::check(root, &members));
    findings.extend(members.iter().flat_map(unused::check));
    findings.extend(members.iter().flat_map(switched_off::check));
    if members.is_empty() {
        findings.push("Cargo.toml: no members found; is this the workspace?".to_owned());
    }
    findings.iter().for_each(|finding| println!("tidy: {finding}"));
    match findings.len() {
        0 => println!("tidy: {} crates keep to the house rules", members.len()),
        n => println!("tidy: {n} findings"),
    }
    findings.is_empty()
}

/// The crates named in the workspace's manifest. One that cannot be read has an empty manifest, which breaks rules.
pub fn members(root: &Path) -> Vec<WorkspaceMember> {
    let text = std::fs::read_to_string(root.join("Cargo.toml")).unwrap_or_default();
    let list = text.split_once("\nmembers = [").and_then(|(_, rest)| rest.split_once(']')).map_or("", |(list, _)| list);
    let member = |dir: &str| {
        let manifest = std::fs::read_to_string(root.join(dir).join("Cargo.toml")).unwrap_or_default();
        let name = manifest.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'));
        WorkspaceMember { name: name.unwrap_or(dir).to_owned(), dir: root.join(dir), manifest }
    };
    list.split('"').skip(1).step_by(2).map(member).collect()
}
