//! What is wrong with a file, where, and what to do about it.
//!
//! The readers know neither lines nor columns: they report byte ranges, and the lines are counted once at the end.

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, Severity, SourceCode};

use crate::excerpt::Excerpt;

/// The most errors that are reported of one file, and as many warnings: more would only hide the first cause.
pub const PROBLEMS_MAX: usize = 50;

/// A stretch of the text, in bytes. Files are far smaller than 32 bits can count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct At {
    /// The first byte.
    pub start: u32,
    /// The byte after the last one.
    pub end: u32,
}

impl At {
    /// The stretch `range`.
    pub fn new(range: Range<usize>) -> Self {
        let narrow = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
        At { start: narrow(range.start), end: narrow(range.end) }
    }
}

/// One thing wrong with a file, or (as a warning) suspicious about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// What is wrong, with the names and numbers involved.
    pub message: String,
    /// The bytes of the text it is about.
    pub span: Range<usize>,
    /// The line of the first of them, from 1.
    pub line: usize,
    /// The column of the first of them, in characters, from 1.
    pub column: usize,
    /// What to do about it.
    pub hint: Option<String>,
    /// What to write under the marked text.
    pub label: Option<String>,
    /// Whether the file is usable all the same.
    pub is_warning: bool,
    excerpt: Excerpt,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Problem {}

impl Diagnostic for Problem {
    fn severity(&self) -> Option<Severity> {
        Some(if self.is_warning { Severity::Warning } else { Severity::Error })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.hint.as_ref().map(|hint| Box::new(hint) as Box<dyn fmt::Display>)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = LabeledSpan::new_primary_with_span(self.label.clone(), self.excerpt.span.clone());
        Some(Box::new(std::iter::once(label)))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.excerpt)
    }
}

/// All problems of one file, in the order of the text.
///
/// Printed plainly it is a headline, and with `{:#}` also one line per problem, `file:line:column: message`, as editors
/// and build logs expect it; drawn by `miette` it shows the places. The crate that reads the file says which of them it
/// hands out: a file that is read has warnings at most.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problems {
    file_name: String,
    problems: Vec<Problem>,
    /// Whether there may be more than are kept.
    is_cut: bool,
}

impl Problems {
    /// The problems, in the order of the text.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.problems.iter()
    }

    /// How many of them are errors.
    pub fn errors(&self) -> usize {
        self.problems.iter().filter(|p| !p.is_warning).count()
    }

    /// How many of them are warnings.
    pub fn warnings(&self) -> usize {
        self.problems.len() - self.errors()
    }

    /// Whether there are none at all.
    pub fn is_empty(&self) -> bool {
        self.problems.is_empty()
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let count = match (self.errors(), self.warnings()) {
            (errors, 0) => counted(errors, "error"),
            (0, warnings) => counted(warnings, "warning"),
            (errors, warnings) => format!("{} and {}", counted(errors, "error"), counted(warnings, "warning")),
        };
        let name = &self.file_name;
        if self.is_cut {
            write!(f, "{name}: the first {count} of more")?;
        } else {
            write!(f, "{name}: {count}")?;
        }
        if f.alternate() {
            for p in &self.problems {
                let kind = if p.is_warning { "warning: " } else { "" };
                write!(f, "\n{name}:{}:{}: {kind}{}", p.line, p.column, p.message)?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

impl Diagnostic for Problems {
    fn severity(&self) -> Option<Severity> {
        Some(if self.errors() == 0 { Severity::Warning } else { Severity::Error })
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|p| p as &dyn Diagnostic)))
    }
}

/// A problem as a reader finds it.
#[derive(Debug)]
pub struct Finding {
    at: At,
    message: String,
    hint: Option<String>,
    label: Option<String>,
    /// Another place, to be named behind the hint.
    earlier: Option<At>,
    is_warning: bool,
}

impl Finding {
    /// An error.
    pub fn new(at: At, message: impl Into<String>) -> Self {
        Finding { at, message: message.into(), hint: None, label: None, earlier: None, is_warning: false }
    }

    /// Suspicious, but no error.
    pub fn warning(at: At, message: impl Into<String>) -> Self {
        Finding { is_warning: true, ..Finding::new(at, message) }
    }

