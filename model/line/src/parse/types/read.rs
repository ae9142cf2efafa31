//! Reading `[[station_type]]` and the stations that name a type.

use linewright_text::{Fields, Keys, Located, LocatedName, Problem, Report, TEXT_MAX, TextRange, suggestion, tag};
use toml_edit::{Item, Table, TableLike, Value};

use super::pattern::{TypeEdit, parts};
use super::{BESIDE, DEPTH_MAX};
use crate::parse::raw::RawStationType;

/// The parameter that every type has.
const NAME: &str = "name";

pub(super) struct StationType<'a> {
    name: LocatedName,
    /// The first one is the station's name.
    parameters: Vec<LocatedName>,
    table: &'a Table,
    /// In the order of the text.
    pub edits: Vec<TypeEdit>,
    /// Inline tables beside the station: header, place, keys with their values.
    pub inline: Vec<(&'static str, TextRange, Vec<TextRange>)>,
}

pub(super) struct TypedStation {
    /// Its number among the stations.
    pub nth: usize,
    pub name: LocatedName,
    /// The name of its type.
    pub of: LocatedName,
    /// The type of this number.
    pub kind: usize,
    /// By parameter of its type.
    pub values: Vec<TypeArgument>,
    /// Keys that are not written out.
    pub cuts: Vec<TypeEdit>,
}

pub(super) struct TypeArgument {
    pub name: String,
    pub at: TextRange,
    /// Text as it is written.
    pub source: String,
    /// As a part of a text.
    pub words: String,
}

/// Whether anything of types is written.
pub(super) fn has_types(root: &Table) -> bool {
    let is_typed = |table: &dyn TableLike| table.contains_key("type") || table.contains_key("parameters");
    root.contains_key("station_type")
        || match root.get("station") {
            Some(Item::ArrayOfTables(stations)) => stations.iter().any(|station| is_typed(station)),
            Some(Item::Value(Value::Array(stations))) => {
                stations.iter().filter_map(Value::as_inline_table).any(|station| is_typed(station))
            }
            _ => false,
        }
}

pub(super) fn types<'a>(root: &'a Table, report: &mut Report) -> Vec<StationType<'a>> {
    let Some(item) = root.get("station_type") else { return Vec::new() };
    let Item::ArrayOfTables(tables) = item else {
        report.add(
            Problem::error(item.span().unwrap_or(0..0), "`station_type` must be a list of tables")
                .hint("write each type under a header `[[station_type]]`, with two brackets"),
        );
        return Vec::new();
    };
    let mut types: Vec<StationType<'_>> = Vec::new();
    for table in tables {
        let at = table.span().unwrap_or(0..0);
        // Other keys are those of a station, and are read in it.
        let read = RawStationType::read(&mut Fields::new(table, at.clone(), RawStationType::WHAT), report);
        let Some(name) = read.name else { continue };
        tag(&name, "station type", report);
        if let Some(earlier) = types.iter().find(|earlier| earlier.name.value == name.value) {
            report.add(
                Problem::error(name.at.clone(), format!("a second station type named `{}`", name.value))
                    .label("again")
                    .also(&earlier.name.at, "first here"),
            );
        }
        let mut parameters = vec![Located::new(NAME.to_owned(), name.at.clone())];
        for parameter in read.parameters {
            tag(&parameter, "parameter", report);
            match parameters.iter().find(|earlier| earlier.value == parameter.value) {
                Some(earlier) => report.add(
                    Problem::error(parameter.at.clone(), format!("a second parameter named `{}`", parameter.value))
                        .also(&earlier.at, "the first")
                        .hint("`name` is the station's name, and need not be listed"),
                ),
                None => parameters.push(parameter),
            }
        }
        let mut found = StationType { name, parameters, table, edits: Vec::new(), inline: Vec::new() };
        found.read_edits(report);
        types.push(found);
    }
    types
}

