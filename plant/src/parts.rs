//! Parts: their locations, and how mechanisms move them.
//!
//! A part is at a position of a nest, or is in a hand, or both: a hand that holds it over an open clamp. Or it has
//! fallen down. Nothing else can happen to it: whatever outputs do, no part is lost and none is made. What happens
//! follows from where axes stand before and after a moment:
//!
//! ```text
//!   a hand opens         what it held stays in the nest it reaches, if that is free; else it falls
//!   a hand moves away    with what it holds; a closed clamp keeps its part
//!   a hand comes         what it holds is in the nest as well, if that is free and open
//!   a hand closes        it has the part that it reaches; or nothing, without a report
//! ```
//!
//! The position of a store at which a hand is follows from the outputs with the number, at the moment its axes come to
//! stand there. Parts are the true state of a cell, for observers of the plant from outside; controllers see sensors.

use std::collections::BTreeMap;

use linewright_line::{Grip, HolderId, Line, MaterialFlow, Reach, Sign, Stand, StationId, Tick};

use crate::by_hand::{PartByHand, PartRefusal};
use crate::fault::MotionFault;
use crate::positions::{PartPosition, PositionsMisfit, misfit};

/// So many mishaps are kept; later ones are only counted.
const MISHAPS_MAX: usize = 10_000;

/// A part, by the number that it was put in with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PartNo(pub u64);

/// A position in a nest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NestPosition {
    pub nest: HolderId,
    /// From 1.
    pub position: u16,
}

/// Location of a part. Neither here nor there: it has fallen down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartLocation {
    /// The nest it is in, or is held in.
    pub spot: Option<NestPosition>,
    /// The hand that has it.
    pub hand: Option<HolderId>,
}

/// Mishap of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartFault {
    /// A hand has let go of it where nothing was to take it, or could not hold it.
    Fell { part: PartNo, hand: HolderId, cause: FallCause },
    /// A hand has left with it while a clamp held it, and has lost it to the clamp.
    Torn { part: PartNo, hand: HolderId },
    /// It was brought to where it cannot be: a place that has another part, or a closed clamp.
    Blocked { part: PartNo, hand: HolderId, spot: NestPosition },
}

impl PartFault {
    /// Whether it has happened for certain. An axis with a drive is at each place that it passes, so a part may be brought there by the
    /// way. And a nest of a station on another bus is simulated there: here it stands as it began, and keeps what was put into it.
    pub fn is_certain(&self, line: &Line) -> bool {
        let bus = |station: StationId| &line.station(station).bus;
        let (hand, spot) = match *self {
            PartFault::Blocked { .. } => return false,
            PartFault::Fell { hand, cause: FallCause::Taken(spot) | FallCause::Shut(spot), .. } => (hand, spot),
            PartFault::Fell { .. } | PartFault::Torn { .. } => return true,
        };
        let Grip::Hand(hand) = line.handling.holder(hand).grip else { return true };
        let owner = line.handling.holder(spot.nest).name.split_once('.').and_then(|(name, _)| line.station_named(name));
        owner.is_none_or(|station| bus(station) == bus(hand.station))
    }
}

/// Why a part has fallen out of a hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FallCause {
    /// The hand opened where it reaches no nest.
    OverNothing,
    /// It opened over a nest, and the number on its outputs is that of no position there.
    NoPosition { nest: HolderId, number: u16 },
    /// It opened over a position with another part.
    Taken(NestPosition),
    /// It opened over a closed clamp.
    Shut(NestPosition),
    /// It was closed, and held nothing fast.
    NotHeld,
}

/// View of the mechanisms that parts need.
pub(crate) trait Mechanisms {
    /// Whether an axis stands there.
    fn stands(&self, stand: &Stand) -> bool;
    /// Whether a drive to there has this fault.
    fn suffers(&self, stand: &Stand, fault: MotionFault) -> bool;
    /// The outputs of a station.
    fn outputs(&self, station: StationId) -> u128;
}

