//! One station's mechanisms: axes, what drives them, and the switches they press.
//!
//! A description has operations; an axis has only drives (an output that pulls it towards a position) and switches (an
//! input that is on at a position). The translation is here.

use std::time::Duration;

use linewright_line::{Drive, DriveIndex, InputId, MotionSignals, OpId, OperationModule, OutputId, Station, Tick};

use crate::axis::{AxisState, Travel};
use crate::fault::MotionFault;
use crate::positions::{AxisPosition, PositionsMisfit, misfit};

/// A switch is on within this fraction of its operation's way.
///
/// Narrow enough that a motion's time is its time, wide enough that rounding never leaves a switch off.
const REACH: f64 = 0.001;
/// Coordinates nearer than this are one place.
const SAME_PLACE: f64 = 1e-6;
/// Most places that an endless axis can have left behind; far below what its counter holds.
const LEFT_MAX: u64 = 1 << 40;
/// Fraction of its speed at which a slipping motion moves.
const SLIP: f64 = 0.25;

/// Motion of an operation that a drive performs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stroke {
    Normal,
    Recovery,
}

/// An output that pulls an axis towards a position.
pub(crate) struct Actuator {
    pub(crate) op: OpId,
    pub(crate) stroke: Stroke,
    pub(crate) output: OutputId,
    pub(crate) fault: Option<MotionFault>,
    from: f64,
    target: f64,
    /// Duration of the whole way from `from` to `target`, above zero.
    duration: Duration,
    fault_input: Option<InputId>,
}

struct Switch {
    input: InputId,
    at: f64,
    reach: f64,
}

/// The places of an endless axis. From outside they are one: it stands at `home` in each of them.
///
/// Its gear goes from one to the next and rests there, however long its output stays on; the next index begins when the output
/// comes on again. It turns one way, whatever pulls at it.
struct Index {
    home: f64,
    by: f64,
    /// It has come to the next place under the output that is on.
    rests: bool,
    /// Number of places left behind.
    left: i64,
    /// Where a drive turns it: how its places are numbered. It goes to the one it is ordered to, if that is the next one.
    places: Option<DriveIndex>,
}

/// One axis with everything that acts on it.
pub(crate) struct Mechanism {
    pub(crate) drives: Vec<Actuator>,
    switches: Vec<Switch>,
    state: AxisState,
    /// Of an endless axis: how far it goes on with one index, and where it begins.
    index: Option<Index>,
    /// Its present motion: the drive's place in `drives`, its fault, and the factor of its duration.
    moving: Option<(usize, Option<MotionFault>, f64)>,
    /// Drives both ways are on; it stands.
    opposed: bool,
    /// Motions begun so far: makes every one's random factor its own.
    begun: u64,
    /// The moments at which its present motion changes an input or ends, in order; worked out when the motion begins,
    /// because queries are far more frequent than motions.
    changes: Vec<Tick>,
}

/// Effect of a change of outputs or faults on an axis.
pub(crate) struct AxisChange {
    /// Drives both ways have just come on at once.
    pub(crate) alarm: bool,
}

impl Mechanism {
    /// The axis of `station` with this place, standing at its home position, and the drive that moves it.
    pub(crate) fn new(station: &Station, axis: usize, drive: Option<&Drive>) -> Self {
        let mut mechanism = Mechanism {
            drives: Vec::new(),
            switches: Vec::new(),
            state: AxisState::standing(station.axes[axis].home),
            index: station.axes[axis].index.map(|by| Index {
                home: station.axes[axis].home,
                by,
                rests: false,
                left: 0,
                places: drive.and_then(|drive| drive.index.clone()),
            }),
            moving: None,
            opposed: false,
            begun: 0,
            changes: Vec::new(),
        };
        for (at, operation) in station.operations.iter().enumerate() {
            let motion = operation.motion;
            if motion.axis.index() != axis {
                continue;
            }
            let op = OpId::at(at);
            let end = motion.to + station.index_of(op).unwrap_or(0.0);
            mechanism.add(op, Stroke::Normal, (motion.from, end), operation.duration, operation.normal);
            if let OperationModule::Reversible { recovery, recovery_duration, .. } = &operation.module {
                mechanism.add(op, Stroke::Recovery, (motion.to, motion.from), *recovery_duration, *recovery);
            }
        }
        mechanism
    }

