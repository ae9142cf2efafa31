//! Stations that are left out of the mode decision of the line.
//!
//! In a line without a cell a fault in auto is the line's: all stand by. In a cell it is an exception of the order in which
//! it happens, and the others work on. So the stations of what has failed, and those of what is down, are *isolated* until
//! that is put right; it follows from the state, so nothing about it is remembered. Stations in emergency stop are so as well.
//!
//! Of these a person may lead one in manual while the others are in auto, as far as [`Participation`] has it. Such a station
//! gets no order, and what an answer or a request would bring into service waits until it is in auto again.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use linewright_line::{StationId, Tick};

use super::super::firing::{ActivityPhase, OngoingActivity};
use super::super::player::Coordination;
use super::super::state::PlayerState;
use super::book::ExceptionStage;

/// How far a station takes part in auto.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Participation {
    /// It may get orders, or has one.
    InService,
    /// It is left out, and stations of its failed activity have still to come to rest, or go back after an answer.
    Securing,
    /// It is left out. These are the tasks of its activities that have failed and wait for an answer: until then they keep all
    /// tokens that they have taken, so no activity with a task in conflict with one of these starts.
    LeftOut {
        tasks: Vec<Arc<str>>,
        /// Epoch in which its present period of manual by itself began; none if it is not in manual. No answer to these activities is
        /// taken until the period ends.
        kept_in: Option<u64>,
    },
}

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

    /// How far a station takes part in auto now.
    pub fn participation(&self, now: Tick, station: StationId) -> Participation {
        let (state, table) = (&self.state, self.state.table());
        let has_order = |firing: &&OngoingActivity| firing.orders.iter().any(|order| order.station == station);
        let its: Vec<&OngoingActivity> = state.firings().filter(has_order).collect();
        let of = |resource| table.handling().resource(resource).and_then(|of| of.station);
        let is_down = state.exceptions().down().any(|(id, _)| of(id) == Some(station));
        let works = its.iter().any(|firing| firing.phase == ActivityPhase::Running);
        if works || (its.is_empty() && !is_down) {
            return Participation::InService;
        }
        let waits = |firing: &OngoingActivity| {
            let stage = state.exceptions().trouble(firing.id).map(|trouble| &trouble.stage);
            matches!(stage, Some(ExceptionStage::Waiting(_)))
        };
        let goes_on = |firing: &OngoingActivity| {
            // One that is not heard may move.
            let may_move = |of: StationId| self.moves(now, of) || self.fresh(now, of).is_none();
            firing.orders.iter().any(|order| order.station != station && may_move(order.station))
        };
        if its.iter().any(|firing| !waits(firing) || goes_on(firing)) {
            return Participation::Securing;
        }
        let orders = its.iter().flat_map(|firing| &table.activity(firing.mode).orders);
        let tasks = orders.filter(|order| order.station == station).map(|order| order.task.clone());
        Participation::LeftOut { tasks: tasks.collect(), kept_in: self.watch.in_manual.get(&station).copied() }
    }

    /// The stations that are in manual by themselves from now on, each with the epoch since which it is.
    pub(in super::super) fn lead_by_hand(&mut self, stations: &BTreeMap<StationId, u64>) {
        if self.watch.in_manual != *stations {
            self.watch.in_manual.clone_from(stations);
            // No record shows that something can start now that could not.
            self.reconsider();
        }
    }
}
