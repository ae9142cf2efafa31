//! TableFindings of all files, and the places of what was read.

use std::collections::{HashMap, HashSet};

use linewright_text::{Located, LocatedName, Problem, Report, TextRange, suggestion};

use super::SourceText;
use super::table::{WrittenRow, WrittenTable};
use crate::{ComponentRef, ConditionId, MachineId, Relations, TableRow};

/// Something of `relations.toml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum DescribedPart {
    Machine(MachineId),
    Condition(ConditionId),
}

/// TableFindings of all files, and the places of what was read.
pub(super) struct TableFindings<'a> {
    pub sources: &'a [SourceText<'a>],
    /// One for each source.
    pub reports: Vec<Report>,
    rows: HashMap<TableRow, (TextRange, HashMap<String, TextRange>)>,
    parts: HashMap<DescribedPart, TextRange>,
    /// What has been reported of rows: a row that is in several sequences has its problems once.
    known: HashSet<(TableRow, String)>,
    /// Operations that are declared, and not understood: their names are no slips.
    misread: Vec<String>,
    /// The source that is `relations.toml`.
    pub description: usize,
}

impl<'a> TableFindings<'a> {
    pub fn new(sources: &'a [SourceText<'a>], description: usize) -> Self {
        let reports = sources.iter().map(|_| Report::default()).collect();
        TableFindings {
            sources,
            reports,
            rows: HashMap::new(),
            parts: HashMap::new(),
            known: HashSet::new(),
            misread: Vec::new(),
            description,
        }
    }

    /// Notes where a row is.
    pub fn note_row(&mut self, row: TableRow, table: &WrittenTable, written: &WrittenRow) {
        let cells = table.columns.iter().zip(&written.cells);
        let cells = cells.map(|(column, cell)| (column.value.clone(), cell.at.clone())).collect();
        self.rows.insert(row, (written.at.clone(), cells));
    }

    /// Notes where a part of the description is.
    pub fn note_part(&mut self, part: DescribedPart, at: TextRange) {
        self.parts.insert(part, at);
    }

    /// A cell of a row; all of the row where the column is not there or empty.
    fn cell(&self, row: TableRow, column: &str) -> TextRange {
        let Some((whole, cells)) = self.rows.get(&row) else { return 0..0 };
        cells.get(column).filter(|cell| !cell.is_empty()).unwrap_or(whole).clone()
    }

    /// Adds an error at a cell of a row.
    pub fn error(&mut self, row: TableRow, column: &str, message: impl Into<String>, hint: impl Into<String>) {
        self.add(row, Problem::error(self.cell(row, column), message).hint(hint));
    }

    /// Adds a warning at a cell of a row.
    pub fn warning(&mut self, row: TableRow, column: &str, message: impl Into<String>, hint: impl Into<String>) {
        self.add(row, Problem::warning(self.cell(row, column), message).hint(hint));
    }

    fn add(&mut self, row: TableRow, problem: Problem) {
        if self.known.insert((row, problem.message.clone())) {
            self.reports[row.file].add(problem);
        }
    }

    /// Notes an operation that is declared, and not understood.
    pub fn note_misread(&mut self, operation: String) {
        self.misread.push(operation);
    }

    /// Adds an error about a name that stands for nothing, unless it is that of something that was not understood.
    pub fn unknown(&mut self, file: usize, name: LocatedName, what: &str, hint: Option<String>) {
        if !self.misread.contains(&name.value) {
            let message = format!("unknown {what} `{}`", shown(&name.value));
            self.reports[file].add_unknown(Problem::error(name.at, message).maybe_hint(hint));
        }
    }

    /// Whether anything has an error.
    pub fn has_errors(&self) -> bool {
        self.reports.iter().any(Report::has_errors)
    }

    /// Adds an error at a part of the description.
    pub fn error_at(&mut self, part: DescribedPart, message: impl Into<String>, hint: impl Into<String>) {
        let at = self.parts.get(&part).cloned().unwrap_or(0..0);
        self.reports[self.description].add(Problem::error(at, message).hint(hint));
    }

    /// The text of a cell, without its quotes, and where it begins.
    pub fn written(&self, file: usize, cell: &LocatedName) -> (&'a str, usize) {
        let text = self.sources[file].text.get(cell.at.clone()).unwrap_or_default();
        let inside = text.strip_prefix('"').map(|text| text.strip_suffix('"').unwrap_or(text));
        (inside.unwrap_or(text), cell.at.start + usize::from(inside.is_some()))
    }

    /// The names in a cell, separated by commas, semicolons or blanks; `-` for none.
    pub fn names(&self, file: usize, cell: &LocatedName) -> Vec<LocatedName> {
        let (text, begin) = self.written(file, cell);
        if text.trim() == "-" {
            return Vec::new();
        }
        let is_between = |sign: char| sign.is_whitespace() || ",;".contains(sign);
        let names = text.split(is_between).filter(|name| !name.is_empty());
        let located = names.map(|name| {
            let at = begin + (name.as_ptr() as usize - text.as_ptr() as usize);
            Located::new(name.to_owned(), at..at + name.len())
        });
        located.collect()
    }

    /// The number of a name, or a problem with what it could have been.
    pub fn find<'n>(
        &mut self,
        file: usize,
        name: &LocatedName,
        what: &str,
        known: impl Iterator<Item = &'n str> + Clone,
    ) -> Option<usize> {
        let found = known.clone().position(|known| known == name.value);
        if found.is_none() {
            self.unknown(file, name.clone(), what, suggestion(&name.value, known));
        }
        found
    }

    /// The numbers of the names in a cell; those that stand for nothing, or twice, are reported.
    pub fn find_all<'n>(
        &mut self,
        file: usize,
        cell: &LocatedName,
        what: &str,
        known: impl Iterator<Item = &'n str> + Clone,
    ) -> Vec<usize> {
        let mut found = Vec::new();
        for name in self.names(file, cell) {
            let Some(id) = self.find(file, &name, what, known.clone()) else { continue };
            if found.contains(&id) {
                self.reports[file].add(Problem::error(name.at, format!("{what} `{}` twice", name.value)));
            } else {
                found.push(id);
            }
        }
        found
    }

    /// The component that a name stands for: `MACHINE.component`, or `component` of `own`.
    pub fn component(
        &mut self,
        relations: &Relations,
        file: usize,
        name: &LocatedName,
        own: Option<MachineId>,
    ) -> Option<ComponentRef> {
        let split = name.value.split_once('.');
        let (machine, rest) = match split {
            Some((machine, component)) => {
                let at = name.at.clone();
                let machine = Located::new(machine.to_owned(), at.clone());
                let id = self.find(file, &machine, "machine", relations.machines.iter().map(|m| m.name.as_str()))?;
                (MachineId(id), Located::new(component.to_owned(), at))
            }
            None => (own?, name.clone()),
        };
        let of = relations.machine(machine);
        let what = format!("component of {}", of.name);
        let component = self.find(file, &rest, &what, of.components.iter().map(|component| component.name.as_str()))?;
        Some(ComponentRef { machine, component })
    }
}

/// Foreign text in a message: short, and in one line.
fn shown(text: &str) -> String {
    const CHARS_MAX: usize = 60;
    let short: String = text.chars().take(CHARS_MAX).map(|sign| if sign.is_control() { ' ' } else { sign }).collect();
    if text.chars().nth(CHARS_MAX).is_some() { format!("{short}…") } else { short }
}
