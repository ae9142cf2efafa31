//! Exploration: the real controllers of several stations, composed with an environment that may do anything.
//!
//! Motions complete, fail or stay at any moment; operators press, hold and release at every panel at once; a station
//! receives a change of mode at any time; every reader holds any report between its last one and the newest. In every
//! state the line's conflicts and the soundness of each station are judged from the description alone, and of all
//! states together it is decided whether home and the start can be reached from each.
//!
//! Controllers are not modelled but called. What keeps this fast is that a station by itself has few situations
//! (`station.rs`): what its controller makes of each is worked out once, and the composed line is played with numbers.
//!
//! Time stands still here. What time does to a controller is among what may happen anyway ([`LineExploration`]).

mod classes;
mod counterexample;
mod facts;
mod home;
mod orders;
mod path;
mod progress;
mod properties;
mod restart;
mod search;
mod setting;
mod state;
mod station;
mod store;
mod successors;
mod system;
mod table;
mod verdict;
mod view_key;

pub use counterexample::LinePath;
pub(crate) use facts::{actuator, bits_of};
pub use progress::SearchProgress;
pub use properties::counted;
pub use search::{LimitReached, SearchLimits};
pub use setting::{Grants, LineExploration};
pub use verdict::{LineExplored, LineProperty, Verdict};

use linewright_station_logic::CompileError;
use thiserror::Error;

/// Why a line cannot be explored at all.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LineNotExplorable {
    /// A station does not compile.
    #[error("{0}")]
    Compile(#[from] CompileError),
    /// More conflicts than there are bits for them.
    #[error("{found} conflicts are more than the {max} that can be watched at once; explore the line in parts")]
    Conflicts {
        /// So many.
        found: usize,
        /// The most there may be.
        max: usize,
    },
    /// More stations than there are bits for them.
    #[error("{found} stations are more than the {max} that can be kept apart; explore the line in parts")]
    Stations {
        /// So many.
        found: usize,
        /// The most there may be.
        max: usize,
    },
    /// A state takes more bits than a packed one may have.
    #[error(
        "a state of these stations takes {found} words of 64 bits, more than the {max} there may be; explore the line in parts, or with fewer reports under way"
    )]
    State {
        /// So many words.
        found: usize,
        /// The most there may be.
        max: usize,
    },
    /// More incoming links at one station than there are bits for them.
    #[error("{station} reads {found} stations, exploration supports {max}")]
    Links {
        station: String,
        /// So many.
        found: usize,
        /// The most there may be.
        max: usize,
    },
}

/// Explores a line as far as the limits allow.
///
/// # Errors
/// When the line cannot be explored at all.
pub fn explore(setting: &LineExploration, limits: SearchLimits) -> Result<LineExplored, LineNotExplorable> {
    explore_watched(setting, limits, &SearchProgress::default())
}

/// The same, with its progress written down as it goes.
///
/// # Errors
/// When the line cannot be explored at all.
pub fn explore_watched(
    setting: &LineExploration,
    limits: SearchLimits,
    progress: &SearchProgress,
) -> Result<LineExplored, LineNotExplorable> {
    let found = setting.line.conflicts.len();
    if found > facts::CONFLICTS_MAX {
        return Err(LineNotExplorable::Conflicts { found, max: facts::CONFLICTS_MAX });
    }
    let (found, max) = (setting.line.stations.len(), facts::STATIONS_MAX);
    if found > max {
        return Err(LineNotExplorable::Stations { found, max });
    }
    for (nth, station) in setting.line.stations.iter().enumerate() {
        let found = setting.into(nth).count();
        if found > station::LINKS_MAX {
            return Err(LineNotExplorable::Links { station: station.name.clone(), found, max: station::LINKS_MAX });
        }
    }
    search::explore(setting, limits, progress)
}