    fn add(&mut self, op: OpId, stroke: Stroke, way: (f64, f64), duration: Duration, signals: MotionSignals) {
        let (from, target) = way;
        // A motion that goes nowhere is complete where it stands.
        let reach = ((target - from).abs() * REACH).max(f64::EPSILON);
        // Operations that end at the same place mostly share its switch.
        if !self.switches.iter().any(|s| (s.input, s.at, s.reach) == (signals.complete, target, reach)) {
            self.switches.push(Switch { input: signals.complete, at: target, reach });
        }
        self.drives.push(Actuator {
            op,
            stroke,
            output: signals.actuator,
            fault: None,
            from,
            target,
            duration: duration.max(Duration::from_micros(1)),
            fault_input: signals.fault,
        });
    }

    /// Where it is kept: its position, between home and the next place if it is endless, and the places left behind.
    pub(crate) fn kept(&self, now: Tick) -> AxisPosition {
        AxisPosition { at: self.state.position(now), left: self.index.as_ref().map_or(0, |index| index.left) }
    }

    /// Stands where it was kept. One that a drive moves can be anywhere.
    ///
    /// # Errors
    /// When it cannot be there.
    pub(crate) fn resume(&mut self, now: Tick, kept: AxisPosition, has_drive: bool) -> Result<(), PositionsMisfit> {
        let (home, ends) = (self.state.position(now), self.drives.iter().flat_map(|drive| [drive.from, drive.target]));
        let (least, most) = ends.fold((home, home), |(least, most), end| (least.min(end), most.max(end)));
        let is_there = (least - SAME_PLACE..=most + SAME_PLACE).contains(&kept.at) || has_drive;
        if !kept.at.is_finite() || !is_there {
            return misfit(format!("{} is no position of it, from {least} to {most}", kept.at));
        }
        if kept.left.unsigned_abs() > LEFT_MAX {
            return misfit(format!("{} places left behind", kept.left));
        }
        self.state.place(now, kept.at);
        self.index.iter_mut().for_each(|index| index.left = kept.left);
        Ok(())
    }

    pub(crate) fn position(&self, now: Tick) -> f64 {
        let at = self.state.position(now);
        match &self.index {
            Some(index) if index.is_at_end(at) => at - index.by,
            Some(_) | None => at,
        }
    }

    /// Number of places an endless axis has come on by, whatever its station counts.
    pub(crate) fn indexes(&self, now: Tick) -> u64 {
        let at = self.state.position(now);
        let left = self.index.as_ref().map_or(0, |index| index.left + i64::from(index.is_at_end(at)));
        u64::try_from(left).unwrap_or(0)
    }

    /// Whether it stands at `at`, by a switch there. An axis that only passes does not stand.
    pub(crate) fn stands_at(&self, now: Tick, at: f64) -> bool {
        let switches = self.switches.iter().filter(|switch| same_place(switch.at, at));
        let reach = switches.map(|switch| switch.reach).reduce(f64::max);
        if let Some(index) = &self.index {
            return self.moving.is_none() && same_place(at, index.home) && self.is_in_place(now);
        }
        self.state.stands_at(now, at, reach.unwrap_or(SAME_PLACE))
    }

    /// Whether an endless axis is at one of its places.
    fn is_in_place(&self, now: Tick) -> bool {
        self.switches.iter().any(|switch| self.is_pressed(switch, self.state.position(now)))
    }

    /// Whether a switch is on where the axis is; that of an endless axis at both ends of an index.
    fn is_pressed(&self, switch: &Switch, position: f64) -> bool {
        switch.is_on(position) || self.index.as_ref().is_some_and(|index| switch.is_on(position + index.by))
    }

    /// Whether a drive to `at` has this fault.
    pub(crate) fn suffers_at(&self, at: f64, fault: MotionFault) -> bool {
        let end = |drive: &Actuator| drive.target - self.index.as_ref().map_or(0.0, |index| index.by);
        self.drives.iter().any(|drive| same_place(end(drive), at) && drive.fault == Some(fault))
    }

    /// Puts its axis where something else has moved it to, a drive.
    pub(crate) fn place(&mut self, now: Tick, at: f64) {
        let at = match &mut self.index {
            Some(index) => index.turned_to(at),
            None => at,
        };
        self.state.place(now, at);
        self.moving = None;
        self.changes.clear();
    }

