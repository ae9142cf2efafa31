//! Description of a device's objects.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use crate::data_type::DataType;
use crate::names::Category;
use crate::value::{NodeId, ObjectValue, ValueSetting};

/// Kind of an object (CiA 301 §7.4.3, table 42).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObjectType {
    /// 0: an entry without data.
    Null,
    /// 2: bytes of any length, such as a program.
    Domain,
    /// 5: a type.
    DefType,
    /// 6: a record type.
    DefStruct,
    /// 7: one value.
    Var,
    /// 8: elements of one type.
    Array,
    /// 9: elements of several types.
    Record,
    /// Another one.
    Other(u8),
}

impl ObjectType {
    pub(crate) fn from_code(code: u8) -> Self {
        match code {
            0 => ObjectType::Null,
            2 => ObjectType::Domain,
            5 => ObjectType::DefType,
            6 => ObjectType::DefStruct,
            7 => ObjectType::Var,
            8 => ObjectType::Array,
            9 => ObjectType::Record,
            other => ObjectType::Other(other),
        }
    }

    /// Whether it has elements with subindices.
    pub fn has_subs(self) -> bool {
        matches!(self, ObjectType::Array | ObjectType::Record | ObjectType::DefStruct)
    }
}

/// Permitted access to an entry (CiA 306, AccessType).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AccessType {
    /// `ro`: may only be read.
    ReadOnly,
    /// `wo`: may only be written.
    WriteOnly,
    /// `rw`: may be read and written.
    ReadWrite,
    /// `rwr`: as `rw`, and goes from the device into a TPDO.
    ReadWriteInput,
    /// `rww`: as `rw`, and comes to the device in an RPDO.
    ReadWriteOutput,
    /// `const`: may only be read and never changes.
    Const,
}

impl AccessType {
    pub(crate) const ALL: [AccessType; 6] = [
        AccessType::ReadOnly,
        AccessType::WriteOnly,
        AccessType::ReadWrite,
        AccessType::ReadWriteInput,
        AccessType::ReadWriteOutput,
        AccessType::Const,
    ];

    /// Name in a file.
    pub fn name(self) -> &'static str {
        match self {
            AccessType::ReadOnly => "ro",
            AccessType::WriteOnly => "wo",
            AccessType::ReadWrite => "rw",
            AccessType::ReadWriteInput => "rwr",
            AccessType::ReadWriteOutput => "rww",
            AccessType::Const => "const",
        }
    }

    /// Whether an SDO may write it.
    pub fn is_writable(self) -> bool {
        !matches!(self, AccessType::ReadOnly | AccessType::Const)
    }

    /// Whether an SDO may read it.
    pub fn is_readable(self) -> bool {
        self != AccessType::WriteOnly
    }
}

impl fmt::Display for AccessType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One value of a device, at an index and a subindex.
#[derive(Clone, Debug)]
pub struct SubObject {
    /// ParameterName.
    pub name: String,
    /// Denotation: the plant's name for it (DCF).
    pub denotation: Option<String>,
    /// ObjectType, nearly always [`ObjectType::Var`].
    pub object_type: ObjectType,
    pub data_type: DataType,
    pub access: AccessType,
    /// DefaultValue: value of the device after switching on, if the file has it.
    pub default: Option<ValueSetting>,
    /// LowLimit.
    pub low: Option<ValueSetting>,
    /// HighLimit.
    pub high: Option<ValueSetting>,
    /// PDOMapping: whether it may be mapped into a PDO.
    pub pdo_mappable: bool,
    /// ObjFlags; see [`SubObject::refuses_download`].
    pub flags: u32,
    /// ParameterValue: the device's value to be set (DCF).
    pub value: Option<ValueSetting>,
    /// UploadFile: where its content is to be put, for a DOMAIN (DCF).
    pub upload_file: Option<String>,
    /// DownloadFile: where its content is, for a DOMAIN (DCF).
    pub download_file: Option<String>,
    /// The line of its section in the file, from 1.
    pub line: u32,
    /// The number of that section.
    pub(crate) section: u32,
}

impl SubObject {
    pub fn default_for(&self, node: NodeId) -> Option<ObjectValue> {
        self.default.as_ref().map(|setting| setting.for_node(node))
    }

