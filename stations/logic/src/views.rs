//! What this station knows of the others, and what it may conclude.
//!
//! A view is the newest report of another station, with an age. A view that is too old is *unknown*, and unknown
//! blocks every condition that reads it, negated or not. In normal operation counts only grow, so a late view can
//! delay a start but never allow a wrong one. The dangerous direction is a count going back; two rules meet it here:
//!
//! * While a view shows an open request to take back the count of an operation, that count is read as already taken
//!   back. So nothing new is started on it — whether or not this station has agreed, and whatever a restart made it
//!   forget.
//! * A request is agreed to only if every operation of ours that builds on the count has not started in that cycle,
//!   or has been undone. The answer is worked out once for each request number and then stands.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId, Tick};

use crate::program::{Cause, Program};
use crate::report::{Answer, Report, Request};

/// The newest that was heard of one other station.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub station: StationId,
    pub boot_id: u64,
    /// Unknown from then on.
    pub known_until: Tick,
    pub done: Vec<i32>,
    pub cycle: i32,
    pub request: Option<Request>,
    /// Our answer to that request.
    pub answer: Option<Answer>,
    /// The other's answer to a request of ours: (our boot id, number, operation in the way).
    pub verdict: Option<(u64, u64, Option<OpId>)>,
}

/// All views, in the order of [`Program::peers`].
#[derive(Clone, Debug)]
pub(crate) struct Views {
    pub peers: Vec<View>,
    stale: Duration,
    /// See [`crate::Rules::counted`].
    pub counted: bool,
}

impl Views {
    /// `operations_of[i]` is how many operations peer `i` has.
    pub(crate) fn new(program: &Program, operations_of: &[usize], stale: Duration) -> Self {
        let view = |(&station, &operations): (&StationId, &usize)| View {
            station,
            boot_id: 0,
            known_until: Tick::ZERO,
            done: vec![i32::MIN; operations],
            cycle: 0,
            request: None,
            answer: None,
            verdict: None,
        };
        Views { peers: program.peers.iter().zip(operations_of).map(view).collect(), stale, counted: true }
    }

    /// Takes a report that is newer than the last one of that station. Gives false, and changes nothing, if it is not
    /// a peer's or does not fit its description.
    pub(crate) fn hear(
        &mut self,
        now: Tick,
        me: (StationId, u64),
        program: &Program,
        started: &[i32],
        from: StationId,
        report: &Report,
    ) -> bool {
        let Some(index) = self.peers.iter().position(|v| v.station == from) else { return false };
        let view = &mut self.peers[index];
        let bits = view.done.len();
        let fits = |request: &Request| bits >= 64 || request.ops < 1 << bits;
        let named = |answer: &Answer| answer.in_the_way.is_none_or(|op| op.index() < bits);
        if report.done.len() != bits || !report.request.as_ref().is_none_or(fits) || !report.answers.iter().all(named) {
            return false;
        }
        view.known_until = now + self.stale;
        view.done.copy_from_slice(&report.done);
        view.cycle = report.cycle;
        view.verdict = report.answers.iter().find(|a| a.to == me.0).map(|a| (a.boot_id, a.number, a.in_the_way));
        let same = view.boot_id == report.boot_id && view.request == report.request;
        view.boot_id = report.boot_id;
        view.request = report.request;
        if !same {
            let answer = report.request.map(|request| Answer {
                to: from,
                boot_id: report.boot_id,
                number: request.number,
                in_the_way: in_the_way(program, index, &self.peers[index], request, started),
            });
            self.peers[index].answer = answer;
        }
        true
    }

    pub(crate) fn is_known(&self, peer: usize, now: Tick) -> bool {
        now < self.peers[peer].known_until
    }

    /// The count of a peer's operation as it may be relied on: one less while it is being taken back.
    pub(crate) fn count(&self, cause: &Cause) -> i32 {
        let view = &self.peers[cause.peer as usize];
        let withdrawing = view.request.is_some_and(|request| request.ops & (1 << cause.from.0) != 0);
        view.done[cause.from.index()].saturating_sub(i32::from(withdrawing))
    }

    /// Whether one arrow holds for an operation that would start in `cycle`.
    pub(crate) fn holds(&self, cause: &Cause, cycle: i32, now: Tick) -> bool {
        let peer = cause.peer as usize;
        let enough = if self.counted { cycle.saturating_sub(cause.lag) } else { self.peers[peer].cycle };
        self.is_known(peer, now) && self.count(cause) >= enough
    }

    /// Whether all arrows observed in `mode` hold for a step that would start in `cycle`.
    #[inline]
    pub(crate) fn all_hold(&self, causes: &[Cause], mode: ControlMode, cycle: i32, now: Tick) -> bool {
        causes.iter().all(|cause| !cause.modes[mode as usize] || self.holds(cause, cycle, now))
    }

    /// Whether every view is known that the arrows observed in `mode` read.
    pub(crate) fn all_known(&self, causes: &[Cause], mode: ControlMode, now: Tick) -> bool {
        causes.iter().all(|cause| !cause.modes[mode as usize] || self.is_known(cause.peer as usize, now))
    }

    /// When the next view becomes unknown.
    pub(crate) fn deadline(&self, now: Tick) -> Tick {
        self.peers.iter().map(|v| v.known_until).filter(|&t| t > now).min().unwrap_or(Tick::NEVER)
    }
}

/// The first operation of ours that has started on a count the request would take back.
///
/// An arrow from A with lag k let B start in cycle c because done(A) ≥ c − k. Taking done(A) back from n to n − 1
/// contradicts exactly those starts with c ≥ n + k.
fn in_the_way(program: &Program, peer: usize, view: &View, request: Request, started: &[i32]) -> Option<OpId> {
    let asked = |cause: &&Cause| cause.peer as usize == peer && request.ops & (1 << cause.from.0) != 0;
    let in_the_way = |cause: &&Cause| {
        let n = view.done[cause.from.index()];
        started[cause.to.index()] >= n.saturating_add(cause.lag)
    };
    program.causes.iter().flatten().filter(asked).find(in_the_way).map(|cause| cause.to)
}
