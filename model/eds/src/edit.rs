//! Small changes of a text: values replaced, lines added. What is not touched stays as it is, byte for byte.

use std::ops::Range;

use crate::ini::{Document, IniKey, SectionRef, range};

/// Changes to be made of a document, all at once.
pub(crate) struct Editor<'a> {
    document: &'a Document,
    line_end: &'static str,
    edits: Vec<Edit>,
}

struct Edit {
    at: Range<usize>,
    text: String,
    /// Whole lines, which begin behind a line end even if the text has none there.
    is_line: bool,
}

impl<'a> Editor<'a> {
    pub(crate) fn new(document: &'a Document) -> Self {
        let is_dos = document.text.find('\n').is_some_and(|at| document.text[..at].ends_with('\r'));
        Editor { document, line_end: if is_dos { "\r\n" } else { "\n" }, edits: Vec::new() }
    }

    /// Puts another value in the place of one.
    pub(crate) fn replace(&mut self, key: IniKey, value: &str) {
        let behind = &self.document.text[key.value.end as usize..];
        // A comment that followed `=` at once needs a space to remain one.
        let is_close = key.value.start == key.value.end && behind.starts_with(';');
        let text = if is_close { format!("{value} ") } else { value.to_owned() };
        self.edits.push(Edit { at: range(key.value), text, is_line: false });
    }

    /// Gives a key of a section this value, behind its other keys if it has none.
    pub(crate) fn set(&mut self, section: SectionRef<'_>, key: &str, value: &str) {
        match section.key(key) {
            Some(found) => self.replace(found, value),
            None => self.insert(section.end(), &[format!("{key}={value}")]),
        }
    }

    /// Adds lines at a place, which is the beginning of a line or the end of the text.
    pub(crate) fn insert(&mut self, at: usize, lines: &[String]) {
        let text: String = lines.iter().flat_map(|line| [line.as_str(), self.line_end]).collect();
        self.edits.push(Edit { at: at..at, text, is_line: true });
    }

    /// The changed text.
    pub(crate) fn finish(mut self) -> String {
        self.edits.sort_by_key(|edit| edit.at.start);
        let old = &self.document.text;
        let (mut new, mut done) = (String::with_capacity(old.len() + 64 * self.edits.len()), 0);
        for edit in self.edits {
            new.push_str(&old[done..edit.at.start]);
            if edit.is_line && !new.is_empty() && !new.ends_with('\n') {
                new.push_str(self.line_end);
            }
            new.push_str(&edit.text);
            done = edit.at.end;
        }
        new.push_str(&old[done..]);
        new
    }
}