    /// Its parameter value for this node id.
    pub fn value_for(&self, node: NodeId) -> Option<ObjectValue> {
        self.value.as_ref().map(|setting| setting.for_node(node))
    }

    /// Value of the device when it is configured: the parameter value, or else the default.
    pub fn effective(&self, node: NodeId) -> Option<ObjectValue> {
        self.value_for(node).or_else(|| self.default_for(node))
    }

    /// ObjFlags bit 0: a configuration is not to write it.
    pub fn refuses_download(&self) -> bool {
        self.flags & 1 != 0
    }

    /// The limit a value is beyond, if it is.
    pub fn limit_broken(&self, value: &ObjectValue, node: NodeId) -> Option<(&'static str, ObjectValue)> {
        let low = self.low.as_ref().map(|low| low.for_node(node));
        if let Some(low) = low.filter(|low| value.is_less(low) == Some(true) || value.is_no_number()) {
            return Some(("LowLimit", low));
        }
        let high = self.high.as_ref().map(|high| high.for_node(node));
        high.filter(|high| high.is_less(value) == Some(true) || value.is_no_number()).map(|high| ("HighLimit", high))
    }
}

/// A compact array: one description for all its elements (CompactSubObj).
#[derive(Clone, Debug)]
pub(crate) struct Compact {
    pub count: u8,
    pub template: SubObject,
    pub names: BTreeMap<u8, String>,
    pub denotations: BTreeMap<u8, String>,
    pub values: BTreeMap<u8, ValueSetting>,
}

/// One object, at an index.
#[derive(Clone, Debug)]
pub struct Object {
    pub index: u16,
    /// ParameterName.
    pub name: String,
    /// Denotation (DCF).
    pub denotation: Option<String>,
    pub object_type: ObjectType,
    /// The list it stands in, if in any.
    pub category: Option<Category>,
    /// ObjFlags.
    pub flags: u32,
    /// The line of its section in the file, from 1.
    pub line: u32,
    pub(crate) section: u32,
    pub(crate) sub_number: Option<u8>,
    /// Number of sections that describe elements, those with errors included.
    pub(crate) described: u16,
    /// Only elements of it are in the file; its section is that of the first one.
    pub(crate) is_implied: bool,
    /// Its elements, or of an object without any its value as element 0.
    pub(crate) subs: BTreeMap<u8, SubObject>,
    pub(crate) compact: Option<Compact>,
}

impl Object {
    /// The entry with this subindex; a single value has subindex 0.
    pub fn entry(&self, sub: u8) -> Option<Cow<'_, SubObject>> {
        match self.subs.get(&sub) {
            Some(entry) => Some(Cow::Borrowed(entry)),
            None => self.compact.as_ref()?.entry(sub).map(Cow::Owned),
        }
    }

    /// Its entries with their subindices, in order. Those of a compact array are made one by one.
    pub fn entries(&self) -> impl Iterator<Item = (u8, Cow<'_, SubObject>)> {
        let last_compact = self.compact.as_ref().map(|compact| compact.count);
        let last = self.subs.last_key_value().map(|(sub, _)| *sub).max(last_compact);
        let all = last.map(|last| 0..=last).into_iter().flatten();
        all.filter_map(|sub| self.entry(sub).map(|entry| (sub, entry)))
    }
}

impl Compact {
    fn entry(&self, sub: u8) -> Option<SubObject> {
        if sub > self.count {
            return None;
        }
        let template = &self.template;
        if sub == 0 {
            // CiA 306: the number of elements is constant and described by nothing but CompactSubObj.
            return Some(SubObject {
                name: "NrOfObjects".to_owned(),
                denotation: None,
                object_type: ObjectType::Var,
                data_type: DataType::Unsigned8,
                access: AccessType::ReadOnly,
                default: Some(ValueSetting::fixed(ObjectValue::Unsigned(self.count.into()))),
                low: None,
                high: None,
                pdo_mappable: false,
                flags: 0,
                value: None,
                upload_file: None,
                download_file: None,
                line: template.line,
                section: template.section,
            });
        }
        Some(SubObject {
            name: self.names.get(&sub).cloned().unwrap_or_else(|| format!("{}{sub}", template.name)),
            denotation: self.denotations.get(&sub).cloned(),
            value: self.values.get(&sub).or(template.value.as_ref()).cloned(),
            ..template.clone()
        })
    }
}
