//! Places of the tokens, and their colours.
//!
//! A coloured marking stores only what there is: pairs of a *cell* and a count. A cell is one colour on one place, and
//! all cells of a net are numbered through, place by place. Domains can have thousands of colours of which a handful is
//! ever present at a time. Equality, order and hash are those of the list, which is kept sorted and without zeros.

use crate::PlaceId;

/// M : a multiset of colours on every place (seed 000, definition 13). It has no reference to its net; the net reads it
/// with [`super::ColouredNet::count`] and [`super::ColouredNet::tokens_on`].
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ColouredMarking {
    pub(super) entries: Vec<(u32, u32)>,
}

impl ColouredMarking {
    /// The cells that have tokens, ascending, with their counts.
    pub fn entries(&self) -> &[(u32, u32)] {
        &self.entries
    }

    /// All tokens together.
    pub fn total(&self) -> u64 {
        self.entries.iter().map(|&(_, count)| u64::from(count)).sum()
    }
}

/// The count of a cell in a sorted list of entries.
pub(super) fn count_in(entries: &[(u32, u32)], cell: u32) -> u32 {
    entries.binary_search_by_key(&cell, |&(cell, _)| cell).map_or(0, |at| entries[at].1)
}

/// A token somewhere: what [`super::ColouredBuilder::tokens`] declares and messages name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TokenElement {
    pub place: PlaceId,
    /// The position of the colour among those of the place.
    pub colour: u32,
}

/// Sorts entries and adds up those of one cell. The place where a count leaves 32 bits is the error.
pub(super) fn collect(entries: &mut Vec<(u32, u32)>) -> Result<(), u32> {
    entries.sort_unstable();
    let mut kept = 0;
    for at in 0..entries.len() {
        let (cell, count) = entries[at];
        if kept > 0 && entries[kept - 1].0 == cell {
            entries[kept - 1].1 = entries[kept - 1].1.checked_add(count).ok_or(cell)?;
        } else {
            entries[kept] = (cell, count);
            kept += 1;
        }
    }
    entries.truncate(kept);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_sorted_and_added_up() {
        let mut entries = vec![(7, 1), (2, 3), (7, 2)];
        assert_eq!(collect(&mut entries), Ok(()));
        assert_eq!(entries, [(2, 3), (7, 3)]);
        assert_eq!((count_in(&entries, 7), count_in(&entries, 3)), (3, 0));
        assert_eq!(collect(&mut vec![(4, u32::MAX), (4, 1)]), Err(4));
    }
}
