//! A text in blocks: each header with the comment above it and the keys below it.

use linewright_text::TextRange;
use toml_edit::{Item, Table};

use super::{BESIDE, DEPTH_MAX};

/// Owner of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlockOwner {
    /// The type of this number.
    Type(usize),
    /// The station of this number.
    Station(usize),
    Others,
}

pub(super) struct TextBlock<'a> {
    pub owner: BlockOwner,
    pub path: Vec<&'a str>,
    is_list: bool,
    /// Beginning of the comment above the header.
    pub lead: usize,
    /// The header.
    pub at: TextRange,
    /// From behind the header to the end of the line of its last value.
    pub body: TextRange,
}

pub(super) struct Blocks<'a> {
    /// End of the keys above the first header.
    pub preamble: usize,
    /// In the order of the text.
    pub all: Vec<TextBlock<'a>>,
    /// End of the last block.
    pub rest: usize,
}

impl TextBlock<'_> {
    /// The header of a type's block in the station's place: `[[station.operation]]`, `[[device]]`, `[device.drive]`.
    pub fn header(&self) -> String {
        let beside = self.path.get(1).is_some_and(|key| BESIDE.contains(key));
        let first = if beside { None } else { Some("station") };
        let keys = first.into_iter().chain(self.path.iter().skip(1).copied());
        let path = keys.map(|key| toml_edit::Key::new(key).to_string()).collect::<Vec<_>>().join(".");
        if self.is_list { format!("[[{path}]]") } else { format!("[{path}]") }
    }
}

pub(super) fn blocks<'a>(root: &'a Table, text: &str) -> Blocks<'a> {
    let mut found = Walk { blocks: Vec::new(), ends: Vec::new() };
    found.table(root, &mut Vec::new(), BlockOwner::Others);
    let Walk { blocks: mut all, mut ends } = found;
    all.sort_by_key(|block| block.at.start);
    ends.sort_unstable();
    let line_end = |at: usize| text[at..].find('\n').map_or(text.len(), |more| at + more + 1);
    // The end of the last value before the next header.
    let end = |from: usize, next: usize| {
        let before = ends.partition_point(|&end| end <= next);
        let last = ends[..before].last().copied().filter(|&end| end > from).unwrap_or(from);
        if last == 0 { 0 } else { line_end(last).min(next) }
    };
    let starts: Vec<usize> = all.iter().map(|block| block.at.start).chain([text.len()]).collect();
    let preamble = end(0, starts[0]);
    let mut lead = preamble;
    for (block, next) in all.iter_mut().zip(&starts[1..]) {
        block.lead = lead;
        block.body = block.at.end..end(block.at.end, *next);
        lead = block.body.end;
    }
    Blocks { preamble, all, rest: lead }
}

struct Walk<'a> {
    blocks: Vec<TextBlock<'a>>,
    /// Ends of values.
    ends: Vec<usize>,
}

impl<'a> Walk<'a> {
    fn table(&mut self, table: &'a Table, path: &mut Vec<&'a str>, owner: BlockOwner) {
        if path.len() > DEPTH_MAX {
            return;
        }
        for (key, item) in table.iter() {
            path.push(key);
            match item {
                Item::Table(inner) => {
                    if !inner.is_dotted() && !inner.is_implicit() {
                        self.block(inner, path, owner, false);
                    }
                    self.table(inner, path, owner);
                }
                Item::ArrayOfTables(list) => {
                    for (nth, inner) in list.iter().enumerate() {
                        let owner = match path[..] {
                            ["station_type"] => BlockOwner::Type(nth),
                            ["station"] => BlockOwner::Station(nth),
                            _ => owner,
                        };
                        self.block(inner, path, owner, true);
                        self.table(inner, path, owner);
                    }
                }
                Item::Value(value) => self.ends.extend(value.span().map(|span| span.end)),
                Item::None => {}
            }
            path.pop();
        }
    }

    fn block(&mut self, table: &Table, path: &[&'a str], owner: BlockOwner, is_list: bool) {
        if let Some(at) = table.span() {
            let body = at.end..at.end;
            self.blocks.push(TextBlock { owner, path: path.to_vec(), is_list, lead: at.start, at, body });
        }
    }
}
