//! Identity and settings of a device, as read.

use linewright_line::{DeviceIdentity, ObjectWrite, Reaction, parse};

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
fn what_keeps_an_output_on_without_a_manager_is_read_with_its_reason() {
    for (object, value) in [("6206:01", 0), ("6206:01", 0xFE), ("6207:01", 2), ("1029:01", 1)] {
        let setting = format!("settings = [{{ object = \"{object}\", type = \"u8\", value = {value} }}]");
        let excused = with(&format!("{setting}\nwithout_error_values = \"the safety relay cuts its supply\""));
        let parsed = parse("line.toml", &excused).unwrap_or_else(|problems| panic!("{problems:#}"));
        let why = parsed.line.devices[0].canopen().expect("CANopen").setup.without_error_values.as_deref();
        assert_eq!(why, Some("the safety relay cuts its supply"));
    }
    // Values without effect on outputs, and those that turn them off.
    for (object, value) in [("6206:01", 3), ("6207:01", 0xFC), ("6206:02", 0), ("1029:01", 2)] {
        let text = with(&format!("settings = [{{ object = \"{object}\", type = \"u8\", value = {value} }}]"));
        assert!(parse("line.toml", &text).is_ok(), "{object} = {value}");
    }
}

#[test]
fn objects_are_read_in_the_forms_people_use_and_numbers_become_bytes_of_their_width() {
    let settings = |object: &str, kind: &str, value: i64| {
        let text = with(&format!("settings = [{{ object = \"{object}\", type = \"{kind}\", value = {value} }}]"));
        parse("line.toml", &text)
            .map(|parsed| parsed.line.devices[0].canopen().expect("CANopen").setup.settings.clone())
    };
    let written = |index, sub, data: &[u8]| Ok(vec![ObjectWrite { index, sub, data: data.to_vec() }]);
    for object in ["6206:01", "6206:1", "6206h:01", "0x6206:0x01"] {
        assert_eq!(settings(object, "u8", 255), written(0x6206, 1, &[255]), "{object}");
    }
    for object in ["", ":", "6206:", "62061:01", "6206:100", "g", "6206:-1", "+206:1"] {
        assert!(settings(object, "u8", 255).is_err(), "{object}");
    }
    assert_eq!(settings("2000", "u16", 0x1234), written(0x2000, 0, &[0x34, 0x12]));
    assert_eq!(settings("2000", "i8", -1), written(0x2000, 0, &[0xFF]));
    assert_eq!(settings("2000", "u32", 0xFFFF_FFFF), written(0x2000, 0, &[0xFF; 4]));
    assert!(settings("2000", "i32", 1 << 31).is_err());
}
