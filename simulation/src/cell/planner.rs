//! A planner beside the decisions, in virtual time: it takes as long as it is told to, or never answers.

use std::time::Duration;

use linewright_coordinator_cell::schedule::{RevisionReason, Schedule, ScheduleFollower, Scheduler};
use linewright_line::Tick;

use super::sim::CellSim;

/// A follower of schedules, and the planner beside it.
pub struct SimulatedPlanner {
    pub follower: ScheduleFollower,
    /// Time of each request's copy, and its reason.
    pub asked: Vec<(Tick, RevisionReason)>,
    scheduler: Box<dyn Scheduler + Send>,
    /// Time that a request takes, by its number; none if it is never answered.
    takes: Box<dyn FnMut(u64) -> Option<Duration>>,
    under_way: Option<(Tick, u64, Schedule)>,
}

impl SimulatedPlanner {
    /// The follower is one that is planned for beside its decisions.
    pub fn new(
        follower: ScheduleFollower,
        scheduler: Box<dyn Scheduler + Send>,
        takes: impl FnMut(u64) -> Option<Duration> + 'static,
    ) -> Self {
        SimulatedPlanner { follower, asked: Vec::new(), scheduler, takes: Box::new(takes), under_way: None }
    }

    /// Goes on until nothing happens any more, at most until a time; see [`CellSim::run`].
    pub fn run(&mut self, sim: &mut CellSim, until: Tick) {
        sim.coordination.reconsider();
        while !sim.is_over() || self.under_way.is_some() {
            let next = sim.next_moment();
            if let Some((at, number, schedule)) = self.under_way.take_if(|(at, ..)| *at <= next.min(until)) {
                sim.now = sim.now.max(at);
                if self.follower.take_schedule(sim.now, number, schedule) {
                    sim.coordination.reconsider();
                }
                sim.say(&mut self.follower, &[]);
            } else if !sim.goes_on(&mut self.follower, until) {
                return;
            }
            self.ask(sim);
        }
    }

    /// Takes the request that is due after a step; the caller does after steps of its own.
    pub fn ask(&mut self, sim: &CellSim) {
        let Some(request) = self.follower.take_request(sim.now, sim.state()) else { return };
        self.asked.push((sim.now, request.reason()));
        let takes = (self.takes)(request.number());
        self.under_way = takes.map(|takes| (sim.now + takes, request.number(), request.plan(&mut *self.scheduler)));
    }
}
