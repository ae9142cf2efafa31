//! Command lines and what they mean, as tables.

use super::*;

fn parse(line: &str) -> Result<(RosArgs, Vec<String>), ArgsError> {
    RosArgs::parse(line.split_whitespace().map(str::to_owned), |_| None)
}

#[test]
fn ros_arguments_are_cut_out_and_the_rest_handed_back() {
    for (line, rest) in [
        ("run line.toml", vec!["run", "line.toml"]),
        ("run --ros-args -r a:=b", vec!["run"]),
        ("--ros-args -r a:=b -- run x", vec!["run", "x"]),
        ("a --ros-args -- b --ros-args --log-level info -- c", vec!["a", "b", "c"]),
        ("a -- b", vec!["a", "--", "b"]),
        ("a -r b:=c", vec!["a", "-r", "b:=c"]),
        ("--ros-args", vec![]),
        ("", vec![]),
    ] {
        assert_eq!(parse(line).unwrap().1, rest, "{line}");
    }
}

#[test]
fn remaps() {
    let (args, _) =
        parse("--ros-args -r __ns:=/l --remap __node:=n -r __name:=m -r s1:mode:=order -r rostopic://a:=b").unwrap();
    let rule = |node: Option<&str>, target: RemapTarget, to: &str| Remap {
        node: node.map(str::to_owned),
        target,
        to: to.to_owned(),
    };
    assert_eq!(
        args.remaps,
        [
            rule(None, RemapTarget::Namespace, "/l"),
            rule(None, RemapTarget::NodeName, "n"),
            rule(None, RemapTarget::NodeName, "m"),
            rule(Some("s1"), RemapTarget::Topic("mode".into()), "order"),
            rule(None, RemapTarget::Topic("a".into()), "b"),
        ]
    );
}

#[test]
fn parameters_the_last_one_wins() {
    let (args, _) = parse("--ros-args -p a:=1 -p a:=2 -p n:a:=3 --param b.c:=x").unwrap();
    assert_eq!(args.param("other", "a"), Some(&ParamValue::Integer(2)));
    assert_eq!(args.param("n", "a"), Some(&ParamValue::Integer(3)));
    assert_eq!(args.param("n", "b.c"), Some(&ParamValue::Text("x".into())));
    assert_eq!(args.param("n", "none"), None);
}

#[test]
fn parameter_values() {
    let list = |items: &[i64]| ParamValue::List(items.iter().map(|i| ParamValue::Integer(*i)).collect());
    for (text, value) in [
        ("true", ParamValue::Bool(true)),
        ("off", ParamValue::Bool(false)),
        ("-7", ParamValue::Integer(-7)),
        ("1.5", ParamValue::Double(1.5)),
        ("1e3", ParamValue::Double(1000.0)),
        ("'1'", ParamValue::Text("1".into())),
        ("nan", ParamValue::Text("nan".into())),
        ("vcan0", ParamValue::Text("vcan0".into())),
        ("/a:=b", ParamValue::Text("/a:=b".into())),
        ("[1,2]", list(&[1, 2])),
        ("['a,b',\"c,d\"]", ParamValue::List(vec![ParamValue::Text("a,b".into()), ParamValue::Text("c,d".into())])),
        ("[]", list(&[])),
    ] {
        let (args, _) = parse(&format!("--ros-args -p v:={text}")).unwrap();
        assert_eq!(args.param("n", "v"), Some(&value), "{text}");
    }
}

#[test]
fn log_levels() {
    for (line, level) in [
        ("--log-level info", LogLevel::Info),
        ("--log-level DEBUG", LogLevel::Debug),
        ("--log-level info --log-level fatal", LogLevel::Fatal),
        ("--log-level rcl:=warn", LogLevel::Warn),
    ] {
        assert_eq!(parse(&format!("--ros-args {line}")).unwrap().0.log_level, Some(level), "{line}");
    }
}

#[test]
fn refusals_name_the_culprit() {
    for (line, culprit) in [
        ("--ros-args run", "'run'"),
        ("--ros-args --wrong", "'--wrong'"),
        ("--ros-args -r", "'-r'"),
        ("--ros-args -r a=b", "a=b"),
        ("--ros-args -r a:=", "a:="),
        ("--ros-args -r :=b", ":=b"),
        ("--ros-args -r :a:=b", ":a:=b"),
        ("--ros-args -r __what:=b", "__what"),
        ("--ros-args -p a", "'-p a'"),
        ("--ros-args --params-file p.yaml", "p.yaml"),
        ("--ros-args --log-level loud", "loud"),
        ("--ros-args -e", "'-e'"),
    ] {
        let error = parse(line).unwrap_err().to_string();
        assert!(error.contains(culprit), "{line}: {error}");
    }
}

#[test]
fn options_without_effect_are_reported() {
    let (args, rest) = parse("--ros-args --enclave /x --disable-rosout-logs -- a").unwrap();
    assert_eq!(args.warnings.len(), 2);
    assert_eq!(rest, ["a"]);
}

#[test]
fn the_environment_is_read_with_the_arguments() {
    let var = |name: &str| (name == "ROS_DOMAIN_ID").then(|| "17".to_owned());
    let (args, _) = RosArgs::parse(Vec::new(), var).unwrap();
    assert_eq!((args.domain_id, args.range), (17, None));
    let error = RosArgs::parse(Vec::new(), |_| Some("bad".to_owned())).unwrap_err();
    assert!(error.to_string().contains("ROS_DOMAIN_ID"), "{error}");
}
