//! All object sections → the object dictionary.

use std::collections::BTreeMap;

use linewright_diagnostics::{Report, shown};

use crate::entry;
use crate::ini::{Document, SectionRef};
use crate::limits::COMPACT_MAX;
use crate::model::{Compact, Object, ObjectType};
use crate::names::SectionKind;
use crate::reader::{SectionReader, Weight};
use crate::value::NodeId;

/// Sections with the meanings of their names.
pub(crate) type Classified<'a> = [(SectionKind, SectionRef<'a>)];

/// Reads all objects. Limits that depend on the node id are checked with `node`.
pub(crate) fn read(sections: &Classified<'_>, node: NodeId, report: &mut Report) -> BTreeMap<u16, Object> {
    let mut objects = BTreeMap::new();
    for &(kind, section) in sections {
        if let SectionKind::Object(index) = kind {
            objects.insert(index, object(index, &mut SectionReader::new(section, report), node));
        }
    }
    for &(kind, section) in sections {
        if let SectionKind::Sub(index, sub) = kind {
            element(&mut objects, (index, sub), &mut SectionReader::new(section, report), node);
        }
    }
    for &(kind, section) in sections {
        if let SectionKind::Names(index) | SectionKind::Denotations(index) | SectionKind::Values(index) = kind {
            of_compact(&mut objects, index, kind, &mut SectionReader::new(section, report), node);
        }
    }
    objects
}

/// Checks that need all sections: whether arrays and records have their elements.
pub(crate) fn check_elements(objects: &BTreeMap<u16, Object>, document: &Document, report: &mut Report) {
    for object in objects.values().filter(|object| !object.is_implied) {
        let Some(section) = document.section(object.section) else { continue };
        let mut reader = SectionReader::new(section, report);
        let described = usize::from(object.described);
        let is_explicit = object.object_type.has_subs() && object.compact.is_none();
        match reader.key("SubNumber").zip(object.sub_number) {
            Some(((key, _), number)) if is_explicit && usize::from(number) != described => {
                let message = format!("it says {number}, but the file describes {described}");
                let hint = "correct the number, or find what is missing or too much";
                // Tools mean the number of elements, or the highest one; each is described by itself anyway.
                reader.say(key, Weight::Warning, message, hint);
            }
            None if is_explicit && described > 0 => {
                let hint = format!("write SubNumber={described}");
                reader.say_here(Weight::Warning, "has elements and no SubNumber", hint);
            }
            _ if is_explicit && described == 0 => {
                let hint = "describe its elements, or say with CompactSubObj how many of one kind there are";
                reader.say_here(Weight::Warning, "is an array or record without elements", hint);
            }
            _ => {}
        }
    }
}

fn object(index: u16, reader: &mut SectionReader<'_, '_>, node: NodeId) -> Object {
    let object_type = entry::object_type(reader);
    let compact_count = compact_count(reader, object_type);
    let mut object = Object {
        index,
        name: String::new(),
        denotation: reader.text("Denotation"),
        object_type,
        category: None,
        flags: 0,
        line: reader.section.line(),
        section: reader.section.index(),
        sub_number: reader.number("SubNumber", 255, Weight::Warning).and_then(|number| u8::try_from(number).ok()),
        described: 0,
        is_implied: false,
        subs: BTreeMap::new(),
        compact: None,
    };
    if compact_count > 0 && is_uniform(object_type) {
        let template = entry::read(reader, ObjectType::Var, node);
        object.name = reader.text("ParameterName").unwrap_or_default();
        object.compact = template.map(|template| Compact {
            count: compact_count,
            template,
            names: BTreeMap::new(),
            denotations: BTreeMap::new(),
            values: BTreeMap::new(),
        });
    } else if object_type.has_subs() {
        object.name = entry::name(reader);
        object.flags = entry::flags(reader);
    } else if let Some(entry) = entry::read(reader, object_type, node) {
        object.name = entry.name.clone();
        object.flags = entry.flags;
        object.subs.insert(0, entry);
    }
    object
}

