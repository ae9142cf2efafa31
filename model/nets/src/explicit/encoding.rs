//! Numbers that a marking is written with.
//!
//! A marking becomes a vector of *digits*, as short as the sums of [`super::invariants`] allow:
//! - places of which exactly one holds a token are one digit, the position of that one. A place may be in several such
//!   sets; it belongs to the digit of the first, and the digit of a later set distinguishes only the places left to it;
//! - a place whose count follows from other places by a sum has no digit;
//! - every other place has its count as a digit.
//!
//! Each digit is a weighted sum of counts, so a firing adds to it what depends on the transition alone; and each count
//! is a [`Form`], a sum of terms that depend on one digit each. Two markings with the same sums have the same digits
//! only if they are equal: every comparison of codes is exact. How the digits are laid out in memory is not known here.

use super::invariants::{Invariant, WantedSums, followers, positive};
use super::sparse::entry;
use crate::{Marking, Net, TransitionId};

/// A digit that no sum bounds has none.
pub(super) type Radix = Option<u32>;

/// Up to which radix the bits of what a digit allows are tabulated per value.
pub(super) const TABLE_MAX: u32 = 256;

/// A form has no larger divisor. A weight of 32 bits of such a place is that many times as much of its sum, which is
/// compared with other sums in 64 bits.
const DIVISOR_MAX: u64 = 1 << 20;

/// Nor a larger constant, for the same reason: what the digits add to it has up to 55 bits.
const CONSTANT_MAX: u64 = 1 << 60;

/// Form of the markings of one net.
#[derive(Debug)]
pub(super) struct MarkingEncoding {
    /// Per digit, the number of its values.
    pub(super) radices: Vec<Radix>,
    /// Per place, its digit and what one token adds to it.
    own: Vec<Option<(usize, u32)>>,
    /// Per place, its count.
    pub(super) forms: Vec<Form>,
    /// Per place, the most tokens that it can hold, if a sum bounds them.
    pub(super) bounds: Vec<Option<u32>>,
}

/// (constant + Σ terms) / divisor: the count of a place as it follows from the digits.
#[derive(Clone, Debug)]
pub(super) struct Form {
    pub(super) constant: i64,
    pub(super) divisor: i64,
    pub(super) terms: Vec<DigitTerm>,
}

/// Contribution of one digit.
#[derive(Clone, Debug)]
pub(super) struct DigitTerm {
    pub(super) digit: usize,
    values: Values,
}

#[derive(Clone, Debug)]
enum Values {
    Table(Box<[i64]>),
    Times(i64),
}

impl DigitTerm {
    /// The contribution of a value of the digit.
    #[inline]
    pub(super) fn of(&self, value: u32) -> i64 {
        match &self.values {
            Values::Table(table) => table[value as usize],
            Values::Times(factor) => factor * i64::from(value),
        }
    }
}

impl Form {
    fn constant(constant: i64) -> Self {
        Form { constant, divisor: 1, terms: Vec::new() }
    }

    /// The numerator.
    #[inline]
    pub(super) fn scaled(&self, digits: &[u32]) -> i64 {
        self.terms.iter().fold(self.constant, |sum, term| sum + term.of(digits[term.digit]))
    }

    /// The count.
    pub(super) fn value(&self, digits: &[u32]) -> i64 {
        self.scaled(digits) / self.divisor
    }

    /// The most that it can be, if its digits are bounded.
    fn most(&self, radices: &[Radix]) -> Option<u32> {
        let mut sum = self.constant;
        for term in &self.terms {
            let most = match &term.values {
                Values::Table(table) => table.iter().copied().max().unwrap_or(0),
                Values::Times(factor) => (factor * i64::from(radices[term.digit]? - 1)).max(0),
            };
            sum = sum.checked_add(most)?;
        }
        u32::try_from(sum / self.divisor).ok()
    }

    /// Adds `factor` times a form whose divisor is 1; false if the numbers become too large.
    fn add(&mut self, factor: i64, other: &Form) -> bool {
        // Digits are less than 2³², so sums of such terms stay countable; and masks are tabulated per value of a sum
        // over the digits of one word, which bounds those tables.
        const LIMIT: i64 = 1 << 10;
        let product = |value: i64| value.checked_mul(factor).filter(|value| value.abs() < LIMIT);
        let Some(constant) = other.constant.checked_mul(factor).and_then(|c| self.constant.checked_add(c)) else {
            return false;
        };
        self.constant = constant;
        for term in &other.terms {
            let values = match &term.values {
                Values::Table(table) => table.iter().map(|&v| product(v)).collect::<Option<_>>().map(Values::Table),
                Values::Times(times) => product(*times).map(Values::Times),
            };
            let Some(values) = values else { return false };
            match self.terms.iter_mut().find(|own| own.digit == term.digit) {
                Some(own) => own.values.add(&values),
                None => self.terms.push(DigitTerm { digit: term.digit, values }),
            }
        }
        self.terms.retain(|term| !term.values.is_zero());
        true
    }
}

