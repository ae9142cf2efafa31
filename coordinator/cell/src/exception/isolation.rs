//! Stations that are left out of the mode decision of the line.
//!
//! In a line without a cell a fault in auto is the line's: all stand by. In a cell it is an exception of the order in which
//! it happens, and the others work on. So the stations of what has failed, and those of what is down, are *isolated* until
//! that is put right; it follows from the state, so nothing about it is remembered. Stations in emergency stop are so as well.

use std::collections::BTreeSet;

use linewright_line::StationId;

use super::super::player::Coordination;
use super::super::state::PlayerState;

/// The stations whose faults are not the line's.
pub fn isolated(state: &PlayerState) -> BTreeSet<StationId> {
    let handling = state.table().handling();
    let failed = state.exceptions().open().filter_map(|(id, _)| state.firing(id));
    let stations = failed.flat_map(|firing| firing.orders.iter().map(|order| order.station));
    let down = state.exceptions().down().filter_map(|(id, _)| handling.resource(id)?.station);
    stations.chain(down).chain(state.exceptions().stopped()).collect()
}

impl Coordination {
    /// The stations that stand between two rests, at no order, as last received. They are given no order before a person
    /// has led them to a rest.
    pub fn held_stations(&self) -> impl Iterator<Item = StationId> + '_ {
        self.watch.held()
    }
}
