//! One replication: the cell plays, with external events in between.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_cell::ResourceId;
use linewright_coordinator_cell::compile::{dispatcher, schedule_follower};
use linewright_coordinator_cell::production::{DispatchConfiguration, ProductionOrderRequest, RequestProblem};
use linewright_coordinator_cell::{
    Dispatcher, PlayerInput, ProductionCommand, ProductionCommandError, ResourceId as PlayedResource,
};
use linewright_line::Tick;

use super::super::sim::{CellSim, CellSimOptions, StationSpeed};
use super::super::task_times::TaskTimes;
use super::course::{Course, CourseEvent};
use super::{CellStudy, NO_LIMIT, PlayedReplication, Standstill, StudyProblem, UNCHANGED};
use crate::rng::Rng;

/// Where no activity has begun or ended for so long, and no station works, none will: described times are a day at most.
const QUIET: Duration = Duration::from_secs(2 * 86_400);

impl CellStudy {
    /// Plays a replication.
    pub fn play(&self, replication: usize) -> PlayedReplication {
        let seed = self.seed_of(replication);
        let options = CellSimOptions {
            seed,
            pace: StationSpeed::Nominal { spread: self.options.spread },
            delay: self.options.delay,
            period: UNCHANGED,
            ..CellSimOptions::default()
        };
        let mut sim = CellSim::new(self.table.clone(), self.stations, options);
        sim.times = self.times(seed);
        let mut plan = self.options.planned.then(|| schedule_follower(&self.cell, &self.played, sim.state()));
        let rules = dispatcher(&self.cell, &self.table);
        let mut by_rules = DispatchConfiguration::new(rules, sim.state().production().clone());
        let course = Course::new(&self.cell, &self.scenario, seed);
        let dispatcher: &mut dyn Dispatcher = match &mut plan {
            Some(plan) => plan,
            None => &mut by_rules,
        };
        let mut run = StudyRun {
            sim,
            dispatcher,
            course,
            since: BTreeMap::new(),
            stood: Vec::new(),
            progressed: Tick::ZERO,
            seen: 0,
        };
        let ended = run.run(&self.scenario.orders, self.scenario.duration.map(|duration| Tick::ZERO + duration));
        let StudyRun { sim, since, mut stood, .. } = run;
        let (end, problem) = match ended {
            Ok(end) => (end, None),
            Err(problem) => (sim.now, Some(problem)),
        };
        stood.extend(since.into_iter().map(|(resource, from)| Standstill { resource, from, to: end.max(from) }));
        PlayedReplication { sim, plan, stood, end, problem }
    }

    /// A stream for each activity whose time is drawn.
    fn times(&self, seed: u64) -> TaskTimes {
        let stream = |(id, distribution): &(linewright_cell::ActivityId, _)| {
            (*distribution, Rng::named(seed, &format!("time/{}", self.cell.activity(*id).name)))
        };
        let of_mode = self.played.long.net().transitions().map(|t| {
            let (activity, _) = self.played.net.move_of(&self.cell, self.played.long.mode(t))?;
            self.scenario.times.iter().position(|(id, _)| self.cell.activity(*id).name == activity.name)
        });
        TaskTimes::new(of_mode.collect(), self.scenario.times.iter().map(stream).collect())
    }
}

struct StudyRun<'a> {
    sim: CellSim,
    dispatcher: &'a mut dyn Dispatcher,
    course: Course,
    /// Time since which resources stand that do.
    since: BTreeMap<ResourceId, Tick>,
    stood: Vec<Standstill>,
    /// Time of the last start or end of an activity, or of work at a station, as far as records have been seen.
    progressed: Tick,
    seen: usize,
}

