//! The section of one entry: its type, its access, its values.
//!
//! An error that would change a value that a device is sent is one. A limit or a default that cannot be read is only a
//! check less, and a warning, unless it is a number that does not fit its type: then the type may be the wrong one.

use linewright_diagnostics::shown;

use crate::data_type::DataType;
use crate::ini::IniKey;
use crate::model::{AccessType, ObjectType, SubObject};
use crate::reader::{SectionReader, Weight};
use crate::value::{self, NodeId, ValueSetting};

/// The kind of object a section describes; a section without one describes one value (CiA 306 §4.6.3.2).
pub(crate) fn object_type(reader: &mut SectionReader<'_, '_>) -> ObjectType {
    const WORDS: [(&str, ObjectType); 6] = [
        ("DOMAIN", ObjectType::Domain),
        ("DEFTYPE", ObjectType::DefType),
        ("DEFSTRUCT", ObjectType::DefStruct),
        ("VAR", ObjectType::Var),
        ("ARRAY", ObjectType::Array),
        ("RECORD", ObjectType::Record),
    ];
    let Some((key, text)) = reader.key("ObjectType") else { return ObjectType::Var };
    if let Some((word, object_type)) = WORDS.iter().find(|(word, _)| word.eq_ignore_ascii_case(text)) {
        reader.say(key, Weight::Warning, format!("`{}` is a word", shown(text)), format!("write the number of {word}"));
        return *object_type;
    }
    let code = reader.number_of(key, text, 0xFF, Weight::Error).and_then(|code| u8::try_from(code).ok());
    let object_type = code.map_or(ObjectType::Var, ObjectType::from_code);
    if let ObjectType::Other(code) = object_type {
        let hint = "7 is VAR, 8 ARRAY, 9 RECORD, 2 DOMAIN";
        reader.say(key, Weight::Warning, format!("there is no object type {code}; it is kept as it is"), hint);
    }
    object_type
}

/// ObjFlags.
pub(crate) fn flags(reader: &mut SectionReader<'_, '_>) -> u32 {
    let flags = reader.number("ObjFlags", u32::MAX.into(), Weight::Warning);
    flags.and_then(|flags| u32::try_from(flags).ok()).unwrap_or_default()
}

/// ParameterName, which every object has.
pub(crate) fn name(reader: &mut SectionReader<'_, '_>) -> String {
    let name = reader.text("ParameterName");
    if name.is_none() {
        reader.say_here(Weight::Warning, "has no ParameterName", "write ParameterName=…");
    }
    name.unwrap_or_default()
}

/// Reads the section of one entry. `None` if it has no data, or if their type is uncertain.
pub(crate) fn read(reader: &mut SectionReader<'_, '_>, object_type: ObjectType, node: NodeId) -> Option<SubObject> {
    let entry_name = name(reader);
    if object_type == ObjectType::Null {
        return None;
    }
    let data_type = data_type(reader, object_type);
    let access = access(reader, object_type);
    let (data_type, access) = (data_type?, access?);
    let mut entry = SubObject {
        name: entry_name,
        denotation: reader.text("Denotation"),
        object_type,
        data_type,
        access,
        default: None,
        low: None,
        high: None,
        pdo_mappable: reader.flag("PDOMapping"),
        flags: flags(reader),
        value: None,
        upload_file: reader.text("UploadFile"),
        download_file: reader.text("DownloadFile"),
        line: reader.section.line(),
        section: reader.section.index(),
    };
    entry.low = setting(reader, "LowLimit", data_type);
    entry.high = setting(reader, "HighLimit", data_type);
    entry.default = setting(reader, "DefaultValue", data_type);
    entry.value = setting(reader, "ParameterValue", data_type);
    check_limits(reader, &mut entry, node);
    Some(entry)
}

fn data_type(reader: &mut SectionReader<'_, '_>, object_type: ObjectType) -> Option<DataType> {
    let Some((key, text)) = reader.key("DataType") else {
        if object_type == ObjectType::Domain {
            return Some(DataType::Domain);
        }
        if !matches!(object_type, ObjectType::DefType | ObjectType::Other(_)) {
            let hint = "write DataType=0x0005 for UNSIGNED8, or what the device has";
            reader.say_here(Weight::Error, "has no DataType", hint);
        }
        return None;
    };
    if let Some(named) = DataType::ALL.iter().find(|known| known.to_string().eq_ignore_ascii_case(text)) {
        let hint = format!("write 0x{:04X}", named.code());
        reader.say(key, Weight::Warning, format!("`{}` is a word", shown(text)), hint);
        return Some(*named);
    }
    let code = reader.number_of(key, text, 0xFFFF, Weight::Error)?;
    u16::try_from(code).ok().map(DataType::from_code)
}

