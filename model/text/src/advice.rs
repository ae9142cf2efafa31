//! What to write where a key is missing or its value is of the wrong type.

use std::ops::Range;

use toml_edit::{Item, Value};

use crate::{Problem, Shape, sentences};

/// Units of time that people write after a number, each with its length in ms.
const UNITS: [(&str, f64); 8] = [
    ("s", 1e3),
    ("sec", 1e3),
    ("second", 1e3),
    ("seconds", 1e3),
    ("ms", 1.0),
    ("milliseconds", 1.0),
    ("min", 60e3),
    ("minutes", 60e3),
];

/// The advice for a missing key: its form, and the first sentence about it. Keys of the outermost table stand above all headers.
pub(crate) fn missing(key: &str, shape: &Shape, about: &[&str], is_outermost: bool) -> String {
    let place = if is_outermost { " above the first header `[…]`" } else { "" };
    let about = sentences(about);
    let about = about.split_inclusive(". ").next().unwrap_or_default().trim();
    format!("write `{key} = {}`{place}. {about}", form(shape)).trim_end_matches([' ', '.']).to_owned()
}

/// A value of this shape, as far as the shape says.
fn form(shape: &Shape) -> String {
    match shape {
        Shape::Text | Shape::Like(_) => "\"…\"".to_owned(),
        Shape::Word(words) => words.first().map_or_else(String::new, |word| format!("\"{word}\"")),
        Shape::Flag => "true".to_owned(),
        Shape::List(..) => "[…]".to_owned(),
        Shape::Table(_, keys) => {
            let is_required = |key: &&crate::Property| key.presence == crate::KeyPresence::Required;
            let keys: Vec<_> = keys.iter().filter(is_required).map(|key| format!("{} = …", key.key)).collect();
            if keys.is_empty() { "{ … }".to_owned() } else { format!("{{ {} }}", keys.join(", ")) }
        }
        Shape::Names(..) | Shape::Part(_) => "{ … = … }".to_owned(),
        Shape::Whole(..) | Shape::Number(..) | Shape::Either(_) => "…".to_owned(),
    }
}

/// The problem of a key whose value is of another type than `expected`.
pub(crate) fn wrong_type(at: Range<usize>, key: &str, expected: &str, found: &Item) -> Problem {
    Problem::error(at, format!("`{key}` must be {expected}"))
        .label(format!("this is {}", described(found.type_name())))
        .maybe_hint(
            found.as_value().and_then(|value| instead(value, expected)).map(|value| format!("write `{key} = {value}")),
        )
}

/// The same of an entry of a list.
pub(crate) fn wrong_value(at: Range<usize>, what: &str, expected: &str, found: &Value) -> Problem {
    Problem::error(at, format!("{what} must be {expected}"))
        .label(format!("this is {}", described(found.type_name())))
        .maybe_hint(instead(found, expected).map(|value| format!("write `{value}")))
}

/// The value that the advice has in the place of a value of another type.
pub(crate) fn advised(found: &Item, expected: &str) -> Option<Value> {
    let advice = instead(found.as_value()?, expected)?;
    advice.split('`').next()?.parse().ok()
}

/// The value that is probably meant, from behind the opening quote of a stretch of code.
fn instead(found: &Value, expected: &str) -> Option<String> {
    match found {
        Value::String(text) => {
            let text = text.value().trim();
            match expected {
                _ if expected.contains("number") => number_in(text, expected),
                "true or false" => {
                    let meant = match text.to_lowercase().as_str() {
                        "true" | "yes" | "on" => true,
                        "false" | "no" | "off" => false,
                        _ => return None,
                    };
                    Some(format!("{meant}`, without quotes"))
                }
                "a list of texts" => Some(format!("[{}]`, in brackets", Value::from(text))),
                _ => None,
            }
        }
        Value::Float(number) if expected.contains("whole number") => {
            let number = *number.value();
            let is_whole = number.fract() == 0.0 && number.abs() < 1e15;
            is_whole.then(|| format!("{number:.0}`, without a decimal point"))
        }
        Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_)
            if expected.starts_with("text in quotes") =>
        {
            let written = found.clone().decorated("", "").to_string();
            Some(format!("{}`, in quotes", Value::from(written)))
        }
        _ => None,
    }
}

