//! One case for each rule: what is said about a file, with line, column, section and key.

use linewright_eds::{limits, read};
use miette::{GraphicalReportHandler, GraphicalTheme};

use crate::common::{HEAD, said, said_of, sound};

/// A list of one optional object, which begins in line 8; the object's section begins in line 11.
fn listed(object: &str) -> Vec<String> {
    said_of(&format!("[OptionalObjects]\nSupportedObjects=1\n1=0x6000\n{object}"))
}

fn var(keys: &str) -> Vec<String> {
    listed(&format!("[6000]\nParameterName=P\nAccessType=rw\n{keys}"))
}

fn expect(said: &[String], expected: &[&str]) {
    assert_eq!(said, expected);
}

#[test]
fn a_sound_file_has_no_problems() {
    expect(&said(HEAD.as_bytes()), &[]);
    expect(&var("DataType=5\nDefaultValue=0xFF ; all\nPDOMapping=1\nLowLimit=0\nHighLimit=255\n"), &[]);
}

#[test]
fn values_out_of_the_range_of_their_type_are_errors() {
    for (data_type, value, name) in [
        (1, "2", "BOOLEAN"),
        (2, "128", "INTEGER8"),
        (2, "-129", "INTEGER8"),
        (2, "0x100", "INTEGER8"),
        (5, "256", "UNSIGNED8"),
        (5, "-1", "UNSIGNED8"),
        (5, "$NODEID+129", "UNSIGNED8"),
        (6, "0x10000", "UNSIGNED16"),
        (0x10, "0x1000000", "INTEGER24"),
        (0x16, "16777216", "UNSIGNED24"),
    ] {
        for key in ["DefaultValue", "ParameterValue"] {
            let column = key.len() + 2;
            expect(
                &var(&format!("DataType={data_type}\n{key}={value}\n")),
                &[&format!("15:{column}: [6000] {key}: `{value}` does not fit into {name}")],
            );
        }
    }
    expect(&var("DataType=5\nLowLimit=-1\n"), &["15:10: warning: [6000] LowLimit: `-1` does not fit into UNSIGNED8"]);
}

#[test]
fn what_is_no_number_is_an_error_that_says_how_to_write_it() {
    for (value, expected, hint) in [
        ("1Fh", "`1Fh` is not a number", "0x1F"),
        ("089", "`089` is not a number", "octal"),
        ("ten", "`ten` is not a number", "0x1F"),
        ("NODEID+1", "`NODEID+1` is no sum of a number and $NODEID", "$NODEID+0x180"),
        ("0x1FFFFFFFFFFFFFFFF", "`0x1FFFFFFFFFFFFFFFF` has more than 64 bits", "64 bits"),
    ] {
        let text = format!("{HEAD}[6000]\nParameterName=P\nAccessType=rw\nDataType=7\nDefaultValue={value}\n");
        let problems = read("a.eds", text.as_bytes()).unwrap_err();
        let problem = problems.iter().find(|problem| !problem.is_warning).expect("an error");
        assert_eq!(problem.message, format!("[6000] DefaultValue: {expected}"));
        assert_eq!((problem.line, problem.column), (12, 14));
        assert!(problem.hint.as_ref().is_some_and(|said| said.contains(hint)), "{problem:?}");
    }
}

#[test]
fn an_octal_number_is_pointed_out() {
    expect(
        &var("DataType=6\nDefaultValue=0100\n"),
        &["15:14: warning: [6000] DefaultValue: `0100` is octal and means 64"],
    );
}

#[test]
fn a_value_of_an_unknown_type_is_an_error_only_where_it_would_be_sent() {
    let message = "[6000] DefaultValue: a value of data type 0x0123, which is not known, means nothing";
    expect(&var("DataType=0x123\nDefaultValue=5\n"), &[&format!("15:14: warning: {message}")]);
    let message = "[6000] ParameterValue: a value of data type 0x0123, which is not known, means nothing";
    expect(&var("DataType=0x123\nParameterValue=5\n"), &[&format!("15:16: {message}")]);
    expect(&var("DataType=0x123\n"), &[]);
}

