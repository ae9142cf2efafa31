//! Closing a bitmap under firing, on one thread or several.
//!
//! Two bits belong to each marking: it has been seen, and it has been fired. Sweeps over the words fire what has been
//! seen and not fired until there is nothing left. A sweep visits memory in order, along one stream per transition; and
//! a word that is reached from several sides within a sweep is fired once for all of them.
//!
//! Threads take blocks of words from a common counter. Only one thread has a word at a time and marks it as fired; any
//! may see markings in it. The set that results is the least one closed under firing, and each marking in it is fired
//! exactly once: sums over markings do not depend on the distribution of the work.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::thread;

use super::bitmap::{Cursor, Kernel, WordForm};

/// Words that a thread takes at a time: half of a first-level cache. Unit tests make threads meet in small nets.
const BLOCK: usize = if cfg!(test) { 1 } else { 2048 };
/// Fewer words are not worth a second thread.
const WORDS_PER_THREAD: usize = if cfg!(test) { 1 } else { 16 * BLOCK };

/// One bit per code.
pub(super) type Bitmap = Vec<AtomicU64>;

/// An empty set.
pub(super) fn bitmap(words: usize) -> Bitmap {
    (0..words).map(|_| AtomicU64::new(0)).collect()
}

/// Findings of firing.
#[derive(Clone, Debug)]
pub(super) struct SweepTally {
    pub(super) states: u64,
    pub(super) arcs: u64,
    pub(super) deadlocks: u64,
    /// The first in the order of codes.
    pub(super) deadlock: Option<(usize, u32)>,
    /// By rule, as bits.
    pub(super) fired: Vec<u64>,
    /// By place.
    pub(super) bounds: Vec<u32>,
}

impl SweepTally {
    fn new(rules: usize, places: usize) -> Self {
        let fired = vec![0; rules.div_ceil(64).max(1)];
        SweepTally { states: 0, arcs: 0, deadlocks: 0, deadlock: None, fired, bounds: vec![0; places] }
    }

    fn add(&mut self, other: &SweepTally) {
        self.states += other.states;
        self.arcs += other.arcs;
        self.deadlocks += other.deadlocks;
        self.deadlock = [self.deadlock, other.deadlock].into_iter().flatten().min();
        self.fired.iter_mut().zip(&other.fired).for_each(|(own, other)| *own |= other);
        self.bounds.iter_mut().zip(&other.bounds).for_each(|(own, &other)| *own = other.max(*own));
    }
}

/// A closure under firing.
pub(super) struct Closure<'a> {
    pub(super) kernel: &'a Kernel,
    /// Markings seen; starts with the initial set.
    pub(super) seen: &'a Bitmap,
    /// Markings fired; starts empty.
    pub(super) fired: &'a Bitmap,
    /// Markings outside do not count as seen.
    pub(super) within: Option<&'a Bitmap>,
    /// The counts of the places whose bounds are to be found, and the bounds that cannot be exceeded.
    pub(super) forms: &'a [WordForm],
    pub(super) bounds: &'a [u32],
    pub(super) limit_states: u64,
}

impl Closure<'_> {
    /// Runs to the end; none if there are more states than allowed.
    pub(super) fn run(&self, threads: usize) -> Option<SweepTally> {
        let threads = threads.clamp(1, (self.seen.len() / WORDS_PER_THREAD).max(1));
        let mut workers: Vec<Worker> = (0..threads).map(|_| Worker::new(self)).collect();
        let states = AtomicU64::new(0);
        // Mostly upwards or mostly downwards: along the way that most firings go.
        let upwards = self.kernel.rules.iter().map(|rule| rule.jump.signum()).sum::<isize>() >= 0;
        loop {
            let sweep = Sweep { next: AtomicUsize::new(0), moved: AtomicBool::new(false), states: &states, upwards };
            match workers.as_mut_slice() {
                [only] => only.sweep::<false>(self, &sweep),
                [first, others @ ..] => thread::scope(|scope| {
                    for worker in others {
                        scope.spawn(|| worker.sweep::<true>(self, &sweep));
                    }
                    first.sweep::<true>(self, &sweep);
                }),
                [] => {}
            }
            if states.load(Relaxed) > self.limit_states {
                return None;
            }
            if !sweep.moved.load(Relaxed) {
                break;
            }
        }
        let mut tally = SweepTally::new(self.kernel.rules.len(), self.forms.len());
        workers.iter().for_each(|worker| tally.add(&worker.tally));
        Some(tally)
    }
}

