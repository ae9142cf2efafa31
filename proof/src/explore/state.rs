//! The composed line at one moment, and the same in as few bits as hold it.
//!
//! A state is a situation number and a cycle for each station, and the words on their way over each link. Cycles grow
//! for ever while the line repeats itself; packed, all are relative to the first station's, so that a state met again
//! a hundred cycles later is the same state. Packing is exact: equal bits, equal state.

use super::view_key::ViewKey;

/// The composed line at one moment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ComposedState {
    /// The mode that is granted in epochs, by its number among those of the setting.
    pub granted: u32,
    /// For each station, its situation.
    pub situations: Vec<u32>,
    /// For each station, its cycle.
    pub cycles: Vec<i32>,
    /// For each link `lag` places, oldest word first, filled up with [`ViewKey::NONE`].
    pub mail: Vec<ViewKey>,
}

impl ComposedState {
    pub fn take(&mut self, other: &ComposedState) {
        self.granted = other.granted;
        self.situations.copy_from_slice(&other.situations);
        self.cycles.copy_from_slice(&other.cycles);
        self.mail.copy_from_slice(&other.mail);
    }
}

/// Something does not fit its field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FieldOverflow {
    Situation,
    Word,
    Offset,
}

/// Widths of the parts of a packed state, in bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Widths {
    pub situation: u32,
    pub word: u32,
    pub offset: u32,
}

impl Widths {
    /// Enough for most lines of few stations.
    pub const FIRST: Widths = Widths { situation: 18, word: 10, offset: 4 };

    /// Enough for what did not fit.
    #[must_use]
    pub fn wider(mut self, unfit: FieldOverflow) -> Self {
        match unfit {
            FieldOverflow::Situation => self.situation += 4,
            FieldOverflow::Word => self.word += 4,
            FieldOverflow::Offset => self.offset += 4,
        }
        self
    }
}

/// There are six modes.
const MODE_BITS: u32 = 3;

#[derive(Clone, Copy, Debug)]
struct StateField {
    at: usize,
    shift: u32,
    width: u32,
}

/// Positions of the parts of a state in its bits.
#[derive(Clone, Debug)]
pub(crate) struct StateLayout {
    granted: StateField,
    situations: Vec<StateField>,
    /// The first station's is always 0 and has none.
    cycles: Vec<StateField>,
    /// Word and base; words without a base have a field of no width.
    mail: Vec<(StateField, StateField)>,
    pub words64: usize,
}

impl StateLayout {
    /// `links`: for each link, whether its view keys have a base; each has `lag` places.
    pub fn new(stations: usize, links: impl Iterator<Item = bool>, lag: usize, widths: Widths) -> Self {
        let mut next = StateField { at: 0, shift: 0, width: 0 };
        let mut field = |width: u32| {
            if next.shift + width > 64 {
                next = StateField { at: next.at + 1, shift: 0, width: 0 };
            }
            let field = StateField { width, ..next };
            next.shift += width;
            field
        };
        let granted = field(MODE_BITS);
        let situations = (0..stations).map(|_| field(widths.situation)).collect();
        let cycles = (1..stations).map(|_| field(widths.offset)).collect();
        let mut mail = Vec::new();
        for has_base in links {
            for _ in 0..lag {
                mail.push((field(widths.word), field(if has_base { widths.offset } else { 0 })));
            }
        }
        StateLayout { granted, situations, cycles, mail, words64: next.at + 1 }
    }

    pub fn pack<const N: usize>(&self, state: &ComposedState) -> Result<[u64; N], FieldOverflow> {
        let mut key = [0; N];
        let origin = state.cycles[0];
        self.granted.put(&mut key, u64::from(state.granted), FieldOverflow::Situation)?;
        for (field, &situation) in self.situations.iter().zip(&state.situations) {
            field.put(&mut key, u64::from(situation), FieldOverflow::Situation)?;
        }
        for (field, &cycle) in self.cycles.iter().zip(&state.cycles[1..]) {
            field.put_signed(&mut key, cycle - origin)?;
        }
        for ((word, base), mail) in self.mail.iter().zip(&state.mail) {
            if mail.id != 0 {
                word.put(&mut key, u64::from(mail.id), FieldOverflow::Word)?;
                if base.width > 0 && mail.has_base() {
                    base.put_signed(&mut key, mail.base - origin)?;
                }
            }
        }
        Ok(key)
    }

    /// The same with another situation of one station, and nothing else changed.
    #[inline]
    pub fn with_situation<const N: usize>(&self, key: &[u64; N], station: usize, to: u32) -> Option<[u64; N]> {
        let field = self.situations[station];
        let mut key = *key;
        if u64::from(to) >> field.width != 0 {
            return None;
        }
        let mask = (u64::MAX >> (64 - field.width)) << field.shift;
        key[field.at] = key[field.at] & !mask | u64::from(to) << field.shift;
        Some(key)
    }

    /// The state, with the first station in cycle 0.
    pub fn unpack<const N: usize>(&self, key: &[u64; N], state: &mut ComposedState) {
        for (field, situation) in self.situations.iter().zip(&mut state.situations) {
            *situation = field.get(key) as u32;
        }
        state.granted = self.granted.get(key) as u32;
        state.cycles[0] = 0;
        for (field, cycle) in self.cycles.iter().zip(&mut state.cycles[1..]) {
            *cycle = field.get_signed(key);
        }
        for ((word, base), mail) in self.mail.iter().zip(&mut state.mail) {
            mail.id = word.get(key) as u32;
            mail.base = if base.width == 0 || !mail.has_base() { 0 } else { base.get_signed(key) };
        }
    }
}

impl StateField {
    #[inline]
    fn put<const N: usize>(self, key: &mut [u64; N], value: u64, unfit: FieldOverflow) -> Result<(), FieldOverflow> {
        if value >> self.width != 0 {
            return Err(unfit);
        }
        key[self.at] |= value << self.shift;
        Ok(())
    }

    #[inline]
    fn get<const N: usize>(self, key: &[u64; N]) -> u64 {
        if self.width == 0 { 0 } else { key[self.at] >> self.shift & (u64::MAX >> (64 - self.width)) }
    }

    /// Signed numbers are kept with half the range added.
    #[inline]
    fn put_signed<const N: usize>(self, key: &mut [u64; N], value: i32) -> Result<(), FieldOverflow> {
        let half = 1i64 << (self.width - 1);
        let value = u64::try_from(i64::from(value) + half).map_err(|_| FieldOverflow::Offset)?;
        self.put(key, value, FieldOverflow::Offset)
    }

    #[inline]
    fn get_signed<const N: usize>(self, key: &[u64; N]) -> i32 {
        (self.get(key) as i64 - (1i64 << (self.width - 1))) as i32
    }
}