impl Values {
    fn add(&mut self, other: &Values) {
        match (self, other) {
            (Values::Table(own), Values::Table(other)) => own.iter_mut().zip(other).for_each(|(a, b)| *a += b),
            (Values::Times(own), Values::Times(other)) => *own += other,
            _ => unreachable!("the terms of one digit are of one kind"),
        }
    }

    fn is_zero(&self) -> bool {
        match self {
            Values::Table(table) => table.iter().all(|&value| value == 0),
            Values::Times(factor) => *factor == 0,
        }
    }
}

impl MarkingEncoding {
    /// The shortest encoding that was found.
    pub(super) fn of(net: &Net) -> Self {
        let sets = cover(net.place_count(), &positive(net, WantedSums::OneToken));
        let mut encoding = MarkingEncoding::with_sets(net.place_count(), &sets);
        encoding.add_counts(net);
        encoding
    }

    /// An encoding that uses no sums: every place is a digit, and nothing bounds it.
    #[cfg(test)]
    pub(super) fn plain(net: &Net) -> Self {
        let mut encoding = MarkingEncoding::with_sets(net.place_count(), &[]);
        (0..net.place_count()).for_each(|place| encoding.add_digit(place, None));
        encoding
    }

    fn with_sets(places: usize, sets: &[OneTokenSet]) -> Self {
        let zero = Form::constant(0);
        let mut encoding = MarkingEncoding {
            radices: Vec::new(),
            own: vec![None; places],
            forms: vec![zero.clone(); places],
            bounds: vec![None; places],
        };
        for set in sets {
            let digit = encoding.radices.len();
            let size = set.own.len();
            // The first place is marked when no other of the set is.
            let mut first = Form::constant(1);
            for &place in set.shared.iter() {
                first.add(-1, &encoding.forms[place]);
            }
            for (position, &place) in set.own.iter().enumerate().skip(1) {
                let table = (0..size).map(|value| i64::from(value == position)).collect();
                let form =
                    Form { constant: 0, divisor: 1, terms: vec![DigitTerm { digit, values: Values::Table(table) }] };
                first.add(-1, &form);
                encoding.forms[place] = form;
                encoding.own[place] = Some((digit, position as u32));
            }
            encoding.forms[set.own[0]] = first;
            set.own.iter().for_each(|&place| encoding.bounds[place] = Some(1));
            if size > 1 {
                encoding.radices.push(Some(size as u32));
            }
        }
        encoding
    }

    fn add_digit(&mut self, place: usize, radix: Radix) {
        let digit = self.radices.len();
        self.radices.push(radix);
        self.own[place] = Some((digit, 1));
        self.forms[place] =
            Form { constant: 0, divisor: 1, terms: vec![DigitTerm { digit, values: Values::Times(1) }] };
    }

    /// Digits for the places that are in no set, or forms where they follow from other places.
    fn add_counts(&mut self, net: &Net) {
        let left: Vec<usize> = (0..net.place_count()).filter(|&place| self.bounds[place].is_none()).collect();
        if left.is_empty() {
            return;
        }
        for invariant in positive(net, WantedSums::Any) {
            for &(place, weight) in &invariant.weights {
                let bound = u32::try_from(invariant.sum / weight).ok();
                let known = &mut self.bounds[place as usize];
                *known = [*known, bound].into_iter().flatten().min();
            }
        }
        let mut wanted: Vec<u32> = left.iter().map(|&place| place as u32).collect();
        wanted.sort_by_key(|&place| (std::cmp::Reverse(self.bounds[place as usize].unwrap_or(u32::MAX)), place));
        let sums = followers(net, &wanted);
        for &place in &left {
            if sums.iter().all(|(follower, _)| *follower as usize != place) {
                self.add_count(place);
            }
        }
        for (place, sum) in &sums {
            match self.follow(*place, sum) {
                Some(form) => self.forms[*place as usize] = form,
                // Its numbers are too large to be computed with: a digit is always right.
                None => self.add_count(*place as usize),
            }
        }
        for (place, _) in &sums {
            let place = *place as usize;
            if self.bounds[place].is_none() {
                self.bounds[place] = self.forms[place].most(&self.radices);
            }
        }
    }

    fn add_count(&mut self, place: usize) {
        let radix = self.bounds[place].and_then(|bound| bound.checked_add(1));
        if radix.is_none() {
            self.bounds[place] = None;
        }
        if radix != Some(1) {
            self.add_digit(place, radix);
        }
    }

