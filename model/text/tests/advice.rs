//! Advice where a key is missing or its value is of the wrong type.

use linewright_text::{
    Fields, Keys, Located, LocatedName, Problem, Report, document, flag, integer, keys, millis, number, one_of,
    seconds, text, texts,
};

const KINDS: &[(&str, bool)] = &[("R", true), ("I", false)];

keys! {
    /// One value of each kind.
    struct OneOfEach is "one of each" {
        /// A time.
        time_s: Option<Located<std::time::Duration>> = seconds(),
        /// A period.
        period_ms: Option<Located<std::time::Duration>> = millis(),
        /// A count.
        count: Option<Located<i64>> = integer(),
        /// A length.
        length: Option<Located<f64>> = number(),
        /// A name.
        name: Option<LocatedName> = text(),
        /// A choice.
        choice: Option<Located<bool>> = flag(),
        /// Several names.
        names: Option<Located<Vec<LocatedName>>> = texts(9),
    }

    /// Keys that are missing.
    struct Needed is "this" {
        /// The duration, in seconds,
        /// up to a day. Twice as long is usual.
        limit_s: Option<Located<f64>> = number().required(),
        /// Its name.
        name: Option<LocatedName> = text().required(),
        /// Its kind
        module: Option<Located<bool>> = one_of(KINDS).required(),
    }
}

fn problems<K: Keys>(text: &str, at: std::ops::Range<usize>) -> Vec<Problem> {
    let mut report = Report::default();
    let document = document(text, &mut report).expect("it is TOML");
    let _ = K::read_all(Fields::new(document.as_table(), at, K::WHAT), &mut report);
    report.into_problems("f", text).into_vec()
}

/// The advice for a value of a key, which must be of the wrong type.
fn advice(key: &str, written: &str) -> Option<String> {
    let problems = problems::<OneOfEach>(&format!("{key} = {written}"), 0..0);
    let [problem] = &problems[..] else { panic!("{problems:?}") };
    assert!(problem.message.starts_with(&format!("`{key}` must be ")), "{problem:?}");
    problem.hint.clone()
}

#[test]
fn a_value_of_the_wrong_type_is_answered_with_the_right_one() {
    for (key, written, hint) in [
        ("time_s", "\"0.8 s\"", "`time_s = 0.8`, without quotes and unit"),
        ("time_s", "\"800ms\"", "`time_s = 0.8`, without quotes and unit"),
        ("time_s", "\"0,8\"", "`time_s = 0.8`, without quotes"),
        ("time_s", "\"2 min\"", "`time_s = 120`, without quotes and unit"),
        ("period_ms", "\"0.05 s\"", "`period_ms = 50`, without quotes and unit"),
        ("count", "3.0", "`count = 3`, without a decimal point"),
        ("count", "\"3\"", "`count = 3`, without quotes"),
        ("count", "\"0x14\"", "`count = 0x14`, without quotes"),
        ("count", "\"14h\"", "`count = 0x14`, without quotes"),
        ("count", "\"7Fh\"", "`count = 0x7F`, without quotes"),
        ("length", "\"50 mm\"", "`length = 50`, without quotes and unit"),
        ("name", "7", "`name = \"7\"`, in quotes"),
        ("name", "true", "`name = \"true\"`, in quotes"),
        ("choice", "\"yes\"", "`choice = true`, without quotes"),
        ("names", "\"a\"", "`names = [\"a\"]`, in brackets"),
    ] {
        let hint = format!("write {hint}");
        assert_eq!(advice(key, written).as_deref(), Some(&*hint), "{key} = {written}");
    }
}

#[test]
fn where_nothing_is_known_to_be_meant_there_is_no_advice() {
    for (key, written) in [
        ("time_s", "\"soon\""),
        ("time_s", "\"3 cycles\""),
        ("time_s", "true"),
        ("count", "3.5"),
        ("count", "\"3.5\""),
        ("choice", "\"maybe\""),
        ("name", "[]"),
        ("count", "\"0xmill\""),
        ("time_s", "\"0x14\""),
    ] {
        assert_eq!(advice(key, written), None, "{key} = {written}");
    }
}

