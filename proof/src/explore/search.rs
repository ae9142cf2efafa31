//! Looking at every state, breadth first, and telling whether home can be reached from each.

use super::setting::Setting;
use super::state::{Layout, State, Unfit, Widths};
use super::system::{Move, System};
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
    /// Fifty million states, four gibibytes.
    fn default() -> Self {
        Limits { states: 50_000_000, bytes: 4 << 30 }
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
    pub table: Table<N>,
    /// For each state, the one it was first reached from.
    came_from: Vec<u32>,
    pub start: State,
    /// The numbers of the states that follow each, one state after the other.
    arcs: Vec<u32>,
    /// Where those of each state end.
    arcs_until: Vec<u64>,
    at_home: Vec<bool>,
    pub end: End,
}

/// Breadth first, so that the first wrong state met is one of the nearest.
pub(crate) fn search<const N: usize>(
    system: System,
    start: State,
    widths: Widths,
    limits: Limits,
) -> Result<Search<N>, Box<(System, State, Unfit)>> {
    let layout = system.layout(widths);
    let mut search = Search {
        system,
        layout,
        table: Table::new(),
        came_from: Vec::new(),
        start,
        arcs: Vec::new(),
        arcs_until: Vec::new(),
        at_home: Vec::new(),
        end: End::Limit,
    };
    match search.run(limits) {
        Ok(end) => {
            search.end = end;
            Ok(search)
        }
        Err(unfit) => Err(Box::new((search.system, search.start, unfit))),
    }
}

/// States whose successors are looked up together.
const BATCH: usize = 32;

impl<const N: usize> Search<N> {
    fn run(&mut self, limits: Limits) -> Result<End, Unfit> {
        let mut batch = Batch::default();
        let first = self.layout.pack(&self.start)?;
        batch.keys.push(first);
        self.meet(&mut batch, 0, &mut self.start.clone());
        let (mut here, mut next, mut moves) = (self.start.clone(), self.start.clone(), Vec::new());
        let mut from = 0;
        while from < self.table.len() {
            if let End::Wrong(number) = self.end {
                return Ok(End::Wrong(number));
            }
            let until = self.table.len().min(from + BATCH);
            for number in from..until {
                let key = *self.table.key(number as u32);
                self.layout.unpack(&key, &mut here);
                self.system.moves(&here, &mut moves);
                for &what in &moves {
                    let key = match self.system.quiet_effect(&here, what) {
                        Some((station, to)) => self.layout.with_situation(&key, station, to).ok_or(Unfit::Situation)?,
                        None => {
                            next.take(&here);
                            self.system.play(&mut next, what);
                            self.layout.pack(&next)?
                        }
                    };
                    batch.keys.push(key);
                }
                batch.ends.push(batch.keys.len());
            }
            self.meet(&mut batch, from as u32, &mut next);
            if self.table.len() > limits.states || self.bytes() > limits.bytes {
                return Ok(End::Limit);
            }
            from = until;
        }
        Ok(End::Exhausted)
    }

    /// Enters the successors of the states from `from` on, and looks at the new ones.
    fn meet(&mut self, batch: &mut Batch<N>, from: u32, state: &mut State) {
        let first_new = self.table.len() as u32;
        let first_arc = self.arcs.len();
        self.table.enter_all(&batch.keys, &mut batch.scratch, &mut self.arcs);
        let mut newest = first_new;
        let mut begin = 0;
        for (nth, &end) in batch.ends.iter().enumerate() {
            for &number in &self.arcs[first_arc + begin..first_arc + end] {
                if number == newest {
                    self.came_from.push(from + nth as u32);
                    newest += 1;
                }
            }
            begin = end;
            self.arcs_until.push((first_arc + end) as u64);
        }
        // The start comes from nowhere.
        if batch.ends.is_empty() {
            self.came_from.push(0);
            self.arcs.clear();
        }
        for number in first_new..self.table.len() as u32 {
            self.layout.unpack(self.table.key(number), state);
            self.at_home.push(self.system.all_at_home(state));
            if self.end == End::Limit && self.system.wrong(state).is_some() {
                self.end = End::Wrong(number);
            }
        }
        batch.keys.clear();
        batch.ends.clear();
    }

