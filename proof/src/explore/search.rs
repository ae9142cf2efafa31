//! Looking at every state, breadth first.

use std::collections::VecDeque;
use std::sync::mpsc::sync_channel;
use std::thread;

use super::LineNotExplorable;
use super::progress::SearchProgress;
use super::properties::StateTally;
use super::setting::LineExploration;
use super::state::{ComposedState, FieldOverflow, StateLayout, Widths};
use super::store::{Batch, InsertResult, StateStore};
use super::successors::{Successor, Successors};
use super::system::{Granted, System};
use super::table::StateKey;
use super::verdict::{self, LineExplored};

/// Limits of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SearchLimits {
    /// At most this many states looked at, each of those that are kept once. What follows them is kept as well.
    pub states: usize,
    /// At most about this many bytes. Where they run out depends on the moment a little; the number of states does not.
    pub bytes: usize,
}

impl Default for SearchLimits {
    /// Fifty million states, three gibibytes.
    fn default() -> Self {
        SearchLimits { states: 50_000_000, bytes: 3 << 30 }
    }
}

/// What there is more of than allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitReached {
    /// States that are kept and looked at.
    States,
    /// Memory, or numbers for states, which end at some billions.
    Memory,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SearchEnd {
    /// Every state has been seen.
    Exhausted,
    /// Something is wrong in the state with this number.
    Wrong(u32),
    /// Not every state has been seen.
    Limit(LimitReached),
}

/// Result of a search.
#[derive(Debug)]
pub(crate) struct LineSearch<const N: usize> {
    pub system: System,
    pub layout: StateLayout,
    pub store: StateStore<N>,
    pub start: ComposedState,
    /// Of how many states it is known what follows them.
    pub looked_at: usize,
    /// For each state, whether all stations are at home; only where ways home and back are asked for.
    pub at_home: Vec<bool>,
    /// For each state, the mode granted and the stations that act on it; only there, too.
    pub grants: Vec<Granted>,
    /// Tally of the states explored.
    pub tally: StateTally,
    pub end: SearchEnd,
}

/// Breadth first, so that the first wrong state met is one of the nearest.
pub(crate) fn search<const N: usize>(
    system: System,
    start: ComposedState,
    widths: Widths,
    limits: SearchLimits,
    progress: &SearchProgress,
) -> Result<LineSearch<N>, Box<(System, ComposedState, FieldOverflow)>> {
    let layout = system.layout(widths);
    let (at_home, grants, tally) = (Vec::new(), Vec::new(), StateTally::default());
    let (store, end) = (StateStore::new(system.setting.asks_for_ways()), SearchEnd::Limit(LimitReached::Memory));
    let mut search = LineSearch { system, layout, store, start, looked_at: 0, at_home, grants, tally, end };
    progress.begin(limits.states);
    match search.run(limits, progress) {
        Ok(end) => {
            search.end = end;
            Ok(search)
        }
        Err(unfit) => Err(Box::new((search.system, search.start, unfit))),
    }
}

/// States whose successors are looked up together.
const BATCH: usize = 64;
/// With so many successors a batch is full.
const BATCH_KEYS_MAX: usize = 1 << 16;
/// Batches on their way from the one thread to the other.
const BATCHES_MAX: usize = 16;
/// The successors of one state may take this part of the memory. One kept state stands for many, and so may have many.
const SHARE_OF_ONE: usize = 4;

/// Why the successors of a state are incomplete.
enum SearchStop {
    Unfit(FieldOverflow),
    /// There is too much of it.
    Limit,
}

