//! A type of like stations: the keys of a station, with parameters in braces, and what stands beside each of them.
//!
//! The keys of a type are read in the stations that are of it; here they are for the schema.

use linewright_text::{KeyPresence, Keys, LocatedName, Property, Shape, keys, tables, text, texts};

use super::handling::RawSensor;
use super::line::{ARROWS_MAX, CONFLICTS_MAX, DEVICES_MAX, SENSORS_MAX};
use super::{RawArrow, RawConflict, RawDevice, RawStation};

/// At most this many types.
pub(super) const TYPES_MAX: usize = 100;
/// At most this many parameters of a type.
pub(in crate::parse) const TYPE_PARAMETERS_MAX: usize = 64;

/// A text that is a parameter alone.
const PARAMETER: &str = "^\\{[^{}]+\\}$";

keys! {
    /// A station type: the keys of `[[station]]`, and arrows, conflicts, devices and sensors that come with each
    /// station of the type. In a text `{name}` is the station's name, `{other}` the value that the station gives to the
    /// parameter `other`; a text that is a parameter alone becomes its value, text or number. A literal brace is
    /// written twice.
    pub(in crate::parse) struct RawStationType is "a station type" {
        /// Name, to which `type` of a station refers; unique.
        name: Option<LocatedName> = text().required(),
        /// Names of its parameters besides `name`, at most 64.
        parameters: Vec<LocatedName> = texts(TYPE_PARAMETERS_MAX).entries(),
    }

    /// What comes with a station of a type.
    struct RawBeside is "a station type" {
        /// Arrows that come with each station of the type.
        arrows as "arrow": Vec<RawArrow> = tables(ARROWS_MAX),
        /// Conflicts that come with each station of the type.
        conflicts as "conflict": Vec<RawConflict> = tables(CONFLICTS_MAX),
        /// Devices that come with each station of the type.
        devices as "device": Vec<RawDevice> = tables(DEVICES_MAX),
        /// Sensors that come with each station of the type.
        sensors as "sensor": Vec<RawSensor> = tables(SENSORS_MAX),
    }
}

/// Shape of a list of types.
pub(super) fn shape() -> Shape {
    let mut keys = RawStationType::keys();
    let others = RawStation::keys().into_iter().filter(|key| !["name", "type", "parameters"].contains(&key.key));
    keys.extend(others.chain(RawBeside::keys()).map(|key| Property {
        // A key may stand in each station instead.
        presence: KeyPresence::Optional,
        shape: with_parameters(key.shape),
        ..key
    }));
    Shape::List(Box::new(Shape::Table(RawStationType::DOC, keys)), TYPES_MAX)
}

/// The same, with a parameter in the place of any value.
fn with_parameters(shape: Shape) -> Shape {
    let inside = |keys: Vec<Property>| {
        let keys = keys.into_iter().map(|key| Property { shape: with_parameters(key.shape), ..key });
        keys.collect::<Vec<_>>()
    };
    match shape {
        Shape::Text => Shape::Text,
        Shape::List(entry, most) => Shape::List(Box::new(with_parameters(*entry)), most),
        Shape::Names(entry, most) => Shape::Names(Box::new(with_parameters(*entry)), most),
        Shape::Table(doc, keys) => Shape::Table(doc, inside(keys)),
        Shape::Part(keys) => Shape::Part(inside(keys)),
        Shape::Either(shapes) => Shape::Either(shapes.into_iter().map(with_parameters).collect()),
        value @ (Shape::Like(_) | Shape::Word(_) | Shape::Flag | Shape::Whole(..) | Shape::Number(..)) => {
            Shape::Either(vec![value, Shape::Like(PARAMETER)])
        }
    }
}
