//! What synthesis has found, in the terms of planners.

use linewright_relations::{InterlockedAction, MachineId, MachineSequence, Precondition, Relations};

use crate::cops::CoordinatedStep;
use crate::guard::{AddedGuard, MarkValue};
use crate::lock::{Trap, WaitingMachine};
use crate::model::{Composition, Mark, Nth, Restriction};

/// Texts about a cell with some products in it.
#[derive(Clone, Copy)]
pub struct Texts<'a> {
    pub relations: &'a Relations,
    pub composition: &'a Composition,
}

impl Texts<'_> {
    /// An operation on a product: `56(P1)`; with its way where it has several.
    pub fn operation(&self, of: Nth) -> String {
        let operation = &self.composition.operations[of];
        let ids = operation.operations.iter().map(|id| self.relations.operation(*id).id.as_str());
        let way = operation.way.as_ref().map_or_else(String::new, |way| format!("/{way}"));
        let ids = ids.collect::<Vec<_>>().join("+");
        let left_out = if operation.is_left_out { " left out" } else { "" };
        format!("{ids}{way}(P{}){left_out}", operation.instance + 1)
    }

    /// The same, with what it is: `56(P1) leave gripper`.
    pub fn operation_with_comment(&self, of: Nth) -> String {
        let id = self.composition.operations[of].operations[0];
        let comment = &self.relations.operation(id).comment;
        let comment = if comment.is_empty() { String::new() } else { format!(" {comment}") };
        format!("{}{comment}", self.operation(of))
    }

    fn machine(&self, of: MachineId) -> &str {
        &self.relations.machine(of).name
    }

    fn value(&self, value: &MarkValue) -> String {
        let name = self.operation(value.of);
        let word = match value.mark {
            Mark::Chosen => "chosen",
            Mark::Started => "started",
            Mark::Finished => "finished",
        };
        let not = if value.is_set { "" } else { "not " };
        format!("{name} {not}{word}")
    }

    /// A condition of a supervisor: `56(P1) finished`.
    pub fn guard(&self, guard: &AddedGuard) -> String {
        let term = |term: &Vec<MarkValue>| term.iter().map(|value| self.value(value)).collect::<Vec<_>>().join(" and ");
        let terms: Vec<String> = guard.terms.iter().map(term).collect();
        let any = terms.join(", or ");
        match (guard.allows, guard.terms.first().is_some_and(Vec::is_empty)) {
            (true, _) if guard.terms.is_empty() => "never".to_owned(),
            (false, true) => "never".to_owned(),
            (true, _) => any,
            (false, false) => format!("not while {any}"),
        }
    }

    /// Predecessors of a step, on its product: `24(P1)`.
    pub fn predecessors(&self, step: &CoordinatedStep, instance: usize) -> String {
        let name = |id| format!("{}(P{})", self.relations.operation(id).id, instance + 1);
        match &step.after {
            Precondition::Always => String::new(),
            after => after.text(&name),
        }
    }

    /// A restriction of the tables, with its place.
    pub fn restriction(&self, restriction: &Restriction) -> String {
        match restriction {
            Restriction::Predecessors(row) => {
                let related = (0..self.relations.conditions.len())
                    .flat_map(|condition| self.relations.related(linewright_relations::ConditionId(condition)));
                let mut related = related.filter(|(_, related)| related.row == *row);
                let text = related.next().map(|(_, related)| {
                    let name = |id| self.relations.operation(id).id.clone();
                    format!("{} after {}", name(related.operation), related.after.text(&name))
                });
                format!("{}: {}", self.relations.place(*row), text.unwrap_or_default())
            }
            Restriction::Booking(machine, zone) => {
                let rows = self.relations.sequences.iter().filter(|sequence| sequence.machine == *machine);
                let rows = rows.flat_map(MachineSequence::rows);
                let mut rows: Vec<_> = rows.filter(|row| row.zones_before.contains(zone)).collect();
                rows.sort_by_key(|row| row.row);
                rows.dedup_by_key(|row| row.row);
                let ids: Vec<&str> =
                    rows.iter().map(|row| self.relations.operation(row.operation).id.as_str()).collect();
                let place = rows.first().map_or_else(String::new, |row| self.relations.place(row.row));
                let zone = &self.relations.zone(*zone).name;
                format!("{place}: {} takes zone {zone} in {}", self.machine(*machine), ids.join(", "))
            }
            Restriction::Interlock(nth) => {
                let interlock = &self.relations.interlocks[*nth];
                let action = match &interlock.action {
                    InterlockedAction::State { component, to } => {
                        let name = self.relations.component_name(*component);
                        format!("{name} to {}", self.relations.state_name(*component, *to))
                    }
                    InterlockedAction::Operation { operation, way } => {
                        let way = way.as_ref().map_or_else(String::new, |way| format!("/{way}"));
                        format!("operation {}{way}", self.relations.operation(*operation).id)
                    }
                };
                let place = self.relations.place(interlock.terms[0].row);
                format!("{place}: interlock of {action}")
            }
        }
    }

    /// What a machine waits for.
    pub fn wait(&self, wait: &WaitingMachine) -> String {
        let next: Vec<String> = wait.next.iter().map(|of| self.operation_with_comment(*of)).collect();
        let next = if next.is_empty() { "its next operation".to_owned() } else { next.join(" or ") };
        let for_zone = wait.lacks.iter().find_map(|restriction| match restriction {
            Restriction::Booking(_, zone) => Some(format!("zone {}", self.relations.zone(*zone).name)),
            _ => None,
        });
        let mut machines: Vec<&str> = wait
            .waits_for
            .iter()
            .flat_map(|of| &self.composition.operations[*of].machines)
            .map(|of| self.machine(*of))
            .collect();
        machines.sort_unstable();
        machines.dedup();
        let operations: Vec<String> = wait.waits_for.iter().map(|of| self.operation(*of)).collect();
        let reason = match for_zone {
            Some(zone) if machines.is_empty() => zone,
            Some(zone) => format!("{zone}, which {} has", machines.join(" and ")),
            None if operations.is_empty() => "what no state allows".to_owned(),
            None => format!("{} of {}", operations.join(", "), machines.join(" and ")),
        };
        format!("{} cannot start {next}: it waits for {reason}", self.machine(wait.machine))
    }

    /// What a trap is, in one sentence for each machine.
    pub fn trap(&self, trap: &Trap) -> Vec<String> {
        let violated = trap.violated.iter().map(|(of, restriction)| {
            format!(
                "nothing holds back {}, against {}",
                self.operation_with_comment(*of),
                self.restriction(restriction)
            )
        });
        violated.chain(trap.locked.iter().map(|wait| self.wait(wait))).collect()
    }

    /// The operations that are started on the way into a trap.
    pub fn way(&self, trap: &Trap) -> Vec<String> {
        let steps = trap.way.iter().map(|(of, mark)| match mark {
            Mark::Chosen => format!("{} is chosen", self.operation_with_comment(*of)),
            Mark::Started | Mark::Finished => self.operation_with_comment(*of),
        });
        steps.collect()
    }
}
