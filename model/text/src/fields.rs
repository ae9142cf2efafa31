//! Reading one table, key by key, without losing a problem.
//!
//! A [`Fields`] wraps any TOML table, written as a block, inline or with dotted keys: to the rest of the parser they
//! are the same. It records which keys were read, so the list of known keys exists only once, as the code that reads
//! them; [`Fields::finish`] reports the others.

use std::fmt;
use std::time::Duration;

use toml_edit::{Item, Table, TableLike, Value};

use crate::advice::{advised, missing, wrong_type, wrong_value};
use crate::lists::texts_of;
use crate::place::{Located, LocatedName, Named, Scalar, TextRange};
use crate::suggest::nearest_all;
use crate::{Problem, Report, Shape, suggestion, units};

/// No duration of a mechanism or message is sensibly longer.
pub(crate) const DURATION_MAX_S: f64 = 24.0 * 3600.0;
/// Nothing a controller can watch is shorter.
pub(crate) const DURATION_MIN_S: f64 = 1e-6;
/// The longest period, in milliseconds.
pub(crate) const MILLIS_MAX: i64 = 60_000;
/// Longest text of a title or a reason, in bytes.
pub const TEXT_MAX: usize = 500;
/// Largest coordinate: a kilometre in millimetres.
pub(crate) const COORDINATE_MAX: f64 = 1e6;

/// The smallest and largest number that measures something.
pub(crate) const POSITIVE_MIN: f64 = 1e-6;
pub(crate) const POSITIVE_MAX: f64 = 1e9;

/// One table being read.
pub struct Fields<'a> {
    table: &'a dyn TableLike,
    /// Where the table is: its header, or the whole of it when inline.
    pub at: TextRange,
    /// Its name, for messages: "a station", "`moves`".
    what: &'static str,
    asked: Vec<&'static str>,
    /// Meaning of the key that is read next, line by line.
    about: &'static [&'static str],
    /// Its name where that stands in its header, by mistake.
    header_name: Option<LocatedName>,
    /// Keys that are missing, each with the misspelled one that is read for it.
    misspelled: Vec<(&'static str, &'a str)>,
}

impl<'a> Fields<'a> {
    /// The table at this place; `what` it is, for messages: "a station", "`moves`".
    pub fn new(table: &'a dyn TableLike, at: TextRange, what: &'static str) -> Self {
        Fields { table, at, what, asked: Vec::new(), about: &[], header_name: None, misspelled: Vec::new() }
    }

    /// The same table, to be read once more: a key that is missing is read where it is misspelled. None if no key is.
    ///
    /// The rest of the text refers to what is meant: without it, one slip would have many errors follow.
    pub(crate) fn as_meant(&self) -> Option<Self> {
        let mut meant = Vec::new();
        for (written, _) in self.unknown() {
            let near = nearest_all(written, self.asked.iter().copied());
            if let [key] = near[..]
                && let Some(key) = self.asked.iter().find(|asked| **asked == key)
                && (!self.has(key) || [*key, written].iter().all(|key| self.is_blocks(key)))
                && !meant.iter().any(|(known, _)| known == key)
            {
                meant.push((*key, written));
            }
        }
        let header_name = self.header_name.clone();
        let same = Fields { header_name, misspelled: meant, ..Fields::new(self.table, self.at.clone(), self.what) };
        (!same.misspelled.is_empty()).then_some(same)
    }

    /// Whether `[[key]]` blocks are written at `key`.
    fn is_blocks(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(Item::is_array_of_tables)
    }

    /// Whether what was read where its key is misspelled is of the right type.
    pub(crate) fn misspelled_fit(&self, report: &Report) -> bool {
        let places = self.misspelled.iter().filter_map(|(_, written)| self.table.get(written)?.span());
        places.into_iter().all(|span| !report.has_error_at(&span))
    }

    /// The keys that were not read.
    fn unknown(&self) -> impl Iterator<Item = (&'a str, &'a Item)> {
        self.table.iter().filter(|(key, item)| !item.is_none() && !self.asked.contains(key))
    }

