//! Zones: which machine has one follows from how far its operations are.

use linewright_relations::{MachineId, ZoneId};

use super::{Draft, any};
use crate::model::{Mark, Predicate};

impl Draft<'_> {
    /// The machines that take a zone at any time.
    pub(super) fn machines_of(&self, zone: ZoneId) -> Vec<MachineId> {
        let takes = |place: &&super::Place<'_>| {
            place.choices.iter().any(|(_, row)| row.is_some_and(|row| row.zones_before.contains(&zone)))
        };
        let mut machines: Vec<MachineId> = self.places.iter().filter(takes).map(|place| place.machine).collect();
        machines.dedup();
        machines
    }

    /// That a machine has a zone: an operation that takes it is going on, or one that keeps it is finished, and the next one of
    /// that machine that takes it is not.
    pub(super) fn has_zone(&self, machine: MachineId, zone: ZoneId) -> Predicate {
        let takes = |place: &super::Place<'_>| {
            place.choices.iter().any(|(_, row)| row.is_some_and(|row| row.zones_before.contains(&zone)))
        };
        let places: Vec<_> = self.places.iter().filter(|place| place.machine == machine && takes(place)).collect();
        let mut parts = Vec::new();
        for (nth, place) in places.iter().enumerate() {
            for (of, row) in &place.choices {
                let Some(row) = row.filter(|row| row.zones_before.contains(&zone)) else { continue };
                parts.push(Predicate::executing(*of));
                if row.zones_after.contains(&zone) {
                    let next = places.get(nth + 1).map_or(Predicate::Const(false), |next| next.done());
                    parts.push(Predicate::All(vec![Predicate::Has(*of, Mark::Finished), next.negated()]));
                }
            }
        }
        any(parts)
    }
}
