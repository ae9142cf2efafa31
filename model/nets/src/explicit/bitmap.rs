//! Sets of markings as bitmaps over all codes.
//!
//! A code is a word and a bit in it. The *low* digits, as many as fit, choose the bit; the *high* digits choose the
//! word, in mixed radix. Firing adds a constant to each digit and never carries, so a transition moves all markings of
//! a word at which it is enabled to one other word at once, by one shift: up to 64 markings fire in a few instructions.
//! The conditions of a transition on the high digits are the same for the whole word; those on the low ones are a mask.
//!
//! Only encodings with all digits bounded can be laid out like this, and only worthwhile ones are (see
//! [`super::decide`]).

use super::encoding::{DigitTerm, MarkingEncoding};
use super::rules::{Filter, FiringRule, LinearCondition, PlayDirection, rules};
use crate::{Marking, Net};

/// Bits of a word.
const BITS: u32 = 64;

/// Places of the digits.
#[derive(Debug)]
pub(super) struct BitmapLayout {
    /// The low digits, with what one adds to the bit number.
    low: Vec<(usize, u32)>,
    /// The high digits, with their radix; the first changes fastest from word to word.
    high: Vec<(usize, u32)>,
    /// Number of words.
    pub(super) words: usize,
}

impl BitmapLayout {
    /// The layout with the fewest words, unless a place may be unbounded or the words cannot be counted in 32 bits.
    pub(super) fn of(encoding: &MarkingEncoding) -> Option<BitmapLayout> {
        BitmapLayout::with_bits(encoding, BITS)
    }

    /// The layout with only `bits` bits of each word in use.
    pub(super) fn with_bits(encoding: &MarkingEncoding, bits: u32) -> Option<BitmapLayout> {
        let radices: Vec<u32> = encoding.radices.iter().copied().collect::<Option<_>>()?;
        if encoding.bounds.contains(&None) {
            return None;
        }
        let chosen = fullest_word(&radices, bits);
        let mut low = Vec::new();
        let mut stride = 1;
        for &digit in &chosen {
            low.push((digit, stride));
            stride *= radices[digit];
        }
        // The digits found first change slowest.
        let high = (0..radices.len()).rev().filter(|digit| !chosen.contains(digit));
        let high: Vec<(usize, u32)> = high.map(|digit| (digit, radices[digit])).collect();
        let words = high.iter().try_fold(1_u32, |words, &(_, radix)| words.checked_mul(radix))?;
        Some(BitmapLayout { low, high, words: words as usize })
    }

    /// Where a marking with these digits is.
    pub(super) fn locate(&self, digits: &[u32]) -> (usize, u32) {
        let word =
            self.high.iter().rev().fold(0, |word, &(digit, radix)| word * radix as usize + digits[digit] as usize);
        (word, self.low.iter().map(|&(digit, stride)| digits[digit] * stride).sum())
    }

    /// The digits of what is there.
    pub(super) fn digits(&self, word: usize, bit: u32, encoding: &MarkingEncoding) -> Vec<u32> {
        let mut digits = vec![0; encoding.radices.len()];
        let mut rest = word;
        for &(digit, radix) in &self.high {
            digits[digit] = (rest % radix as usize) as u32;
            rest /= radix as usize;
        }
        for &(digit, stride) in &self.low {
            digits[digit] = bit / stride % encoding.radices[digit].unwrap_or(1);
        }
        digits
    }

    /// The marking that is there.
    pub(super) fn marking(&self, word: usize, bit: u32, encoding: &MarkingEncoding) -> Marking {
        encoding.marking(&self.digits(word, bit, encoding))
    }

    fn is_low(&self, digit: usize) -> bool {
        self.low.iter().any(|&(low, _)| low == digit)
    }

    /// Number of codes.
    pub(super) fn codes(&self, encoding: &MarkingEncoding) -> u64 {
        self.words as u64 * u64::from(self.valid_bits(encoding))
    }

    /// The bits that stand for something: those below the product of the low radices.
    fn valid_bits(&self, encoding: &MarkingEncoding) -> u32 {
        self.low.iter().map(|&(digit, _)| encoding.radices[digit].unwrap_or(1)).product()
    }
}

