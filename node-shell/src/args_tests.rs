//! Command lines and what they mean, as tables.

use super::*;
use linewright_parameters::ParameterValue;

fn parse(line: &str) -> Result<(RosArgs, Vec<String>), ArgsError> {
    let read = |path: &str| match path {
        "good.yaml" => Ok("/**:\n  ros__parameters: {a: 3}\n".to_owned()),
        "bad.yaml" => Ok("/**:\n  ros__parameters: [\n".to_owned()),
        _ => Err("there is no such file".to_owned()),
    };
    RosArgs::parse(line.split_whitespace().map(str::to_owned), |_| None, read)
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
fn parameters_of_files_and_arguments_keep_their_order() {
    let (args, _) = parse("--ros-args -p a:=1 --params-file good.yaml -p n:a:=yes --param b.c:='/a:=b'").unwrap();
    let argument = |node: Option<&str>, name: &str, value| {
        Override::Argument(Argument { node: node.map(str::to_owned), name: name.to_owned(), value })
    };
    let file = ParameterFile::read("good.yaml", "/**:\n  ros__parameters: {a: 3}\n").expect("it is read");
    let expected = [
        argument(None, "a", ParameterValue::Integer(1)),
        Override::File(file),
        argument(Some("n"), "a", ParameterValue::Bool(true)),
        argument(None, "b.c", ParameterValue::Text("/a:=b".into())),
    ];
    assert_eq!(args.params, expected);
}

#[test]
fn a_node_has_the_name_that_it_is_given() {
    let (args, _) = parse("--ros-args -r __ns:=/hall -r s1:__node:=s2").unwrap();
    assert_eq!(args.node_name("/line", "s1").as_deref(), Ok("/hall/s2"));
    assert_eq!(parse("").unwrap().0.node_name("/line", "s1").as_deref(), Ok("/line/s1"));
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
        ("--ros-args -p a:=[1", "'-p a:=[1'"),
        ("--ros-args --params-file p.yaml", "'--params-file p.yaml': there is no such file"),
        ("--ros-args --params-file bad.yaml", "bad.yaml:3:1: this is no YAML"),
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
    let (args, _) = RosArgs::parse(Vec::new(), var, |_| Ok(String::new())).unwrap();
    assert_eq!((args.domain_id, args.range), (17, None));
    let error = RosArgs::parse(Vec::new(), |_| Some("bad".to_owned()), |_| Ok(String::new())).unwrap_err();
    assert!(error.to_string().contains("ROS_DOMAIN_ID"), "{error}");
}