/// One pass over the words.
struct Sweep<'a> {
    next: AtomicUsize,
    moved: AtomicBool,
    states: &'a AtomicU64,
    upwards: bool,
}

/// State of one thread.
struct Worker<'a> {
    cursor: Cursor<'a>,
    tally: SweepTally,
    /// The places whose bound has not been reached yet.
    open: Vec<usize>,
}

impl<'a> Worker<'a> {
    fn new(closure: &Closure<'a>) -> Self {
        let places = closure.forms.len();
        let tally = SweepTally::new(closure.kernel.rules.len(), places);
        let open = (0..places).filter(|&place| closure.bounds[place] > 0).collect();
        Worker { cursor: closure.kernel.cursor(), tally, open }
    }

    fn sweep<const SHARED: bool>(&mut self, closure: &Closure, sweep: &Sweep) {
        let words = closure.seen.len();
        let blocks = words.div_ceil(BLOCK);
        loop {
            let block = sweep.next.fetch_add(1, Relaxed);
            if block >= blocks || sweep.states.load(Relaxed) > closure.limit_states {
                return;
            }
            let block = if sweep.upwards { block } else { blocks - 1 - block };
            let range = block * BLOCK..((block + 1) * BLOCK).min(words);
            let before = self.tally.states;
            if sweep.upwards {
                range.for_each(|word| self.word::<SHARED>(closure, word));
            } else {
                range.rev().for_each(|word| self.word::<SHARED>(closure, word));
            }
            if self.tally.states > before {
                sweep.states.fetch_add(self.tally.states - before, Relaxed);
                sweep.moved.store(true, Relaxed);
            }
        }
    }

    /// Fires all that is new in a word, and what that makes new in it.
    #[inline]
    fn word<const SHARED: bool>(&mut self, closure: &Closure, word: usize) {
        let mut fired = closure.fired[word].load(Relaxed);
        let mut new = closure.seen[word].load(Relaxed) & !fired;
        if new == 0 {
            return;
        }
        self.cursor.go(word);
        while new != 0 {
            fired |= new;
            self.fire::<SHARED>(closure, word, new);
            new = closure.seen[word].load(Relaxed) & !fired;
        }
        closure.fired[word].store(fired, Relaxed);
    }

    #[inline]
    fn fire<const SHARED: bool>(&mut self, closure: &Closure, word: usize, new: u64) {
        let mut stuck = new;
        let digits = &self.cursor.digits;
        for (at, &set) in self.cursor.candidates().iter().enumerate() {
            let mut rest = set;
            let mut fired = 0;
            while rest != 0 {
                let rule = &closure.kernel.rules[at * 64 + rest.trailing_zeros() as usize];
                let bit = rest & rest.wrapping_neg();
                rest ^= bit;
                let mut enabled = new & rule.low;
                for condition in &rule.mixed {
                    enabled &= condition.mask(digits);
                }
                if enabled == 0 {
                    continue;
                }
                fired |= bit;
                stuck &= !enabled;
                self.tally.arcs += u64::from(enabled.count_ones());
                let target = word.wrapping_add_signed(rule.jump);
                see::<SHARED>(closure, target, rule.moved(enabled));
            }
            self.tally.fired[at] |= fired;
        }
        self.tally.states += u64::from(new.count_ones());
        if stuck != 0 {
            self.tally.deadlocks += u64::from(stuck.count_ones());
            let first = (word, stuck.trailing_zeros());
            self.tally.deadlock = Some(self.tally.deadlock.map_or(first, |known| known.min(first)));
        }
        let (bounds, digits) = (&mut self.tally.bounds, &self.cursor.digits);
        self.open.retain(|&place| {
            bounds[place] = bounds[place].max(closure.forms[place].most(digits, new));
            bounds[place] < closure.bounds[place]
        });
    }
}

#[inline]
fn see<const SHARED: bool>(closure: &Closure, target: usize, mut bits: u64) {
    if let Some(within) = closure.within {
        bits &= within[target].load(Relaxed);
    }
    let seen = &closure.seen[target];
    let known = seen.load(Relaxed);
    if bits & !known == 0 {
        return;
    }
    if SHARED {
        seen.fetch_or(bits, Relaxed);
    } else {
        seen.store(known | bits, Relaxed);
    }
}