impl StationType<'_> {
    fn read_edits(&mut self, report: &mut Report) {
        let table = self.table;
        for key in [NAME, "parameters"] {
            self.edits.extend(entry(table, key).map(TypeEdit::out));
        }
        let mut used = vec![false; self.parameters.len()];
        for (key, item) in table.iter().filter(|(key, _)| ![NAME, "parameters"].contains(key)) {
            if let Some(header) = BESIDE.into_iter().find(|beside| *beside == key) {
                self.beside(header, item, report);
            }
            texts(item, 0, &mut |text, at, is_key| {
                if let Some(parts) = parts(text, &at, &self.parameters, report) {
                    for part in &parts {
                        if let super::PatternPart::Parameter(parameter) = part {
                            used[*parameter] = true;
                        }
                    }
                    self.edits.push(TypeEdit { at, parts, is_key });
                }
            });
        }
        self.edits.sort_by_key(|edit| edit.at.start);
        for (parameter, _) in self.parameters.iter().zip(&used).skip(1).filter(|(_, used)| !**used) {
            report.add(
                Problem::warning(
                    parameter.at.clone(),
                    format!("nothing in the type has parameter `{}`", parameter.value),
                )
                .hint(format!("write `\"{{{}}}\"` where its value stands", parameter.value)),
            );
        }
    }

    /// Tables beside the station: under headers of their own, or in a list that is taken apart.
    fn beside(&mut self, header: &'static str, item: &Item, report: &mut Report) {
        let list = match item {
            Item::ArrayOfTables(_) => return,
            Item::Value(Value::Array(list)) if list.iter().all(Value::is_inline_table) => list,
            other => {
                let at = other.span().unwrap_or_else(|| self.name.at.clone());
                report.add(
                    Problem::error(at, format!("`{header}` must be a list of tables"))
                        .hint(format!("write each one under a header `[[station_type.{header}]]`, with two brackets")),
                );
                return;
            }
        };
        for table in list.iter().filter_map(Value::as_inline_table) {
            let at = table.span().unwrap_or_else(|| self.name.at.clone());
            let keys: Option<Vec<TextRange>> = table.iter().map(|(key, _)| entry(table, key)).collect();
            match keys {
                Some(keys) => self.inline.push((header, at, keys)),
                None => report.add(
                    Problem::error(at, format!("a key with a full stop in an entry of `{header}`"))
                        .hint(format!("write it under a header `[[station_type.{header}]]`")),
                ),
            }
        }
        self.edits.extend(entry(self.table, header).map(TypeEdit::out));
    }
}

/// Every text in an item, with its place, and whether it is the key of a value.
fn texts(item: &Item, depth: usize, found: &mut dyn FnMut(&str, TextRange, bool)) {
    if depth > DEPTH_MAX {
        return;
    }
    match item {
        Item::Value(value) => of_value(value, depth + 1, found),
        Item::Table(table) => of_table(table, depth, found),
        Item::ArrayOfTables(tables) => tables.iter().for_each(|table| of_table(table, depth, found)),
        Item::None => {}
    }
}

fn of_table(table: &dyn TableLike, depth: usize, found: &mut dyn FnMut(&str, TextRange, bool)) {
    for (name, item) in table.iter() {
        // The key of a table is in a header, or before a full stop.
        if let Some(at) = table.key(name).filter(|_| item.is_value()).and_then(|key| key.span()) {
            found(name, at, true);
        }
        texts(item, depth + 1, found);
    }
}

