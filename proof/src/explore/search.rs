//! Looking at every state, breadth first, and telling whether home can be reached from each.

use std::collections::VecDeque;
use std::sync::mpsc::sync_channel;
use std::thread;

use linewright_line::net::ControlMode;

use super::setting::{Grants, Setting};
use super::state::{Layout, State, Unfit, Widths};
use super::system::{Granted, Move, System};
use super::table::{Key, Table};

/// How far a search may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// At most this many states.
    pub states: usize,
    /// At most about this many bytes.
    pub bytes: usize,
}

impl Default for Limits {
    /// Fifty million states, three gibibytes.
    fn default() -> Self {
        Limits { states: 50_000_000, bytes: 3 << 30 }
    }
}

/// Why a search ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// Every state has been seen.
    Exhausted,
    /// Something is wrong in the state with this number.
    Wrong(u32),
    /// There are more states, or they take more memory, than allowed.
    Limit,
}

/// What a search has seen.
#[derive(Debug)]
pub(crate) struct Search<const N: usize> {
    pub system: System,
    pub layout: Layout,
    pub store: Store<N>,
    pub start: State,
    at_home: Vec<bool>,
    /// For each state, the mode granted and who acts on it.
    grants: Vec<Granted>,
    pub end: End,
}

/// States and what follows them, by number.
#[derive(Debug)]
pub(crate) struct Store<const N: usize> {
    table: Table<N>,
    /// For each state, the one it was first reached from.
    came_from: Vec<u32>,
    /// The numbers of the states that follow each, one state after the other.
    arcs: Vec<u32>,
    /// Where those of each state end.
    arcs_until: Vec<u64>,
    scratch: Vec<(u64, u64)>,
}

/// Breadth first, so that the first wrong state met is one of the nearest.
pub(crate) fn search<const N: usize>(
    system: System,
    start: State,
    widths: Widths,
    limits: Limits,
) -> Result<Search<N>, Box<(System, State, Unfit)>> {
    let layout = system.layout(widths);
    let mut search =
        Search { system, layout, store: Store::new(), start, at_home: Vec::new(), grants: Vec::new(), end: End::Limit };
    match search.run(limits) {
        Ok(end) => {
            search.end = end;
            Ok(search)
        }
        Err(unfit) => Err(Box::new((search.system, search.start, unfit))),
    }
}

/// States whose successors are looked up together.
const BATCH: usize = 64;
/// Batches on their way from the one thread to the other.
const BATCHES_MAX: usize = 16;

/// Successors that are looked up together.
#[derive(Debug)]
struct Batch<const N: usize> {
    keys: Vec<Key<N>>,
    /// For each state, where its successors end.
    ends: Vec<usize>,
    /// Memory that the other thread takes.
    bytes: usize,
}

/// What became of a batch.
#[derive(Debug)]
struct Entered<const N: usize> {
    /// The states that are new, in the order of their numbers.
    new: Vec<Key<N>>,
    /// There are as many as there may be.
    full: bool,
}

