//! Collection of a reader's findings.

use std::ops::Range;

use crate::problems::Cut;
use crate::{Problem, Problems};

/// At most this many errors, and as many warnings, are kept of a text that is kept whole: more would only hide the first
/// cause.
const PROBLEMS_MAX: usize = 500;

/// The same where each problem has an excerpt of its own.
pub const EXCERPTS_MAX: usize = 50;

/// Collection of a reader's findings.
#[derive(Debug, Default)]
pub struct Report {
    errors: Vec<Problem>,
    warnings: Vec<Problem>,
    cut: Cut,
    in_excerpts: bool,
    has_unknown: bool,
}

impl Report {
    /// For a text that is not kept: a few problems, each with the lines around it.
    pub fn of_excerpts() -> Self {
        Report { in_excerpts: true, ..Report::default() }
    }

    fn most(&self) -> usize {
        if self.in_excerpts { EXCERPTS_MAX } else { PROBLEMS_MAX }
    }

    /// Adds a problem, unless there are far too many of its kind already.
    pub fn add(&mut self, problem: Problem) {
        let most = self.most();
        let (kind, cut) = match problem.is_warning {
            true => (&mut self.warnings, &mut self.cut.warnings),
            false => (&mut self.errors, &mut self.cut.errors),
        };
        if kind.len() < most {
            kind.push(problem);
        } else {
            *cut = true;
        }
    }

    /// Adds an error about a name that stands for nothing. Where there is one of the same text, this is a further place of it: one slip
    /// is one error, however often the name is written.
    pub fn add_unknown(&mut self, problem: Problem) {
        self.has_unknown = true;
        match self.errors.iter_mut().find(|known| known.message == problem.message) {
            Some(known) => known.again.push(problem.span),
            None => self.add(problem),
        }
    }

    /// Whether a name stands for nothing: then what is used is not known.
    pub fn has_unknown(&self) -> bool {
        self.has_unknown
    }

    /// Turns all problems into others: once the errors, and once the warnings.
    pub fn rewrite(&mut self, turn: impl Fn(Vec<Problem>) -> Vec<Problem>) {
        self.errors = turn(std::mem::take(&mut self.errors));
        self.warnings = turn(std::mem::take(&mut self.warnings));
    }

    /// Adds all that another one holds.
    pub fn join(&mut self, other: Report) {
        self.has_unknown |= other.has_unknown;
        self.cut.errors |= other.cut.errors;
        self.cut.warnings |= other.cut.warnings;
        other.errors.into_iter().chain(other.warnings).for_each(|problem| self.add(problem));
    }

    /// Whether another error would not be kept: then there is no need to work it out, and there are more than are kept.
    pub fn is_full(&mut self) -> bool {
        let is_full = self.errors.len() >= self.most();
        self.cut.errors |= is_full;
        is_full
    }

    /// Whether anything forbids using the file.
    pub fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// Whether an error is about exactly this place.
    pub fn has_error_at(&self, span: &Range<usize>) -> bool {
        self.errors.iter().any(|problem| problem.span == *span)
    }

    /// The result, with the warnings, if nothing forbids using it; otherwise all problems. No result without an error is
    /// a mistake of the program, and reported as one.
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

    /// All of them, with the parts kept of the text they point into. `file_name` is for messages.
    pub fn into_problems(self, file_name: &str, text: &str) -> Problems {
        let all = self.errors.into_iter().chain(self.warnings).collect();
        let make = if self.in_excerpts { Problems::excerpts } else { Problems::new };
        let mut problems = make(file_name, text, all);
        problems.cut = self.cut;
        problems
    }
}
