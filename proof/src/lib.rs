//! Decides whether a line is right: by structure, and by exploring its real controllers, composed; and whether a flexible
//! cell is, by exploring its net.
//!
//! # Map
//! - [`structure`]: each station's net, the chart as an event graph, the mode decision.
//! - [`explore`]: the real controllers of several stations, composed.
//! - [`positions`]: the second barrier by itself, conflict by conflict.
//! - [`parts`]: a large line in parts of a few stations each, conflict by conflict.
//! - [`cell`]: whether parts of a flexible cell get stuck; tasks in conflict; the net with what fails; task orders between
//!   the real player and the real controllers.
//! - [`generate`]: random lines and cells, and lines broken on purpose.
//!
//! Controllers are called, not modelled. There is no clock: limits are numbers of states and bytes. How a question is put
//! and how an answer is printed is the caller's.

pub mod cell;
pub mod explore;
pub mod generate;
pub mod parts;
pub mod positions;
pub mod structure;