#[test]
fn a_text_has_the_characters_of_its_type() {
    let message = "VISIBLE_STRING has no character `€`";
    expect(&var("DataType=9\nDefaultValue=5 €\n"), &[&format!("15:14: warning: [6000] DefaultValue: {message}")]);
    expect(&var("DataType=9\nParameterValue=5 €\n"), &[&format!("15:16: [6000] ParameterValue: {message}")]);
    expect(&var("DataType=11\nParameterValue=5 €\n"), &[]);
    expect(
        &var("DataType=9\nParameterValue=\"a\"\n"),
        &["15:16: warning: [6000] ParameterValue: the quotation marks are part of the text"],
    );
    expect(
        &var("DataType=9\nParameterValue=a ;b\n"),
        &["15:16: warning: [6000] ParameterValue: what stands behind ` ;` is taken as a comment"],
    );
}

#[test]
fn an_entry_says_what_it_is() {
    expect(&var(""), &["11:2: [6000] has no DataType"]);
    expect(&listed("[6000]\nParameterName=P\nDataType=5\n"), &["11:2: [6000] has no AccessType"]);
    expect(&listed("[6000]\nDataType=5\nAccessType=RW\n"), &["11:2: warning: [6000] has no ParameterName"]);
    expect(
        &listed("[6000]\nParameterName=P\nDataType=5\nAccessType=wr\n"),
        &["14:12: [6000] AccessType: there is no access type `wr`"],
    );
    expect(&var("DataType=UNSIGNED8\n"), &["14:10: warning: [6000] DataType: `UNSIGNED8` is a word"]);
    expect(&var("DataType=byte\n"), &["14:10: [6000] DataType: `byte` is not a number"]);
    expect(&var("DataType=5\nObjectType=VAR\n"), &["15:12: warning: [6000] ObjectType: `VAR` is a word"]);
}

#[test]
fn limits_are_kept() {
    expect(
        &var("DataType=5\nHighLimit=10\nParameterValue=11\n"),
        &["16:16: [6000] ParameterValue: 11 (0xB) is beyond HighLimit, which is 10 (0xA)"],
    );
    expect(
        &var("DataType=2\nLowLimit=-1\nDefaultValue=-2\n"),
        &["16:14: warning: [6000] DefaultValue: -2 is beyond LowLimit, which is -1"],
    );
    expect(
        &var("DataType=8\nHighLimit=1.5\nParameterValue=nan\n"),
        &["16:16: [6000] ParameterValue: NaN is beyond HighLimit, which is 1.5"],
    );
    expect(
        &var("DataType=5\nLowLimit=9\nHighLimit=1\nParameterValue=200\n"),
        &["16:11: warning: [6000] HighLimit: 1 is less than LowLimit, which is 9; both are ignored"],
    );
}

#[test]
fn lists_are_counted_and_complete() {
    expect(
        &said_of(
            "[OptionalObjects]\nSupportedObjects=2\n1=0x6000\n[6000]\nParameterName=P\nDataType=5\nAccessType=ro\n",
        ),
        &["9:18: [OptionalObjects] SupportedObjects: it says 2, but the list has 1"],
    );
    expect(&listed(""), &["10:3: [OptionalObjects] 1: there is no section [6000]"]);
    expect(&said_of("[OptionalObjects]\n"), &["8:2: warning: [OptionalObjects] has no SupportedObjects"]);
    expect(
        &said_of("[6000]\nParameterName=P\nDataType=5\nAccessType=ro\n"),
        &["8:2: warning: [6000] stands in none of the lists of objects"],
    );
    expect(
        &said_of("[ManufacturerObjects]\nSupportedObjects=1\n1=0x1000\n"),
        &["10:3: warning: [ManufacturerObjects] 1: the object 0x1000 is listed twice, first in [MandatoryObjects]"],
    );
    expect(
        &said_of(
            "[ManufacturerObjects]\nSupportedObjects=1\n1=0x6000\n[6000]\nParameterName=P\nDataType=5\nAccessType=ro\n",
        ),
        &["10:3: warning: [ManufacturerObjects] 1: the object 0x6000 belongs into [OptionalObjects]"],
    );
    let list = |keys| said_of(&format!("[OptionalObjects]\nSupportedObjects=1\n{keys}\n"));
    expect(&list("1=1018h"), &["10:3: [OptionalObjects] 1: `1018h` is not a number"]);
    expect(&list("1="), &["10:1: [OptionalObjects] 1: there is no number"]);
}

