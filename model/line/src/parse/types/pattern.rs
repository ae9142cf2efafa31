//! Texts of a type with parameters in braces: `"Clamp {number}"`.

use linewright_text::{LocatedName, Problem, Report, TextRange, suggestion};

/// A stretch of the text and its replacement.
#[derive(Clone, Debug)]
pub(super) struct TypeEdit {
    pub at: TextRange,
    /// Nothing where the stretch is left out.
    pub parts: Vec<PatternPart>,
    /// It is the key of a value.
    pub is_key: bool,
}

/// A part of a text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PatternPart {
    Words(String),
    /// The parameter of this number.
    Parameter(usize),
}

impl TypeEdit {
    /// A stretch that is left out.
    pub fn out(at: TextRange) -> Self {
        TypeEdit { at, parts: Vec::new(), is_key: false }
    }
}

/// The parts of a text in a type; `None` where it has no braces. Braces of its own are written twice.
pub(super) fn parts(
    text: &str,
    at: &TextRange,
    parameters: &[LocatedName],
    report: &mut Report,
) -> Option<Vec<PatternPart>> {
    if !text.contains(['{', '}']) {
        return None;
    }
    let mut parts = Vec::new();
    let mut words = String::new();
    let mut rest = text;
    while let Some(brace) = rest.find(['{', '}']) {
        words.push_str(&rest[..brace]);
        let tail = &rest[brace..];
        if tail.starts_with("{{") || tail.starts_with("}}") {
            words.push_str(&tail[..1]);
            rest = &tail[2..];
            continue;
        }
        let Some(end) = tail.find('}').filter(|_| tail.starts_with('{')) else {
            report.add(
                Problem::error(at.clone(), "a brace without its other half")
                    .hint("`{name}` is a parameter of the type; a brace of the text's own is written twice, `{{`"),
            );
            return None;
        };
        let name = &tail[1..end];
        match parameters.iter().position(|parameter| parameter.value == name) {
            Some(parameter) => {
                if !words.is_empty() {
                    parts.push(PatternPart::Words(std::mem::take(&mut words)));
                }
                parts.push(PatternPart::Parameter(parameter));
            }
            None => {
                let known = parameters.iter().map(|parameter| parameter.value.as_str());
                report.add(
                    Problem::error(at.clone(), format!("unknown parameter `{{{name}}}` of this type"))
                        .maybe_hint(suggestion(name, known)),
                );
            }
        }
        rest = &tail[end + 1..];
    }
    words.push_str(rest);
    if !words.is_empty() {
        parts.push(PatternPart::Words(words));
    }
    Some(parts)
}

/// A text as TOML has it.
pub(super) fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}

/// A text as a key in TOML.
pub(super) fn as_key(text: &str) -> String {
    toml_edit::Key::new(text).to_string()
}

#[cfg(test)]
mod tests {
    use linewright_text::Located;

    use super::*;

    fn read(text: &str) -> (Option<Vec<PatternPart>>, Vec<String>) {
        let known = ["name", "io"].map(|name| Located::new(name.to_owned(), 0..0));
        let mut report = Report::default();
        let parts = parts(text, &(0..1), &known, &mut report);
        (parts, report.into_problems("f", text).into_vec().into_iter().map(|problem| problem.message).collect())
    }

    #[test]
    fn parameters_stand_in_braces() {
        let words = |words: &str| PatternPart::Words(words.to_owned());
        assert_eq!(read("plain"), (None, vec![]));
        assert_eq!(read("{io}"), (Some(vec![PatternPart::Parameter(1)]), vec![]));
        assert_eq!(
            read("{name}: close {{{io}}}").0,
            Some(vec![PatternPart::Parameter(0), words(": close {"), PatternPart::Parameter(1), words("}")])
        );
        assert_eq!(read("é{é}").1, ["unknown parameter `{é}` of this type"]);
        for open in ["{name", "a}b", "{", "}", "{{}"] {
            assert_eq!(read(open), (None, vec!["a brace without its other half".to_owned()]), "{open}");
        }
        for (text, key) in [("P1_up", "P1_up"), ("1.5", "\"1.5\""), ("a b", "\"a b\"")] {
            assert_eq!(as_key(text), key);
        }
    }
}
