//! One problem of a file.

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, Severity, SourceCode};

use crate::excerpt::Excerpt;

/// One thing wrong with a file, or (as a warning) suspicious about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Text, with the names and numbers involved.
    pub message: String,
    /// The bytes of the text it is about.
    pub span: Range<usize>,
    /// The line of the first of them, from 1.
    pub line: usize,
    /// The column of the first of them, in characters, from 1.
    pub column: usize,
    /// Advice.
    pub hint: Option<String>,
    /// Text under the marked place.
    pub label: Option<String>,
    /// Other places that take part in it, each with its own label.
    pub also: Vec<(Range<usize>, String)>,
    /// Further places of the same problem; their lines are named behind the advice.
    pub again: Vec<Range<usize>>,
    /// Whether the file is usable all the same.
    pub is_warning: bool,
    /// The lines around it, where the whole text is not kept.
    pub(crate) excerpt: Option<Box<Excerpt>>,
}

impl Problem {
    /// An error at `span`; its line and column are set when it joins its text.
    pub fn error(span: impl Into<Range<usize>>, message: impl Into<String>) -> Self {
        Problem {
            message: message.into(),
            span: span.into(),
            line: 1,
            column: 1,
            hint: None,
            label: None,
            also: Vec::new(),
            again: Vec::new(),
            is_warning: false,
            excerpt: None,
        }
    }

    pub fn warning(span: impl Into<Range<usize>>, message: impl Into<String>) -> Self {
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

    /// With the place of the first of two.
    pub fn earlier(self, at: impl Into<Range<usize>>) -> Self {
        self.also(&at.into(), "the first")
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
        let span = self.excerpt.as_ref().map_or(&self.span, |excerpt| &excerpt.span);
        let primary = LabeledSpan::new_primary_with_span(self.label.clone(), span.clone());
        let also = self.also.iter().map(|(span, label)| LabeledSpan::new_with_span(Some(label.clone()), span.clone()));
        Some(Box::new(std::iter::once(primary).chain(also)))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt.as_ref().map(|excerpt| &**excerpt as &dyn SourceCode)
    }
}
