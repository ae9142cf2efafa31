//! Reasons why a controller cannot be made of a description or a snapshot.

use std::fmt;

use crate::peer_set::PEERS_MAX;
use crate::program::CompileError;

impl fmt::Display for CompileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CompileError::TooManyPaths { station, has, most } => {
                write!(f, "station {station} has {has} irreversible operations, at most {most}")
            }
            CompileError::TooManyPeers { station, has } => {
                write!(f, "arrows and conflicts join station {station} with {has} others, at most {PEERS_MAX}")
            }
            CompileError::SnapshotDoesNotFit { why } => write!(f, "snapshot does not fit this station: {why}"),
        }
    }
}
