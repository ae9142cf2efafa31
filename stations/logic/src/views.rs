//! This station's views of the others, and its conclusions.
//!
//! A view is the newest report of another station, with an age. A view that is too old is *unknown*, and unknown
//! blocks every condition that reads it, negated or not. In normal operation counts only grow, so a late view can
//! delay a start but never allow a wrong one. The dangerous direction is a count going back; two rules meet it here:
//!
//! * While a view shows an open request to take back the count of an operation, that count is read as already taken
//!   back. So nothing new is started on it — whether or not this station has agreed, and whatever it lost in a restart.
//! * A request is agreed to only if every operation of ours that builds on the count has not started in that cycle,
//!   or has been undone. The answer is worked out once for each request number and then stands.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId, Tick};

use crate::ignored::Ignored;
use crate::peer_set::PeerSet;
use crate::program::{IncomingArrow as Cause, Program};
use crate::report::{AgreementAnswer, AgreementRequest, StationReport};
use crate::rules::Rules;

/// The newest state received of one other station.
#[derive(Clone, Debug)]
pub(crate) struct PeerView {
    pub station: StationId,
    pub boot_id: u64,
    /// When this life of it was received first.
    pub life_since: Tick,
    /// Unknown from then on.
    pub known_until: Tick,
    /// Its generation; 0 for none.
    pub generation: u64,
    /// An axis of it is not where its chart has it: nothing builds on its counts.
    pub position_lost: bool,
    /// Nothing of it is driven.
    pub stopped: bool,
    /// Its input image.
    pub measured: u128,
    /// Time from which on the input image is unknown.
    pub measured_until: Tick,
    pub done: Vec<i32>,
    pub cycle: i32,
    /// Its marking, of each operation the number of its place; empty where nothing here reads it.
    pub places: Vec<u8>,
    pub recovering_home: bool,
    pub request: Option<AgreementRequest>,
    /// Our answer to that request; none yet where it waits for this station's standstill.
    pub answer: Option<AgreementAnswer>,
    /// The other's answer to a request of ours: (our boot id, number, operation in the way).
    pub verdict: Option<(u64, u64, Option<OpId>)>,
}

/// All views, in the order of [`Program::peers`].
#[derive(Clone, Debug)]
pub(crate) struct PeerViews {
    pub peers: Vec<PeerView>,
    stale: Duration,
    /// The generation of this station's own counts; 0 for none.
    pub generation: u64,
    ahead_max: i32,
    /// The second barrier stands for every conflict of this station.
    covers: bool,
    pub rules: Rules,
}

/// Whether a peer's counts may be compared, with the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Comparability {
    Comparable,
    /// Not received, or too long ago.
    NotHeard,
    /// This station or the peer has no generation, or they have different ones.
    OtherGeneration,
    /// An axis of the peer is not where its chart has it.
    PositionLost,
    /// Further ahead than the arrows allow.
    TooFarAhead,
}

impl PeerViews {
    /// `operations_of[i]` is how many operations peer `i` has.
    pub(crate) fn new(program: &Program, operations_of: &[usize], stale: Duration) -> Self {
        let view = |(&station, &operations): (&StationId, &usize)| PeerView {
            station,
            boot_id: 0,
            life_since: Tick::ZERO,
            known_until: Tick::ZERO,
            generation: 0,
            position_lost: false,
            stopped: false,
            measured: 0,
            measured_until: Tick::ZERO,
            done: vec![i32::MIN; operations],
            cycle: 0,
            places: Vec::with_capacity(operations),
            recovering_home: false,
            request: None,
            answer: None,
            verdict: None,
        };
        PeerViews {
            peers: program.peers.iter().zip(operations_of).map(view).collect(),
            stale,
            generation: 0,
            ahead_max: program.ahead_max,
            covers: program.interlocks.covers,
            rules: Rules::default(),
        }
    }

