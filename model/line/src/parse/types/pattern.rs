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
