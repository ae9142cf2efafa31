//! Reader of I/O lists exported by spreadsheets and PLC tools: column names, separators, encodings.

use linewright_line::{IO_COLUMNS, IoRow, RowProblem, suggestion};

/// Alternative column names, in the order of [`IO_COLUMNS`], in lower case: TIA Portal and STEP 7, English and German.
const WORDS: [&[&str]; IO_COLUMNS.len()] = [
    &["symbol", "tag", "tag name", "signal", "variable", "variable name", "variablenname"],
    &["logical address", "operand", "adresse", "logische adresse"],
    &["device name", "module", "modul", "baugruppe", "gerät"],
    &[],
    &["kommentar", "description", "beschreibung"],
];

/// The text of a list.
#[derive(Debug, PartialEq, Eq)]
pub struct ListText {
    pub text: String,
    /// Its encoding does not say of itself that it is the right one.
    pub is_guessed: bool,
}

/// A list's text: UTF-8, UTF-16 with its mark, or else Windows-1252, which spreadsheets write. Names of signals are plain in
/// any of them.
pub fn text(bytes: Vec<u8>) -> Result<ListText, &'static str> {
    let wide = match bytes.as_slice() {
        [0xFF, 0xFE, rest @ ..] => Some((rest, u16::from_le_bytes as fn([u8; 2]) -> u16)),
        [0xFE, 0xFF, rest @ ..] => Some((rest, u16::from_be_bytes as fn([u8; 2]) -> u16)),
        _ => None,
    };
    if let Some((rest, unit)) = wide {
        let (units, odd) = rest.as_chunks::<2>();
        let text = String::from_utf16(&units.iter().map(|&pair| unit(pair)).collect::<Vec<_>>());
        let text = text.ok().filter(|_| odd.is_empty()).ok_or("begins as UTF-16 and goes on as something else")?;
        return Ok(ListText { text, is_guessed: false });
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(ListText { text, is_guessed: false }),
        Err(error) => {
            let text = error.as_bytes().iter().map(|&byte| windows_1252(byte)).collect::<Option<String>>();
            let text = text.ok_or("is neither UTF-8 nor Windows-1252: save it as CSV in UTF-8")?;
            Ok(ListText { text, is_guessed: true })
        }
    }
}

fn windows_1252(byte: u8) -> Option<char> {
    const FROM_80: [char; 32] = [
        '€', '\0', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\0', 'Ž', '\0', '\0', '‘', '’', '“', '”',
        '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\0', 'ž', 'Ÿ',
    ];
    match byte {
        0x80..=0x9F => Some(FROM_80[usize::from(byte - 0x80)]).filter(|&letter| letter != '\0'),
        _ => Some(char::from(byte)),
    }
}

/// Where a column is: under its own name, or under the only other word for it.
fn column(nth: usize, headers: &csv::StringRecord, problems: &mut Vec<RowProblem>) -> Option<usize> {
    let own = headers.iter().position(|header| header.eq_ignore_ascii_case(IO_COLUMNS[nth]));
    let is_word = |header: &str| WORDS[nth].contains(&header.to_lowercase().as_str());
    let mut words = headers.iter().enumerate().filter(|(_, header)| own.is_none() && is_word(header));
    let found = words.next();
    if let (Some((_, one)), Some((_, other))) = (found, words.next()) {
        let name = IO_COLUMNS[nth];
        let message = format!("`{one}` and `{other}` may both be the column `{name}`: call the right one `{name}`");
        problems.push(RowProblem { line: 1, column: "", message });
    }
    own.or(found.map(|(at, _)| at))
}

fn missing(nth: usize, headers: &csv::StringRecord) -> RowProblem {
    let name = IO_COLUMNS[nth];
    let near = suggestion(name, headers.iter()).filter(|_| headers.len() > 1);
    let near = near.map(|near| format!(" ({near})")).unwrap_or_default();
    let mut message = format!("the first line has no column `{name}`{near}");
    // The list of a controller has none.
    if name == "device" {
        message += ": add one, or say where each device begins in the controller's addresses, as in --begin 'drill io=%I4,%Q4'";
    }
    RowProblem { line: 1, column: "", message }
}

