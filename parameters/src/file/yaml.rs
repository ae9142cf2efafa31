//! YAML text as a tree with places.
//!
//! Only what a parameter file needs: maps with plain keys, lists, scalars. No aliases, which ROS 2 does not read either and which can
//! stand for more than memory holds; no second document; no tags but `!!str`.

use std::ops::Range;

use linewright_diagnostics::Problem;
use saphyr_parser::{Event, Parser, ScalarStyle, Span, StrInput, Tag};

/// Deepest nesting.
const DEPTH_MAX: usize = 32;

/// Part of a document.
#[derive(Debug)]
pub(crate) struct YamlNode {
    /// Its bytes in the text; of a map or list where it begins.
    pub span: Range<usize>,
    pub kind: YamlKind,
}

#[derive(Debug)]
pub(crate) enum YamlKind {
    /// A scalar without quotation marks.
    Plain(String),
    /// A scalar that is a text, whatever it looks like.
    Quoted(String),
    List(Vec<YamlNode>),
    /// Keys with their places.
    Map(Vec<(String, Range<usize>, YamlNode)>),
}

/// The only document of a text; none if it is empty.
pub(crate) fn document(text: &str) -> Result<Option<YamlNode>, Box<Problem>> {
    let mut reader = TreeReader { parser: Parser::new_from_str(text), bytes: byte_offsets(text) };
    let mut found = None;
    loop {
        let (event, span) = reader.next()?;
        match event {
            Event::StreamStart | Event::DocumentStart(_) | Event::DocumentEnd => {}
            Event::StreamEnd => return Ok(found),
            _ if found.is_some() => {
                let at = reader.place(span);
                let problem = Problem::error(at, "a second document in one file");
                return Err(problem.hint("take out the line `---` before it").into());
            }
            event => found = Some(reader.node(event, span, 0)?),
        }
    }
}

/// The byte that each character begins at, and the end.
fn byte_offsets(text: &str) -> Vec<usize> {
    text.char_indices().map(|(at, _)| at).chain([text.len()]).collect()
}

struct TreeReader<'t> {
    parser: Parser<'t, StrInput<'t>>,
    bytes: Vec<usize>,
}

impl<'t> TreeReader<'t> {
    fn byte(&self, character: usize) -> usize {
        self.bytes.get(character).or(self.bytes.last()).copied().unwrap_or(0)
    }

    fn place(&self, span: Span) -> Range<usize> {
        self.byte(span.start.index())..self.byte(span.end.index())
    }

    fn next(&mut self) -> Result<(Event<'t>, Span), Box<Problem>> {
        match self.parser.next_event() {
            Some(Ok(next)) => Ok(next),
            Some(Err(error)) => {
                let at = self.byte(error.marker().index());
                Err(Problem::error(at..at, format!("this is no YAML: {}", error.info())).into())
            }
            None => Ok((Event::StreamEnd, Span::default())),
        }
    }

    fn node(&mut self, event: Event<'t>, span: Span, depth: usize) -> Result<YamlNode, Box<Problem>> {
        let span = self.place(span);
        if depth > DEPTH_MAX {
            return Err(Problem::error(span, format!("more than {DEPTH_MAX} levels of nesting")).into());
        }
        let kind = match event {
            Event::Scalar(text, style, _, tag) => {
                let is_text = is_text(tag.as_deref(), &span)?;
                let text = text.into_owned();
                if style == ScalarStyle::Plain && !is_text { YamlKind::Plain(text) } else { YamlKind::Quoted(text) }
            }
            Event::SequenceStart(_, tag) => {
                is_text(tag.as_deref(), &span)?;
                let mut items = Vec::new();
                loop {
                    match self.next()? {
                        (Event::SequenceEnd, _) => break,
                        (event, span) => items.push(self.node(event, span, depth + 1)?),
                    }
                }
                YamlKind::List(items)
            }
            Event::MappingStart(_, tag) => {
                is_text(tag.as_deref(), &span)?;
                let mut entries = Vec::new();
                loop {
                    let (event, span) = self.next()?;
                    if matches!(event, Event::MappingEnd) {
                        break;
                    }
                    let key = self.node(event, span, depth + 1)?;
                    let (YamlKind::Plain(name) | YamlKind::Quoted(name)) = key.kind else {
                        return Err(Problem::error(key.span, "a key that is no name").into());
                    };
                    let (event, span) = self.next()?;
                    entries.push((name, key.span, self.node(event, span, depth + 1)?));
                }
                YamlKind::Map(entries)
            }
            Event::Alias(_) => {
                let problem = Problem::error(span, "an alias, which parameter files of ROS 2 have not");
                return Err(problem.hint("write the value itself").into());
            }
            Event::Nothing
            | Event::StreamStart
            | Event::StreamEnd
            | Event::DocumentStart(_)
            | Event::DocumentEnd
            | Event::SequenceEnd
            | Event::MappingEnd => return Err(Problem::error(span, "a value is missing").into()),
        };
        Ok(YamlNode { span, kind })
    }
}

/// Whether a tag makes a text of what follows.
fn is_text(tag: Option<&Tag>, span: &Range<usize>) -> Result<bool, Box<Problem>> {
    match tag {
        None => Ok(false),
        Some(tag) if tag.is_yaml_core_schema() && tag.suffix == "str" => Ok(true),
        Some(tag) => Err(Problem::error(span.clone(), format!("the tag {tag} is not read; only !!str is")).into()),
    }
}
