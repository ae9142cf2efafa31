//! The words for faults in scenarios: those of `linewright fail`, from the same table.

use linewright_plant::{CLEAR_WORD, MotionFault};
use linewright_text::{Fields, KeyKind, KeyPresence, LocatedName, Property, Report, Shape};

/// A fault, or the end of any, and its mechanism.
pub(crate) type FaultOf = (Option<MotionFault>, LocatedName);

/// All words, with their faults; none for the end of a fault.
pub(crate) fn words() -> impl Iterator<Item = (&'static str, Option<MotionFault>)> {
    MotionFault::ALL.into_iter().map(|fault| (fault.name(), Some(fault))).chain([(CLEAR_WORD, None)])
}

/// The faults of a step.
pub(crate) fn read(fields: &mut Fields<'_>, report: &mut Report) -> Vec<FaultOf> {
    words().filter_map(|(word, fault)| Some((fault, fields.text(report, word)?))).collect()
}

/// A key for each word.
pub(crate) fn faults() -> KeyKind<Vec<FaultOf>> {
    let property = |(key, fault): (&'static str, Option<MotionFault>)| Property {
        key,
        doc: fault.map_or(&["All is well again."], MotionFault::about),
        shape: Shape::Text,
        presence: KeyPresence::Optional,
        usual: None,
    };
    KeyKind::new(|fields, report, _| read(fields, report), move || Shape::Part(words().map(property).collect()))
}
