//! Decides a net whose markings fit a bitmap.
//!
//! Forwards from the initial marking, counting; backwards from it within what was found, which decides reversibility;
//! and only for nets that are not reversible, the terminal components of the rest.

use std::sync::atomic::Ordering::Relaxed;

use super::bitmap::{BitmapLayout, Kernel, word_forms};
use super::encoding::MarkingEncoding;
use super::facts::{Home, NetFacts, Storage, WitnessMarking};
use super::limits::{ExplorationLimit, ExplorationLimits, ExplorationUndecided, MemoryBudget};
use super::path::path_to;
use super::rules::PlayDirection;
use super::space::{BitmapSpace, Space};
use super::sweep::{Bitmap, Closure, SweepTally, bitmap};
use super::terminal::terminal;
use crate::{Marking, Net};

/// Bytes that the two bitmaps take that every decision needs.
pub(super) fn bytes(layout: &BitmapLayout) -> usize {
    layout.words.saturating_mul(2 * size_of::<u64>())
}

/// State numbers have 32 bits.
const STATES_MAX: u64 = u32::MAX as u64 - 2;

/// As [`super::decide`].
pub(super) fn decide(
    net: &Net,
    encoding: &MarkingEncoding,
    layout: &BitmapLayout,
    limits: &ExplorationLimits,
) -> Result<NetFacts, ExplorationUndecided> {
    let limit = limits.states.min(STATES_MAX);
    let mut budget = MemoryBudget::new(limits.bytes);
    budget.take(bytes(layout), 0)?;
    let (seen, fired) = (bitmap(layout.words), bitmap(layout.words));
    let start = layout.locate(&encoding.digits(&net.initial_marking()));
    seen[start.0].store(1 << start.1, Relaxed);
    let forth = Kernel::new(net, encoding, layout, PlayDirection::Fire);
    let bounds: Vec<u32> = encoding.bounds.iter().map(|bound| bound.unwrap_or(u32::MAX)).collect();
    let closure = Closure {
        kernel: &forth,
        seen: &seen,
        fired: &fired,
        within: None,
        forms: &word_forms(encoding, layout),
        bounds: &bounds,
        limit_states: limit,
    };
    let undecided = ExplorationUndecided { states: limit, cause: ExplorationLimit::States { limit } };
    let tally = closure.run(limits.threads).ok_or(undecided)?;
    let mut bitmaps = Bitmaps { net, encoding, layout, forth, seen, spare: fired, budget };
    let returning = bitmaps.returning(start, limits.threads, tally.states)?;
    bitmaps.conclude(tally, start, &returning)
}

/// The reachable markings and what belongs to them.
struct Bitmaps<'a> {
    net: &'a Net,
    encoding: &'a MarkingEncoding,
    layout: &'a BitmapLayout,
    forth: Kernel,
    seen: Bitmap,
    /// No longer needed for its contents.
    spare: Bitmap,
    budget: MemoryBudget,
}

impl Bitmaps<'_> {
    /// The reachable markings from which the initial one can be reached.
    fn returning(&mut self, start: (usize, u32), threads: usize, states: u64) -> Result<Bitmap, ExplorationUndecided> {
        self.budget.take(self.layout.words * size_of::<u64>(), states)?;
        let returning = bitmap(self.layout.words);
        returning[start.0].store(1 << start.1, Relaxed);
        self.spare.iter().for_each(|word| word.store(0, Relaxed));
        let closure = Closure {
            kernel: &Kernel::new(self.net, self.encoding, self.layout, PlayDirection::FireBack),
            seen: &returning,
            fired: &self.spare,
            within: Some(&self.seen),
            forms: &[],
            bounds: &[],
            limit_states: u64::MAX,
        };
        closure.run(threads);
        Ok(returning)
    }

    fn marking(&self, at: (usize, u32)) -> Marking {
        self.layout.marking(at.0, at.1, self.encoding)
    }

    fn conclude(
        mut self,
        tally: SweepTally,
        start: (usize, u32),
        returning: &Bitmap,
    ) -> Result<NetFacts, ExplorationUndecided> {
        let transitions = self.net.transition_count();
        let mut fires = vec![false; transitions];
        for (at, rule) in self.forth.rules.iter().enumerate() {
            fires[rule.transition as usize] = tally.fired[at / 64] >> (at % 64) & 1 != 0;
        }
        let strays = self.seen.iter().zip(returning).map(|(seen, back)| seen.load(Relaxed) & !back.load(Relaxed));
        let stray = strays.enumerate().find(|&(_, bits)| bits != 0).map(|(word, bits)| (word, bits.trailing_zeros()));
        let initial = self.net.initial_marking();
        let mut facts = NetFacts {
            states: tally.states,
            arcs: tally.arcs,
            deadlocks: tally.deadlocks,
            deadlock: None,
            bounds: tally.bounds,
            lost: fires.iter().map(|fires| (!fires).then(|| initial.clone())).collect(),
            fires,
            no_return: stray.map(|at| self.marking(at)),
            terminal_components: 1,
            home: Some(Home { states: tally.states, example: initial }),
            storage: Storage::Bitmap { codes: self.layout.codes(self.encoding) },
            bytes: 0,
        };
        if stray.is_some() {
            self.spare = Bitmap::new();
            self.budget.give_back(self.layout.words * size_of::<u64>());
            self.budget.take(BitmapSpace::bytes(self.layout.words), tally.states)?;
            let mut space = BitmapSpace::new(self.encoding, self.layout, &self.forth, &self.seen);
            let parts = terminal(
                &mut space,
                transitions,
                |space: &BitmapSpace, state| {
                    let (word, bit) = space.place_of(state);
                    returning[word].load(Relaxed) >> bit & 1 != 0
                },
                &mut self.budget,
            )?;
            facts.lost = parts.lost.iter().map(|lost| lost.map(|state| space.marking(state))).collect();
            facts.terminal_components = parts.count;
            facts.home = parts
                .first
                .filter(|_| parts.count == 1)
                .map(|part| Home { states: part.states, example: space.marking(part.first) });
            if let Some((word, bit)) = tally.deadlock {
                let (from, to) = (space.number(start.0, start.1), space.number(word, bit));
                let path = path_to(&mut space, from, to, &mut self.budget)?;
                facts.deadlock = Some(WitnessMarking { marking: self.marking((word, bit)), path });
            }
        } else if let Some(at) = tally.deadlock {
            // The initial marking is the only one.
            facts.deadlock = Some(WitnessMarking { marking: self.marking(at), path: Vec::new() });
        }
        facts.bytes = self.budget.peak();
        Ok(facts)
    }
}
