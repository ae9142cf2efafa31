//! Every reachable marking of a bounded net, exactly, in little memory and fast.
//!
//! [`decide`] plays a net out and gives all facts that need no question: how many markings and arcs, deadlocks, bounds,
//! which transitions are live, whether the net is reversible and which markings are home. [`find`] looks for one marking
//! and the shortest way to it; [`walk`] gives the whole graph, for example to write it to a file. All answer exactly or
//! are undecided, and no comparison of markings relies on a hash.
//!
//! It works in layers, each in a module and each using only those before it: conserved sums of tokens (`invariants`),
//! the numbers that a marking is written with (`encoding`), when transitions fire, by those numbers (`rules`), and two
//! ways to store sets of markings: one bit per possible code, fired 64 at a time (`bitmap`, `sweep`), or a table of keys
//! (`table`). The slow and obvious way to the same facts is [`crate::reach`], and the tests hold the two against each
//! other.
//!
//! It does not recognise an unbounded net: the search ends at a limit. That is the business of [`crate::coverability`].

mod bitmap;
mod encoding;
mod facts;
mod find;
mod invariants;
mod limits;
mod on_bitmap;
mod on_table;
mod path;
mod rules;
mod space;
mod sparse;
mod sweep;
mod table;
mod terminal;
mod walk;

#[cfg(test)]
mod testnets;
#[cfg(test)]
mod tests;

pub use facts::{Home, NetFacts, Storage, WitnessMarking};
pub use find::{find, find_marking};
pub use limits::{ExplorationLimit, ExplorationLimits, ExplorationUndecided};
pub use on_table::MarkingView;
pub use walk::{GraphEvent, walk};

use self::bitmap::BitmapLayout;
use self::encoding::MarkingEncoding;
use crate::Net;

/// A bitmap of so few words is always used: half a megabyte.
const WORDS_SMALL: usize = 1 << 15;
/// A larger one is used when there is a state for every so many words: going over them then costs less than a table.
const WORDS_PER_STATE: u64 = 64;

/// Plays a net out and returns the facts.
///
/// # Errors
/// [`ExplorationUndecided`] if there are more states than allowed, if the tables would need more bytes than allowed, or if a place
/// gets more tokens than 32 bits can count. An unbounded net always ends so.
pub fn decide(net: &Net, limits: &ExplorationLimits) -> Result<NetFacts, ExplorationUndecided> {
    if limits.states == 0 {
        return Err(ExplorationUndecided { states: 0, cause: ExplorationLimit::States { limit: 0 } });
    }
    let encoding = MarkingEncoding::of(net);
    let Some(layout) = BitmapLayout::of(&encoding).filter(|layout| on_bitmap::bytes(layout) <= limits.bytes) else {
        return on_table::decide(net, &encoding, limits);
    };
    let few = layout.words as u64 / WORDS_PER_STATE;
    if layout.words > WORDS_SMALL {
        let first = ExplorationLimits { states: few.min(limits.states), ..*limits };
        match on_table::decide(net, &encoding, &first) {
            Err(ExplorationUndecided {
                cause: ExplorationLimit::States { .. } | ExplorationLimit::Bytes { .. },
                ..
            }) if few < limits.states => {}
            decided => return decided,
        }
    }
    on_bitmap::decide(net, &encoding, &layout, limits)
}