/// The rows of a list. Commas, semicolons and tabs separate, whichever the first line has most of. `is_counted_through`: the
/// list is of a whole controller, and may be without devices.
pub fn rows(text: &str, is_counted_through: bool) -> Result<Vec<IoRow>, Vec<RowProblem>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.lines().next().unwrap_or("");
    let count = |sign: u8| first.bytes().filter(|byte| *byte == sign).count();
    let separator = [b',', b';', b'\t'].into_iter().rev().max_by_key(|sign| count(*sign)).unwrap_or(b',');
    let mut reader =
        csv::ReaderBuilder::new().delimiter(separator).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
    let unreadable = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        vec![RowProblem { line, column: "", message: format!("cannot be read: {error}") }]
    };
    let headers = reader.headers().map_err(unreadable)?.clone();
    let mut problems = Vec::new();
    let at: [Option<usize>; IO_COLUMNS.len()] = std::array::from_fn(|nth| column(nth, &headers, &mut problems));
    let needed = if is_counted_through { 2 } else { 3 };
    let missing = (0..needed).filter(|&nth| at[nth].is_none()).map(|nth| missing(nth, &headers));
    if problems.is_empty() {
        problems.extend(missing);
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut rows = Vec::new();
    let (mut counted, mut line) = (0, 1);
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let field = |column: usize| at[column].map(|at| record.get(at).unwrap_or("").to_owned());
        if record.iter().all(str::is_empty) {
            continue;
        }
        let [name, address, device] = [0, 1, 2].map(|column| field(column).unwrap_or_default());
        // The reader's own count of lines is behind where lines end with CR LF.
        let from = record.position().and_then(|at| usize::try_from(at.byte()).ok()).unwrap_or(counted);
        let begin = text.len() - text[from..].trim_start_matches(['\r', '\n']).len();
        line += text.as_bytes()[counted..begin].iter().filter(|&&byte| byte == b'\n').count() as u64;
        counted = begin;
        let mut wrong = |message: &str| problems.push(RowProblem { line, column: "", message: message.to_owned() });
        if record.iter().any(|field| field.contains('\n')) {
            wrong("a field goes on in the next line: a quote is not closed");
        }
        if record.iter().skip(headers.len()).any(|field| !field.is_empty()) {
            wrong("more fields than the first line has columns: a text with the separator in it stands in quotes");
        }
        rows.push(IoRow { line, name, address, device, station: field(3), comment: field(4) });
    }
    if problems.is_empty() { Ok(rows) } else { Err(problems) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_as_spreadsheets_write_them() {
        let row = |line, name: &str| IoRow {
            line,
            name: name.to_owned(),
            address: "%IX0.0".to_owned(),
            device: "clamp, io".to_owned(),
            station: None,
            comment: Some("says \"no\"".to_owned()),
        };
        for (separator, device) in [(',', "\"clamp, io\""), (';', "clamp, io"), ('\t', "clamp, io")] {
            let header = ["Address", "type", "DEVICE", "comment", "name"].join(&separator.to_string());
            let line =
                |name: &str| ["%IX0.0", "BOOL", device, "\"says \"\"no\"\"\"", name].join(&separator.to_string());
            let text = format!("\u{feff}{header}\r\n{}\r\n\r\n{}\r\n", line(" a "), line("b"));
            assert_eq!(rows(&text, false).expect("read"), [row(2, "a"), row(4, "b")], "{separator:?}");
        }
        let unclosed =
            rows("name,address,device\na,%IX0.0,\"far side\nb,%IX0.1,clamp\n", false).expect_err("not closed");
        assert_eq!((unclosed[0].line, unclosed.len()), (2, 1), "{unclosed:?}");
        let longer = rows("name;address;device;comment\na;%IX0.0;clamp;near; above\n", false).expect_err("five fields");
        assert!(longer[0].message.starts_with("more fields"), "{longer:?}");
        let short = rows("name,address,device\nx\n", false).expect("read");
        assert_eq!((short[0].device.as_str(), &short[0].comment, &short[0].station), ("", &None, &None));
    }

    #[test]
    fn a_list_without_its_columns_is_refused() {
        let problems = rows("name;adress;device\n", false).expect_err("no address");
        assert_eq!(problems[0].message, "the first line has no column `address` (did you mean `adress`?)");
        assert_eq!(rows("", false).expect_err("nothing").len(), 3);
    }

    #[test]
    fn columns_may_have_the_words_of_other_tools() {
        let tia = "Name;Path;Data Type;Logical Address;Comment;Hmi Visible\nY_up;Tags;Bool;%Q4.0;up;True\n";
        let found = rows(tia, true).expect("read");
        let comment = Some("up".to_owned());
        let row = IoRow { line: 2, name: "Y_up".to_owned(), address: "%Q4.0".to_owned(), comment, ..IoRow::default() };
        assert_eq!(found, [row]);
        let german = "Symbol;Operand;Baugruppe;Kommentar\nY_up;A 4.0;press io;oben\n";
        let found = rows(german, false).expect("read");
        assert_eq!((found[0].device.as_str(), found[0].comment.as_deref()), ("press io", Some("oben")));
        let both = rows("Symbol;Tag;Operand;Device\n", false).expect_err("two names");
        assert_eq!(both[0].message, "`Symbol` and `Tag` may both be the column `name`: call the right one `name`");
        assert_eq!(both.len(), 1, "{both:?}");
        let own = rows("Symbol;Name;Address;Device;Tag\nx;y;%I0.0;d;z\n", false).expect("its own name");
        assert_eq!(own[0].name, "y");
        let controller = rows("Symbol,Address\n", false).expect_err("no device");
        assert!(controller[0].message.contains("--begin"), "{controller:?}");
    }

    #[test]
    fn encodings_are_told_apart() {
        let read = |bytes: &[u8]| text(bytes.to_vec()).map(|list| (list.text, list.is_guessed));
        assert_eq!(read("Gerät".as_bytes()), Ok(("Gerät".to_owned(), false)));
        assert_eq!(read(b"Ger\xE4t \x80"), Ok(("Gerät €".to_owned(), true)));
        assert_eq!(read(b"\xFF\xFEG\0\xE4\0"), Ok(("Gä".to_owned(), false)));
        assert_eq!(read(b"\xFE\xFF\0G\0\xE4"), Ok(("Gä".to_owned(), false)));
        assert!(read(b"\xFF\xFEG\0\xE4").is_err_and(|why| why.contains("UTF-16")));
        // In another code page that is a small u with two dots.
        assert!(read(b"f\x81r").is_err_and(|why| why.contains("save it as CSV in UTF-8")));
    }
}
