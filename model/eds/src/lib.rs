//! CANopen device descriptions, EDS and DCF (CiA 306-1): read, with errors that have a line and a key, and written.
//!
//! An electronic data sheet lists the objects of a device. A device configuration file is the same with the values one
//! device of one net is to be given. [`read`] takes what tools write and warns with a place where it is sloppy; it
//! refuses what would leave open what a device is sent. [`Eds::to_bytes`] gives back every byte, and [`Eds::configure`]
//! makes a DCF of an EDS that differs from it in the values alone.
//!
//! The crate handles text and object dictionaries, not files, frames, or the purpose of an object, with two exceptions:
//! the identity of a device ([`Eds::identity`]), and that a PDO is switched off while it is changed
//! ([`Eds::downloads`]).
//!
//! ```
//! use linewright_eds::{Configuration, NodeId, ObjectValue, read};
//!
//! let text = "[DeviceInfo]\nVendorNumber=0x1F\n[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n\
//!     [OptionalObjects]\nSupportedObjects=1\n1=0x1017\n\
//!     [1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\nDefaultValue=0x30191\n\
//!     [1017]\nParameterName=Heartbeat time\nDataType=6\nAccessType=rw\nDefaultValue=0 ; off\n";
//! let eds = read("io.eds", text.as_bytes())?;
//! let node = NodeId::new(4).expect("1 to 127");
//! let device_type = eds.entry(0x1000, 0).expect("there is one");
//! assert_eq!(device_type.default_for(node), Some(ObjectValue::Unsigned(0x30191)));
//!
//! let dcf = eds.configure("io4.dcf", &Configuration::new(node).set(0x1017, 0, ObjectValue::Unsigned(50)))?;
//! assert_eq!(dcf.downloads(node)?[0].to_string(), "1017h: 32 00");
//!
//! let wrong = text.replace("DataType=6", "DataType=5").replace("DefaultValue=0 ; off", "DefaultValue=300");
//! let problems = read("io.eds", wrong.as_bytes()).unwrap_err();
//! assert_eq!(
//!     format!("{problems:#}"),
//!     "io.eds: 1 error\nio.eds:18:14: [1017] DefaultValue: `300` does not fit into UNSIGNED8"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How a file is read
//! 1. `decode`: bytes → text
//! 2. `ini`: text → sections and keys, as places in it
//! 3. `names`: what each section is about
//! 4. `info`, `objects` with `entry`: meaning of the sections
//! 5. `lists`: does what is listed agree with what is there?
//!
//! All problems of a file are reported at once.

mod data_type;
mod dcf;
mod decode;
mod download;
mod edit;
mod entry;
mod identity;
mod info;
mod ini;
pub mod limits;
mod lists;
mod model;
mod names;
mod number;
mod objects;
mod reader;
mod value;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::HashMap;

pub use data_type::{DataType, EncodeError, ValueDecodeError};
pub use dcf::{Configuration, ConfigureError, ConfigureErrors};
pub use download::{Download, DownloadContent, DownloadError, WriteReason};
pub use identity::EdsIdentity;
pub use info::{Commissioning, DeviceInfo, FileInfo};
pub use linewright_diagnostics::{Problem, Problems};
pub use model::{AccessType, Object, ObjectType, SubObject};
pub use names::Category;
pub use value::{NodeId, ObjectValue, ValueSetting};

use decode::TextEncoding;
use ini::{Document, SectionRef};
use linewright_diagnostics::{Report, shown};
use names::SectionKind;
use reader::{SectionReader, Weight};

/// A device description that was read.
#[derive(Clone, Debug)]
pub struct Eds {
    pub file: FileInfo,
    pub device: DeviceInfo,
    /// `[DeviceComissioning]`, of a DCF.
    pub commissioning: Option<Commissioning>,
    /// `[Comments]`, line by line.
    pub comments: Vec<String>,
    /// `[DummyUsage]`: the numbers of the types that may be mapped into an RPDO as a gap.
    pub dummies: Vec<u16>,
    file_name: String,
    encoding: TextEncoding,
    document: Document,
    objects: BTreeMap<u16, Object>,
    warnings: Problems,
}

/// Reads an EDS or a DCF. `file_name` is for messages.
///
/// # Errors
/// All problems of the file, each with its line and key; warnings among them. At most [`limits::PROBLEMS_MAX`] of each.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<Eds, Problems> {
    let mut report = Report::of_excerpts();
    match decode::decode(bytes, &mut report) {
        Ok((text, encoding)) => understand(file_name, text, encoding, report),
        Err(readable) => Err(report.into_problems(file_name, &readable)),
    }
}

