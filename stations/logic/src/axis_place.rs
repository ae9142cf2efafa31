//! The places of an endless axis that a drive turns: they have numbers, and it is measured at which one it stands.
//!
//! A switch says that the axis is at a place; a drive says at which. So an index is an order to a place: to the one after the
//! place from which it began, which is remembered from before it begins until it is complete. An order that comes late or
//! twice, or again after a restart, leads to the same place.
//!
//! | the place it is at, or has left last | at a place | between places |
//! |---|---|---|
//! | from which the index began | has not left yet | under way |
//! | the next one | complete | gone too far: under way while its drive moves it, else in doubt |
//! | any other | in doubt | in doubt |
//! | not known: the drive is not homed | – | under way; only a person who holds it has it homed |
//!
//! At a rest the homing is none of the index: see [`crate::homing`].
//!
//! At rest the place is the one where the last index ended. Another one is in doubt: it was turned while nothing looked.

use linewright_line::net::{ControlMode, MotionStage, StationPlace};
use linewright_line::{Device, Drive, DriveIndex, Line, OpId, Owner, StationId};

use crate::controller::Controller;
use crate::event::PlacesApart;
use crate::parts::{IndexProgress, RunCommand, Token};
use crate::place_table::PlaceTable;

/// The places of the endless axis that a drive turns.
#[derive(Clone, Debug)]
pub(crate) struct NumberedPlaces {
    /// The operation that is an index of the axis.
    pub op: OpId,
    pub numbers: DriveIndex,
    /// The drive is homed: until then it measures nothing.
    is_homed: bool,
    /// The switches of the other axes while the index turns.
    pub while_turning: u128,
}

/// The drive that turns an endless axis of a station from place to place.
pub(crate) fn index_drive(line: &Line, station: StationId) -> Option<(&Drive, &DriveIndex)> {
    let drives = line.devices_of(Owner::Station(station)).filter_map(Device::drive);
    drives.filter_map(|drive| Some((drive, drive.index.as_ref()?))).next()
}

impl NumberedPlaces {
    pub fn of(drive: &Drive, numbers: &DriveIndex, (line, station): (&Line, StationId), op: OpId) -> Self {
        let while_turning = line.station(station).rest_inputs(StationPlace::operating(op));
        let is_homed = drive.homing.is_some();
        NumberedPlaces { op, numbers: numbers.clone(), is_homed, while_turning }
    }

    /// Whether the drive is homed: until then it measures nothing.
    pub fn is_homed(&self) -> bool {
        self.is_homed
    }

    pub fn mark_freeing(&self, places: &mut [PlaceTable]) {
        places.iter_mut().for_each(|table| table.frees = table.complete & self.while_turning != 0);
    }
}

impl Controller {
    /// The place that the drive reports; 0 while it tells none, or there is no such drive.
    fn measured_place(&self) -> u16 {
        let axis = self.program.places_of_axis.as_ref().filter(|_| self.image.valid);
        axis.map_or(0, |axis| axis.numbers.reported(self.image.bits))
    }

    /// The switch of the index while it is off because the drive is not homed: it says nothing then.
    pub(crate) fn unreferenced(&self) -> u128 {
        let axis = self.program.places_of_axis.as_ref().filter(|axis| axis.is_homed && self.image.valid);
        let silent = axis.filter(|_| self.measured_place() == 0);
        silent.map_or(0, |axis| self.program.index_switch(axis.op) & !self.image.bits)
    }

    /// What need not be measured for this motion: a person who holds it frees the axis so that the index can home it.
    /// Nothing locks an axis that is at an unknown place.
    pub(crate) fn disregarded(&self, place: u16) -> u128 {
        let frees = self.program.places[usize::from(place)].frees && self.commands.mode() == ControlMode::Manual;
        if frees { self.unreferenced() } else { 0 }
    }

