//! XML in the form that the readers of this crate need: the children of an element, its attributes, its text.
//!
//! A thin layer over `quick-xml`, which finds tags and checks that they are closed in order. Here are the bounds on
//! depth and attributes, the places of everything in the text, and words for what is wrong. No entity is ever expanded
//! but the five of XML itself; a DOCTYPE is passed over. Prefixes are ignored: no two of PNML's elements differ in
//! nothing else.

use std::borrow::Cow;

use quick_xml::Reader;
use quick_xml::errors::IllFormedError;
use quick_xml::events::{BytesStart, Event};

use crate::limits::{ATTRIBUTES_MAX, DEPTH_MAX, NAME_BYTES_MAX};
use linewright_diagnostics::{At, Problem, Report, shown};

/// The text cannot be read on; the reason is in the report.
pub(crate) struct XmlAbort;

/// The start of an element.
pub(crate) struct Tag<'a> {
    /// Its name without prefix.
    pub name: &'a str,
    /// The whole start tag.
    pub at: At,
    start: BytesStart<'a>,
}

/// The value of an attribute, or the text in an element.
#[derive(Clone, Debug)]
pub(crate) struct AttributeValue<'a> {
    pub text: Cow<'a, str>,
    pub at: At,
}

pub(crate) struct Xml<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    /// The start tags of the elements that are open.
    open: Vec<At>,
    /// An element has been opened.
    has_root: bool,
}

