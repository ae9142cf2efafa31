//! The shortest presses in manual after which auto is accepted.
//!
//! Best first, by what was done and the least that is left. The stations that are moved are a set, which grows where it has to:
//! to all that a refused press reads, if a way through it could still be shorter than the one that was found.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::rc::Rc;
use std::time::Duration;

use linewright_line::net::StationPlace;
use linewright_line::{Line, OpId, Parameter, StationId};
use linewright_station_logic::RejoinAt;
use rustc_hash::FxHashMap;

use crate::distance::{Aim, Cost, Distances};
use crate::ends::{CommonEnds, KeptWay};
use crate::restore::is_unknown;
use crate::situation::LineSituation;
use crate::step::{ConfirmedNumber, PanelButton, RecoveryAction, RejoinChoice};
use crate::units::{PlayedLine, PlayedStations, Resumed};

/// Presses that are tried, at most, before any plan is taken instead of the shortest.
pub const TRIED_MAX: usize = 8_000;
/// The same of the search for any plan.
pub const TRIED_FOR_ANY_MAX: usize = 16_000;
/// In the search for any plan what is left counts for so many times what was done.
const GREED: u32 = 8;

/// What moves by an action, and where.
type PlannedMotions = Vec<(StationId, StationPlace)>;
/// Least estimate, then the furthest, then the newest.
type OpenNode = Reverse<(Cost, Reverse<u32>, Reverse<usize>)>;

/// An action with its effect.
#[derive(Clone)]
pub(crate) struct Move {
    pub action: RecoveryAction,
    pub motions: PlannedMotions,
    pub after: PlayedStations,
    /// A switch that is on already has to be believed for it.
    pub is_doubtful: bool,
    /// The motion is the homing of a drive.
    pub homes: bool,
    /// What it counts for against others.
    cost: Cost,
}

/// *Return* counts for a quarter longer than it takes, and this: of two ways that take nearly as long the one that goes on is taken.
const RETURN_COUNTS: Duration = Duration::from_millis(250);

/// A press that is to believe a switch may need a second one, after the report of the watchdog.
const AFTER_WATCHDOG: u32 = 1;
/// Where a position is lost as well, a person looks and confirms it first, if that is possible.
const AGAINST_CONFIRMING: u32 = 4;

impl Move {
    fn of(action: RecoveryAction, motions: PlannedMotions, time: Duration, after: PlayedStations) -> Self {
        let is_return = matches!(action, RecoveryAction::Press(_, PanelButton::Return));
        let counts = if is_return { time + time / 4 + RETURN_COUNTS } else { time };
        Move { action, motions, after, is_doubtful: false, homes: false, cost: (1, counts) }
    }
}

/// Result of a search.
pub(crate) struct FoundMoves {
    pub moves: Vec<Move>,
    pub is_shortest: bool,
    pub expanded: usize,
}

/// A search failed.
pub(crate) struct NotFound {
    pub expanded: usize,
    /// Every state that can be reached was looked at.
    pub is_certain: bool,
}

struct SearchNode {
    units: PlayedStations,
    done: Cost,
    /// The node before, and the action that led here.
    from: Option<(usize, Move)>,
}

pub(crate) struct Search<'f, 'l> {
    floor: &'f PlayedLine<'l>,
    distances: Distances<'l>,
    compares: Vec<bool>,
    left_out: &'f [StationId],
    situation: &'f LineSituation,
    /// Resume takes effect.
    resumes: bool,
    /// Stations of one activity end it alike.
    ends: &'f CommonEnds,
    kept: &'f KeptWay,
    accepted: &'f dyn Fn(&PlayedStations) -> bool,
}

enum Outcome {
    Goal(usize),
    Exhausted,
    Limit,
}

/// By station, whether its counts are compared with those of another one.
fn compares(line: &Line) -> Vec<bool> {
    let compares = |id| line.arrows.iter().any(|arrow| arrow.from.0 == id || arrow.to.0 == id);
    line.station_ids().map(compares).collect()
}