/// The digits whose product comes closest to filling a word; of several such choices one with many digits, because
/// every high digit costs time.
fn fullest_word(radices: &[u32], bits: u32) -> Vec<usize> {
    let mut best: Vec<Option<Vec<usize>>> = vec![None; bits as usize + 1];
    best[1] = Some(Vec::new());
    for (digit, &radix) in radices.iter().enumerate().filter(|&(_, &radix)| radix <= bits) {
        for product in (1..=bits / radix).rev() {
            let Some(mut longer) = best[product as usize].clone() else { continue };
            longer.push(digit);
            let place = &mut best[(product * radix) as usize];
            if place.as_ref().is_none_or(|known| known.len() < longer.len()) {
                *place = Some(longer);
            }
        }
    }
    best.into_iter().flatten().next_back().unwrap_or_default()
}

/// A transition, compiled for words.
#[derive(Debug)]
pub(super) struct WordRule {
    /// The bits at which the conditions on low digits hold.
    pub(super) low: u64,
    /// The conditions that take both, or several high digits.
    pub(super) mixed: Vec<WordCondition>,
    /// Change of the word number.
    pub(super) jump: isize,
    left: u32,
    right: u32,
    /// Its position among the transitions of the net.
    pub(super) transition: u32,
}

impl WordRule {
    /// The bits to which those at which it fires move.
    #[inline]
    pub(super) fn moved(&self, bits: u64) -> u64 {
        // One of the two is zero.
        (bits << self.left) >> self.right
    }
}

/// The bits at which a sum of low terms is at least what the high terms leave to be had.
#[derive(Debug)]
pub(super) struct WordCondition {
    need: i64,
    high: Vec<DigitTerm>,
    /// The least sum of the low terms.
    least: i64,
    /// Surplus needed over the least: the bits that have it.
    masks: Vec<u64>,
}

impl WordCondition {
    #[inline]
    pub(super) fn mask(&self, digits: &[u32]) -> u64 {
        let missing = self.high.iter().fold(self.need - self.least, |rest, term| rest - term.of(digits[term.digit]));
        if missing <= 0 { u64::MAX } else { self.masks.get(missing as usize).copied().unwrap_or(0) }
    }
}

/// The count of a place, word by word.
#[derive(Debug)]
pub(super) struct WordForm {
    constant: i64,
    divisor: i64,
    high: Vec<DigitTerm>,
    /// Values of the low digits, the most first, and the bits with each.
    low: Vec<(i64, u64)>,
}

impl WordForm {
    /// The most tokens at any of the bits, of which there is one at least.
    #[inline]
    pub(super) fn most(&self, digits: &[u32], bits: u64) -> u32 {
        let high = self.high.iter().fold(self.constant, |sum, term| sum + term.of(digits[term.digit]));
        let low = self.low.iter().find(|(_, mask)| mask & bits != 0).map_or(0, |&(value, _)| value);
        ((high + low) / self.divisor) as u32
    }
}

/// The rules of a net for one way of playing it, compiled for words.
#[derive(Debug)]
pub(super) struct Kernel {
    pub(super) rules: Vec<WordRule>,
    pub(super) filter: Filter,
    /// As in [`BitmapLayout`].
    high: Vec<(usize, u32)>,
    digits: usize,
}

impl Kernel {
    pub(super) fn new(net: &Net, encoding: &MarkingEncoding, layout: &BitmapLayout, direction: PlayDirection) -> Self {
        let mut rules = rules(net, encoding, direction);
        let filter = Filter::take(&mut rules, &encoding.radices, |digit| !layout.is_low(digit));
        let lows = Lows::new(encoding, layout);
        let compile = |rule: &FiringRule| lows.compile(rule, layout);
        Kernel {
            rules: rules.iter().map(compile).collect(),
            filter,
            high: layout.high.clone(),
            digits: encoding.radices.len(),
        }
    }

    pub(super) fn cursor(&self) -> Cursor<'_> {
        let levels = self.high.len();
        let all = self.filter.all();
        Cursor {
            kernel: self,
            quotients: vec![usize::MAX; levels],
            digits: vec![0; self.digits],
            sets: all.repeat(levels + 1),
        }
    }
}

/// The forms of all places, for words.
pub(super) fn word_forms(encoding: &MarkingEncoding, layout: &BitmapLayout) -> Vec<WordForm> {
    let lows = Lows::new(encoding, layout);
    let form = |form: &super::encoding::Form| {
        let (low_terms, high): (Vec<DigitTerm>, Vec<DigitTerm>) =
            form.terms.iter().cloned().partition(|term| layout.is_low(term.digit));
        let mut low: Vec<(i64, u64)> = Vec::new();
        for (bit, value) in lows.sums(&low_terms).into_iter().enumerate() {
            match low.iter_mut().find(|(known, _)| *known == value) {
                Some((_, mask)) => *mask |= 1 << bit,
                None => low.push((value, 1 << bit)),
            }
        }
        low.sort_unstable_by_key(|&(value, _)| std::cmp::Reverse(value));
        WordForm { constant: form.constant, divisor: form.divisor, high, low }
    };
    encoding.forms.iter().map(form).collect()
}

