//! The mechanisms of a line: outputs in, time, inputs out.
//!
//! Pure and event-driven: between two changes every axis moves on a straight line, so [`Plant::advance`] costs the same
//! for a microsecond and for an hour, and [`Plant::next_change`] gives exactly the time of the next change. The same
//! seed gives the same plant.

use linewright_line::{AxisId, Device, HolderId, InputId, Line, OpId, OutputId, Owner, Stand, StationId, Tick};
use linewright_random::mix;

use crate::by_hand::{PartByHand, PartRefusal};
use crate::fault::MotionFault;
use crate::mechanism::{Mechanism, Stroke};
use crate::parts::{Mechanisms, NestPosition, PartFault, PartLocation, PartNo, PlantParts};
use crate::positions::{AxisPosition, PartPosition, PositionsMisfit, misfit};

/// Deviations of a plant from its description.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantOptions {
    /// Seed of its random deviations.
    pub seed: u64,
    /// Largest deviation of a motion's duration, as a fraction: 0.1 is up to a tenth shorter or longer. At most 0.9.
    pub variation: f64,
    /// People serve the stores: they bring a part when a hand reaches for one in a store and there is none, and take
    /// one away where another is brought: a cell gets its parts by hand, and gives them away so.
    pub people: bool,
}

/// The mechanisms of a line.
pub struct Plant {
    options: PlantOptions,
    now: Tick,
    /// By station, by axis.
    stations: Vec<Vec<Mechanism>>,
    /// By station: when the first of its motions ends.
    arrivals: Vec<Tick>,
    /// By station.
    outputs: Vec<u128>,
    lamps: u128,
    /// The console's inputs while it is not touched: a closed-circuit contact is on.
    untouched: u128,
    /// By station, at its end the console: inputs held, and those of them held on.
    forced: Vec<(u128, u128)>,
    alarms: u64,
    /// `None` in a line whose description has no places for parts.
    parts: Option<PlantParts>,
}

/// View of a plant for its parts.
struct Axes<'p> {
    now: Tick,
    stations: &'p [Vec<Mechanism>],
    outputs: &'p [u128],
}

impl Mechanisms for Axes<'_> {
    fn stands(&self, stand: &Stand) -> bool {
        self.stations[stand.station.index()][stand.axis.index()].stands_at(self.now, stand.at)
    }

    fn suffers(&self, stand: &Stand, fault: MotionFault) -> bool {
        self.stations[stand.station.index()][stand.axis.index()].suffers_at(stand.at, fault)
    }

    fn outputs(&self, station: StationId) -> u128 {
        self.outputs[station.index()]
    }
}

impl Plant {
    /// The mechanisms of `line`, every axis at home, every output off, and no part in it.
    pub fn new(line: &Line, options: PlantOptions) -> Self {
        let axes = |id: StationId| {
            let drive = |axis: usize| {
                let mut drives = line.devices_of(Owner::Station(id)).filter_map(Device::drive);
                drives.find(|drive| drive.axis.index() == axis)
            };
            let station = line.station(id);
            (0..station.axes.len()).map(|axis| Mechanism::new(station, axis, drive(axis))).collect()
        };
        let mut plant = Plant {
            options,
            now: Tick::ZERO,
            stations: line.station_ids().map(axes).collect(),
            arrivals: vec![Tick::NEVER; line.stations.len()],
            outputs: vec![0; line.stations.len()],
            lamps: 0,
            untouched: line.console.estop.filter(|contact| !contact.pressed).map_or(0, |contact| 1 << contact.input.0),
            forced: vec![(0, 0); line.stations.len() + 1],
            alarms: 0,
            parts: None,
        };
        if !line.handling.is_empty() {
            plant.parts = Some(PlantParts::new(&line.handling, line.stations.len(), options.people, &plant.axes()));
        }
        plant
    }