    /// The index that homes the drive, where nothing is amiss but that it is not homed, and advance leads on to that.
    pub(crate) fn to_be_homed(&self) -> Option<OpId> {
        let silent = self.unreferenced();
        let axis = self.program.places_of_axis.as_ref().filter(|_| silent != 0 && self.marking.doubtful.is_none())?;
        if self.rests_to_be_homed().is_some()
            || self.marking().any(|place| place.op == axis.op && place.stage != MotionStage::Completed)
        {
            return Some(axis.op);
        }
        let token = self.tokens().first().filter(|token| self.marking.count == 1 && self.rest_off(token) == silent)?;
        let place = self.place(token);
        let onward = match place.stage {
            MotionStage::Completed => {
                let steps = self.program.causes.len();
                self.ops_of_step((usize::from(self.program.step_of[place.op.index()]) + 1) % steps).next()?
            }
            MotionStage::Operating | MotionStage::Incomplete => place.op,
        };
        let onward = &self.program.places[usize::from(self.program.index_of(StationPlace::operating(onward)))];
        (onward.frees || (onward.turns != 0 && self.program.tasks.is_some())).then_some(axis.op)
    }

    /// Follows the axis as it stands: its place is learned where it is not known, and is not to change.
    pub(crate) fn follow_place(&mut self) {
        let is_under_way = |token: &Token| self.program.places[usize::from(token.place)].turns != 0;
        let measured = self.measured_place();
        if measured == 0 || self.tokens().iter().any(is_under_way) {
            return;
        }
        let Some(op) = self.program.places_of_axis.as_ref().map(|axis| axis.op) else { return };
        let is_at_one = self.image.bits & self.program.index_switch(op) != 0;
        if self.marking.axis_place == 0 && self.marking.doubtful.is_none() && is_at_one {
            self.marking.axis_place = measured;
            self.due.report = true;
        } else if self.marking.axis_place != 0 && self.marking.axis_place != measured {
            self.doubt(op);
        }
    }

    /// What this image makes of an index of the axis; none for a doubt.
    pub(crate) fn measured_progress(&mut self, token: &Token) -> Option<IndexProgress> {
        let measured = self.measured_place();
        let turns = self.program.places[usize::from(token.place)].turns;
        let is_at_one = self.image.bits & turns != 0;
        if measured == 0 {
            // Without its devices, or before it is homed: its switch alone.
            return self.progress(token);
        }
        if self.marking.axis_place == 0 {
            if is_at_one {
                // It was led on to here, from an unknown place.
                return self.is_by_itself(token).then_some(IndexProgress::Arrived);
            }
            // The place it has left last is the one from which this index began.
            self.marking.axis_place = measured;
            self.due.report = true;
        }
        let next = self.next_place();
        match (measured == self.marking.axis_place, is_at_one) {
            (true, true) => Some(IndexProgress::AtStart),
            (true, false) => Some(IndexProgress::Away),
            (false, true) => (measured == next).then_some(IndexProgress::Arrived),
            // A drive that overshoots comes back, if it can.
            (false, false) => (measured == next && self.is_by_itself(token)).then_some(IndexProgress::Away),
        }
    }

    /// The place after the one that is known.
    fn next_place(&self) -> u16 {
        self.program.places_of_axis.as_ref().map_or(0, |axis| axis.numbers.next(self.marking.axis_place))
    }

    /// The outputs that say to which place an index goes. To none, an order that only homes the drive, where its place is
    /// not known: an axis that looks for its zero moves, so a person has to hold it.
    pub(crate) fn place_order(&self, index: usize) -> u128 {
        let token = &self.marking.tokens[index];
        let table = &self.program.places[usize::from(token.place)];
        let Some(axis) = self.program.places_of_axis.as_ref().filter(|_| table.is_measured) else { return 0 };
        let is_known = self.marking.axis_place != 0 && (self.measured_place() != 0 || token.run == RunCommand::Auto);
        if is_known { axis.numbers.order(self.next_place()) } else { 0 }
    }

    /// The place at which the axis is measured, where that is not the last one that was known.
    pub(crate) fn places_apart(&self) -> Option<PlacesApart> {
        let (measured, known) = (self.measured_place(), self.marking.axis_place);
        let differ = measured != 0 && known != 0 && measured != known;
        differ.then_some(PlacesApart { measured, known })
    }

    /// Whether the output image says another place than it is to: since it was worked out, the place has become known or lost.
    pub(crate) fn orders_another_place(&self, index: usize) -> bool {
        let bits = self.program.places_of_axis.as_ref().map_or(0, |axis| axis.numbers.order(u16::MAX));
        self.output.bits & bits != self.place_order(index)
    }

    /// An index is complete: the axis stands at another place.
    pub(crate) fn index_completes(&mut self, index: usize) {
        let table = &self.program.places[usize::from(self.marking.tokens[index].place)];
        if table.is_measured {
            self.marking.axis_place = self.measured_place();
        }
    }
}
