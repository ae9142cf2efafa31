//! Rules of a description, each broken once: a file of edits, and behind each the problems that it must raise.
//!
//! For tests alone. A case is one or more edits of a sound text, then each problem in full: place, marked text, message,
//! `[label]` and `(advice)`. Warnings that the unedited text has as well are left out.
//!
//! ```text
//! # hand types                       a heading, for readers
//! @ cell                             which text is edited, for the cases below
//! type = 6 ==> type = 7              what, first occurrence, by what; \n is a line feed; nothing before `==>`: at the end
//! > 31:17 `7`: unknown hand type 7 (types are 1 to 6)
//! ```
//!
//! With `INSTA_UPDATE=always` the problems are written anew; read the difference.

pub mod slips;

use std::fmt::Write;
use std::path::Path;

use linewright_diagnostics::Problem;

/// Checks every case of the file `dir/name`. `base` gives the text by its name, `read` all problems of a text.
///
/// # Panics
///
/// If an edit has no effect, a problem points out of its text, or the problems of a case are others than those listed.
pub fn check(dir: &str, name: &str, base: impl Fn(&str) -> String, read: impl Fn(&str) -> Vec<Problem>) {
    let path = Path::new(dir).join(name);
    let expected = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut found = String::new();
    let (mut sound, mut known, mut edited) = (String::new(), Vec::new(), None);
    for (number, line) in expected.lines().chain([""]).enumerate() {
        if let Some((old, new)) = line.split_once("==>") {
            let text: &mut String = edited.get_or_insert_with(|| sound.clone());
            *text = edit(text, &plain(old), &plain(new)).unwrap_or_else(|| panic!("{name}:{}: no effect", number + 1));
        } else if line.is_empty() {
            let case: Option<String> = edited.take();
            found.extend(case.map(|text| listed(&text, &read(&text), &known)));
        } else if let Some(base_name) = line.strip_prefix("@ ") {
            sound = base(base_name);
            known = read(&sound);
            known.retain(|problem| problem.is_warning);
        }
        if !line.starts_with('>') {
            writeln!(found, "{line}").expect("writing to a string");
        }
    }
    // The last line is the empty one that ends the last case.
    found.truncate(found.trim_end().len() + 1);
    if found != expected && std::env::var("INSTA_UPDATE").is_ok_and(|how| how == "always") {
        std::fs::write(&path, &found).expect("the file can be written");
    } else if let Some((nth, (now, before))) =
        found.lines().zip(expected.lines()).enumerate().find(|(_, (now, before))| now != before)
    {
        panic!("{name}:{}: expected\n{before}\nfound\n{now}", nth + 1);
    } else {
        assert_eq!(found.lines().count(), expected.lines().count(), "{name}: other lines at the end");
    }
}

/// One side of an edit, without the blanks around it.
fn plain(side: &str) -> String {
    let side = side.strip_prefix(' ').unwrap_or(side);
    side.strip_suffix(' ').unwrap_or(side).replace("\\n", "\n")
}

/// The text with the first `old` replaced; `None` if that changes nothing.
fn edit(text: &str, old: &str, new: &str) -> Option<String> {
    let edited = if old.is_empty() { format!("{text}{new}") } else { text.replacen(old, new, 1) };
    (edited != text).then_some(edited)
}

/// The problems of a text but for those of `known`, one a line. Places move with an edit, so a known warning hides one
/// warning of the same message.
fn listed(text: &str, problems: &[Problem], known: &[Problem]) -> String {
    let mut list = String::new();
    let mut known: Vec<&Problem> = known.iter().collect();
    for p in problems {
        if let Some(at) = known.iter().position(|k| p.is_warning && k.message == p.message) {
            known.swap_remove(at);
            continue;
        }
        let marked = text.get(p.span.clone()).unwrap_or_else(|| panic!("{p} points out of the text"));
        let marked = marked.lines().next().unwrap_or_default();
        let kind = if p.is_warning { "warning: " } else { "" };
        let label = p.label.as_deref().map_or(String::new(), |label| format!(" [{label}]"));
        let hint = p.hint.as_deref().map_or(String::new(), |hint| format!(" ({hint})"));
        writeln!(list, "> {}:{} `{marked}`: {kind}{}{label}{hint}", p.line, p.column, p.message)
            .expect("writing to a string");
    }
    if list.is_empty() { "> no problem\n".to_owned() } else { list }
}