fn of_value(value: &Value, depth: usize, found: &mut dyn FnMut(&str, TextRange, bool)) {
    if depth > DEPTH_MAX {
        return;
    }
    match value {
        Value::String(text) => {
            if let Some(at) = text.span() {
                found(text.value(), at, false);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| of_value(value, depth + 1, found)),
        Value::InlineTable(table) => of_table(table, depth, found),
        _ => {}
    }
}

/// Place of a key with its value; `None` for a key that has a header of its own.
fn entry(table: &dyn TableLike, key: &str) -> Option<TextRange> {
    let (name, item) = table.get_key_value(key)?;
    Some(name.span()?.start..item.as_value()?.span()?.end)
}

pub(super) fn stations<'a>(
    root: &'a Table,
    types: &[StationType<'a>],
    text: &str,
    report: &mut Report,
) -> Vec<TypedStation> {
    let tables = match root.get("station") {
        Some(Item::ArrayOfTables(tables)) => tables,
        Some(Item::Value(Value::Array(list))) => {
            let typed = list.iter().filter_map(Value::as_inline_table).filter_map(|table| entry(table, "type"));
            typed.for_each(|at| {
                report.add(
                    Problem::error(at, "a station of a type in a list")
                        .hint("write each station under a header `[[station]]`, with two brackets"),
                );
            });
            return Vec::new();
        }
        _ => return Vec::new(),
    };
    let mut stations = Vec::new();
    for (nth, table) in tables.iter().enumerate() {
        if table.contains_key("type") {
            stations.extend(station(nth, table, types, text, report));
        } else if let Some((key, _)) = table.get_key_value("parameters") {
            let at = key.span().unwrap_or(0..0);
            report.add(Problem::error(at, "parameters without a `type`").hint("only a station type has parameters"));
        }
    }
    stations
}

fn station<'a>(
    nth: usize,
    table: &'a Table,
    types: &[StationType<'a>],
    text: &str,
    report: &mut Report,
) -> Option<TypedStation> {
    let at = table.span().unwrap_or(0..0);
    let mut fields = Fields::new(table, at.clone(), "a station of a type");
    let of = fields.text(report, "type")?;
    let name = fields.text(report, NAME);
    let Some(name) = name else {
        if !table.contains_key(NAME) {
            report.add(Problem::error(at, "a station of a type needs `name`").label("no `name` here"));
        }
        return None;
    };
    let Some(kind) = types.iter().position(|known| known.name.value == of.value) else {
        let known = types.iter().map(|known| known.name.value.as_str());
        let hint = suggestion(&of.value, known);
        report.add(Problem::error(of.at.clone(), format!("unknown station type `{}`", of.value)).maybe_hint(hint));
        return None;
    };
    let values = values(table, &name, &of, &types[kind], text, report);
    for (key, item) in table.iter().filter(|(key, _)| ![NAME, "type", "parameters"].contains(key)) {
        if let Some((other, _)) = types[kind].table.get_key_value(key) {
            let place =
                |key: Option<&toml_edit::Key>, item: &Item| key.and_then(|key| key.span()).or_else(|| item.span());
            let at = place(table.key(key), item).unwrap_or_else(|| at.clone());
            report.add(
                Problem::error(at, format!("`{key}` is written in station `{}` and in its type", name.value))
                    .also(&place(Some(other), item).unwrap_or(0..0), "in the type")
                    .hint("what differs from station to station is a parameter of the type"),
            );
        }
    }
    let cuts = ["type", "parameters"].into_iter().filter_map(|key| entry(table, key)).map(TypeEdit::out);
    let mut cuts: Vec<TypeEdit> = cuts.collect();
    cuts.sort_by_key(|edit| edit.at.start);
    Some(TypedStation { nth, name, of, kind, values: values?, cuts })
}

/// The values of all parameters of a type.
fn values(
    table: &Table,
    name: &LocatedName,
    of: &LocatedName,
    kind: &StationType<'_>,
    text: &str,
    report: &mut Report,
) -> Option<Vec<TypeArgument>> {
    let empty = Table::new();
    let written: &dyn TableLike = match table.get("parameters") {
        None => &empty,
        Some(Item::Value(Value::InlineTable(inline))) if !inline.is_dotted() => inline,
        Some(Item::Table(block)) if !block.is_dotted() => block,
        Some(other) => {
            let at = table.key("parameters").and_then(|key| key.span()).or_else(|| other.span());
            let problem = Problem::error(at.unwrap_or(0..0), "`parameters` must be a table");
            report.add(problem.hint("all in one: `parameters = { … }`"));
            return None;
        }
    };
    let known = || kind.parameters.iter().skip(1).map(|parameter| parameter.value.as_str());
    for (key, item) in written.iter().filter(|(key, _)| !known().any(|known| known == *key)) {
        let at = written.key(key).and_then(|key| key.span()).or_else(|| item.span());
        let problem = Problem::error(at.unwrap_or(0..0), format!("type `{}` has no parameter `{key}`", of.value));
        report.add(problem.maybe_hint(suggestion(key, known())));
    }
    let mut values = vec![TypeArgument {
        name: NAME.to_owned(),
        at: name.at.clone(),
        source: super::pattern::quoted(&name.value),
        words: name.value.clone(),
    }];
    for parameter in kind.parameters.iter().skip(1) {
        let Some(item) = written.get(&parameter.value) else {
            report.add(
                Problem::error(
                    of.at.clone(),
                    format!("station `{}` needs parameter `{}`", name.value, parameter.value),
                )
                .also(&parameter.at, "its type has it")
                .hint(format!("`parameters = {{ {} = … }}`", parameter.value)),
            );
            continue;
        };
        values.extend(value(&parameter.value, item, text, report));
    }
    (values.len() == kind.parameters.len()).then_some(values)
}

fn value(name: &str, item: &Item, text: &str, report: &mut Report) -> Option<TypeArgument> {
    let at = item.span().unwrap_or(0..0);
    let words = match item.as_value() {
        Some(Value::String(text)) => text.value().clone(),
        Some(Value::Integer(number)) => number.value().to_string(),
        Some(Value::Float(number)) => number.value().to_string(),
        Some(Value::Boolean(flag)) => flag.value().to_string(),
        _ => {
            report.add(Problem::error(at, format!("parameter `{name}` must be a text, a number, true or false")));
            return None;
        }
    };
    if words.len() > TEXT_MAX {
        report.add(Problem::error(at, format!("parameter `{name}` has over {TEXT_MAX} bytes")));
        return None;
    }
    let source = text.get(at.clone())?.to_owned();
    Some(TypeArgument { name: name.to_owned(), at, source, words })
}

/// Warns of types that no station has: nothing in them is read.
pub(super) fn unused(types: &[StationType<'_>], stations: &[TypedStation], report: &mut Report) {
    for (nth, kind) in types.iter().enumerate() {
        if !stations.iter().any(|station| station.kind == nth) && !report.has_errors() {
            report.add(
                Problem::warning(kind.name.at.clone(), format!("no station is of type `{}`", kind.name.value))
                    .label("not used, and not checked"),
            );
        }
    }
}
