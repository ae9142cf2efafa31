//! Modes of a transition that the tokens at hand allow, without trying all modes.
//!
//! A transition of a universal domain has thousands of modes, and a marking a handful of tokens; so the search begins
//! with the tokens (seed 000, §7.2.3, L3747: the tokens in the pre-places determine the possible firing modes). Each
//! term of an input arc takes exactly one colour in a given mode. Choosing a token for the term therefore fixes those
//! components of the mode that the term reads; once no term can fix another component, what is still open is enumerated.
//!
//! The order of the terms is fixed when the net is built. Every mode is met once: the tokens chosen follow from it.

use super::linear::{ComponentPick, LinearTerm, turn};
use super::marking::{collect, count_in};
use super::net::{ColouredArc, ColouredNet, ColouredPlace};
use crate::PlaceId;

/// A component of a mode that is not fixed yet. No tone has this number: tones from 0 are less than a size.
const OPEN: u32 = u32::MAX;

/// The order in which the components of a mode are fixed.
#[derive(Clone, Debug, Default)]
pub(super) struct BindingOrder {
    /// A place with tokens to be tried, and the tones from each token; each fixes a component that the ones before do
    /// not.
    asks: Vec<(PlaceId, Box<[ComponentPick]>)>,
    /// The components that no input reads.
    free: Vec<u32>,
}

impl BindingOrder {
    /// The terms that fix most come first.
    pub(super) fn new(inputs: &[ColouredArc], components: usize) -> BindingOrder {
        let mut fixed = vec![false; components];
        let mut asks = Vec::new();
        let terms = || inputs.iter().flat_map(|side| side.terms.iter().map(move |term| (side.place, &term.picks)));
        loop {
            let gain = |picks: &[ComponentPick]| {
                let mut new: Vec<u32> = picks.iter().map(|pick| pick.from).filter(|&k| !fixed[k as usize]).collect();
                new.sort_unstable();
                new.dedup();
                new.len()
            };
            // Of equals the first, so that the order is that of declaration.
            let best = terms().rev().max_by_key(|(_, picks)| gain(picks));
            let Some((place, picks)) = best.filter(|(_, picks)| gain(picks) > 0) else { break };
            picks.iter().for_each(|pick| fixed[pick.from as usize] = true);
            asks.push((place, picks.clone()));
        }
        let free = (0..components as u32).filter(|&k| !fixed[k as usize]).collect();
        BindingOrder { asks, free }
    }
}

/// The entries of a marking that lie on a place.
pub(super) fn on_place<'a>(entries: &'a [(u32, u32)], place: &ColouredPlace) -> &'a [(u32, u32)] {
    let start = entries.partition_point(|&(cell, _)| cell < place.offset);
    let rest = &entries[start..];
    let end = rest.partition_point(|&(cell, _)| cell - place.offset < place.shape.count);
    &rest[..end]
}

/// The modes of one transition that a marking and the guard enable.
pub(super) struct BindingSearch<'a> {
    net: &'a ColouredNet,
    transition: usize,
    entries: &'a [(u32, u32)],
    /// Whether a token that is there is there as often as needed.
    endless: bool,
    mode: Vec<u32>,
    found: &'a mut Vec<u32>,
    /// Most modes to find.
    most: usize,
}

/// Appends the colours of the modes of a transition that are enabled in a marking, ascending; at most about `most`.
///
/// With `endless`, the marking gives only which cells are marked, and each of those has tokens enough.
pub(super) fn enabled(
    net: &ColouredNet,
    transition: usize,
    entries: &[(u32, u32)],
    endless: bool,
    most: usize,
    found: &mut Vec<u32>,
) {
    let components = net.transitions[transition].shape.sizes.len();
    let start = found.len();
    let most = start.saturating_add(most);
    let mut search = BindingSearch { net, transition, entries, endless, mode: vec![OPEN; components], found, most };
    search.ask(0);
    found[start..].sort_unstable();
}

impl BindingSearch<'_> {
    /// Fixes components by the tokens of the plan from step `at` on.
    fn ask(&mut self, at: usize) {
        // A copy of the reference, so that the plan can be read while the search changes.
        let net = self.net;
        let Some((place, picks)) = net.transitions[self.transition].plan.asks.get(at) else {
            return self.choose(0);
        };
        let place = &net.places[place.index()];
        let mut tones = vec![0; picks.len()];
        let before = self.mode.clone();
        for &(cell, _) in on_place(self.entries, place) {
            place.shape.decode(cell - place.offset, &mut tones);
            if self.fix(picks, &tones, &place.shape.sizes) {
                self.ask(at + 1);
            }
            self.mode.copy_from_slice(&before);
            if self.found.len() >= self.most {
                return;
            }
        }
    }

    /// Makes a term give this token; false if a component would have to have two values.
    fn fix(&mut self, picks: &[ComponentPick], token: &[u32], sizes: &[u32]) -> bool {
        picks.iter().zip(token).zip(sizes).all(|((pick, &tone), &size)| {
            let back = if pick.shift == 0 { 0 } else { size - pick.shift };
            let wanted = turn(tone, back, size);
            let known = &mut self.mode[pick.from as usize];
            if *known == OPEN {
                *known = wanted;
            }
            *known == wanted
        })
    }

    /// Tries every tone for the free components from number `at` on.
    fn choose(&mut self, at: usize) {
        let net = self.net;
        let transition = &net.transitions[self.transition];
        let Some(&component) = transition.plan.free.get(at) else {
            if transition.allows(&self.mode) && self.covered() {
                self.found.push(transition.shape.encode(&self.mode));
            }
            return;
        };
        for tone in 0..transition.shape.sizes[component as usize] {
            self.mode[component as usize] = tone;
            self.choose(at + 1);
            if self.found.len() >= self.most {
                break;
            }
        }
        self.mode[component as usize] = OPEN;
    }

    /// Whether the marking has what the mode takes (seed 000, definition 14).
    fn covered(&self) -> bool {
        self.net.transitions[self.transition].inputs.iter().all(|side| {
            let place = &self.net.places[side.place.index()];
            let entry = |term: &LinearTerm| (place.offset + term.apply(&self.mode, &place.shape), term.weight as u32);
            let has = |&(cell, needs): &(u32, u32)| {
                let has = count_in(self.entries, cell);
                if self.endless { has > 0 } else { has >= needs }
            };
            if let [term] = &side.terms[..] {
                return has(&entry(term));
            }
            // Several terms of one arc may meet in one colour.
            let mut takes: Vec<_> = side.terms.iter().map(entry).collect();
            collect(&mut takes).is_ok() && takes.iter().all(has)
        })
    }
}
