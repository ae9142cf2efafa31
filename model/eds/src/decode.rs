//! Bytes ↔ text.
//!
//! The standard requires ASCII. Tools write their national encoding, mostly ISO-8859-1 or its Windows relative, and of
//! late UTF-8. What is valid UTF-8 is taken as that, everything else byte for byte as ISO-8859-1: names may show a
//! wrong letter then, but no byte is lost, and nothing that a device is sent depends on it.

use linewright_diagnostics::{At, Problem, Report};

use crate::limits::FILE_BYTES_MAX;

/// Encoding of a file's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextEncoding {
    Utf8,
    /// With a byte order mark before it.
    Utf8Marked,
    Latin1,
}

const MARK: &[u8] = b"\xEF\xBB\xBF";

/// The text; or, with a problem, as much of it as could be read.
pub(crate) fn decode(bytes: &[u8], report: &mut Report) -> Result<(String, TextEncoding), String> {
    let mut refuse = |problem, readable| {
        report.add(problem);
        Err(readable)
    };
    let start = At::default();
    if bytes.len() > FILE_BYTES_MAX {
        let hint = format!("at most {FILE_BYTES_MAX} are read; is this the right file?");
        return refuse(Problem::error(start, format!("the file has {} bytes", bytes.len())).hint(hint), String::new());
    }
    if matches!(bytes, [0xFE, 0xFF, ..] | [0xFF, 0xFE, ..]) {
        return refuse(
            Problem::error(start, "the file is UTF-16").hint("save it as UTF-8 or ISO-8859-1"),
            String::new(),
        );
    }
    if let Some(at) = bytes.iter().position(|&byte| byte == 0) {
        let readable = latin1(&bytes[..at]);
        let at = At::new(readable.len()..readable.len());
        return refuse(Problem::error(at, "a zero byte: this is no text").hint("is this the right file?"), readable);
    }
    let (marked, rest) = match bytes.strip_prefix(MARK) {
        Some(rest) => (true, rest),
        None => (false, bytes),
    };
    match (std::str::from_utf8(rest), marked) {
        (Ok(text), true) => Ok((text.to_owned(), TextEncoding::Utf8Marked)),
        (Ok(text), false) => Ok((text.to_owned(), TextEncoding::Utf8)),
        (Err(_), false) => Ok((latin1(bytes), TextEncoding::Latin1)),
        (Err(error), true) => {
            let readable = latin1(&rest[..error.valid_up_to()]);
            let at = At::new(readable.len()..readable.len());
            let byte = rest.get(error.valid_up_to()).copied().unwrap_or_default();
            let message =
                format!("the byte 0x{byte:02X} here is not UTF-8, and the file begins with the mark of UTF-8");
            refuse(Problem::error(at, message).hint("save the whole file as UTF-8, or without the mark"), readable)
        }
    }
}

/// The bytes of a text. One that its old encoding cannot express, or only as something else, becomes marked UTF-8.
pub(crate) fn encode(text: &str, encoding: TextEncoding) -> Vec<u8> {
    let marked = || [MARK, text.as_bytes()].concat();
    match encoding {
        TextEncoding::Utf8 => text.as_bytes().to_vec(),
        TextEncoding::Utf8Marked => marked(),
        TextEncoding::Latin1 => {
            let bytes: Option<Vec<u8>> = text.chars().map(|c| u8::try_from(u32::from(c)).ok()).collect();
            // ASCII is the same in both; with anything else it must still not pass for UTF-8.
            bytes.filter(|bytes| text.is_ascii() || std::str::from_utf8(bytes).is_err()).unwrap_or_else(marked)
        }
    }
}

fn latin1(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| char::from(byte)).collect()
}
