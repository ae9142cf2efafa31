//! `linewright schema`: what a description may contain, as a JSON schema, so that editors complete and check it.
//!
//! It follows from the tables of keys that the reader uses ([`linewright_text::Shape`]); this module only writes it down,
//! in draft 7, which editors of TOML understand. A schema holds keys, types and bounds. What holds between them is for
//! `check`.

use std::process::ExitCode;

use linewright_text::{KeyPresence, Property, Shape, TEXT_MAX, Usual, sentences};
use miette::IntoDiagnostic;
use serde_json::{Map, Value, json};

/// Print the JSON schema of a description: line, cell, relations, or a scenario of a cell.
#[derive(Debug, clap::Args)]
#[command(after_help = "A description names its schema in its first line, by the path from itself:\n\
    #:schema line.schema.json")]
pub struct Args {
    /// Kind of the description.
    description: Description,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Description {
    /// `line.toml`.
    Line,
    /// `cell.toml`.
    Cell,
    /// `relations.toml`.
    Relations,
    /// A scenario of a cell, for `linewright simulate`.
    Scenario,
}

/// `linewright schema`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let (title, shape) = match args.description {
        Description::Line => ("line.toml", linewright_line::schema()),
        Description::Cell => ("cell.toml", linewright_cell::schema()),
        Description::Relations => ("relations.toml", linewright_relations::schema()),
        Description::Scenario => ("a scenario of a cell", linewright_simulation::cell::CellScenario::schema()),
    };
    let mut schema = of(&shape);
    schema.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    schema.insert("title".to_owned(), json!(title));
    crate::out::say!("{}", serde_json::to_string_pretty(&schema).into_diagnostic()?);
    Ok(ExitCode::SUCCESS)
}

fn of(shape: &Shape) -> Map<String, Value> {
    let schema = match shape {
        Shape::Text => json!({ "type": "string", "maxLength": TEXT_MAX }),
        Shape::Like(pattern) => json!({ "type": "string", "maxLength": TEXT_MAX, "pattern": pattern }),
        Shape::Word(words) => json!({ "type": "string", "enum": words }),
        Shape::Flag => json!({ "type": "boolean" }),
        Shape::Whole(low, high) => {
            let bound = |bound: i64| (bound != i64::MIN && bound != i64::MAX).then(|| json!(bound));
            bounded("integer", bound(*low), bound(*high))
        }
        Shape::Number(low, high) => {
            let bound = |bound: f64| bound.is_finite().then(|| json!(bound));
            bounded("number", bound(*low), bound(*high))
        }
        Shape::List(entry, most) => json!({ "type": "array", "items": of(entry), "maxItems": most }),
        Shape::Names(entry, most) => {
            json!({ "type": "object", "additionalProperties": of(entry), "maxProperties": most })
        }
        Shape::Table(doc, keys) => table(doc, keys),
        Shape::Part(keys) => table(&[], keys),
        Shape::Either(shapes) => json!({ "anyOf": shapes.iter().map(of).collect::<Vec<_>>() }),
    };
    match schema {
        Value::Object(schema) => schema,
        _ => Map::new(),
    }
}

fn bounded(kind: &str, low: Option<Value>, high: Option<Value>) -> Value {
    let mut schema = json!({ "type": kind });
    for (key, bound) in [("minimum", low), ("maximum", high)] {
        if let Some(bound) = bound {
            schema[key] = bound;
        }
    }
    schema
}

fn table(doc: &[&str], keys: &[Property]) -> Value {
    let properties: Map<String, Value> = keys.iter().map(|key| (key.key.to_owned(), property(key))).collect();
    let mut schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if !doc.is_empty() {
        schema["description"] = json!(sentences(doc));
    }
    let required: Vec<&str> =
        keys.iter().filter(|key| key.presence == KeyPresence::Required).map(|key| key.key).collect();
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    let either: Vec<Value> = keys.iter().filter_map(|key| either(key.key, key.presence)).collect();
    if !either.is_empty() {
        schema["allOf"] = json!(either);
    }
    schema
}

/// One of two keys, where the one may be left out for the other.
fn either(key: &str, presence: KeyPresence) -> Option<Value> {
    match presence {
        KeyPresence::Unless(others) => {
            let one = std::iter::once(key).chain(others.iter().copied()).map(|key| json!({ "required": [key] }));
            Some(json!({ "anyOf": one.collect::<Vec<_>>() }))
        }
        KeyPresence::Optional | KeyPresence::Required => None,
    }
}

fn property(key: &Property) -> Value {
    let mut schema = of(&key.shape);
    schema.insert("description".to_owned(), json!(sentences(key.doc)));
    if let Some(usual) = key.usual {
        schema.insert("default".to_owned(), default(usual));
    }
    Value::Object(schema)
}

fn default(usual: Usual) -> Value {
    match usual {
        Usual::Word(word) => json!(word),
        Usual::Flag(flag) => json!(flag),
        Usual::Whole(number) => json!(number),
        Usual::Number(number) => json!(number),
    }
}