impl<const N: usize> Search<N> {
    /// Two threads share the work: this one plays, the other keeps the states. States are numbered in the order in
    /// which one thread alone would meet them, so the result does not depend on how the two take turns.
    fn run(&mut self, limits: Limits) -> Result<End, Unfit> {
        let first = self.layout.pack(&self.start)?;
        let Search { system, layout, store, start, at_home, grants, .. } = self;
        let mut player = Player { system, layout, here: start.clone(), next: start.clone() };
        thread::scope(|scope| {
            let (batches, incoming) = sync_channel::<Batch<N>>(BATCHES_MAX);
            let (entered, results) = sync_channel::<Entered<N>>(BATCHES_MAX);
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
                return Ok(End::Limit);
            }
            loop {
                let wait = queue.is_empty() || under_way == BATCHES_MAX;
                let result = if wait { results.recv().ok() } else { results.try_recv().ok() };
                if let Some(result) = result {
                    under_way -= 1;
                    queue.extend(result.new);
                    if result.full {
                        return Ok(End::Limit);
                    }
                    continue;
                }
                let mut batch = Batch { keys: Vec::with_capacity(BATCH * 12), ends: Vec::new(), bytes: 0 };
                while let Some(key) = (batch.ends.len() < BATCH).then(|| queue.pop_front()).flatten() {
                    player.layout.unpack(&key, &mut player.here);
                    at_home.push(player.system.all_at_home(&player.here));
                    grants.push(player.system.granted(&player.here));
                    if player.system.wrong(&player.here).is_some() {
                        return Ok(End::Wrong(at_home.len() as u32 - 1));
                    }
                    player.expand(&key, &mut batch)?;
                }
                batch.bytes = player.system.bytes() + at_home.capacity() + grants.capacity() * size_of::<Granted>();
                if batches.send(batch).is_err() {
                    return Ok(End::Limit);
                }
                under_way += 1;
                while queue.is_empty() && under_way > 0 {
                    let Ok(result) = results.recv() else { return Ok(End::Limit) };
                    under_way -= 1;
                    queue.extend(result.new);
                    if result.full {
                        return Ok(End::Limit);
                    }
                }
                if queue.is_empty() {
                    return Ok(End::Exhausted);
                }
            }
        })
    }

    pub fn states(&self) -> usize {
        self.store.table.len()
    }

    pub fn arcs(&self) -> u64 {
        self.store.arcs.len() as u64
    }

    pub fn bytes(&self) -> usize {
        let flags = self.at_home.capacity() + self.grants.capacity() * size_of::<Granted>();
        self.store.bytes() + flags + self.system.bytes()
    }

    /// The states on the way to one, from the start to it.
    pub fn way_to(&self, mut number: u32) -> Vec<u32> {
        let mut way = vec![number];
        while number != 0 {
            number = self.store.came_from[number as usize];
            way.push(number);
        }
        way.reverse();
        way
    }

    /// The state with a number.
    pub fn state(&self, number: u32) -> State {
        let mut state = self.start.clone();
        self.layout.unpack(self.store.table.key(number), &mut state);
        state
    }

    /// The moves that lead along these states.
    pub fn moves_along(&mut self, way: &[u32]) -> Vec<(State, Move)> {
        let mut told = Vec::new();
        for pair in way.windows(2) {
            let state = self.state(pair[0]);
            let goal = *self.store.table.key(pair[1]);
            let moves = self.system.moves(&state);
            let leads = |what: &Move| {
                let mut next = state.clone();
                self.system.play(&mut next, *what);
                self.layout.pack(&next) == Ok(goal)
            };
            let what = moves.into_iter().find(leads).expect("a state was reached by one of its predecessor's moves");
            told.push((state, what));
        }
        told
    }

    /// How many states nothing follows.
    pub fn deadlocks(&self) -> usize {
        (0..self.store.arcs_until.len()).filter(|&number| self.followers(number).is_empty()).count()
    }

    /// The numbers of the states that follow one.
    fn followers(&self, number: usize) -> &[u32] {
        let Store { arcs, arcs_until, .. } = &self.store;
        let begin = if number == 0 { 0 } else { arcs_until[number - 1] };
        &arcs[begin as usize..arcs_until[number] as usize]
    }

    /// Of an exhausted search: a state from which home cannot be reached, if there is one.
    ///
    /// With manual mode among the modes, by manual mode alone: no station takes up any other on the way. The mode
    /// decision lets an operator come to manual from everywhere, whatever is wrong; it lets nobody into auto or hand
    /// while something is.
    pub fn stranded(&self) -> Option<u32> {
        match self.home_by_manual() {
            None => self.cut_off_from(self.at_home.clone(), |_, _| true),
            Some(manual) => self.cut_off_from(self.at_home.clone(), |from, to| {
                let (from, to) = (self.grants[from as usize], self.grants[to as usize]);
                to.mode == manual || (to.mode == from.mode && to.acting & !from.acting == 0)
            }),
        }
    }

    /// The number of manual mode, where home is asked for by it alone.
    pub fn home_by_manual(&self) -> Option<u8> {
        let Setting { modes, grants, .. } = &self.system.setting;
        let manual = modes.iter().position(|&mode| mode == ControlMode::Manual)?;
        (*grants == Grants::InEpochs).then_some(manual as u8)
    }

    /// Of an exhausted search: a state from which the start cannot be reached, if there is one.
    pub fn no_return(&self) -> Option<u32> {
        let mut goal = vec![false; self.states()];
        goal[0] = true;
        self.cut_off_from(goal, |_, _| true)
    }

    /// The first state from which no way along these arcs leads to a goal.
    ///
    /// Sweeps over all arcs, to and fro, until nothing changes: a state from which one that leads to a goal follows
    /// leads there itself. Ways run with the numbers as well as against them, so few sweeps are enough.
    fn cut_off_from(&self, goal: Vec<bool>, may: impl Fn(u32, u32) -> bool) -> Option<u32> {
        let mut leads = goal;
        let mut left: Vec<u32> = (0..self.states() as u32).filter(|&number| !leads[number as usize]).collect();
        loop {
            let before = left.len();
            left.reverse();
            left.retain(|&number| {
                let leading = |&next: &u32| leads[next as usize] && may(number, next);
                let found = self.followers(number as usize).iter().any(leading);
                leads[number as usize] = found;
                !found
            });
            if left.is_empty() || left.len() == before {
                return left.iter().min().copied();
            }
        }
    }
}