    /// The key under which the value of `key` is written.
    fn written<'k>(&self, key: &'k str) -> &'k str
    where
        'a: 'k,
    {
        self.misspelled.iter().find(|(known, _)| *known == key).map_or(key, |(_, written)| written)
    }

    /// Notes the meaning of the key that is read next, for messages.
    pub fn note(&mut self, about: &'static [&'static str]) {
        self.about = about;
    }

    /// Whether nothing is written in it.
    pub fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// Whether anything is written at `key`, whatever it is.
    pub fn has(&self, key: &str) -> bool {
        self.table.get(self.written(key)).is_some_and(|item| !item.is_none())
    }

    /// Whether a table is written at `key`, for what may be a table or something shorter.
    pub fn is_table(&self, key: &str) -> bool {
        self.table.get(self.written(key)).is_some_and(Item::is_table_like)
    }

    /// The item at `key` with its place.
    fn item(&mut self, key: &'static str) -> Option<(&'a Item, TextRange)> {
        self.asked.push(key);
        let (found, item) = self.table.get_key_value(self.written(key))?;
        let at = item.span().or_else(|| found.span()).unwrap_or_else(|| self.at.clone());
        (!item.is_none()).then_some((item, at))
    }

    fn read<T>(
        &mut self,
        report: &mut Report,
        key: &'static str,
        expected: &str,
        get: impl FnOnce(&'a Item) -> Option<T>,
    ) -> Option<Located<T>> {
        let (item, at) = self.item(key)?;
        match get(item) {
            Some(value) => Some(Located::new(value, at)),
            None => {
                report.add(wrong_type(at, key, expected, item));
                None
            }
        }
    }

    /// A value of a simple type. Where another type is written and the advice has a value, that value is read: the rest of the text
    /// refers to it.
    fn scalar<T>(
        &mut self,
        report: &mut Report,
        key: &'static str,
        expected: &str,
        get: fn(&Item) -> Option<T>,
    ) -> Option<Located<T>> {
        let (item, at) = self.item(key)?;
        let value = get(item).or_else(|| {
            report.add(wrong_type(at.clone(), key, expected, item));
            get(&Item::Value(advised(item, expected)?))
        })?;
        Some(Located::new(value, at))
    }

    /// Reports that a required key of this shape is missing.
    pub(crate) fn require<T>(
        &self,
        report: &mut Report,
        key: &'static str,
        shape: &dyn Fn() -> Shape,
        found: Option<T>,
    ) -> Option<T> {
        if found.is_none() && !self.has(key) {
            report.add(
                Problem::error(self.at.clone(), format!("{} needs `{key}`", self.what))
                    .label(format!("no `{key}` here"))
                    .hint(missing(key, &shape(), self.about, self.at == (0..0))),
            );
        }
        found
    }

    /// Any text.
    pub fn text(&mut self, report: &mut Report, key: &'static str) -> Option<LocatedName> {
        if key == "name" && !self.has(key) && self.header_name.is_some() {
            return self.header_name.clone();
        }
        let text = self.read(report, key, "text in quotes", |item| item.as_str().map(str::to_owned))?;
        if text.value.len() > TEXT_MAX {
            report.add(
                Problem::error(text.at, format!("`{key}` has {} bytes", text.value.len()))
                    .hint(format!("at most {TEXT_MAX}")),
            );
            return None;
        }
        Some(text)
    }

    /// True or false.
    pub fn flag(&mut self, report: &mut Report, key: &'static str) -> Option<Located<bool>> {
        self.scalar(report, key, "true or false", Item::as_bool)
    }

    /// A whole number.
    pub fn integer(&mut self, report: &mut Report, key: &'static str) -> Option<Located<i64>> {
        self.scalar(report, key, "a whole number", Item::as_integer)
    }

    /// A coordinate in millimetres.
    pub fn coordinate(&mut self, report: &mut Report, key: &'static str) -> Option<Located<f64>> {
        let number = self.scalar(report, key, "a number", number)?;
        checked_coordinate(report, number, key)
    }

    /// A number above zero: a distance, a speed, a ratio.
    pub fn positive(&mut self, report: &mut Report, key: &'static str) -> Option<Located<f64>> {
        let number = self.scalar(report, key, "a number", number)?;
        let fits = (POSITIVE_MIN..=POSITIVE_MAX).contains(&number.value);
        checked(report, key, number, fits, "a number above zero, at least 0.000001 and at most 1000000000")
    }

    /// Any number.
    pub fn number(&mut self, report: &mut Report, key: &'static str) -> Option<Located<f64>> {
        let number = self.scalar(report, key, "a number", number)?;
        let fits = number.value.is_finite();
        checked(report, key, number, fits, "a finite number")
    }

    /// A number within bounds.
    pub fn within(&mut self, report: &mut Report, key: &'static str, low: f64, high: f64) -> Option<Located<f64>> {
        let number = self.scalar(report, key, "a number", number)?;
        let fits = (low..=high).contains(&number.value);
        checked(report, key, number, fits, format!("between {low} and {high}"))
    }

    /// A whole number within bounds.
    pub fn whole(&mut self, report: &mut Report, key: &'static str, low: i64, high: i64) -> Option<Located<i64>> {
        let number = self.integer(report, key)?;
        let fits = (low..=high).contains(&number.value);
        checked(report, key, number, fits, format!("between {low} and {high}"))
    }

    /// One of a few words; the first one where nothing is written.
    pub fn word<T: Copy>(&mut self, report: &mut Report, key: &'static str, known: &[(&'static str, T)]) -> T {
        self.maybe_word(report, key, known).map_or(known[0].1, |word| word.value)
    }

    /// One of a few words, and its place.
    pub fn maybe_word<T: Copy>(
        &mut self,
        report: &mut Report,
        key: &'static str,
        known: &[(&'static str, T)],
    ) -> Option<Located<T>> {
        let word = self.text(report, key)?;
        if let Some((_, meaning)) = known.iter().find(|(name, _)| *name == word.value) {
            return Some(Located::new(*meaning, word.at));
        }
        let names = known.iter().map(|(name, _)| *name);
        report.add(
            Problem::error(word.at, format!("unknown {key} `{}`", word.value))
                .maybe_hint(suggestion(&word.value, names)),
        );
        None
    }

    /// A positive duration in seconds.
    pub fn seconds(&mut self, report: &mut Report, key: &'static str) -> Option<Located<Duration>> {
        let factor = units::factor(self.written(key), key);
        let mut seconds = self.scalar(report, key, "a number of seconds", number)?;
        seconds.value *= factor;
        if !(DURATION_MIN_S..=DURATION_MAX_S).contains(&seconds.value) {
            report.add(
                Problem::error(seconds.at, format!("`{key}` is {} seconds", seconds.value))
                    .label("not a usable duration")
                    .hint("a duration is positive and at most a day (86400 s)"),
            );
            return None;
        }
        Some(Located::new(Duration::from_secs_f64(seconds.value), seconds.at))
    }

    /// A period in whole milliseconds.
    pub fn millis(&mut self, report: &mut Report, key: &'static str) -> Option<Located<Duration>> {
        let factor = units::factor(self.written(key), key);
        let millis = if factor == 1.0 {
            self.scalar(report, key, "a whole number of milliseconds", Item::as_integer)?
        } else {
            let other = self.scalar(report, key, "a number", number)?;
            Located::new((other.value * factor).round() as i64, other.at)
        };
        match u64::try_from(millis.value) {
            Ok(value) if (1..=MILLIS_MAX).contains(&millis.value) => {
                Some(Located::new(Duration::from_millis(value), millis.at))
            }
            _ => {
                report.add(
                    Problem::error(millis.at, format!("`{key}` is {} ms", millis.value))
                        .hint("between 1 ms and one minute (60000)"),
                );
                None
            }
        }
    }

    /// A list of texts, at most `max` long.
    pub fn texts(&mut self, report: &mut Report, key: &'static str, max: usize) -> Option<Located<Vec<LocatedName>>> {
        let (item, at) = self.item(key)?;
        texts_of(report, key, item, at, max)
    }

    /// A table inside this one.
    pub fn table(&mut self, report: &mut Report, key: &'static str, what: &'static str) -> Option<Fields<'a>> {
        let table = self.read(report, key, "a table, `{ … }`", Item::as_table_like)?;
        Some(Fields::new(table.value, table.at, what))
    }

    /// A list of tables, `[[key]]` blocks or `[{ … }, …]`, at most `max` long.
    pub fn tables(
        &mut self,
        report: &mut Report,
        key: &'static str,
        what: &'static str,
        max: usize,
    ) -> Vec<Fields<'a>> {
        let Some((item, at)) = self.item(key) else { return Vec::new() };
        let mut tables: Vec<Fields<'a>> = Vec::new();
        match item {
            Item::ArrayOfTables(blocks) => {
                // Beside blocks under a misspelled header there may be others, which have their place between them.
                let beside = self.table.get(key).filter(|_| self.written(key) != key);
                let beside = beside.and_then(Item::as_array_of_tables).into_iter().flatten();
                let mut blocks: Vec<&Table> = blocks.iter().chain(beside).collect();
                blocks.sort_by_key(|block| block.span().map(|span| span.start));
                for block in blocks {
                    let at = block.span().unwrap_or_else(|| at.clone());
                    tables.push(Fields::new(block, at, what));
                }
            }
            Item::Value(Value::Array(array)) => {
                for value in array {
                    let at = value.span().unwrap_or_else(|| at.clone());
                    match value.as_inline_table() {
                        Some(table) => tables.push(Fields::new(table, at, what)),
                        None => report.add(wrong_value(at, &format!("an entry of `{key}`"), "a table", value)),
                    }
                }
            }
            other => {
                let problem = wrong_type(at.clone(), key, "a list of tables", other);
                let advice = format!("write each one under a header `[[{key}]]`, with two brackets");
                // What is meant is read all the same: the rest of the text refers to it.
                match other {
                    Item::Table(named) if named.is_implicit() => {
                        report.add(problem.hint(format!("{advice}, and below it `name = \"…\"`")));
                        tables.extend(by_header(named, what));
                    }
                    _ => {
                        report.add(problem.hint(advice));
                        tables.extend(other.as_table_like().map(|table| Fields::new(table, at, what)));
                    }
                }
            }
        }
        if tables.len() > max {
            let problem = Problem::error(tables[max].at.clone(), format!("{} times `{key}`", tables.len()));
            report.add(problem.label("one too many").hint(format!("at most {max}")));
            tables.truncate(max);
        }
        tables
    }

    /// A table of at most `max` texts or whole numbers, under names that are the user's own.
    pub fn scalars(&mut self, report: &mut Report, key: &'static str, max: usize) -> Option<Named<Located<Scalar>>> {
        self.named(report, key, max, |report, name, item, at| {
            let text = item.as_str().filter(|text| text.len() <= TEXT_MAX).map(|text| Scalar::Text(text.to_owned()));
            match text.or_else(|| item.as_integer().map(Scalar::Integer)) {
                Some(value) => Some(Located::new(value, at)),
                None => {
                    report.add(wrong_type(at, name, "text in quotes or a whole number", item));
                    None
                }
            }
        })
    }

    /// A table of at most `max` lists of texts, each at most `longest` long, under names that are the user's own.
    pub fn lists(
        &mut self,
        report: &mut Report,
        key: &'static str,
        max: usize,
        longest: usize,
    ) -> Option<Named<Located<Vec<LocatedName>>>> {
        self.named(report, key, max, |report, name, item, at| texts_of(report, name, item, at, longest))
    }

    /// A table of at most `max` texts, under names that are the user's own.
    pub fn texts_by_name(&mut self, report: &mut Report, key: &'static str, max: usize) -> Option<Named<LocatedName>> {
        self.named(report, key, max, |report, name, item, at| match item.as_str() {
            Some(text) if text.len() <= TEXT_MAX => Some(Located::new(text.to_owned(), at)),
            Some(_) => {
                report.add(Problem::error(at, format!("`{name}` has over {TEXT_MAX} bytes")));
                None
            }
            None => {
                report.add(wrong_type(at, name, "text in quotes", item));
                None
            }
        })
    }

    /// A table of at most `max` coordinates, under names that are the user's own.
    pub fn coordinates(&mut self, report: &mut Report, key: &'static str, max: usize) -> Option<Named<f64>> {
        self.named(report, key, max, |report, name, item, at| match number(item) {
            Some(value) => checked_coordinate(report, Located::new(value, at), name).map(|value| value.value),
            None => {
                report.add(wrong_type(at, name, "a number", item));
                None
            }
        })
    }

    /// A table whose keys are the user's own names.
    fn named<T>(
        &mut self,
        report: &mut Report,
        key: &'static str,
        max: usize,
        read: impl Fn(&mut Report, &str, &Item, TextRange) -> Option<T>,
    ) -> Option<Named<T>> {
        let Located { value: table, at } = self.read(report, key, "a table, `{ … }`", Item::as_table_like)?;
        if table.len() > max {
            let problem = Problem::error(at, format!("`{key}` has {} entries", table.len()));
            report.add(problem.hint(format!("at most {max}")));
            return Some(Vec::new());
        }
        let mut entries = Vec::new();
        for (name, item) in table.iter() {
            let name_at = table.key(name).and_then(|key| key.span()).unwrap_or_else(|| at.clone());
            let item_at = item.span().unwrap_or_else(|| name_at.clone());
            let value = read(report, name, item, item_at);
            entries.extend(value.map(|value| (Located::new(name.to_owned(), name_at), value)));
        }
        Some(entries)
    }

    /// Reports every key that was not read.
    pub fn finish(self, report: &mut Report) {
        for (key, item) in self.unknown() {
            let key_at = self.table.key(key).and_then(|k| k.span());
            let at = key_at.or_else(|| item.span()).unwrap_or_else(|| self.at.clone());
            let hint = units::rewritten(key, &self.asked, item).or_else(|| suggestion(key, self.asked.iter().copied()));
            let problem = Problem::error(at, format!("unknown key `{key}` in {}", self.what));
            report.add(problem.label("unknown key").maybe_hint(hint));
        }
    }
}

