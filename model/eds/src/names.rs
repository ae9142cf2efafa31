//! What the name of a section says, as CiA 306 spells it, in any case.

/// A list of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Category {
    /// `[MandatoryObjects]`: what every device has.
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

/// What a section is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    FileInfo,
    DeviceInfo,
    Commissioning,
    DummyUsage,
    Comments,
    List(Category),
    Object(u16),
    Sub(u16, u8),
    /// `[1003Name]`, `[1003Denotation]` and `[1003Value]`: what elements of a compact array have of their own.
    Names(u16),
    Denotations(u16),
    Values(u16),
    /// Not of this crate: kept as it is.
    Unknown,
    /// Meant as an object or an element of one, but not understood.
    Garbled,
}

/// What the name of a section says.
pub(crate) fn classify(name: &str) -> Kind {
    const NAMED: [(&str, Kind); 9] = [
        ("FileInfo", Kind::FileInfo),
        ("DeviceInfo", Kind::DeviceInfo),
        // Spelt so in the standard.
        ("DeviceComissioning", Kind::Commissioning),
        ("DeviceCommissioning", Kind::Commissioning),
        ("DummyUsage", Kind::DummyUsage),
        ("Comments", Kind::Comments),
        ("MandatoryObjects", Kind::List(Category::Mandatory)),
        ("OptionalObjects", Kind::List(Category::Optional)),
        ("ManufacturerObjects", Kind::List(Category::Manufacturer)),
    ];
    if let Some((_, kind)) = NAMED.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
        return *kind;
    }
    if name.starts_with("0x") || name.starts_with("0X") {
        return Kind::Garbled;
    }
    let Some((digits, rest)) = name.split_at_checked(4) else { return Kind::Unknown };
    let Some(index) = hex(digits).and_then(|index| u16::try_from(index).ok()) else { return Kind::Unknown };
    let rest = rest.trim_start();
    match rest.to_ascii_lowercase().as_str() {
        "" => return Kind::Object(index),
        "name" => return Kind::Names(index),
        "denotation" => return Kind::Denotations(index),
        "value" => return Kind::Values(index),
        _ => {}
    }
    match rest.split_at_checked(3) {
        Some((word, digits)) if word.eq_ignore_ascii_case("sub") => {
            match hex(digits.trim()).and_then(|sub| u8::try_from(sub).ok()) {
                Some(sub) => Kind::Sub(index, sub),
                None => Kind::Garbled,
            }
        }
        _ => Kind::Unknown,
    }
}

fn hex(digits: &str) -> Option<u32> {
    let all_are = !digits.is_empty() && digits.len() <= 8 && digits.chars().all(|c| c.is_ascii_hexdigit());
    if all_are { u32::from_str_radix(digits, 16).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_any_case() {
        for (name, expected) in [
            ("fileinfo", Kind::FileInfo),
            ("DEVICECOMMISSIONING", Kind::Commissioning),
            ("DeviceComissioning", Kind::Commissioning),
            ("1018", Kind::Object(0x1018)),
            ("1A00", Kind::Object(0x1A00)),
            ("1a00SUBa", Kind::Sub(0x1A00, 10)),
            ("1A00sub0A", Kind::Sub(0x1A00, 10)),
            ("6000 sub 1", Kind::Sub(0x6000, 1)),
            ("1003Name", Kind::Names(0x1003)),
            ("1003value", Kind::Values(0x1003)),
            ("1003Denotation", Kind::Denotations(0x1003)),
            ("1003ObjectLinks", Kind::Unknown),
            ("M1SubExt6000", Kind::Unknown),
            ("Tools", Kind::Unknown),
            ("A0", Kind::Unknown),
            ("", Kind::Unknown),
            ("1018sub", Kind::Garbled),
            ("1018sub1FF", Kind::Garbled),
            ("1018sub0x1", Kind::Garbled),
            ("0x1018", Kind::Garbled),
            ("101ü", Kind::Unknown),
        ] {
            assert_eq!(classify(name), expected, "{name}");
        }
    }
}