impl<const N: usize> LineSearch<N> {
    /// Two threads share the work: this one plays, the other keeps the states. States are numbered in the order in
    /// which one thread alone would meet them, so the result does not depend on how the two take turns.
    fn run(&mut self, limits: SearchLimits, progress: &SearchProgress) -> Result<SearchEnd, FieldOverflow> {
        let LineSearch { system, layout, store, start, looked_at, at_home, grants, tally, .. } = self;
        let asks_for_ways = system.setting.asks_for_ways();
        let mut here = start.clone();
        system.settle(&mut here);
        let first = layout.pack(&here)?;
        let keys_max = limits.bytes / SHARE_OF_ONE / size_of::<StateKey<N>>();
        let (successors, bytes_max) = (Successors::new(start), limits.bytes);
        let mut player = PackedPlayer { system, layout, here, successors, keys_max, bytes_max };
        thread::scope(|scope| {
            let (batches, incoming) = sync_channel::<Batch<N>>(BATCHES_MAX);
            let (entered, results) = sync_channel::<InsertResult<N>>(BATCHES_MAX);
            scope.spawn(move || {
                for batch in incoming {
                    if entered.send(store.enter(&batch, limits)).is_err() {
                        break;
                    }
                }
            });
            let mut queue = VecDeque::new();
            let mut under_way = 1;
            if batches.send(Batch { keys: vec![first], ends: Vec::new(), bytes: 0 }).is_err() {
                return Ok(SearchEnd::Limit(LimitReached::Memory));
            }
            loop {
                let wait = queue.is_empty() || under_way == BATCHES_MAX;
                let result = if wait { results.recv().ok() } else { results.try_recv().ok() };
                if let Some(result) = result {
                    under_way -= 1;
                    queue.extend(result.new);
                    if result.full {
                        return Ok(SearchEnd::Limit(LimitReached::Memory));
                    }
                    continue;
                }
                let mut batch = Batch { keys: Vec::with_capacity(BATCH * 12), ends: Vec::new(), bytes: 0 };
                while batch.ends.len() < BATCH && batch.keys.len() < BATCH_KEYS_MAX {
                    let Some(key) = queue.pop_front() else { break };
                    if *looked_at == limits.states {
                        return Ok(SearchEnd::Limit(LimitReached::States));
                    }
                    player.layout.unpack(&key, &mut player.here);
                    *looked_at += 1;
                    if asks_for_ways {
                        at_home.push(player.system.all_at_home(&player.here));
                        grants.push(player.system.granted(&player.here));
                    }
                    tally.add(player.system.tally(&player.here));
                    if player.system.wrong(&player.here).is_some() {
                        return Ok(SearchEnd::Wrong(*looked_at as u32 - 1));
                    }
                    match player.expand(&key, &mut batch) {
                        Ok(()) => {}
                        Err(SearchStop::Unfit(unfit)) => return Err(unfit),
                        Err(SearchStop::Limit) => return Ok(SearchEnd::Limit(LimitReached::Memory)),
                    }
                }
                progress.looked_at(*looked_at);
                batch.bytes = player.system.bytes() + at_home.capacity() + grants.capacity() * size_of::<Granted>();
                if batches.send(batch).is_err() {
                    return Ok(SearchEnd::Limit(LimitReached::Memory));
                }
                under_way += 1;
                while queue.is_empty() && under_way > 0 {
                    let Ok(result) = results.recv() else { return Ok(SearchEnd::Limit(LimitReached::Memory)) };
                    under_way -= 1;
                    queue.extend(result.new);
                    if result.full {
                        return Ok(SearchEnd::Limit(LimitReached::Memory));
                    }
                }
                if queue.is_empty() {
                    return Ok(SearchEnd::Exhausted);
                }
            }
        })
    }

    /// Number of states kept; each may stand for several.
    pub fn kept(&self) -> usize {
        self.store.len()
    }

    /// The state with a number, as it is kept.
    pub fn state(&self, number: u32) -> ComposedState {
        let mut state = self.start.clone();
        self.layout.unpack(self.store.key(number), &mut state);
        state
    }

    pub fn bytes(&self) -> usize {
        let flags = self.at_home.capacity() + self.grants.capacity() * size_of::<Granted>();
        self.store.bytes() + flags + self.system.bytes()
    }
}

