//! When transitions fire, by digits.
//!
//! For either way of playing the net, each transition has conditions (a sum of terms, each of one digit, must not be
//! less than a number) and a constant change of the digits. Conditions on one digit alone are the rule, and are turned
//! into a [`Filter`]: per value of a digit, the set of transitions that it does not rule out. A transition that remains
//! after all digits is nearly always enabled.

use super::encoding::{DigitTerm, MarkingEncoding, Radix, TABLE_MAX};
use crate::{Net, PlaceId, TransitionId};

/// One transition, played one way.
#[derive(Debug)]
pub(super) struct FiringRule {
    pub(super) transition: TransitionId,
    pub(super) conditions: Vec<LinearCondition>,
    /// Change of the digits, without the zeros; ordered by digit.
    pub(super) change: Vec<(usize, i64)>,
    /// Places that get more tokens and are not known to be bounded, with what they get.
    pub(super) growing: Vec<(PlaceId, i64)>,
}

/// Σ terms ≥ need.
#[derive(Clone, Debug)]
pub(super) struct LinearCondition {
    pub(super) terms: Vec<DigitTerm>,
    pub(super) need: i64,
}

impl LinearCondition {
    /// Whether it holds.
    #[inline]
    pub(super) fn holds(&self, digits: &[u32]) -> bool {
        self.terms.iter().map(|term| term.of(digits[term.digit])).sum::<i64>() >= self.need
    }

    /// The digit, if there is but one.
    pub(super) fn digit(&self) -> Option<usize> {
        if let [term] = self.terms.as_slice() { Some(term.digit) } else { None }
    }

    /// The least and the most that the sum can be, by the radices.
    fn range(&self, radices: &[Radix]) -> Option<(i64, i64)> {
        let mut range = (0, 0);
        for term in &self.terms {
            let radix = radices[term.digit].filter(|&radix| radix <= TABLE_MAX)?;
            let values = || (0..radix).map(|value| term.of(value));
            range = (range.0 + values().min()?, range.1 + values().max()?);
        }
        Some(range)
    }
}

/// Direction in which transitions are played.
#[derive(Clone, Copy)]
pub(super) enum PlayDirection {
    Fire,
    FireBack,
}

/// The rules of all transitions that can ever fire that way, in order.
pub(super) fn rules(net: &Net, encoding: &MarkingEncoding, direction: PlayDirection) -> Vec<FiringRule> {
    net.transitions().filter_map(|t| rule(net, encoding, direction, t)).collect()
}

fn rule(net: &Net, encoding: &MarkingEncoding, direction: PlayDirection, t: TransitionId) -> Option<FiringRule> {
    let (takes, gives, sign) = match direction {
        PlayDirection::Fire => (net.preset(t), net.postset(t), 1),
        PlayDirection::FireBack => (net.postset(t), net.preset(t), -1),
    };
    let mut conditions = Vec::new();
    for &(place, weight) in takes {
        let form = &encoding.forms[place.index()];
        let need = i64::from(weight) * form.divisor - form.constant;
        let condition = LinearCondition { terms: form.terms.clone(), need };
        match condition.range(&encoding.radices) {
            Some((least, _)) if least >= need => {}
            Some((_, most)) if most < need => return None,
            _ => conditions.push(condition),
        }
    }
    let growing = gives.iter().filter(|(place, _)| encoding.bounds[place.index()].is_none());
    let growing = growing.filter_map(|&(place, weight)| {
        let taken = takes.binary_search_by_key(&place, |&(place, _)| place).map_or(0, |at| takes[at].1);
        let gets = i64::from(weight) - i64::from(taken);
        (gets > 0).then_some((place, gets))
    });
    let mut change = encoding.change(net, t);
    change.iter_mut().for_each(|(_, by)| *by *= sign);
    Some(FiringRule { transition: t, conditions, change, growing: growing.collect() })
}

/// Per value of each digit, the rules that it does not rule out, as bits.
#[derive(Debug)]
pub(super) struct Filter {
    /// Words per set.
    pub(super) width: usize,
    /// By digit, then value; empty for a digit that rules nothing out.
    tables: Vec<Vec<u64>>,
    /// All rules.
    all: Vec<u64>,
}

impl Filter {
    /// Takes over, and removes from the rules, the conditions on one digit that `covers` accepts and that is not
    /// larger than a table may be.
    pub(super) fn take(rules: &mut [FiringRule], radices: &[Radix], covers: impl Fn(usize) -> bool) -> Self {
        let width = rules.len().div_ceil(64).max(1);
        let mut all = vec![0; width];
        (0..rules.len()).for_each(|rule| all[rule / 64] |= 1 << (rule % 64));
        let mut tables: Vec<Vec<u64>> = vec![Vec::new(); radices.len()];
        for (at, rule) in rules.iter_mut().enumerate() {
            rule.conditions.retain(|condition| {
                let digit = condition.digit().filter(|&digit| covers(digit));
                let Some((digit, radix)) = digit.and_then(|d| Some((d, radices[d].filter(|&r| r <= TABLE_MAX)?)))
                else {
                    return true;
                };
                if tables[digit].is_empty() {
                    tables[digit] = (0..radix).flat_map(|_| all.iter().copied()).collect();
                }
                for value in (0..radix).filter(|&value| condition.terms[0].of(value) < condition.need) {
                    tables[digit][value as usize * width + at / 64] &= !(1 << (at % 64));
                }
                false
            });
        }
        Filter { width, tables, all }
    }

    /// All rules.
    pub(super) fn all(&self) -> &[u64] {
        &self.all
    }

    /// The rules that a value of a digit does not rule out; none if the digit never rules out any.
    #[inline]
    pub(super) fn of(&self, digit: usize, value: u32) -> Option<&[u64]> {
        let table = &self.tables[digit];
        let start = value as usize * self.width;
        if table.is_empty() { None } else { Some(&table[start..start + self.width]) }
    }
}