impl<'a> Xml<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Xml { text, reader, open: Vec::new(), has_root: false }
    }

    /// The next child of the element that is open; none when that has been closed.
    pub(crate) fn child(&mut self, report: &mut Report) -> Result<Option<Tag<'a>>, XmlAbort> {
        loop {
            let (event, at) = self.event(report)?;
            match event {
                Event::Start(start) => return self.opened(start, at, report).map(Some),
                Event::End(_) | Event::Eof => return Ok(None),
                _ => {}
            }
        }
    }

    /// Passes over the rest of the element that is open.
    pub(crate) fn skip(&mut self, report: &mut Report) -> Result<(), XmlAbort> {
        let outside = self.open.len().saturating_sub(1);
        loop {
            let (event, at) = self.event(report)?;
            match event {
                Event::Start(start) => _ = self.opened(start, at, report)?,
                Event::End(_) if self.open.len() == outside => return Ok(()),
                Event::Eof => return Ok(()),
                _ => {}
            }
        }
    }

    /// The text in the element that is open, without blanks around it; other elements in it are passed over. Blanks that
    /// are written as references (`&#32;`) are meant, and stay.
    pub(crate) fn content(&mut self, report: &mut Report) -> Result<AttributeValue<'a>, XmlAbort> {
        let mut text = ElementText::default();
        while self.child_behind(&mut text, report)?.is_some() {
            self.skip(report)?;
        }
        Ok(text.value())
    }

    /// As [`Xml::child`]; adds to `text` what stands before the child.
    pub(crate) fn child_behind(
        &mut self,
        text: &mut ElementText,
        report: &mut Report,
    ) -> Result<Option<Tag<'a>>, XmlAbort> {
        loop {
            let (event, at) = self.event(report)?;
            match event {
                Event::Text(part) => text.content.literal(&part.xml10_content()),
                Event::CData(part) => text.content.literal(&part.xml10_content()),
                Event::GeneralRef(reference) => match character(&reference) {
                    Some(c) => text.content.meant(c),
                    None => report.add(
                        Problem::error(
                            at,
                            format!("`&{};` stands for no character that is known here", shown(&reference)),
                        )
                        .hint(ONLY_PREDEFINED),
                    ),
                },
                Event::Start(start) => return self.opened(start, at, report).map(Some),
                Event::End(_) | Event::Eof => return Ok(None),
                _ => continue,
            }
            text.at = Some(At { end: at.end, ..text.at.unwrap_or(at) });
        }
    }

    /// One event with its place. Closing more than was opened, or less, is an error of `quick-xml` or here.
    fn event(&mut self, report: &mut Report) -> Result<(Event<'a>, At), XmlAbort> {
        let start = self.position();
        let event = self.reader.read_event();
        let at = At::new(start..self.position());
        match event {
            Ok(Event::Eof) if !self.open.is_empty() => {
                let tag = *self.open.last().unwrap_or(&at);
                let shown = shown(&self.text[tag.start as usize..tag.end as usize]);
                let finding = Problem::error(tag, format!("the file ends before `{shown}` is closed"));
                report.add(finding.label("opened here").hint("the file has been cut short; write it again"));
                Err(XmlAbort)
            }
            Ok(Event::End(end)) => {
                self.open.pop();
                Ok((Event::End(end), at))
            }
            Ok(event) => Ok((event, at)),
            Err(error) => {
                let from = usize::try_from(self.reader.error_position()).unwrap_or(start);
                // Errors of what is never closed are placed where it begins; all else is behind it.
                let place = At::new(from..self.position().clamp(from, from.saturating_add(60)));
                report.add(
                    Problem::error(place, format!("this is not XML: {}", words(&error))).label("reading stopped here"),
                );
                Err(XmlAbort)
            }
        }
    }

    fn opened(&mut self, start: BytesStart<'a>, at: At, report: &mut Report) -> Result<Tag<'a>, XmlAbort> {
        if self.open.is_empty() && self.has_root {
            let finding = Problem::error(at, "a second element stands behind the end of the first");
            report.add(finding.hint("a file has one outermost element; keep each in a file of its own"));
            return Err(XmlAbort);
        }
        if self.open.len() == DEPTH_MAX {
            let finding = Problem::error(at, format!("elements are nested more than {DEPTH_MAX} deep"));
            report.add(finding.hint("no net needs that; is this the right file?"));
            return Err(XmlAbort);
        }
        self.has_root = true;
        self.open.push(at);
        let name = self.name_of(at);
        Ok(Tag { name, at, start })
    }

    /// The name of the element whose start tag is at `at`, without its prefix.
    fn name_of(&self, at: At) -> &'a str {
        let tag = &self.text[at.start as usize + 1..at.end as usize];
        let name = &tag[..tag.find(|c: char| c.is_ascii_whitespace() || matches!(c, '>' | '/')).unwrap_or(tag.len())];
        name.rsplit_once(':').map_or(name, |(_, local)| local)
    }

    fn position(&self) -> usize {
        usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX).min(self.text.len())
    }
}

impl<'a> Tag<'a> {
    /// The values of these attributes, in the order of `names`. Errors of any attribute are reported.
    pub(crate) fn attributes<const N: usize>(
        &self,
        xml: &Xml<'a>,
        names: [&str; N],
        report: &mut Report,
    ) -> [Option<AttributeValue<'a>>; N] {
        let mut values = [const { None }; N];
        for (index, attribute) in self.start.attributes().enumerate() {
            if index == ATTRIBUTES_MAX {
                report
                    .add(Problem::error(self.at, format!("`{}` has more than {ATTRIBUTES_MAX} attributes", self.name)));
                break;
            }
            let attribute = match attribute {
                Ok(attribute) => attribute,
                Err(error) => {
                    report.add(Problem::error(
                        self.at,
                        format!("an attribute of `{}` cannot be read: {error}", self.name),
                    ));
                    break;
                }
            };
            if let Some(wanted) = names.iter().position(|&name| name == attribute.key.as_ref()) {
                values[wanted] = self.value(xml, names[wanted], &attribute.value, report);
            }
        }
        values
    }

