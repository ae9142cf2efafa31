//! One case for each rule: what is reported about a file, with line, column, section and key; most in `problems/eds.cases`.

use linewright_eds::{limits, read};
use miette::{GraphicalReportHandler, GraphicalTheme};

use crate::common::{HEAD, said, sound};

fn expect(said: &[String], expected: &[&str]) {
    assert_eq!(said, expected);
}

#[test]
fn rules_of_a_file() {
    let base = |name: &str| {
        let object = "[OptionalObjects]\nSupportedObjects=1\n1=0x6000\n";
        match name {
            "head" => HEAD.to_owned(),
            "object" => format!("{HEAD}{object}"),
            "variable" => format!("{HEAD}{object}[6000]\nParameterName=P\nAccessType=rw\n"),
            other => panic!("no base is called `{other}`"),
        }
    };
    let problems = |text: &str| match read("a.eds", text.as_bytes()) {
        Ok(eds) => eds.warnings().clone().into_vec(),
        Err(problems) => problems.into_vec(),
    };
    linewright_cases::check(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/problems"), "eds.cases", base, problems);
}

#[test]
fn a_sound_file_has_no_problems() {
    expect(&said(HEAD.as_bytes()), &[]);
    assert_eq!(sound(&format!("{HEAD}[DeviceComissioning]\nNodeID=0\n")).node_id(), None);
}

#[test]
fn a_key_before_the_first_section_belongs_to_nothing() {
    let said = said(format!("a=1\n{HEAD}").as_bytes());
    expect(&said, &["1:1: warning: `a=1` stands before the first section and belongs to nothing"]);
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
