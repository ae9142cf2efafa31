//! A list found by the search in another order: presses of one station one after the other, where the order between stations is free.
//!
//! So an operator does not walk from panel to panel and back. An order is permitted if the real controllers, played in that order, make the same
//! motions and reach the same end.

use linewright_line::StationId;

use crate::search::{Move, Search};
use crate::units::PlayedStations;

/// Lists of more moves stay as they are: each change of the order is played.
const MOVES_MAX: usize = 40;

/// The same moves, which lead from `start` to the same, with those of a station together as far as they may be.
pub(crate) fn grouped(search: &Search<'_, '_>, start: &PlayedStations, moves: Vec<Move>) -> Vec<Move> {
    if moves.len() > MOVES_MAX {
        return moves;
    }
    together(moves, |made| made.action.station(), |order| search.replayed(start, order))
}

/// The steps with those of a station together. `played` gives the steps of another order; none where it is not permitted.
fn together<T: Clone>(
    mut steps: Vec<T>,
    station: impl Fn(&T) -> Option<StationId>,
    played: impl Fn(&[T]) -> Option<Vec<T>>,
) -> Vec<T> {
    for at in 0..steps.len() {
        let Some(own) = station(&steps[at]) else { continue };
        let next = steps.iter().skip(at + 1).position(|of| station(of) == Some(own)).filter(|&between| between > 0);
        if let Some(between) = next {
            let mut order = steps.clone();
            let step = order.remove(at + 1 + between);
            order.insert(at + 1, step);
            steps = played(&order).unwrap_or(steps);
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps as a letter for the station and a number; `-` is one of several stations.
    fn order(steps: &[&'static str], permitted: impl Fn(&[&str]) -> bool) -> Vec<&'static str> {
        let station = |of: &&str| of.starts_with(char::is_alphabetic).then(|| StationId(u16::from(of.as_bytes()[0])));
        together(steps.to_vec(), station, |order| permitted(order).then(|| order.to_vec()))
    }

    #[test]
    fn steps_of_a_station_stand_together_where_that_is_permitted() {
        assert_eq!(order(&["a1", "b1", "a2", "c1", "b2"], |_| true), ["a1", "a2", "b1", "b2", "c1"]);
        assert_eq!(order(&["a1", "-", "b1", "a2"], |_| true), ["a1", "a2", "-", "b1"]);
        // a2 is refused before b1 is done.
        let is_before = |order: &[&str], one: &str, other: &str| {
            let place = |of: &str| order.iter().position(|step| *step == of);
            place(one) < place(other)
        };
        let waits = |order: &[&str]| is_before(order, "b1", "a2");
        assert_eq!(order(&["a1", "b1", "a2", "b2"], waits), ["a1", "b1", "b2", "a2"]);
        assert_eq!(order(&["a1", "b1", "a2"], |_| false), ["a1", "b1", "a2"]);
    }
}
