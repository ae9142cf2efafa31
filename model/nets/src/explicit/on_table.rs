//! Deciding a net with its markings in a table: the same questions as over a bitmap, one marking at a time.

use super::encoding::MarkingEncoding;
use super::facts::{Home, NetFacts, Storage, WitnessMarking};
use super::limits::{ExplorationLimits, ExplorationUndecided};
use super::space::TableSpace;
use super::table::MarkingTable;
use super::terminal::terminal;
use crate::{Marking, Net, TransitionId};

/// As [`super::decide`].
pub(super) fn decide(
    net: &Net,
    encoding: &MarkingEncoding,
    limits: &ExplorationLimits,
) -> Result<NetFacts, ExplorationUndecided> {
    decide_in(MarkingTable::new(net, encoding, limits)?, net, encoding)
}

/// With a table of the initial marking.
pub(super) fn decide_in(
    mut table: MarkingTable,
    net: &Net,
    encoding: &MarkingEncoding,
) -> Result<NetFacts, ExplorationUndecided> {
    let mut facts = explore(net, encoding, &mut table)?;
    let returning = returning(&mut table)?;
    if let Some(stray) = returning.iter().position(|&back| !back) {
        facts.no_return = Some(table.marking(stray as u32));
        let mut budget = table.budget;
        let mut space = TableSpace { table: &table, scratch: table.scratch() };
        let skip = |_: &TableSpace, state: u32| returning[state as usize];
        let parts = terminal(&mut space, net.transition_count(), skip, &mut budget)?;
        facts.lost = parts.lost.iter().map(|lost| lost.map(|state| table.marking(state))).collect();
        facts.terminal_components = parts.count;
        facts.home = parts
            .first
            .filter(|_| parts.count == 1)
            .map(|part| Home { states: part.states, example: table.marking(part.first) });
        facts.bytes = budget.peak();
    } else {
        facts.bytes = table.budget.peak();
    }
    Ok(facts)
}

/// Fires everything at every marking, and counts.
fn explore(net: &Net, encoding: &MarkingEncoding, table: &mut MarkingTable) -> Result<NetFacts, ExplorationUndecided> {
    let mut scratch = table.scratch();
    let mut fires = vec![false; net.transition_count()];
    let (mut arcs, mut deadlocks, mut deadlock) = (0, 0, None);
    let mut bounds = SeenMaxima::new(encoding);
    let mut state = 0;
    while (state as usize) < table.len() {
        bounds.see(encoding, table.digits(state, &mut scratch));
        let fired = table.expand(state, &mut scratch, |transition, _, _| fires[transition as usize] = true)?;
        arcs += fired as u64;
        if fired == 0 {
            deadlocks += 1;
            deadlock = deadlock.or(Some(state));
        }
        state += 1;
    }
    let initial = net.initial_marking();
    let states = table.len() as u64;
    Ok(NetFacts {
        states,
        arcs,
        deadlocks,
        deadlock: deadlock.map(|state| found(table, state)),
        bounds: bounds.finish(encoding),
        lost: fires.iter().map(|fires| (!fires).then(|| initial.clone())).collect(),
        fires,
        no_return: None,
        terminal_components: 1,
        home: Some(Home { states, example: initial }),
        storage: Storage::Table { bits: table.bits() },
        bytes: 0,
    })
}

/// A marking with a shortest way to it. The search was breadth first, so of the markings one step before it, the first
/// that was found is one step nearer to the start.
pub(super) fn found(table: &MarkingTable, state: u32) -> WitnessMarking {
    let mut scratch = table.scratch();
    let mut path = Vec::new();
    let mut at = state;
    while at != 0 {
        let mut best = (at, 0);
        table.predecessors(at, &mut scratch, |transition, from| best = best.min((from, transition)));
        path.push(TransitionId(best.1));
        at = best.0;
    }
    path.reverse();
    WitnessMarking { marking: table.marking(state), path }
}

/// Per marking, whether the initial one can be reached from it.
fn returning(table: &mut MarkingTable) -> Result<Vec<bool>, ExplorationUndecided> {
    let states = table.len();
    // The marks and, at worst, a stack of all.
    table.budget.take(states * (size_of::<bool>() + size_of::<u32>()), states as u64)?;
    let mut scratch = table.scratch();
    let mut returning = vec![false; states];
    let mut stack = Vec::with_capacity(states);
    returning[0] = true;
    stack.push(0);
    while let Some(state) = stack.pop() {
        table.predecessors(state, &mut scratch, |_, from| {
            if !std::mem::replace(&mut returning[from as usize], true) {
                stack.push(from);
            }
        });
    }
    drop(stack);
    table.budget.give_back(states * size_of::<u32>());
    Ok(returning)
}

/// The most that each place has held so far.
struct SeenMaxima {
    /// By place.
    most: Vec<u32>,
    digits: Vec<u32>,
    /// Places that are not a digit and have not held the most that they can.
    open: Vec<usize>,
}

impl SeenMaxima {
    fn new(encoding: &MarkingEncoding) -> Self {
        let places = encoding.forms.len();
        let open = (0..places).filter(|&place| encoding.count_of(place).is_none() && encoding.bounds[place] != Some(0));
        SeenMaxima { most: vec![0; places], digits: vec![0; encoding.radices.len()], open: open.collect() }
    }

    #[inline]
    fn see(&mut self, encoding: &MarkingEncoding, digits: &[u32]) {
        self.digits.iter_mut().zip(digits).for_each(|(most, &digit)| *most = digit.max(*most));
        let most = &mut self.most;
        self.open.retain(|&place| {
            most[place] = most[place].max(encoding.forms[place].value(digits) as u32);
            encoding.bounds[place].is_none_or(|bound| most[place] < bound)
        });
    }

    fn finish(mut self, encoding: &MarkingEncoding) -> Vec<u32> {
        for (place, most) in self.most.iter_mut().enumerate() {
            if let Some(digit) = encoding.count_of(place) {
                *most = self.digits[digit];
            }
        }
        self.most
    }
}

/// The counts of a marking, read where they are stored.
#[derive(Clone, Copy, Debug)]
pub struct MarkingView<'a> {
    pub(super) encoding: &'a MarkingEncoding,
    pub(super) digits: &'a [u32],
}

impl MarkingView<'_> {
    /// The tokens on a place.
    ///
    /// # Panics
    /// When the net has no such place.
    pub fn tokens(&self, place: crate::PlaceId) -> u32 {
        self.encoding.forms[place.index()].value(self.digits) as u32
    }

    /// The whole marking.
    pub fn to_marking(&self) -> Marking {
        self.encoding.marking(self.digits)
    }
}
