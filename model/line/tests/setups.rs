//! What a device has to be and is told: what is read, and every rule about it broken once.

use linewright_line::{DeviceIdentity, ObjectWrite, Problem, Reaction, parse};

const LINE: &str = include_str!("descriptions/drives.toml");

/// The description with this added to the device of the valves.
fn with(text: &str) -> String {
    LINE.replace("outputs = [\"Y_open\", \"Y_close\"]\n", &format!("outputs = [\"Y_open\", \"Y_close\"]\n{text}\n"))
}

#[test]
fn identity_and_settings_are_read() {
    let text = with(
        "file = \"io.eds\"\nidentity = { type = 0x30191, vendor = 0x123, revision = 0x10002 }\n\
         settings = [{ object = \"6206:01\", type = \"u8\", value = 255 }, { object = \"2000\", value = 1 }, \
         { object = \"2001h:2\", type = \"i16\", value = -2 }]",
    );
    let parsed = parse("line.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}"));
    let setup = &parsed.line.devices[0].canopen().expect("CANopen").setup;
    assert_eq!(setup.file.as_deref(), Some("io.eds"));
    let identity = DeviceIdentity { device_type: Some(0x0003_0191), vendor: Some(0x123), ..DeviceIdentity::default() };
    assert_eq!(setup.identity, DeviceIdentity { revision: Some(0x0001_0002), ..identity });
    let setting = |index, sub, data: &[u8]| ObjectWrite { index, sub, data: data.to_vec() };
    let expected = [setting(0x6206, 1, &[255]), setting(0x2000, 0, &[1, 0, 0, 0]), setting(0x2001, 2, &[0xFE, 0xFF])];
    assert_eq!(setup.settings, expected);
    assert_eq!(parsed.line.devices[1].canopen().expect("CANopen").setup, linewright_line::DeviceSetup::default());
}

/// The one problem that this text has beyond those of the whole.
fn problem(text: &str) -> String {
    let messages = |problems: &[Problem]| problems.iter().map(|problem| problem.message.clone()).collect::<Vec<_>>();
    let found = match parse("line.toml", &with(text)) {
        Ok(parsed) => messages(&parsed.warnings),
        Err(problems) => problems.iter().map(|problem| problem.message.clone()).collect(),
    };
    let known = messages(&parse("line.toml", LINE).expect("it is sound").warnings);
    let mut new = found.into_iter().filter(|message| !known.contains(message));
    let first = new.next().unwrap_or_else(|| panic!("nothing wrong with {text}"));
    assert_eq!(new.next(), None, "{text}");
    first
}

#[test]
fn what_trouble_does_is_read() {
    let reactions = |text: &str| {
        let parsed = parse("line.toml", &with(text)).unwrap_or_else(|problems| panic!("{problems:#}"));
        parsed
            .line
            .devices
            .iter()
            .map(|d| (d.on_emergency(), d.canopen().expect("CANopen").setup.when_lost))
            .collect::<Vec<_>>()
    };
    let (fault, report) = (Reaction::Fault, Reaction::Report);
    // The drive has a fault signal of its own.
    assert_eq!(reactions(""), [(fault, fault), (report, fault)]);
    assert_eq!(reactions("on_emergency = \"report\""), [(report, fault), (report, fault)]);
    let lamp = "[[device]]\nname = \"lamps\"\nstation = \"slide\"\nnode = 9\noutputs = [\"L\"]\nwhen_lost = \"report\"";
    assert_eq!(reactions(lamp), [(fault, fault), (report, report), (report, fault)]);
}

#[test]
fn a_device_that_something_depends_on_cannot_be_lost_without_a_fault() {
    let cannot = "this device cannot be lost without a fault:";
    assert_eq!(problem("when_lost = \"report\""), format!("{cannot} `C_0` is one of its inputs"));
    let output = LINE.replace("outputs = [\"Y_open\", \"Y_close\"]", "outputs = [\"Y_open\"]")
        + "\n[[device]]\nname = \"valve\"\nstation = \"slide\"\nnode = 9\noutputs = [\"Y_close\"]\nwhen_lost = \"report\"\n";
    let problems = parse("line.toml", &output).expect_err("a motion needs it");
    let messages: Vec<String> = problems.iter().map(|problem| problem.message.clone()).collect();
    assert!(messages.contains(&format!("{cannot} `Y_close` is one of its outputs")), "{messages:?}");
    let drive = LINE.replace("node = 3\n", "node = 3\nwhen_lost = \"report\"\n");
    let problems = parse("line.toml", &drive).expect_err("a drive moves an axis");
    let messages: Vec<String> = problems.iter().map(|problem| problem.message.clone()).collect();
    assert!(messages.contains(&format!("{cannot} it is a drive")), "{messages:?}");
    assert_eq!(problem("on_emergency = \"ignore\""), "unknown on_emergency `ignore`");
}

#[test]
fn what_cannot_be_sent_is_refused_in_place() {
    let setting = |setting: &str| problem(&format!("settings = [{{ {setting} }}]"));
    assert_eq!(setting("object = \"62061\", value = 1"), "`62061` is no object");
    assert_eq!(setting("object = \"6206:01\", type = \"u8\", value = 256"), "256 does not fit its type");
    assert_eq!(setting("object = \"6206:01\", type = \"i8\", value = -129"), "-129 does not fit its type");
    assert_eq!(setting("object = \"1016:01\", value = 0"), "object 1016h is written by the manager itself");
    assert_eq!(
        setting("object = \"1017\", type = \"u16\", value = 0"),
        "object 1017h is written by the manager itself"
    );
    assert_eq!(setting("object = \"2000\", type = \"u64\", value = 0"), "unknown type `u64`");
    assert_eq!(problem("identity = { vendor = -1 }"), "-1 is no part of an identity");
    assert_eq!(problem("identity = { vendor = 0x100000000 }"), "4294967296 is no part of an identity");
    let twice = "settings = [{ object = \"2000\", value = 1 }, { object = \"2000:0\", value = 2 }]";
    assert_eq!(problem(twice), "object 2000h:00 is written twice");
}

#[test]
fn what_keeps_an_output_on_without_a_manager_needs_a_reason() {
    let keeps = "an output of this device stays on when the manager is gone";
    for (object, value) in [("6206:01", 0), ("6206:01", 0xFE), ("6207:01", 2), ("1029:01", 1)] {
        let setting = format!("settings = [{{ object = \"{object}\", type = \"u8\", value = {value} }}]");
        assert_eq!(problem(&setting), keeps, "{object} = {value}");
        let excused = with(&format!("{setting}\nwithout_error_values = \"the safety relay cuts its supply\""));
        let parsed = parse("line.toml", &excused).unwrap_or_else(|problems| panic!("{problems:#}"));
        let why = parsed.line.devices[0].canopen().expect("CANopen").setup.without_error_values.as_deref();
        assert_eq!(why, Some("the safety relay cuts its supply"));
    }
    // What no output hangs on, and what lets go.
    for (object, value) in [("6206:01", 3), ("6207:01", 0xFC), ("6206:02", 0), ("1029:01", 2)] {
        let text = with(&format!("settings = [{{ object = \"{object}\", type = \"u8\", value = {value} }}]"));
        assert!(parse("line.toml", &text).is_ok(), "{object} = {value}");
    }
    assert_eq!(problem("without_error_values = \" \""), "no reason is given");
    let drive = LINE.replace("node = 3\n", "node = 3\nwithout_error_values = \"a brake\"\n");
    let problems = parse("line.toml", &drive).expect_err("a drive has others");
    assert!(problems.iter().any(|p| p.message == "this device has no error values to be without"), "{problems:#}");
}
