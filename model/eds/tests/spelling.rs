//! Spellings that files have: numbers, names of sections in any case, and text of an encoding that cannot express it.

use linewright_eds::{Configuration, Eds, ObjectValue, read};

use crate::common::{HEAD, node, said, sound};

const OBJECT: &str = "[OptionalObjects]\nSupportedObjects=1\n1=0x6000\n[6000]\nParameterName=P\n";
const UNSIGNED8: u8 = 0x05;
const INTEGER8: u8 = 0x02;
const UNSIGNED64: u8 = 0x1B;

/// A single value of a type, with this default.
fn text_of(data_type: u8, default: &str) -> String {
    format!("{HEAD}{OBJECT}AccessType=rw\nDataType={data_type}\nDefaultValue={default}\n")
}

/// The default as read for a node.
fn default(data_type: u8, default: &str, id: u8) -> Option<ObjectValue> {
    sound(&text_of(data_type, default)).entry(0x6000, 0).expect("it is there").default_for(node(id))
}

#[test]
fn decimal_hexadecimal_and_octal() {
    for (written, value) in [
        ("0", 0),
        ("10", 10),
        ("0x1f", 31),
        ("0X1F", 31),
        ("017", 15),
        ("00", 0),
        (" 7 ", 7),
        ("18446744073709551615", u64::MAX),
    ] {
        assert_eq!(default(UNSIGNED64, written, 1), Some(ObjectValue::Unsigned(value)), "{written}");
    }
    for (written, value) in [("-5", -5), ("-0x80", -128)] {
        assert_eq!(default(INTEGER8, written, 1), Some(ObjectValue::Integer(value)), "{written}");
    }
    for written in ["x", "0x", "1.5", "0x1G", "+5", "--5", "5 6", "0b1", "１", "18446744073709551616"] {
        assert!(read("a.eds", text_of(UNSIGNED64, written).as_bytes()).is_err(), "{written}");
    }
    assert_eq!(["010", "07", "0"].map(|written| said(text_of(UNSIGNED64, written).as_bytes()).len()), [1, 0, 0]);
}

#[test]
fn sums_with_the_node_id() {
    for (written, value) in [("$NODEID+0x10", 0x15), ("0x10 + $NodeId", 0x15), ("$NODEID", 5), ("38", 38)] {
        assert_eq!(default(UNSIGNED8, written, 5), Some(ObjectValue::Unsigned(value)), "{written}");
    }
    for written in ["NODEID+1", "$NODEID+", "$NODEID+$NODEID", "$NODEID-1", "$NODEID+1+2", "1+2", "$NODEID0x10"] {
        assert!(read("a.eds", text_of(UNSIGNED8, written).as_bytes()).is_err(), "{written}");
    }
}

#[test]
fn names_of_sections_in_any_case() {
    let head = format!("{HEAD}{OBJECT}");
    let sub = |name: &str, sub: u8| {
        let entry = |name: &str, default: u8| {
            format!("[{name}]\nParameterName=S\nDataType=5\nAccessType=ro\nDefaultValue={default}\n")
        };
        sound(&format!("{head}ObjectType=9\nSubNumber=2\n{}{}", entry("6000sub0", sub), entry(name, 77)))
    };
    for (name, number) in [("6000suba", 10), ("6000SUBa", 10), ("6000sub0A", 10), ("6000 sub 1", 1)] {
        let value = sub(name, number).entry(0x6000, number).and_then(|entry| entry.default_for(node(1)));
        assert_eq!(value, Some(ObjectValue::Unsigned(77)), "{name}");
    }
    let array = format!("{head}ObjectType=8\nDataType=5\nAccessType=rw\nCompactSubObj=2\n");
    let named = sound(&format!(
        "{array}[6000NAME]\nNrOfEntries=1\n1=left\n[6000value]\nNrOfEntries=1\n1=9\n[6000Denotation]\nNrOfEntries=1\n1=L\n"
    ));
    let first = named.entry(0x6000, 1).expect("it is there");
    assert_eq!((first.name.as_str(), first.denotation.as_deref()), ("left", Some("L")));
    assert_eq!(first.value_for(node(1)), Some(ObjectValue::Unsigned(9)));
    for name in ["DEVICECOMMISSIONING", "DeviceComissioning"] {
        assert_eq!(sound(&format!("{HEAD}[{name}]\nNodeID=5\n")).node_id(), Some(node(5)), "{name}");
    }
    for name in ["1003ObjectLinks", "M1SubExt6000", "Tools", "A0", "101ü"] {
        assert_eq!(said(format!("{HEAD}[{name}]\na=1\n").as_bytes()), [""; 0], "{name}");
    }
    for name in ["1018sub", "1018sub1FF", "1018sub0x1", "0x1018"] {
        let said = said(format!("{HEAD}[{name}]\na=1\n").as_bytes());
        assert!(said.iter().any(|line| line.contains("its index or subindex is not understood")), "{name}: {said:?}");
    }
}

/// The value of a Unicode string in a file that was ISO-8859-1, and whether the file is marked as UTF-8 now.
fn rewritten(value: &str) -> (Eds, bool) {
    let text = format!("{HEAD}{OBJECT}AccessType=rw\nDataType=11\nParameterValue=");
    let old = [text.as_bytes(), b"\xFC\n"].concat();
    let configuration = Configuration::new(node(1)).set(0x6000, 0, ObjectValue::Text(value.to_owned()));
    let bytes =
        read("a.dcf", &old).expect("it is sound").configure("a.dcf", &configuration).expect("it fits").to_bytes();
    (read("a.dcf", &bytes).expect("it is sound"), bytes.starts_with(b"\xEF\xBB\xBF"))
}

#[test]
fn a_text_its_encoding_cannot_say_becomes_utf_8() {
    // The second would be valid UTF-8 with another meaning.
    for (value, is_marked) in [("5 €", true), ("Ã¼", true), ("ö", false), ("u", false)] {
        let (eds, marked) = rewritten(value);
        let read = eds.entry(0x6000, 0).and_then(|entry| entry.value_for(node(1)));
        assert_eq!((read, marked), (Some(ObjectValue::Text(value.to_owned())), is_marked));
    }
}
