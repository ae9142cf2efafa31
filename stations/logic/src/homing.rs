//! The homing of a drive that turns an endless axis, while its station stands at a rest.
//!
//! A drive that has lost its reference says nothing, so the position of its station is lost. To home it restores the position;
//! it is no index: nothing is counted by it, no place is marked, and the arrows that order the next index are not waited for.
//! They could not hold: what they wait for needs the axis at its place. In manual mode a person holds *advance*, and the output
//! of the index is on, with no place, for as long as all of this holds:
//!
//! * The station stands at a rest, its other axes measured where they are while the axis turns.
//! * Of each conflict that a turning axis has a part in the other station is measured outside (see `interlock`); it is received,
//!   stands, has its position, and stands outside by its marking. So neither barrier is left out.
//! * Arrows from stations without such a conflict hold as for the index: what else they keep apart is not known. Where counts are
//!   not compared, since generations differ, such a station stands.
//! * The drive has said nothing for so long that no station has a view of the time before, and what one may have started by
//!   such a view is received.
//!
//! Meanwhile the position is lost and the station reports that it moves: no count of it is relied on, and no motion of another
//! station relies on its measured positions or on its standstill. Where the axis is homed it is compared with the place that is
//! known (see `axis_place`).

use linewright_line::net::{ControlMode, MotionStage, StationPlace};
use linewright_line::{OpId, StationId, Tick};

use crate::controller::Controller;
use crate::position_guard::{OwnSide, PositionGuard};
use crate::program::{IncomingArrow, bit};

/// Times the age of a stale message: one for the view by which another station starts, one for the view of that start.
const SILENCES: u32 = 2;

/// The homing at a rest.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Homing {
    /// A person holds it, and nothing forbids it.
    pub is_driven: bool,
    /// When the drive was first seen to say nothing; none while it does, or its devices are lost.
    silent_since: Option<Tick>,
}

/// What a homing waits for.
pub(crate) enum HomingNeed<'a> {
    /// A measured position.
    Position(PositionGuard),
    /// The state of another station.
    State(StationId),
    /// Its position, which is lost.
    PlaceOf(StationId),
    /// Its standstill.
    Standstill(StationId),
    /// Its being led out of its state of this conflict.
    Outside(StationId, u16),
    /// An arrow of a station without a conflict.
    Arrow(&'a IncomingArrow),
    /// The end of the drive's fault: these inputs.
    Fault(u128),
    /// The end of all views of the time before.
    OldViews,
}

impl Controller {
    /// The index whose axis is homed by advance where the station stands now, if nothing else is in the way.
    pub(crate) fn rests_to_be_homed(&self) -> Option<OpId> {
        let axis = self.program.places_of_axis.as_ref().filter(|_| self.unreferenced() != 0)?;
        let is_known = self.rules.positions && !self.marking.unconfirmed && self.marking.doubtful.is_none();
        let is_by_cycle = self.program.tasks.is_none() && self.marking.path.is_none();
        let rests = self.marking().all(|place| place.stage == MotionStage::Completed);
        let frees = axis.while_turning;
        (is_known && is_by_cycle && rests && self.image.bits & frees == frees).then_some(axis.op)
    }

