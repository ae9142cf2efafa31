//! The bytes of an object, and how people write and read them.

use clap::ValueEnum;

/// Type of an object's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ValueKind {
    /// Unsigned, one byte.
    U8,
    /// Unsigned, two bytes.
    U16,
    /// Unsigned, four bytes.
    U32,
    /// Unsigned, eight bytes.
    U64,
    /// Signed, one byte.
    I8,
    /// Signed, two bytes.
    I16,
    /// Signed, four bytes.
    I32,
    /// Signed, eight bytes.
    I64,
    /// A floating point number of four bytes.
    F32,
    /// A floating point number of eight bytes.
    F64,
    /// Text.
    Text,
    /// Bytes in hexadecimal: `01 02` or `0102`.
    Hex,
}

impl ValueKind {
    /// Bytes of a whole number, and whether it has a sign.
    fn whole(self) -> Option<(usize, bool)> {
        match self {
            ValueKind::U8 => Some((1, false)),
            ValueKind::U16 => Some((2, false)),
            ValueKind::U32 => Some((4, false)),
            ValueKind::U64 => Some((8, false)),
            ValueKind::I8 => Some((1, true)),
            ValueKind::I16 => Some((2, true)),
            ValueKind::I32 => Some((4, true)),
            ValueKind::I64 => Some((8, true)),
            ValueKind::F32 | ValueKind::F64 | ValueKind::Text | ValueKind::Hex => None,
        }
    }

    /// The bytes of what a person has written, least significant first.
    pub fn bytes(self, text: &str) -> Result<Vec<u8>, String> {
        if let Some((len, signed)) = self.whole() {
            let number = number(text).ok_or_else(|| format!("'{text}' is no whole number; write 10, -10 or 0x0A"))?;
            let bits = 8 * len as u32;
            let (least, most) =
                if signed { (-(1i128 << (bits - 1)), (1i128 << (bits - 1)) - 1) } else { (0, (1i128 << bits) - 1) };
            if !(least..=most).contains(&number) {
                return Err(format!("{number} does not fit {len} bytes; {least} to {most} do"));
            }
            return Ok(number.to_le_bytes()[..len].to_vec());
        }
        let real = |error| format!("'{text}': {error}");
        match self {
            ValueKind::F32 => Ok(text.parse::<f32>().map_err(real)?.to_le_bytes().to_vec()),
            ValueKind::F64 => Ok(text.parse::<f64>().map_err(real)?.to_le_bytes().to_vec()),
            ValueKind::Hex => hex(text).ok_or_else(|| format!("'{text}' is not pairs of hexadecimal digits")),
            _ => Ok(text.as_bytes().to_vec()),
        }
    }

    /// Bytes in a person's words; an error if they cannot be that.
    pub fn text(self, bytes: &[u8]) -> Result<String, String> {
        if let Some((len, signed)) = self.whole() {
            let mut wide = [0; 16];
            fits(bytes, len)?;
            wide[..len].copy_from_slice(bytes);
            let unsigned = i128::from_le_bytes(wide);
            let negative = signed && bytes[len - 1] & 0x80 != 0;
            let number = if negative { unsigned - (1i128 << (8 * len)) } else { unsigned };
            return Ok(number.to_string());
        }
        match self {
            ValueKind::F32 => Ok(f32::from_le_bytes(fits(bytes, 4)?.try_into().unwrap_or_default()).to_string()),
            ValueKind::F64 => Ok(f64::from_le_bytes(fits(bytes, 8)?.try_into().unwrap_or_default()).to_string()),
            ValueKind::Hex => Ok(spaced(bytes)),
            _ => Ok(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned()),
        }
    }
}

