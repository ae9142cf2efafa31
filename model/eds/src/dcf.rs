//! From a description to the configuration of one device: the same text with values in it.
//!
//! The result is read again before it is handed out, and every value compared. A value that cannot be written in a
//! file, such as a text with a line end, is found there and not on the machine.

use std::collections::BTreeMap;
use std::fmt;

use linewright_diagnostics::{Problems, Report};

use crate::download::address;
use crate::edit::Editor;
use crate::ini::SectionRef;
use crate::names::{SectionKind, classify};
use crate::value::{self, NodeId, ObjectValue};
use crate::{AccessType, Eds, EncodeError, understand};

/// Values for one device of one net.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    pub node_id: NodeId,
    /// Its name.
    pub node_name: Option<String>,
    /// Bit rate of its bus, in kbit/s.
    pub baud_rate: Option<u16>,
    /// Its serial number, for LSS.
    pub serial_number: Option<u32>,
    /// Parameter values by index and subindex. What is not named keeps the value it has.
    pub values: BTreeMap<(u16, u8), ObjectValue>,
}

impl Configuration {
    /// A node id and nothing else.
    pub fn new(node_id: NodeId) -> Self {
        Configuration { node_id, node_name: None, baud_rate: None, serial_number: None, values: BTreeMap::new() }
    }

    pub fn set(mut self, index: u16, sub: u8, value: ObjectValue) -> Self {
        self.values.insert((index, sub), value);
        self
    }
}

/// Reason why a value cannot be part of a configuration.
#[derive(Clone, Debug, PartialEq)]
pub enum ConfigureError {
    /// The device has no such entry.
    NoEntry {
        index: u16,
        /// Subindex.
        sub: u8,
    },
    /// The entry cannot be written.
    NotWritable {
        index: u16,
        /// Subindex.
        sub: u8,
        /// ParameterName of the entry.
        name: String,
        access: AccessType,
    },
    /// The value is none of the entry's type.
    Encode {
        index: u16,
        /// Subindex.
        sub: u8,
        /// Error in the value.
        error: EncodeError,
    },
    /// The value is beyond a limit of the entry.
    Limit {
        index: u16,
        /// Subindex.
        sub: u8,
        value: ObjectValue,
        /// LowLimit or HighLimit.
        limit: &'static str,
        end: ObjectValue,
    },
    /// A text that cannot be written in a file of this kind: empty, with a line end, with spaces around it, or with
    /// ` ;`.
    NotSayable {
        /// Place where it was to stand.
        place: String,
        text: String,
    },
    /// The changed file would not be sound.
    File(Problems),
}

impl fmt::Display for ConfigureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ConfigureError::NoEntry { index, sub } => {
                write!(f, "{}: the description has no such entry", address(*index, *sub))
            }
            ConfigureError::NotWritable { index, sub, name, access } => {
                write!(f, "{} `{name}` cannot be written: it is {access}", address(*index, *sub))
            }
            ConfigureError::Encode { index, sub, error } => write!(f, "{}: {error}", address(*index, *sub)),
            ConfigureError::Limit { index, sub, value, limit, end } => {
                write!(f, "{}: {value} is beyond {limit}, which is {end}", address(*index, *sub))
            }
            ConfigureError::NotSayable { place, text } => {
                let hint = "nothing at all, line ends, spaces at its ends and ` ;` cannot be written";
                write!(f, "{place}: the text {text:?} has no form in a DCF; {hint}")
            }
            ConfigureError::File(problems) => write!(f, "{problems:#}"),
        }
    }
}

impl std::error::Error for ConfigureError {}

/// All reasons why a configuration is none.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigureErrors(pub Vec<ConfigureError>);

impl fmt::Display for ConfigureErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if at == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for ConfigureErrors {}

impl Eds {
    /// This description with the values of one device in it: a DCF called `file_name`. Order, comments and everything
    /// this crate does not support stay as they are.
    ///
    /// # Errors
    /// All values that the device cannot be given or a file cannot contain.
    pub fn configure(&self, file_name: &str, configuration: &Configuration) -> Result<Eds, ConfigureErrors> {
        let mut errors = self.check(configuration);
        if !errors.is_empty() {
            return Err(ConfigureErrors(errors));
        }
        let mut editor = Editor::new(&self.document);
        self.set_values(configuration, &mut editor);
        self.set_file_info(file_name, &mut editor);
        // Last: it may be a new section at the end, behind all that is added to the last one.
        let commissioning = commissioning(configuration);
        self.set_commissioning(&commissioning, &mut editor);
        let dcf = understand(file_name, editor.finish(), self.encoding, Report::of_excerpts());
        let dcf = dcf.map_err(|problems| ConfigureErrors(vec![ConfigureError::File(problems)]))?;
        errors.extend(dcf.said_otherwise(configuration, &commissioning));
        if errors.is_empty() { Ok(dcf) } else { Err(ConfigureErrors(errors)) }
    }

    fn check(&self, configuration: &Configuration) -> Vec<ConfigureError> {
        let mut errors = Vec::new();
        for (&(index, sub), value) in &configuration.values {
            let Some(entry) = self.entry(index, sub) else {
                errors.push(ConfigureError::NoEntry { index, sub });
                continue;
            };
            if !entry.access.is_writable() {
                let (name, access) = (entry.name.clone(), entry.access);
                errors.push(ConfigureError::NotWritable { index, sub, name, access });
            } else if let Err(error) = value::write(value, entry.data_type) {
                errors.push(ConfigureError::Encode { index, sub, error });
            } else if let Some((limit, end)) = entry.limit_broken(value, configuration.node_id) {
                errors.push(ConfigureError::Limit { index, sub, value: value.clone(), limit, end });
            } else if value_text(value).is_some_and(breaks_lines) {
                // Nothing of it may become a line of its own.
                errors.push(not_sayable(address(index, sub), value_text(value).unwrap_or_default()));
            }
        }
        for (key, text) in commissioning(configuration) {
            if breaks_lines(&text) {
                errors.push(not_sayable(key.to_owned(), &text));
            }
        }
        errors
    }

