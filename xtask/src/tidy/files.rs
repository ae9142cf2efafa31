//! Rules about single files: a head that describes it, a bounded length, no paths of the machine it was written on.

use std::fs;
use std::path::{Path, PathBuf};

/// Most lines of a file; a longer one is to be divided.
const LINES_MAX: usize = 500;

/// Never part of the product, whatever is in them.
const NOT_OURS: [&str; 3] = ["target", ".git", "node_modules"];

/// Kinds of files that are text and written by people.
const TEXT: [&str; 17] = [
    "rs", "toml", "md", "sh", "py", "xml", "msg", "service", "target", "yml", "yaml", "txt", "conf", "cases", "snap",
    "dbc", "hex",
];

/// Checks every file of the project.
pub fn check(root: &Path) -> Vec<String> {
    let mut findings = Vec::new();
    let mut files = Vec::new();
    collect(root, &mut files);
    files.sort();
    for path in files {
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().into_owned();
        let Ok(text) = fs::read_to_string(&path) else {
            findings.push(format!("{name}: cannot be read as text"));
            continue;
        };
        findings.extend(of_file(&name, &text));
        if name.ends_with("/tests/all.rs") {
            findings.extend(left_out(&name, &text, &path));
        }
    }
    findings
}

fn collect(dir: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(dir) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        let name = entry.file_name();
        let name = name.to_string_lossy();
        match entry.file_type() {
            Ok(kind) if kind.is_dir() && !NOT_OURS.contains(&&*name) => collect(&path, files),
            Ok(kind) if kind.is_file() && is_text(&path, &name) => files.push(path),
            _ => {}
        }
    }
}

fn is_text(path: &Path, name: &str) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    // `.ci/run` and the like have no extension.
    name != "Cargo.lock" && extension.map_or(name == "run", |extension| TEXT.contains(&extension))
}

fn of_file(name: &str, text: &str) -> Vec<String> {
    let mut findings = Vec::new();
    if name.ends_with(".rs") {
        if !text.starts_with("//!") {
            findings.push(format!("{name}: begins without `//!`; say in a few sentences what it is"));
        }
        findings.extend(length(name, text.lines().count()));
    }
    for home in homes() {
        if let Some(line) = text.lines().position(|line| line.contains(&home)) {
            findings.push(format!("{name}:{}: the path `{home}…` exists on one machine only", line + 1));
        }
    }
    findings
}

/// Tests beside `all.rs` that neither it nor another test program of the crate names, and that are none themselves:
/// they would not be compiled, and not be missed.
fn left_out(name: &str, text: &str, path: &Path) -> Vec<String> {
    let dir = path.parent().unwrap_or(path);
    let manifest = dir.parent().and_then(|root| fs::read_to_string(root.join("Cargo.toml")).ok()).unwrap_or_default();
    let (programs, modules): (Vec<String>, Vec<String>) = modules_in(dir)
        .filter(|module| module != "all")
        .partition(|module| manifest.contains(&format!("[[test]]\nname = \"{module}\"\n")));
    let others = programs.iter().filter_map(|program| fs::read_to_string(dir.join(format!("{program}.rs"))).ok());
    let texts: Vec<String> = others.chain([text.to_owned()]).collect();
    let is_named = |module: &str| texts.iter().any(|text| text.lines().any(|line| line == format!("mod {module};")));
    let mut missing: Vec<String> = modules.into_iter().filter(|module| !is_named(module)).collect();
    missing.sort();
    missing.iter().map(|module| format!("{name}: `mod {module};` is missing, so its tests are never run")).collect()
}

/// The files and directories in this one that could be modules.
fn modules_in(dir: &Path) -> impl Iterator<Item = String> {
    fs::read_dir(dir).into_iter().flatten().flatten().filter_map(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let module = name.strip_suffix(".rs").map(str::to_owned);
        module.or_else(|| entry.path().join("mod.rs").is_file().then_some(name))
    })
}

fn length(name: &str, lines: usize) -> Option<String> {
    (lines > LINES_MAX).then(|| format!("{name}: {lines} lines, {LINES_MAX} at most; which half can stand alone?"))
}

/// Beginnings of people's and machines' own directories. Put together here, so that this file does not contain them.
fn homes() -> impl Iterator<Item = String> {
    ["work", "home", "root", "Users"].into_iter().map(|dir| format!("/{dir}/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_a_head_and_one_that_is_too_long_are_found() {
        assert_eq!(of_file("a.rs", "//! Head.\nfn a() {}\n"), Vec::<String>::new());
        assert!(of_file("a.rs", "fn a() {}\n")[0].contains("without `//!`"));
        let long = format!("//! Head.\n{}", "\n".repeat(LINES_MAX));
        assert!(of_file("a.rs", &long)[0].contains("501 lines"));
        assert_eq!(of_file("a.md", &long), Vec::<String>::new());
    }

    #[test]
    fn tests_that_nobody_names_are_found() {
        let root = std::env::temp_dir().join(format!("linewright-tidy-{}", std::process::id()));
        let dir = root.join("tests");
        for inner in ["group", "data", "shared"] {
            fs::create_dir_all(dir.join(inner)).expect("a directory");
        }
        for file in ["all.rs", "named.rs", "other.rs", "group/mod.rs", "data/text.toml", "shared/mod.rs"] {
            fs::write(dir.join(file), "").expect("a file");
        }
        fs::write(root.join("Cargo.toml"), "[[test]]\nname = \"all\"\n[[test]]\nname = \"alone\"\n").expect("a file");
        fs::write(dir.join("alone.rs"), "mod shared;\n").expect("a file");
        let found = left_out("a/tests/all.rs", "//! Head.\nmod named;\n", &dir.join("all.rs"));
        fs::remove_dir_all(&root).expect("it was there");
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("`mod group;`") && found[1].contains("`mod other;`"), "{found:?}");
    }

    #[test]
    fn a_file_that_is_too_long_is_found() {
        assert_eq!(length("a.rs", LINES_MAX), None);
        assert!(length("a.rs", LINES_MAX + 1).is_some_and(|finding| finding.contains("501 lines")));
    }

    #[test]
    fn a_path_of_one_machine_is_found_with_its_line() {
        let home = homes().next().expect("there are some");
        let found = of_file("a.md", &format!("all well\nsee {home}main\n"));
        assert!(found[0].starts_with("a.md:2: the path"), "{found:?}");
    }
}