    fn axes(&self) -> Axes<'_> {
        Axes { now: self.now, stations: &self.stations, outputs: &self.outputs }
    }

    /// Lets parts follow the mechanisms.
    fn settle(&mut self) {
        let axes = Axes { now: self.now, stations: &self.stations, outputs: &self.outputs };
        if let Some(parts) = &mut self.parts {
            parts.settle(self.now, &axes);
        }
    }

    /// The moment it has been advanced to.
    pub fn now(&self) -> Tick {
        self.now
    }

    /// Lets time pass until `now`. A moment already passed changes nothing.
    pub fn advance(&mut self, now: Tick) {
        if self.parts.is_some() {
            // Parts follow from every moment at which something comes or leaves, not from the last one alone.
            while let Some(at) = self.next_change().filter(|at| *at <= now) {
                self.advance_axes(at);
                self.settle();
            }
        }
        self.advance_axes(now);
    }

    fn advance_axes(&mut self, now: Tick) {
        // Where one drive ends another may take over, if one output serves two operations: such moments are settled one
        // by one, at their own time, so that the times of queries do not matter.
        while let Some((at, station)) = self.next_arrival().filter(|(at, _)| *at <= now) {
            self.now = self.now.max(at);
            let arrived = |mechanism: &Mechanism| mechanism.arrival() == Some(at);
            if let Some(axis) = self.stations[station].iter().position(arrived) {
                self.redrive(station, axis);
            }
        }
        self.now = self.now.max(now);
    }

    /// Sets the outputs of `owner` at `now`: bit `i` is output `i`. The console's outputs are lamps and move nothing.
    pub fn set_outputs(&mut self, now: Tick, owner: Owner, image: u128) {
        self.advance(now);
        let held = match owner {
            Owner::Station(id) => &mut self.outputs[id.index()],
            Owner::Console => &mut self.lamps,
        };
        if std::mem::replace(held, image) == image {
            return;
        }
        if let Owner::Station(id) = owner {
            self.redrive_station(id.index());
            self.settle();
        }
    }

    pub fn outputs(&self, owner: Owner) -> u128 {
        match owner {
            Owner::Station(id) => self.outputs.get(id.index()).copied().unwrap_or(0),
            Owner::Console => self.lamps,
        }
    }

    /// The inputs of `owner`: bit `i` is input `i`. Those no mechanism presses are off until they are forced, and a
    /// closed-circuit contact of the console on.
    pub fn inputs(&self, owner: Owner) -> u128 {
        let pressed = match owner {
            Owner::Station(id) => self.stations.get(id.index()).map(Vec::as_slice).unwrap_or_default(),
            Owner::Console => &[],
        };
        let seen = match (owner, &self.parts) {
            (Owner::Station(id), Some(parts)) => parts.seen(id),
            (Owner::Station(_), None) => 0,
            (Owner::Console, _) => self.untouched,
        };
        let image = pressed.iter().fold(seen, |image, mechanism| image | mechanism.inputs(self.now));
        let (held, on) = self.forced[self.place_of(owner)];
        image & !held | on
    }

    /// The place of an owner's entry in `forced`.
    fn place_of(&self, owner: Owner) -> usize {
        match owner {
            Owner::Station(id) => id.index(),
            Owner::Console => self.stations.len(),
        }
    }

    /// The next moment at which an input changes or a motion ends, if nothing is set before.
    pub fn next_change(&self) -> Option<Tick> {
        self.stations.iter().flatten().filter_map(|mechanism| mechanism.next_change(self.now)).min()
    }

    /// The same of one station alone, for callers that play stations one by one. Where parts are handled, a station's
    /// inputs change with other stations' mechanisms too.
    pub fn next_change_of(&self, station: StationId) -> Option<Tick> {
        if self.parts.is_some() {
            return self.next_change();
        }
        let mechanisms = self.stations.get(station.index())?;
        mechanisms.iter().filter_map(|mechanism| mechanism.next_change(self.now)).min()
    }

    /// Position of an axis, in its own unit.
    pub fn position(&self, station: StationId, axis: AxisId) -> f64 {
        self.stations[station.index()][axis.index()].position(self.now)
    }

    /// Number of places an endless axis has come on by since the beginning.
    pub fn indexes(&self, station: StationId, axis: AxisId) -> u64 {
        self.stations[station.index()][axis.index()].indexes(self.now)
    }

    /// Puts an axis where it was moved by other means than an output: by a drive, which has its own laws of motion.
    pub fn place(&mut self, now: Tick, station: StationId, axis: AxisId, at: f64) {
        self.advance(now);
        self.stations[station.index()][axis.index()].place(self.now, at);
        self.settle();
    }

    /// Where an axis is kept while the power is off.
    pub(crate) fn kept_axis(&self, station: StationId, axis: AxisId) -> AxisPosition {
        self.stations[station.index()][axis.index()].kept(self.now)
    }

    /// Puts an axis where it was kept, before anything has moved.
    pub(crate) fn resume_axis(
        &mut self,
        (station, axis): (StationId, AxisId),
        kept: AxisPosition,
        has_drive: bool,
    ) -> Result<(), PositionsMisfit> {
        self.stations[station.index()][axis.index()].resume(self.now, kept, has_drive)
    }

    /// Where parts are, and what hands reach.
    pub(crate) fn kept_parts(&self) -> (Vec<PartPosition>, Vec<Option<u16>>) {
        self.parts.as_ref().map(PlantParts::kept).unwrap_or_default()
    }

    /// Puts parts where they were kept, once all axes are.
    pub(crate) fn resume_parts(
        &mut self,
        parts: &[PartPosition],
        reached: &[Option<u16>],
    ) -> Result<(), PositionsMisfit> {
        let axes = Axes { now: self.now, stations: &self.stations, outputs: &self.outputs };
        match &mut self.parts {
            Some(own) => own.resume(parts, reached, &axes),
            None if parts.is_empty() && reached.is_empty() => Ok(()),
            None => misfit("it has no places for parts"),
        }
    }

    /// Number of times that drives both ways of one axis have come on at once. A controller must never do that; the
    /// axis then stands still.
    pub fn alarms(&self) -> u64 {
        self.alarms
    }

    /// Makes the normal motion of an operation fail, or work again (`None`), from `now` on.
    pub fn inject(&mut self, now: Tick, station: StationId, op: OpId, fault: Option<MotionFault>) {
        self.set_fault(now, station, fault, |drive| drive.op == op && drive.stroke == Stroke::Normal);
    }

    /// Makes the recovery motion of an operation fail, or work again (`None`), from `now` on.
    pub fn inject_recovery(&mut self, now: Tick, station: StationId, op: OpId, fault: Option<MotionFault>) {
        self.set_fault(now, station, fault, |drive| drive.op == op && drive.stroke == Stroke::Recovery);
    }

    /// Makes every motion that an output drives fail, or work again (`None`), from `now` on.
    pub fn inject_output(&mut self, now: Tick, owner: Owner, output: OutputId, fault: Option<MotionFault>) {
        if let Owner::Station(station) = owner {
            self.set_fault(now, station, fault, |drive| drive.output == output);
        }
    }

    /// Holds an input of `owner` on or off, whatever the mechanism does, or lets go of it (`None`): a finger on a
    /// button, a stuck switch.
    pub fn force(&mut self, owner: Owner, input: InputId, value: Option<bool>) {
        let place = self.place_of(owner);
        let (held, on) = &mut self.forced[place];
        let input = input.bit();
        (*held, *on) = (*held & !input, *on & !input);
        if let Some(value) = value {
            *held |= input;
            *on |= if value { input } else { 0 };
        }
    }

    fn set_fault(
        &mut self,
        now: Tick,
        station: StationId,
        fault: Option<MotionFault>,
        hit: impl Fn(&crate::mechanism::Actuator) -> bool,
    ) {
        self.advance(now);
        let Some(mechanisms) = self.stations.get_mut(station.index()) else { return };
        for drive in mechanisms.iter_mut().flat_map(|m| &mut m.drives).filter(|d| hit(d)) {
            drive.fault = fault;
        }
        self.redrive_station(station.index());
        self.settle();
    }

    /// A person puts a part somewhere, at `now`: a new one, or one that has fallen down.
    ///
    /// # Errors
    /// Why it cannot be put there.
    pub fn put(&mut self, now: Tick, part: PartNo, spot: NestPosition) -> Result<(), PartRefusal> {
        self.advance(now);
        let axes = Axes { now: self.now, stations: &self.stations, outputs: &self.outputs };
        self.parts.as_mut().map_or(Err(PartRefusal::NoSuchSpot), |parts| parts.put(part, spot, &axes))
    }

    /// A person takes a part away at `now`, out of the plant; gives where it was.
    ///
    /// # Errors
    /// Why it cannot be taken.
    pub fn take(&mut self, now: Tick, part: PartNo) -> Result<PartLocation, PartRefusal> {
        self.advance(now);
        let axes = Axes { now: self.now, stations: &self.stations, outputs: &self.outputs };
        self.parts.as_mut().map_or(Err(PartRefusal::Unknown), |parts| parts.take(part, &axes))
    }

    /// A person puts a new part into a nest, or takes out what is in a nest or in a hand, at `now`. A part can be pulled out of a closed
    /// hand, and not out of a closed clamp; nothing is put into a hand.
    ///
    /// # Errors
    /// Why it cannot be done.
    pub fn by_hand(&mut self, now: Tick, what: PartByHand, at: NestPosition) -> Result<PartNo, PartRefusal> {
        self.advance(now);
        let axes = Axes { now: self.now, stations: &self.stations, outputs: &self.outputs };
        self.parts.as_mut().map_or(Err(PartRefusal::NoSuchSpot), |parts| parts.by_hand(what, at, &axes))
    }

    /// Why a person cannot do that now, if so.
    pub fn objection(&self, what: PartByHand, at: NestPosition) -> Option<PartRefusal> {
        self.parts.as_ref().map_or(Some(PartRefusal::NoSuchSpot), |parts| parts.offered(what, at).err())
    }

    pub fn parts(&self) -> impl Iterator<Item = (PartNo, PartLocation)> + '_ {
        self.parts.iter().flat_map(PlantParts::all)
    }

    pub fn part_at(&self, spot: NestPosition) -> Option<PartNo> {
        self.parts.as_ref()?.at(spot)
    }

    pub fn part_in(&self, hand: HolderId) -> Option<PartNo> {
        self.parts.as_ref()?.in_hand(hand)
    }

    /// Mishaps of parts, as far as they are kept, and their number.
    pub fn mishaps(&self) -> (&[(Tick, PartFault)], u64) {
        self.parts.as_ref().map_or((&[], 0), PlantParts::mishaps)
    }

    fn next_arrival(&self) -> Option<(Tick, usize)> {
        let arrivals = self.arrivals.iter().enumerate().filter(|(_, at)| **at != Tick::NEVER);
        arrivals.map(|(station, at)| (*at, station)).min()
    }

    fn redrive_station(&mut self, station: usize) {
        for axis in 0..self.stations[station].len() {
            self.redrive(station, axis);
        }
    }

    fn redrive(&mut self, station: usize, axis: usize) {
        let image = self.outputs(Owner::Station(StationId::at(station)));
        let PlantOptions { seed, variation, people: _ } = self.options;
        let place = (station as u64) << 48 | (axis as u64) << 32;
        let factor = |begun| 1.0 + variation.clamp(0.0, 0.9) * (2.0 * unit(seed ^ mix(place | begun)) - 1.0);
        let change = self.stations[station][axis].drive(self.now, image, factor);
        self.alarms += u64::from(change.alarm);
        let arrivals = self.stations[station].iter().filter_map(Mechanism::arrival);
        self.arrivals[station] = arrivals.min().unwrap_or(Tick::NEVER);
    }
}

/// A number in 0..1 that follows from `seed` alone.
fn unit(seed: u64) -> f64 {
    (mix(seed) >> 11) as f64 / (1u64 << 53) as f64
}