/// The number that a text begins with, in the unit that is expected.
fn number_in(text: &str, expected: &str) -> Option<String> {
    if let Some(digits) = hexadecimal(text).filter(|_| expected.contains("whole number")) {
        return Some(format!("0x{digits}`, without quotes"));
    }
    let end = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+'))).unwrap_or(text.len());
    let (number, unit) = (text[..end].replace(',', "."), text[end..].trim().to_lowercase());
    if unit.starts_with('x') {
        // Meant as hexadecimal, which 0 is no advice for.
        return None;
    }
    let number: f64 = number.parse().ok()?;
    let wanted = match expected {
        "a number of seconds" => Some(1e3),
        "a whole number of milliseconds" => Some(1.0),
        _ => None,
    };
    let written = UNITS.iter().find(|(name, _)| *name == unit).map(|&(_, length)| length);
    let number = match (wanted, written) {
        // Twelve digits: more would show how the computer divides.
        (Some(wanted), Some(written)) => (number * written / wanted * 1e9).round() / 1e9,
        (Some(_), None) if !unit.is_empty() => return None,
        _ => number,
    };
    let without = if unit.is_empty() { "quotes" } else { "quotes and unit" };
    let is_whole = number.fract() == 0.0;
    (is_whole || !expected.contains("whole number")).then(|| format!("{number}`, without {without}"))
}

/// The digits of a hexadecimal number as people write it, `0x14` or `14h`.
fn hexadecimal(text: &str) -> Option<&str> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")).or_else(|| text.strip_suffix(['h', 'H']));
    digits.filter(|digits| (1..=8).contains(&digits.len()) && digits.chars().all(|digit| digit.is_ascii_hexdigit()))
}

/// What is written for a number with a decimal comma in a line that is no TOML: `1,6` is a list without brackets there.
pub(crate) fn decimal_comma(line: &str) -> Option<String> {
    let mut in_quotes = false;
    let quoted: Vec<bool> = line
        .bytes()
        .map(|byte| {
            in_quotes ^= byte == b'"';
            in_quotes
        })
        .collect();
    let (at, _) = line.match_indices(',').find(|&(at, _)| {
        let before = line[..at].trim_end_matches(|c: char| c.is_ascii_digit());
        // In a list two numbers may stand side by side.
        let is_value = before.len() < at && before.trim_end_matches(['-', '+']).trim_end().ends_with('=');
        is_value && !quoted[at] && line[at + 1..].starts_with(|c: char| c.is_ascii_digit())
    })?;
    let start = line[..at].rfind('=').map_or(at, |equals| equals + 1);
    let decimals = line[at + 1..].find(|c: char| !c.is_ascii_digit()).unwrap_or(line.len() - at - 1);
    let (whole, fraction) = (line[start..at].trim(), &line[at + 1..at + 1 + decimals]);
    let key = line[..start - 1].rsplit(['{', ',']).next().unwrap_or_default().trim();
    Some(format!("write `{key} = {whole}.{fraction}`: a decimal point, no comma"))
}

/// What is written for a hexadecimal number in a line that is no TOML: `14h`, or `10x11`.
pub(crate) fn hexadecimal_number(line: &str) -> Option<String> {
    let (key, value) = line.split_once('=')?;
    let value = value.split('#').next().unwrap_or_default().trim();
    let key = key.trim();
    if let Some(digits) = value.strip_suffix(['h', 'H']).and_then(|_| hexadecimal(value)) {
        return Some(format!("write `{key} = 0x{digits}`: a hexadecimal number begins with 0x"));
    }
    // Which number is meant by `10x11` nobody can tell.
    let (before, digits) = value.split_once(['x', 'X'])?;
    let is_hexadecimal = |of: &str| of.chars().all(|digit| digit.is_ascii_hexdigit());
    let is_meant = !digits.is_empty() && is_hexadecimal(before) && is_hexadecimal(digits);
    is_meant.then(|| format!("a hexadecimal number begins with 0x, such as `{key} = 0x{digits}`"))
}

/// What is written for the second table under a header that may stand once.
pub(crate) fn second_header(line: &str, message: &str) -> Option<String> {
    let name = line.trim().strip_prefix('[')?.split(']').next()?.trim();
    let is_second = message.contains("duplicate key") && !name.starts_with('[');
    is_second.then(|| format!("if there are several, write each under a header `[[{name}]]`, with two brackets"))
}

fn described(type_name: &str) -> &str {
    match type_name {
        "string" => "text",
        "integer" => "a whole number",
        "float" => "a number with a decimal point",
        "boolean" => "true or false",
        "datetime" => "a date",
        "array" => "a list",
        "array of tables" => "a list of tables",
        "table" | "inline table" => "a table",
        other => other,
    }
}
