//! Whether a cell is right: whatever is decided, nothing gets stuck, and every part can always be finished.
//!
//! Explored is the net that is played, written out as an ordinary one, by the explorer of `linewright-nets`. Every mix
//! of part types may come, in every order, up to `wip_max` parts at a time; whatever can start may start, or not. Three
//! arguments keep that small. Tests compare each with a player of parts without a net (`tests/cells`).
//!
//! - **Whole activities.** What has started can always end, and its end takes no tokens. So an end can be moved forward
//!   to right behind its start, and where nothing is in progress the same markings are reached without the states
//!   between ([`Detail::Coordination`]). Nothing gets stuck in the midst of an activity that has all it needs; a part
//!   that was grasped without a reservation is such a marking, not the midst of one.
//! - **Groups.** Resources that share no part and no activity have only the number of parts let in in common. A part
//!   that is inside never waits for that. So each group is explored alone, as if it had the whole number for itself.
//! - **Parts by and by.** Leave one part out of a story, with all that is done with it: what is left is a story, since
//!   a part only takes what others may need and gives it back. So what is sound with n parts is sound with fewer, what
//!   gets stuck with n does so with more, and those that are stuck in the end got there without the others. Numbers of
//!   parts are tried upwards: a violation is found with the fewest parts, the largest sound number with it, and beyond
//!   the limits the number reached. Once more parts are let in than ever fit, all larger numbers are the same.
//!
//! Time and failures are not modelled here; they are up to the token player.

mod conflict;
mod counterexample;
mod group;
mod play;
pub mod protocol;
pub mod recovery;
mod verdict;
mod words;

use linewright_cell::Cell;
use linewright_cell::net::{CellNet, Detail, Supply, net};
use linewright_nets::coloured::{ColouredError, Colours, UnfoldError, Unfolding, unfold};
pub use linewright_nets::explicit::ExplorationLimits;
use thiserror::Error;

pub use crate::explore::Verdict;
pub use conflict::{APART, check_conflicts};
pub use counterexample::{CellPath, Holding, WaitingPart};
pub use verdict::{CellProperty, Checked, GroupExplored};

/// At most so many places and transitions of the ordinary net: a thousand resources need a tenth of it.
const NODES_MAX: usize = 1_000_000;

/// Subject and extent of an exploration.
#[derive(Clone, Debug)]
pub struct CellExploration<'c> {
    pub cell: &'c Cell,
    /// Detail in which activities are explored. The answers are the same, the numbers of states are not.
    pub detail: Detail,
    /// Of each part type at most so many, in their order; none for any mix.
    pub parts: Option<Vec<u32>>,
    /// Of each search.
    pub limits: ExplorationLimits,
}

impl<'c> CellExploration<'c> {
    /// Any mix of parts, in whole activities.
    pub fn new(cell: &'c Cell) -> Self {
        CellExploration { cell, detail: Detail::Coordination, parts: None, limits: ExplorationLimits::default() }
    }
}

/// Why a cell cannot be explored at all.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CellNotExplorable {
    /// Too large for a net.
    #[error("the cell has no net: {}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Net(Vec<ColouredError>),
    /// Too large to be written out.
    #[error(transparent)]
    Unfold(#[from] UnfoldError),
}

/// A cell's net, and the same written out.
pub(crate) struct Nets<'c> {
    cell: &'c Cell,
    net: CellNet,
    long: Unfolding,
}

impl<'c> Nets<'c> {
    fn of(setting: &CellExploration<'c>, detail: Detail) -> Result<Self, CellNotExplorable> {
        let cell = setting.cell;
        let supply = setting.parts.as_deref().map_or(Supply::Open, Supply::Closed);
        let net = net(cell, detail, supply).map_err(CellNotExplorable::Net)?;
        let long = unfold(net.net(), Colours::Reachable, NODES_MAX)?;
        Ok(Nets { cell, net, long })
    }
}

/// Explores a cell as far as the limits allow, and draws the conclusions.
///
/// # Errors
/// When there is no net to explore.
pub fn check(setting: &CellExploration<'_>) -> Result<Checked, CellNotExplorable> {
    let cell = setting.cell;
    let nets = Nets::of(setting, setting.detail)?;
    let groups = group::groups(&nets);
    let plays = groups.iter().map(|group| play::play(group, cell.limits.wip_max, &setting.limits)).collect::<Vec<_>>();
    Ok(verdict::judge(setting, &nets, &groups, &plays))
}
