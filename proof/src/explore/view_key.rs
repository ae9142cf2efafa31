//! View keys: what one reader can observe of a report, as a word: equal words, equal reports to that reader.
//!
//! A word holds the counts the reader's arrows read, the request that the writer has open, and the writer's answer to
//! the reader. Counts grow for ever while the line repeats itself, so they are kept relative to a base that follows
//! from the word's own content: two equal reports then have the same word and the same base, whenever they were made.
//!
//! Request numbers never repeat and so grow for ever as well. Of a number matters only whether it is the one that is
//! open: a request that has been closed still blocks the counts it names until the reader receives its end, but an
//! answer to it is void.

use linewright_line::{OpId, StationId};
use linewright_station_logic::{AgreementAnswer, AgreementRequest, StationReport};
use rustc_hash::FxHashMap;

/// A word with its base; 0 is "no word".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct ViewKey {
    pub id: u32,
    pub base: i32,
}

impl ViewKey {
    /// Nothing on its way.
    pub const NONE: ViewKey = ViewKey { id: 0, base: 0 };
    /// That of a writer that has lost its memory.
    pub const LOST: ViewKey = ViewKey { id: 1, base: 0 };

    /// Whether its base has a meaning, on a link whose words have one.
    #[inline]
    pub fn has_base(self) -> bool {
        self.id > ViewKey::LOST.id
    }

    /// The same word when the origin its base refers to moves by `by`.
    pub fn shifted(self, by: i32, words: &ViewKeys) -> ViewKey {
        if !words.has_base || !self.has_base() { self } else { ViewKey { id: self.id, base: self.base + by } }
    }
}

/// Content of a word.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ReportView {
    /// The counts, relative to the base.
    pub counts: Vec<i32>,
    /// The writer's cycle, relative to the base, where a rule reads it; otherwise 0.
    pub cycle: i32,
    /// The operations of the request it has made, and whether that is still open.
    pub request: Option<(u64, bool)>,
    /// Its answer to the request that the reader has open.
    pub answer: Option<Option<OpId>>,
    /// The writer has lost its memory. Nothing else counts then, since nothing can be compared.
    pub is_lost: bool,
}

/// The words of one link.
#[derive(Debug)]
pub(crate) struct ViewKeys {
    /// The rule that reads flags instead of counts compares with the writer's cycle.
    with_cycle: bool,
    has_base: bool,
    numbers: FxHashMap<ReportView, u32>,
    contents: Vec<ReportView>,
}

impl ReportView {
    const NOTHING: ReportView =
        ReportView { counts: Vec::new(), cycle: 0, request: None, answer: None, is_lost: false };
}

impl ViewKeys {
    pub fn new(with_cycle: bool, counts: usize) -> Self {
        let has_base = with_cycle || counts > 0;
        let contents = vec![ReportView::NOTHING, ReportView { is_lost: true, ..ReportView::NOTHING }];
        ViewKeys { with_cycle, has_base, numbers: FxHashMap::default(), contents }
    }

    /// Whether its words have a base.
    pub fn has_base(&self) -> bool {
        self.has_base
    }

    pub fn content(&self, id: u32) -> &ReportView {
        &self.contents[id as usize]
    }

    /// The word for counts and cycle as they stand relative to some origin; its base is relative to the same.
    pub fn word(
        &mut self,
        counts: impl Iterator<Item = i32>,
        cycle: i32,
        request: Option<(u64, bool)>,
        answer: Option<Option<OpId>>,
    ) -> ViewKey {
        let mut counts: Vec<i32> = counts.collect();
        let base = match counts.first() {
            Some(&first) => first,
            None if self.with_cycle => cycle,
            None => 0,
        };
        counts.iter_mut().for_each(|count| *count -= base);
        let cycle = if self.with_cycle { cycle - base } else { 0 };
        ViewKey { id: self.number(ReportView { counts, cycle, request, answer, is_lost: false }), base }
    }

    fn number(&mut self, content: ReportView) -> u32 {
        if let Some(&number) = self.numbers.get(&content) {
            return number;
        }
        let number = self.contents.len() as u32;
        self.contents.push(content.clone());
        self.numbers.insert(content, number);
        number
    }

    /// The word after its writer has closed the request it names.
    pub fn closed(&mut self, word: ViewKey) -> ViewKey {
        let content = self.content(word.id);
        let Some((ops, true)) = content.request else { return word };
        let content = ReportView { request: Some((ops, false)), ..content.clone() };
        ViewKey { id: self.number(content), base: word.base }
    }

    /// The word after its reader has closed the request it answers.
    pub fn unanswered(&mut self, word: ViewKey) -> ViewKey {
        let content = self.content(word.id);
        if content.answer.is_none() {
            return word;
        }
        let content = ReportView { answer: None, ..content.clone() };
        ViewKey { id: self.number(content), base: word.base }
    }
}

/// The numbers that a report to a controller needs.
pub(crate) struct ReportNumbers {
    /// The number of the writer's request.
    pub request: u64,
    /// The reader's open request, if it has one.
    pub answered: Option<u64>,
}

/// A report that means the word to `reader`. `ops`: number of the writer's operations; counts that the reader does not
/// read are anything.
pub(crate) fn report(
    content: &ReportView,
    base: i32,
    read: &[OpId],
    ops: usize,
    reader: (StationId, u64),
    numbers: &ReportNumbers,
) -> StationReport {
    let mut done = vec![base; ops];
    for (op, count) in read.iter().zip(&content.counts) {
        done[op.index()] = base + count;
    }
    let answers = match (content.answer, numbers.answered) {
        (Some(in_the_way), Some(number)) => {
            vec![AgreementAnswer { to: reader.0, boot_id: reader.1, number, in_the_way }]
        }
        _ => Vec::new(),
    };
    StationReport {
        boot_id: 1,
        generation: u64::from(!content.is_lost),
        cycle: base + content.cycle,
        done,
        request: content.request.map(|(ops, _)| AgreementRequest { number: numbers.request, ops }),
        answers,
        ..StationReport::default()
    }
}
