//! The largest set of states in which nothing is locked and nothing bad can happen by itself.
//!
//! Backwards from the finished states, within the reachable ones that violate nothing; states from which an uncontrollable event
//! leads out of what remains are taken away, until nothing changes.

use oxidd::BooleanFunction;
use oxidd::bdd::BDDFunction;
use oxidd::util::OutOfMemory;

use crate::model::Composition;
use crate::symbolic::{Diagrams, Set, SymbolicEvent, meet, without};

/// Sets of a cell.
pub(crate) struct Controlled<'c> {
    pub events: Vec<SymbolicEvent<'c>>,
    /// Everything that restrictions allow, supervised or not.
    pub reachable: BDDFunction,
    /// Of these, the states that are good: a supervisor keeps the cell in them. Empty where there is none.
    pub good: BDDFunction,
    /// Those that are reached under supervision.
    pub supervised: BDDFunction,
}

/// Computes the sets.
pub(crate) fn control<'c>(
    diagrams: &mut Diagrams,
    composition: &'c Composition,
) -> Result<Controlled<'c>, OutOfMemory> {
    let events = diagrams.events(composition)?;
    let everywhere = diagrams.constant(true);
    let initial = diagrams.initial()?;
    let reachable = reach(diagrams, &events, &initial, &everywhere)?;
    let mut bad = diagrams.constant(false);
    for requirement in &composition.requirements {
        bad = bad.or(&without(&reachable, &diagrams.set(&requirement.holds)?)?)?;
    }
    let free = || events.iter().filter(|event| !event.event.is_controllable);
    for event in free() {
        bad = bad.or(&without(&event.possible.and(&reachable)?, &event.enabled)?)?;
    }
    let finished = diagrams.set(&composition.finished)?;
    let mut good = without(&reachable, &bad)?;
    loop {
        let mut next = finishing(diagrams, &events, &good.and(&finished)?, &good)?;
        for event in free() {
            let stays = diagrams.preimage(event, &next)?;
            next = without(&next, &without(&event.possible, &stays)?)?;
        }
        if next == good {
            break;
        }
        good = next;
    }
    let supervised = match meet(&initial, &good)? {
        true => reach(diagrams, &events, &initial, &good)?,
        false => diagrams.constant(false),
    };
    Ok(Controlled { events, reachable, good, supervised })
}

/// All states that are reached from `from` within `within`. Events are taken in the order of their operations, which is that of the
/// work: a few rounds reach everything.
fn reach(diagrams: &mut Diagrams, events: &[SymbolicEvent<'_>], from: &BDDFunction, within: &BDDFunction) -> Set {
    let mut reached = from.clone();
    loop {
        let before = reached.clone();
        for event in events {
            let next = diagrams.image(event, &event.enabled, &reached)?.and(within)?;
            reached = reached.or(&next)?;
            diagrams.note(&reached);
        }
        if reached == before {
            return Ok(reached);
        }
    }
}

/// The states of `within` from which one of `to` is reached without leaving it.
fn finishing(diagrams: &mut Diagrams, events: &[SymbolicEvent<'_>], to: &BDDFunction, within: &BDDFunction) -> Set {
    let mut reached = to.clone();
    loop {
        let before = reached.clone();
        for event in events.iter().rev() {
            let earlier = diagrams.preimage(event, &reached)?.and(&event.enabled)?.and(within)?;
            reached = reached.or(&earlier)?;
            diagrams.note(&reached);
        }
        if reached == before {
            return Ok(reached);
        }
    }
}