    /// The count of a place as its sum gives it; none if the numbers are too large to be computed with.
    fn follow(&self, place: u32, sum: &Invariant) -> Option<Form> {
        let own = entry(&sum.weights, place);
        let sign = own.signum();
        let mut form = Form::constant(sum.sum.checked_mul(sign)?);
        for &(other, weight) in sum.weights.iter().filter(|&&(other, _)| other != place) {
            form.add(weight.checked_mul(-sign)?, &self.forms[other as usize]).then_some(())?;
        }
        form.divisor = own.checked_abs()?;
        let is_small = own.unsigned_abs() <= DIVISOR_MAX && form.constant.unsigned_abs() <= CONSTANT_MAX;
        is_small.then_some(form)
    }

    pub(super) fn digits(&self, marking: &Marking) -> Vec<u32> {
        let mut digits = vec![0_u32; self.radices.len()];
        for (own, &tokens) in self.own.iter().zip(marking.as_slice()) {
            if let Some((digit, weight)) = *own {
                // Only a marking of another net can be too much for a digit.
                digits[digit] = digits[digit].wrapping_add(weight.wrapping_mul(tokens));
            }
        }
        digits
    }

    /// The marking with these digits.
    pub(super) fn marking(&self, digits: &[u32]) -> Marking {
        Marking::from_tokens(self.forms.iter().map(|form| form.value(digits) as u32))
    }

    /// Change of the digits by firing a transition, without the zeros; ordered by digit.
    pub(super) fn change(&self, net: &Net, t: TransitionId) -> Vec<(usize, i64)> {
        let mut changes: Vec<(usize, i64)> = Vec::new();
        let gives = net.postset(t).iter().map(|&(place, weight)| (place, i64::from(weight)));
        let takes = net.preset(t).iter().map(|&(place, weight)| (place, -i64::from(weight)));
        for (place, tokens) in gives.chain(takes) {
            let Some((digit, weight)) = self.own[place.index()] else { continue };
            match changes.iter_mut().find(|(known, _)| *known == digit) {
                Some((_, change)) => *change += i64::from(weight) * tokens,
                None => changes.push((digit, i64::from(weight) * tokens)),
            }
        }
        changes.retain(|&(_, change)| change != 0);
        changes.sort_unstable();
        changes
    }

    /// The digit that is the count of a place, if it is one.
    pub(super) fn count_of(&self, place: usize) -> Option<usize> {
        let form = &self.forms[place];
        matches!(form.terms.as_slice(), [DigitTerm { values: Values::Times(1), .. }] if form.constant == 0 && form.divisor == 1)
            .then(|| form.terms[0].digit)
    }
}

/// Places that hold exactly one token: those that get a digit for it, and those that earlier digits distinguish.
#[derive(Clone, Debug)]
struct OneTokenSet {
    own: Vec<usize>,
    shared: Vec<usize>,
}

/// A choice of sets, ordered so that each shares only places of earlier ones, that makes short codes.
fn cover(places: usize, sums: &[Invariant]) -> Vec<OneTokenSet> {
    let sets: Vec<Vec<usize>> =
        sums.iter().map(|sum| sum.weights.iter().map(|&(place, _)| place as usize).collect()).collect();
    // Which choice is best is a hard question; the largest first is a good answer, and a few disturbed orders are
    // tried for a better one.
    let tries = (200_000 / (1 + places + sets.iter().map(Vec::len).sum::<usize>())).clamp(1, 64);
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut best: Option<(f64, Vec<OneTokenSet>)> = None;
    for attempt in 0..tries {
        let mut order: Vec<(f64, usize)> = Vec::with_capacity(sets.len());
        for (at, set) in sets.iter().enumerate() {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let noise = (seed >> 40) as f64 / (1_u64 << 24) as f64;
            let noise = if attempt == 0 { 0.0 } else { noise * set.len() as f64 };
            order.push((-(set.len() as f64) + noise, at));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (bits, chosen) = take_in_order(places, order.iter().map(|&(_, at)| &sets[at]));
        if best.as_ref().is_none_or(|(least, _)| bits < *least) {
            best = Some((bits, chosen));
        }
    }
    best.map_or(Vec::new(), |(_, chosen)| chosen)
}

fn take_in_order<'a>(places: usize, sets: impl Iterator<Item = &'a Vec<usize>>) -> (f64, Vec<OneTokenSet>) {
    let mut taken = vec![false; places];
    let mut chosen = Vec::new();
    let mut bits = 0.0;
    for set in sets {
        let (shared, own): (Vec<usize>, Vec<usize>) = set.iter().partition(|&&place| taken[place]);
        if own.is_empty() {
            continue;
        }
        own.iter().for_each(|&place| taken[place] = true);
        bits += (own.len() as f64).log2();
        chosen.push(OneTokenSet { own, shared });
    }
    (bits + taken.iter().filter(|&&taken| !taken).count() as f64, chosen)
}
