//! A list found by the search in another order: presses of one station one after the other, where the order between stations is free.
//!
//! Nobody has to walk from panel to panel and back. Whether an order is permitted the real controllers decide: it is played.

use crate::search::{Move, Search};
use crate::units::PlayedStations;

/// Lists of more moves stay as they are: each change of the order is played.
const MOVES_MAX: usize = 40;

/// The same moves, which lead from `start` to the same, with those of a station together as far as they may be.
pub(crate) fn grouped(search: &Search<'_, '_>, start: &PlayedStations, mut moves: Vec<Move>) -> Vec<Move> {
    if moves.len() > MOVES_MAX {
        return moves;
    }
    for at in 0..moves.len() {
        let Some(station) = moves[at].action.station() else { continue };
        let is_its = |of: &Move| of.action.station() == Some(station);
        let next = moves.iter().skip(at + 1).position(is_its).filter(|&between| between > 0);
        if let Some(between) = next {
            let mut order = moves.clone();
            let made = order.remove(at + 1 + between);
            order.insert(at + 1, made);
            moves = search.replayed(start, &order).unwrap_or(moves);
        }
    }
    moves
}