    /// Takes a report that is newer than the last one of that station.
    ///
    /// A request of a peer whose counts are not of this station's generation is not answered here (see `entry`).
    ///
    /// # Errors
    /// When it is not a peer's or does not fit its description; nothing has changed.
    pub(crate) fn hear(
        &mut self,
        now: Tick,
        me: (StationId, u64),
        program: &Program,
        started: &[i32],
        from: StationId,
        report: &StationReport,
    ) -> Result<(), Ignored> {
        let index = self.peers.iter().position(|v| v.station == from).ok_or(Ignored::NotAPeer)?;
        let view = &mut self.peers[index];
        let bits = view.done.len();
        let fits = |request: &AgreementRequest| bits >= 64 || request.ops < 1 << bits;
        let named = |answer: &AgreementAnswer| answer.in_the_way.is_none_or(|op| op.index() < bits);
        if report.done.len() != bits || !report.request.as_ref().is_none_or(fits) || !report.answers.iter().all(named) {
            return Err(Ignored::Misfit);
        }
        view.known_until = now + self.stale;
        view.generation = report.generation;
        view.position_lost = report.position_lost.is_some();
        view.stopped = report.stopped;
        view.measured = report.measured;
        // The image was some time old when it was sent; the time of the message is unknown, and counts as 0.
        let left = self.stale.saturating_sub(report.measured_age);
        view.measured_until = if report.devices_valid { now + left } else { Tick::ZERO };
        view.done.copy_from_slice(&report.done);
        view.cycle = report.cycle;
        view.places.clear();
        if !program.spans.is_empty() && report.places.len() == bits {
            view.places.extend_from_slice(&report.places);
            view.recovering_home = report.recovering_home;
        }
        view.verdict = report.answers.iter().find(|a| a.to == me.0).map(|a| (a.boot_id, a.number, a.in_the_way));
        let same = view.boot_id == report.boot_id && view.request == report.request;
        if view.boot_id != report.boot_id {
            view.life_since = now;
        }
        view.boot_id = report.boot_id;
        view.request = report.request;
        if same {
            return Ok(());
        }
        self.peers[index].answer = None;
        // To agree to a withdrawal is to have compared counts.
        if let Some(request) = report.request.filter(|_| self.shares_generation(index)) {
            let in_the_way = in_the_way(program, index, &self.peers[index], request, started);
            self.answer(index, request, in_the_way);
        }
        Ok(())
    }

    /// The peers with a request that has no answer yet, though their counts belong to another generation.
    pub(crate) fn unanswered(&self) -> PeerSet {
        let waits = |peer: &usize| {
            let view = &self.peers[*peer];
            view.request.is_some() && view.answer.is_none() && !self.shares_generation(*peer)
        };
        (0..self.peers.len()).filter(waits).collect()
    }

    /// Answers the request of a peer.
    pub(crate) fn answer(&mut self, peer: usize, request: AgreementRequest, in_the_way: Option<OpId>) {
        let view = &mut self.peers[peer];
        let (to, boot_id, number) = (view.station, view.boot_id, request.number);
        view.answer = Some(AgreementAnswer { to, boot_id, number, in_the_way });
    }

    /// Whether the counts of a peer belong to this station's generation.
    pub(crate) fn shares_generation(&self, peer: usize) -> bool {
        !self.rules.generations || (self.generation != 0 && self.peers[peer].generation == self.generation)
    }

    /// Whether a report of the peer is there that is not too old.
    pub(crate) fn is_heard(&self, peer: usize, now: Tick) -> bool {
        now < self.peers[peer].known_until
    }

    /// The input image of a peer that is not too old and that its devices vouch for.
    #[inline]
    pub(crate) fn measured(&self, peer: usize, now: Tick) -> Option<u128> {
        let view = &self.peers[peer];
        (now < view.measured_until).then_some(view.measured)
    }

    /// Whether a peer reports that nothing of it is driven, and that its devices are in order. A gateway puts out what an earlier
    /// life of it sent last for as long as that is not too old.
    pub(crate) fn stands(&self, peer: usize, now: Tick) -> bool {
        let view = &self.peers[peer];
        let is_first = self.rules.timely && now < view.life_since + self.stale;
        view.stopped && !is_first && now < view.measured_until && self.is_heard(peer, now)
    }

