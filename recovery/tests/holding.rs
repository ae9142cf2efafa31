//! The transfers of the shipped cells, stopped at every moment: along each list the part is held by the hand or by the clamp.

use std::collections::BTreeSet;

use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{AxisId, Grip, HolderId, InputId, Line, Sensor, Sign, Stand, StationId, TaskId, Tick};
use linewright_recovery::{
    ActivityEnd, DecidedEnd, LedOrder, LineSituation, RecoveryPlan, RecoveryStep, StandingAlarm, plan,
};
use linewright_station_logic::{
    Controller, NO_DELAY, Restore, StationInput, StationOutbox, StationReport, StationSnapshot,
};

use crate::cells::shipped;

/// The orders of an activity: station and task of each.
type Orders = [(&'static str, &'static str); 2];

const TRANSFERS: [(usize, Orders); 4] = [
    (0, [("robot", "load m1"), ("m1", "clamp")]),
    (0, [("robot", "unload m1"), ("m1", "release")]),
    (1, [("robot_1", "load robot_2"), ("robot_2", "receive")]),
    (1, [("robot_1", "unload robot_2"), ("robot_2", "give")]),
];

/// How many operations of its task each station has done, and whether the next one is under way.
type Moment = [(usize, bool); 2];

struct Transfer<'l> {
    line: &'l Line,
    tasks: [(StationId, TaskId); 2],
}

/// Positions of all axes; not a number between two ends.
#[derive(Clone)]
struct Positions(Vec<Vec<f64>>);

impl Positions {
    fn of(&self, station: StationId, axis: AxisId) -> f64 {
        self.0[station.index()][axis.index()]
    }

    fn holds(&self, stand: &Stand) -> bool {
        (self.of(stand.station, stand.axis) - stand.at).abs() < 1e-6
    }
}

impl<'l> Transfer<'l> {
    fn of(line: &'l Line, orders: Orders) -> Self {
        let tasks = orders.map(|(station, task)| {
            let id = line.station_named(station).expect("it is one");
            (id, line.station(id).task_named(task).expect("it is one"))
        });
        Transfer { line, tasks }
    }

    fn steps(&self, at: usize) -> usize {
        let (id, task) = self.tasks[at];
        self.line.station(id).task(task).steps.len()
    }

    fn op(&self, at: usize, done: usize) -> linewright_line::OpId {
        let (id, task) = self.tasks[at];
        let station = self.line.station(id);
        station.steps[station.task(task).steps.start + done][0]
    }

    fn positions(&self, moment: Moment) -> Positions {
        let homes = self.line.stations.iter().map(|station| station.axes.iter().map(|axis| axis.home).collect());
        let mut all = Positions(homes.collect());
        for (at, (done, moves)) in moment.into_iter().enumerate() {
            let (id, task) = self.tasks[at];
            let station = self.line.station(id);
            all.0[id.index()] = station.positions_before_steps()[station.task(task).steps.start].clone();
            for op in 0..done + usize::from(moves) {
                let motion = station.operations[self.op(at, op).index()].motion;
                all.0[id.index()][motion.axis.index()] = if op < done { motion.to } else { f64::NAN };
            }
        }
        all
    }

    fn sees(&self, positions: &Positions, sign: &Sign) -> bool {
        match sign {
            Sign::Stands(stand) => positions.holds(stand),
            Sign::Part(holder) => match &self.line.handling.holder(*holder).grip {
                Grip::Hand(stand) | Grip::Clamp(stand) => positions.holds(stand),
                Grip::Loose => true,
            },
        }
    }

    /// The inputs of a station that see other stations, and parts.
    fn seen(&self, positions: &Positions, id: StationId) -> u128 {
        let sensors = self.line.handling.sensors.iter().filter(|sensor| sensor.station == id);
        let on = sensors.filter(|sensor| sensor.when.iter().all(|sign| self.sees(positions, sign)));
        on.fold(0, |bits, sensor| bits | sensor.input.bit())
    }

    /// Every moment that both can come to, each waiting for its inputs.
    fn moments(&self) -> Vec<Moment> {
        let mut known = BTreeSet::from([[(0, false); 2]]);
        let mut open: Vec<Moment> = known.iter().copied().collect();
        while let Some(moment) = open.pop() {
            for at in 0..2 {
                let (done, moves) = moment[at];
                let mut next = moment;
                if moves {
                    next[at] = (done + 1, false);
                } else if done < self.steps(at) {
                    let (id, _) = self.tasks[at];
                    let mut awaited = self.line.station(id).awaited_by(self.op(at, done));
                    let on = self.seen(&self.positions(moment), id);
                    if awaited.any(|input| on & input.bit() == 0) {
                        continue;
                    }
                    next[at] = (done, true);
                }
                if known.insert(next) {
                    open.push(next);
                }
            }
        }
        assert!(known.contains(&[0, 1].map(|at| (self.steps(at), false))), "it comes to its end");
        known.into_iter().collect()
    }