#[test]
fn a_decimal_comma_is_answered_with_a_decimal_point() {
    for (line, advice) in [
        ("duration_s = 1,6", Some("`duration_s = 1.6`")),
        ("moves = { axis = \"x\", from = -0,5, to = 100 }", Some("`from = -0.5`")),
        ("list = [1,6]", None),
        ("name = \"a = 1,6\"", None),
        ("duration_s = 16", None),
        ("= ,6", None),
    ] {
        let mut report = Report::default();
        let _ = document(line, &mut report);
        let hints: Vec<String> =
            report.into_problems("f", line).into_vec().into_iter().filter_map(|problem| problem.hint).collect();
        let expected = advice.map(|advice| format!("write {advice}: a decimal point, no comma"));
        assert_eq!(hints.iter().find(|hint| hint.contains("decimal point")), expected.as_ref(), "{line}: {hints:?}");
    }
}

#[test]
fn a_missing_key_is_answered_with_its_form_and_its_first_sentence() {
    let hints = |at| problems::<Needed>("# f", at).into_iter().filter_map(|problem| problem.hint).collect::<Vec<_>>();
    let expected = [
        "write `limit_s = …`. The duration, in seconds, up to a day",
        "write `name = \"…\"`. Its name",
        "write `module = \"R\"`. Its kind",
    ];
    assert_eq!(hints(1..3), expected);
    assert_eq!(hints(0..0)[1], "write `name = \"…\"` above the first header `[…]`. Its name");
}

#[test]
fn a_hexadecimal_number_and_a_header_twice_are_answered_with_what_to_write() {
    for (text, advice) in [
        ("node = 14h", Some("write `node = 0x14`: a hexadecimal number begins with 0x")),
        ("node = 7Fh # the belt", Some("write `node = 0x7F`: a hexadecimal number begins with 0x")),
        ("node = 14x", None),
        ("node = 10x11", Some("a hexadecimal number begins with 0x, such as `node = 0x11`")),
        ("node = \"10x11", None),
        (
            "[arrow]\na = 1\n[arrow]\n",
            Some("if there are several, write each under a header `[[arrow]]`, with two brackets"),
        ),
        ("a = 1\na = 2", None),
    ] {
        let mut report = Report::default();
        assert!(document(text, &mut report).is_none(), "{text}");
        let problems = report.into_problems("f", text).into_vec();
        let [problem] = &problems[..] else { panic!("{problems:?}") };
        assert_eq!(problem.hint.as_deref(), advice, "{text}");
    }
}

#[test]
fn a_misspelled_key_and_a_value_of_the_wrong_type_are_read_as_what_is_meant() {
    let messages = |text: &str| {
        let found = problems::<Needed>(text, 0..0);
        found.into_iter().map(|problem| problem.message).collect::<Vec<_>>()
    };
    assert_eq!(messages("limits = 3\nname = \"a\"\nmodule = \"R\""), ["unknown key `limits` in this"]);
    // By its value it is something else.
    let other = messages("limits = [3]\nname = \"a\"\nmodule = \"R\"");
    assert!(other.iter().any(|message| message == "this needs `limit_s`"), "{other:?}");

    let mut report = Report::default();
    let document = document("count = \"0x14\"\ntime_s = \"800 ms\"", &mut report).expect("it is TOML");
    let read = OneOfEach::read_all(Fields::new(document.as_table(), 0..0, OneOfEach::WHAT), &mut report);
    assert_eq!(read.count.map(|count| count.value), Some(20));
    assert_eq!(read.time_s.map(|time| time.value), Some(std::time::Duration::from_millis(800)));
    assert_eq!(report.into_problems("f", "").into_vec().len(), 2);
}