    /// With this advice.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// With this written under the marked text.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// With the place of the first of two.
    pub fn earlier(mut self, at: At) -> Self {
        self.earlier = Some(at);
        self
    }
}

/// Where the readers put what they find.
#[derive(Debug, Default)]
pub struct Report {
    findings: Vec<Finding>,
    errors: usize,
    is_cut: bool,
}

impl Report {
    /// Adds a problem, unless there are enough of its kind already.
    pub fn add(&mut self, finding: Finding) {
        let warnings = self.findings.len() - self.errors;
        let so_far = if finding.is_warning { warnings } else { self.errors };
        if so_far < PROBLEMS_MAX {
            self.errors += usize::from(!finding.is_warning);
            self.findings.push(finding);
        } else {
            self.is_cut = true;
        }
    }

    /// Whether nothing was found that makes the file unusable.
    pub fn is_sound(&self) -> bool {
        self.errors == 0
    }

    /// What was found in the text, in its order. `file_name` is for messages.
    pub fn into_problems(mut self, file_name: &str, text: &str) -> Problems {
        self.findings.sort_by_key(|finding| (finding.at.start, finding.is_warning));
        let places = Places::of(text, &self.findings);
        let problems = self.findings.into_iter().map(|finding| places.problem(file_name, finding)).collect();
        Problems { file_name: file_name.to_owned(), problems, is_cut: self.is_cut }
    }
}

/// The lines of a text in which something is wrong, counted in one pass. The beginnings of all lines would be many times
/// as long as a text that consists of line ends.
struct Places<'a> {
    text: &'a str,
    /// For some bytes of the text: the line they are in, from 1, and where that line starts. Ascending.
    lines: Vec<(usize, usize, usize)>,
}

impl<'a> Places<'a> {
    fn of(text: &'a str, findings: &[Finding]) -> Self {
        let mut places = Places { text, lines: Vec::new() };
        let ats = findings.iter().flat_map(|finding| [Some(finding.at), finding.earlier]).flatten();
        let mut wanted: Vec<usize> = ats.map(|at| places.within(at).start).collect();
        wanted.sort_unstable();
        let (mut line, mut start, mut seen) = (1, 0, 0);
        for at in wanted {
            for (newline, _) in text.as_bytes()[seen..at].iter().enumerate().filter(|&(_, &byte)| byte == b'\n') {
                (line, start) = (line + 1, seen + newline + 1);
            }
            seen = at;
            places.lines.push((at, line, start));
        }
        places
    }

    /// The line a byte is in, from 1, and where that line starts.
    fn line(&self, at: usize) -> (usize, usize) {
        let found = self.lines.binary_search_by_key(&at, |&(at, ..)| at);
        found.map_or((1, 0), |index| (self.lines[index].1, self.lines[index].2))
    }

    /// Cut to the text and to whole characters: what a drawing can be made of, whatever a library reported.
    fn within(&self, at: At) -> Range<usize> {
        let whole = |at: &usize| self.text.is_char_boundary(*at);
        let (start, end) = (at.start as usize, at.end as usize);
        let start = (0..=start.min(self.text.len())).rev().find(whole).unwrap_or(0);
        start..(end.max(start)..self.text.len()).find(whole).unwrap_or(self.text.len())
    }

    fn problem(&self, file_name: &str, finding: Finding) -> Problem {
        let span = self.within(finding.at);
        let (line, line_start) = self.line(span.start);
        let excerpt = Excerpt::of(file_name, self.text, &span, line_start, line);
        let earlier = finding.earlier.map(|at| format!("the first is in line {}", self.line(self.within(at).start).0));
        let hint = match (finding.hint, earlier) {
            (Some(hint), Some(earlier)) => Some(format!("{hint}; {earlier}")),
            (hint, earlier) => hint.or(earlier),
        };
        let (column, is_warning) = (excerpt.column(), finding.is_warning);
        Problem { message: finding.message, line, column, span, hint, label: finding.label, is_warning, excerpt }
    }
}

/// Somebody else's text in a message: short, and in one line.
pub fn shown(text: &str) -> String {
    const CHARS_MAX: usize = 60;
    let mut short: String = text.chars().take(CHARS_MAX).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(CHARS_MAX).is_some() {
        short.push('…');
    }
    short
}