fn understand(file_name: &str, text: String, encoding: TextEncoding, mut report: Report) -> Result<Eds, Problems> {
    let document = Document::new(text, &mut report);
    let sections = classify(&document, &mut report);
    let of_kind = |wanted: SectionKind| sections.iter().find(|(kind, _)| *kind == wanted).map(|(_, section)| *section);
    let file = of_kind(SectionKind::FileInfo).map(|section| FileInfo::read(&SectionReader::new(section, &mut report)));
    let device =
        of_kind(SectionKind::DeviceInfo).map(|section| DeviceInfo::read(&mut SectionReader::new(section, &mut report)));
    let device = device.unwrap_or_default();
    let commissioning = of_kind(SectionKind::Commissioning);
    let commissioning = commissioning.map(|section| Commissioning::read(&mut SectionReader::new(section, &mut report)));
    let comments =
        of_kind(SectionKind::Comments).map(|section| info::comments(&SectionReader::new(section, &mut report)));
    let dummies =
        of_kind(SectionKind::DummyUsage).map(|section| info::dummies(&mut SectionReader::new(section, &mut report)));
    let node = commissioning.as_ref().and_then(|commissioning| commissioning.node_id).unwrap_or(NodeId::FIRST);
    let mut objects = objects::read(&sections, node, &mut report);
    objects::check_elements(&objects, &document, &mut report);
    lists::check(&sections, &document, &mut objects, device.compact_pdo > 0, &mut report);
    identity::check(&device, &objects, &document, node, &mut report);
    if objects.is_empty() {
        let hint = "an EDS has sections such as [1000]; is this the right file?";
        report.add(Problem::error(0..0, "the file describes no object").hint(hint));
    }
    drop(sections);
    let is_sound = !report.has_errors();
    let warnings = report.into_problems(file_name, &document.text);
    if !is_sound {
        return Err(warnings);
    }
    Ok(Eds {
        file: file.unwrap_or_default(),
        device,
        commissioning,
        comments: comments.unwrap_or_default(),
        dummies: dummies.unwrap_or_default(),
        file_name: file_name.to_owned(),
        encoding,
        document,
        objects,
        warnings,
    })
}

/// Subject of each section. Of two about the same thing a program would take one by chance.
fn classify<'a>(document: &'a Document, report: &mut Report) -> Vec<(SectionKind, SectionRef<'a>)> {
    let mut sections = Vec::new();
    let mut first: HashMap<SectionKind, SectionRef<'a>> = HashMap::new();
    for section in document.sections() {
        let kind = names::classify(section.name());
        match kind {
            SectionKind::Unknown => continue,
            SectionKind::Garbled => {
                let message = "looks like an object, but its index or subindex is not understood";
                SectionReader::new(section, report).say_here(
                    Weight::Error,
                    message,
                    "write it as [1018] or [1018sub1]",
                );
                continue;
            }
            _ => {}
        }
        if let Some(before) = first.get(&kind) {
            let message = format!("[{}] occurs twice", shown(section.name()));
            let finding = Problem::error(section.at(), message).hint("remove one of them, or put both together");
            report.add(finding.earlier(before.at()));
            continue;
        }
        first.insert(kind, section);
        section.check_twice(report);
        sections.push((kind, section));
    }
    sections
}

impl Eds {
    /// The name the file was read by.
    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    /// Warnings about the file.
    pub fn warnings(&self) -> &Problems {
        &self.warnings
    }

    /// The file, byte for byte.
    pub fn to_bytes(&self) -> Vec<u8> {
        decode::encode(&self.document.text, self.encoding)
    }

    pub fn object(&self, index: u16) -> Option<&Object> {
        self.objects.get(&index)
    }

    /// All objects, by index.
    pub fn objects(&self) -> impl Iterator<Item = &Object> {
        self.objects.values()
    }

    /// The entry with this index and subindex; a single value has subindex 0.
    pub fn entry(&self, index: u16, sub: u8) -> Option<Cow<'_, SubObject>> {
        self.objects.get(&index)?.entry(sub)
    }

    /// All entries with index and subindex, in order. Those of compact arrays are made one by one.
    pub fn entries(&self) -> impl Iterator<Item = (u16, u8, Cow<'_, SubObject>)> {
        self.objects.values().flat_map(|object| object.entries().map(|(sub, entry)| (object.index, sub, entry)))
    }

    /// The node id a DCF is for.
    pub fn node_id(&self) -> Option<NodeId> {
        self.commissioning.as_ref().and_then(|commissioning| commissioning.node_id)
    }
}