    /// The report of a station in the activity.
    fn report(&self, at: usize, moment: Moment) -> StationReport {
        let ((id, task), (done, moves)) = (self.tasks[at], moment[at]);
        let station = self.line.station(id);
        let fresh = Controller::new(self.line, id, 7, Restore::Fresh).expect("a shipped station compiles");
        let mut snapshot = StationSnapshot { placed: true, ..fresh.snapshot() };
        let from = station.task(task).from;
        let came_by = station.task_ids().find(|&other| other != task && station.task(other).to == from);
        match (done, moves, came_by) {
            (0, false, Some(before)) => snapshot.marking = vec![StationPlace::completed(station.last_of(before))],
            (0, false, None) => {}
            _ => {
                snapshot.cycle += 1;
                for op in (0..done + usize::from(moves)).map(|step| self.op(at, step)) {
                    snapshot.started[op.index()] += 1;
                }
                for op in (0..done).map(|step| self.op(at, step)) {
                    snapshot.done[op.index()] += 1;
                }
                let place = match moves {
                    true => StationPlace::incomplete(self.op(at, done)),
                    false => StationPlace::completed(self.op(at, done - 1)),
                };
                snapshot.marking = vec![place];
            }
        }
        reported(self.line, id, snapshot, self.seen(&self.positions(moment), id))
    }

    /// The situation with the alarm of the activity, where one is to be led at least.
    fn situation(&self, moment: Moment, end: Option<ActivityEnd>) -> Option<LineSituation> {
        let stations = self.line.station_ids().map(|id| match self.tasks.iter().position(|of| of.0 == id) {
            Some(at) => Some(self.report(at, moment)),
            None => {
                let fresh = Controller::new(self.line, id, 7, Restore::Fresh).expect("a shipped station compiles");
                let snapshot = StationSnapshot { placed: true, ..fresh.snapshot() };
                Some(reported(self.line, id, snapshot, 0))
            }
        });
        let mut seen = LineSituation::of(self.line, ControlMode::StandBy, stations.collect());
        let is_away = |id: &StationId| {
            let report = seen.stations[id.index()].as_ref().expect("it is heard");
            !report.at_home || !report.incomplete.is_empty()
        };
        let lead: Vec<StationId> = self.tasks.iter().map(|of| of.0).filter(is_away).collect();
        if lead.is_empty() {
            return None;
        }
        // As the coordinator decides: by a station that has completed its order, or has not begun it.
        let ends = [0, 1].map(|at| match moment[at] {
            (0, false) => Some(ActivityEnd::TakenBack),
            (done, _) => (done == self.steps(at)).then_some(ActivityEnd::Done),
        });
        let end = ends[0].or(ends[1]).or(end);
        seen.left_out = self.tasks.map(|of| of.0).to_vec();
        seen.alarms = vec![StandingAlarm {
            id: 1,
            text: "it failed.".to_owned(),
            answers: ["as-before", "as-done"].map(ListedAnswer::from).to_vec(),
            lead,
            reset: Vec::new(),
            at_order: Vec::new(),
            end: end.map(|end| DecidedEnd { end, because: "it is decided".to_owned() }),
            bring: None,
        }];
        Some(seen)
    }
}

/// The report of a station that stands so, with these inputs beside its switches.
pub fn reported(line: &Line, id: StationId, snapshot: StationSnapshot, seen: u128) -> StationReport {
    let station = line.station(id);
    let bits = snapshot.marking.iter().fold(seen, |bits, &place| bits | station.rest_inputs(place));
    let mut controller = Controller::new(line, id, 7, Restore::From(snapshot)).expect("its own");
    let (now, until, under) = (Tick::from_millis(1), Tick::NEVER, NO_DELAY);
    controller.handle(now, StationInput::Inputs { bits, valid: true, until, under });
    controller.step(now, &mut StationOutbox::default());
    controller.report()
}

/// What lets go of the part, or tears at it, when this step begins.
fn lost_by(line: &Line, positions: &Positions, step: &RecoveryStep) -> Option<String> {
    let flow = &line.handling;
    let stand_of = |holder: HolderId| match flow.holder(holder).grip {
        Grip::Hand(stand) | Grip::Clamp(stand) => Some(stand),
        Grip::Loose => None,
    };
    let is_open = |stand: Stand| {
        let at = positions.of(stand.station, stand.axis);
        !at.is_nan() && !positions.holds(&stand)
    };
    let reached = |reach: &&linewright_line::Reach| reach.when.iter().all(|stand| positions.holds(stand));
    step.moves.iter().find_map(|of| {
        let (id, motion) = (of.station, line.operation((of.station, of.place.op)).motion);
        let target = if of.place.block == Block::Normal { motion.to } else { motion.from };
        let is_it = |stand: &Stand| (stand.station, stand.axis) == (id, motion.axis);
        for (at, holder) in flow.holders.iter().enumerate() {
            let Some(stand) = stand_of(HolderId::at(at)).filter(is_it).filter(|stand| stand.at != target) else {
                continue;
            };
            let mut others = flow.reaches.iter().filter(reached).filter_map(|reach| match holder.is_hand() {
                true => (reach.hand == HolderId::at(at)).then_some(reach.to),
                false => (reach.to == HolderId::at(at)).then_some(reach.hand),
            });
            if !others.any(|other| stand_of(other).is_none_or(|of| positions.holds(&of))) && !is_open(stand) {
                return Some(format!("{} lets go", holder.name));
            }
        }
        let moved = flow.reaches.iter().filter(reached).find(|reach| {
            let [hand, nest] = [reach.hand, reach.to].map(stand_of);
            reach.when.iter().any(is_it) && hand.zip(nest).is_some_and(|(hand, nest)| !is_open(hand) && !is_open(nest))
        });
        moved.map(|reach| format!("{} is moved while both hold", flow.holder(reach.hand).name))
    })
}

