//! The ordinary net that a coloured net stands for, with the way back.
//!
//! One place for each colour of each place, one transition for each mode that a guard allows. Names contain their
//! origin: `p3<2,1>`. A net of universal domains unfolds to far more than is ever used, so there is a second way that
//! keeps only the colours which could ever be there: those that start on a place, and the results of modes of colours
//! that could be there. Counts are ignored in that, so it keeps a little more than exploration would find; what it drops
//! can never be marked or fire, and everything else behaves the same.

use thiserror::Error;

use super::bind;
use super::marking::{ColouredMarking, TokenElement};
use super::net::{ColouredNet, NetMode};
use crate::{Marking, Net, NetBuilder, PlaceId, TransitionId};

/// Colours to unfold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// All of every domain.
    All,
    /// The colours that a place can ever hold.
    Reachable,
}

/// Reason why there is no ordinary net.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum UnfoldError {
    /// It would have more places and transitions than allowed.
    #[error("the unfolding has more than {limit} places and transitions")]
    TooLarge {
        /// Number allowed.
        limit: usize,
    },
    /// Of the colours that could ever be there, there is none: no token, and no transition that needs none.
    #[error("nothing is left to unfold: the net has no token, and no transition that could fire without one")]
    Nothing,
}

/// An ordinary net and where its nodes come from. Both tables are ascending, which is also the order of the nodes.
#[derive(Clone, Debug)]
pub struct Unfolding {
    net: Net,
    /// The cell of each place.
    cells: Vec<u32>,
    /// The mode of each transition.
    modes: Vec<NetMode>,
}

/// Writes down the ordinary net, unless it has more than `limit` places and transitions together.
pub fn unfold(net: &ColouredNet, colours: Colours, limit: usize) -> Result<Unfolding, UnfoldError> {
    let too_large = UnfoldError::TooLarge { limit };
    let (cells, modes) = match colours {
        Colours::All => all(net, limit),
        Colours::Reachable => reachable(net, limit),
    }
    .ok_or(too_large)?;
    if cells.is_empty() && modes.is_empty() {
        return Err(UnfoldError::Nothing);
    }
    let mut b = NetBuilder::new(net.name());
    for &cell in &cells {
        b.place(net.cell_name(cell), super::marking::count_in(&net.initial.entries, cell));
    }
    // Whatever a mode touches is in the table: either all cells are, or the mode is there because its cells are.
    let at = |cell: u32| PlaceId(cells.partition_point(|&known| known < cell) as u32);
    for &mode in &modes {
        let transition = b.transition(net.mode_name(mode));
        let [takes, gives] = sides(net, mode);
        takes.iter().for_each(|&(cell, weight)| _ = b.input(transition, at(cell), weight));
        gives.iter().for_each(|&(cell, weight)| _ = b.output(transition, at(cell), weight));
    }
    match b.build() {
        Ok(net) => Ok(Unfolding { net, cells, modes }),
        // Names are different because those of the coloured net are, and arcs resolve. What remains is the size.
        Err(_) => Err(too_large),
    }
}

/// Tokens that a mode takes and gives, added up by cell.
fn sides(net: &ColouredNet, mode: NetMode) -> [Vec<(u32, u32)>; 2] {
    let (mut takes, mut gives) = (Vec::new(), Vec::new());
    net.demand(&[mode], &mut takes).expect("the builder bounds what an arc moves");
    net.append_outputs(mode, &mut gives);
    super::marking::collect(&mut gives).expect("the builder bounds what an arc moves");
    [takes, gives]
}

type Nodes = Option<(Vec<u32>, Vec<NetMode>)>;

fn all(net: &ColouredNet, limit: usize) -> Nodes {
    let room = limit.checked_sub(net.cell_count() as usize)?;
    let modes: Vec<NetMode> =
        net.transitions().flat_map(|transition| net.modes(transition)).take(room.saturating_add(1)).collect();
    (modes.len() <= room).then(|| ((0..net.cell_count()).collect(), modes))
}

/// Lets colours spread until nothing new comes.
fn reachable(net: &ColouredNet, limit: usize) -> Nodes {
    let mut entries: Vec<(u32, u32)> = net.initial.entries.iter().map(|&(cell, _)| (cell, 1)).collect();
    loop {
        let before = entries.len();
        let mut modes = Vec::new();
        for transition in net.transitions() {
            let room = limit.checked_sub(entries.len() + modes.len())?;
            let mut colours = Vec::new();
            bind::enabled(net, transition.index(), &entries, true, room + 1, &mut colours);
            if colours.len() > room {
                return None;
            }
            modes.extend(colours.into_iter().map(|colour| NetMode { transition, colour }));
        }
        for &mode in &modes {
            net.append_outputs(mode, &mut entries);
            if entries.len() > 2 * (limit + before) {
                entries = distinct(entries);
            }
        }
        entries = distinct(entries);
        if entries.len() == before {
            return Some((entries.into_iter().map(|(cell, _)| cell).collect(), modes));
        }
    }
}

fn distinct(mut entries: Vec<(u32, u32)>) -> Vec<(u32, u32)> {
    entries.iter_mut().for_each(|entry| entry.1 = 1);
    entries.sort_unstable();
    entries.dedup();
    entries
}

impl Unfolding {
    /// The ordinary net.
    pub fn net(&self) -> &Net {
        &self.net
    }

    /// The coloured place and the colour that a place stands for.
    pub fn cell(&self, coloured: &ColouredNet, place: PlaceId) -> TokenElement {
        coloured.cell(self.cells[place.index()])
    }

    /// The mode that a transition stands for.
    pub fn mode(&self, transition: TransitionId) -> NetMode {
        self.modes[transition.index()]
    }

    /// The place that stands for a cell, if that was unfolded.
    pub fn place_of(&self, cell: u32) -> Option<PlaceId> {
        self.cells.binary_search(&cell).ok().map(|at| PlaceId(at as u32))
    }

    /// The transition that stands for a mode, if that was unfolded.
    pub fn transition_of(&self, mode: NetMode) -> Option<TransitionId> {
        self.modes.binary_search(&mode).ok().map(|at| TransitionId(at as u32))
    }

    /// The same marking of the ordinary net; none if it has tokens on cells that were not unfolded.
    pub fn marking(&self, coloured: &ColouredMarking) -> Option<Marking> {
        let mut tokens = vec![0; self.cells.len()];
        for &(cell, count) in coloured.entries() {
            tokens[self.place_of(cell)?.index()] = count;
        }
        Some(Marking::from_tokens(tokens))
    }

    /// The same marking of the coloured net.
    pub fn coloured(&self, marking: &Marking) -> ColouredMarking {
        let entries = self.cells.iter().copied().zip(marking.as_slice().iter().copied());
        ColouredMarking { entries: entries.filter(|&(_, count)| count > 0).collect() }
    }
}
