//! Search for one marking, and the shortest way to it.

use super::encoding::MarkingEncoding;
use super::facts::WitnessMarking;
use super::limits::{ExplorationLimit, ExplorationLimits, ExplorationUndecided};
use super::on_table::{MarkingView, found};
use super::table::MarkingTable;
use crate::{Marking, Net};

/// The first reachable marking, breadth first, that `wanted` accepts; none if there is no such marking.
///
/// The search stops there: a limit is met only if that many states come before it. Uses one thread.
///
/// # Errors
/// As [`super::decide`].
pub fn find(
    net: &Net,
    limits: &ExplorationLimits,
    wanted: impl FnMut(MarkingView) -> bool,
) -> Result<Option<WitnessMarking>, ExplorationUndecided> {
    if limits.states == 0 {
        return Err(ExplorationUndecided { states: 0, cause: ExplorationLimit::States { limit: 0 } });
    }
    search(net, &MarkingEncoding::of(net), limits, wanted)
}

/// A shortest way to a marking; none if it is not reachable.
///
/// # Errors
/// As [`super::decide`].
pub fn find_marking(
    net: &Net,
    limits: &ExplorationLimits,
    marking: &Marking,
) -> Result<Option<WitnessMarking>, ExplorationUndecided> {
    find(net, limits, |view| net.places().all(|place| view.tokens(place) == marking.tokens(place)))
}

pub(super) fn search(
    net: &Net,
    encoding: &MarkingEncoding,
    limits: &ExplorationLimits,
    mut wanted: impl FnMut(MarkingView) -> bool,
) -> Result<Option<WitnessMarking>, ExplorationUndecided> {
    let mut table = MarkingTable::new(net, encoding, limits)?;
    let mut scratch = table.scratch();
    let mut looked_at = 0;
    let mut next = 0;
    loop {
        while looked_at < table.len() {
            let state = looked_at as u32;
            if wanted(MarkingView { encoding, digits: table.digits(state, &mut scratch) }) {
                return Ok(Some(found(&table, state)));
            }
            looked_at += 1;
        }
        if next == table.len() {
            return Ok(None);
        }
        table.expand(next as u32, &mut scratch, |_, _, _| {})?;
        next += 1;
    }
}
