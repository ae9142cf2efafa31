//! The labels of a node or arc: `<name>`, `<initialMarking>`, `<inscription>` and the like.
//!
//! The standard puts the text of a label in `<text>`; PIPE puts it in `<value>`, and numbers as `Default,1`: one token of
//! the only colour that its place/transition nets have. Text that stands in neither is read as well: a marking that is
//! passed over makes another net. For the same reason a label that holds only what is not known here is refused.

use crate::limits::NAME_BYTES_MAX;
use crate::xml::{AttributeValue, ElementText, Xml, XmlAbort};
use linewright_diagnostics::{At, Problem, Report, shown};

/// Reads the label that is open: its text, or none if it is only drawn.
pub(crate) fn label<'a>(xml: &mut Xml<'a>, report: &mut Report) -> Result<Option<AttributeValue<'a>>, XmlAbort> {
    let mut found: Option<AttributeValue<'a>> = None;
    let mut unknown: Option<Problem> = None;
    let mut bare = ElementText::default();
    while let Some(tag) = xml.child_behind(&mut bare, report)? {
        if matches!(tag.name, "text" | "value") {
            let value = xml.content(report)?;
            let at = if value.text.is_empty() { tag.at } else { value.at };
            add(&mut found, AttributeValue { at, ..value }, tag.at, report);
            continue;
        }
        if !matches!(tag.name, "graphics" | "toolspecific") {
            let finding = Problem::error(tag.at, format!("`{}` in a label is not known here", shown(tag.name)));
            unknown.get_or_insert(finding.hint("write what the label says in `<text>`"));
        }
        xml.skip(report)?;
    }
    let bare = bare.value();
    if !bare.text.is_empty() {
        let at = bare.at;
        add(&mut found, bare, at, report);
    }
    if let (None, Some(finding)) = (&found, unknown) {
        report.add(finding);
    }
    Ok(found)
}

/// A label may be given twice by a tool that writes for two readers; it may not have two values.
fn add<'a>(found: &mut Option<AttributeValue<'a>>, value: AttributeValue<'a>, at: At, report: &mut Report) {
    match found {
        Some(first) if first.text != value.text => {
            report.add(Problem::error(at, "this label has two texts").hint("remove one of the two"));
        }
        _ => *found = Some(value),
    }
}

/// A name that is short enough; an empty one is none.
pub(crate) fn name(value: AttributeValue<'_>, report: &mut Report) -> Option<String> {
    if value.text.len() > NAME_BYTES_MAX {
        report.add(Problem::error(value.at, format!("a name has more than {NAME_BYTES_MAX} bytes")).hint("shorten it"));
        return None;
    }
    (!value.text.is_empty()).then(|| value.text.into_owned())
}

/// A number of tokens, if one is given. `what` names it in messages: "the initial marking of the place `p`".
pub(crate) fn number(value: &AttributeValue<'_>, what: impl Fn() -> String, report: &mut Report) -> Option<u32> {
    let text = value.text.trim();
    if text.is_empty() {
        return None;
    }
    let (colour, digits) = text.rsplit_once(',').map_or(("Default", text), |(colour, n)| (colour.trim(), n.trim()));
    match digits.parse() {
        Ok(number) if colour == "Default" => return Some(number),
        _ => {}
    }
    report.add(refusal(value.at, &what(), text, colour, digits));
    // It has been reported; so that nothing is reported in its wake, any number will do.
    Some(1)
}

fn refusal(at: At, what: &str, text: &str, colour: &str, digits: &str) -> Problem {
    let finding = Problem::error(at, format!("{what} is `{}`", shown(text)));
    let unsigned = digits.trim_start_matches(['-', '+']);
    let is_number = !unsigned.is_empty() && unsigned.bytes().all(|byte| byte.is_ascii_digit());
    if colour != "Default" {
        finding.hint("tokens with colours are not read; only place/transition nets are")
    } else if is_number && digits.starts_with('-') {
        finding.hint("it cannot be negative")
    } else if is_number {
        finding.hint(format!("at most {} is possible", u32::MAX))
    } else {
        finding.hint("a whole number is needed")
    }
}
