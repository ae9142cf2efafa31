//! Problems of a file.

use std::fmt;

use miette::{Diagnostic, Severity, SourceCode};

use crate::Problem;
use crate::excerpt::{Excerpt, WholeText};
use crate::place::{Lines, within};

/// All problems of one file, in the order of the text.
///
/// Printed plainly it is a headline, and with `{:#}` also one line per problem, `file:line:column: message`, as editors
/// and build logs expect it; drawn by `miette` it shows the places. The crate that reads the file documents which of
/// them it returns: a file that is read has warnings at most.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problems {
    file_name: String,
    /// The whole text, unless each problem has its excerpt.
    source: Option<Box<WholeText>>,
    problems: Vec<Problem>,
    pub(crate) cut: Cut,
}

/// The longest line, in bytes, that is drawn whole in a text that is kept whole.
const LINE_DRAWN_MAX: usize = 2000;

/// The longest message, in characters; of a longer one the beginning is kept.
const MESSAGE_MAX: usize = 1000;

/// As many lines of further places are named.
const AGAIN_MAX: usize = 5;

/// Names the lines of a problem's further places, in order and each once.
fn name_again(text: &str, problem: &mut Problem, lines: &Lines) {
    let found = std::mem::take(&mut problem.again);
    let mut found: Vec<usize> = found.iter().map(|span| lines.line(within(text, span).start).0).collect();
    found.sort_unstable();
    found.dedup();
    found.retain(|line| *line != problem.line);
    let shown: Vec<String> = found.iter().take(AGAIN_MAX).map(ToString::to_string).collect();
    let more = found.len().saturating_sub(AGAIN_MAX);
    let place = match &shown[..] {
        [] => return,
        [line] => format!("the same in line {line}"),
        [lines @ .., last] if more == 0 => format!("the same in lines {} and {last}", lines.join(", ")),
        lines => format!("the same in lines {} and {more} more", lines.join(", ")),
    };
    behind_the_advice(problem, place);
}

fn behind_the_advice(problem: &mut Problem, text: String) {
    problem.hint = Some(match problem.hint.take() {
        Some(hint) if hint.ends_with('?') => format!("{hint} {text}"),
        Some(hint) => format!("{hint}; {text}"),
        None => text,
    });
}

/// Kind of which there are more than are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cut {
    pub errors: bool,
    pub warnings: bool,
}

impl Problems {
    /// The problems of the text `text`, called `file_name`, which is kept whole.
    ///
    /// Also of use for the warnings of a sound description, to have them drawn. A text with very long lines is kept in
    /// excerpts all the same: its drawing would be as long.
    pub fn new(file_name: &str, text: &str, mut problems: Vec<Problem>) -> Self {
        if text.lines().any(|line| line.len() > LINE_DRAWN_MAX) {
            return Problems::excerpts(file_name, text, problems);
        }
        for problem in &mut problems {
            problem.span = within(text, &problem.span);
            problem.also.iter_mut().for_each(|(span, _)| *span = within(text, span));
        }
        let again = |problem: &Problem| problem.again.iter().map(|span| within(text, span).start).collect::<Vec<_>>();
        let starts = problems.iter().flat_map(|problem| again(problem).into_iter().chain([problem.span.start]));
        let lines = Lines::of(text, starts.collect());
        for problem in &mut problems {
            let start;
            (problem.line, start) = lines.line(problem.span.start);
            problem.column = text[start..problem.span.start].chars().count() + 1;
            name_again(text, problem, &lines);
        }
        let source = Box::new(WholeText { file_name: file_name.to_owned(), text: text.to_owned() });
        Problems::sorted(file_name, Some(source), problems)
    }

    /// The same, with no more of the text than the lines around each problem; other places are named behind the advice.
    pub(crate) fn excerpts(file_name: &str, text: &str, mut problems: Vec<Problem>) -> Self {
        let starts = |problem: &Problem| {
            let also = problem.also.iter().map(|(span, _)| span).chain(&problem.again);
            also.chain([&problem.span]).map(|span| within(text, span).start).collect::<Vec<_>>()
        };
        let lines = Lines::of(text, problems.iter().flat_map(starts).collect());
        for problem in &mut problems {
            problem.span = within(text, &problem.span);
            let (line, start) = lines.line(problem.span.start);
            let excerpt = Excerpt::of(file_name, text, &problem.span, start, line);
            (problem.line, problem.column) = (line, excerpt.column());
            problem.excerpt = Some(Box::new(excerpt));
            for (span, label) in std::mem::take(&mut problem.also) {
                let place = format!("{label} is in line {}", lines.line(within(text, &span).start).0);
                behind_the_advice(problem, place);
            }
            name_again(text, problem, &lines);
        }
        Problems::sorted(file_name, None, problems)
    }

    fn sorted(file_name: &str, source: Option<Box<WholeText>>, mut problems: Vec<Problem>) -> Self {
        for problem in &mut problems {
            if let Some((end, _)) = problem.message.char_indices().nth(MESSAGE_MAX) {
                problem.message.replace_range(end.., "…");
            }
        }
        problems.sort_by_key(|problem| (problem.span.start, problem.is_warning));
        Problems { file_name: file_name.to_owned(), source, problems, cut: Cut::default() }
    }

    /// The problems, in the order of the text.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.problems.iter()
    }

    /// The problems, without their text.
    pub fn into_vec(self) -> Vec<Problem> {
        self.problems
    }

    /// Number of errors.
    pub fn errors(&self) -> usize {
        self.problems.iter().filter(|problem| !problem.is_warning).count()
    }

    /// Number of warnings.
    pub fn warnings(&self) -> usize {
        self.problems.len() - self.errors()
    }

    /// Whether there are none at all.
    pub fn is_empty(&self) -> bool {
        self.problems.is_empty()
    }

    fn headline(&self) -> String {
        let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let (errors, warnings) = (counted(self.errors(), "error"), counted(self.warnings(), "warning"));
        let name = &self.file_name;
        match (self.cut.errors, self.cut.warnings) {
            (true, true) => format!("{name}: the first {errors} and {warnings} of more"),
            (true, false) => format!("{name}: the first {errors} of more"),
            (false, true) if self.errors() == 0 => format!("{name}: the first {warnings} of more"),
            _ if self.warnings() == 0 => format!("{name}: {errors}"),
            _ if self.errors() == 0 => format!("{name}: {warnings}"),
            _ => format!("{name}: {errors} and {warnings}"),
        }
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.headline())?;
        if f.alternate() {
            for problem in &self.problems {
                let Problem { line, column, message, .. } = problem;
                let kind = if problem.is_warning { "warning: " } else { "" };
                write!(f, "\n{}:{line}:{column}: {kind}{message}", self.file_name)?;
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
        self.source.as_ref().map(|source| &**source as &dyn SourceCode)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|problem| problem as &dyn Diagnostic)))
    }
}
