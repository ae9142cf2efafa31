//! I/O lists: changes of a description by a list, and what stays.

use linewright_line::{
    BitAddress, DeviceBegin, IoDirection, IoListError, IoRow, TransferLine, io_list, parse, unknown_devices,
    with_io_list, within_devices,
};
use proptest::prelude::*;

use crate::types::TYPES;

fn list(text: &str) -> Vec<IoRow> {
    io_list("line.toml", text).expect("it is read")
}

fn row(name: &str, address: &str, device: &str) -> IoRow {
    let (name, address, device) = (name.to_owned(), address.to_owned(), device.to_owned());
    IoRow { line: 2, name, address, device, station: None, comment: None }
}

#[track_caller]
fn taken(text: &str, rows: &[IoRow]) -> (String, Vec<String>) {
    match with_io_list("line.toml", text, rows) {
        Ok(change) => (change.text, change.changes),
        Err(IoListError::Description(problems) | IoListError::Result(problems)) => panic!("{problems:#}"),
        Err(IoListError::Rows(problems)) => panic!("{problems:?}"),
    }
}

#[track_caller]
fn refused(text: &str, rows: &[IoRow]) -> Vec<(u64, &'static str, String)> {
    match with_io_list("line.toml", text, rows) {
        Err(IoListError::Rows(problems)) => problems.into_iter().map(|p| (p.line, p.column, p.message)).collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_list_has_every_bit_with_its_place() {
    let rows = list(&TransferLine::default().text());
    let found: Vec<_> = rows.iter().filter(|row| row.device == "clamp 1 io").collect();
    let names: Vec<&str> = found.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names[..3], ["LS_open", "LS_closed", "low_pressure"]);
    assert_eq!((found[1].address.as_str(), found[1].station.as_deref()), ("%IX0.1", Some("clamp_1")));
    assert_eq!((found[3].address.as_str(), found[3].name.as_str()), ("%IX0.3", ""));
    assert_eq!((found[8].address.as_str(), found[8].name.as_str()), ("%QX0.0", "open"));
    assert!(rows.iter().any(|row| row.station.as_deref() == Some("console") && row.name == "PB_1"));
    assert!(rows.iter().all(|row| !row.device.contains("drive")), "drives have no bits");
    assert!(list(TYPES).iter().any(|row| row.device == "clamp 1 io" && row.name == "LS_closed"), "of a type");
}

#[test]
fn its_own_list_changes_nothing() {
    for text in [TransferLine { machines: 3, time_scale: 1.0 }.text(), TYPES.to_owned()] {
        assert_eq!(taken(&text, &list(&text)), (text, vec![]));
    }
}

#[test]
fn signals_change_places_and_the_text_around_them_stays() {
    let text = TransferLine::default().text();
    let rows = [
        row("LS_closed", "%IX0.0", "clamp 1 io"),
        row("LS_open", "%IX0.1", "clamp 1 io"),
        row("lamp_clamp", "%QX1.1", "clamp 1 io"),
        IoRow { comment: Some("at the \"top\"".to_owned()), ..row("low_pressure", "%I0.3", "clamp 1 io") },
    ];
    let (after, changes) = taken(&text, &rows);
    assert_eq!(
        changes,
        [
            "clamp_1: LS_closed: clamp 1 io %IX0.1 → clamp 1 io %IX0.0",
            "clamp_1: LS_open: clamp 1 io %IX0.0 → clamp 1 io %IX0.1",
            "clamp_1: lamp_clamp: clamp 1 io %QX0.2 → clamp 1 io %QX1.1",
            "clamp_1: low_pressure: clamp 1 io %IX0.2 → clamp 1 io %IX0.3",
            "clamp_1: low_pressure: comment none → \"at the \"top\"\"",
        ]
    );
    let old = "inputs = [\"LS_open\", \"LS_closed\", \"low_pressure\", \"\", \"\", \"SS_manual\", \"PB_advance\", \"PB_return\"]\noutputs = [\"open\", \"close\", \"lamp_clamp\"]\n";
    let new = "inputs = [\"LS_closed\", \"LS_open\", \"\", \"low_pressure\", \"\", \"SS_manual\", \"PB_advance\", \"PB_return\"]\noutputs = [\"open\", \"close\", \"\", \"\", \"\", \"\", \"\", \"\", \"\", \"lamp_clamp\"]\n\n[device.comments]\nlow_pressure = 'at the \"top\"'\n";
    assert_eq!(after, text.replace(old, new));
    // The comment is in the next list, and goes with its signal.
    let listed = list(&after);
    let comment =
        |rows: &[IoRow]| rows.iter().find(|row| row.name == "low_pressure").and_then(|row| row.comment.clone());
    assert_eq!(comment(&listed).as_deref(), Some("at the \"top\""));
    let (moved, _) = taken(&after, &[row("low_pressure", "%IX0.4", "clamp 1 io")]);
    assert_eq!(comment(&list(&moved)).as_deref(), Some("at the \"top\""));
    // An empty comment takes it away, and the table with it.
    let without = IoRow { comment: Some(String::new()), ..row("low_pressure", "%IX0.4", "clamp 1 io") };
    let (without, _) = taken(&moved, &[without]);
    assert!(!without.contains("comments"), "{without}");
}

#[test]
fn a_device_within_braces_keeps_its_comments_within_braces() {
    let mut document: toml_edit::DocumentMut = TransferLine::default().text().parse().expect("TOML");
    document["device"].make_value();
    let commented = IoRow { comment: Some("x".to_owned()), ..row("LS_open", "%IX0.0", "clamp 1 io") };
    let (after, _) = taken(&document.to_string(), &[commented]);
    assert!(after.contains(", comments = { LS_open = \"x\" } }"), "{after}");
}

#[test]
fn a_list_binds_what_no_device_carries_yet() {
    let text = TransferLine::default().text();
    let bare = text.replace("outputs = [\"open\", \"close\", \"lamp_clamp\"]\n", "");
    assert!(parse("line.toml", &bare).is_err());
    let outputs = [("open", "%QX0.0"), ("close", "%QX0.1"), ("lamp_clamp", "%QX0.2")];
    let rows: Vec<IoRow> = outputs.iter().map(|(name, address)| row(name, address, "clamp 1 io")).collect();
    let (after, changes) = taken(&bare, &rows);
    assert_eq!(changes.len(), 3);
    assert_eq!(parse("line.toml", &after).map(|p| p.line), parse("line.toml", &text).map(|p| p.line));
}

#[test]
fn rows_that_are_wrong_are_named_with_their_column_and_nothing_is_taken() {
    let text = TransferLine::default().text();
    let at = |line, row: IoRow| IoRow { line, ..row };
    let found = refused(
        &text,
        &[
            at(2, row("LS_open", "%IX0.0", "clamp 1 oi")),
            at(3, row("LS_open", "%IX9.0", "clamp 1 io")),
            at(4, row("LS open", "%IX0.0", "clamp 1 io")),
            at(5, IoRow { station: Some("mill_1".to_owned()), ..row("LS_open", "%IX0.0", "clamp 1 io") }),
            at(6, row("x", "%IX0.0", "")),
            at(7, row("LS_open", "%IX0.4", "clamp 1 io")),
            at(8, row("LS_open", "%IX0.3", "clamp 1 io")),
            at(9, row("LS_main_0", "%IX0.3", "mill 1 main drive")),
            at(10, row("y", "%IX0.4", "clamp 1 io")),
        ],
    );
    let expected = [
        (2, "device", "no device with inputs and outputs is called `clamp 1 oi`: did you mean `clamp 1 io`?"),
        (
            3,
            "address",
            "`%IX9.0` is in byte 9, and a device has bytes 0 to 7, counted in each: of a list that is counted through a \
             whole controller say where each device begins, as in --begin 'clamp 1 io=9'",
        ),
        (4, "name", "`LS open` cannot name a signal: one word of letters, digits and signs"),
        (5, "station", "`clamp 1 io` is a device of `clamp_1`, not of `mill_1`"),
        (6, "device", "no device"),
        (8, "name", "`LS_open` of `clamp_1` has a row already, line 7"),
        (9, "device", "no device with inputs and outputs is called `mill 1 main drive`"),
        (10, "address", "%IX0.4 of clamp 1 io has a row already, line 7"),
    ];
    let found: Vec<_> = found.iter().map(|(line, column, message)| (*line, *column, message.as_str())).collect();
    let begins = |at: usize| {
        found.get(at).is_some_and(|f| f.0 == expected[at].0 && f.1 == expected[at].1 && f.2.starts_with(expected[at].2))
    };
    assert!((0..expected.len()).all(begins) && found.len() == expected.len(), "{found:#?}");

    let there = refused(&text, &[row("LS_open", "%IX0.1", "clamp 1 io")]);
    assert_eq!(
        there,
        [(2, "address", "%IX0.1 of clamp 1 io carries `LS_closed`, which has no row: give it one".to_owned())]
    );
    let same = at(2, row("open", "%QX0.0", "clamp 1 io"));
    let typed = refused(TYPES, &[same, at(3, row("LS_open", "%IX0.4", "clamp 1 io"))]);
    assert_eq!(typed[0].0, 3);
    assert_eq!(typed[0].1, "device");
    assert!(typed[0].2.contains("(LS_open: clamp 1 io %IX0.0 → clamp 1 io %IX0.4): change the type"), "{typed:?}");
    let comment = IoRow { comment: Some("far".to_owned()), ..at(4, row("LS_open", "%IX0.0", "clamp 1 io")) };
    let typed = refused(TYPES, &[comment]);
    assert!(typed[0].2.contains("(LS_open: comment none → \"far\")"), "{typed:?}");
    let output = with_io_list("line.toml", &text, &[row("LS_open", "%QX0.7", "clamp 1 io")]);
    assert!(matches!(output, Err(IoListError::Result(_))), "an input as an output: {output:?}");
    let gone = with_io_list("line.toml", &text, &[row("", "%IX0.0", "clamp 1 io")]);
    assert!(matches!(gone, Err(IoListError::Result(_))), "a signal that is needed: {gone:?}");
}

#[test]
fn devices_of_begins_are_looked_for_by_name() {
    let begins = ["clamp 1 oi=4", "transfer io=0"].map(|text| DeviceBegin::read(text).expect("as it has to be"));
    let unknown = unknown_devices("line.toml", &TransferLine::default().text(), &begins).expect("a description");
    assert_eq!(
        unknown,
        ["no device with inputs and outputs is called `clamp 1 oi`: did you mean `clamp 1 io`?".to_owned()]
    );
}

fn begins(texts: &[&str]) -> Vec<DeviceBegin> {
    texts.iter().map(|text| DeviceBegin::read(text).expect("it is as it has to be")).collect()
}

#[test]
fn rows_find_their_devices_by_where_these_begin() {
    let begins = begins(&["load io=0", "drill io=%I4,%Q2"]);
    let rows = vec![
        row("a", "%I3.7", ""),
        row("b", "E 4.0", ""),
        row("c", "%Q2.1", ""),
        row("d", "A 1.1", "load io"),
        row("m", "%M4.0", ""),
        row("w", "%IW64", ""),
        row("t", "T 5", ""),
        row("n", "", ""),
    ];
    let found = within_devices(rows, &begins).expect("all are certain");
    let found: Vec<_> =
        found.iter().map(|row| (row.name.as_str(), row.device.as_str(), row.address.as_str())).collect();
    let places = [
        ("a", "load io", "%IX3.7"),
        ("b", "drill io", "%IX0.0"),
        ("c", "drill io", "%QX0.1"),
        ("d", "load io", "%QX1.1"),
    ];
    assert_eq!(found, places);
}

#[test]
fn a_row_of_which_the_device_is_not_certain_is_refused() {
    let problem =
        |row: IoRow, given: &[&str]| within_devices(vec![row], &begins(given)).expect_err("refused")[0].clone();
    let before = problem(row("a", "%I3.0", ""), &["load io=4"]);
    assert_eq!(before.message, "no --begin says that a device begins at `%I3.0` or before it");
    let behind = problem(row("a", "%I12.0", ""), &["load io=4"]);
    assert!(behind.message.contains("8 bytes behind the beginning of `load io`"), "{}", behind.message);
    let unnamed = problem(row("a", "%I4.0", "drill io"), &["load io=4"]);
    assert!(unnamed.message.contains("`drill io`"), "{}", unnamed.message);
    let outputs = problem(row("a", "%Q4.0", ""), &["load io=%I4"]);
    assert!(outputs.message.starts_with("no --begin"), "{}", outputs.message);
    let same = problem(row("a", "%I4.0", ""), &["load io=4", "drill io=4"]);
    assert!(same.message.contains("begin at the same byte"), "{}", same.message);
    assert!(problem(row("a", "%I4.9", ""), &["load io=4"]).message.contains("no address of a bit"));
    for wrong in ["load io", "load io=", "load io=%M4", "load io=%I4,%I5", "load io=-1", "load io=%I4.0"] {
        assert!(DeviceBegin::read(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn addresses_are_read_as_they_are_written() {
    for direction in [IoDirection::Input, IoDirection::Output] {
        for bit in 0..64 {
            let address = BitAddress { direction, bit };
            assert_eq!(BitAddress::read(&address.to_string()), Some(address));
            let german = address.to_string().replace("%IX", "E ").replace("%QX", "A ");
            assert_eq!(BitAddress::read(&german), Some(address));
        }
    }
    assert_eq!(BitAddress { direction: IoDirection::Output, bit: 11 }.to_string(), "%QX1.3");
    for same in ["%IX1.3", "%I1.3", " %ix1.3 ", "6000h:02 bit 3", "%IX01.3", "I1.3", "E    1.3", "%E1.3", "i 1.3"] {
        let address = Some(BitAddress { direction: IoDirection::Input, bit: 11 });
        assert_eq!(BitAddress::read(same), address, "{same}");
    }
    for wrong in [
        "",
        "%",
        "%IX",
        "%IX1",
        "%IX1.8",
        "%IX8.0",
        "%MX0.0",
        "%IW0",
        "%IX-1.0",
        "%IX1.3.4",
        "6000h:00 bit 0",
        "é",
        "E",
    ] {
        assert_eq!(BitAddress::read(wrong), None, "{wrong}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever bits signals move to, the next list has them, the rest of the description stays, and the way back is
    /// there.
    #[test]
    fn a_shuffled_list_is_taken_and_the_way_back_leads_home(seed in proptest::collection::vec(0_usize..1000, 64)) {
        let text = TransferLine::default().text();
        let before = list(&text);
        let mut rows: Vec<IoRow> = before.clone();
        let (device, letter) = ("transfer io", "%I");
        let at: Vec<usize> =
            (0..rows.len()).filter(|&nth| rows[nth].device == device && rows[nth].address.starts_with(letter)).collect();
        for (nth, pick) in seed.iter().enumerate() {
            let (a, b) = (at[nth % at.len()], at[pick % at.len()]);
            let name = rows[a].name.clone();
            rows[a].name = std::mem::replace(&mut rows[b].name, name);
        }
        let (after, changes) = taken(&text, &rows);
        let bits = |rows: &[IoRow]| {
            let named = rows.iter().filter(|row| !row.name.is_empty());
            let mut bits: Vec<_> = named.map(|row| (row.device.clone(), row.address.clone(), row.name.clone())).collect();
            bits.sort();
            bits
        };
        prop_assert_eq!(bits(&list(&after)), bits(&rows));
        prop_assert_eq!(changes.is_empty(), bits(&rows) == bits(&before));
        prop_assert_eq!(after.matches('#').count(), text.matches('#').count());
        let (back, _) = taken(&after, &before);
        prop_assert_eq!(bits(&list(&back)), bits(&before));
        prop_assert_eq!(parse("l", &back).map(|parsed| parsed.line), parse("l", &text).map(|parsed| parsed.line));
    }
}
