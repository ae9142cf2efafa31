//! The lists of objects, held against the objects there are.

use std::collections::BTreeMap;

use linewright_diagnostics::Report;

use crate::ini::Document;
use crate::model::Object;
use crate::names::{Category, SectionKind};
use crate::objects::Classified;
use crate::reader::{SectionReader, Weight};

/// The PDO objects, which a file with CompactPDO need not describe.
const PDO_OBJECTS: std::ops::RangeInclusive<u16> = 0x1400..=0x1BFF;

/// Gives every object the list it stands in, and reports what is listed and not there, or there and not listed.
pub(crate) fn check(
    sections: &Classified<'_>,
    document: &Document,
    objects: &mut BTreeMap<u16, Object>,
    has_compact_pdo: bool,
    report: &mut Report,
) {
    let mut has_lists = [false; 3];
    for &(kind, section) in sections {
        let SectionKind::List(category) = kind else { continue };
        has_lists[category as usize] = true;
        list(category, &mut SectionReader::new(section, report), objects, has_compact_pdo);
    }
    if !has_lists[Category::Mandatory as usize]
        && let Some(first) = document.sections().next()
    {
        let mut reader = SectionReader::new(first, report);
        let hint = "this may be no EDS, or part of one";
        reader.say_here(Weight::Warning, "begins a file without [MandatoryObjects]", hint);
    }
    if has_lists == [false; 3] {
        return;
    }
    // Below 1000h are types, which are not listed.
    for object in
        objects.values().filter(|object| object.category.is_none() && !object.is_implied && object.index >= 0x1000)
    {
        let Some(section) = document.section(object.section) else { continue };
        let expected = expected(object.index);
        let hint = format!("add it to [{}] and count it in SupportedObjects", expected.section());
        SectionReader::new(section, report).say_here(Weight::Warning, "stands in none of the lists of objects", hint);
    }
}

/// List of an object by CiA 306.
fn expected(index: u16) -> Category {
    match index {
        0x1000 | 0x1001 | 0x1018 => Category::Mandatory,
        0x2000..=0x5FFF => Category::Manufacturer,
        _ => Category::Optional,
    }
}

fn list(
    category: Category,
    reader: &mut SectionReader<'_, '_>,
    objects: &mut BTreeMap<u16, Object>,
    has_compact_pdo: bool,
) {
    let found = reader.numbered("SupportedObjects");
    for (position, (number, key, _)) in found.iter().enumerate() {
        if *number != position as u64 + 1 {
            let message = format!("{} is expected here", position + 1);
            reader.say(*key, Weight::Warning, message, "number the objects 1, 2, 3 and so on");
            // One wrong number makes all after it wrong.
            break;
        }
    }
    for (_, key, text) in found {
        let Some(index) = reader.number_of(key, text, 0xFFFF, Weight::Error) else { continue };
        let index = u16::try_from(index).unwrap_or_default();
        let Some(object) = objects.get_mut(&index) else {
            if has_compact_pdo && PDO_OBJECTS.contains(&index) {
                continue;
            }
            let message = format!("there is no section [{index:04X}]");
            reader.say(key, Weight::Error, message, "describe the object, or take it off the list");
            continue;
        };
        if let Some(before) = object.category {
            let message = format!("the object 0x{index:04X} is listed twice, first in [{}]", before.section());
            reader.say(key, Weight::Warning, message, "remove one of them and correct SupportedObjects");
            continue;
        }
        if expected(index) != category && !(category == Category::Optional && index == 0x1018) {
            let message = format!("the object 0x{index:04X} belongs into [{}]", expected(index).section());
            reader.say(key, Weight::Warning, message, "move it, and correct both SupportedObjects");
        }
        object.category = Some(category);
    }
}
