//! Remaining ways of parts, and where tokens come back from: computed once from the table.
//!
//! A part goes from cell to cell, each mode that moves it is a step that takes its time, so the rest of its way is a
//! shortest path. Other tokens are left out: it is the time by the plan, without waits for a robot.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::time::Duration;

use super::super::ids::{CellId, ModeId, TokenDemand};
use super::super::plan::ActivityTiming;
use super::super::table::CellTable;

/// Ways through a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShortestRoutes {
    remaining: Vec<Duration>,
    run: Vec<Duration>,
    producers: Vec<Vec<ModeId>>,
    comes_back: Vec<bool>,
}

impl ShortestRoutes {
    pub fn new(table: &CellTable) -> Self {
        let mut producers = vec![Vec::new(); table.cell_count()];
        for mode in table.modes() {
            table.gives(mode).iter().for_each(|&(cell, _)| producers[cell.index()].push(mode));
        }
        let gives = |mode, cell| table.gives(mode).iter().find(|(to, _)| *to == cell).map_or(0, |&(_, weight)| weight);
        let returns = |cell: CellId| {
            let takes = |&mode: &ModeId| table.takes(mode).iter().find(|(from, _)| *from == cell).map(|&(_, w)| w);
            table.consumers(cell).iter().all(|mode| takes(mode).is_some_and(|weight| gives(*mode, cell) >= weight))
        };
        let taken = |mode| others(table.takes(mode), table.part_in(mode));
        let given = |mode| others(table.gives(mode), table.part_out(mode));
        let alone = |mode: ModeId| taken(mode).is_empty();
        let in_place = |mode: ModeId| alone(mode) || taken(mode) == given(mode);
        let timed = |mode| time(table, mode);
        let after = shortest(table, |mode| alone(mode).then(|| timed(mode)));
        let while_kept = shortest(table, |mode| in_place(mode).then(|| timed(mode)));
        let run = table.modes().map(|mode| {
            let keeps = taken(mode).iter().any(|of| !given(mode).contains(of));
            let further = if keeps { &while_kept } else { &after };
            time(table, mode) + table.part_out(mode).map_or(Duration::ZERO, |to| further[to.index()])
        });
        ShortestRoutes {
            remaining: shortest(table, |mode| Some(timed(mode))),
            run: run.collect(),
            producers,
            comes_back: table.cells().map(returns).collect(),
        }
    }

    /// Least time of a part on a cell until it leaves or nothing more is to be done with it, by nominal times; zero
    /// where it never comes to an end.
    pub fn remaining(&self, cell: CellId) -> Duration {
        self.remaining[cell.index()]
    }

    /// Time of a mode, and of all that follows from it without a further decision about others: what needs nothing but the
    /// part; and, if the mode keeps something that it does not give back itself, also what needs other things for its own
    /// time only. So it is loading, which takes the machine's place, and what the machine then does, or the human's
    /// attention; not the unloading, which gives the place back. This is the processing time of a decision.
    pub fn run(&self, mode: ModeId) -> Duration {
        self.run[mode.index()]
    }

    /// The modes that give to a cell.
    pub(super) fn producers(&self, cell: CellId) -> &[ModeId] {
        &self.producers[cell.index()]
    }

    /// Whether each mode that takes from a cell gives as much back to it: a carrier, which is only ever under way.
    pub(super) fn comes_back(&self, cell: CellId) -> bool {
        self.comes_back[cell.index()]
    }
}

/// Tokens beside the part.
fn others(tokens: &[TokenDemand], part: Option<CellId>) -> BTreeSet<TokenDemand> {
    tokens.iter().copied().filter(|&(cell, _)| Some(cell) != part).collect()
}

/// Time of a mode by itself.
pub(in super::super) fn time(table: &CellTable, mode: ModeId) -> Duration {
    match table.activity(mode).kind {
        ActivityTiming::Immediate => Duration::ZERO,
        ActivityTiming::Decided { time, limit: _ } => time,
    }
}

/// From each cell the shortest way to where nothing takes a part away, or it leaves (Dijkstra 1959, backwards), by the modes
/// that have a length.
pub(in super::super) fn shortest(table: &CellTable, length: impl Fn(ModeId) -> Option<Duration>) -> Vec<Duration> {
    let mut into: Vec<Vec<(ModeId, Duration)>> = vec![Vec::new(); table.cell_count()];
    let mut open: BinaryHeap<Reverse<(Duration, CellId)>> = BinaryHeap::new();
    let mut has_way = vec![false; table.cell_count()];
    for mode in table.modes() {
        let (Some(far), Some(from)) = (length(mode), table.part_in(mode)) else { continue };
        has_way[from.index()] = true;
        match table.part_out(mode) {
            Some(to) => into[to.index()].push((mode, far)),
            None => open.push(Reverse((far, from))),
        }
    }
    open.extend(table.cells().filter(|cell| !has_way[cell.index()]).map(|cell| Reverse((Duration::ZERO, cell))));
    let mut found: Vec<Option<Duration>> = vec![None; table.cell_count()];
    while let Some(Reverse((far, cell))) = open.pop() {
        if found[cell.index()].is_some() {
            continue;
        }
        found[cell.index()] = Some(far);
        let before = into[cell.index()].iter();
        let before = before.filter_map(|&(mode, length)| Some((far + length, table.part_in(mode)?)));
        open.extend(before.map(Reverse));
    }
    found.into_iter().map(Option::unwrap_or_default).collect()
}
