//! Numbers as CiA 306 writes them: `10`, `0x1F`, `017` (octal), `-5`, and sums with the node id, `$NODEID+0x180`.

use std::fmt;

use linewright_diagnostics::shown;

/// A number and how it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    /// Between −(2^64 − 1) and 2^64 − 1.
    pub value: i128,
    /// Written in hexadecimal, which for a signed type may mean its bits.
    pub is_hex: bool,
    /// Written with a leading 0, and something else if read as decimal.
    pub is_octal: bool,
}

/// Reason why a text is no number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NotANumber {
    /// There is nothing.
    Empty,
    /// A leading 0 means octal, and this has an 8 or a 9.
    BadOctal(String),
    /// Hexadecimal the way PLC programmers write it.
    HexSuffix(String),
    /// `NODEID` without its `$`, or something else than a sum.
    BadNodeId(String),
    /// More than 64 bits.
    TooLong(String),
    /// Anything else.
    Other(String),
}

impl NotANumber {
    /// Advice.
    pub(crate) fn hint(&self) -> &'static str {
        match self {
            NotANumber::Empty => "write a number, or remove the key",
            NotANumber::BadOctal(_) => {
                "a leading 0 means octal; write it without the 0, or with 0x if it is hexadecimal"
            }
            NotANumber::HexSuffix(_) => "write hexadecimal as 0x1F",
            NotANumber::BadNodeId(_) => "the node id is added as in $NODEID+0x180",
            NotANumber::TooLong(_) => "no type has more than 64 bits",
            NotANumber::Other(_) => "write it as 31, 0x1F or 037",
        }
    }
}

impl fmt::Display for NotANumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotANumber::Empty => f.write_str("there is no number"),
            NotANumber::TooLong(text) => write!(f, "`{}` has more than 64 bits", shown(text)),
            NotANumber::BadOctal(text) | NotANumber::HexSuffix(text) | NotANumber::Other(text) => {
                write!(f, "`{}` is not a number", shown(text))
            }
            NotANumber::BadNodeId(text) => write!(f, "`{}` is no sum of a number and $NODEID", shown(text)),
        }
    }
}

/// Reads one number.
pub(crate) fn number(text: &str) -> Result<Number, NotANumber> {
    let text = text.trim();
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text),
    };
    let (radix, digits) = if let Some(hex) = digits.strip_prefix("0x").or(digits.strip_prefix("0X")) {
        (16, hex)
    } else if digits.len() > 1 && digits.starts_with('0') {
        (8, &digits[1..])
    } else {
        (10, digits)
    };
    if text.is_empty() {
        return Err(NotANumber::Empty);
    }
    if digits.is_empty() || !digits.chars().all(|c| c.is_digit(radix)) {
        return Err(wrong(text, radix, digits));
    }
    let Ok(value) = u64::from_str_radix(digits, radix) else { return Err(NotANumber::TooLong(text.to_owned())) };
    let value = if negative { -i128::from(value) } else { i128::from(value) };
    Ok(Number { value, is_hex: radix == 16, is_octal: radix == 8 && value.abs() > 7 })
}

fn wrong(text: &str, radix: u32, digits: &str) -> NotANumber {
    let hex_suffix = text.strip_suffix(['h', 'H']).is_some_and(|rest| {
        rest.starts_with(|c: char| c.is_ascii_digit()) && rest.chars().all(|c| c.is_ascii_hexdigit())
    });
    let text = text.to_owned();
    match () {
        () if hex_suffix => NotANumber::HexSuffix(text),
        () if radix == 8 && !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()) => {
            NotANumber::BadOctal(text)
        }
        () if text.to_ascii_uppercase().contains("NODEID") => NotANumber::BadNodeId(text),
        () => NotANumber::Other(text),
    }
}

/// Reads a number or a sum of one with the node id; whether the node id is to be added.
pub(crate) fn sum(text: &str) -> Result<(Number, bool), NotANumber> {
    let is_node_id = |term: &str| term.trim().eq_ignore_ascii_case("$NODEID");
    let zero = Number { value: 0, is_hex: false, is_octal: false };
    match text.split_once('+') {
        None if is_node_id(text) => Ok((zero, true)),
        None => Ok((number(text)?, false)),
        Some((first, second)) if is_node_id(first) => Ok((number(second)?, true)),
        Some((first, second)) if is_node_id(second) => Ok((number(first)?, true)),
        Some(_) => Err(NotANumber::BadNodeId(text.to_owned())),
    }
}
