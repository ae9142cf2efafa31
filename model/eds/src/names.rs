//! Meaning of the name of a section, as CiA 306 spells it, in any case.

/// A list of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Category {
    /// `[MandatoryObjects]`: objects of every device.
    Mandatory,
    /// `[OptionalObjects]`: other objects of the standards.
    Optional,
    /// `[ManufacturerObjects]`: 2000h to 5FFFh.
    Manufacturer,
}

impl Category {
    /// All of them, in the order of a file.
    pub const ALL: [Category; 3] = [Category::Mandatory, Category::Optional, Category::Manufacturer];

    /// The section it is listed in.
    pub fn section(self) -> &'static str {
        match self {
            Category::Mandatory => "MandatoryObjects",
            Category::Optional => "OptionalObjects",
            Category::Manufacturer => "ManufacturerObjects",
        }
    }
}

/// Subject of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum SectionKind {
    FileInfo,
    DeviceInfo,
    Commissioning,
    DummyUsage,
    Comments,
    List(Category),
    Object(u16),
    Sub(u16, u8),
    /// `[1003Name]`, `[1003Denotation]` and `[1003Value]`: own data of elements of a compact array.
    Names(u16),
    Denotations(u16),
    Values(u16),
    /// Not of this crate: kept as it is.
    Unknown,
    /// Meant as an object or an element of one, but not understood.
    Garbled,
}

/// Meaning of the name of a section.
pub(crate) fn classify(name: &str) -> SectionKind {
    const NAMED: [(&str, SectionKind); 9] = [
        ("FileInfo", SectionKind::FileInfo),
        ("DeviceInfo", SectionKind::DeviceInfo),
        // Spelt so in the standard.
        ("DeviceComissioning", SectionKind::Commissioning),
        ("DeviceCommissioning", SectionKind::Commissioning),
        ("DummyUsage", SectionKind::DummyUsage),
        ("Comments", SectionKind::Comments),
        ("MandatoryObjects", SectionKind::List(Category::Mandatory)),
        ("OptionalObjects", SectionKind::List(Category::Optional)),
        ("ManufacturerObjects", SectionKind::List(Category::Manufacturer)),
    ];
    if let Some((_, kind)) = NAMED.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
        return *kind;
    }
    if name.starts_with("0x") || name.starts_with("0X") {
        return SectionKind::Garbled;
    }
    let Some((digits, rest)) = name.split_at_checked(4) else { return SectionKind::Unknown };
    let Some(index) = hex(digits).and_then(|index| u16::try_from(index).ok()) else { return SectionKind::Unknown };
    let rest = rest.trim_start();
    match rest.to_ascii_lowercase().as_str() {
        "" => return SectionKind::Object(index),
        "name" => return SectionKind::Names(index),
        "denotation" => return SectionKind::Denotations(index),
        "value" => return SectionKind::Values(index),
        _ => {}
    }
    match rest.split_at_checked(3) {
        Some((word, digits)) if word.eq_ignore_ascii_case("sub") => {
            match hex(digits.trim()).and_then(|sub| u8::try_from(sub).ok()) {
                Some(sub) => SectionKind::Sub(index, sub),
                None => SectionKind::Garbled,
            }
        }
        _ => SectionKind::Unknown,
    }
}

fn hex(digits: &str) -> Option<u32> {
    let all_are = !digits.is_empty() && digits.len() <= 8 && digits.chars().all(|c| c.is_ascii_hexdigit());
    if all_are { u32::from_str_radix(digits, 16).ok() } else { None }
}