/// Plays the line from packed state to packed state.
struct Player<'a> {
    system: &'a mut System,
    layout: &'a Layout,
    here: State,
    next: State,
}

impl Player<'_> {
    /// Appends what follows the state taken up.
    fn expand<const N: usize>(&mut self, key: &Key<N>, batch: &mut Batch<N>) -> Result<(), Unfit> {
        for link in 0..self.system.setting.links.len() {
            for nth in 0..self.system.waiting(&self.here, link) {
                self.play(Move::Hear { link, nth }, batch)?;
            }
        }
        for station in 0..self.here.situations.len() {
            for nth in 0..self.system.acts(&self.here, station) {
                let Some(effect) = self.system.act(&self.here, station, nth) else { continue };
                // Most of what happens is nobody else's business.
                batch.keys.push(if effect.is_local() {
                    self.layout.with_situation(key, station, effect.to).ok_or(Unfit::Situation)?
                } else {
                    self.next.take(&self.here);
                    self.system.happen(&mut self.next, station, effect);
                    self.layout.pack(&self.next)?
                });
            }
        }
        for mode in self.system.grants(&self.here) {
            self.play(Move::Grant(mode), batch)?;
        }
        batch.ends.push(batch.keys.len());
        Ok(())
    }

    fn play<const N: usize>(&mut self, what: Move, batch: &mut Batch<N>) -> Result<(), Unfit> {
        self.next.take(&self.here);
        self.system.play(&mut self.next, what);
        batch.keys.push(self.layout.pack(&self.next)?);
        Ok(())
    }
}

impl<const N: usize> Store<N> {
    fn new() -> Self {
        Store {
            table: Table::new(),
            came_from: Vec::new(),
            arcs: Vec::new(),
            arcs_until: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Enters the successors of the states that come next in order. The start, alone, is nobody's successor.
    fn enter(&mut self, batch: &Batch<N>, limits: Limits) -> Entered<N> {
        let (first_new, first_arc) = (self.table.len() as u32, self.arcs.len());
        self.table.enter_all(&batch.keys, &mut self.scratch, &mut self.arcs);
        if batch.ends.is_empty() {
            self.came_from.push(0);
            self.arcs.clear();
        }
        let (mut newest, mut begin) = (first_new, 0);
        for &end in &batch.ends {
            let from = self.arcs_until.len() as u32;
            for &number in &self.arcs[first_arc + begin..first_arc + end] {
                if number == newest {
                    self.came_from.push(from);
                    newest += 1;
                }
            }
            begin = end;
            self.arcs_until.push((first_arc + end) as u64);
        }
        let new = (first_new..self.table.len() as u32).map(|number| *self.table.key(number)).collect();
        let full = self.table.len() > limits.states || self.bytes() + batch.bytes > limits.bytes;
        Entered { new, full }
    }

    fn bytes(&self) -> usize {
        let numbers = (self.came_from.capacity() + self.arcs.capacity()) * size_of::<u32>();
        self.table.bytes() + numbers + self.arcs_until.capacity() * size_of::<u64>()
    }
}

/// Explores with fields as narrow as they turn out to be possible.
pub(crate) fn explore_with<R>(
    setting: &Setting,
    limits: Limits,
    mut conclude: impl Conclude<R>,
) -> Result<R, linewright_station_logic::CompileError> {
    let (mut system, mut start) = System::new(setting)?;
    let mut widths = Widths::FIRST;
    loop {
        let layout = system.layout(widths);
        let unfit = match layout.words64 {
            1 | 2 => match search::<2>(system, start, widths, limits) {
                Ok(found) => return Ok(conclude.conclude(found)),
                Err(unfit) => unfit,
            },
            3 => match search::<3>(system, start, widths, limits) {
                Ok(found) => return Ok(conclude.conclude(found)),
                Err(unfit) => unfit,
            },
            4 => match search::<4>(system, start, widths, limits) {
                Ok(found) => return Ok(conclude.conclude(found)),
                Err(unfit) => unfit,
            },
            5..=8 => match search::<8>(system, start, widths, limits) {
                Ok(found) => return Ok(conclude.conclude(found)),
                Err(unfit) => unfit,
            },
            _ => match search::<32>(system, start, widths, limits) {
                Ok(found) => return Ok(conclude.conclude(found)),
                Err(unfit) => unfit,
            },
        };
        let why;
        (system, start, why) = *unfit;
        widths = widths.wider(why);
    }
}

/// What is made of a search, whatever the width of its states.
pub(crate) trait Conclude<R> {
    fn conclude<const N: usize>(&mut self, search: Search<N>) -> R;
}