fn access(reader: &mut SectionReader<'_, '_>, object_type: ObjectType) -> Option<AccessType> {
    let names = || AccessType::ALL.map(AccessType::name).join(", ");
    let Some((key, text)) = reader.key("AccessType") else {
        return match object_type {
            // CiA 306: the default of a DOMAIN is rw.
            ObjectType::Domain => Some(AccessType::ReadWrite),
            ObjectType::DefType | ObjectType::Other(_) => Some(AccessType::ReadOnly),
            _ => {
                let hint = format!("write AccessType= and one of {}", names());
                reader.say_here(Weight::Error, "has no AccessType", hint);
                None
            }
        };
    };
    let text = text.split(';').next().unwrap_or_default().trim();
    let access = AccessType::ALL.into_iter().find(|access| access.name().eq_ignore_ascii_case(text));
    if access.is_none() {
        let hint = format!("it is one of {}", names());
        reader.say(key, Weight::Error, format!("there is no access type `{}`", shown(text)), hint);
    }
    access
}

/// The value of one of the four keys that hold one.
pub(crate) fn setting(reader: &mut SectionReader<'_, '_>, name: &str, data_type: DataType) -> Option<ValueSetting> {
    let (key, text) = reader.key(name)?;
    setting_of(reader, key, text, name, data_type)
}

/// The value of a key that was found, which is read like the key `role`.
pub(crate) fn setting_of(
    reader: &mut SectionReader<'_, '_>,
    key: IniKey,
    text: &str,
    role: &str,
    data_type: DataType,
) -> Option<ValueSetting> {
    let is_number = data_type.size().is_some();
    if key.commented && !is_number && role == "ParameterValue" {
        let hint = "write text without ` ;`, which begins a comment";
        reader.say(key, Weight::Warning, "what stands behind ` ;` is taken as a comment", hint);
    }
    let is_quoted = text.len() > 1 && text.starts_with('"') && text.ends_with('"');
    if is_quoted && role == "ParameterValue" && matches!(data_type, DataType::VisibleString | DataType::UnicodeString) {
        let hint = "remove them if they are not meant; other tools may leave them out";
        reader.say(key, Weight::Warning, "the quotation marks are part of the text", hint);
    }
    let text = if is_number { text.split(';').next().unwrap_or_default() } else { text };
    match value::read(text, data_type) {
        Ok((setting, is_octal)) => {
            if is_octal && let Some(value) = setting.value.whole() {
                reader.say_octal(key, text, value);
            }
            Some(setting)
        }
        Err(wrong) => {
            let weight = match role {
                "ParameterValue" => Weight::Error,
                "DefaultValue" if wrong.is_certain() => Weight::Error,
                _ => Weight::Warning,
            };
            reader.say(key, weight, wrong.to_string(), wrong.hint());
            None
        }
    }
}

/// A value beyond the limits will be refused by the device. Limits that contradict each other are none.
fn check_limits(reader: &mut SectionReader<'_, '_>, entry: &mut SubObject, node: NodeId) {
    let ends = entry.low.as_ref().zip(entry.high.as_ref());
    if let Some((low, high)) = ends.map(|(low, high)| (low.for_node(node), high.for_node(node)))
        && high.is_less(&low) == Some(true)
        && let Some((key, _)) = reader.key("HighLimit")
    {
        let message = format!("{high} is less than LowLimit, which is {low}; both are ignored");
        reader.say(key, Weight::Warning, message, "exchange or correct them");
        (entry.low, entry.high) = (None, None);
    }
    let both = [(&entry.default, "DefaultValue", Weight::Warning), (&entry.value, "ParameterValue", Weight::Error)];
    for (setting, name, weight) in both {
        let Some(value) = setting.as_ref().map(|setting| setting.for_node(node)) else { continue };
        if let Some((limit, end)) = entry.limit_broken(&value, node)
            && let Some((key, _)) = reader.key(name)
        {
            let message = format!("{value} is beyond {limit}, which is {end}");
            reader.say(key, weight, message, "correct the value or the limit");
        }
    }
}