/// What goes wrong on the way.
fn fault(transfer: &Transfer<'_>, moment: Moment, found: &RecoveryPlan) -> Option<String> {
    let mut positions = transfer.positions(moment);
    for step in &found.steps {
        if let Some(what) = lost_by(transfer.line, &positions, step) {
            return Some(format!("{what} by `{}`", step.text(transfer.line)));
        }
        for of in &step.moves {
            let motion = transfer.line.operation((of.station, of.place.op)).motion;
            let at = if of.place.block == Block::Normal { motion.to } else { motion.from };
            positions.0[of.station.index()][motion.axis.index()] = at;
        }
    }
    None
}

#[test]
fn a_part_is_held_along_every_list() {
    let lines = shipped().map(|(_, line)| line);
    let (mut both, mut ends) = (0, [0, 0]);
    for (cell, orders) in TRANSFERS {
        let transfer = Transfer::of(&lines[cell], orders);
        for moment in transfer.moments() {
            for end in [None, Some(ActivityEnd::Done), Some(ActivityEnd::TakenBack)] {
                let Some(seen) = transfer.situation(moment, end) else { continue };
                let found = plan(transfer.line, &seen);
                let texts: Vec<String> = found.steps.iter().map(|step| step.text(transfer.line)).collect();
                let what = fault(&transfer, moment, &found);
                assert_eq!(what, None, "{orders:?} {moment:?} {end:?}: {texts:#?}");
                let decided = seen.alarms[0].end.as_ref().map(|of| of.end);
                assert!(decided.is_none() || found.led[0].end == decided, "{orders:?} {moment:?} {end:?}: {texts:#?}");
                assert_eq!(found.led[0].order, LedOrder::Kept, "{orders:?} {moment:?} {end:?}: {texts:#?}");
                both += usize::from(seen.alarms[0].lead.len() == 2);
                match found.led[0].end {
                    Some(ActivityEnd::Done) => ends[0] += 1,
                    Some(ActivityEnd::TakenBack) => ends[1] += 1,
                    None => {}
                }
            }
        }
    }
    assert!(both > 50 && ends[0] > 20 && ends[1] > 50, "{both} {ends:?}");
}

/// Without inputs that are waited for the stations do their tasks by time, and go back so.
#[test]
fn where_no_station_waits_the_order_is_that_of_the_chart_by_time() {
    let [(_, mut line), _] = shipped();
    let (orders, moment) = (TRANSFERS[0].1, [(2, true), (1, true)]);
    let list = |line: &Line| {
        let transfer = Transfer::of(line, orders);
        let seen = transfer.situation(moment, Some(ActivityEnd::TakenBack)).expect("both are led");
        let found = plan(line, &seen);
        (found.led[0].clone(), found.steps.iter().map(|step| step.text(line)).collect::<Vec<_>>())
    };
    let robot = line.station_named("robot").expect("there");
    let input = line.station(robot).inputs.iter().position(|name| name == "m1_clamped").map(InputId::at);
    let is_it = |sensor: &Sensor| sensor.station == robot && Some(sensor.input) == input;
    let at = line.handling.sensors.iter().position(is_it).expect("it is described");
    for left_out in [at..at + 1, 0..line.handling.sensors.len() - 1] {
        line.handling.sensors.drain(left_out);
        let (led, texts) = list(&line);
        assert_eq!(led.order, LedOrder::Unknown, "what they wait for is not described: {texts:#?}");
        assert!(led.text(&line).contains("does not tell the order"), "{}", led.text(&line));
    }
    let operations = line.stations.iter_mut().flat_map(|station| &mut station.operations);
    operations.for_each(|operation| {
        operation.waits.clear();
        operation.result = None;
    });
    let (led, texts) = list(&line);
    let at = |name: &str| texts.iter().position(|text| text.contains(&format!("`{name}` is undone")));
    assert_eq!((led.order, led.end), (LedOrder::Kept, Some(ActivityEnd::TakenBack)), "{texts:#?}");
    assert!(at("carry to m1").is_some() && at("carry to m1") < at("prepare tools"), "{texts:#?}");
    assert!(at("clamp-close").is_some() && at("clamp-close") < at("fetch for m1"), "{texts:#?}");
}
