//! Reads the text of an interface: fields and constants, each with the comment above it.
//!
//! A comment that an empty line or `---` follows is about no single item: the first one is about the whole interface,
//! others are remarks for readers of the file.

/// Lines of a comment, without their marks.
pub type Doc = Vec<String>;

/// Section between two lines of `---`.
#[derive(Default)]
pub struct MessageSection {
    pub constants: Vec<MessageConstant>,
    pub fields: Vec<MessageField>,
}

pub struct MessageField {
    pub doc: Doc,
    pub kind: FieldType,
    pub name: String,
}

pub struct MessageConstant {
    pub doc: Doc,
    pub kind: FieldType,
    pub name: String,
    pub value: i128,
}

/// The type of a field.
pub enum FieldType {
    /// A number or a truth value, with its name in Rust.
    Plain(&'static str),
    /// Eight bits that are no number.
    Byte,
    Text,
    /// A message, by its name, and its package where that is written before it.
    Message(Option<String>, String),
    /// A sequence, with the most elements it may have.
    Sequence(Box<FieldType>, Option<usize>),
}

impl FieldType {
    /// Whether values of it are compared as floating point numbers are: not all of them equal themselves. So are those of
    /// the messages `with_floats`.
    pub fn has_float(&self, with_floats: &[&str]) -> bool {
        match self {
            FieldType::Plain(rust) => *rust == "f64",
            FieldType::Sequence(element, _) => element.has_float(with_floats),
            FieldType::Message(_, name) => with_floats.contains(&name.as_str()),
            FieldType::Byte | FieldType::Text => false,
        }
    }
}

const PLAIN: [(&str, &str); 10] = [
    ("bool", "bool"),
    ("int8", "i8"),
    ("uint8", "u8"),
    ("int16", "i16"),
    ("uint16", "u16"),
    ("int32", "i32"),
    ("uint32", "u32"),
    ("int64", "i64"),
    ("uint64", "u64"),
    ("float64", "f64"),
];

/// The comment about the whole interface, and its sections.
pub fn interface(text: &str) -> Result<(Doc, Vec<MessageSection>), String> {
    let mut head = None;
    let mut sections = vec![MessageSection::default()];
    let mut comment = Doc::new();
    for (index, line) in text.lines().map(str::trim).enumerate() {
        if let Some(words) = line.strip_prefix('#') {
            comment.push(words.trim().to_owned());
        } else if line.is_empty() || line == "---" {
            let remark = std::mem::take(&mut comment);
            if !remark.is_empty() {
                head.get_or_insert(remark);
            }
            if line == "---" {
                sections.push(MessageSection::default());
            }
        } else if let Some(section) = sections.last_mut() {
            let doc = std::mem::take(&mut comment);
            item(section, doc, line).map_err(|problem| format!("line {}: {problem}", index + 1))?;
        }
    }
    Ok((head.unwrap_or_default(), sections))
}

fn item(section: &mut MessageSection, doc: Doc, line: &str) -> Result<(), String> {
    let (kind, rest) = line.split_once(' ').ok_or_else(|| format!("`{line}` has no name"))?;
    let kind = self::kind(kind)?;
    if doc.is_empty() {
        return Err(format!("`{line}` has no comment above it"));
    }
    match rest.split_once('=') {
        None => {
            let name = named(rest, |c| c.is_ascii_lowercase())?;
            section.fields.push(MessageField { doc, kind, name });
        }
        Some((name, value)) => {
            let name = named(name, |c| c.is_ascii_uppercase())?;
            let value = value.trim().parse().map_err(|_| format!("`{}` is no decimal number", value.trim()))?;
            match kind {
                FieldType::Plain("bool" | "f64")
                | FieldType::Text
                | FieldType::Message(..)
                | FieldType::Sequence(..) => {
                    return Err(format!("the constant {name} is no whole number"));
                }
                FieldType::Plain(_) | FieldType::Byte => {
                    section.constants.push(MessageConstant { doc, kind, name, value })
                }
            }
        }
    }
    Ok(())
}

fn named(name: &str, letter: fn(char) -> bool) -> Result<String, String> {
    let name = name.trim();
    let rest = |c: char| letter(c) || c.is_ascii_digit() || c == '_';
    if name.starts_with(letter) && name.chars().all(rest) {
        Ok(name.to_owned())
    } else {
        Err(format!("`{name}` is no name of a field or a constant"))
    }
}

fn kind(text: &str) -> Result<FieldType, String> {
    let unknown = || format!("a type `{text}` is not supported");
    if let Some((element, bound)) = text.strip_suffix(']').and_then(|text| text.split_once('[')) {
        let element = Box::new(kind(element)?);
        return match (&*element, bound.strip_prefix("<=").map(str::parse)) {
            (FieldType::Sequence(..), _) => Err(unknown()),
            (_, None) if bound.is_empty() => Ok(FieldType::Sequence(element, None)),
            (_, Some(Ok(most))) => Ok(FieldType::Sequence(element, Some(most))),
            _ => Err(unknown()),
        };
    }
    if let Some((_, rust)) = PLAIN.iter().find(|(ros, _)| *ros == text) {
        return Ok(FieldType::Plain(rust));
    }
    let (package, message) = text.rsplit_once('/').map_or((None, text), |(package, name)| (Some(package), name));
    match text {
        "byte" => Ok(FieldType::Byte),
        "string" => Ok(FieldType::Text),
        _ if message.starts_with(|c: char| c.is_ascii_uppercase()) && message.chars().all(|c| c.is_alphanumeric()) => {
            Ok(FieldType::Message(package.map(str::to_owned), message.to_owned()))
        }
        _ => Err(unknown()),
    }
}
