//! Sets of peers: one bit per entry of a program's `peers`, at most 256 of them.

use std::ops::BitOr;

/// Stations that one exchanges counts or positions with.
pub(crate) const PEERS_MAX: usize = 256;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PeerSet([u64; PEERS_MAX / 64]);

impl PeerSet {
    pub const EMPTY: Self = Self([0; PEERS_MAX / 64]);

    pub fn insert(&mut self, peer: usize) {
        self.0[peer / 64] |= 1 << (peer % 64);
    }

    pub fn contains(self, peer: usize) -> bool {
        self.0[peer / 64] & (1 << (peer % 64)) != 0
    }

    /// The peers of this set for which `keep` holds.
    pub fn filtered(self, mut keep: impl FnMut(usize) -> bool) -> Self {
        self.iter().filter(|&peer| keep(peer)).collect()
    }

    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
    }

    /// In ascending order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        let words = self.0.into_iter().enumerate();
        words.flat_map(|(index, word)| {
            let bits = std::iter::successors(Some(word), |rest| Some(rest & rest.wrapping_sub(1)));
            bits.take_while(|&rest| rest != 0).map(move |rest| index * 64 + rest.trailing_zeros() as usize)
        })
    }

    /// The bits, as many words as `peers` stations need.
    pub fn words(self, peers: usize) -> impl Iterator<Item = u64> {
        self.0.into_iter().take(peers.div_ceil(64))
    }
}

impl FromIterator<usize> for PeerSet {
    fn from_iter<I: IntoIterator<Item = usize>>(peers: I) -> Self {
        let mut set = Self::EMPTY;
        peers.into_iter().for_each(|peer| set.insert(peer));
        set
    }
}

impl BitOr for PeerSet {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] | other.0[word]))
    }
}
