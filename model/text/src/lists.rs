//! Lists of texts.

use toml_edit::{Array, Item};

use crate::advice::{wrong_type, wrong_value};
use crate::fields::TEXT_MAX;
use crate::place::{Located, LocatedName, TextRange};
use crate::{Problem, Report};

/// The texts of a list, at most `max` of them. Of a list that is too long the first are read all the same, and a text by itself as a
/// list of one: the rest of the description refers to them.
pub(crate) fn texts_of(
    report: &mut Report,
    key: &str,
    item: &Item,
    at: TextRange,
    max: usize,
) -> Option<Located<Vec<LocatedName>>> {
    if let Some(array) = item.as_array() {
        return Some(list(report, key, Located::new(array, at), max));
    }
    report.add(wrong_type(at.clone(), key, "a list of texts", item));
    let text = item.as_str().filter(|text| text.len() <= TEXT_MAX && max > 0)?;
    Some(Located::new(vec![Located::new(text.to_owned(), at.clone())], at))
}

fn list(report: &mut Report, key: &str, array: Located<&Array>, max: usize) -> Located<Vec<LocatedName>> {
    if array.value.len() > max {
        report.add(
            Problem::error(array.at.clone(), format!("`{key}` has {} entries", array.value.len()))
                .hint(format!("at most {max}")),
        );
    }
    let mut texts = Vec::with_capacity(array.value.len().min(max));
    for value in array.value.iter().take(max) {
        let at = value.span().unwrap_or_else(|| array.at.clone());
        match value.as_str() {
            Some(text) if text.len() <= TEXT_MAX => texts.push(Located::new(text.to_owned(), at)),
            Some(_) => report.add(Problem::error(at, format!("an entry of `{key}` has over {TEXT_MAX} bytes"))),
            None => report.add(wrong_value(at, &format!("an entry of `{key}`"), "text in quotes", value)),
        }
    }
    Located::new(texts, array.at)
}
