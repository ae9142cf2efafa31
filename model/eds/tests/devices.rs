//! Two whole devices: what is read of them, and what a configuration of them sets in which order.

use linewright_eds::{
    AccessType, Category, Configuration, ConfigureError, DataType, Eds, EdsIdentity, ObjectType, ObjectValue,
    WriteReason, read,
};

use crate::common::{DRIVE, HEAD, IO, node, sound};

fn drive() -> Eds {
    read("drive.eds", DRIVE).unwrap_or_else(|problems| panic!("{problems:#}"))
}

fn downloads(eds: &Eds, id: u8) -> Vec<String> {
    eds.downloads(node(id)).expect("for this node").iter().map(ToString::to_string).collect()
}

#[test]
fn the_shipped_device_is_read_without_a_warning() {
    let io = read("linewright-io.eds", IO).unwrap_or_else(|problems| panic!("{problems:#}"));
    assert!(io.warnings().is_empty(), "{:#}", io.warnings());
    let identity = EdsIdentity {
        product: Some(401),
        revision: Some(0x1_0000),
        device_type: Some(0x0003_0191),
        ..EdsIdentity::default()
    };
    assert_eq!(io.identity(), identity);
    assert_eq!(io.device.baud_rates, [10, 20, 50, 125, 250, 500, 800, 1000]);
    assert_eq!(io.entry(0x6000, 8).expect("the last byte").name, "Inputs 56 to 63");
    assert_eq!(io.entry(0x5F00, 64).expect("the last output").access, AccessType::WriteOnly);
    assert!(io.entry(0x6000, 9).is_none() && io.entry(0x6001, 0).is_none());
    assert_eq!(io.to_bytes(), IO);
}

#[test]
fn what_a_drive_says_of_itself() {
    let drive = drive();
    assert_eq!(drive.file.created_by.as_deref(), Some("J. Müller"));
    assert_eq!(drive.file.created.as_deref(), Some("11-21-2026 09:30AM"));
    assert_eq!(drive.device.order_code.as_deref(), Some("A-400"));
    assert_eq!((drive.device.rx_pdos, drive.device.lss), (Some(1), true));
    assert_eq!(drive.dummies, [5, 6]);
    assert_eq!(
        drive.identity(),
        EdsIdentity {
            device_type: Some(0x0002_0192),
            vendor: Some(0x3E7),
            product: Some(0x10400),
            revision: Some(0x20001),
            serial: None,
        }
    );
    assert_eq!(drive.to_bytes(), DRIVE);
    let said: Vec<_> = drive.warnings().iter().map(|problem| (problem.line, problem.message.as_str())).collect();
    assert_eq!(said, [(442, "[6081] DefaultValue: `01750` is octal and means 1000")]);
}

#[test]
fn entries_have_type_access_and_default() {
    let drive = drive();
    let entry = |index, sub| drive.entry(index, sub).unwrap_or_else(|| panic!("{index:04X} {sub}"));
    assert_eq!(entry(0x1014, 0).default_for(node(5)), Some(ObjectValue::Unsigned(0x85)));
    assert_eq!(entry(0x1400, 1).default_for(node(127)), Some(ObjectValue::Unsigned(0x27F)));
    assert_eq!(entry(0x1008, 0).default_for(node(1)), Some(ObjectValue::Text("Achse 400".into())));
    assert_eq!(entry(0x607D, 1).default_for(node(1)), Some(ObjectValue::Integer(-50_000)));
    assert_eq!(entry(0x6098, 0).low.as_ref().and_then(|low| low.constant()), Some(&ObjectValue::Integer(-128)));
    assert_eq!(entry(0x6081, 0).default_for(node(1)), Some(ObjectValue::Unsigned(1000)));
    assert_eq!(entry(0x2000, 0).default_for(node(1)), Some(ObjectValue::Real32(5.0)));
    assert_eq!(entry(0x2000, 0).name, "Lead of the screw / mm");
    assert_eq!(entry(0x2002, 0).default_for(node(1)), Some(ObjectValue::Boolean(true)));
    assert_eq!((entry(0x2010, 0).object_type, entry(0x2010, 0).data_type), (ObjectType::Domain, DataType::Domain));
    assert_eq!((entry(0x6040, 0).access, entry(0x6040, 0).pdo_mappable), (AccessType::ReadWriteOutput, true));
    assert_eq!(entry(0x6041, 0).default_for(node(1)), None);
    assert_eq!(drive.object(0x6040).expect("there").category, Some(Category::Optional));
    let line = entry(0x1017, 0).line as usize;
    let text: String = DRIVE.iter().map(|&byte| char::from(byte)).collect();
    assert_eq!(text.lines().nth(line - 1), Some("[1017]"));
}

