//! Tests in a library without tests by its manifest: they would not be run, and not be missed.
//!
//! A library without unit tests has `test = false`, one without examples `doctest = false`; otherwise each would be
//! compiled once more for nothing.

use super::WorkspaceMember;
use super::unused::sources;

/// Checks one crate.
pub fn check(member: &WorkspaceMember) -> Vec<String> {
    if !member.dir.join("src/lib.rs").is_file() {
        return Vec::new();
    }
    findings(&member.name, &member.manifest, &sources(&member.dir.join("src")))
}

fn findings(name: &str, manifest: &str, text: &str) -> Vec<String> {
    let lib = manifest.split_once("[lib]\n").map_or("", |(_, rest)| rest.split("\n[").next().unwrap_or_default());
    let kinds =
        [("test", "unit tests", has_tests(text)), ("doctest", "examples in its documentation", has_examples(text))];
    let wrong = |(key, what, there): (&str, &str, bool)| {
        let off = lib.lines().any(|line| line == format!("{key} = false"));
        match (there, off) {
            (true, true) => Some(format!("{name}: has {what}, which `{key} = false` in [lib] switches off")),
            (false, false) => Some(format!("{name}: has no {what}; say `{key} = false` in [lib]")),
            (true, false) | (false, true) => None,
        }
    };
    kinds.into_iter().filter_map(wrong).collect()
}

fn has_tests(text: &str) -> bool {
    text.lines().map(str::trim).any(|line| line.starts_with("#[test]") || line.starts_with("#[tokio::test"))
}

/// Whether there is a block of code in the documentation that is Rust.
fn has_examples(text: &str) -> bool {
    let mut inside = false;
    let docs = text.lines().filter_map(|line| line.trim_start().strip_prefix("//")?.strip_prefix(['/', '!']));
    docs.filter_map(|doc| doc.trim().strip_prefix("```")).any(|kind| {
        let opens = !inside;
        inside = opens;
        opens && ["", "rust", "no_run", "should_panic", "compile_fail"].contains(&kind)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFF: &str = "[lib]\ntest = false\ndoctest = false\n\n[lints]\n";

    #[test]
    fn tests_that_are_switched_off_are_found() {
        assert_eq!(findings("a", OFF, "/// ```text\n/// a\n/// ```\nfn a() {}\n"), [""; 0]);
        let test = findings("a", OFF, "    #[test]\n    fn a() {}\n");
        assert!(test.len() == 1 && test[0].contains("`test = false`"), "{test:?}");
        let example = findings("a", OFF, "/// ```text\n/// ```\n/// ```\n/// a();\n/// ```\n");
        assert!(example.len() == 1 && example[0].contains("`doctest = false`"), "{example:?}");
        assert_eq!(findings("a", "[lib]\ntest = false\n", "fn a() {}").len(), 1);
        assert_eq!(findings("a", "", "fn a() {}").len(), 2);
    }
}
