//! A transfer of a shipped cell is stopped at many moments: both stations are led to the same end of it.

use std::time::Duration;

use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::{Line, OpId, StationId, TaskId};
use linewright_proof::generate::Random;
use linewright_recovery::{
    ActivityEnd, DecidedEnd, EndsReached, LineSituation, RecoveryAction, RecoveryEnd, StandingAlarm, plan,
};
use linewright_simulation::{LineSim, OperatorAction};

use crate::cells::shipped;
use crate::operator::{command, described, follow, run_for, situation, switched_on};

const SEEDS: u64 = 24;

/// The orders of an activity: station and task of each.
type Orders = [(&'static str, &'static str); 2];

const TRANSFERS: [(usize, Orders); 4] = [
    (0, [("robot", "load m1"), ("m1", "clamp")]),
    (0, [("robot", "load m2"), ("m2", "clamp")]),
    (0, [("robot", "load m3"), ("m3", "clamp")]),
    (1, [("robot_1", "load robot_2"), ("robot_2", "receive")]),
];

struct Transfer {
    sim: LineSim,
    tasks: [(StationId, TaskId); 2],
    before: [i32; 2],
}

impl Transfer {
    /// Done by hand, one station sooner than the other, and stopped at some moment.
    fn stopped(line: &Line, orders: &Orders, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let tasks = orders.map(|(station, task)| {
            let id = line.station_named(station).expect("it is one");
            (id, line.station(id).task_named(task).expect("it is one"))
        });
        let mut sim = switched_on(line, seed);
        for &(id, task) in &tasks {
            let station = line.station(id);
            let steps = station.steps[station.task(task).steps.clone()].iter().flatten();
            let waits: Vec<_> = steps.flat_map(|&op| station.awaited_by(op)).collect();
            for input in waits {
                sim.act(OperatorAction::Force(Some(id), input, Some(true))).expect("it is done");
            }
        }
        command(&mut sim, ModeCommand::Start);
        command(&mut sim, ModeCommand::Hand);
        let buttons: [u32; 2] = tasks.map(|(id, task)| {
            let station = line.station(id);
            1 << station.operations[station.first_of(task).index()].hand.forward().0
        });
        let mut transfer = Transfer { sim, tasks, before: [0; 2] };
        transfer.before = transfer.done();
        let first = random.below(2);
        let part = |random: &mut Random| Duration::from_millis(100 * random.below(40) as u64);
        for held in [buttons[first], buttons[0] | buttons[1]] {
            transfer.sim.act(OperatorAction::Buttons(held)).expect("it is done");
            let long = part(&mut random);
            run_for(&mut transfer.sim, long);
        }
        transfer.sim.act(OperatorAction::Command(ModeCommand::EStop)).expect("it is done");
        run_for(&mut transfer.sim, Duration::from_secs(1));
        transfer
    }

    fn last(&self, (id, task): (StationId, TaskId)) -> OpId {
        self.sim.line().station(id).last_of(task)
    }

    fn done(&self) -> [i32; 2] {
        let done = |of: (StationId, TaskId)| {
            let report = self.sim.controller(of.0).expect("it is up").report();
            report.done[self.last(of).index()]
        };
        self.tasks.map(done)
    }

    fn ends(&self) -> [ActivityEnd; 2] {
        let done = self.done();
        [0, 1].map(|at| if done[at] > self.before[at] { ActivityEnd::Done } else { ActivityEnd::TakenBack })
    }

    fn held(&self) -> Vec<StationId> {
        let is_held = |id: &StationId| {
            let report = self.sim.controller(*id).expect("it is up").report();
            !report.at_home || !report.incomplete.is_empty()
        };
        self.tasks.iter().map(|(id, _)| *id).filter(is_held).collect()
    }

    /// The situation with the alarm of its activity.
    fn seen(&self, end: Option<&DecidedEnd>) -> LineSituation {
        let mut seen = situation(&self.sim);
        seen.left_out = self.tasks.map(|(id, _)| id).to_vec();
        seen.alarms = vec![StandingAlarm {
            id: 1,
            text: "it failed.".to_owned(),
            answers: ["as-before", "as-done"].map(ListedAnswer::from).to_vec(),
            lead: self.held(),
            reset: Vec::new(),
            at_order: Vec::new(),
            end: end.cloned(),
            bring: None,
        }];
        seen
    }

    /// Follows plans until both stand at rests.
    fn lead(&mut self, end: Option<&DecidedEnd>) {
        let mut reached = EndsReached::default();
        for _ in 0..40 {
            if self.held().is_empty() {
                return;
            }
            let mut seen = self.seen(end);
            reached.complete(self.sim.line(), &mut seen);
            let found = plan(self.sim.line(), &seen);
            assert_eq!(found.end, RecoveryEnd::Auto, "{}", described(&self.sim));
            follow(&mut self.sim, &found.steps[0]);
        }
        panic!("it does not end: {}", described(&self.sim));
    }
}

