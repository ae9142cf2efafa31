//! `relations.toml` as written: every key that it may have.

use linewright_text::{
    Fields, Keys, Located, LocatedName, Named, Report, keys, one_of, tables, text, texts, texts_by_name, whole,
};

use crate::ComponentKind;

/// At most this many machines, zones, conditions and functions each.
const PARTS_MAX: usize = 200;
/// At most this many states of a component, and states of a condition.
const STATES_MAX: usize = 100;
/// At most this many products at once.
const PRODUCTS_MAX: i64 = 12;

/// Reads `text`; `None` when it is not TOML at all.
pub(super) fn read(text: &str, report: &mut Report) -> Option<RawRelations> {
    let document = linewright_text::document(text, report)?;
    Some(RawRelations::read_all(Fields::new(document.as_table(), 0..0, RawRelations::WHAT), report))
}

keys! {
    /// A cell whose order of work follows from relations of operations: its machines, zones and cycle start conditions. The tables
    /// beside this file are operations*.csv, relations*.csv, executions*.csv and interlocks*.csv.
    pub(super) struct RawRelations is "the description" {
        /// Name of the cell: one word of letters, digits, `_` and `-`, at most 64.
        name: Option<LocatedName> = text().required(),
        /// Title of the cell for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// Most products in the cell at once, 1 to 12; 1 if left out.
        products_max: i64 = whole(1, PRODUCTS_MAX).or(1),
        /// Machines, at most 200.
        machines as "machine": Vec<RawMachine> = tables(PARTS_MAX),
        /// Zones: volumes and passive resources that one machine at a time may have, at most 200.
        zones as "zone": Vec<RawZone> = tables(PARTS_MAX),
        /// Cycle start conditions, at most 200.
        conditions as "condition": Vec<RawCondition> = tables(PARTS_MAX),
        /// General functions of the cell, at most 200.
        functions as "function": Vec<RawFunction> = tables(PARTS_MAX),
    }

    /// A machine: a robot, a fixture, a turntable, an operator.
    pub(super) struct RawMachine is "a machine" {
        /// Its name: one word.
        name: Option<LocatedName> = text().required(),
        /// Title for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// Its components, at most 200; none where only the order of operations is described.
        components as "component": Vec<RawComponent> = tables(PARTS_MAX),
    }

    /// A component of a machine: what has a state of its own.
    pub(super) struct RawComponent is "a component" {
        /// Its name: one word.
        name: Option<LocatedName> = text().required(),
        /// Title for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// `actuator` or `variable` if executions order it, `sensor` if it only reports.
        kind: Option<Located<ComponentKind>> = one_of(&ComponentKind::ALL).required(),
        /// The states that it can be in, from two to 100, each one word.
        states: Option<Located<Vec<LocatedName>>> = texts(STATES_MAX).required(),
        /// Actuators and sensors that it consists of, as circuit diagrams name them, at most 100.
        subcomponents: Vec<LocatedName> = texts(STATES_MAX).entries(),
        /// The function block that controls it.
        block: Option<LocatedName> = text(),
    }

    /// A volume or passive resource that one machine at a time may have.
    pub(super) struct RawZone is "a zone" {
        /// Its name: one word, a number for instance.
        name: Option<LocatedName> = text().required(),
        /// Title for people; the name if left out.
        title: Option<LocatedName> = text(),
    }

    /// A cycle start condition: the situation in which a set of sequences is run.
    pub(super) struct RawCondition is "a condition" {
        /// Its name: one word.
        name: Option<LocatedName> = text().required(),
        /// Title for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// The product that is worked on.
        product: Option<LocatedName> = text(),
        /// The work cycle that the sequences are of, 1 to 100; 1 if left out.
        cycle: i64 = whole(1, 100).or(1),
        /// States that make it valid, all of them: `"MACHINE.component" = "state"`.
        states: Option<Named<LocatedName>> = texts_by_name(STATES_MAX),
    }

    /// A general function of the cell, which no machine has.
    pub(super) struct RawFunction is "a function" {
        /// Its name: one word.
        name: Option<LocatedName> = text().required(),
        /// Title for people; the name if left out.
        title: Option<LocatedName> = text(),
        /// The function block.
        block: Option<LocatedName> = text().required(),
    }
}