fn aim(compares: &[bool], units: &PlayedStations) -> Aim {
    let mut generations = units.iter().zip(compares).filter(|(_, c)| **c).map(|(u, _)| u.report.generation);
    match generations.next() {
        None => Aim::InOrder,
        Some(first) if first != 0 && generations.all(|other| other == first) => Aim::InOrder,
        Some(_) => Aim::Home,
    }
}

/// Whether auto founds a new generation of counts from there.
pub(crate) fn begins_anew(line: &Line, units: &PlayedStations) -> bool {
    aim(&compares(line), units) == Aim::Home
}

impl<'f, 'l> Search<'f, 'l> {
    /// `accepted`: the mode decision takes auto from there.
    pub fn new(
        floor: &'f PlayedLine<'l>,
        (left_out, situation): (&'f [StationId], &'f LineSituation),
        resumes: bool,
        (ends, kept): (&'f CommonEnds, &'f KeptWay),
        accepted: &'f dyn Fn(&PlayedStations) -> bool,
    ) -> Self {
        let line: &'l Line = floor.line;
        let (compares, distances) = (compares(line), Distances::new(line));
        Search { floor, distances, compares, left_out, situation, resumes, ends, kept, accepted }
    }

    fn is_task_driven(&self, station: usize) -> bool {
        self.floor.line.stations[station].is_task_driven()
    }

    /// What every station is to be led to: home, unless their counts can be compared.
    fn aim(&self, units: &PlayedStations) -> Aim {
        aim(&self.compares, units)
    }

    fn is_placed(&self, units: &PlayedStations, station: usize, aim: Aim) -> bool {
        let unit = &units[station];
        let is_in_order = unit.is_in_order(self.is_task_driven(station));
        self.left_out.contains(&StationId::at(station)) || is_in_order && (aim == Aim::InOrder || unit.report.at_home)
    }

    fn is_goal(&self, units: &PlayedStations) -> bool {
        let aim = self.aim(units);
        let is_placed = (0..units.len()).all(|station| self.is_placed(units, station, aim));
        is_placed && self.ends.agree(units, self.kept) && (self.accepted)(units)
    }

    /// The least that is left. One *resume* may stand for a press at each station that has something to be led on, or may have
    /// after a confirmation; and for one of each, since nothing of it becomes incomplete again.
    fn left(&self, units: &PlayedStations) -> Cost {
        let aim = self.aim(units);
        let all = (0..units.len()).filter(|&station| !self.is_placed(units, station, aim));
        let (mut presses, mut time, mut shared) = (0, Duration::ZERO, 0);
        for station in all {
            let (more, longer) = self.distances.least(station, &units[station], aim);
            (presses, time) = (presses + more, time + longer);
            let report = &units[station].report;
            let may_be_resumed = !report.incomplete.is_empty() || report.position_lost.is_some();
            shared += u32::from(self.resumes && may_be_resumed && more > 0);
        }
        (presses - shared.saturating_sub(1), time)
    }

    /// The shortest moves from here.
    pub fn run(&self, start: &PlayedStations) -> Result<FoundMoves, NotFound> {
        let aim = self.aim(start);
        let lost = |station: usize| start[station].report.position_lost.is_some();
        // Once a position is confirmed by a person, counts are founded anew at home.
        let first_aim = if (0..start.len()).any(lost) { Aim::Home } else { aim };
        let mut moved: BTreeSet<usize> =
            (0..start.len()).filter(|&station| !self.is_placed(start, station, aim)).collect();
        let mut expanded = 0;
        loop {
            let mut best = BestFirst::new(self, start, 1);
            let limit = (TRIED_MAX / (2 * moved.len().max(1))).saturating_sub(expanded);
            let outcome = best.run(&moved, limit);
            expanded += best.expanded;
            let bound = match outcome {
                Outcome::Goal(at) => best.nodes[at].done.0,
                Outcome::Exhausted => u32::MAX,
                Outcome::Limit => return self.any(start, &moved, &best.blocked, expanded),
            };
            // What stands away from home may have to come home after a confirmation.
            let away = (0..start.len()).filter(|&s| bound > 1 && !self.is_placed(start, s, first_aim));
            let blockers = best.blocked.iter().filter(|&(_, &least)| least + 1 < bound).map(|(&station, _)| station);
            let more: Vec<usize> = away.chain(blockers).filter(|station| !moved.contains(station)).collect();
            match outcome {
                Outcome::Goal(at) if more.is_empty() => {
                    return Ok(FoundMoves { moves: best.moves_to(at), is_shortest: true, expanded });
                }
                _ if more.is_empty() => return Err(NotFound { expanded, is_certain: true }),
                _ => moved.extend(more),
            }
        }
    }

