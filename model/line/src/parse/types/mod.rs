//! Station types: a description with `[[station_type]]` → the same description with every station written out.
//!
//! This is done to the text, before any other pass: the result is one text that could have been written by hand, and
//! nothing after it has types. A [`Splice`] keeps where each stretch comes from, so that problems of the written out text
//! are shown in the type, with the station that uses it, or at the parameter.

mod blocks;
mod pattern;
mod read;

use linewright_text::{BYTES_MAX, NoteId, Problem, Report, Splice, TextRange};

use blocks::{BlockOwner, TextBlock};
use pattern::{PatternPart, TypeEdit};
use read::{StationType, TypedStation};

/// Keys of a type that are written beside the station, not in it.
const BESIDE: [&str; 4] = ["arrow", "conflict", "device", "sensor"];
/// Nothing in a description is deeper.
const DEPTH_MAX: usize = 32;

/// The text with every station of a type written out; the text itself where there is none. `None`, and problems, where
/// that cannot be done.
pub(super) fn expand(text: &str, report: &mut Report) -> Option<Splice> {
    // What is no TOML is reported by the reader.
    let Some(document) = linewright_text::document(text, &mut Report::default()) else {
        return Some(Splice::whole(text));
    };
    let root = document.as_table();
    if !read::has_types(root) {
        return Some(Splice::whole(text));
    }
    let types = read::types(root, report);
    let stations = read::stations(root, &types, text, report);
    read::unused(&types, &stations, report);
    if report.has_errors() {
        return None;
    }
    let blocks = blocks::blocks(root, text);
    let mut writer = Writer { text, types: &types, blocks: &blocks.all, splice: Splice::default() };
    writer.splice.copy(text, 0..blocks.preamble, None);
    for block in &blocks.all {
        let typed = match block.owner {
            BlockOwner::Type(_) => continue,
            BlockOwner::Station(nth) => stations.iter().find(|station| station.nth == nth),
            BlockOwner::Others => None,
        };
        match typed {
            Some(station) if block.path.len() == 1 => {
                writer.station(block, station);
                if writer.splice.text().len() > BYTES_MAX {
                    report.add(
                        Problem::error(
                            station.of.at.clone(),
                            "with all stations written out the description is too long",
                        )
                        .label("with this one")
                        .hint(format!("at most {BYTES_MAX} bytes")),
                    );
                    return None;
                }
            }
            Some(_) if block.path[1..] == ["parameters"] => {}
            Some(_) | None => {
                writer.splice.end_line();
                writer.splice.copy(text, block.lead..block.body.end, None);
            }
        }
    }
    writer.splice.copy(text, blocks.rest..text.len(), None);
    Some(writer.splice)
}

/// Puts the new text together.
struct Writer<'a> {
    text: &'a str,
    types: &'a [StationType<'a>],
    blocks: &'a [TextBlock<'a>],
    splice: Splice,
}

impl Writer<'_> {
    /// Writes out a station with its type.
    fn station(&mut self, block: &TextBlock<'_>, station: &TypedStation) {
        let of = &self.types[station.kind];
        let label = format!("station `{}` is of this type", station.name.value);
        let note = self.splice.note(station.of.at.clone(), label, &station.name.value);
        self.splice.end_line();
        self.splice.copy(self.text, block.lead..block.at.end, None);
        self.stretch(block.body.clone(), &station.cuts, station, None);
        let parts = self.blocks.iter().filter(|block| block.owner == BlockOwner::Type(station.kind));
        for (nth, part) in parts.enumerate() {
            self.splice.end_line();
            if nth > 0 {
                self.splice.copy(self.text, part.lead..part.at.start, Some(note));
                self.splice.put(&part.header(), part.at.clone(), Some(note));
            }
            self.stretch(part.body.clone(), &of.edits, station, Some(note));
        }
        for (header, entry, keys) in &of.inline {
            self.splice.end_line();
            self.splice.put(&format!("\n[[{header}]]\n"), entry.clone(), Some(note));
            for key in keys {
                self.stretch(key.clone(), &of.edits, station, Some(note));
                self.splice.end_line();
            }
        }
        self.splice.end_line();
    }

    /// A stretch of the text with its edits.
    fn stretch(&mut self, range: TextRange, edits: &[TypeEdit], station: &TypedStation, note: Option<NoteId>) {
        let mut at = range.start;
        let first = edits.partition_point(|edit| edit.at.start < range.start);
        for edit in edits[first..].iter().take_while(|edit| edit.at.end <= range.end) {
            // An edit within one that is left out is left out as well. A text that is too long is not used.
            if edit.at.start < at || self.splice.text().len() > BYTES_MAX {
                continue;
            }
            self.splice.copy(self.text, at..edit.at.start, note);
            self.edit(edit, station, note);
            at = if edit.parts.is_empty() { self.after(&edit.at).min(range.end) } else { edit.at.end };
        }
        self.splice.copy(self.text, at..range.end.max(at), note);
    }

    /// Beginning of the text behind what is left out: where nothing else stands in its line, the next line.
    fn after(&self, out: &TextRange) -> usize {
        let is_blank = |words: &str| words.trim().is_empty();
        let before = self.text[..out.start].rsplit('\n').next().is_none_or(is_blank);
        match self.text[out.end..].split_once('\n') {
            Some((rest, _)) if before && is_blank(rest) => out.end + rest.len() + 1,
            _ => out.end,
        }
    }

    fn edit(&mut self, edit: &TypeEdit, station: &TypedStation, note: Option<NoteId>) {
        match &edit.parts[..] {
            [] => {}
            [PatternPart::Parameter(parameter)] if !edit.is_key => {
                let value = &station.values[*parameter];
                let what = format!("`{}` of station `{}` stands here", value.name, station.name.value);
                let note = self.splice.note(edit.at.clone(), what, "");
                self.splice.put(&value.source, value.at.clone(), Some(note));
            }
            parts => {
                let words = parts.iter().map(|part| match part {
                    PatternPart::Words(words) => words.as_str(),
                    PatternPart::Parameter(parameter) => station.values[*parameter].words.as_str(),
                });
                let words = words.collect::<String>();
                let text = if edit.is_key { pattern::as_key(&words) } else { pattern::quoted(&words) };
                self.splice.put(&text, edit.at.clone(), note);
            }
        }
    }
}
