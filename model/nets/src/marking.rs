//! Where the tokens are.
//!
//! A marking is a plain vector of counts, one per place. It has no reference to its net: the token game in
//! [`crate::game`] brings the two together. Equality, order and hash are those of the vector, which makes a marking
//! usable as the key of a set of states and gives every report the same order on every run.

use crate::PlaceId;

/// M : P → {0, 1, 2, …} (seed 002 §3.1).
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Marking(Box<[u32]>);

impl Marking {
    /// The marking with these counts, in the order of the places.
    pub fn from_tokens(tokens: impl IntoIterator<Item = u32>) -> Self {
        Marking(tokens.into_iter().collect())
    }

    /// Number of places that the marking covers.
    pub fn place_count(&self) -> usize {
        self.0.len()
    }

    /// M(p): the tokens on a place.
    ///
    /// # Panics
    /// When the marking has no such place.
    pub fn tokens(&self, place: PlaceId) -> u32 {
        self.0[place.index()]
    }

    /// All tokens together.
    pub fn total(&self) -> u64 {
        self.0.iter().map(|&count| u64::from(count)).sum()
    }

    /// The places that have at least one token, in order.
    pub fn marked(&self) -> impl Iterator<Item = PlaceId> + '_ {
        (0..).map(PlaceId).zip(&self.0).filter(|&(_, &count)| count > 0).map(|(place, _)| place)
    }

    /// The counts, in the order of the places.
    pub fn as_slice(&self) -> &[u32] {
        &self.0
    }

    pub(crate) fn set(&mut self, place: PlaceId, count: u32) {
        self.0[place.index()] = count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_read_by_place() {
        let m = Marking::from_tokens([0, 2, 0, u32::MAX]);
        assert_eq!(m.tokens(PlaceId(1)), 2);
        assert_eq!(m.marked().collect::<Vec<_>>(), [PlaceId(1), PlaceId(3)]);
        assert_eq!(m.total(), u64::from(u32::MAX) + 2);
    }
}
