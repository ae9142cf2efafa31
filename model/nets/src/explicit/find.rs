//! One marking that is looked for, and the shortest way to it.

use super::encoding::Encoding;
use super::facts::Found;
use super::limits::{Cause, Limits, Undecided};
use super::on_table::{View, found};
use super::table::Table;
use crate::{Marking, Net};

/// The first reachable marking, breadth first, that `wanted` accepts; none if there is no such marking.
///
/// The search stops there: a limit is met only if that many states come before it. Uses one thread.
///
/// # Errors
/// As [`super::decide`].
pub fn find(net: &Net, limits: &Limits, wanted: impl FnMut(View) -> bool) -> Result<Option<Found>, Undecided> {
    if limits.states == 0 {
        return Err(Undecided { states: 0, cause: Cause::States { limit: 0 } });
    }
    search(net, &Encoding::of(net), limits, wanted)
}

/// A shortest way to a marking; none if it is not reachable.
///
/// # Errors
/// As [`super::decide`].
pub fn find_marking(net: &Net, limits: &Limits, marking: &Marking) -> Result<Option<Found>, Undecided> {
    find(net, limits, |view| net.places().all(|place| view.tokens(place) == marking.tokens(place)))
}

pub(super) fn search(
    net: &Net,
    encoding: &Encoding,
    limits: &Limits,
    mut wanted: impl FnMut(View) -> bool,
) -> Result<Option<Found>, Undecided> {
    let mut table = Table::new(net, encoding, limits)?;
    let mut scratch = table.scratch();
    let mut looked_at = 0;
    let mut next = 0;
    loop {
        while looked_at < table.len() {
            let state = looked_at as u32;
            if wanted(View { encoding, digits: table.digits(state, &mut scratch) }) {
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