#[test]
fn what_stands_twice_is_an_error_if_it_matters() {
    let twice = format!("{HEAD}[1000]\nParameterName=Other\nDataType=7\nAccessType=rw\n");
    let problems = read("a.eds", twice.as_bytes()).unwrap_err();
    let problem = problems.iter().next().expect("one");
    assert_eq!((problem.line, problem.message.as_str()), (8, "[1000] occurs twice"));
    assert!(problem.hint.as_ref().is_some_and(|hint| hint.contains("the first is in line 4")), "{problem:?}");
    expect(
        &said_of("[1018sub1]\nParameterName=P\nDataType=7\nAccessType=ro\n[1018SUB01]\n"),
        &["8:2: warning: [1018sub1] is an element, but there is no section [1018]", "12:2: [1018SUB01] occurs twice"],
    );
    expect(&var("DataType=5\nDefaultValue=1\ndefaultvalue=2\n"), &["16:1: [6000] defaultvalue: stands here twice"]);
    expect(
        &var("DataType=5\nDefaultValue=1\nDefaultValue=1\n"),
        &["16:1: warning: [6000] DefaultValue: stands here twice"],
    );
    expect(&said_of("[Tools]\nA=1\nA=2\n[Tools]\n"), &[]);
    let both = "[DeviceComissioning]\nNodeID=1\n[DeviceCommissioning]\nNodeID=2\n";
    expect(&said_of(both), &["10:2: [DeviceCommissioning] occurs twice"]);
}

#[test]
fn lines_that_are_nothing_are_pointed_out() {
    expect(&var("DataType=5\nDefaultValue 5\n"), &["15:1: `DefaultValue 5` has no `=`"]);
    expect(
        &var("DataType=5\nwhatever\n"),
        &["15:1: warning: `whatever` is neither a section nor a key nor a comment; it is ignored"],
    );
    expect(
        &var("DataType=5\n# no comment\n"),
        &["15:1: warning: this is taken as a comment, but other tools will not"],
    );
    expect(&said_of("[Tools\n"), &["8:1: `[Tools` has no `]`"]);
    expect(&said_of("[Tools] x=1\n"), &["8:9: warning: `x=1` behind the section's name is ignored"]);
    let said = said(format!("a=1\n{HEAD}").as_bytes());
    expect(&said, &["1:1: warning: `a=1` stands before the first section and belongs to nothing"]);
}

#[test]
fn sections_that_look_like_objects_are_never_passed_over() {
    for name in ["0x6000", "6000sub", "6000sub100", "6000subX"] {
        let message = format!("8:2: [{name}] looks like an object, but its index or subindex is not understood");
        expect(&said_of(&format!("[{name}]\nDefaultValue=1\n")), &[&message]);
    }
}

#[test]
fn compact_arrays_are_bounded_and_counted() {
    let compact = |keys| listed(&format!("[6000]\nParameterName=P\nObjectType=8\nDataType=5\nAccessType=rw\n{keys}"));
    expect(&compact("CompactSubObj=254\n"), &[]);
    expect(
        &compact("CompactSubObj=255\n"),
        &[
            "11:2: warning: [6000] is an array or record without elements",
            "16:15: [6000] CompactSubObj: `255` is not 0 to 254",
        ],
    );
    expect(&compact("CompactSubObj=4294967296\n")[1..], &["16:15: [6000] CompactSubObj: `4294967296` is not 0 to 254"]);
    expect(
        &compact("CompactSubObj=2\n[6000Value]\nNrOfEntries=1\n3=1\n"),
        &["19:3: [6000Value] 3: there is no element 3; CompactSubObj says 2"],
    );
    expect(
        &compact("CompactSubObj=2\n[6000Value]\nNrOfEntries=2\n2=1\n"),
        &["18:13: [6000Value] NrOfEntries: it says 2, but the list has 1"],
    );
    expect(
        &compact("CompactSubObj=2\n[6000Value]\nNrOfEntries=1\n2=256\n"),
        &["19:3: [6000Value] 2: `256` does not fit into UNSIGNED8"],
    );
    expect(
        &var("DataType=5\n[6000Value]\nNrOfEntries=1\n2=1\n"),
        &["15:2: [6000Value] belongs to an array with CompactSubObj, which [6000] is not"],
    );
    expect(
        &var("DataType=5\nCompactSubObj=2\n"),
        &["15:15: [6000] CompactSubObj: only an array or a record has elements"],
    );
}

