//! Restart of a station where it was, from its record.
//!
//! A snapshot comes from outside: from a file that may belong to an older description. Everything that indexes or
//! counts is checked once here, so that nothing after it needs to.

use linewright_line::net::{Block, StationPlace};

use crate::axis_place::NumberedPlaces;
use crate::controller::Controller;
use crate::event::StopCause;
use crate::program::CompileError;
use crate::report::{Restore, StationSnapshot};
use crate::slot::OrderSlot;

/// Counts a machine never reaches in its life; above it arithmetic could overflow.
const COUNT_MAX: i32 = i32::MAX / 2;

impl Controller {
    pub(crate) fn restore(&mut self, snapshot: StationSnapshot) -> Result<(), CompileError> {
        self.check(&snapshot).map_err(|why| CompileError::SnapshotDoesNotFit { why })?;
        self.marking.count = snapshot.marking.len();
        for (token, place) in self.marking.tokens.iter_mut().zip(&snapshot.marking) {
            let place = if place.is_operating() { place.stopped() } else { *place };
            if place.is_incomplete() {
                self.marking.causes_of_stop[place.op.index()] = StopCause::Restart;
            }
            token.place = self.program.index_of(place);
        }
        self.views.generation = snapshot.generation;
        self.marking.placed = snapshot.placed;
        self.counts.cycle = snapshot.cycle;
        self.counts.done = snapshot.done;
        self.counts.started = snapshot.started;
        self.marking.path = snapshot.path;
        self.marking.doubtful = snapshot.doubtful;
        self.marking.axis_place = snapshot.place;
        let is_certain = snapshot.placed || snapshot.generation != 0;
        self.marking.unconfirmed = !is_certain && self.is_home_to_be_confirmed();
        // Without a place to compare with, a homing would be believed wherever it ends: counts begin anew with all at home.
        if snapshot.place == 0 && self.program.places_of_axis.as_ref().is_some_and(NumberedPlaces::is_homed) {
            self.views.generation = 0;
        }
        self.agreement.next_request = snapshot.next_request;
        if let (Some(orders), Some(kept), Some(tasks)) = (&mut self.orders, snapshot.order, &self.program.tasks) {
            **orders = OrderSlot::restored(kept, tasks);
        }
        Ok(())
    }

    /// Whether it stands at home by the chart, and nothing that is measured at rest would contradict. From a record that is not
    /// certain it is at home only if the devices confirm it, as without a record.
    fn is_home_to_be_confirmed(&self) -> bool {
        let is_judged_at_rest =
            self.home_switch() & !self.program.places[usize::from(self.program.home_place)].rest == 0;
        let is_there = |place| place == StationPlace::completed(self.program.home);
        let is_by_chart = if self.program.tasks.is_some() { self.marking().all(is_there) } else { self.is_at_home() };
        is_by_chart && !is_judged_at_rest
    }

    /// Reason why a snapshot is not one of this station's.
    fn check(&self, snapshot: &StationSnapshot) -> Result<(), &'static str> {
        let operations = self.counts.done.len();
        if snapshot.done.len() != operations || snapshot.started.len() != operations {
            return Err("other number of operations");
        }
        let known = |op: linewright_line::OpId| op.index() < operations;
        let exists =
            |p: &StationPlace| known(p.op) && (p.block == Block::Normal || !self.program.paths.contains(&p.op));
        if !snapshot.marking.iter().all(exists) {
            return Err("marked place not in the net");
        }
        if snapshot.path.is_some_and(|op| !self.program.paths.contains(&op)) {
            return Err("recovery path not in the net");
        }
        if snapshot.doubtful.is_some_and(|op| !known(op) || self.program.index_switch(op) == 0) {
            return Err("doubt of an operation that is no index");
        }
        if snapshot.place > self.program.places_of_axis.as_ref().map_or(0, |axis| axis.numbers.places) {
            return Err("place that no axis has");
        }
        let Some(first) = snapshot.marking.first() else { return Err("no marked place") };
        let step = self.program.step_of[first.op.index()];
        let mut marked: Vec<_> = snapshot.marking.iter().map(|p| p.op).collect();
        marked.sort_unstable();
        let whole_step =
            (0..operations).filter(|&op| self.program.step_of[op] == step).eq(marked.iter().map(|o| o.index()));
        // A recovery path runs one operation at a time, be it one of a group.
        let on_path = snapshot.path.is_some() && marked.len() == 1;
        if !whole_step && !on_path {
            return Err("marked places are not those of one step");
        }
        let counts = snapshot.done.iter().zip(&snapshot.started);
        // On its way home a station has claimed what it skips, which may belong to the next cycle.
        let newest = snapshot.cycle.saturating_add(i32::from(snapshot.path.is_some()));
        let in_order = |(&done, &started): (&i32, &i32)| -COUNT_MAX < done && done <= started && started <= newest;
        if snapshot.cycle > COUNT_MAX || !counts.into_iter().all(in_order) {
            return Err("counts contradict each other");
        }
        Ok(())
    }

    /// Record from which [`Restore::From`] brings the station up where it is now. Keep it before the outputs and the
    /// report of the same step leave, so that no state is sent that the record lacks.
    pub fn snapshot(&self) -> StationSnapshot {
        StationSnapshot {
            marking: self.marking().collect(),
            generation: self.views.generation,
            placed: self.marking.placed && !self.marking.unconfirmed,
            cycle: self.counts.cycle,
            done: self.counts.done.clone(),
            started: self.counts.started.clone(),
            path: self.marking.path,
            doubtful: self.marking.doubtful,
            place: self.marking.axis_place,
            next_request: self.agreement.next_request,
            order: self.orders.as_ref().map(|orders| orders.memory()),
        }
    }

    pub(crate) fn come_up(&mut self, restore: Restore) -> Result<(), CompileError> {
        match restore {
            Restore::Fresh => Ok(()),
            Restore::From(snapshot) => self.restore(snapshot),
        }
    }
}
