//! Dependencies that no source mentions: built for nothing.

use std::path::Path;

use super::WorkspaceMember;

/// Checks one crate's manifest against its sources.
pub fn check(member: &WorkspaceMember) -> Vec<String> {
    // Fuzz targets are programs, in the directory where cargo-fuzz looks for them.
    let product = ["src", "fuzz_targets"].map(|dir| sources(&member.dir.join(dir))).concat();
    let tests: String = ["tests", "benches", "examples"].map(|dir| sources(&member.dir.join(dir))).concat();
    let build = sources(&member.dir.join("build"));
    let mut findings = named(&member.name, &member.manifest, "[dependencies]", &product);
    findings.extend(named(&member.name, &member.manifest, "[build-dependencies]", &build));
    // What a build script does is tested as a module of the tests.
    findings.extend(named(&member.name, &member.manifest, "[dev-dependencies]", &(product + &tests + &build)));
    findings
}

fn named(name: &str, manifest: &str, section: &str, text: &str) -> Vec<String> {
    let unused = dependencies(manifest, section).filter(|dep| !mentions(text, &dep.replace('-', "_")));
    unused.map(|dep| format!("{name}: {dep} in {section} is used nowhere; take it off")).collect()
}

/// The names in one section: what stands before the first dot, blank or equals sign of a line.
fn dependencies<'a>(manifest: &'a str, section: &str) -> impl Iterator<Item = &'a str> {
    let lines = manifest.lines().skip_while(move |line| *line != section).skip(1);
    lines.take_while(|line| !line.starts_with('[')).filter_map(|line| {
        let name = line.split(['.', ' ', '=']).next().unwrap_or_default();
        (!name.is_empty() && !name.starts_with('#')).then_some(name)
    })
}

/// Whether the word stands there as a whole.
fn mentions(text: &str, word: &str) -> bool {
    let is_part = |glyph: char| glyph == '_' || glyph.is_alphanumeric();
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back().is_some_and(is_part);
        let after = text[at + word.len()..].chars().next().is_some_and(is_part);
        !before && !after
    })
}

/// All Rust sources below a directory, one after the other.
pub fn sources(dir: &Path) -> String {
    let Ok(entries) = std::fs::read_dir(dir) else { return String::new() };
    let one = |path: std::path::PathBuf| match path.is_dir() {
        true => sources(&path),
        false if path.extension().is_some_and(|kind| kind == "rs") => {
            std::fs::read_to_string(&path).unwrap_or_default()
        }
        false => String::new(),
    };
    entries.flatten().map(|entry| one(entry.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &str = "[package]\nname = \"a\"\n\n[dependencies]\nsome-crate.workspace = true\n# A word.\n\
                            other = { workspace = true }\n\n[dev-dependencies]\nthird = \"1\"\n";

    #[test]
    fn a_dependency_that_no_source_mentions_is_found() {
        assert_eq!(dependencies(MANIFEST, "[dependencies]").collect::<Vec<_>>(), ["some-crate", "other"]);
        assert_eq!(dependencies(MANIFEST, "[dev-dependencies]").collect::<Vec<_>>(), ["third"]);
        let found = named("a", MANIFEST, "[dependencies]", "use some_crate::Thing; fn another() {}");
        assert_eq!(found, ["a: other in [dependencies] is used nowhere; take it off"]);
    }
}
