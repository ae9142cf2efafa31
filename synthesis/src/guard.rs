//! What a supervisor adds to the start of an operation, as a condition that can be read.
//!
//! Of the states in which an operation may start, some must allow it and some must forbid it; all others do not matter. Marks that
//! are not needed to keep the two apart are left out one by one: first that something has been chosen or started, then what has
//! finished, the earliest first, so that what remains is the latest that has to be finished. What remains is written as an
//! irredundant sum of products (Minato 1992), of what allows or of what forbids, whichever is shorter.

use oxidd::bdd::BDDFunction;
use oxidd::util::OutOfMemory;
use oxidd::{BooleanFunction, BooleanFunctionQuant};

use crate::model::{Composition, Mark, Nth};
use crate::symbolic::{Diagrams, meet, without};

/// A mark that is set, or is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MarkValue {
    /// Number in [`Composition::operations`].
    pub of: Nth,
    pub mark: Mark,
    pub is_set: bool,
}

/// A condition: one of its terms, each all of its values. With `allows` false it is what forbids.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AddedGuard {
    pub allows: bool,
    pub terms: Vec<Vec<MarkValue>>,
}

/// A condition that holds in all of `allow` and nowhere in `forbid`; no mark of it can be left out.
pub(crate) fn readable(
    diagrams: &Diagrams,
    composition: &Composition,
    allow: &BDDFunction,
    forbid: &BDDFunction,
) -> Result<AddedGuard, OutOfMemory> {
    let mut marks: Vec<(Nth, Mark)> = diagrams.marks().to_vec();
    marks.sort_by_key(|(of, mark)| (*mark == Mark::Finished, composition.operations[*of].depth, *of, *mark));
    let (mut allow, mut forbid) = (allow.clone(), forbid.clone());
    let mut kept = Vec::new();
    for (of, mark) in marks {
        let variable = diagrams.variable(of, mark);
        let (less_allow, less_forbid) = (allow.exists(&variable)?, forbid.exists(&variable)?);
        if meet(&less_allow, &less_forbid)? {
            kept.push((of, mark));
        } else {
            (allow, forbid) = (less_allow, less_forbid);
        }
    }
    // The latest first, so that products share them.
    kept.reverse();
    let (allows, _) = cover(diagrams, &kept, &allow, &forbid.not()?)?;
    let (forbids, _) = cover(diagrams, &kept, &forbid, &allow.not()?)?;
    let size = |terms: &[Vec<MarkValue>]| terms.iter().map(Vec::len).sum::<usize>() + terms.len();
    Ok(match size(&allows) <= size(&forbids) {
        true => AddedGuard { allows: true, terms: allows },
        false => AddedGuard { allows: false, terms: forbids },
    })
}

/// An irredundant sum of products between `low` and `high`, over these marks, and its set.
fn cover(
    diagrams: &Diagrams,
    marks: &[(Nth, Mark)],
    low: &BDDFunction,
    high: &BDDFunction,
) -> Result<(Vec<Vec<MarkValue>>, BDDFunction), OutOfMemory> {
    if !low.satisfiable() {
        return Ok((Vec::new(), diagrams.constant(false)));
    }
    let Some((&(of, mark), rest)) = marks.split_first().filter(|_| !high.valid()) else {
        return Ok((vec![Vec::new()], diagrams.constant(true)));
    };
    let variable = diagrams.variable(of, mark);
    let not = variable.not()?;
    let (low_0, low_1) = (low.restrict(&not)?, low.restrict(&variable)?);
    let (high_0, high_1) = (high.restrict(&not)?, high.restrict(&variable)?);
    let (without_it, set_0) = cover(diagrams, rest, &without(&low_0, &high_1)?, &high_0)?;
    let (with_it, set_1) = cover(diagrams, rest, &without(&low_1, &high_0)?, &high_1)?;
    let open = without(&low_0, &set_0)?.or(&without(&low_1, &set_1)?)?;
    let (either, set) = cover(diagrams, rest, &open, &high_0.and(&high_1)?)?;
    let mut terms = Vec::new();
    for (part, is_set) in [(without_it, false), (with_it, true)] {
        terms.extend(part.into_iter().map(|mut term| {
            term.push(MarkValue { of, mark, is_set });
            term
        }));
    }
    terms.extend(either);
    terms.iter_mut().for_each(|term| term.sort_unstable());
    let set = set.or(&variable.ite(&set_1, &set_0)?)?;
    Ok((terms, set))
}