    pub(crate) fn inputs(&self, now: Tick) -> u128 {
        let at = self.state.position(now);
        let switches = self.switches.iter().filter(|s| self.is_pressed(s, at)).map(|s| s.input);
        let broken = self.drives.iter().filter(|d| d.fault == Some(MotionFault::Break)).filter_map(|d| d.fault_input);
        let place = self.index.as_ref().map_or(0, |index| index.report(at));
        switches.chain(broken).fold(place, |image, input| image | input.bit())
    }

    /// The next moment after `now` at which its inputs change or its motion ends, if outputs stay as they are.
    pub(crate) fn next_change(&self, now: Tick) -> Option<Tick> {
        self.changes.iter().copied().find(|at| *at > now)
    }

    /// Works out [`Mechanism::changes`] anew: the arrival, and every tick at which a switch differs from the tick
    /// before.
    fn plan_changes(&mut self) {
        let state = &self.state;
        let mut changes = std::mem::take(&mut self.changes);
        changes.clear();
        changes.extend(state.arrival());
        for switch in &self.switches {
            let is_on = |at: Tick| self.is_pressed(switch, state.position(at));
            let flips = |at: &Tick| is_on(*at) != is_on(*at - Duration::from_micros(1));
            let begin = self.index.as_ref().map(|index| switch.at - index.by);
            for at in [Some(switch.at), begin].into_iter().flatten() {
                changes.extend(state.crossings(at, switch.reach).filter(flips));
            }
        }
        changes.sort_unstable();
        changes.dedup();
        self.changes = changes;
    }

    /// When its motion ends; time is advanced to here, as another drive may take over.
    pub(crate) fn arrival(&self) -> Option<Tick> {
        // Nothing changes after it.
        self.moving.and_then(|_| self.changes.last().copied())
    }

    /// Obeys the outputs in `image` and the faults from `now` on. `random` gives a motion's duration its factor, from
    /// the number of motions begun before.
    pub(crate) fn drive(&mut self, now: Tick, image: u128, random: impl Fn(u64) -> f64) -> AxisChange {
        let on = |drive: &&Actuator| image & drive.output.bit() != 0 && drive.target != drive.from;
        let ways = || self.drives.iter().filter(on).map(|drive| self.pull(drive, self.position(now)));
        let opposed = ways().any(|way| way > 0.0) && ways().any(|way| way < 0.0);
        let change = AxisChange { alarm: opposed && !self.opposed };
        self.opposed = opposed;
        let jammed =
            self.drives.iter().filter(on).any(|d| matches!(d.fault, Some(MotionFault::Stick | MotionFault::Break)));
        let chosen = if opposed || jammed {
            None
        } else if self.index.is_some() {
            self.turn_on(now, image)
        } else {
            self.choose(now, image)
        };
        let fault = chosen.and_then(|at| self.drives[at].fault);
        if let Some((was, was_fault, _)) = self.moving
            && chosen == Some(was)
            && fault == was_fault
        {
            return change;
        }
        if chosen.is_none() && self.moving.is_none() {
            return change;
        }
        self.moving = chosen.map(|at| {
            self.begun += 1;
            (at, fault, random(self.begun))
        });
        let travel = self.moving.map(|(at, fault, factor)| self.drives[at].travel(fault, factor));
        self.state.change(now, travel);
        self.plan_changes();
        change
    }

    /// The drive that turns an endless axis on, of those that are on; `None` if it is to rest. A new index is reckoned
    /// from home.
    fn turn_on(&mut self, now: Tick, image: u128) -> Option<usize> {
        let on = |drive: &&Actuator| image & drive.output.bit() != 0;
        let at = self.drives.iter().position(|drive| on(&drive));
        // A drive that drives back cannot.
        let chosen = at.filter(|_| !self.drives.iter().filter(on).any(|d| d.fault == Some(MotionFault::SlipBack)));
        let here = self.state.position(now);
        let index = self.index.as_mut()?;
        let chosen = chosen.filter(|_| index.goes_to_next(image, here));
        // A drive rests until it is ordered to another place, a gear until it is driven anew.
        let is_geared = index.places.is_none();
        index.rests =
            is_geared && at.is_some() && (index.rests || (self.moving.is_some() && here >= index.home + index.by));
        let chosen = chosen.filter(|_| !index.rests)?;
        if index.is_at_end(here) && self.moving.is_none() {
            index.left += 1;
            let from = here - index.by;
            self.state.place(now, from);
        }
        Some(chosen)
    }