/// The low digits of every bit.
struct Lows {
    digits: Vec<Vec<u32>>,
}

impl Lows {
    fn new(encoding: &MarkingEncoding, layout: &BitmapLayout) -> Self {
        Lows { digits: (0..layout.valid_bits(encoding)).map(|bit| layout.digits(0, bit, encoding)).collect() }
    }

    /// Per bit, a sum of low terms.
    fn sums(&self, terms: &[DigitTerm]) -> Vec<i64> {
        let sum = |digits: &Vec<u32>| terms.iter().map(|term| term.of(digits[term.digit])).sum();
        self.digits.iter().map(sum).collect()
    }

    fn mask(&self, sums: &[i64], least: i64) -> u64 {
        sums.iter().enumerate().filter(|&(_, &sum)| sum >= least).fold(0, |mask, (bit, _)| mask | 1 << bit)
    }

    fn compile(&self, rule: &FiringRule, layout: &BitmapLayout) -> WordRule {
        let mut low = self.mask(&vec![0; self.digits.len()], 0);
        let mut mixed = Vec::new();
        for LinearCondition { terms, need } in &rule.conditions {
            let (low_terms, high): (Vec<DigitTerm>, Vec<DigitTerm>) =
                terms.iter().cloned().partition(|term| layout.is_low(term.digit));
            let sums = self.sums(&low_terms);
            if high.is_empty() {
                low &= self.mask(&sums, *need);
                continue;
            }
            let (least, most) = (sums.iter().min().map_or(0, |&s| s), sums.iter().max().map_or(0, |&s| s));
            let masks = (least..=most).map(|sum| self.mask(&sums, sum)).collect();
            mixed.push(WordCondition { need: *need, high, least, masks });
        }
        let mut shift = 0_i64;
        let mut jump = 0_isize;
        let change = |digit: usize| rule.change.iter().find(|&&(of, _)| of == digit).map_or(0, |&(_, by)| by);
        layout.low.iter().for_each(|&(digit, stride)| shift += change(digit) * i64::from(stride));
        let mut stride = 1_isize;
        for &(digit, radix) in &layout.high {
            jump += change(digit) as isize * stride;
            stride *= radix as isize;
        }
        // A change that no marking has room for belongs to a transition that never fires.
        if shift.abs() >= i64::from(BITS) || jump.unsigned_abs() >= layout.words {
            (low, shift, jump) = (0, 0, 0);
        }
        let (left, right) = (shift.max(0) as u32, (-shift).max(0) as u32);
        WordRule { low, mixed, jump, left, right, transition: rule.transition.0 }
    }
}

/// The high digits of a word, and the rules that they do not rule out.
///
/// Going from one word to a near one costs little: the results of the slower digits are kept.
#[derive(Debug)]
pub(super) struct Cursor<'k> {
    kernel: &'k Kernel,
    /// Per high digit, the word number without the faster digits.
    quotients: Vec<usize>,
    pub(super) digits: Vec<u32>,
    /// By high digit, the rules that it and the slower ones do not rule out; at the end, all.
    sets: Vec<u64>,
}

impl Cursor<'_> {
    #[inline]
    pub(super) fn go(&mut self, word: usize) {
        let width = self.kernel.filter.width;
        let mut rest = word;
        let mut changed = 0;
        for (quotient, &(digit, radix)) in self.quotients.iter_mut().zip(&self.kernel.high) {
            if *quotient == rest {
                break;
            }
            *quotient = rest;
            // 32 bits are enough for a word number, and divide faster.
            let (value, slower) = (rest as u32 % radix, rest as u32 / radix);
            self.digits[digit] = value;
            rest = slower as usize;
            changed += 1;
        }
        for level in (0..changed).rev() {
            let (digit, _) = self.kernel.high[level];
            let (faster, slower) = self.sets[level * width..].split_at_mut(width);
            match self.kernel.filter.of(digit, self.digits[digit]) {
                Some(set) => (0..width).for_each(|at| faster[at] = slower[at] & set[at]),
                None => faster.copy_from_slice(&slower[..width]),
            }
        }
    }

    /// The rules that the high digits do not rule out.
    #[inline]
    pub(super) fn candidates(&self) -> &[u64] {
        &self.sets[..self.kernel.filter.width]
    }
}
