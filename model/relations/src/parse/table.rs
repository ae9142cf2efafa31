//! A table as it was written: its columns, and the cells of each row, with their places.
//!
//! Commas, semicolons and tabs separate, whichever the first line has most of: spreadsheets write each of them.

use csv_core::{ReadFieldResult, ReaderBuilder};
use linewright_text::{Located, LocatedName, Problem, Report, TextRange, suggestion};

/// At most this many rows of one table.
const ROWS_MAX: usize = 20_000;
/// At most this many columns.
const COLUMNS_MAX: usize = 500;
/// The longest cell, in bytes.
const CELL_MAX: usize = 2000;

/// A table as it was written.
pub(super) struct WrittenTable {
    /// The first line, in lower case where it is one of ours.
    pub columns: Vec<LocatedName>,
    pub rows: Vec<WrittenRow>,
}

/// A row of it.
pub(super) struct WrittenRow {
    /// Its line, from 1.
    pub line: u32,
    /// All of it.
    pub at: TextRange,
    /// As many as there are columns.
    pub cells: Vec<LocatedName>,
}

impl WrittenTable {
    /// The number of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.value == name)
    }
}

/// Reads a table. `known` are its columns, of which the first `required` must be there; others are reported, unless the table
/// may have columns of its own.
pub(super) fn read(text: &str, known: &[&str], required: usize, has_own: bool, report: &mut Report) -> WrittenTable {
    let mut lines = split(text, report).into_iter();
    let Some((_, head)) = lines.next() else {
        let columns = known[..required].join(",");
        report.add(Problem::error(0..0, "this table is empty").hint(format!("its first line is `{columns}`")));
        return WrittenTable { columns: Vec::new(), rows: Vec::new() };
    };
    let mut columns: Vec<LocatedName> = head;
    for column in &mut columns {
        if let Some(own) = known.iter().find(|known| known.eq_ignore_ascii_case(&column.value)) {
            column.value = (*own).to_owned();
        } else if !has_own {
            report.add(
                Problem::error(column.at.clone(), format!("unknown column `{}`", column.value))
                    .maybe_hint(suggestion(&column.value, known.iter().copied())),
            );
        }
    }
    for (nth, column) in columns.iter().enumerate() {
        if let Some(first) = columns[..nth].iter().find(|first| first.value == column.value) {
            report.add(
                Problem::error(column.at.clone(), format!("a second column `{}`", column.value))
                    .earlier(first.at.clone()),
            );
        }
    }
    for name in &known[..required] {
        if !columns.iter().any(|column| column.value == *name) {
            let end = columns.last().map_or(0..0, |column| column.at.clone());
            report.add(
                Problem::error(end, format!("this table has no column `{name}`")).hint("add it to the first line"),
            );
        }
    }
    let mut rows = Vec::new();
    for (line, mut cells) in lines {
        let at = cells.first().map_or(0, |cell| cell.at.start)..cells.last().map_or(0, |cell| cell.at.end);
        if let Some(more) = cells.get(columns.len()).filter(|cell| !cell.value.is_empty()) {
            report.add(
                Problem::error(
                    more.at.clone(),
                    format!("this row has more cells than the first line has columns ({})", columns.len()),
                )
                .hint("put a cell that contains the separator into quotes"),
            );
        }
        cells.resize(columns.len(), Located::new(String::new(), at.end..at.end));
        rows.push(WrittenRow { line, at, cells });
    }
    WrittenTable { columns, rows }
}

/// The cells of each line that has any, with the number of the line.
fn split(text: &str, report: &mut Report) -> Vec<(u32, Vec<LocatedName>)> {
    let begin = if text.starts_with('\u{feff}') { 3 } else { 0 };
    let first = text[begin..].lines().next().unwrap_or_default();
    let count = |sign: u8| first.bytes().filter(|byte| *byte == sign).count();
    let separator = [b'\t', b';', b','].into_iter().max_by_key(|sign| count(*sign)).unwrap_or(b',');
    let mut reader = ReaderBuilder::new().delimiter(separator).build();
    let (mut at, mut rows, mut cells) = (begin, Vec::new(), Vec::new());
    let (mut line, mut counted) = (1, 0);
    let mut cell = vec![0; CELL_MAX];
    loop {
        let start = at;
        let (mut filled, mut is_long) = (0, false);
        let ends_record = loop {
            let (result, read, written) = reader.read_field(&text.as_bytes()[at..], &mut cell[filled..]);
            (at, filled) = (at + read, filled + written);
            match result {
                ReadFieldResult::InputEmpty => {}
                ReadFieldResult::OutputFull => (filled, is_long) = (0, true),
                ReadFieldResult::Field { record_end } => break record_end,
                ReadFieldResult::End => return rows,
            }
        };
        let place = trimmed(text, start..at, separator);
        if is_long {
            report.add(
                Problem::error(place.clone(), format!("a cell of more than {CELL_MAX} bytes"))
                    .hint("is a quote missing?"),
            );
            filled = 0;
        }
        let value = String::from_utf8_lossy(&cell[..filled]).trim().to_owned();
        cells.push(Located::new(value, place));
        if !ends_record {
            continue;
        }
        let begins = cells[0].at.start;
        line += text.as_bytes()[counted..begins].iter().filter(|byte| **byte == b'\n').count();
        counted = begins;
        if cells.len() > COLUMNS_MAX || rows.len() > ROWS_MAX {
            let message = format!("more than {ROWS_MAX} rows or {COLUMNS_MAX} columns");
            report.add(Problem::error(cells[0].at.clone(), message).hint("is this the right file?"));
            return rows;
        }
        if cells.iter().any(|cell| !cell.value.is_empty()) {
            rows.push((u32::try_from(line).unwrap_or(u32::MAX), std::mem::take(&mut cells)));
        }
        cells.clear();
    }
}

/// The place of a cell without what separates it, and without blanks.
fn trimmed(text: &str, of: TextRange, separator: u8) -> TextRange {
    let (mut start, mut end) = (of.start, of.end);
    let bytes = text.as_bytes();
    let is_blank = |byte: u8| byte.is_ascii_whitespace();
    while start < end && is_blank(bytes[start]) && bytes[start] != separator {
        start += 1;
    }
    if end > start && bytes[end - 1] == separator {
        end -= 1;
    }
    while end > start && is_blank(bytes[end - 1]) {
        end -= 1;
    }
    start..end
}
