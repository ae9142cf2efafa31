//! The whole graph of markings, shown piece by piece: for writing it to a file, or for other analyses.

use super::encoding::MarkingEncoding;
use super::limits::{ExplorationLimit, ExplorationLimits, ExplorationUndecided};
use super::on_table::MarkingView;
use super::table::MarkingTable;
use crate::{Net, StateId, TransitionId};

/// A piece of the graph.
#[derive(Clone, Copy, Debug)]
pub enum GraphEvent<'a> {
    /// A marking. They come in the order of their numbers, which is that of discovery, breadth first; 0 is the initial
    /// one.
    State(StateId, MarkingView<'a>),
    /// An arc from the last marking shown, in the order of transitions. Where it leads may not have been shown yet.
    Arc {
        /// Transition that fires.
        transition: TransitionId,
        /// Where it leads.
        to: StateId,
    },
}

/// Shows every marking, each followed by its arcs. Arcs are shown as they are found and not kept.
///
/// # Errors
/// As [`super::decide`]; what has been shown until then is a part of the graph.
pub fn walk(
    net: &Net,
    limits: &ExplorationLimits,
    mut show: impl FnMut(GraphEvent),
) -> Result<(), ExplorationUndecided> {
    if limits.states == 0 {
        return Err(ExplorationUndecided { states: 0, cause: ExplorationLimit::States { limit: 0 } });
    }
    let encoding = MarkingEncoding::of(net);
    let mut table = MarkingTable::new(net, &encoding, limits)?;
    let mut scratch = table.scratch();
    let mut next = 0;
    while (next as usize) < table.len() {
        show(GraphEvent::State(
            StateId(next),
            MarkingView { encoding: &encoding, digits: table.digits(next, &mut scratch) },
        ));
        table.expand(next, &mut scratch, |transition, to, _| {
            show(GraphEvent::Arc { transition: TransitionId(transition), to: StateId(to) });
        })?;
        next += 1;
    }
    Ok(())
}
