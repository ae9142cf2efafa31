//! Reading one table of a scenario, key by key, without losing a problem.
//!
//! It remembers which keys were asked for, so the list of known keys exists only as the code that reads them.

use std::ops::Range;
use std::time::Duration;

use linewright_line::{Problem, suggestion};
use toml_edit::{Item, TableLike};

/// More problems are not worth reading.
const PROBLEMS_MAX: usize = 100;

/// Where problems are put.
#[derive(Default)]
pub(super) struct Report {
    problems: Vec<Problem>,
}

impl Report {
    pub(super) fn error(&mut self, span: Range<usize>, message: impl Into<String>, hint: Option<String>) {
        if self.problems.len() < PROBLEMS_MAX {
            self.problems.push(Problem::error(span, message).maybe_hint(hint));
        }
    }

    pub(super) fn into_vec(self) -> Vec<Problem> {
        self.problems
    }
}

/// A value and where it stands.
pub(super) type At<T> = (T, Range<usize>);

/// One table being read.
pub(super) struct Fields<'a> {
    table: &'a dyn TableLike,
    pub(super) at: Range<usize>,
    what: &'static str,
    asked: Vec<&'static str>,
}

impl<'a> Fields<'a> {
    pub(super) fn new(table: &'a dyn TableLike, at: Range<usize>, what: &'static str) -> Self {
        Fields { table, at, what, asked: Vec::new() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    fn read<T>(
        &mut self,
        report: &mut Report,
        key: &'static str,
        expected: &str,
        get: impl FnOnce(&'a Item) -> Option<T>,
    ) -> Option<At<T>> {
        self.asked.push(key);
        let (found, item) = self.table.get_key_value(key)?;
        let at = item.span().or_else(|| found.span()).unwrap_or_else(|| self.at.clone());
        let value = get(item);
        if value.is_none() {
            report.error(at.clone(), format!("`{key}` must be {expected}"), None);
        }
        value.map(|value| (value, at))
    }

    pub(super) fn text(&mut self, report: &mut Report, key: &'static str) -> Option<At<&'a str>> {
        self.read(report, key, "text in quotes", Item::as_str)
    }

    pub(super) fn flag(&mut self, report: &mut Report, key: &'static str) -> Option<At<bool>> {
        self.read(report, key, "true or false", Item::as_bool)
    }

    /// A number within bounds.
    pub(super) fn number(&mut self, report: &mut Report, key: &'static str, low: f64, high: f64) -> Option<At<f64>> {
        let number = |item: &Item| item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64));
        let (value, at) = self.read(report, key, "a number", number)?;
        if (low..=high).contains(&value) {
            return Some((value, at));
        }
        report.error(at, format!("`{key}` is {value}"), Some(format!("between {low} and {high}")));
        None
    }

    /// A whole number from 0 to `high`.
    pub(super) fn whole(&mut self, report: &mut Report, key: &'static str, high: usize) -> Option<At<usize>> {
        let (value, at) = self.read(report, key, "a whole number", Item::as_integer)?;
        match usize::try_from(value) {
            Ok(whole) if whole <= high => Some((whole, at)),
            Ok(_) | Err(_) => {
                report.error(at, format!("`{key}` is {value}"), Some(format!("between 0 and {high}")));
                None
            }
        }
    }

    /// A time in seconds, at most a day.
    pub(super) fn seconds(&mut self, report: &mut Report, key: &'static str) -> Option<At<Duration>> {
        let (value, at) = self.number(report, key, 0.0, 86_400.0)?;
        Some((Duration::from_secs_f64(value), at))
    }

    /// A list of texts.
    pub(super) fn texts(&mut self, report: &mut Report, key: &'static str) -> Option<At<Vec<At<&'a str>>>> {
        let (array, at) = self.read(report, key, "a list of texts", Item::as_array)?;
        let mut texts = Vec::new();
        for value in array {
            let here = value.span().unwrap_or_else(|| at.clone());
            match value.as_str() {
                Some(text) => texts.push((text, here)),
                None => report.error(here, format!("an entry of `{key}` must be text in quotes"), None),
            }
        }
        Some((texts, at))
    }

    pub(super) fn table(&mut self, report: &mut Report, key: &'static str, what: &'static str) -> Option<Fields<'a>> {
        let (table, at) = self.read(report, key, "a table", Item::as_table_like)?;
        Some(Fields::new(table, at, what))
    }

    /// `[[key]]` blocks, at most `max` of them.
    pub(super) fn blocks(
        &mut self,
        report: &mut Report,
        key: &'static str,
        what: &'static str,
        max: usize,
    ) -> Vec<Fields<'a>> {
        let expected = "blocks, each under a header with two brackets";
        let Some((blocks, at)) = self.read(report, key, expected, Item::as_array_of_tables) else {
            return Vec::new();
        };
        if blocks.len() > max {
            report.error(at, format!("{} times `{key}`", blocks.len()), Some(format!("at most {max}")));
            return Vec::new();
        }
        let place = |block: &toml_edit::Table| block.span().unwrap_or_else(|| at.clone());
        blocks.iter().map(|block| Fields::new(block, place(block), what)).collect()
    }

    /// Reports every key that nobody asked for.
    pub(super) fn finish(self, report: &mut Report) {
        for (key, item) in self.table.iter() {
            if !self.asked.contains(&key) {
                let at = self.table.key(key).and_then(|k| k.span()).or_else(|| item.span());
                let hint = suggestion(key, self.asked.iter().copied());
                report.error(
                    at.unwrap_or_else(|| self.at.clone()),
                    format!("unknown key `{key}` in {}", self.what),
                    hint,
                );
            }
        }
    }
}