    pub fn arcs(&self) -> u64 {
        self.arcs.len() as u64
    }

    pub fn bytes(&self) -> usize {
        let states = self.came_from.capacity() * size_of::<u32>() + self.at_home.capacity();
        let arcs = self.arcs.capacity() * size_of::<u32>() + self.arcs_until.capacity() * size_of::<u64>();
        self.table.bytes() + states + arcs + self.system.bytes()
    }

    /// The states on the way to one, from the start to it.
    pub fn way_to(&self, mut number: u32) -> Vec<u32> {
        let mut way = vec![number];
        while number != 0 {
            number = self.came_from[number as usize];
            way.push(number);
        }
        way.reverse();
        way
    }

    /// The state with a number.
    pub fn state(&self, number: u32) -> State {
        let mut state = self.start.clone();
        self.layout.unpack(self.table.key(number), &mut state);
        state
    }

    /// The moves that lead along these states.
    pub fn moves_along(&mut self, way: &[u32]) -> Vec<(State, Move)> {
        let mut state = self.start.clone();
        let mut told = Vec::new();
        for pair in way.windows(2) {
            self.layout.unpack(self.table.key(pair[0]), &mut state);
            let goal = *self.table.key(pair[1]);
            let mut moves = Vec::new();
            self.system.moves(&state, &mut moves);
            let leads = |what: &Move| {
                let mut next = state.clone();
                self.system.play(&mut next, *what);
                self.layout.pack(&next) == Ok(goal)
            };
            let what = moves.into_iter().find(leads).expect("a state was reached by one of its predecessor's moves");
            told.push((state.clone(), what));
        }
        told
    }

    /// How many states nothing follows.
    pub fn deadlocks(&self) -> usize {
        (0..self.arcs_until.len()).filter(|&number| self.followers(number).is_empty()).count()
    }

    /// The numbers of the states that follow one.
    fn followers(&self, number: usize) -> &[u32] {
        let begin = if number == 0 { 0 } else { self.arcs_until[number - 1] };
        &self.arcs[begin as usize..self.arcs_until[number] as usize]
    }

    /// Of an exhausted search: a state from which home cannot be reached, if there is one.
    ///
    /// Sweeps over all arcs, to and fro, until nothing changes: a state from which one that leads home follows leads
    /// home itself. Ways home run with the numbers as well as against them, so few sweeps are enough.
    pub fn stranded(&self) -> Option<u32> {
        self.cut_off_from(self.at_home.clone())
    }

    /// Of an exhausted search: a state from which the start cannot be reached, if there is one.
    pub fn no_return(&self) -> Option<u32> {
        let mut goal = vec![false; self.table.len()];
        goal[0] = true;
        self.cut_off_from(goal)
    }

    fn cut_off_from(&self, goal: Vec<bool>) -> Option<u32> {
        let states = self.table.len();
        let mut leads = goal;
        let mut left: Vec<u32> = (0..states as u32).filter(|&number| !leads[number as usize]).collect();
        loop {
            let before = left.len();
            left.reverse();
            left.retain(|&number| {
                let found = self.followers(number as usize).iter().any(|&next| leads[next as usize]);
                leads[number as usize] = found;
                !found
            });
            if left.is_empty() || left.len() == before {
                return left.iter().min().copied();
            }
        }
    }
}

/// Successors that are looked up together.
#[derive(Debug)]
struct Batch<const N: usize> {
    keys: Vec<Key<N>>,
    /// For each state, where its successors end.
    ends: Vec<usize>,
    scratch: Vec<(u64, u64)>,
}

impl<const N: usize> Default for Batch<N> {
    fn default() -> Self {
        Batch { keys: Vec::new(), ends: Vec::new(), scratch: Vec::new() }
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