    /// Whether a peer's counts may be compared with those of this station, which is in `cycle`.
    pub(crate) fn standing(&self, peer: usize, cycle: i32, now: Tick) -> Comparability {
        let view = &self.peers[peer];
        if now >= view.known_until {
            return Comparability::NotHeard;
        }
        if !self.rules.generations {
            return Comparability::Comparable;
        }
        if !self.shares_generation(peer) {
            Comparability::OtherGeneration
        } else if view.position_lost {
            Comparability::PositionLost
        } else if view.cycle > cycle.saturating_add(self.ahead_max) {
            Comparability::TooFarAhead
        } else {
            Comparability::Comparable
        }
    }

    /// Whether in this mode the second barrier stands in for the counts of a peer. It does in manual mode, where a person
    /// watches the motion and holds it, for a peer whose counts are of another generation: that is how a line whose memory is
    /// lost comes home. Where any conflict of this station has no measured positions it does not, and the motion is blocked: an
    /// arrow may keep apart more than the two stations that it joins.
    pub(crate) fn positions_stand_in(&self, peer: usize, mode: ControlMode, now: Tick) -> bool {
        self.rules.positions
            && mode == ControlMode::Manual
            && self.covers
            && self.is_heard(peer, now)
            && !self.shares_generation(peer)
    }

    /// The count of a peer's operation as it may be relied on: one less while it is being taken back.
    pub(crate) fn count(&self, cause: &Cause) -> i32 {
        let view = &self.peers[cause.peer as usize];
        let withdrawing = view.request.is_some_and(|request| request.ops & (1 << cause.from.0) != 0);
        view.done[cause.from.index()].saturating_sub(i32::from(withdrawing))
    }

    /// Whether one arrow holds for an operation that would start in `cycle`.
    pub(crate) fn holds(&self, cause: &Cause, mode: ControlMode, cycle: i32, now: Tick) -> bool {
        let peer = cause.peer as usize;
        if !self.rules.arrows {
            return true;
        }
        if self.positions_stand_in(peer, mode, now) {
            return true;
        }
        let enough = if self.rules.counted { cycle.saturating_sub(cause.lag) } else { self.peers[peer].cycle };
        self.standing(peer, cycle, now) == Comparability::Comparable && self.count(cause) >= enough
    }

    /// Whether all arrows observed in `mode` hold for a step that would start in `cycle`.
    #[inline]
    pub(crate) fn all_hold(&self, causes: &[Cause], mode: ControlMode, cycle: i32, now: Tick) -> bool {
        causes.iter().all(|cause| !cause.modes[mode as usize] || self.holds(cause, mode, cycle, now))
    }

    /// Whether every view is known that the arrows observed in `mode` read.
    pub(crate) fn all_known(&self, causes: &[Cause], mode: ControlMode, cycle: i32, now: Tick) -> bool {
        let known = |cause: &Cause| self.standing(cause.peer as usize, cycle, now) == Comparability::Comparable;
        !self.rules.arrows || causes.iter().all(|cause| !cause.modes[mode as usize] || known(cause))
    }

    /// Time at which the next view becomes unknown.
    pub(crate) fn deadline(&self, now: Tick) -> Tick {
        let ends = self.peers.iter().flat_map(|v| [v.known_until, v.measured_until, v.life_since + self.stale]);
        ends.filter(|&t| t > now).min().unwrap_or(Tick::NEVER)
    }
}

/// The first operation of ours that has started on a count the request would take back.
///
/// An arrow from A with lag k let B start in cycle c because done(A) ≥ c − k. Taking done(A) back from n to n − 1
/// contradicts exactly those starts with c ≥ n + k.
fn in_the_way(
    program: &Program,
    peer: usize,
    view: &PeerView,
    request: AgreementRequest,
    started: &[i32],
) -> Option<OpId> {
    let asked = |cause: &&Cause| cause.peer as usize == peer && request.ops & (1 << cause.from.0) != 0;
    let in_the_way = |cause: &&Cause| {
        let n = view.done[cause.from.index()];
        started[cause.to.index()] >= n.saturating_add(cause.lag)
    };
    program.causes.iter().flatten().filter(asked).find(in_the_way).map(|cause| cause.to)
}
