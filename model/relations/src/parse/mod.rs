//! Texts → checked [`Relations`], or all errors of all texts at once.
//!
//! The texts go through three passes, each with one question:
//!
//! 1. `table`, `raw`: is it TOML or a table, and has each key or cell the right type? → values with their places
//! 2. `parts`, `operations`, `sequences`, `executions`, `interlocks`: what does each name stand for? → [`Relations`], as far
//!    as they can be understood
//! 3. `rules`: does it hold together? One function per rule
//!
//! No pass stops at a mistake. What could not be read is absent in the later passes and is passed over there. The rules of the
//! third pass are asked only where every name stands for something: they are about what is not there.

pub(crate) mod executions;
mod findings;
pub(crate) mod interlocks;
pub(crate) mod operations;
mod parts;
mod raw;
mod rules;
pub(crate) mod sequences;
mod table;

use findings::TableFindings;
use linewright_text::{Keys, Problem, Problems, Shape};

use crate::{Relations, TableRow};

/// The name of the description beside the tables.
pub const DESCRIPTION: &str = "relations.toml";

/// A kind of table; files of one kind have names that begin with its word, and end with `.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// Declarations of operations (DOP).
    Operations,
    /// Relations of operations (ROP).
    Relations,
    /// Executions of operations (EOP).
    Executions,
    /// Interlocks (IL).
    Interlocks,
}

impl TableKind {
    /// All kinds, with the beginnings of their files' names.
    pub const ALL: [(&'static str, TableKind); 4] = [
        ("operations", TableKind::Operations),
        ("relations", TableKind::Relations),
        ("executions", TableKind::Executions),
        ("interlocks", TableKind::Interlocks),
    ];

    /// The kind of a file by its name; `None` if it is no table.
    pub fn of_file(name: &str) -> Option<TableKind> {
        let stem = name.strip_suffix(".csv")?;
        TableKind::ALL.iter().find(|(begin, _)| stem.starts_with(begin)).map(|(_, kind)| *kind)
    }
}

/// A text and the name of its file, without its directory.
#[derive(Clone, Copy, Debug)]
pub struct SourceText<'a> {
    pub name: &'a str,
    pub text: &'a str,
}

/// Sound relations.
#[derive(Clone, Debug)]
pub struct ParsedRelations {
    pub relations: Relations,
    /// Warnings of each file that has any.
    pub warnings: Vec<Problems>,
}

/// Reads `relations.toml` and the tables beside it. Files of other names are passed over.
///
/// # Errors
/// All problems of all files, warnings included, each with its place: one [`Problems`] for each file that has any.
pub fn parse(sources: &[SourceText<'_>]) -> Result<ParsedRelations, Vec<Problems>> {
    let Some(description) = sources.iter().position(|source| source.name == DESCRIPTION) else {
        let problem = Problem::error(0..0, format!("there is no {DESCRIPTION}"))
            .hint("it names the cell, its machines, zones and cycle start conditions");
        return Err(vec![Problems::new(DESCRIPTION, "", vec![problem])]);
    };
    let mut findings = TableFindings::new(sources, description);
    let relations = understand(&mut findings);
    let is_wrong = findings.has_errors();
    let reports = findings.reports.into_iter().zip(sources);
    let problems = reports.map(|(report, source)| report.into_problems(source.name, source.text));
    let problems: Vec<Problems> = problems.filter(|problems| !problems.is_empty()).collect();
    match relations {
        Some(relations) if !is_wrong => Ok(ParsedRelations { relations, warnings: problems }),
        _ => Err(problems),
    }
}

/// Keys of `relations.toml`, with types and bounds. Rules between them are checked by [`parse`].
pub fn schema() -> Shape {
    raw::RawRelations::shape()
}

fn understand(findings: &mut TableFindings<'_>) -> Option<Relations> {
    for (source, report) in findings.sources.iter().zip(&mut findings.reports) {
        if !linewright_text::is_bounded(source.text, "the file", report) {
            return None;
        }
    }
    let text = findings.sources[findings.description].text;
    let raw = raw::read(text, &mut findings.reports[findings.description])?;
    let mut relations = parts::read(&raw, findings);
    relations.files = findings.sources.iter().map(|source| source.name.to_owned()).collect();
    // Operations first: the other tables refer to them.
    for (begin, kind) in TableKind::ALL {
        let of_kind = |(_, source): &(usize, &SourceText<'_>)| TableKind::of_file(source.name) == Some(kind);
        let files: Vec<usize> = findings.sources.iter().enumerate().filter(of_kind).map(|(file, _)| file).collect();
        if files.is_empty() && matches!(kind, TableKind::Operations | TableKind::Relations) {
            let problem = Problem::error(0..0, format!("there is no table {begin}.csv beside this file"));
            findings.reports[findings.description]
                .add(problem.hint(format!("files whose names begin with `{begin}` are read")));
        }
        // Without operations every name in the other tables would stand for nothing.
        if relations.operations.is_empty() && kind != TableKind::Operations {
            break;
        }
        for file in files {
            match kind {
                TableKind::Operations => operations::read(file, &mut relations, findings),
                TableKind::Relations => sequences::read(file, &mut relations, findings),
                TableKind::Executions => executions::read(file, &mut relations, findings),
                TableKind::Interlocks => interlocks::read(file, &mut relations, findings),
            }
        }
    }
    if !findings.has_errors() {
        rules::check(&relations, findings);
    }
    Some(relations)
}

/// The row of a table that a line is.
fn row(file: usize, line: u32) -> TableRow {
    TableRow { file, line }
}