/// The parts of a plant.
#[derive(Clone, Debug)]
pub(crate) struct PlantParts {
    handling: MaterialFlow,
    parts: BTreeMap<PartNo, PartLocation>,
    /// By holder: whether it is closed.
    closed: Vec<bool>,
    /// By reach: the spot, while the axes stand so and the number is that of a position.
    reached: Vec<Option<NestPosition>>,
    /// By station: inputs that see something.
    seen: Vec<u128>,
    mishaps: Vec<(Tick, PartFault)>,
    mishap_count: u64,
    /// People look after the stores.
    people: bool,
}

impl PlantParts {
    /// None of them; with the mechanisms as they stand.
    pub(crate) fn new(handling: &MaterialFlow, stations: usize, people: bool, mechanisms: &impl Mechanisms) -> Self {
        let mut parts = PlantParts {
            closed: vec![false; handling.holders.len()],
            reached: vec![None; handling.reaches.len()],
            handling: handling.clone(),
            parts: BTreeMap::new(),
            seen: vec![0; stations],
            mishaps: Vec::new(),
            mishap_count: 0,
            people,
        };
        parts.settle(Tick::ZERO, mechanisms);
        parts
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = (PartNo, PartLocation)> + '_ {
        self.parts.iter().map(|(part, at)| (*part, *at))
    }

    pub(crate) fn at(&self, spot: NestPosition) -> Option<PartNo> {
        self.all().find(|(_, at)| at.spot == Some(spot)).map(|(part, _)| part)
    }

    pub(crate) fn in_hand(&self, hand: HolderId) -> Option<PartNo> {
        self.all().find(|(_, at)| at.hand == Some(hand)).map(|(part, _)| part)
    }

    /// Where parts are, and what hands reach, to be kept.
    pub(crate) fn kept(&self) -> (Vec<PartPosition>, Vec<Option<u16>>) {
        let name = |holder: HolderId| self.handling.holders[holder.index()].name.clone();
        let part = |(part, at): (PartNo, PartLocation)| PartPosition {
            number: part.0,
            nest: at.spot.map(|spot| (name(spot.nest), spot.position)),
            hand: at.hand.map(name),
        };
        (self.all().map(part).collect(), self.reached.iter().map(|reached| reached.map(|spot| spot.position)).collect())
    }

    /// Puts parts where they were kept, with the mechanisms as they stand.
    ///
    /// # Errors
    /// When they cannot be there.
    pub(crate) fn resume(
        &mut self,
        parts: &[PartPosition],
        reached: &[Option<u16>],
        mechanisms: &impl Mechanisms,
    ) -> Result<(), PositionsMisfit> {
        if reached.len() != self.reached.len() {
            return misfit(format!("{} reaches of grippers, expected {}", reached.len(), self.reached.len()));
        }
        let places = |reach: &Reach| self.handling.holders[reach.to.index()].places;
        for ((reach, now), kept) in self.handling.reaches.iter().zip(&mut self.reached).zip(reached) {
            if let Some(position) = kept.filter(|position| !(1..=places(reach)).contains(position)) {
                return misfit(format!("a gripper at position {position} of a nest with {}", places(reach)));
            }
            *now = kept.map(|position| NestPosition { nest: reach.to, position });
        }
        self.parts.clear();
        for part in parts {
            let at = self.location(part)?;
            let is_taken = |other: &PartLocation| {
                at.spot.is_some() && other.spot == at.spot || at.hand.is_some() && other.hand == at.hand
            };
            if self.parts.values().any(is_taken) || self.parts.insert(PartNo(part.number), at).is_some() {
                return misfit(format!("part {} is where another is, or twice", part.number));
            }
        }
        // As they stood when the power went: nothing closes or opens by this.
        self.closed = self.handling.holders.iter().map(|holder| closed(holder.grip, mechanisms)).collect();
        self.look(mechanisms);
        Ok(())
    }

    fn location(&self, part: &PartPosition) -> Result<PartLocation, PositionsMisfit> {
        let holder = |name: &str, is_hand: bool| {
            let found = self.handling.holders.iter().position(|of| of.name == name && of.is_hand() == is_hand);
            found.map(HolderId::at).ok_or_else(|| PositionsMisfit(format!("there is no `{name}`")))
        };
        let spot = part.nest.as_ref().map(|(name, position)| {
            let (nest, position) = (holder(name, false)?, *position);
            let places = self.handling.holders[nest.index()].places;
            if !(1..=places).contains(&position) {
                return misfit(format!("position {position} of `{name}`, which has {places}"));
            }
            Ok(NestPosition { nest, position })
        });
        let hand = part.hand.as_ref().map(|name| holder(name, true));
        Ok(PartLocation { spot: spot.transpose()?, hand: hand.transpose()? })
    }

