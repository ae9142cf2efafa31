//! Holds the Rust structs to the `.msg` files: same fields, same order, same types, same constants.
//!
//! The Rust side is what the `message!` macro recorded; the other side is parsed here from the files
//! that a ROS 2 workspace builds. The standard messages' files belong to ROS 2, so their text, as
//! published, stands at the end.

use linewright_msgs::{
    ActivityState, AlarmState, Answer, AnswerAlarm, Byte, CORead, COReadID, COWrite, COWriteID, CellState, ChangeOrder,
    Constant, DiagnosticArray, DiagnosticStatus, Flag, Header, KeyValue, LineState, ModeOrder, OrderEnd, OrderState,
    PACKAGE, PartState, ProcessImage, ProductionRequest, ProductionState, RosAction, RosMessage, RosService, RunTask,
    SecureOrder, SetResource, StationEvent, StationState, SubmitOrders, Text, Time, Trigger, WhyNot,
};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// `(type, name)` of each field and `(type, name, value)` of each constant.
#[derive(Debug, Default, PartialEq, Eq)]
struct MsgFile {
    fields: Vec<(String, String)>,
    constants: Vec<(String, String, String)>,
}

fn parse(text: &str) -> MsgFile {
    let mut file = MsgFile::default();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let (ros_type, rest) = line.split_once(' ').unwrap_or_else(|| panic!("'{line}' has no name"));
        match rest.split_once('=') {
            Some((name, value)) => {
                file.constants.push((ros_type.to_owned(), name.trim().to_owned(), value.trim().to_owned()));
            }
            None => file.fields.push((ros_type.to_owned(), rest.trim().to_owned())),
        }
    }
    file
}

fn recorded<T: RosMessage>() -> MsgFile {
    let constant = |c: Constant| (c.ros_type, c.name.to_owned(), c.value);
    MsgFile {
        fields: T::fields().into_iter().map(|f| (f.ros_type, f.name.to_owned())).collect(),
        constants: T::constants().into_iter().map(constant).collect(),
    }
}

fn directory() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("msg")
}

fn same<T: RosMessage>(checked: &mut BTreeSet<String>) {
    assert_eq!(T::PACKAGE, PACKAGE);
    let path = directory().join(format!("{}.msg", T::NAME));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    assert_eq!(recorded::<T>(), parse(&text), "{}", T::NAME);
    checked.insert(format!("{}.msg", T::NAME));
}