#[test]
fn compact_arrays_have_the_elements_they_count() {
    let drive = drive();
    let errors = drive.object(0x1003).expect("there");
    let names: Vec<_> = errors.entries().map(|(sub, entry)| (sub, entry.name.clone())).collect();
    let expected = ["NrOfObjects", "Last error", "Pre-defined error field2", "Pre-defined error field3"];
    assert_eq!(names.iter().map(|(_, name)| name.as_str()).take(4).collect::<Vec<_>>(), expected);
    assert_eq!(names.len(), 5);
    assert_eq!(drive.entry(0x1003, 0).expect("the count").default_for(node(1)), Some(ObjectValue::Unsigned(4)));
    assert!(drive.entry(0x1003, 5).is_none());
}

#[test]
fn an_eds_sets_nothing() {
    assert_eq!(downloads(&drive(), 9), Vec::<String>::new());
}

#[test]
fn a_pdo_is_off_while_it_is_changed_and_storing_comes_last() {
    let configuration = Configuration::new(node(9))
        .set(0x1010, 1, ObjectValue::Unsigned(0x6576_6173))
        .set(0x1017, 0, ObjectValue::Unsigned(50))
        .set(0x1016, 1, ObjectValue::Unsigned(0x007F_00C8))
        .set(0x1020, 1, ObjectValue::Unsigned(15_000))
        .set(0x1600, 0, ObjectValue::Unsigned(2))
        .set(0x1600, 1, ObjectValue::Unsigned(0x6040_0010))
        .set(0x1600, 2, ObjectValue::Unsigned(0x607A_0020))
        .set(0x1800, 2, ObjectValue::Unsigned(1))
        .set(0x1A00, 1, ObjectValue::Unsigned(0x6041_0010))
        .set(0x607D, 1, ObjectValue::Integer(-1))
        .set(0x1400, 1, ObjectValue::Unsigned(0x8000_0209));
    let dcf = drive().configure("drive9.dcf", &configuration).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(
        downloads(&dcf, 9),
        [
            "1016h sub 1: C8 00 7F 00",
            "1017h: 32 00",
            "607Dh sub 1: FF FF FF FF",
            "1400h sub 1: 09 02 00 80 (switched off)",
            "1600h: 00 (no mapping)",
            "1600h sub 1: 10 00 40 60",
            "1600h sub 2: 20 00 7A 60",
            "1600h: 02",
            "1400h sub 1: 09 02 00 80",
            "1800h sub 1: 89 01 00 80 (switched off)",
            "1A00h: 00 (no mapping)",
            "1A00h sub 1: 10 00 41 60",
            "1A00h: 03 (as before)",
            "1800h sub 2: 01",
            "1800h sub 1: 89 01 00 00 (as before)",
            "1020h sub 1: 98 3A 00 00",
            "1010h sub 1: 73 61 76 65",
        ]
    );
    let first = &dcf.downloads(node(9)).expect("for this node")[0];
    assert_eq!((first.index, first.sub, first.reason), (0x1016, 1, WriteReason::Value));
    let error = dcf.downloads(node(8)).unwrap_err().to_string();
    assert_eq!(error, "the file is for node 09h, not for node 08h; correct NodeID in its [DeviceComissioning]");
}

#[test]
fn what_cannot_or_must_not_be_written_is_left_out() {
    let text = format!(
        "{HEAD}ParameterValue=1\n[OptionalObjects]\nSupportedObjects=3\n1=0x6000\n2=0x6001\n3=0x6002\n\
        [6000]\nParameterName=A\nDataType=5\nAccessType=rw\nParameterValue=1\nObjFlags=1\n\
        [6001]\nParameterName=B\nDataType=5\nAccessType=rw\nParameterValue=$NODEID+1\nObjFlags=2\n\
        [6002]\nParameterName=C\nObjectType=2\nDownloadFile=table.bin\n"
    );
    assert_eq!(downloads(&sound(&text), 3), ["6001h: 04", "6002h: the file table.bin"]);
}

