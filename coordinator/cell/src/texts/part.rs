//! Names of parts.

use crate::ids::PartId;
use crate::state::PlayerState;

/// A part by its number and, where it counts to a production order, by that: `part 7 (order rush, 2 of 5)`.
pub fn part(state: &PlayerState, part: PartId) -> String {
    format!("part {}", number(state, part))
}

/// The same without the word before it: `7 (order rush, 2 of 5)`.
pub(super) fn number(state: &PlayerState, part: PartId) -> String {
    let (production, id) = (state.production(), part.0);
    match production.order_of(part).zip(production.number_in_order(part)) {
        Some((order, number)) => format!("{id} (order {}, {number} of {})", order.request.name, order.request.quantity),
        None => id.to_string(),
    }
}
