//! Written descriptions equal those read, and configurations read back equal those written: thousands of generated
//! ones.
//!
//! The generator writes its own text from its own model, in the many ways of spelling that files have, and the reader
//! must find the model again.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use linewright_eds::{Configuration, DataType, ObjectValue, read};
use proptest::prelude::*;

use crate::common::{self, node};

/// One entry as the generator means it.
#[derive(Clone, Debug)]
struct Meant {
    data_type: DataType,
    writable: bool,
    default: Option<ObjectValue>,
    spelling: u8,
}

/// Contents of an object: a value, elements, or compact elements.
#[derive(Clone, Debug)]
enum Shape {
    Var(Meant),
    Record(BTreeMap<u8, Meant>),
    Compact(u8, Meant),
}

fn numeric() -> impl Strategy<Value = DataType> {
    let types: Vec<_> = DataType::ALL.iter().copied().filter(|data_type| data_type.size().is_some()).collect();
    prop::sample::select(types)
}

/// A value of a type from any bytes, by the slow way: bit by bit.
fn value_of(data_type: DataType, raw: u64) -> ObjectValue {
    let bits = 8 * data_type.size().expect("a number") as u32;
    match data_type {
        DataType::Boolean => ObjectValue::Boolean(raw & 1 == 1),
        DataType::Real32 => ObjectValue::Real32((raw as i32) as f32 / 64.0),
        DataType::Real64 => ObjectValue::Real64((raw as i64) as f64 / 1024.0),
        _ => {
            let kept = (0..bits).filter(|bit| raw >> bit & 1 == 1).fold(0_i128, |sum, bit| sum + (1 << bit));
            let signed = data_type.to_string().starts_with("INTEGER");
            if signed && kept >= 1 << (bits - 1) {
                ObjectValue::Integer((kept - (1 << bits)) as i64)
            } else if signed {
                ObjectValue::Integer(kept as i64)
            } else {
                ObjectValue::Unsigned(kept as u64)
            }
        }
    }
}

fn spelled(value: &ObjectValue, spelling: u8) -> String {
    let number: i128 = match *value {
        ObjectValue::Boolean(value) => value.into(),
        ObjectValue::Integer(value) => value.into(),
        ObjectValue::Unsigned(value) => value.into(),
        ObjectValue::Real32(value) => return format!("{value:?}"),
        ObjectValue::Real64(value) => return format!("{value:?}"),
        _ => unreachable!("numbers only"),
    };
    let (sign, size) = (if number < 0 { "-" } else { "" }, number.abs());
    match spelling % 5 {
        0 => format!("{sign}{size}"),
        1 => format!("{sign}0x{size:x}"),
        2 => format!("{sign}0X{size:08X}"),
        3 if size > 7 => format!("{sign}0{size:o}"),
        3 => format!("{sign}{size} ; a small one"),
        _ => format!("  {sign}0x{size:X};hex"),
    }
}

fn meant() -> impl Strategy<Value = Meant> {
    (numeric(), any::<bool>(), prop::option::of(any::<u64>()), any::<u8>()).prop_map(
        |(data_type, writable, raw, spelling)| {
            let default = raw.map(|raw| value_of(data_type, raw));
            Meant { data_type, writable, default, spelling }
        },
    )
}

fn objects() -> impl Strategy<Value = BTreeMap<u16, Shape>> {
    let shape = prop_oneof![
        meant().prop_map(Shape::Var),
        prop::collection::btree_map(any::<u8>(), meant(), 1..5).prop_map(Shape::Record),
        (1..=254_u8, meant()).prop_map(|(count, meant)| Shape::Compact(count, meant)),
    ];
    prop::collection::btree_map(0x2000..0x6000_u16, shape, 1..6)
}

fn write_entry(text: &mut String, section: &str, meant: &Meant) {
    let case = |key: &str| match meant.spelling % 3 {
        0 => key.to_owned(),
        1 => key.to_lowercase(),
        _ => format!("{} ", key.to_uppercase()),
    };
    let access = if meant.writable { "rw" } else { "const" };
    let _ = writeln!(text, "[{section}]\n{}=P {section}\n{}={access}", case("ParameterName"), case("AccessType"));
    let _ = writeln!(text, "{}=0x{:04x}", case("DataType"), meant.data_type.code());
    if let Some(default) = &meant.default {
        let _ = writeln!(text, "{}={}", case("DefaultValue"), spelled(default, meant.spelling));
    }
}

