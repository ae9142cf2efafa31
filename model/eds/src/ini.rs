//! The text as sections and keys, with nothing lost: everything is a place in the text.
//!
//! Comments, blank lines, spaces and line ends are not kept apart; they are what the places leave out. Writing is
//! therefore copying the text, and changing a value is changing a few bytes of it (`edit`). This module has no name of
//! the standard, except the keys whose loss would change what a device is sent.

use std::collections::HashMap;

use linewright_diagnostics::{At, Problem, Report, shown};

/// A line that begins with one of these and has no `=` is a value about to be lost.
const NEVER_LOST: [&str; 12] = [
    "parametervalue",
    "defaultvalue",
    "datatype",
    "accesstype",
    "lowlimit",
    "highlimit",
    "objecttype",
    "pdomapping",
    "objflags",
    "subnumber",
    "compactsubobj",
    "nodeid",
];

/// A text and where in it everything is.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    pub text: String,
    sections: Vec<Section>,
    keys: Vec<IniKey>,
}

#[derive(Clone, Copy, Debug)]
struct Section {
    name: At,
    /// Of the header, from 1.
    line: u32,
    first_key: u32,
    /// Behind the line end of the last key, or of the header.
    end: u32,
}

/// One `key=value`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IniKey {
    pub key: At,
    /// Without spaces and comments around it.
    pub value: At,
    /// Whether a comment stood behind the value.
    pub commented: bool,
}

/// One section of a document.
#[derive(Clone, Copy)]
pub(crate) struct SectionRef<'a> {
    document: &'a Document,
    index: usize,
}

impl Document {
    /// Takes a text apart. What is neither section, key nor comment is reported and otherwise left alone.
    pub(crate) fn new(text: String, report: &mut Report) -> Self {
        let mut document = Document { text: String::new(), sections: Vec::new(), keys: Vec::new() };
        let (mut start, mut line) = (0, 0);
        while start < text.len() {
            let end = text[start..].find('\n').map_or(text.len(), |length| start + length + 1);
            line += 1;
            document.read_line(&text, start, end, line, report);
            start = end;
        }
        document.text = text;
        document
    }

    fn read_line(&mut self, text: &str, start: usize, end: usize, line: u32, report: &mut Report) {
        let at = trimmed(text, start, end);
        let content = &text[range(at)];
        if content.is_empty() || content.starts_with(';') {
            return;
        }
        if content.starts_with('#') || content.starts_with("//") {
            let finding = Problem::warning(at, "this is taken as a comment, but other tools will not");
            return report.add(finding.hint("begin comments with `;`"));
        }
        if content.starts_with('[') {
            return self.read_header(text, at, (line, end), report);
        }
        let Some(equals) = content.find('=') else { return report.add(no_key(at, content)) };
        let middle = at.start as usize + equals;
        let (value, commented) = without_comment(text, trimmed(text, middle + 1, at.end as usize));
        let key = IniKey { key: trimmed(text, at.start as usize, middle), value, commented };
        match self.sections.last_mut() {
            Some(section) => {
                section.end = narrow(end);
                self.keys.push(key);
            }
            None => {
                let message = format!("`{}` stands before the first section and belongs to nothing", shown(content));
                report.add(Problem::warning(at, message).hint("put it behind the header of its section"));
            }
        }
    }

    fn read_header(&mut self, text: &str, at: At, (line, end): (u32, usize), report: &mut Report) {
        let content = &text[range(at)];
        let Some(close) = content.find(']') else {
            let finding = Problem::error(at, format!("`{}` has no `]`", shown(content)));
            return report.add(finding.hint("close the section's name with `]`"));
        };
        let close = at.start as usize + close;
        let behind = trimmed(text, close + 1, at.end as usize);
        if behind.start < behind.end && !text[range(behind)].starts_with(';') {
            let message = format!("`{}` behind the section's name is ignored", shown(&text[range(behind)]));
            report.add(Problem::warning(behind, message).hint("keys go into lines of their own"));
        }
        let name = trimmed(text, at.start as usize + 1, close);
        self.sections.push(Section { name, line, first_key: narrow(self.keys.len()), end: narrow(end) });
    }