    /// Any moves, the stations that were in the way included.
    fn any(
        &self,
        start: &PlayedStations,
        moved: &BTreeSet<usize>,
        blocked: &FxHashMap<usize, u32>,
        expanded: usize,
    ) -> Result<FoundMoves, NotFound> {
        let all = moved.iter().chain(blocked.keys()).copied().collect();
        let mut total = expanded;
        for set in [moved, &all] {
            let mut best = BestFirst::new(self, start, GREED);
            let outcome = best.run(set, TRIED_FOR_ANY_MAX / (4 * set.len().max(1)));
            total += best.expanded;
            if let Outcome::Goal(at) = outcome {
                return Ok(FoundMoves { moves: best.moves_to(at), is_shortest: false, expanded: total });
            }
        }
        Err(NotFound { expanded: total, is_certain: false })
    }

    fn resumed(&self, units: &PlayedStations) -> Option<Move> {
        let Resumed { units, motions, time } = self.floor.resume(units).filter(|_| self.resumes)?;
        Some(Move::of(RecoveryAction::Resume, motions, time, units))
    }

    /// The same moves from `start` in this order; none where one of them is refused there, or does something else, or they do not lead
    /// to the goal.
    pub fn replayed(&self, start: &PlayedStations, order: &[Move]) -> Option<Vec<Move>> {
        let mut units = start.clone();
        let mut played = Vec::with_capacity(order.len());
        for made in order {
            let is_same = |of: &Move| {
                let (motions, again) = (&made.motions, &of.motions);
                of.action == made.action
                    && motions == again
                    && (of.is_doubtful, of.homes) == (made.is_doubtful, made.homes)
            };
            let again = match made.action.station() {
                Some(station) => self.actions(&units, station.index()).into_iter().find(is_same)?,
                None => self.resumed(&units).filter(is_same)?,
            };
            if !self.ends.permit(self.floor.line, &units, &again.after, self.kept) {
                return None;
            }
            units.clone_from(&again.after);
            played.push(again);
        }
        self.is_goal(&units).then_some(played)
    }

    /// Every action of a station that has an effect.
    fn actions(&self, units: &PlayedStations, station: usize) -> Vec<Move> {
        let id = StationId::at(station);
        let mut moves = Vec::new();
        // On its recovery path *return* leads it on.
        let is_on = self.situation.lead_on.contains(&id) && !units[station].report.recovering_home;
        for button in [PanelButton::Advance, PanelButton::Return] {
            if button == PanelButton::Return && is_on {
                continue;
            }
            if let Some(pressed) = self.floor.press(units, station, button) {
                let action = RecoveryAction::Press(id, button);
                let motions = pressed.motions.into_iter().map(|place| (id, place)).collect();
                let mut made = Move::of(action, motions, pressed.time, pressed.units);
                (made.is_doubtful, made.homes) = (pressed.is_doubtful, pressed.homes);
                if pressed.is_doubtful {
                    let is_lost = units[station].report.position_lost.is_some();
                    made.cost.0 += if is_lost { AGAINST_CONFIRMING } else { AFTER_WATCHDOG };
                }
                moves.push(made);
            }
        }
        let report = &units[station].report;
        let described = &self.floor.line.stations[station];
        let is_confirmed = || !described.is_task_driven() && self.is_confirmed(units, station);
        let is_unknown = is_unknown(described, report) && !is_confirmed();
        // A drive that can be homed says where its axis is; nobody has to judge it by eye.
        let is_homed = moves.iter().any(|made| made.homes);
        if (report.position_lost.is_some() && !is_homed) || is_unknown {
            moves.extend(self.confirmations(units, station));
        }
        moves
    }