fn text_of(objects: &BTreeMap<u16, Shape>, dos: bool) -> String {
    let mut text = String::from("; made up\n[MandatoryObjects]\nSupportedObjects=0\n[ManufacturerObjects]\n");
    let _ = writeln!(text, "SupportedObjects={}", objects.len());
    for (at, index) in objects.keys().enumerate() {
        let _ = writeln!(text, "{}=0x{index:x}", at + 1);
    }
    for (index, shape) in objects {
        let _ = writeln!(text, "\n; object {index:X}h");
        match shape {
            Shape::Var(meant) => write_entry(&mut text, &format!("{index:04X}"), meant),
            Shape::Compact(count, meant) => {
                write_entry(&mut text, &format!("{index:04x}"), meant);
                let _ = writeln!(text, "ObjectType=8\nCompactSubObj={count}");
            }
            Shape::Record(subs) => {
                let _ = writeln!(text, "[{index:04X}]\nParameterName=R\nObjectType=0x9\nSubNumber={}", subs.len());
                for (sub, meant) in subs {
                    write_entry(&mut text, &format!("{index:04X}Sub{sub:x}"), meant);
                }
            }
        }
        text.push_str("MyOwnKey=kept \t\n");
    }
    if dos { text.replace('\n', "\r\n") } else { text }
}