    pub(crate) fn mishaps(&self) -> (&[(Tick, PartFault)], u64) {
        (&self.mishaps, self.mishap_count)
    }

    /// The inputs of a station that see something.
    pub(crate) fn seen(&self, station: StationId) -> u128 {
        self.seen.get(station.index()).copied().unwrap_or(0)
    }

    /// A person puts a part somewhere: a new one, or one that has fallen down.
    pub(crate) fn put(
        &mut self,
        part: PartNo,
        spot: NestPosition,
        mechanisms: &impl Mechanisms,
    ) -> Result<(), PartRefusal> {
        let holders = self.handling.holders.get(spot.nest.index()).filter(|holder| !holder.is_hand());
        if holders.is_none_or(|nest| !(1..=nest.places).contains(&spot.position)) {
            return Err(PartRefusal::NoSuchSpot);
        }
        if self.parts.get(&part).is_some_and(|at| *at != PartLocation::default()) {
            return Err(PartRefusal::Known);
        }
        if self.at(spot).is_some() {
            return Err(PartRefusal::Occupied);
        }
        if self.closed[spot.nest.index()] {
            return Err(PartRefusal::Held);
        }
        self.parts.insert(part, PartLocation { spot: Some(spot), hand: None });
        self.look(mechanisms);
        Ok(())
    }

    /// A person takes a part away, out of the plant.
    pub(crate) fn take(&mut self, part: PartNo, mechanisms: &impl Mechanisms) -> Result<PartLocation, PartRefusal> {
        let at = *self.parts.get(&part).ok_or(PartRefusal::Unknown)?;
        if at.hand.is_some() || at.spot.is_some_and(|spot| self.closed[spot.nest.index()]) {
            return Err(PartRefusal::Held);
        }
        self.parts.remove(&part);
        self.look(mechanisms);
        Ok(at)
    }

    /// The part that a person would put into a nest, or take out of a nest or a hand. A hand lets a part be pulled out; a closed clamp
    /// does not.
    ///
    /// # Errors
    /// Why it cannot be done.
    pub(crate) fn offered(&self, what: PartByHand, at: NestPosition) -> Result<PartNo, PartRefusal> {
        let holder = self.handling.holders.get(at.nest.index());
        let holder =
            holder.filter(|holder| (1..=holder.places).contains(&at.position)).ok_or(PartRefusal::NoSuchSpot)?;
        let found = if holder.is_hand() { self.in_hand(at.nest) } else { self.at(at) };
        match (what, found) {
            (PartByHand::Put, _) if holder.is_hand() => Err(PartRefusal::NoSuchSpot),
            (PartByHand::Put, Some(_)) => Err(PartRefusal::Occupied),
            (PartByHand::Put, None) if self.closed[at.nest.index()] => Err(PartRefusal::Held),
            (PartByHand::Put, None) => Ok(self.next_number()),
            (PartByHand::Take, None) => Err(PartRefusal::Empty),
            (PartByHand::Take, Some(part)) => {
                let is_at = self.parts[&part];
                let is_clamped = is_at.spot.is_some_and(|spot| self.closed[spot.nest.index()]);
                let is_in_another = is_at.hand.is_some_and(|hand| hand != at.nest);
                if is_clamped || is_in_another { Err(PartRefusal::Held) } else { Ok(part) }
            }
        }
    }

    /// Does that, and gives the part.
    pub(crate) fn by_hand(
        &mut self,
        what: PartByHand,
        at: NestPosition,
        mechanisms: &impl Mechanisms,
    ) -> Result<PartNo, PartRefusal> {
        let part = self.offered(what, at)?;
        match what {
            PartByHand::Put => _ = self.parts.insert(part, PartLocation { spot: Some(at), hand: None }),
            PartByHand::Take => _ = self.parts.remove(&part),
        }
        self.look(mechanisms);
        Ok(part)
    }

