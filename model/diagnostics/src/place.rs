//! Places in a text, and the lines they are in.

use std::ops::Range;

/// A stretch of the text, in bytes, for readers that keep many. Files are far smaller than 32 bits can count.
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

impl From<At> for Range<usize> {
    fn from(at: At) -> Self {
        at.start as usize..at.end as usize
    }
}

/// `span` cut to the text and to whole characters: what a drawing can be made of, whatever a library reported.
pub(crate) fn within(text: &str, span: &Range<usize>) -> Range<usize> {
    let whole = |at: &usize| text.is_char_boundary(*at);
    let start = (0..=span.start.min(text.len())).rev().find(whole).unwrap_or(0);
    start..(span.end.max(start)..text.len()).find(whole).unwrap_or(text.len())
}

/// The lines of a text in which something is wrong, counted in one pass. The beginnings of all lines would be many times
/// as long as a text that consists of line ends.
pub(crate) struct Lines {
    /// For some bytes of the text: the line they are in, from 1, and where that line starts. Ascending.
    lines: Vec<(usize, usize, usize)>,
}

impl Lines {
    /// The lines of the bytes `wanted`.
    pub(crate) fn of(text: &str, mut wanted: Vec<usize>) -> Self {
        wanted.sort_unstable();
        let mut lines = Vec::with_capacity(wanted.len());
        let (mut line, mut start, mut seen) = (1, 0, 0);
        for at in wanted {
            for (newline, _) in text.as_bytes()[seen..at].iter().enumerate().filter(|&(_, &byte)| byte == b'\n') {
                (line, start) = (line + 1, seen + newline + 1);
            }
            seen = at;
            lines.push((at, line, start));
        }
        Lines { lines }
    }

    /// The line such a byte is in, from 1, and where that line starts.
    pub(crate) fn line(&self, at: usize) -> (usize, usize) {
        let found = self.lines.binary_search_by_key(&at, |&(at, ..)| at);
        found.map_or((1, 0), |index| (self.lines[index].1, self.lines[index].2))
    }
}
