//! Petri nets: structure, marking, token game and structural analysis.

mod builder;
pub mod game;
mod id;
mod marking;
mod net;

pub use builder::{ArcName, Direction, MAX_NODES, NetBuilder, NetError};
pub use game::{FireError, Move};
pub use id::{Named, Node, PlaceId, TransitionId};
pub use marking::Marking;
pub use net::Net;