#[test]
fn a_dcf_differs_from_its_eds_in_the_values_alone() {
    let configuration = Configuration {
        node_name: Some("Mühle, Schlitten".into()),
        baud_rate: Some(500),
        serial_number: Some(7),
        ..Configuration::new(node(9))
            .set(0x1017, 0, ObjectValue::Unsigned(50))
            .set(0x1016, 2, ObjectValue::Unsigned(1))
            .set(0x607D, 2, ObjectValue::Integer(40_000))
            .set(0x2000, 0, ObjectValue::Real32(0.1))
    };
    let dcf = drive().configure("nets/drive9.dcf", &configuration).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((dcf.node_id(), dcf.identity().serial), (Some(node(9)), Some(7)));
    assert_eq!(dcf.file.last_eds.as_deref(), Some("drive.eds"));
    let latin1 = |bytes: &[u8]| bytes.iter().map(|&byte| char::from(byte)).collect::<String>();
    let (before, after) = (latin1(DRIVE), latin1(&dcf.to_bytes()));
    let replaced = before.replace("FileName=drive.eds", "FileName=drive9.dcf");
    let mut old = replaced.lines().peekable();
    let added: Vec<_> = after.lines().filter(|line| old.next_if_eq(line).is_none()).collect();
    assert_eq!(old.next(), None);
    assert_eq!(
        added,
        [
            "LastEDS=drive.eds",
            "[1016Value]",
            "NrOfEntries=1",
            "2=1",
            "",
            "ParameterValue=0x0032",
            "ParameterValue=40000",
            "ParameterValue=0.1",
            "",
            "[DeviceComissioning]",
            "NodeID=9",
            "NodeName=Mühle, Schlitten",
            "Baudrate=500",
            "LSS_SerialNumber=0x00000007",
        ]
    );
    assert!(after.lines().count() == after.matches("\r\n").count(), "DOS line ends throughout");

    let again = dcf.configure("drive9.dcf", &Configuration::new(node(10)).set(0x1016, 1, ObjectValue::Unsigned(2)));
    let again = again.unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(again.node_id(), Some(node(10)));
    assert_eq!(again.commissioning.as_ref().and_then(|of| of.node_name.as_deref()), Some("Mühle, Schlitten"));
    assert!(latin1(&again.to_bytes()).contains("[1016Value]\r\nNrOfEntries=2\r\n2=1\r\n1=2\r\n"));
}

#[test]
fn what_cannot_be_configured_is_said_all_at_once() {
    let text = |text: &str| ObjectValue::Text(text.into());
    let eds = sound(&format!(
        "{HEAD}[2000]\nParameterName=Label\nDataType=9\nAccessType=rw\n[2001]\nParameterName=L\nDataType=5\n\
        AccessType=rw\nHighLimit=9\n"
    ));
    let configuration = Configuration::new(node(1))
        .set(0x1000, 0, ObjectValue::Unsigned(1))
        .set(0x2000, 0, text("a\nNodeID=5"))
        .set(0x2001, 0, ObjectValue::Unsigned(10))
        .set(0x3000, 1, ObjectValue::Unsigned(1));
    let errors = eds.configure("a.dcf", &configuration).unwrap_err();
    assert_eq!(
        errors.to_string().lines().collect::<Vec<_>>(),
        [
            "1000h `Device type` cannot be written: it is ro",
            "2000h: the text \"a\\nNodeID=5\" has no form in a DCF; nothing at all, line ends, spaces at its ends and ` ;` \
         cannot be written",
            "2001h: 10 (0xA) is beyond HighLimit, which is 9",
            "3000h sub 1: the description has no such entry",
        ]
    );
    for unsayable in ["", " a", "a ", "a ;b", ";"] {
        let errors = eds.configure("a.dcf", &Configuration::new(node(1)).set(0x2000, 0, text(unsayable))).unwrap_err();
        assert!(matches!(errors.0[..], [ConfigureError::NotSayable { .. }]), "{unsayable:?}: {errors}");
    }
    let euro = eds.configure("a.dcf", &Configuration::new(node(1)).set(0x2000, 0, text("5 €"))).unwrap_err();
    assert_eq!(euro.to_string(), "2000h: VISIBLE_STRING has no character `€`");
    let wrong = eds.configure("a.dcf", &Configuration::new(node(1)).set(0x2001, 0, text("5"))).unwrap_err();
    assert_eq!(wrong.to_string(), "2001h: `5` is no value of UNSIGNED8");
}
