//! Everything that decides a controller's future, as a list of numbers: by this a checker recognises a state.
//!
//! Counts are relative to an origin the caller chooses; of a request's number only matters whether it is the one its writer has
//! open, and of a life whether it is the present one. They grow for ever while the situation repeats. Moments in time are left
//! out: a checker keeps the clock still, and lets things expire by input to the controller.

use linewright_line::net::MotionStage;
use linewright_line::{OpId, StationId};

use crate::controller::Controller;
use crate::program::bit;
use crate::report::{AgreementAnswer, AgreementRequest};

/// Origin of a situation, for one writer of requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestWriter {
    /// Its present life.
    pub boot_id: u64,
    /// The number of its open request.
    pub open: Option<u64>,
}

/// A controller's view of one other station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeerSituation<'a> {
    /// The cycle in which each operation was last completed.
    pub done: &'a [i32],
    /// The generation of its counts; 0 for none.
    pub generation: u64,
    pub cycle: i32,
    /// The request it has made.
    pub request: Option<AgreementRequest>,
    /// Our answer to that request.
    pub answer: Option<AgreementAnswer>,
    /// Its answer to a request of ours: its number, and the operation in the way.
    pub verdict: Option<(u64, Option<OpId>)>,
}

impl Controller {
    /// View of another station; `None` if it does not read that one.
    pub fn held(&self, station: StationId) -> Option<PeerSituation<'_>> {
        let view = self.views.peers.iter().find(|view| view.station == station)?;
        Some(PeerSituation {
            done: &view.done,
            generation: view.generation,
            cycle: view.cycle,
            request: view.request,
            answer: view.answer,
            verdict: view.verdict.map(|(_, number, in_the_way)| (number, in_the_way)),
        })
    }

    /// Its count of completions of one operation.
    pub fn done(&self, op: OpId) -> i32 {
        self.counts.done[op.index()]
    }

    /// The request it has open.
    pub fn request(&self) -> Option<AgreementRequest> {
        self.agreement.pending.map(|pending| pending.request)
    }

    /// This controller as a writer of requests.
    pub fn writer(&self) -> RequestWriter {
        RequestWriter { boot_id: self.boot_id, open: self.agreement.pending.map(|p| p.request.number) }
    }

    /// Whether an answer to this number can still mean anything to this station.
    pub fn awaits(&self, number: u64) -> bool {
        !self.rules.fresh_numbers || self.agreement.pending.is_some_and(|p| p.request.number == number)
    }

    /// Appends the situation to `out`. Two controllers of one station whose situations are equal do the same from then
    /// on, given the same inputs at times at which nothing expires.
    pub fn situation(&self, origin: i32, writers: impl Fn(StationId) -> RequestWriter, out: &mut Vec<i64>) {
        for token in self.tokens() {
            let place = &self.program.places[token.place as usize];
            let moves = place.place.is_operating();
            let flags = match place.place.stage {
                MotionStage::Operating => [token.left_start, token.driven, token.awaits_image],
                // Only whether its switch counts when it goes on; the cause of the stop is left out where nothing sticks.
                MotionStage::Incomplete => [token.left_start || token.awaits_image, false, false],
                MotionStage::Completed => [false; 3],
            };
            let run = if moves { token.run as i64 } else { 0 };
            out.extend([i64::from(token.place), run, i64::from(flags[0]), i64::from(flags[1]), i64::from(flags[2])]);
            if place.turns != 0 {
                out.push(token.progress as i64);
            }
        }
        let relative = |count: i32| i64::from(count) - i64::from(origin);
        let cycle = self.orders.as_ref().map_or_else(|| relative(self.counts.cycle), |_| 0);
        out.extend([-1, cycle, self.marking.path.map_or(-1, |op| i64::from(op.0))]);
        match &self.orders {
            None => out.extend(self.counts.done.iter().chain(&self.counts.started).map(|&count| relative(count))),
            // Its counts are not compared, and each goes its own way for ever.
            Some(orders) => {
                out.extend(
                    self.counts
                        .done
                        .iter()
                        .zip(&self.counts.started)
                        .map(|(&done, &started)| i64::from(started - done)),
                );
                orders.situation(out);
            }
        }
        let word = |bits: u128| [(bits >> 64) as i64, bits as i64];
        for bits in [self.levels.now, self.levels.before, self.image.bits] {
            out.extend(word(bits));
        }
        out.extend([i64::from(self.image.valid), self.levels.mode as i64, i64::from(self.marking.unconfirmed)]);
        out.push(i64::from(self.marking.placed) | i64::from(self.marking.doubtful.is_some()) << 1);
        out.extend(self.program.places_of_axis.as_ref().map(|_| i64::from(self.marking.axis_place)));
        out.extend(self.program.places_of_axis.as_ref().map(|_| i64::from(self.homing.is_driven)));
        out.push(i64::from(self.views.generation != 0));
        self.commands.situation(self.now, out);
        out.extend((self.levels.now & bit::RESUME != 0).then_some(self.resumed as i64));
        match &self.agreement.pending {
            None => out.push(-1),
            Some(pending) => {
                out.extend([pending.request.ops as i64, pending.mode as i64]);
                for peers in [pending.needs, pending.entered] {
                    out.extend(peers.words(self.views.peers.len()).map(|word| word as i64));
                }
                out.extend(word(pending.hold));
                out.extend(pending.rows().iter().map(|&row| i64::from(row)));
            }
        }
        for (peer, view) in self.views.peers.iter().enumerate() {
            let writer = writers(view.station);
            out.extend([
                i64::from(self.views.is_heard(peer, self.now)),
                i64::from(writer.boot_id == view.boot_id),
                if self.rules.counted { 0 } else { relative(view.cycle) },
            ]);
            if self.rules.generations {
                let same = view.generation == self.views.generation;
                out.extend([same, view.position_lost].map(i64::from));
            }
            if self.rules.positions {
                out.extend([self.now < view.measured_until, view.stopped].map(i64::from));
                out.extend(word(view.measured & self.program.interlocks.read_of(peer)));
            }
            if self.program.places_of_axis.is_some() {
                out.extend(view.places.iter().map(|&number| i64::from(number)));
                out.push(i64::from(view.recovering_home));
            }
            let read = self.program.causes.iter().flatten().filter(|c| usize::from(c.peer) == peer);
            out.extend(read.map(|cause| relative(view.done[cause.from.index()])));
            match view.request {
                None => out.push(-1),
                // An answer to a request that is no longer open has no value; that it was made still blocks.
                Some(request) if writer.open != Some(request.number) => out.extend([-2, request.ops as i64]),
                Some(request) => {
                    let in_the_way = view.answer.and_then(|a| a.in_the_way);
                    out.extend([in_the_way.map_or(0, |op| 1 + i64::from(op.0)), request.ops as i64]);
                }
            }
            match view.verdict.filter(|&(boot, number, _)| boot == self.boot_id && self.awaits(number)) {
                None => out.push(-1),
                Some((_, _, in_the_way)) => out.push(in_the_way.map_or(0, |op| 1 + i64::from(op.0))),
            }
        }
    }
}