/// Tables with their names in their headers, `[station.press]`.
fn by_header<'a>(tables: &'a Table, what: &'static str) -> impl Iterator<Item = Fields<'a>> {
    tables.iter().filter_map(move |(name, item)| {
        let table = item.as_table_like()?;
        let name_at = tables.key(name).and_then(|key| key.span()).unwrap_or(0..0);
        let mut fields = Fields::new(table, item.span().unwrap_or_else(|| name_at.clone()), what);
        fields.header_name = Some(Located::new(name.to_owned(), name_at));
        Some(fields)
    })
}

/// A whole number will do as a number.
fn number(item: &Item) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))
}

/// A number that is one of those permitted; `hint` names them.
fn checked<T: fmt::Display>(
    report: &mut Report,
    key: &str,
    number: Located<T>,
    fits: bool,
    hint: impl Into<String>,
) -> Option<Located<T>> {
    if fits {
        return Some(number);
    }
    report.add(Problem::error(number.at, format!("`{key}` is {}", number.value)).hint(hint));
    None
}

fn checked_coordinate(report: &mut Report, number: Located<f64>, key: &str) -> Option<Located<f64>> {
    if number.value.abs() <= COORDINATE_MAX {
        return Some(number);
    }
    let problem = Problem::error(number.at, format!("`{key}` is {}", number.value));
    report.add(problem.label("not a usable coordinate").hint("between -1000000 and 1000000 mm"));
    None
}