#[test]
fn every_msg_file_has_a_struct_that_says_the_same() {
    let mut checked = BTreeSet::new();
    same::<ActivityState>(&mut checked);
    same::<AlarmState>(&mut checked);
    same::<Answer>(&mut checked);
    same::<CellState>(&mut checked);
    same::<LineState>(&mut checked);
    same::<ModeOrder>(&mut checked);
    same::<OrderEnd>(&mut checked);
    same::<OrderState>(&mut checked);
    same::<SecureOrder>(&mut checked);
    same::<PartState>(&mut checked);
    same::<ProcessImage>(&mut checked);
    same::<ProductionRequest>(&mut checked);
    same::<ProductionState>(&mut checked);
    same::<StationEvent>(&mut checked);
    same::<StationState>(&mut checked);
    let files: BTreeSet<String> = std::fs::read_dir(directory())
        .expect("msg directory")
        .map(|entry| entry.expect("entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(checked, files);
    let cmake = include_str!("../CMakeLists.txt");
    for file in &files {
        assert!(cmake.contains(&format!("\"msg/{file}\"")), "{file} is not listed in CMakeLists.txt");
    }
}

#[test]
fn the_action_is_what_its_file_says() {
    let text = include_str!("../action/RunTask.action");
    let parts: Vec<&str> = text.split("---\n").collect();
    let [goal, result, feedback] = parts[..] else { panic!("{} parts", parts.len()) };
    assert_eq!(recorded::<<RunTask as RosAction>::Goal>(), parse(goal));
    assert_eq!(recorded::<<RunTask as RosAction>::Result>(), parse(result));
    assert_eq!(recorded::<<RunTask as RosAction>::Feedback>(), parse(feedback));
    assert!(include_str!("../CMakeLists.txt").contains(&format!("\"action/{}.action\"", RunTask::NAME)));
}

#[test]
fn standard_messages_are_as_published() {
    let cases = [
        ("builtin_interfaces", "Time", recorded::<Time>(), "int32 sec\nuint32 nanosec"),
        ("std_msgs", "Header", recorded::<Header>(), "builtin_interfaces/Time stamp\nstring frame_id"),
        ("std_msgs", "String", recorded::<Text>(), "string data"),
        ("std_msgs", "Bool", recorded::<Flag>(), "bool data"),
    ];
    for (package, name, rust, published) in cases {
        assert_eq!(rust, parse(published), "{package}/{name}");
    }
    assert_eq!((Text::PACKAGE, Text::NAME), ("std_msgs", "String"));
    assert_eq!((Flag::PACKAGE, Flag::NAME), ("std_msgs", "Bool"));
}

#[test]
fn diagnostics_are_as_published() {
    let cases = [
        ("KeyValue", recorded::<KeyValue>(), "string key\nstring value"),
        (
            "DiagnosticStatus",
            recorded::<DiagnosticStatus>(),
            // As published but for the package of KeyValue, which a message of the same package need not name.
            "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n\
             string hardware_id\ndiagnostic_msgs/KeyValue[] values",
        ),
        (
            "DiagnosticArray",
            recorded::<DiagnosticArray>(),
            "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status",
        ),
    ];
    for (name, rust, published) in cases {
        assert_eq!(rust, parse(published), "diagnostic_msgs/{name}");
    }
    assert_eq!(DiagnosticStatus::STALE, Byte(3));
}

/// A `.srv` file: request and response, with three dashes between them.
fn service<S: RosService>(name: &str, published: &str) {
    let (request, response) = published.split_once("---").expect("two halves");
    assert_eq!(recorded::<S::Request>(), parse(request), "{name}");
    assert_eq!(recorded::<S::Response>(), parse(response), "{name}");
    assert_eq!(format!("{}/{}", S::PACKAGE, S::NAME), name);
    assert_eq!(S::Request::NAME, format!("{}_Request", S::NAME));
    assert_eq!(S::Response::NAME, format!("{}_Response", S::NAME));
}

#[test]
fn our_services_are_what_their_files_say() {
    let files = [
        ("AnswerAlarm", include_str!("../srv/AnswerAlarm.srv"), service::<AnswerAlarm> as fn(&str, &str)),
        ("ChangeOrder", include_str!("../srv/ChangeOrder.srv"), service::<ChangeOrder>),
        ("SetResource", include_str!("../srv/SetResource.srv"), service::<SetResource>),
        ("SubmitOrders", include_str!("../srv/SubmitOrders.srv"), service::<SubmitOrders>),
        ("WhyNot", include_str!("../srv/WhyNot.srv"), service::<WhyNot>),
    ];
    let there = std::fs::read_dir(directory().join("../srv")).expect("srv directory").count();
    assert_eq!(there, files.len());
    for (name, text, same) in files {
        same(&format!("{PACKAGE}/{name}"), text);
        assert!(include_str!("../CMakeLists.txt").contains(&format!("\"srv/{name}.srv\"")), "{name}");
    }
}

#[test]
fn services_are_as_published() {
    const TYPES: &str = "uint8 CANOPEN_DATATYPE_INT8 = 0x02\nuint8 CANOPEN_DATATYPE_INT16 = 0x03\n\
        uint8 CANOPEN_DATATYPE_INT32 = 0x04\nuint8 CANOPEN_DATATYPE_UINT8 = 0x05\n\
        uint8 CANOPEN_DATATYPE_UINT16 = 0x06\nuint8 CANOPEN_DATATYPE_UINT32 = 0x07\n";
    let types = TYPES.replace("0x0", "");
    // An empty request gets this member from the generator of interfaces.
    service::<Trigger>(
        "std_srvs/Trigger",
        "uint8 structure_needs_at_least_one_member\n---\nbool success\nstring message",
    );
    service::<CORead>("canopen_interfaces/CORead", "uint16 index\nuint8 subindex\n---\nbool success\nuint32 data");
    service::<COWrite>("canopen_interfaces/COWrite", "uint16 index\nuint8 subindex\nuint32 data\n---\nbool success");
    let read = "uint8 nodeid\nuint16 index\nuint8 subindex\nuint8 canopen_datatype\n---\nbool success\nuint32 data";
    service::<COReadID>("canopen_interfaces/COReadID", &format!("{types}{read}"));
    let write = "int8 nodeid\nuint16 index\nuint8 subindex\nuint32 data\nuint8 canopen_datatype\n---\nbool success";
    service::<COWriteID>("canopen_interfaces/COWriteID", &format!("{types}{write}"));
}