    /// One value. An error in it is reported, and it stands for itself as it is written, so that nothing else looks as
    /// if it were missing.
    fn value(&self, xml: &Xml<'a>, name: &str, raw: &str, report: &mut Report) -> Option<AttributeValue<'a>> {
        // The reader lends parts of the text without their places.
        let start = (raw.as_ptr() as usize).wrapping_sub(xml.text.as_ptr() as usize);
        let range = start..start.saturating_add(raw.len());
        let raw = xml.text.get(range.clone())?;
        let at = At::new(range);
        let finding = match quick_xml::escape::unescape(raw) {
            _ if raw.len() > NAME_BYTES_MAX => {
                Problem::error(at, format!("the attribute `{name}` has {} bytes", raw.len()))
                    .hint(format!("at most {NAME_BYTES_MAX}"))
            }
            Ok(text) if text.chars().all(is_legal) => return Some(AttributeValue { text, at }),
            Ok(_) => Problem::error(at, format!("the attribute `{name}` has a character that is not allowed in XML")),
            Err(error) => {
                let error = shown(&error.to_string());
                Problem::error(at, format!("the attribute `{name}` cannot be read: {error}")).hint(ONLY_PREDEFINED)
            }
        };
        report.add(finding);
        Some(AttributeValue { text: raw.into(), at })
    }
}

const ONLY_PREDEFINED: &str =
    "`&lt; &gt; &amp; &quot; &apos;` and `&#number;` are read, and entities of one's own are not";

/// Message of `quick-xml`, with a repetition of the text cut to what can be read.
fn words(error: &quick_xml::Error) -> String {
    match error {
        quick_xml::Error::Syntax(error) => error.to_string(),
        quick_xml::Error::IllFormed(IllFormedError::MismatchedEndTag { expected, found }) => {
            format!("`</{}>` is expected here, not `</{}>`", shown(expected), shown(found))
        }
        quick_xml::Error::IllFormed(IllFormedError::UnmatchedEndTag(found)) => {
            format!("`</{}>` closes nothing", shown(found))
        }
        quick_xml::Error::IllFormed(IllFormedError::UnclosedReference) => {
            "a `&` that begins no reference is written `&amp;`".to_owned()
        }
        other => shown(&other.to_string()),
    }
}

/// The character that a reference in a text stands for.
fn character(reference: &quick_xml::events::BytesRef<'_>) -> Option<char> {
    let c = match reference.resolve_char_ref().ok()? {
        Some(c) => c,
        None => quick_xml::escape::resolve_predefined_entity(reference)?.chars().next()?,
    };
    is_legal(c).then_some(c)
}

/// Whether XML allows this character.
pub(crate) fn is_legal(c: char) -> bool {
    (c >= ' ' || matches!(c, '\t' | '\n' | '\r')) && !matches!(c, '\u{FFFE}' | '\u{FFFF}')
}

/// The text in an element, with its place.
#[derive(Default)]
pub(crate) struct ElementText {
    content: BoundedText,
    at: Option<At>,
}

impl ElementText {
    pub(crate) fn value<'a>(self) -> AttributeValue<'a> {
        AttributeValue { text: self.content.finish().into(), at: self.at.unwrap_or_default() }
    }
}

/// Text being put together, bounded.
#[derive(Default)]
struct BoundedText {
    text: String,
    /// Up to here it stays whatever follows; behind it are blanks that may turn out to be the last.
    kept: usize,
}

impl BoundedText {
    fn literal(&mut self, part: &str) {
        for c in part.chars() {
            if !c.is_whitespace() {
                // Where the whole text is looked through for control characters, these two cannot be seen.
                self.meant(if is_legal(c) { c } else { '\u{FFFD}' });
            } else if self.kept > 0 && self.has_room() {
                self.text.push(c);
            }
        }
    }

    fn meant(&mut self, c: char) {
        if self.has_room() {
            self.text.push(c);
            self.kept = self.text.len();
        }
    }

    /// One more than is allowed, so that a check of the length sees it.
    fn has_room(&self) -> bool {
        self.text.len() <= NAME_BYTES_MAX
    }

    fn finish(mut self) -> String {
        self.text.truncate(self.kept);
        self.text
    }
}