    /// Whether it stands within operations that its switches fit, as after a confirmation: another one would be a way round. At
    /// the home operation a station stands also without one, when it is switched on away from home.
    fn is_confirmed(&self, units: &PlayedStations, station: usize) -> bool {
        let (report, home) = (&units[station].report, self.floor.line.stations[station].home);
        let stays = |op: OpId| {
            let confirmed = self.floor.rejoin(units, station, RejoinAt::Within(op));
            confirmed.is_some_and(|after| after[station].report.places == report.places)
        };
        report.incomplete.iter().all(|&(op, _)| op != home && stays(op))
    }

    /// A person confirms where it stands: by its switches, or the operations in which it may have been stopped.
    fn confirmations(&self, units: &PlayedStations, station: usize) -> Vec<Move> {
        let id = StationId::at(station);
        let still = |action, after| Move::of(action, Vec::new(), Duration::ZERO, after);
        let (described, report) = (self.floor.line.station(id), &units[station].report);
        let marks = report.places.iter().enumerate().filter(|&(_, &number)| number != 0);
        let marked: Vec<OpId> = marks.map(|(op, _)| OpId::at(op)).collect();
        let is_of_task = |op: OpId| marked.iter().any(|&of| described.task_of(of) == described.task_of(op));
        // The numbers of the task within which it is known to stand are in its journal.
        let are_known = |at: RejoinAt| match at {
            RejoinAt::Within(op) => report.placed && is_of_task(op),
            RejoinAt::Measured | RejoinAt::Rest(_) => report.placed,
        };
        let asked = |at: RejoinAt| match are_known(at) {
            true => &[],
            false => units[station].controller.numbers_to_confirm(at),
        };
        let choice = |at: RejoinAt, after: &PlayedStations| {
            let places: Vec<StationPlace> = after[station].controller.marking().collect();
            let task =
                places.first().filter(|_| !after[station].report.at_home).and_then(|of| described.task_of(of.op));
            // Where several activities have ordered it with different numbers, which of them it was for is for a person to see.
            let mut ordered = self.situation.interrupted.iter().filter(|of| of.station == id && Some(of.task) == task);
            let order = ordered.next().filter(|first| ordered.all(|other| other.numbers == first.numbers));
            let number = |parameter: &Parameter| ConfirmedNumber {
                parameter: parameter.clone(),
                known: order.and_then(|order| order.number(parameter)),
            };
            let numbers = asked(at).iter().map(number).collect();
            RejoinChoice {
                at,
                places,
                on: report.measured,
                numbers,
                activity: order.map(|order| order.activity.clone()),
            }
        };
        if let Some(after) = self.floor.rejoin(units, station, RejoinAt::Measured) {
            let at = choice(RejoinAt::Measured, &after);
            return vec![still(RecoveryAction::Rejoin { station: id, at, or: Vec::new() }, after)];
        }
        let within = |op: OpId| {
            let after = self.floor.rejoin(units, station, RejoinAt::Within(op))?;
            Some((op, choice(RejoinAt::Within(op), &after), after))
        };
        let mut fitting: Vec<(OpId, RejoinChoice, PlayedStations)> = described.op_ids().filter_map(within).collect();
        // A place that its journal has is assumed; else one of the task that it was ordered to do. The others are named beside it.
        let is_kept = |op: OpId| report.placed && marked.contains(&op);
        fitting
            .sort_by_key(|(op, of, _)| (!is_kept(*op), of.activity.is_none(), !marked.contains(op), !is_of_task(*op)));
        let rejoin = |nth: usize| {
            let mut or: Vec<RejoinChoice> = fitting.iter().map(|(_, of, _)| of.clone()).collect();
            let at = or.remove(nth);
            RecoveryAction::Rejoin { station: id, at, or }
        };
        let kept = fitting.iter().filter(|(op, ..)| is_kept(*op)).count();
        let ordered = fitting.iter().filter(|(_, of, _)| of.activity.is_some()).count();
        let assumed = [kept, ordered].into_iter().find(|&count| count > 0).unwrap_or(fitting.len());
        (0..assumed).map(|nth| still(rejoin(nth), fitting[nth].2.clone())).collect()
    }
}