    /// All sections, in order.
    pub(crate) fn sections(&self) -> impl Iterator<Item = SectionRef<'_>> {
        (0..self.sections.len()).map(|index| SectionRef { document: self, index })
    }

    /// The section of this number.
    pub(crate) fn section(&self, index: u32) -> Option<SectionRef<'_>> {
        let index = index as usize;
        (index < self.sections.len()).then_some(SectionRef { document: self, index })
    }

    /// The text at a place of it.
    pub(crate) fn str(&self, at: At) -> &str {
        self.text.get(range(at)).unwrap_or_default()
    }
}

impl<'a> SectionRef<'a> {
    pub(crate) fn index(self) -> u32 {
        narrow(self.index)
    }

    fn own(self) -> Section {
        self.document.sections[self.index]
    }

    /// Text between the brackets.
    pub(crate) fn name(self) -> &'a str {
        self.document.str(self.own().name)
    }

    /// Its place.
    pub(crate) fn at(self) -> At {
        self.own().name
    }

    /// The line of its header, from 1.
    pub(crate) fn line(self) -> u32 {
        self.own().line
    }

    /// The byte behind its last line.
    pub(crate) fn end(self) -> usize {
        self.own().end as usize
    }

    /// Its keys, in order.
    pub(crate) fn keys(self) -> &'a [IniKey] {
        let next = self.document.sections.get(self.index + 1);
        let end = next.map_or(self.document.keys.len(), |next| next.first_key as usize);
        &self.document.keys[self.own().first_key as usize..end]
    }

    /// The first key of this name, in any case.
    pub(crate) fn key(self, name: &str) -> Option<IniKey> {
        self.keys().iter().find(|key| self.document.str(key.key).eq_ignore_ascii_case(name)).copied()
    }

    /// The text at a place of the document.
    pub(crate) fn str(self, at: At) -> &'a str {
        self.document.str(at)
    }

    /// Two values for one key: which one a program takes is chance, unless they are the same.
    pub(crate) fn check_twice(self, report: &mut Report) {
        let mut first: HashMap<String, IniKey> = HashMap::new();
        for &key in self.keys() {
            let name = self.str(key.key);
            let Some(&before) = first.get(&name.to_ascii_lowercase()) else {
                first.insert(name.to_ascii_lowercase(), key);
                continue;
            };
            let message = format!("[{}] {}: stands here twice", shown(self.name()), shown(name));
            report.add(if self.str(key.value) == self.str(before.value) {
                Problem::warning(key.key, message).hint("remove one of them").earlier(before.key)
            } else {
                let hint = "the values differ; remove the wrong one";
                Problem::error(key.key, message).hint(hint).earlier(before.key)
            });
        }
    }
}

fn no_key(at: At, content: &str) -> Problem {
    let word = content.split(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default().to_ascii_lowercase();
    if NEVER_LOST.contains(&word.as_str()) {
        return Problem::error(at, format!("`{}` has no `=`", shown(content))).hint("write `key=value`");
    }
    let message = format!("`{}` is neither a section nor a key nor a comment; it is ignored", shown(content));
    Problem::warning(at, message).hint("write `key=value`, or begin it with `;`")
}

fn narrow(at: usize) -> u32 {
    // Files are limited to far less.
    u32::try_from(at).unwrap_or(u32::MAX)
}

pub(crate) fn range(at: At) -> std::ops::Range<usize> {
    at.start as usize..at.end as usize
}

fn trimmed(text: &str, start: usize, end: usize) -> At {
    let content = &text[start..end];
    let start = start + (content.len() - content.trim_start().len());
    At::new(start..start + content.trim().len())
}

/// A comment begins with `;` at the beginning of a value or behind a space. Anywhere else it may be part of a name.
fn without_comment(text: &str, value: At) -> (At, bool) {
    let content = &text[range(value)];
    let begins = |&(at, _): &(usize, &str)| content[..at].chars().next_back().is_none_or(char::is_whitespace);
    match content.match_indices(';').find(begins) {
        Some((at, _)) => (trimmed(text, value.start as usize, value.start as usize + at), true),
        None => (value, false),
    }
}
