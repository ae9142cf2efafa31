//! What is wrong with a description, where, and what to do about it.
//!
//! A [`Problem`] is one sentence with a place; [`Problems`] is all of them with the text they point into, so that
//! `miette` can draw them. The rules know neither lines nor columns: they report byte ranges, and
//! [`Problems::new`] counts the lines once at the end. Nothing here knows what a line of production is.

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, NamedSource, Severity, SourceCode};

/// At most this many errors, and as many warnings, are kept: more would only hide the first cause.
const PROBLEMS_MAX: usize = 500;

/// One thing wrong with a description, or (as a warning) suspicious about it.
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
    /// Other places that take part in it, each with its own label.
    pub also: Vec<(Range<usize>, String)>,
    /// Whether the description is usable all the same.
    pub is_warning: bool,
}

impl Problem {
    /// An error at `span`; its line and column are set when it joins its text.
    pub fn error(span: Range<usize>, message: impl Into<String>) -> Self {
        Problem {
            message: message.into(),
            span,
            line: 1,
            column: 1,
            hint: None,
            label: None,
            also: Vec::new(),
            is_warning: false,
        }
    }

    /// A warning at `span`.
    pub fn warning(span: Range<usize>, message: impl Into<String>) -> Self {
        Problem { is_warning: true, ..Problem::error(span, message) }
    }

    /// With this written under the marked text.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// With this advice.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// With this advice, if there is any.
    pub fn maybe_hint(mut self, hint: Option<String>) -> Self {
        self.hint = hint.or(self.hint);
        self
    }

    /// With another place marked.
    pub fn also(mut self, span: &Range<usize>, label: impl Into<String>) -> Self {
        self.also.push((span.clone(), label.into()));
        self
    }
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
        let primary = LabeledSpan::new_primary_with_span(self.label.clone(), self.span.clone());
        let also = self.also.iter().map(|(span, label)| LabeledSpan::new_with_span(Some(label.clone()), span.clone()));
        Some(Box::new(std::iter::once(primary).chain(also)))
    }
}

/// All problems of one description, in the order of the text, with the text they point into.
///
/// Printed plainly it is one line per problem, `file:line:column: message`, as editors and build logs expect it;
/// drawn by `miette` it shows the places.
#[derive(Debug)]
pub struct Problems {
    source: NamedSource<String>,
    problems: Vec<Problem>,
    /// Whether there may be more than are kept.
    is_cut: bool,
}

impl Problems {
    /// The problems of the description `text`, called `file_name`.
    ///
    /// Also of use for the warnings of a sound description, to have them drawn.
    pub fn new(file_name: &str, text: &str, mut problems: Vec<Problem>) -> Self {
        let places = Places::of(text);
        for problem in &mut problems {
            problem.span = within(text, &problem.span);
            (problem.line, problem.column) = places.line_and_column(problem.span.start);
            for (span, _) in &mut problem.also {
                *span = within(text, span);
            }
        }
        problems.sort_by_key(|p| (p.span.start, p.is_warning));
        Problems { source: NamedSource::new(file_name, text.to_owned()), problems, is_cut: false }
    }

    /// The problems, in the order of the text.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.problems.iter()
    }

    /// The problems, without their text.
    pub fn into_vec(self) -> Vec<Problem> {
        self.problems
    }

    /// How many of them are errors.
    pub fn errors(&self) -> usize {
        self.problems.iter().filter(|p| !p.is_warning).count()
    }

    /// How many of them are warnings.
    pub fn warnings(&self) -> usize {
        self.problems.len() - self.errors()
    }

    fn headline(&self) -> String {
        let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let name = self.source.name();
        if self.is_cut {
            return format!("{name}: the first {} of more", count(self.errors(), "error"));
        }
        match (self.errors(), self.warnings()) {
            (errors, 0) => format!("{name}: {}", count(errors, "error")),
            (0, warnings) => format!("{name}: {}", count(warnings, "warning")),
            (errors, warnings) => format!("{name}: {}, {}", count(errors, "error"), count(warnings, "warning")),
        }
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.headline())?;
        if f.alternate() {
            for p in &self.problems {
                let kind = if p.is_warning { "warning: " } else { "" };
                write!(f, "\n{}:{}:{}: {kind}{}", self.source.name(), p.line, p.column, p.message)?;
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

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|p| p as &dyn Diagnostic)))
    }
}

/// Where the rules put what they find.
#[derive(Default)]
pub struct Report {
    errors: Vec<Problem>,
    warnings: Vec<Problem>,
}

impl Report {
    /// Adds a problem, unless there are far too many of its kind already.
    pub fn add(&mut self, problem: Problem) {
        let kind = if problem.is_warning { &mut self.warnings } else { &mut self.errors };
        if kind.len() < PROBLEMS_MAX {
            kind.push(problem);
        }
    }

    /// Whether another error would not be kept: then there is no need to work out a hint for it.
    pub fn is_full(&self) -> bool {
        self.errors.len() >= PROBLEMS_MAX
    }

    /// Whether anything forbids using the description.
    pub fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// What was read, with the warnings, if nothing forbids using it; otherwise all problems. That nothing could be read
    /// and no rule says why would be a mistake of the program, and is said as one.
    pub fn close<T>(mut self, read: Option<T>, file_name: &str, text: &str) -> Result<(T, Vec<Problem>), Problems> {
        let has_errors = self.has_errors();
        match read {
            Some(read) if !has_errors => Ok((read, self.into_problems(file_name, text).into_vec())),
            _ => {
                if !has_errors {
                    self.add(
                        Problem::error(0..0, "this description is incomplete in a way that no rule explains")
                            .hint("this is a mistake of the program: please report it, with the file"),
                    );
                }
                Err(self.into_problems(file_name, text))
            }
        }
    }

    /// All of them, with the text they point into.
    pub fn into_problems(self, file_name: &str, text: &str) -> Problems {
        let is_cut = self.is_full();
        let all = self.errors.into_iter().chain(self.warnings).collect();
        Problems { is_cut, ..Problems::new(file_name, text, all) }
    }
}

/// `span` cut to the text and to whole characters: what a drawing can be made of, whatever a library reported.
fn within(text: &str, span: &Range<usize>) -> Range<usize> {
    let whole = |at: &usize| text.is_char_boundary(*at);
    let start = (0..=span.start.min(text.len())).rev().find(whole).unwrap_or(0);
    start..(span.end.max(start)..text.len()).find(whole).unwrap_or(text.len())
}

/// The beginnings of a text's lines, found once for all problems.
struct Places<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Places<'a> {
    fn of(text: &'a str) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Places { text, starts }
    }

    fn line_and_column(&self, at: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|&start| start <= at);
        let start = self.starts[line.saturating_sub(1)];
        (line, self.text[start..at].chars().count() + 1)
    }
}
