//! The whole graph of markings, shown piece by piece: for writing it to a file, or for a question of one's own.

use super::encoding::Encoding;
use super::limits::{Cause, Limits, Undecided};
use super::on_table::View;
use super::table::Table;
use crate::{Net, StateId, TransitionId};

/// A piece of the graph.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A marking. They come in the order of their numbers, which is that of discovery, breadth first; 0 is the initial
    /// one.
    State(StateId, View<'a>),
    /// An arc from the last marking shown, in the order of transitions. Where it leads may not have been shown yet.
    Arc {
        /// What fires.
        transition: TransitionId,
        /// Where it leads.
        to: StateId,
    },
}

/// Shows every marking, each followed by its arcs. Arcs are shown as they are found and not kept.
///
/// # Errors
/// As [`super::decide`]; what has been shown until then is a part of the graph.
pub fn walk(net: &Net, limits: &Limits, mut show: impl FnMut(Event)) -> Result<(), Undecided> {
    if limits.states == 0 {
        return Err(Undecided { states: 0, cause: Cause::States { limit: 0 } });
    }
    let encoding = Encoding::of(net);
    let mut table = Table::new(net, &encoding, limits)?;
    let mut scratch = table.scratch();
    let mut next = 0;
    while (next as usize) < table.len() {
        show(Event::State(StateId(next), View { encoding: &encoding, digits: table.digits(next, &mut scratch) }));
        table.expand(next, &mut scratch, |transition, to, _| {
            show(Event::Arc { transition: TransitionId(transition), to: StateId(to) });
        })?;
        next += 1;
    }
    Ok(())
}