struct BestFirst<'s, 'f, 'l> {
    search: &'s Search<'f, 'l>,
    greed: u32,
    nodes: Vec<SearchNode>,
    costs: FxHashMap<Box<[u64]>, Cost>,
    open: BinaryHeap<OpenNode>,
    expanded: usize,
    /// Stations that a refused press reads, with the least estimate of a state in which one was.
    blocked: FxHashMap<usize, u32>,
}

impl<'s, 'f, 'l> BestFirst<'s, 'f, 'l> {
    fn new(search: &'s Search<'f, 'l>, start: &PlayedStations, greed: u32) -> Self {
        let mut best = BestFirst {
            search,
            greed,
            nodes: Vec::new(),
            costs: FxHashMap::default(),
            open: BinaryHeap::new(),
            expanded: 0,
            blocked: FxHashMap::default(),
        };
        best.enter(SearchNode { units: start.clone(), done: (0, Duration::ZERO), from: None });
        best
    }

    fn estimate(&self, units: &PlayedStations, done: Cost) -> Cost {
        let (presses, time) = self.search.left(units);
        (done.0 + presses * self.greed, done.1 + time * self.greed)
    }

    fn enter(&mut self, node: SearchNode) {
        let key: Box<[u64]> = node.units.iter().map(|unit| unit.key).collect();
        if self.costs.get(&key).is_some_and(|&known| known <= node.done) {
            return;
        }
        self.costs.insert(key, node.done);
        let estimate = self.estimate(&node.units, node.done);
        self.open.push(Reverse((estimate, Reverse(node.done.0), Reverse(self.nodes.len()))));
        self.nodes.push(node);
    }

    fn run(&mut self, moved: &BTreeSet<usize>, limit: usize) -> Outcome {
        while let Some(Reverse((estimate, _, Reverse(at)))) = self.open.pop() {
            let units = self.nodes[at].units.clone();
            let done = self.nodes[at].done;
            let key: Box<[u64]> = units.iter().map(|unit| unit.key).collect();
            if self.costs.get(&key).is_some_and(|&known| known < done) {
                continue;
            }
            if self.search.is_goal(&units) {
                return Outcome::Goal(at);
            }
            if self.expanded >= limit {
                return Outcome::Limit;
            }
            self.expanded += 1;
            for &station in moved {
                self.expand(at, &units, done, station, estimate.0, moved);
            }
            if let Some(resumed) = self.search.resumed(&units) {
                self.go_on(at, &units, done, resumed);
            }
        }
        Outcome::Exhausted
    }

    fn expand(
        &mut self,
        at: usize,
        units: &PlayedStations,
        done: Cost,
        station: usize,
        estimate: u32,
        moved: &BTreeSet<usize>,
    ) {
        let moves = self.search.actions(units, station);
        let presses = moves.iter().filter(|m| matches!(m.action, RecoveryAction::Press(..))).count();
        if presses < 2 {
            let peers = units[station].controller.peers().iter().map(|peer| peer.index());
            for peer in peers.filter(|peer| !moved.contains(peer)) {
                let least = self.blocked.entry(peer).or_insert(estimate);
                *least = estimate.min(*least);
            }
        }
        for made in moves {
            self.go_on(at, units, done, made);
        }
    }

    fn go_on(&mut self, at: usize, units: &PlayedStations, done: Cost, made: Move) {
        let changed = made.after.iter().zip(units).any(|(a, b)| !Rc::ptr_eq(a, b) && a.key != b.key);
        let Search { floor, ends, kept, .. } = self.search;
        if changed && ends.permit(floor.line, units, &made.after, kept) {
            let done = (done.0 + made.cost.0, done.1 + made.cost.1);
            self.enter(SearchNode { units: made.after.clone(), done, from: Some((at, made)) });
        }
    }

    fn moves_to(&self, mut at: usize) -> Vec<Move> {
        let mut moves = Vec::new();
        while let Some((from, made)) = &self.nodes[at].from {
            moves.push(made.clone());
            at = *from;
        }
        moves.reverse();
        moves
    }
}
