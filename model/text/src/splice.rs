//! A text put together from stretches of another one, with the place that each stretch comes from.
//!
//! Problems in the new text are shown in the old one: that is the one people have written. A stretch that stands in the
//! new text several times has a note on what it was copied for this time.

use std::collections::HashMap;

use crate::{Problem, Report, TextRange};

/// Reason why a stretch stands in the new text: a place of the old text, and what to write there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NoteId(usize);

/// Two marks that are drawn together are no farther apart.
const NEAR_LINES: usize = 12;

/// The new text, and where its stretches come from.
#[derive(Clone, Debug, Default)]
pub struct Splice {
    text: String,
    pieces: Vec<Piece>,
    notes: Vec<SpliceNote>,
}

#[derive(Clone, Debug)]
struct SpliceNote {
    at: TextRange,
    label: String,
    /// The word that differs from copy to copy, for problems that are the same but for it.
    varies: String,
}

#[derive(Clone, Debug)]
struct Piece {
    /// Its beginning in the new text.
    start: usize,
    from: TextRange,
    /// Whether it is byte by byte what the old text has there.
    is_copy: bool,
    note: Option<NoteId>,
}

impl Splice {
    /// The text as it is.
    pub fn whole(text: &str) -> Self {
        let mut splice = Splice::default();
        splice.copy(text, 0..text.len(), None);
        splice
    }

    /// The new text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A reason for stretches: `label` is written at `at` of the old text. `varies` is the word in messages that differs
    /// from copy to copy.
    pub fn note(&mut self, at: TextRange, label: impl Into<String>, varies: &str) -> NoteId {
        self.notes.push(SpliceNote { at, label: label.into(), varies: varies.to_owned() });
        NoteId(self.notes.len() - 1)
    }

    /// Adds a stretch of the old text as it is.
    pub fn copy(&mut self, old: &str, from: TextRange, note: Option<NoteId>) {
        if let Some(stretch) = old.get(from.clone()) {
            self.pieces.push(Piece { start: self.text.len(), from, is_copy: true, note });
            self.text.push_str(stretch);
        }
    }

    /// Adds other words, which stand for this stretch of the old text.
    pub fn put(&mut self, words: &str, from: TextRange, note: Option<NoteId>) {
        self.pieces.push(Piece { start: self.text.len(), from, is_copy: false, note });
        self.text.push_str(words);
    }

    /// Ends a line that has no end yet.
    pub fn end_line(&mut self) {
        if !self.text.is_empty() && !self.text.ends_with('\n') {
            let at = self.pieces.last().map_or(0, |piece| piece.from.end);
            self.put("\n", at..at, None);
        }
    }

    /// Turns problems of the new text into problems of the text `old`. A problem of a stretch in each of its copies is
    /// reported once.
    pub fn put_back(&self, old: &str, report: &mut Report) {
        report.rewrite(|problems| self.put_back_all(old, problems));
    }

    fn put_back_all(&self, old: &str, problems: Vec<Problem>) -> Vec<Problem> {
        let mut kept: Vec<(Problem, Option<NoteId>, usize)> = Vec::new();
        let mut first: HashMap<(TextRange, String), usize> = HashMap::new();
        for mut problem in problems {
            let (span, note) = self.origin(&problem.span);
            problem.span = span;
            problem.also.iter_mut().for_each(|(at, _)| *at = self.origin(at).0);
            problem.again.iter_mut().for_each(|at| *at = self.origin(at).0);
            // Other copies of its own place.
            let places = problem.again.len();
            problem.again.retain(|at| *at != problem.span);
            let copies = places - problem.again.len();
            if let Some(note) = note {
                let key = (problem.span.clone(), self.without_what_varies(&problem.message, note));
                if let Some(&earlier) = first.get(&key) {
                    kept[earlier].2 += 1 + copies;
                    continue;
                }
                first.insert(key, kept.len());
            }
            kept.push((problem, note, copies));
        }
        let noted = kept.into_iter().map(|(problem, note, more)| match note {
            None => problem,
            Some(NoteId(note)) => {
                let SpliceNote { at, label, .. } = &self.notes[note];
                let label = if more == 0 { label.clone() } else { format!("{label}, and {more} more") };
                noted_at(old, problem, at, label)
            }
        });
        noted.collect()
    }

    fn without_what_varies(&self, message: &str, note: NoteId) -> String {
        let varies = &self.notes[note.0].varies;
        if varies.is_empty() { message.to_owned() } else { message.replace(varies.as_str(), "") }
    }

    /// The stretch of the old text that a stretch of the new one stands for.
    pub fn origin_of(&self, range: &TextRange) -> TextRange {
        self.origin(range).0
    }

    /// The same, with its note.
    fn origin(&self, range: &TextRange) -> (TextRange, Option<NoteId>) {
        let Some(first) = self.piece(range.start) else { return (range.clone(), None) };
        let last = self.piece(range.end.max(range.start + 1) - 1).filter(|last| last.note == first.note);
        let start = if first.is_copy { first.from.start + (range.start - first.start) } else { first.from.start };
        let end = match last {
            Some(last) if last.is_copy => last.from.start + range.end.saturating_sub(last.start),
            Some(last) => last.from.end,
            None => first.from.end,
        };
        (start..end.max(start), first.note)
    }

    fn piece(&self, at: usize) -> Option<&Piece> {
        let after = self.pieces.partition_point(|piece| piece.start <= at);
        self.pieces[..after].last()
    }
}

/// The problem with a note: marked where it is near, and else with its line, since what is drawn reaches from one mark to the
/// other.
fn noted_at(old: &str, mut problem: Problem, at: &TextRange, label: String) -> Problem {
    let lines = |text: Option<&str>| text.unwrap_or("").matches('\n').count();
    let (first, last) = (at.start.min(problem.span.start), at.start.max(problem.span.start));
    if lines(old.get(first..last)) <= NEAR_LINES {
        return problem.also(at, label);
    }
    let place = format!("{label} (line {})", lines(old.get(..at.start)) + 1);
    let with_place = |hint: String| format!("{hint}{} {place}", if hint.ends_with('?') { "" } else { ";" });
    problem.hint = Some(problem.hint.take().map_or(place.clone(), with_place));
    problem
}