#[test]
fn elements_belong_to_arrays_and_records() {
    expect(
        &listed(
            "[6000]\nParameterName=P\nObjectType=9\nSubNumber=2\n[6000sub0]\nParameterName=N\nDataType=5\nAccessType=ro\n",
        ),
        &["14:11: warning: [6000] SubNumber: it says 2, but the file describes 1"],
    );
    expect(
        &var("DataType=5\n[6000sub1]\nParameterName=N\nDataType=5\nAccessType=ro\n"),
        &["15:2: [6000sub1] is an element of [6000], which is a single value"],
    );
}

#[test]
fn a_file_that_is_none_is_said_to_be_none() {
    expect(&said(b""), &["1:1: the file describes no object"]);
    expect(&said(b"a\0b"), &["1:2: a zero byte: this is no text"]);
    expect(&said(b"\xFF\xFE[\0"), &["1:1: the file is UTF-16"]);
    expect(
        &said(b"\xEF\xBB\xBF[a]\n\xFC"),
        &["2:1: the byte 0xFC here is not UTF-8, and the file begins with the mark of UTF-8"],
    );
    let large = vec![b'\n'; limits::FILE_BYTES_MAX + 1];
    expect(&said(&large), &[&format!("1:1: the file has {} bytes", large.len())]);
}

#[test]
fn node_ids_are_1_to_127() {
    let node = |id| said_of(&format!("[DeviceComissioning]\nNodeID={id}\n"));
    expect(&node("127"), &[]);
    expect(&node("128"), &["9:8: [DeviceComissioning] NodeID: there is no node id 128"]);
    expect(&node("x"), &["9:8: [DeviceComissioning] NodeID: `x` is not a number"]);
    assert_eq!(sound(&format!("{HEAD}[DeviceComissioning]\nNodeID=0\n")).node_id(), None);
}

#[test]
fn identity_that_contradicts_itself_is_pointed_out() {
    let text = "[DeviceInfo]\nVendorNumber=5\nProductNumber=next year\n[1018]\nParameterName=I\nObjectType=9\nSubNumber=1\n\
        [1018sub1]\nParameterName=V\nDataType=7\nAccessType=ro\nDefaultValue=6\n[OptionalObjects]\nSupportedObjects=1\n1=0x1018\n";
    expect(
        &said_of(text),
        &[
            "9:14: warning: [DeviceInfo] VendorNumber: 0x5 here, 0x6 in object 1018h sub 1, which counts",
            "10:15: warning: [DeviceInfo] ProductNumber: `next year` is not a number",
        ],
    );
}

#[test]
fn all_at_once_and_drawn_in_place() {
    let text = "[DeviceInfo]\r\nVendorName=Prüfstand\r\n[MandatoryObjects]\r\nSupportedObjects=2\r\n1=0x1000\r\n2=0x1001\r\n\
        [1000]\r\nParameterName=Device type\r\nDataType=7\r\nAccessType=ro\r\nDefaultValue = 0x1FFFFFFFF ; too long\r\n";
    let problems = read("node4.eds", text.as_bytes()).unwrap_err();
    let mut drawn = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .render_report(&mut drawn, &problems)
        .expect("it can be drawn");
    insta::assert_snapshot!(drawn);
}

#[test]
fn more_problems_than_anybody_reads_are_cut() {
    let many: String = (0..200).map(|n| format!("[{:04X}]\nDataType=x\n", 0x2000 + n)).collect();
    let problems = read("a.eds", many.as_bytes()).unwrap_err();
    assert_eq!((problems.errors(), problems.warnings()), (limits::PROBLEMS_MAX, limits::PROBLEMS_MAX));
    assert!(problems.to_string().ends_with("errors and 50 warnings of more"), "{problems}");
}
