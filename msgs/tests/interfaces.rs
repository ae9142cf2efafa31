//! Output of the build script for an interface, its refusals, and the build of the same files in a ROS 2 workspace.

use linewright_msgs::{CORead, DiagnosticStatus, Flag, PACKAGE, RosAction, RosMessage, RosService, RunTask, Text};

#[path = "../build/generate/mod.rs"]
mod generate;

#[test]
fn a_comment_stands_above_what_it_is_about() {
    let text = "# A drill.\n\n# A remark.\n\n# At rest.\nbyte REST=0\n\n# How\n# deep.\nint32[<=4] depths\n# Name.\nstd_msgs/String name\n";
    let rust = generate::rust("tools", "Drill.msg", text, &mut Default::default()).expect("an interface");
    let expected = [
        "/// A drill.\n///\n/// `tools/Drill` in ROS 2.\n#[derive(",
        "pub struct Drill {\n    /// How\n    /// deep.\n    pub depths: crate::Bounded<i32, 4>,\n    /// Name.\n    pub name: Text,\n}\n",
        "impl Drill {\n    /// At rest.\n    pub const REST: crate::Byte = crate::Byte(0);\n}\n",
        "crate::RosField::check_bounds(&self.name, &format!(\"{path}.name\"))?;",
        "const PACKAGE: &'static str = \"tools\";\n    const NAME: &'static str = \"Drill\";",
    ];
    for part in expected {
        assert!(rust.contains(part), "{part}\nis not in\n{rust}");
    }
    assert!(!rust.contains("remark"), "{rust}");
}

#[test]
fn what_no_interface_needs_is_refused_with_its_line() {
    let cases = [
        ("A.msg", "uint8 a", "line 1: `uint8 a` has no comment above it"),
        ("A.msg", "# One.\nuint8 a\nuint8 b", "line 3: `uint8 b` has no comment above it"),
        ("A.msg", "# One.\n\nuint8 a", "line 3: `uint8 a` has no comment above it"),
        ("A.msg", "# One.\nuint8", "line 2: `uint8` has no name"),
        ("A.msg", "# One.\nuint8 a # of them", "line 2: `a # of them` is no name of a field or a constant"),
        ("A.msg", "# One.\nuint8 a 3", "line 2: `a 3` is no name of a field or a constant"),
        ("A.msg", "# One.\nuint8 ONE", "line 2: `ONE` is no name of a field or a constant"),
        ("A.msg", "# One.\nuint8 one=1", "line 2: `one` is no name of a field or a constant"),
        ("A.msg", "# One.\nuint8 ONE=one", "line 2: `one` is no decimal number"),
        ("A.msg", "# One.\nstring ONE=1", "line 2: the constant ONE is no whole number"),
        ("A.msg", "# One.\nfloat64 ONE=1", "line 2: the constant ONE is no whole number"),
        ("A.msg", "# One.\nfloat32 a", "line 2: a type `float32` is not supported"),
        ("A.msg", "# One.\nuint8[3] a", "line 2: a type `uint8[3]` is not supported"),
        ("A.msg", "# One.\nuint8[<=x] a", "line 2: a type `uint8[<=x]` is not supported"),
        ("A.msg", "# One.\nuint8[][] a", "line 2: a type `uint8[][]` is not supported"),
        ("A.msg", "# One.\nstring<=3 a", "line 2: a type `string<=3` is not supported"),
        ("A.msg", "---", "2 sections between lines of `---` do not make a `.msg` file"),
        ("A.srv", "---\n---", "3 sections between lines of `---` do not make a `.srv` file"),
        ("A.action", "---", "2 sections between lines of `---` do not make a `.action` file"),
        ("A.idl", "", "1 sections between lines of `---` do not make a `.idl` file"),
    ];
    for (file, text, expected) in cases {
        assert_eq!(
            generate::rust("tools", file, text, &mut Default::default()),
            Err(expected.to_owned()),
            "{file}: {text}"
        );
    }
}

#[test]
fn a_message_without_fields_has_the_byte_that_ros_gives_it() {
    let rust = generate::rust("tools", "Go.srv", "---\n# It went.\nbool gone\n", &mut Default::default())
        .expect("an interface");
    assert!(rust.contains("pub struct GoRequest {\n    /// A message without fields is sent as one byte.\n"), "{rust}");
    assert!(rust.contains("pub structure_needs_at_least_one_member: u8,\n}"), "{rust}");
}

/// Names on the wire are those of ROS 2, also where Rust has others.
#[test]
fn names_are_as_published() {
    assert_eq!((Text::PACKAGE, Text::NAME), ("std_msgs", "String"));
    assert_eq!((Flag::PACKAGE, Flag::NAME), ("std_msgs", "Bool"));
    assert_eq!((DiagnosticStatus::PACKAGE, DiagnosticStatus::NAME), ("diagnostic_msgs", "DiagnosticStatus"));
    assert_eq!((CORead::PACKAGE, CORead::NAME), ("canopen_interfaces", "CORead"));
    assert_eq!(<CORead as RosService>::Request::NAME, "CORead_Request");
    assert_eq!(<CORead as RosService>::Response::NAME, "CORead_Response");
    assert_eq!((RunTask::PACKAGE, RunTask::NAME), (PACKAGE, "RunTask"));
    assert_eq!(<RunTask as RosAction>::Goal::NAME, "RunTask_Goal");
    assert_eq!(<RunTask as RosAction>::Feedback::PACKAGE, PACKAGE);
}

#[test]
fn a_ros_workspace_builds_every_file() {
    let cmake = include_str!("../CMakeLists.txt");
    let listed = |line: &&str| line.trim().starts_with('"');
    let mut listed: Vec<String> =
        cmake.lines().filter(listed).map(|line| line.trim().trim_matches('"').into()).collect();
    let mut there = Vec::new();
    for kind in ["msg", "srv", "action"] {
        let dir = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(kind);
        for entry in std::fs::read_dir(dir).expect("a directory") {
            there.push(format!("{kind}/{}", entry.expect("an entry").file_name().to_string_lossy()));
        }
    }
    there.sort();
    listed.sort();
    assert_eq!(listed, there);
}

/// What a type has inside is part of its hash, so it has to be known.
#[test]
fn a_hash_needs_every_type_inside() {
    let mut types = generate::TypeDescriptions::default();
    generate::rust("tools", "Drill.msg", "# Which.\nBit bit\n", &mut types).expect("an interface");
    let missing = "tools/msg/Drill: no description of the type tools/msg/Bit";
    assert_eq!(types.hash("tools/msg/Drill"), Err(missing.to_owned()));
    let hash_with = |types: &mut generate::TypeDescriptions, bit: &str| {
        generate::rust("tools", "Bit.msg", bit, types).expect("an interface");
        types.hash("tools/msg/Drill").expect("all is known")
    };
    let number = hash_with(&mut types, "# In mm.\nint32 length\n");
    assert_ne!(hash_with(&mut types, "# In mm.\nfloat64 length\n"), number);
    assert_eq!(hash_with(&mut types, "# Another comment.\nint32 length\n"), number);
}