/// Each with the seed.
fn transfers() -> impl Iterator<Item = Transfer> {
    let lines = shipped().map(|(_, line)| line);
    TRANSFERS.iter().flat_map(move |(cell, orders)| {
        let line = lines[*cell].clone();
        (0..SEEDS).map(move |seed| Transfer::stopped(&line, orders, seed))
    })
}

#[test]
fn both_stations_of_a_transfer_are_led_to_the_same_end() {
    let (mut both, mut apart, mut ends) = (0, 0, [0, 0]);
    for mut transfer in transfers().filter(|transfer| transfer.held().len() == 2) {
        both += 1;
        // Each by itself they would part.
        let mut each = transfer.seen(None);
        let of_one =
            |at: usize| StandingAlarm { id: at as u64, lead: vec![transfer.tasks[at].0], ..each.alarms[0].clone() };
        each.alarms = vec![of_one(0), of_one(1)];
        let free = plan(transfer.sim.line(), &each);
        apart += usize::from(free.led[0].end != free.led[1].end);
        let shown = plan(transfer.sim.line(), &transfer.seen(None));
        transfer.lead(None);
        let reached = transfer.ends();
        assert_eq!(reached[0], reached[1], "{}", described(&transfer.sim));
        assert_eq!(shown.led[0].end, Some(reached[0]), "as it was shown");
        ends[usize::from(reached[0] == ActivityEnd::Done)] += 1;
    }
    assert!(both > 20 && apart > 3 && ends[0] > 3 && ends[1] > 3, "{both} {apart} {ends:?}");
}

#[test]
fn what_is_decided_is_led_to_also_where_it_is_longer() {
    for end in [ActivityEnd::Done, ActivityEnd::TakenBack] {
        let decided = DecidedEnd { end, because: "m1 has completed its order".to_owned() };
        let mut longer = 0;
        for mut transfer in transfers().filter(|transfer| !transfer.held().is_empty()).step_by(3) {
            let held = transfer.held();
            let shortest = plan(transfer.sim.line(), &transfer.seen(None));
            let found = plan(transfer.sim.line(), &transfer.seen(Some(&decided)));
            assert!(found.presses() >= shortest.presses());
            longer += usize::from(shortest.led[0].end != Some(end));
            assert_eq!(found.led[0].end, Some(end), "{}", described(&transfer.sim));
            let text = found.led[0].text(transfer.sim.line());
            assert!(text.contains("since m1 has completed its order. "), "{text}");
            transfer.lead(Some(&decided));
            let ends = transfer.ends();
            let is_led = |at: &usize| held.contains(&transfer.tasks[*at].0);
            assert!((0..2).filter(is_led).all(|at| ends[at] == end), "{}", described(&transfer.sim));
        }
        assert!(longer > 3, "{end:?}: {longer}");
    }
}

/// A person goes another way with the first station than the list has it: the other one follows.
#[test]
fn the_second_station_follows_the_first() {
    let mut parted = 0;
    for mut transfer in transfers().filter(|transfer| transfer.held().len() == 2) {
        let shown = plan(transfer.sim.line(), &transfer.seen(None)).led[0].end;
        let mut reached = EndsReached::default();
        reached.complete(&transfer.sim.line().clone(), &mut transfer.seen(None));
        let other = match shown {
            Some(ActivityEnd::Done) => ActivityEnd::TakenBack,
            _ => ActivityEnd::Done,
        };
        let (first, line) = (transfer.tasks[0].0, transfer.sim.line().clone());
        let decided = DecidedEnd { end: other, because: String::new() };
        for _ in 0..40 {
            let mut seen = transfer.seen(Some(&decided));
            seen.alarms[0].lead.retain(|id| *id == first);
            if seen.alarms[0].lead.is_empty() {
                break;
            }
            let steps = plan(&line, &seen).steps;
            let is_its = |action: &RecoveryAction| {
                matches!(action, RecoveryAction::Command(_)) || action.station() == Some(first)
            };
            let Some(step) = steps.iter().find(|step| is_its(&step.action)) else { break };
            follow(&mut transfer.sim, step);
        }
        let mut seen = transfer.seen(None);
        if seen.alarms[0].lead.len() != 1 {
            continue;
        }
        parted += 1;
        reached.complete(&line, &mut seen);
        let now = plan(&line, &seen);
        assert_eq!(now.led[0].end, Some(transfer.ends()[0]), "{}", described(&transfer.sim));
    }
    assert!(parted > 5, "{parted}");
}
