//! The few lines of a file around a problem, kept to be drawn.
//!
//! Files that programs write may be one line of many megabytes. A drawing of such a line would be as long, and the
//! whole text would have to be kept until then. So each problem takes with it what a reader needs: its line with the
//! ones before and after, or of a long line the part around the problem.

use std::ops::Range;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// The longest line that is shown whole, in bytes.
const LINE_MAX: usize = 160;

/// Of a longer one, how much is shown before the problem and how much from it on.
const BEFORE: usize = 40;
const AFTER: usize = 80;

/// Part of a text, and where it stands in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Excerpt {
    file_name: String,
    text: String,
    /// Place of the problem, in `text`.
    pub(crate) span: Range<usize>,
    /// Number of lines of the file before `text`.
    lines_before: usize,
    /// The line and column of the problem in the file, from 1.
    line: usize,
    column: usize,
}

impl Excerpt {
    /// Text around `span`, in the line that starts at `line_start` and is the `line`-th one.
    pub(crate) fn of(file_name: &str, text: &str, span: &Range<usize>, line_start: usize, line: usize) -> Self {
        let whole = |at: usize| (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
        let line_end = text[line_start..].find('\n').map_or(text.len(), |length| line_start + length);
        let (from, lines_before) = if line_end - line_start > LINE_MAX {
            (whole(span.start.saturating_sub(BEFORE).max(line_start)), line - 1)
        } else {
            let before = text[..line_start.saturating_sub(1)].rfind('\n').map_or(0, |at| at + 1);
            let has_before = line_start > 0 && line_start - before <= LINE_MAX;
            if has_before { (before, line - 2) } else { (line_start, line - 1) }
        };
        let to = if line_end - line_start > LINE_MAX {
            whole(line_end.min(span.start + AFTER))
        } else {
            let after =
                text.get(line_end + 1..).map_or(line_end, |rest| line_end + 1 + rest.find('\n').unwrap_or(rest.len()));
            if after - line_end <= LINE_MAX { after } else { line_end }
        };
        Excerpt {
            file_name: file_name.to_owned(),
            text: text[from..to].chars().map(harmless).collect(),
            span: span.start - from..span.end.clamp(span.start, to) - from,
            lines_before,
            line,
            column: text[line_start..span.start].chars().count() + 1,
        }
    }

    /// The column of the problem in the file, in characters, from 1.
    pub(crate) fn column(&self) -> usize {
        self.column
    }
}

/// A terminal obeys control characters; these are of no use here. Each stand-in has as many bytes as they have.
fn harmless(c: char) -> char {
    match c {
        '\n' | '\t' => c,
        c if c.is_ascii_control() => ' ',
        c if c.is_control() => '\u{A0}',
        c => c,
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let found = self.text.read_span(span, lines_before, lines_after)?;
        // For the span alone, `miette` needs its place; otherwise the lines it is going to draw.
        let (line, column) = match lines_before {
            0 => (self.line - 1, self.column - 1),
            _ => (self.lines_before + found.line(), found.column()),
        };
        Ok(named(&self.file_name, &*found, (line, column), found.line_count()))
    }
}

/// Found lines, with the file's name and where they begin in it.
fn named<'a>(
    file: &str,
    found: &(dyn SpanContents<'a> + 'a),
    (line, column): (usize, usize),
    lines: usize,
) -> Box<dyn SpanContents<'a> + 'a> {
    Box::new(MietteSpanContents::new_named(file.to_owned(), found.data(), *found.span(), line, column, lines))
}

/// A whole text, to be drawn around each of the places that take part in a problem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct WholeText {
    pub file_name: String,
    pub text: String,
}

impl SourceCode for WholeText {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let found = self.text.read_span(span, lines_before, lines_after)?;
        // `miette` counts these lines from the beginning of the text. It would take places far apart for neighbours, and draw
        // every line between them.
        let lines = found.line_count().saturating_sub(found.line());
        Ok(named(&self.file_name, &*found, (found.line(), found.column()), lines))
    }
}