/// All entries, expanded the slow way.
fn expanded(objects: &BTreeMap<u16, Shape>) -> BTreeMap<(u16, u8), Meant> {
    let mut all = BTreeMap::new();
    for (&index, shape) in objects {
        match shape {
            Shape::Var(meant) => drop(all.insert((index, 0), meant.clone())),
            Shape::Record(subs) => all.extend(subs.iter().map(|(sub, meant)| ((index, *sub), meant.clone()))),
            Shape::Compact(count, meant) => {
                let default = Some(ObjectValue::Unsigned((*count).into()));
                let first = Meant { data_type: DataType::Unsigned8, writable: false, default, spelling: 0 };
                all.insert((index, 0), first);
                all.extend((1..=*count).map(|sub| ((index, sub), meant.clone())));
            }
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_model_is_found_again_in_its_text(objects in objects(), dos in any::<bool>()) {
        let text = text_of(&objects, dos);
        let eds = read("a.eds", text.as_bytes()).map_err(|problems| TestCaseError::fail(format!("{problems:#}\n{text}")))?;
        prop_assert_eq!(eds.to_bytes(), text.as_bytes());
        let expected = expanded(&objects);
        prop_assert_eq!(eds.entries().count(), expected.len());
        for (index, sub, entry) in eds.entries() {
            let meant = &expected[&(index, sub)];
            prop_assert_eq!(entry.data_type, meant.data_type);
            prop_assert_eq!(entry.access.is_writable(), meant.writable);
            prop_assert_eq!(&entry.default_for(node(1)), &meant.default, "{:04X} {}", index, sub);
            let line = text.lines().nth(entry.line as usize - 1).unwrap_or_default();
            prop_assert!(line.to_lowercase().contains(&format!("{index:04x}")), "{line}");
        }
    }

    #[test]
    fn what_is_configured_is_read_back_and_nothing_else_has_changed(
        objects in objects(),
        dos in any::<bool>(),
        raw in prop::collection::vec((any::<prop::sample::Index>(), any::<u64>()), 0..12),
        id in 1..=127_u8,
    ) {
        let text = text_of(&objects, dos);
        let eds = read("a.eds", text.as_bytes()).map_err(|problems| TestCaseError::fail(format!("{problems:#}")))?;
        let writable: Vec<_> = expanded(&objects).into_iter().filter(|(_, meant)| meant.writable).collect();
        let mut configuration = Configuration::new(node(id));
        for (at, raw) in raw.iter().filter(|_| !writable.is_empty()) {
            let ((index, sub), meant) = at.get(&writable);
            configuration = configuration.set(*index, *sub, value_of(meant.data_type, *raw));
        }
        let dcf = eds.configure("a.dcf", &configuration).map_err(|errors| TestCaseError::fail(errors.to_string()))?;
        let again = read("a.dcf", &dcf.to_bytes()).map_err(|problems| TestCaseError::fail(format!("{problems:#}")))?;
        prop_assert_eq!(again.node_id(), Some(node(id)));
        let mut set = 0;
        for (index, sub, entry) in again.entries() {
            let value = entry.value_for(node(id));
            prop_assert_eq!(value.as_ref(), configuration.values.get(&(index, sub)));
            prop_assert_eq!(entry.default_for(node(1)), eds.entry(index, sub).unwrap().default_for(node(1)));
            set += usize::from(entry.value.is_some());
        }
        prop_assert_eq!(set, configuration.values.len());
        prop_assert_eq!(again.downloads(node(id)).unwrap().len(), configuration.values.len());

        let after = String::from_utf8(dcf.to_bytes()).unwrap();
        let mut old = text.lines().peekable();
        let added = after.lines().filter(|line| old.next_if_eq(line).is_none()).count();
        prop_assert_eq!(old.next(), None, "every line is still there, in order");
        prop_assert!(added <= 3 + 5 * configuration.values.len(), "{added} lines added");
        // Once more, with nothing new: the same bytes.
        let same = again.configure("a.dcf", &configuration).map_err(|errors| TestCaseError::fail(errors.to_string()))?;
        prop_assert_eq!(same.to_bytes(), dcf.to_bytes());
    }

    #[test]
    fn values_and_bytes_are_two_forms_of_the_same(data_type in numeric(), raw in any::<u64>()) {
        let value = value_of(data_type, raw);
        let bytes = data_type.encode(&value).expect("of the type");
        prop_assert_eq!(Some(bytes.len()), data_type.size());
        prop_assert_eq!(data_type.decode(&bytes).expect("its bytes"), value);
        if !matches!(data_type, DataType::Real32 | DataType::Real64 | DataType::Boolean) {
            let expected: Vec<u8> = (0..bytes.len()).map(|byte| (raw >> (8 * byte)) as u8).collect();
            prop_assert_eq!(bytes, expected);
        }
    }
}

#[test]
fn texts_and_bytes_are_coded_as_the_standard_says() {
    let text = |text: &str| ObjectValue::Text(text.into());
    assert_eq!(DataType::VisibleString.encode(&text("Aä")), Ok(vec![0x41, 0xE4]));
    assert_eq!(DataType::VisibleString.decode(b"A\0\0"), Ok(text("A")));
    assert_eq!(DataType::UnicodeString.encode(&text("A€")), Ok(vec![0x41, 0, 0xAC, 0x20]));
    assert_eq!(DataType::UnicodeString.decode(&[0x41, 0, 0xAC, 0x20]), Ok(text("A€")));
    assert!(DataType::UnicodeString.decode(&[0x41]).is_err() && DataType::UnicodeString.decode(&[0, 0xD8]).is_err());
    assert_eq!(DataType::OctetString.encode(&ObjectValue::Bytes(vec![1, 2])), Ok(vec![1, 2]));
    assert_eq!(DataType::Other(0x40).decode(&[9]), Ok(ObjectValue::Bytes(vec![9])));
    assert!(DataType::Other(0x40).encode(&ObjectValue::Unsigned(9)).is_err());
    assert_eq!(DataType::Integer8.encode(&ObjectValue::Unsigned(127)), Ok(vec![127]));
    assert!(DataType::Integer8.encode(&ObjectValue::Unsigned(128)).is_err());
    assert!(DataType::Unsigned16.decode(&[1]).is_err());
    for code in 0..=0xFFFF {
        assert_eq!(DataType::from_code(code).code(), code);
    }
}

#[test]
fn bytes_reals_and_times_are_read_from_text() {
    let value = |data_type: u16, text: &str| {
        let file = format!(
            "{}[2000]\nParameterName=A\nAccessType=rw\nDataType={data_type}\nParameterValue={text}\n",
            common::HEAD
        );
        common::sound(&file).entry(0x2000, 0).and_then(|entry| entry.value_for(node(1)))
    };
    assert_eq!(value(0x0A, "01 2a FF"), Some(ObjectValue::Bytes(vec![1, 0x2A, 0xFF])));
    assert_eq!(value(0x0F, "012A"), Some(ObjectValue::Bytes(vec![1, 0x2A])));
    assert_eq!(value(0x08, "0x40490FDB"), Some(ObjectValue::Real32(std::f32::consts::PI)));
    assert_eq!(value(0x11, "0x400921FB54442D18"), Some(ObjectValue::Real64(std::f64::consts::PI)));
    assert_eq!(value(0x08, "-1.5e3"), Some(ObjectValue::Real32(-1500.0)));
    assert_eq!(value(0x0C, "365 43200000"), Some(ObjectValue::Unsigned(365 << 32 | 43_200_000)));
    assert_eq!(value(0x09, "a ; b"), Some(ObjectValue::Text("a".into())));
    assert_eq!(value(0x09, "a;b"), Some(ObjectValue::Text("a;b".into())));
    assert_eq!(value(0x03, "0xFFFE"), Some(ObjectValue::Integer(-2)));
    assert_eq!(value(0x07, "0x180+$nodeid"), Some(ObjectValue::Unsigned(0x181)));
}