    /// Direction in which a drive pulls, as a number above or below zero. One that brings the axis to its target from
    /// both sides pulls towards it; any other pulls on in its own direction.
    fn pull(&self, drive: &Actuator, here: f64) -> f64 {
        let way = drive.target - drive.from;
        let twin = |other: &Actuator| other.output == drive.output && same_place(other.target, drive.target);
        let is_both = self.drives.iter().any(|other| twin(other) && (other.target - other.from) * way < 0.0);
        if is_both { drive.target - here } else { way }
    }

    /// The drive that moves the axis, of those that are on: the one with the nearest target ahead. One output may serve
    /// several operations in a row; it then pulls from one's end to the next's. A drive that has arrived holds the
    /// axis; one whose target was left behind pulls back to it only if no other acts. Of drives that pull together a
    /// faulty one decides: one that slips back drags the others along, and holds them where it came from.
    fn choose(&self, now: Tick, image: u128) -> Option<usize> {
        let here = self.position(now);
        let is_on = |d: &Actuator| image & d.output.bit() != 0 && d.from != d.target;
        let on = || self.drives.iter().enumerate().filter(|(_, d)| is_on(d));
        if let Some((at, slipping)) = on().find(|(_, d)| d.fault == Some(MotionFault::SlipBack)) {
            return (here != slipping.from).then_some(at);
        }
        let ahead = |d: &Actuator| (d.target - here) * (d.target - d.from).signum() > 0.0;
        // Two operations may share output and target, from different ends: the one whose way begins here is meant, and
        // one that has begun is not changed for another on the way.
        let began = self.moving.map(|(at, ..)| at);
        let key = |at: usize, d: &Actuator| {
            let way_here = if began == Some(at) { -1.0 } else { (d.from - here).abs() };
            (d.fault.is_none(), (d.target - here).abs(), way_here)
        };
        let nearest = |only_ahead: bool| {
            let candidates = on().filter(|(_, d)| !only_ahead || ahead(d)).map(|(at, d)| (at, key(at, d)));
            let first =
                candidates.min_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2)));
            first.map(|(at, _)| at)
        };
        let arrived = on().any(|(_, d)| d.target == here);
        nearest(true).or_else(|| if arrived { None } else { nearest(false) })
    }
}

impl Actuator {
    fn travel(&self, fault: Option<MotionFault>, factor: f64) -> Travel {
        let speed = (self.target - self.from).abs() / (self.duration.as_micros() as f64 * factor);
        match fault {
            Some(MotionFault::Slip) => Travel { target: self.target, speed: speed * SLIP },
            Some(MotionFault::SlipBack) => Travel { target: self.from, speed: speed * SLIP },
            Some(MotionFault::Stick | MotionFault::Break | MotionFault::Miss | MotionFault::Drop) | None => {
                Travel { target: self.target, speed }
            }
        }
    }
}

fn same_place(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_PLACE
}

impl Index {
    /// Its drive has moved it to `at`, which counts on over all turns; gives where that is from its home.
    fn turned_to(&mut self, at: f64) -> f64 {
        let sign = self.places.as_ref().map_or(1.0, DriveIndex::sign);
        let gone = (at - self.home) * sign;
        self.left = (gone / self.by + REACH).floor() as i64;
        self.home + gone - self.left as f64 * self.by
    }

    /// The number of the place it is at, or has left last.
    fn number(&self, position: f64) -> Option<u16> {
        let count = i64::from(self.places.as_ref()?.places);
        let is_at_next = self.is_at_end(position);
        u16::try_from((self.left + i64::from(is_at_next)).rem_euclid(count) + 1).ok()
    }

    fn report(&self, position: f64) -> u128 {
        let number = self.number(position);
        self.places.as_ref().zip(number).map_or(0, |(places, number)| places.report(number))
    }

    /// Whether it may go on under these outputs: a drive is ordered to the next place, anything else to none.
    fn goes_to_next(&self, outputs: u128, position: f64) -> bool {
        let Some((places, number)) = self.places.as_ref().zip(self.number(position)) else { return true };
        places.ordered(outputs) == places.next(number)
    }

    /// Whether a position is that of the next place.
    fn is_at_end(&self, position: f64) -> bool {
        // A motion that its switch has stopped stands at the edge of the reach. With numbered places the reach is that of the number:
        // otherwise a drive just before its place would count as being at it, and be turned on to the next.
        let reach = if self.places.is_some() { REACH } else { 1.5 * REACH };
        position >= self.home + self.by * (1.0 - reach)
    }
}

impl Switch {
    fn is_on(&self, position: f64) -> bool {
        (position - self.at).abs() <= self.reach
    }
}
