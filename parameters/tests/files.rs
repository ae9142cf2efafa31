//! Parameter files and arguments.

use linewright_parameters::{
    Argument, Override, OverrideError, ParameterFile, ParameterSet, ParameterType, ParameterValue, apply,
    argument_value,
};
use proptest::prelude::*;

use crate::sets::set;

const NODE: &str = "/hall/drill";

fn read(text: &str) -> ParameterFile {
    ParameterFile::read("p.yaml", text).unwrap_or_else(|problems| panic!("{problems:#}"))
}

/// The parameters of the node with a file.
fn with(text: &str) -> Result<ParameterSet, OverrideError> {
    let mut set = set();
    apply(&mut set, &[read(text).into()], NODE, &["elsewhere"]).map(|_| set)
}

#[test]
fn sections_of_each_form_are_for_the_nodes_they_name() {
    for (text, count) in [
        ("/**:\n  ros__parameters:\n    rate:\n      count: 3\n", 3),
        ("/**:\n  ros__parameters:\n    rate.count: 3\n", 3),
        ("/hall/drill:\n  ros__parameters: {rate: {count: 3}}\n", 3),
        ("/hall:\n  drill:\n    ros__parameters: {rate.count: 3}\n", 3),
        ("hall:\n  /drill:\n    ros__parameters: {rate.count: 3}\n", 3),
        ("/**:\n  drill:\n    ros__parameters: {rate.count: 3}\n", 3),
        ("/*/drill:\n  ros__parameters: {rate.count: 3}\n", 3),
        ("/*:\n  ros__parameters: {rate.count: 3}\n", 1),
        ("/hall/mill:\n  ros__parameters: {rate.count: 3}\n", 1),
        ("drill:\n  ros__parameters: {rate.count: 3}\n", 1),
        ("/**:\n  ros__parameters: {rate.count: 3}\n/hall/drill:\n  ros__parameters: {rate.count: 4}\n", 4),
        ("/hall/drill:\n  ros__parameters: {rate.count: 4}\n/**:\n  ros__parameters: {rate.count: 3}\n", 3),
        ("---\n/**:\n  ros__parameters: {rate.count: 3}\n", 3),
        ("/**:\n  ros__parameters:\n", 1),
        ("", 1),
        ("# nothing\n", 1),
    ] {
        let set = with(text).unwrap_or_else(|error| panic!("{text}{error}"));
        assert_eq!(set.get("rate.count"), Some(&ParameterValue::Integer(count)), "{text}");
    }
}

#[test]
fn a_name_without_its_namespace_is_warned_of() {
    let file = read("drill:\n  ros__parameters: {rate.count: 3}\n");
    let warnings = apply(&mut set(), &[file.into()], NODE, &[]).expect("no error");
    let expected =
        "p.yaml: 'drill' without a namespace is the node /drill, and not this one: write /hall/drill, or /**/drill";
    assert_eq!(warnings, [expected]);
}

#[test]
fn what_a_file_has_wrong_is_shown_where_it_is() {
    for (text, expected) in [
        ("ros__parameters: {a: 1}\n", "p.yaml:1:1: ros__parameters stands below no node"),
        ("- a\n", "p.yaml:1:1: a parameter file is a map of nodes' names"),
        ("/a:\n  b: 1\n", "p.yaml:2:3: node '/a/b' has no ros__parameters"),
        ("/a_*:\n  ros__parameters: {}\n", "p.yaml:2:3: node '/a_*': 'a_*': a wildcard stands for whole parts"),
        ("/a:\n  ros__parameters: 3\n", "p.yaml:2:3: ros__parameters is no map of parameters' names"),
        ("/a:\n  ros__parameters: {x: 1, x: 2}\n", "p.yaml:2:27: x is set twice for the same nodes"),
        ("/a:\n  ros__parameters: {x.y: 1, x: {y: 2}}\n", "p.yaml:2:33: x.y is set twice for the same nodes"),
        (
            "/a:\n  ros__parameters: {x: &b 1, y: *b}\n",
            "p.yaml:2:33: an alias, which parameter files of ROS 2 have not",
        ),
        ("/a:\n  ros__parameters: {x: !odd 1}\n", "p.yaml:2:24: the tag !odd is not read; only !!str is"),
        ("/a: {}\n---\n/b: {}\n", "p.yaml:3:1: a second document in one file"),
        ("/a:\n  b:\n c: [\n", "this is no YAML"),
        ("ä: {ö: 1}\n", "p.yaml:1:5: node 'ä/ö' has no ros__parameters"),
    ] {
        let problems = ParameterFile::read("p.yaml", text).expect_err(text);
        let shown = format!("{problems:#}");
        assert!(shown.contains(expected), "{text}{shown}");
    }
    let deep = format!("/a:\n  ros__parameters: {}1{}\n", "[".repeat(100), "]".repeat(100));
    assert!(format!("{:#}", ParameterFile::read("p.yaml", &deep).expect_err("too deep")).contains("levels of nesting"));
    let many: String = (0..6000).map(|n| format!("    a{n}: 1\n")).collect();
    let many = ParameterFile::read("p.yaml", &format!("/a:\n  ros__parameters:\n{many}")).expect_err("too many");
    assert!(format!("{many:#}").contains("p.yaml:5003:5: more than 5000 values"), "{many:#}");
}