    fn set_values(&self, configuration: &Configuration, editor: &mut Editor<'_>) {
        let mut of_compact: BTreeMap<u16, Vec<(u8, String)>> = BTreeMap::new();
        for (&(index, sub), value) in &configuration.values {
            let Some((object, entry)) = self.object(index).zip(self.entry(index, sub)) else { continue };
            let Ok(text) = value::write(value, entry.data_type) else { continue };
            if object.subs.contains_key(&sub) {
                if let Some(section) = self.document.section(entry.section) {
                    editor.set(section, "ParameterValue", &text);
                }
            } else {
                of_compact.entry(index).or_default().push((sub, text));
            }
        }
        for (index, values) in of_compact {
            self.set_compact(index, &values, editor);
        }
    }

    /// Values of a compact array stand in a section of their own, which counts them.
    fn set_compact(&self, index: u16, values: &[(u8, String)], editor: &mut Editor<'_>) {
        let Some(section) = self.section_of(SectionKind::Values(index)) else {
            let Some(object) = self.object(index).and_then(|object| self.document.section(object.section)) else {
                return;
            };
            let names = self.section_of(SectionKind::Names(index));
            let mut lines = vec![String::new(), format!("[{index:04X}Value]"), format!("NrOfEntries={}", values.len())];
            lines.extend(values.iter().map(|(sub, text)| format!("{sub}={text}")));
            return editor.insert(names.unwrap_or(object).end(), &lines);
        };
        let mut count = section.keys().iter().filter(|key| is_number(section.str(key.key))).count();
        let mut added = Vec::new();
        for (sub, text) in values {
            let found = section.keys().iter().find(|key| section.str(key.key).parse() == Ok(*sub));
            match found {
                Some(key) => editor.replace(*key, text),
                None => added.push(format!("{sub}={text}")),
            }
        }
        count += added.len();
        editor.set(section, "NrOfEntries", &count.to_string());
        editor.insert(section.end(), &added);
    }

    fn set_commissioning(&self, values: &[(&'static str, String)], editor: &mut Editor<'_>) {
        match self.section_of(SectionKind::Commissioning) {
            Some(section) => {
                for (key, text) in values {
                    editor.set(section, key, text);
                }
            }
            None => {
                // Spelt so in the standard.
                let mut lines = vec![String::new(), "[DeviceComissioning]".to_owned()];
                lines.extend(values.iter().map(|(key, text)| format!("{key}={text}")));
                editor.insert(self.document.text.len(), &lines);
            }
        }
    }

    fn set_file_info(&self, file_name: &str, editor: &mut Editor<'_>) {
        let Some(section) = self.section_of(SectionKind::FileInfo) else { return };
        let last = |path: &str| path.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
        let names = [last(file_name), last(&self.file_name)];
        if names.iter().any(|name| breaks_lines(name)) {
            return;
        }
        editor.set(section, "FileName", &names[0]);
        if self.commissioning.is_none() {
            editor.set(section, "LastEDS", &names[1]);
        }
    }

    fn section_of(&self, kind: SectionKind) -> Option<SectionRef<'_>> {
        self.document.sections().find(|section| classify(section.name()) == kind)
    }

    /// Values read back that differ from those to be written.
    fn said_otherwise(&self, configuration: &Configuration, said: &[(&'static str, String)]) -> Vec<ConfigureError> {
        let mut errors = Vec::new();
        for (&(index, sub), value) in &configuration.values {
            let Some(entry) = self.entry(index, sub) else { continue };
            let read = entry.value_for(configuration.node_id).map(|value| entry.data_type.encode(&value));
            if read != Some(entry.data_type.encode(value)) {
                let text = value_text(value).map_or_else(|| value.to_string(), str::to_owned);
                errors.push(not_sayable(address(index, sub), &text));
            }
        }
        let section = self.section_of(SectionKind::Commissioning);
        for (key, text) in said {
            let read = section.and_then(|section| section.key(key).map(|key| section.str(key.value)));
            if read != Some(text) {
                errors.push(not_sayable((*key).to_owned(), text));
            }
        }
        errors
    }
}

fn commissioning(configuration: &Configuration) -> Vec<(&'static str, String)> {
    let mut values = vec![("NodeID", configuration.node_id.get().to_string())];
    values.extend(configuration.node_name.iter().map(|name| ("NodeName", name.clone())));
    values.extend(configuration.baud_rate.map(|rate| ("Baudrate", rate.to_string())));
    values.extend(configuration.serial_number.map(|number| ("LSS_SerialNumber", format!("0x{number:08X}"))));
    values
}

fn not_sayable(place: String, text: &str) -> ConfigureError {
    ConfigureError::NotSayable { place, text: text.to_owned() }
}

fn value_text(value: &ObjectValue) -> Option<&str> {
    match value {
        ObjectValue::Text(text) => Some(text),
        _ => None,
    }
}

fn breaks_lines(text: &str) -> bool {
    text.contains(['\n', '\r', '\0'])
}

fn is_number(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_digit())
}
