//! Rules about documents: every path that they name exists, and the README names every crate.

use std::fs;
use std::path::Path;

use super::WorkspaceMember;

/// Documents whose paths are checked; of `docs/decisions` every page.
const DOCUMENTS: [&str; 2] = ["CONTRIBUTING.md", "ARCHITECTURE.md"];

/// Checks every document.
pub fn check(root: &Path, members: &[WorkspaceMember]) -> Vec<String> {
    let decisions = fs::read_dir(root.join("docs/decisions")).into_iter().flatten().flatten().map(|entry| entry.path());
    let documents = DOCUMENTS.iter().map(|name| root.join(name)).chain(decisions);
    let mut findings = Vec::new();
    for path in documents {
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().into_owned();
        let Ok(text) = fs::read_to_string(&path) else {
            findings.push(format!("{name}: cannot be read"));
            continue;
        };
        for (line, text) in text.lines().enumerate() {
            let gone = paths(text).filter(|named| !root.join(named).exists());
            findings.extend(gone.map(|named| format!("{name}:{}: there is no `{named}`", line + 1)));
        }
    }
    let readme = fs::read_to_string(root.join("README.md")).unwrap_or_default();
    for member in members {
        let dir = member.dir.strip_prefix(root).unwrap_or(&member.dir).display();
        if !readme.contains(&format!("`{dir}`")) {
            findings.push(format!("README.md: the table of crates does not name `{dir}`"));
        }
    }
    findings
}

/// Words in backticks that are paths of the project: a `/` in them, a letter first, and nothing but names.
fn paths(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2).filter(|word| {
        word.contains('/')
            && word.starts_with(|first: char| first.is_ascii_lowercase() || first == '.')
            && word.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c))
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn only_paths_of_the_project_are_looked_for() {
        let line = "1. `model/line/src/line.rs`: a variant of `Hand`; `~/state`, `cargo xtask test`, `a/**`";
        assert_eq!(super::paths(line).collect::<Vec<_>>(), ["model/line/src/line.rs"]);
    }
}