#[test]
fn values_that_a_node_does_not_take_are_shown_where_they_are() {
    let text = "/**:\n  ros__parameters:\n    rate: {count: 99, period_s: 2}\n    timing.lease_ms: 400\n    levl: low\n    elsewhere: 3\n";
    let error = with(text).expect_err("four of them").to_string();
    let expected = "p.yaml: 4 errors\n\
                    p.yaml:3:19: rate.count is from -3 to 7, and not 99\n\
                    p.yaml:3:33: rate.period_s is a double, and not an integer; write 2.0\n\
                    p.yaml:4:22: timing.lease_ms is read-only, and is 500; it is set by lease_ms in [timing] of line.toml\n\
                    p.yaml:5:5: levl is no parameter of this node; did you mean level?";
    assert_eq!(error, expected);
    let exact =
        with("/hall/drill:\n  ros__parameters: {elsewhere: 3}\n").expect_err("it is another node's").to_string();
    assert!(exact.contains("p.yaml:2:21: elsewhere is no parameter of this node"), "{exact}");
}

#[test]
fn arguments_and_files_count_in_the_order_given() {
    let argument = |node: Option<&str>, name: &str, value: i64| {
        let (node, name) = (node.map(str::to_owned), name.to_owned());
        Override::from(Argument { node, name, value: ParameterValue::Integer(value) })
    };
    let file = Override::from(read("/**:\n  ros__parameters: {rate.count: 3}\n"));
    let count = |overrides: &[Override]| {
        let mut set = set();
        apply(&mut set, overrides, NODE, &["elsewhere"]).map(|_| set.get("rate.count").cloned())
    };
    let is = |value| Ok(Some(ParameterValue::Integer(value)));
    assert_eq!(count(&[argument(None, "rate.count", 5), file.clone()]), is(3));
    assert_eq!(count(&[file.clone(), argument(None, "rate.count", 5)]), is(5));
    assert_eq!(count(&[argument(Some("drill"), "rate.count", 6), argument(Some("mill"), "rate.count", 7)]), is(6));
    assert_eq!(count(&[argument(None, "elsewhere", 5)]), is(1));
    let refused = count(&[argument(Some("drill"), "elsewhere", 5)]).expect_err("not this node's").to_string();
    assert_eq!(refused, "'-p drill:elsewhere:=5': elsewhere is no parameter of this node");
    let refused = count(&[argument(None, "rate.count", 50)]).expect_err("out of bounds").to_string();
    assert_eq!(refused, "'-p rate.count:=50': rate.count is from -3 to 7, and not 50");
}

#[test]
fn scalars_have_the_types_that_ros_gives_them() {
    use ParameterValue::{Bool, Double, Integer, Other, Text};
    let text = |text: &str| Text(text.to_owned());
    for (written, expected) in [
        ("true", Bool(true)),
        ("off", Bool(false)),
        ("Y", Bool(true)),
        ("yEs", text("yEs")),
        ("-7", Integer(-7)),
        ("+7", Integer(7)),
        ("0x1F", Integer(31)),
        ("010", Integer(8)),
        ("0", Integer(0)),
        ("08", Double(8.0)),
        ("--1", text("--1")),
        ("-9223372036854775808", Integer(i64::MIN)),
        ("9223372036854775808", Double(9_223_372_036_854_775_808.0)),
        ("1.5", Double(1.5)),
        ("1e3", Double(1000.0)),
        (".inf", Double(f64::INFINITY)),
        ("nan", text("nan")),
        ("inf", text("inf")),
        ("'1'", text("1")),
        ("!!str 1", text("1")),
        ("vcan0", text("vcan0")),
        ("/a:=b", text("/a:=b")),
        ("[1, 2]", Other(ParameterType::IntegerArray)),
        ("['a,b', \"c\"]", Other(ParameterType::TextArray)),
        ("[0.5]", Other(ParameterType::DoubleArray)),
        ("[on]", Other(ParameterType::BoolArray)),
        ("[]", Other(ParameterType::TextArray)),
        ("~", Other(ParameterType::NotSet)),
        ("", Other(ParameterType::NotSet)),
    ] {
        assert_eq!(argument_value(written), Ok(expected), "{written}");
    }
    for written in ["{a: 1}", "[1", "*a", "'a"] {
        argument_value(written).expect_err(written);
    }
}

/// As `ros2 param dump` writes it.
fn dumped(set: &ParameterSet) -> String {
    let mut text = format!("{NODE}:\n  ros__parameters:\n");
    let mut section = "";
    for (declared, value) in set.iter() {
        let (above, name) = declared.name.split_once('.').unwrap_or(("", declared.name));
        if !above.is_empty() && above != section {
            text += &format!("    {above}:\n");
        }
        section = above;
        let indent = if above.is_empty() { "    " } else { "      " };
        text += &format!("{indent}{name}: {value}\n");
    }
    text
}

proptest! {
    #[test]
    fn a_dump_is_a_parameter_file(count in -3..=7_i64, period in 0.5..10.0, is_high: bool, quiet: bool) {
        let mut expected = set();
        let level = if is_high { "high" } else { "low" };
        for (name, value) in [
            ("rate.count", ParameterValue::Integer(count)),
            ("rate.period_s", ParameterValue::Double(period)),
            ("level", ParameterValue::Text(level.to_owned())),
            ("quiet", ParameterValue::Bool(quiet)),
        ] {
            expected.set(name, &value).expect("it may be set");
        }
        prop_assert_eq!(with(&dumped(&expected)), Ok(expected));
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[/*:a-z0-9{}\\[\\],.'\"&!|>\\-# \n\täß]{0,200}") {
        if let Ok(file) = ParameterFile::read("p.yaml", &text) {
            let _ = apply(&mut set(), &[file.into()], NODE, &[]);
        }
        let _ = argument_value(&text);
    }
}