    /// What the homing at a rest waits for now.
    pub(crate) fn homing_need(&self, op: OpId) -> Option<HomingNeed<'_>> {
        let place = StationPlace::operating(op);
        let failed = self.image.bits & self.program.places[usize::from(self.program.index_of(place))].fault;
        if failed != 0 {
            return Some(HomingNeed::Fault(failed));
        }
        if let Some(need) = self.program.guards(place, None).find_map(|(guard, _)| self.guard_need(guard)) {
            return Some(need);
        }
        let step = self.program.step_of[op.index()];
        let keeps_apart = |peer: u16| {
            let mut guards = self.program.guards(place, None);
            guards.any(|(guard, _)| guard.peer == peer && guard.own == OwnSide::Inside)
        };
        let arrows =
            self.program.causes[usize::from(step)].iter().filter(|arrow| arrow.modes[ControlMode::Manual as usize]);
        let cycle = self.cycle_of_start(step);
        let mut others = arrows.filter(|arrow| !keeps_apart(arrow.peer));
        let is_unsure = |peer: usize| {
            let is_measured_only = self.views.positions_stand_in(peer, ControlMode::Manual, self.now);
            is_measured_only && !self.views.stands(peer, self.now)
        };
        let hinders = |arrow: &&IncomingArrow| {
            let holds = self.views.holds(arrow, ControlMode::Manual, cycle, self.now);
            !holds || is_unsure(usize::from(arrow.peer))
        };
        if let Some(arrow) = others.find(hinders) {
            let peer = usize::from(arrow.peer);
            return Some(match is_unsure(peer) {
                true => HomingNeed::Standstill(self.views.peers[peer].station),
                false => HomingNeed::Arrow(arrow),
            });
        }
        let silence = self.homing.silent_since.map(|since| self.now.since(since));
        // Where the clock stands still, every report has been received.
        let is_over = self.program.peers.is_empty()
            || !self.rules.timely
            || silence.is_some_and(|silence| silence >= self.stale * SILENCES);
        (!is_over).then_some(HomingNeed::OldViews)
    }

    fn guard_need(&self, guard: PositionGuard) -> Option<HomingNeed<'_>> {
        let peer = usize::from(guard.peer);
        let view = &self.views.peers[peer];
        if guard.own == OwnSide::Inside {
            if !self.views.is_heard(peer, self.now) {
                return Some(HomingNeed::State(view.station));
            }
            if view.position_lost {
                return Some(HomingNeed::PlaceOf(view.station));
            }
        }
        if !guard.holds(self.positions_known(&guard)) {
            return Some(HomingNeed::Position(guard));
        }
        if guard.own != OwnSide::Inside {
            return None;
        }
        // With a request open it is about to move.
        if !self.views.stands(peer, self.now) || view.request.is_some() {
            return Some(HomingNeed::Standstill(view.station));
        }
        let mut spans = self.program.spans.iter().filter(|span| span.conflict == guard.conflict);
        (!spans.all(|span| span.is_left_by(view))).then_some(HomingNeed::Outside(view.station, guard.conflict))
    }

    /// The index whose axis is being homed at a rest.
    pub fn homes(&self) -> Option<OpId> {
        self.program.places_of_axis.as_ref().filter(|_| self.homing.is_driven).map(|axis| axis.op)
    }

    fn may_be_homed(&self) -> bool {
        let rests = self.rests_to_be_homed().filter(|_| self.commands.mode() == ControlMode::Manual);
        rests.is_some_and(|op| self.homing_need(op).is_none())
    }

    /// Begins, goes on with or ends the homing at a rest. It begins by an edge of advance that nothing else has used.
    pub(crate) fn follow_homing(&mut self, edges: u128) {
        if self.program.places_of_axis.is_none() {
            return;
        }
        let silent = self.unreferenced() != 0;
        self.homing.silent_since = silent.then(|| self.homing.silent_since.unwrap_or(self.now));
        let begins = bit::levels(edges) & bit::ADVANCE != 0;
        let is_held = self.levels.now & bit::ADVANCE != 0;
        let is_driven = is_held && (self.homing.is_driven || begins) && self.may_be_homed();
        if is_driven != self.homing.is_driven {
            self.homing.is_driven = is_driven;
            self.due.outputs = true;
            self.due.report = true;
        }
    }

    /// The output that homes the drive; with no place beside it.
    pub(crate) fn homing_output(&self) -> u128 {
        let axis = self.program.places_of_axis.as_ref().filter(|_| self.homing.is_driven);
        let place = axis.map(|axis| self.program.index_of(StationPlace::operating(axis.op)));
        place.map_or(0, |place| self.program.places[usize::from(place)].actuator)
    }

    /// The inputs that a homing reads.
    pub(crate) fn homing_inputs(&self) -> u128 {
        let axis = self.program.places_of_axis.as_ref().filter(|_| self.unreferenced() != 0);
        axis.map_or(0, |axis| {
            let table = &self.program.places[usize::from(self.program.index_of(StationPlace::operating(axis.op)))];
            table.fault | table.turns | axis.while_turning
        })
    }
}