/// Likely values of bytes whose type is not given.
pub fn guess(bytes: &[u8]) -> String {
    let hex = spaced(bytes);
    let readable = |byte: &u8| byte.is_ascii_graphic() || *byte == b' ';
    let text = bytes.strip_suffix(b"\0").unwrap_or(bytes);
    match bytes.len() {
        0 => "empty".to_owned(),
        len @ (1 | 2 | 4 | 8) => {
            let mut wide = [0; 8];
            wide[..len].copy_from_slice(bytes);
            let number = u64::from_le_bytes(wide);
            format!("{number} ({number:0width$X}h; bytes {hex})", width = 2 * len)
        }
        _ if text.iter().all(readable) => format!("\"{}\" ({} bytes)", String::from_utf8_lossy(text), bytes.len()),
        len => format!("{hex} ({len} bytes)"),
    }
}

fn fits(bytes: &[u8], len: usize) -> Result<&[u8], String> {
    if bytes.len() == len {
        return Ok(bytes);
    }
    Err(format!("the object has {} bytes ({}), this type has {len}", bytes.len(), spaced(bytes)))
}

fn number(text: &str) -> Option<i128> {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    // `from_str_radix` alone would take another sign.
    let plain = digits.bytes().all(|byte| byte.is_ascii_alphanumeric());
    let magnitude = match digits.strip_prefix("0x") {
        Some(hex) => u64::from_str_radix(hex, 16).ok(),
        None => digits.parse::<u64>().ok(),
    };
    magnitude.filter(|_| plain).map(|magnitude| sign * i128::from(magnitude))
}

fn hex(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let pair = |pair: &[u8]| {
        let digit = |at: usize| char::from(pair[at]).to_digit(16);
        Some((digit(0)? * 16 + digit(1)?) as u8)
    };
    digits.len().is_multiple_of(2).then(|| digits.chunks_exact(2).map(pair).collect())?
}

fn spaced(bytes: &[u8]) -> String {
    let digits: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    digits.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let cases = [
            (ValueKind::U8, "255", &[0xFF][..]),
            (ValueKind::U16, "0x1234", &[0x34, 0x12]),
            (ValueKind::I16, "-2", &[0xFE, 0xFF]),
            (ValueKind::I8, "-128", &[0x80]),
            (ValueKind::U64, "18446744073709551615", &[0xFF; 8]),
            (ValueKind::F32, "1.5", &[0, 0, 0xC0, 0x3F]),
            (ValueKind::Text, "mill 1", b"mill 1"),
            (ValueKind::Hex, "01 0a", &[1, 10]),
        ];
        for (kind, text, bytes) in cases {
            assert_eq!(kind.bytes(text).as_deref(), Ok(bytes), "{text}");
        }
        assert_eq!(ValueKind::I16.text(&[0xFE, 0xFF]).as_deref(), Ok("-2"));
        assert_eq!(ValueKind::U32.text(&[1, 0, 0, 0x80]).as_deref(), Ok("2147483649"));
        assert_eq!(ValueKind::F32.text(&[0, 0, 0xC0, 0x3F]).as_deref(), Ok("1.5"));
        assert_eq!(ValueKind::Text.text(b"io\0\0").as_deref(), Ok("io"));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let bad = [
            (ValueKind::U8, "256"),
            (ValueKind::U8, "-1"),
            (ValueKind::I8, "128"),
            (ValueKind::U8, "+1"),
            (ValueKind::U8, "0x+1"),
        ];
        for (kind, text) in bad.into_iter().chain([
            (ValueKind::U8, ""),
            (ValueKind::Hex, "012"),
            (ValueKind::Hex, "0g"),
            (ValueKind::F32, "x"),
        ]) {
            assert!(kind.bytes(text).is_err(), "{kind:?} {text}");
        }
        assert!(ValueKind::U16.text(&[1]).is_err());
    }

    #[test]
    fn bytes_of_no_known_type_are_shown_in_every_likely_way() {
        assert_eq!(guess(&[0x91, 0x01, 0x03, 0x00]), "197009 (00030191h; bytes 91 01 03 00)");
        assert_eq!(guess(b"linewright io"), "\"linewright io\" (13 bytes)");
        assert_eq!(guess(&[1, 2, 3]), "01 02 03 (3 bytes)");
        assert_eq!(guess(&[]), "empty");
    }
}