/// Plays the line from packed state to packed state.
struct PackedPlayer<'a> {
    system: &'a mut System,
    layout: &'a StateLayout,
    here: ComposedState,
    successors: Successors,
    /// The most that may follow one state.
    keys_max: usize,
    /// The most that situations may take.
    bytes_max: usize,
}

impl PackedPlayer<'_> {
    /// Appends what follows the state taken up, each once.
    fn expand<const N: usize>(&mut self, key: &StateKey<N>, batch: &mut Batch<N>) -> Result<(), SearchStop> {
        let PackedPlayer { system, layout, here, successors, keys_max, bytes_max } = self;
        let (begin, keys) = (batch.keys.len(), &mut batch.keys);
        successors.each(system, here, &mut |follower| {
            let next = match follower.next {
                // Most moves concern no other station.
                Successor::Beside { station, to } => {
                    layout.with_situation(key, station, to).ok_or(FieldOverflow::Situation)
                }
                Successor::State(next) => layout.pack(next),
            };
            keys.push(next.map_err(SearchStop::Unfit)?);
            let too_much = keys.len() - begin > *keys_max || follower.bytes > *bytes_max;
            if too_much { Err(SearchStop::Limit) } else { Ok(()) }
        })?;
        batch.close(begin);
        Ok(())
    }
}

/// The widest that a packed state may be, in words of 64 bits.
const WORDS_MAX: usize = 64;

/// A counterexample is looked for once more among so many states that stand for themselves.
const PLAIN_STATES_MAX: usize = 1_000_000;

/// Explores and draws the conclusions.
///
/// Where each kept state stands for several, the way to the nearest wrong one of those kept need not be the shortest of
/// the line's own. The shortest is easier to read; it is looked for where that takes about a second. Nor need the
/// nearest wrong one be among the first that are kept: where the search did not come to an end, it is looked for as
/// well.
pub(crate) fn explore(
    setting: &LineExploration,
    limits: SearchLimits,
    progress: &SearchProgress,
) -> Result<LineExplored, LineNotExplorable> {
    let explored = fit(setting, limits, progress)?;
    if !setting.lumped || explored.exhausted {
        return Ok(explored);
    }
    let plain = LineExploration { lumped: false, ..setting.clone() };
    progress.looks_again(true);
    let again = fit(&plain, SearchLimits { states: limits.states.min(PLAIN_STATES_MAX), ..limits }, progress);
    progress.looks_again(false);
    let again = again?;
    Ok(if again.exhausted || again.counterexample().is_some() { again } else { explored })
}

/// Explores with fields as narrow as they turn out to be possible.
fn fit(
    setting: &LineExploration,
    limits: SearchLimits,
    progress: &SearchProgress,
) -> Result<LineExplored, LineNotExplorable> {
    let (mut system, mut start) = System::new(setting)?;
    let mut widths = Widths::FIRST;
    loop {
        let found = match system.layout(widths).words64 {
            0..=2 => attempt::<2>(system, start, widths, limits, progress),
            3 => attempt::<3>(system, start, widths, limits, progress),
            4 => attempt::<4>(system, start, widths, limits, progress),
            5..=8 => attempt::<8>(system, start, widths, limits, progress),
            9..=WORDS_MAX => attempt::<WORDS_MAX>(system, start, widths, limits, progress),
            found => return Err(LineNotExplorable::State { found, max: WORDS_MAX }),
        };
        let why;
        (system, start, why) = match found {
            Ok(explored) => return Ok(explored),
            Err(unfit) => *unfit,
        };
        widths = widths.wider(why);
    }
}

fn attempt<const N: usize>(
    system: System,
    start: ComposedState,
    widths: Widths,
    limits: SearchLimits,
    progress: &SearchProgress,
) -> Result<LineExplored, Box<(System, ComposedState, FieldOverflow)>> {
    search::<N>(system, start, widths, limits, progress).map(verdict::judge)
}