    fn next_number(&self) -> PartNo {
        PartNo(self.parts.keys().next_back().map_or(1, |part| part.0.saturating_add(1)))
    }

    /// Does what follows from how the mechanisms stand now.
    pub(crate) fn settle(&mut self, now: Tick, mechanisms: &impl Mechanisms) {
        let was = std::mem::take(&mut self.closed);
        self.closed = self.handling.holders.iter().map(|holder| closed(holder.grip, mechanisms)).collect();
        let hands: Vec<(HolderId, Stand)> = self.hands().collect();
        for &(hand, _) in &hands {
            if was[hand.index()] && !self.closed[hand.index()] {
                self.open(now, hand, mechanisms);
            }
        }
        self.move_hands(now, mechanisms);
        for &(hand, stand) in &hands {
            let closes = !was[hand.index()] && self.closed[hand.index()];
            if closes && !mechanisms.suffers(&stand, MotionFault::Miss) {
                self.grasp(hand);
            }
            if mechanisms.suffers(&stand, MotionFault::Drop) {
                self.drop_from(now, hand);
            }
        }
        self.look(mechanisms);
    }

    fn hands(&self) -> impl Iterator<Item = (HolderId, Stand)> + '_ {
        self.handling.holders.iter().enumerate().filter_map(|(id, holder)| match holder.grip {
            Grip::Hand(stand) => Some((HolderId::at(id), stand)),
            Grip::Loose | Grip::Clamp(_) => None,
        })
    }

    /// The spot that a hand can take from, and put down at.
    fn reached_by(&self, hand: HolderId) -> Option<NestPosition> {
        let of_hand = self.handling.reaches.iter().zip(&self.reached).filter(|(reach, _)| reach.hand == hand);
        of_hand.filter_map(|(_, reached)| *reached).next()
    }

    /// A hand opens: the part stays where it is held by something else, or can lie.
    fn open(&mut self, now: Tick, hand: HolderId, mechanisms: &impl Mechanisms) {
        let Some(part) = self.in_hand(hand) else { return };
        let lies = match self.parts[&part].spot {
            Some(spot) => Ok(spot),
            None => self.put_down(hand, mechanisms),
        };
        self.parts.insert(part, PartLocation { spot: lies.ok(), hand: None });
        if let Err(cause) = lies {
            self.note(now, PartFault::Fell { part, hand, cause });
        }
    }

    /// The spot in which a part comes to lie that a hand lets go of.
    ///
    /// # Errors
    /// Why it falls.
    fn put_down(&self, hand: HolderId, mechanisms: &impl Mechanisms) -> Result<NestPosition, FallCause> {
        if let Some(spot) = self.reached_by(hand) {
            return match (self.closed[spot.nest.index()], self.at(spot)) {
                (true, _) => Err(FallCause::Shut(spot)),
                (false, Some(_)) => Err(FallCause::Taken(spot)),
                (false, None) => Ok(spot),
            };
        }
        let stands = |reach: &&Reach| reach.hand == hand && reach.when.iter().all(|stand| mechanisms.stands(stand));
        Err(self.handling.reaches.iter().find(stands).map_or(FallCause::OverNothing, |reach| {
            let outputs = reach.when.first().map_or(0, |stand| mechanisms.outputs(stand.station));
            FallCause::NoPosition { nest: reach.to, number: number(&reach.position, outputs) }
        }))
    }

    /// Axes have left nests, or come to some.
    fn move_hands(&mut self, now: Tick, mechanisms: &impl Mechanisms) {
        let before: Vec<Option<NestPosition>> = self.hands().map(|(hand, _)| self.reached_by(hand)).collect();
        for (reach, reached) in self.handling.reaches.iter().zip(&mut self.reached) {
            let stands = reach.when.iter().all(|stand| mechanisms.stands(stand));
            let (hand, nest) = (&self.handling.holders[reach.hand.index()], &self.handling.holders[reach.to.index()]);
            // The number on arrival counts until the axes leave.
            *reached = reached.filter(|_| stands).or_else(|| {
                let Grip::Hand(stand) = hand.grip else { return None };
                let position = number(&reach.position, mechanisms.outputs(stand.station));
                let is_one = stands && (1..=nest.places).contains(&position);
                is_one.then_some(NestPosition { nest: reach.to, position })
            });
        }
        let hands: Vec<HolderId> = self.hands().map(|(hand, _)| hand).collect();
        for (hand, before) in hands.into_iter().zip(before) {
            let after = self.reached_by(hand);
            if before != after {
                self.leave(now, hand);
                self.come(now, hand, after);
            }
        }
    }

    fn leave(&mut self, now: Tick, hand: HolderId) {
        let Some(part) = self.in_hand(hand) else { return };
        let is_clamped = self.parts[&part].spot.is_some_and(|spot| self.closed[spot.nest.index()]);
        let Some(at) = self.parts.get_mut(&part) else { return };
        if is_clamped {
            at.hand = None;
            self.note(now, PartFault::Torn { part, hand });
        } else {
            at.spot = None;
        }
    }

    /// Whether people serve a spot: that of a store, which is no station's.
    fn is_looked_after(&self, spot: NestPosition) -> bool {
        self.people && self.handling.holders.get(spot.nest.index()).is_some_and(|holder| !holder.name.contains('.'))
    }

    fn come(&mut self, now: Tick, hand: HolderId, spot: Option<NestPosition>) {
        let (Some(part), Some(spot)) = (self.in_hand(hand), spot) else { return };
        if self.is_looked_after(spot) {
            self.parts.retain(|_, at| at.spot != Some(spot) || at.hand.is_some());
        }
        if self.at(spot).is_some() || self.closed[spot.nest.index()] {
            self.note(now, PartFault::Blocked { part, hand, spot });
        } else if let Some(at) = self.parts.get_mut(&part) {
            at.spot = Some(spot);
        }
    }

    fn grasp(&mut self, hand: HolderId) {
        let empty = self.reached_by(hand).filter(|&spot| self.is_looked_after(spot) && self.at(spot).is_none());
        if let Some(spot) = empty {
            let next = self.next_number();
            self.parts.insert(next, PartLocation { spot: Some(spot), hand: None });
        }
        let part = self.reached_by(hand).and_then(|spot| self.at(spot));
        // A part in another hand is out of reach for this one.
        if let Some(at) = part.and_then(|part| self.parts.get_mut(&part)).filter(|at| at.hand.is_none()) {
            at.hand = Some(hand);
        }
    }

    /// A hand that holds nothing fast: what is nowhere else falls.
    fn drop_from(&mut self, now: Tick, hand: HolderId) {
        let Some(part) = self.in_hand(hand).filter(|part| self.parts[part].spot.is_none()) else { return };
        self.parts.insert(part, PartLocation::default());
        self.note(now, PartFault::Fell { part, hand, cause: FallCause::NotHeld });
    }

    /// Updates the sensors.
    fn look(&mut self, mechanisms: &impl Mechanisms) {
        self.seen.fill(0);
        for sensor in &self.handling.sensors {
            let is_so = |sign: &Sign| match sign {
                Sign::Stands(stand) => mechanisms.stands(stand),
                Sign::Part(holder) => self
                    .parts
                    .values()
                    .any(|at| at.hand == Some(*holder) || at.spot.is_some_and(|spot| spot.nest == *holder)),
            };
            if sensor.when.iter().all(is_so) {
                self.seen[sensor.station.index()] |= sensor.input.bit();
            }
        }
    }

    fn note(&mut self, now: Tick, mishap: PartFault) {
        self.mishap_count += 1;
        if self.mishaps.len() < MISHAPS_MAX {
            self.mishaps.push((now, mishap));
        }
    }
}

fn closed(grip: Grip, mechanisms: &impl Mechanisms) -> bool {
    match grip {
        Grip::Loose => false,
        Grip::Clamp(stand) | Grip::Hand(stand) => mechanisms.stands(&stand),
    }
}

/// The number that outputs carry; 1 where there are none.
fn number(bits: &[linewright_line::OutputId], image: u128) -> u16 {
    if bits.is_empty() {
        return 1;
    }
    let on = bits.iter().enumerate().filter(|(_, bit)| image & bit.bit() != 0);
    let number = on.fold(0u64, |number, (nth, _)| number | 1 << nth);
    u16::try_from(number).unwrap_or(0)
}
