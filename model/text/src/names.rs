//! Names that a description defines: their meaning, and whether they are well formed.
//!
//! A name that is defined twice stands for its first definition. One that is malformed is kept as it is, and stands for
//! unknown names as well: its uses may have it as it ought to be. So one slip is reported once and not at every use.

use std::collections::HashMap;

use crate::{LocatedName, Problem, Report, TextRange, nearest, suggestion};

/// Longest name, in characters. ROS allows 255 for a whole topic name; ours are one part of one.
pub const NAME_MAX: usize = 64;

/// Names of one kind in one scope, each with its number and the place that defines it.
#[derive(Clone, Debug, Default)]
pub struct NameTable<'a> {
    entries: HashMap<&'a str, (usize, &'a TextRange)>,
    /// In the order of the description, so that suggestions do not depend on hashing.
    order: Vec<&'a str>,
    /// Malformed ones among them.
    malformed: Vec<&'a str>,
}

impl<'a> NameTable<'a> {
    /// Names of signals, by their place in the list; the first of two that are the same.
    pub fn of_tags(names: impl IntoIterator<Item = &'a LocatedName>) -> Self {
        let mut table = NameTable::default();
        for (id, name) in names.into_iter().enumerate() {
            table.note(name, is_tag(&name.value));
            table.define(name, id);
        }
        table
    }

    /// Defines `name` as number `id`; gives back the place of an earlier definition, which then stands.
    pub fn define(&mut self, name: &'a LocatedName, id: usize) -> Option<&'a TextRange> {
        if let Some((_, earlier)) = self.entries.get(name.value.as_str()) {
            return Some(earlier);
        }
        self.entries.insert(&name.value, (id, &name.at));
        self.order.push(&name.value);
        None
    }

    /// Notes whether a defined name is well formed; one that is not stands for unknown names as well.
    pub fn note(&mut self, name: &'a LocatedName, is_well_formed: bool) {
        if !is_well_formed {
            self.malformed.push(&name.value);
        }
    }

    /// Whether number `id` has a malformed name.
    pub fn is_malformed(&self, id: usize) -> bool {
        self.malformed.iter().any(|name| self.get(name) == Some(id))
    }

    /// Index of `name`, or of the malformed name in whose place it may be written. An unknown name that is nearer to a
    /// well-formed one is a slip of its own.
    pub fn meant(&self, name: &str) -> Option<usize> {
        let stand_in = || {
            let first = self.malformed.first()?;
            let near = nearest(name, self.malformed.iter().copied().chain(self.names())).unwrap_or(first);
            self.malformed.contains(&near).then(|| self.get(near)).flatten()
        };
        self.get(name).or_else(stand_in)
    }

    /// Index of `name`.
    pub fn get(&self, name: &str) -> Option<usize> {
        self.entries.get(name).map(|&(id, _)| id)
    }

    /// Whether no name is defined.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The name of number `id`.
    pub fn name(&self, id: usize) -> &'a str {
        self.order.iter().copied().find(|name| self.get(name) == Some(id)).unwrap_or("?")
    }

    /// Place of the definition of `name`.
    pub fn place(&self, name: &str) -> Option<&'a TextRange> {
        self.entries.get(name).map(|&(_, at)| at)
    }

    /// All well-formed names, in the order of the description.
    pub fn names(&self) -> impl Iterator<Item = &'a str> + Clone + use<'a, '_> {
        self.order.iter().copied().filter(|name| !self.malformed.contains(name))
    }

    /// Index of the name that is meant, or a problem with what it could have been.
    pub fn find(&self, name: &LocatedName, what: &str, report: &mut Report) -> Option<usize> {
        let found = self.meant(&name.value);
        if found.is_none() && !report.is_full() {
            report.add_unknown(
                Problem::error(name.at.clone(), format!("unknown {what} `{}`", name.value))
                    .maybe_hint(suggestion(&name.value, self.names())),
            );
        }
        found
    }
}

/// Defines `name` in `table`, and reports a second definition.
pub fn unique<'a>(table: &mut NameTable<'a>, name: &'a LocatedName, id: usize, what: &str, report: &mut Report) {
    if let Some(earlier) = table.define(name, id) {
        report.add(
            Problem::error(name.at.clone(), format!("a second {what} named `{}`", name.value))
                .label("again")
                .also(earlier, "first here"),
        );
    }
}

/// Reports a name that cannot become part of the ROS graph; whether it can.
pub fn ros_name(name: &LocatedName, what: &str, report: &mut Report) -> bool {
    let text = &name.value;
    let fits = text.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && text.starts_with(|c: char| c.is_ascii_lowercase())
        && !text.contains("__")
        && text.len() <= NAME_MAX;
    if !fits {
        report.add(
            Problem::error(name.at.clone(), format!("`{text}` cannot be the name of a {what}"))
                .label("not a ROS name")
                .hint(format!(
                    "lower-case letters, digits and single `_`, a letter first, at most {NAME_MAX}; `title` may be anything"
                )),
        );
    }
    fits
}

/// Reports a name that is not as a chart prints it: words, with blanks between them; whether it is.
pub fn phrase(name: &LocatedName, what: &str, report: &mut Report) -> bool {
    let text = &name.value;
    let fits = !text.is_empty()
        && text.trim() == text
        && !text.contains(':')
        && !text.chars().any(char::is_control)
        && text.chars().count() <= NAME_MAX;
    if !fits {
        report.add(
            Problem::error(name.at.clone(), format!("`{}` cannot name this {what}", text.escape_debug()))
                .hint(format!("some words without `:`, no blank at either end, at most {NAME_MAX} characters")),
        );
    }
    fits
}

/// The name with `_` for each stretch of blanks, where that makes it one word.
fn without_blanks(text: &str) -> Option<String> {
    let word = text.split_whitespace().collect::<Vec<_>>().join("_");
    (word != text && is_tag(&word)).then_some(word)
}

fn is_tag(text: &str) -> bool {
    !text.is_empty() && text.len() <= NAME_MAX && text.chars().all(|c| c.is_ascii_graphic())
}

/// Reports a name that is not as a circuit diagram prints it: one word; whether it is.
pub fn tag(name: &LocatedName, what: &str, report: &mut Report) -> bool {
    let text = &name.value;
    let fits = is_tag(text);
    if !fits {
        report.add(Problem::error(name.at.clone(), format!("`{}` cannot name this {what}", text.escape_debug())).hint(
            format!(
                "one word of letters, digits and signs without blanks, at most {NAME_MAX}{}",
                without_blanks(text).map_or(String::new(), |word| format!(": `{word}`"))
            ),
        ));
    }
    fits
}