impl StudyRun<'_> {
    /// Runs until the end, or until all orders are done. Returns that time.
    fn run(&mut self, orders: &[ProductionOrderRequest], end: Option<Tick>) -> Result<Tick, StudyProblem> {
        if !orders.is_empty() {
            self.submit(orders)?;
        }
        loop {
            let next = self.course.next().filter(|next| end.is_none_or(|end| *next <= end)).or(end);
            match next {
                Some(next) => self.sim.run_on(self.dispatcher, next),
                None => self.run_out(),
            }
            if let Some(mode) = self.sim.spins() {
                let activity = self.sim.table.mode_name(mode).to_owned();
                return Err(StudyProblem::Spins { activity, at_s: self.sim.now.as_secs_f64() });
            }
            if end.is_none() && self.is_done() {
                let ends = self.sim.state().production().orders().filter_map(|order| order.ended);
                return Ok(ends.max().unwrap_or(self.sim.now));
            }
            let Some(next) = next else { return Err(self.stuck()) };
            if end.is_none() && self.is_stuck() {
                return Err(self.stuck());
            }
            self.sim.now = self.sim.now.max(next);
            if end.is_some_and(|end| next >= end) {
                return Ok(next);
            }
            self.outside(next)?;
        }
    }

    /// External events of this moment.
    fn outside(&mut self, now: Tick) -> Result<(), StudyProblem> {
        loop {
            let (table, stations) = (&self.sim.table, &mut self.sim.stations);
            let worked = |resource: ResourceId| {
                let station = table.handling().resources.get(resource.index()).and_then(|of| of.station);
                let station = station.and_then(|id| stations.get_mut(id.index()));
                station.map_or(Duration::ZERO, |station| station.worked(now))
            };
            match self.course.take(now, worked) {
                None => return Ok(()),
                Some(CourseEvent::Order(order)) => self.submit(&[order])?,
                Some(CourseEvent::Resource(resource)) => self.change(resource, now),
            }
        }
    }

    fn submit(&mut self, orders: &[ProductionOrderRequest]) -> Result<(), StudyProblem> {
        self.sim.say(self.dispatcher, &[PlayerInput::Production(0, ProductionCommand::Submit(orders))]);
        let at_s = self.sim.now.as_secs_f64();
        match self.sim.told.pop() {
            Some(Ok(_)) => Ok(()),
            Some(Err(ProductionCommandError::Request(problems))) => {
                let too_many = problems.iter().find_map(|problem| match problem {
                    RequestProblem::TooMany { open } => Some(*open),
                    _ => None,
                });
                let why = || problems.iter().map(|problem| problem.to_string()).collect::<Vec<_>>().join(", ");
                Err(match too_many {
                    Some(open) => StudyProblem::TooManyOrders { open, at_s },
                    None => StudyProblem::Refused { why: why(), at_s },
                })
            }
            other => Err(StudyProblem::Refused { why: format!("{other:?}"), at_s }),
        }
    }

    /// A resource may have broken down, or be repaired.
    fn change(&mut self, resource: ResourceId, now: Tick) {
        let station = self.sim.table.handling().resources.get(resource.index()).and_then(|of| of.station);
        let Some(station) = station.and_then(|id| self.sim.stations.get_mut(id.index())) else { return };
        let stands = self.course.stands(resource);
        if stands {
            station.stand(now);
            self.since.entry(resource).or_insert(now);
        } else if let Some(from) = self.since.remove(&resource) {
            station.go_on(now);
            self.stood.push(Standstill { resource, from, to: now });
        }
        // As an operator's request: it finishes its work after the repair, and gets no other order.
        let played = PlayedResource(u32::try_from(resource.index()).unwrap_or(u32::MAX));
        let is_out = self.sim.state().exceptions().is_down(played).is_some();
        let out = self.course.is_left_out(resource);
        if out != is_out {
            self.sim.say(self.dispatcher, &[PlayerInput::Resource { resource: played, up: !out }]);
        }
    }

    fn is_done(&self) -> bool {
        let state = self.sim.state();
        self.course.is_over() && state.production().missing().next().is_none() && state.parts().len() == 0
    }

    /// Runs until nothing happens any more; the end condition is checked again and again.
    fn run_out(&mut self) {
        self.sim.run_on(self.dispatcher, self.sim.now);
        while let Some(at) = self.sim.next_event().filter(|_| self.sim.spins().is_none()) {
            // Only the limit of an order that does not end is so far away.
            if at.since(self.sim.now) > NO_LIMIT / 2 {
                return;
            }
            self.sim.run_on(self.dispatcher, at);
            if self.is_done() || self.is_stuck() {
                return;
            }
        }
    }

    /// Whether nothing will happen but failures, and repairs of what stands idle: they make nothing possible. No activity by
    /// the clock alone takes as long.
    fn is_stuck(&mut self) -> bool {
        let sim = &self.sim;
        if sim.is_working() || sim.log[self.seen..].iter().any(|record| record.fact.activity_step().is_some()) {
            self.progressed = sim.now;
        }
        self.seen = sim.log.len();
        self.course.is_over() && !self.course.repairs() && sim.now.since(self.progressed) > QUIET
    }

    fn stuck(&self) -> StudyProblem {
        let state = self.sim.state();
        StudyProblem::Stuck { left: state.left(), inside: state.parts().len(), at_s: self.progressed.as_secs_f64() }
    }
}
