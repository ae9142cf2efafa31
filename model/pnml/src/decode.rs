//! Bytes → text.
//!
//! PNML is UTF-8 as a rule. Older tools declare ISO-8859-1, which is as easily read; what is declared matters only if
//! there is a byte outside of ASCII. Other encodings are refused by name. Nothing is guessed: a wrong guess would show as
//! wrong names much later.

use std::borrow::Cow;

use crate::limits::FILE_BYTES_MAX;
use linewright_diagnostics::{At, Problem, Report, shown};

/// Bytes of the file that the XML declaration may reach into.
const DECLARATION_MAX: usize = 256;

/// The text; or, with a problem, as much of it as could be read.
pub(crate) fn decode<'a>(bytes: &'a [u8], report: &mut Report) -> Result<Cow<'a, str>, &'a str> {
    let mut refuse = |problem, readable| {
        report.add(problem);
        Err(readable)
    };
    let start = At::default();
    if bytes.len() > FILE_BYTES_MAX {
        let hint = format!("at most {FILE_BYTES_MAX} are read; is this the right file?");
        return refuse(Problem::error(start, format!("the file has {} bytes", bytes.len())).hint(hint), "");
    }
    if matches!(bytes, [0xFE, 0xFF, ..] | [0xFF, 0xFE, ..] | [0, b'<', ..] | [b'<', 0, ..]) {
        return refuse(Problem::error(start, "the file is UTF-16").hint("save it as UTF-8"), "");
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = match (declared(bytes), std::str::from_utf8(bytes)) {
        // In ASCII all that is declared in practice agrees: some programs write UTF-16 above text that is not.
        (_, Ok(text)) if text.is_ascii() => Cow::Borrowed(text),
        (XmlEncoding::Utf8, Ok(text)) => Cow::Borrowed(text),
        (XmlEncoding::Latin1, _) => bytes.iter().map(|&byte| char::from(byte)).collect::<String>().into(),
        (XmlEncoding::Utf8, Err(error)) => {
            let (valid, _) = bytes.split_at(error.valid_up_to());
            let readable = std::str::from_utf8(valid).unwrap_or_default();
            let message = format!("the byte 0x{:02X} here is not UTF-8", bytes[valid.len()]);
            let hint =
                "save the file as UTF-8, or declare the encoding: <?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>";
            return refuse(Problem::error(At::new(valid.len()..valid.len()), message).hint(hint), readable);
        }
        (XmlEncoding::Other(name), _) => {
            let problem = Problem::error(start, format!("the file declares the encoding `{}`", shown(&name)));
            return refuse(problem.hint("UTF-8, US-ASCII and ISO-8859-1 are read; save it as UTF-8"), "");
        }
    };
    match text.bytes().position(|byte| byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r')) {
        None => Ok(text),
        Some(at) => {
            let found = text.as_bytes()[at];
            let message = format!("the control character U+{found:04X} is not allowed in XML");
            let hint = if found == 0 { "is this the right file?" } else { "remove it" };
            // What was copied to be decoded cannot be lent to the caller; its beginning has the same lines in the bytes.
            let readable = std::str::from_utf8(bytes).unwrap_or_default();
            let place = if readable.len() == text.len() { At::new(at..at + 1) } else { start };
            refuse(Problem::error(place, message).hint(hint), readable)
        }
    }
}

enum XmlEncoding {
    Utf8,
    Latin1,
    Other(String),
}

/// Encoding by the XML declaration, if there is one.
fn declared(bytes: &[u8]) -> XmlEncoding {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(DECLARATION_MAX)]);
    let value = || {
        let (declaration, _) = head.strip_prefix("<?xml")?.split_once("?>")?;
        let (_, rest) = declaration.split_once("encoding")?;
        let rest = rest.trim_start().strip_prefix('=')?.trim_start();
        let quote = rest.chars().next().filter(|&c| c == '"' || c == '\'')?;
        rest[1..].split_once(quote).map(|(name, _)| name.to_ascii_lowercase())
    };
    match value().as_deref() {
        None | Some("utf-8" | "utf8" | "us-ascii" | "ascii") => XmlEncoding::Utf8,
        Some("iso-8859-1" | "iso8859-1" | "iso_8859-1" | "latin1" | "latin-1") => XmlEncoding::Latin1,
        Some(other) => XmlEncoding::Other(other.to_owned()),
    }
}