fn compact_count(reader: &mut SectionReader<'_, '_>, object_type: ObjectType) -> u8 {
    let Some((key, text)) = reader.key("CompactSubObj") else { return 0 };
    let count = reader.number_of(key, text, COMPACT_MAX.into(), Weight::Error);
    let count = count.and_then(|count| u8::try_from(count).ok()).unwrap_or_default();
    if count > 0 && !is_uniform(object_type) {
        let message = "only an array or a record has elements";
        reader.say(key, Weight::Error, message, "write ObjectType=0x8, or remove it");
    }
    count
}

/// Whether CompactSubObj may describe it. The standard has arrays; tools write the mappings of PDOs, which are records
/// of one type, in this way as well.
fn is_uniform(object_type: ObjectType) -> bool {
    matches!(object_type, ObjectType::Array | ObjectType::Record)
}

fn element(
    objects: &mut BTreeMap<u16, Object>,
    (index, sub): (u16, u8),
    reader: &mut SectionReader<'_, '_>,
    node: NodeId,
) {
    let object_type = entry::object_type(reader);
    let entry = entry::read(reader, object_type, node);
    let mut is_orphan = false;
    let object = objects.entry(index).or_insert_with(|| {
        is_orphan = true;
        Object {
            index,
            name: String::new(),
            denotation: None,
            object_type: ObjectType::Record,
            category: None,
            flags: 0,
            line: reader.section.line(),
            section: reader.section.index(),
            sub_number: None,
            described: 0,
            is_implied: true,
            subs: BTreeMap::new(),
            compact: None,
        }
    });
    if is_orphan {
        let message = format!("is an element, but there is no section [{index:04X}]");
        let hint = format!("write [{index:04X}] before it, with ParameterName, ObjectType and SubNumber");
        reader.say_here(Weight::Warning, message, hint);
    } else if !object.object_type.has_subs()
        && !matches!(object.object_type, ObjectType::Other(_) | ObjectType::DefType)
    {
        let message = format!("is an element of [{index:04X}], which is a single value");
        reader.say_here(Weight::Error, message, "correct the ObjectType of one of them: 0x8 is ARRAY, 0x9 RECORD");
        return;
    }
    if object.compact.as_ref().is_some_and(|compact| sub > 0 && sub <= compact.count) {
        let message = format!("describes what CompactSubObj of [{index:04X}] has described already; this is taken");
        reader.say_here(Weight::Warning, message, "remove one of them");
    }
    object.described = object.described.saturating_add(1);
    if let Some(entry) = entry {
        object.subs.insert(sub, entry);
    }
}

/// `[1003Name]` and the like: own data of elements of a compact array.
fn of_compact(
    objects: &mut BTreeMap<u16, Object>,
    index: u16,
    kind: SectionKind,
    reader: &mut SectionReader<'_, '_>,
    node: NodeId,
) {
    let Some(compact) = objects.get_mut(&index).and_then(|object| object.compact.as_mut()) else {
        let message = format!("belongs to an array with CompactSubObj, which [{index:04X}] is not");
        // A name is only a name, but a value is lost.
        let weight = if matches!(kind, SectionKind::Values(_)) { Weight::Error } else { Weight::Warning };
        return reader.say_here(weight, message, format!("write CompactSubObj in [{index:04X}], or remove this"));
    };
    for (number, key, text) in reader.numbered("NrOfEntries") {
        let Some(sub) = u8::try_from(number).ok().filter(|sub| (1..=compact.count).contains(sub)) else {
            let message = format!("there is no element {number}; CompactSubObj says {}", compact.count);
            reader.say(key, Weight::Error, message, "correct the number, or CompactSubObj");
            continue;
        };
        match kind {
            SectionKind::Names(_) => drop(compact.names.insert(sub, text.to_owned())),
            SectionKind::Denotations(_) => drop(compact.denotations.insert(sub, text.to_owned())),
            _ if text.is_empty() => {}
            _ => {
                let template = &compact.template;
                let setting = entry::setting_of(reader, key, text, "ParameterValue", template.data_type);
                let Some(setting) = setting else { continue };
                let value = setting.for_node(node);
                if let Some((limit, end)) = template.limit_broken(&value, node) {
                    let message = format!("{} is beyond {limit}, which is {end}", shown(&value.to_string()));
                    reader.say(key, Weight::Error, message, "correct the value or the limit");
                }
                compact.values.insert(sub, setting);
            }
        }
    }
}
