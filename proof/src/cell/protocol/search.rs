//! The product: one player, its stations, what was sent, and what is on its way back, breadth first.

use linewright_line::StationId;
use rustc_hash::FxHashMap;

use super::players::{PlayerMove, Players, StandReason, StationMessage};
use super::stage::ActivityStart;
use super::station::{TaskStationAct, TaskStationModels};
use super::{
    ANSWERED, ActivityExplored, BACK, BrokenRule, CLOSED, ENDED, GIVEN, ProtocolSetting, RESTORED, STOPPED, TWICE,
    words,
};
use crate::explore::{LimitReached, SearchProgress};

/// Messages of one activity and of what follows it, a bit each. With more the exploration is not exhaustive, and reports so.
pub(super) const MESSAGES_MAX: u32 = u64::BITS;

/// A state as numbers: the player, the number of disturbances left, the messages sent (two words); then of each station
/// its situation, and one more than the number of its report on its way.
type Packed = Box<[u32]>;

const PLAYER: usize = 0;
const LEFT: usize = 1;
const SENT: usize = 2;
const STATIONS: usize = 4;

/// Transition from one state to the next.
#[derive(Clone, Copy, Debug)]
enum ProtocolArc {
    Begins,
    Message(u32),
    Act(u32, TaskStationAct),
    Says(u32),
    Player(PlayerMove),
}

struct ProtocolSearch<'c> {
    setting: &'c ProtocolSetting<'c>,
    stations: Vec<StationId>,
    machines: Vec<TaskStationModels<'c>>,
    players: Players,
    numbers: FxHashMap<Packed, u32>,
    states: Vec<Packed>,
    came: Vec<(u32, ProtocolArc)>,
    arcs: Vec<(u32, u32)>,
    wrong: Option<(u32, ProtocolArc, &'static str, String)>,
}

pub(super) fn explore(
    setting: &ProtocolSetting<'_>,
    stage: ActivityStart,
    progress: &SearchProgress,
) -> ActivityExplored {
    progress.begin(setting.states);
    let ActivityStart { name, mode, stations, machines, mut player } = stage;
    let mut search = ProtocolSearch {
        setting,
        machines: stations.iter().map(|_| TaskStationModels::new(setting.line)).collect(),
        players: Players::new(setting.rules, stations.clone()),
        stations,
        numbers: FxHashMap::default(),
        states: Vec::new(),
        came: Vec::new(),
        arcs: Vec::new(),
        wrong: None,
    };
    player.coordination = player.coordination.with_rules(setting.rules);
    let mut first = vec![0, u32::from(setting.disturbances), 0, 0];
    for (nth, machine) in machines.into_iter().enumerate() {
        first.push(search.machines[nth].enter(machine.with_rules(setting.order_rules)));
        first.push(0);
    }
    // It has started, and is what is looked at.
    let before = player.coordination.state().firings().map(|firing| firing.id).max();
    let start = search.players.enter(player);
    let stepped = search.players.step(start, PlayerMove::Start(mode), |_, _| unreachable!("nobody is heard")).clone();
    let mut begun = search.players.all[stepped.to as usize].clone();
    begun.firing = begun.coordination.state().firings().map(|firing| firing.id).max().filter(|id| Some(*id) != before);
    let begun = search.players.enter_anew(begun);
    first[PLAYER] = begun;
    stepped.sends.iter().for_each(|&message| sent(&mut first, message));
    search.enter(first.into(), 0, ProtocolArc::Begins);
    let mut at = 0;
    while at < search.states.len() && search.wrong.is_none() && search.limit().is_none() {
        search.expand(at as u32);
        at += 1;
        progress.looked_at(at);
    }
    let limit = search.limit().filter(|_| search.wrong.is_none() && at < search.states.len());
    let fits = search.players.messages.len() <= MESSAGES_MAX as usize;
    let exhausted = search.wrong.is_some() || (fits && at == search.states.len());
    if search.wrong.is_none() && exhausted {
        search.look_for_ends();
    }
    let wrong = search.wrong.take().map(|wrong| search.tell(wrong));
    ActivityExplored {
        name,
        stations: search.stations.iter().map(|&station| setting.line.station(station).name.clone()).collect(),
        states: search.states.len(),
        disturbed: setting.disturbances > 0,
        exhausted,
        limit,
        wrong,
    }
}

/// A message beyond those that have a bit leaves the state as it is.
fn sent(state: &mut [u32], message: u32) {
    let bit = 1_u64.checked_shl(message).unwrap_or(0);
    state[SENT] |= bit as u32;
    state[SENT + 1] |= (bit >> 32) as u32;
}

impl ProtocolSearch<'_> {
    /// The limit that has been reached.
    fn limit(&self) -> Option<LimitReached> {
        // A state has a number of 32 bits.
        if self.states.len() >= self.setting.states.min(u32::MAX as usize / 2) {
            return Some(LimitReached::States);
        }
        (self.bytes() > self.setting.bytes).then_some(LimitReached::Memory)
    }

    /// Memory of the states and arcs, about: each state is kept twice, with the block that holds it.
    fn bytes(&self) -> usize {
        const BLOCK: usize = 16;
        let numbers = self.states.first().map_or(0, |state| size_of_val(&**state));
        let entries = size_of::<(Packed, u32)>() + size_of::<Packed>() + size_of::<(u32, ProtocolArc)>();
        let back = size_of::<Vec<u32>>();
        self.states.len() * (2 * (numbers + BLOCK) + entries + back) + self.arcs.len() * size_of::<[u32; 3]>()
    }

    fn enter(&mut self, state: Packed, from: u32, by: ProtocolArc) {
        let next = self.states.len() as u32;
        let number = *self.numbers.entry(state).or_insert_with_key(|state| {
            self.states.push(state.clone());
            self.came.push((from, by));
            next
        });
        if !matches!(by, ProtocolArc::Begins) && number != from {
            self.arcs.push((from, number));
        }
    }

    fn expand(&mut self, from: u32) {
        let state = self.states[from as usize].clone();
        let player = state[PLAYER];
        if self.players.over[player as usize] {
            return;
        }
        for nth in 0..self.stations.len() {
            self.expand_station(from, &state, nth);
        }
        for index in 0..self.players.events[player as usize].len() {
            let event = self.players.events[player as usize][index];
            let costs = event == PlayerMove::Restart || event == PlayerMove::Alarm;
            if !costs || state[LEFT] > 0 {
                let mut next = state.to_vec();
                next[LEFT] -= u32::from(costs);
                self.player(from, next, event);
            }
        }
    }

    fn expand_station(&mut self, from: u32, state: &Packed, nth: usize) {
        let (at, pending) = (STATIONS + 2 * nth, STATIONS + 2 * nth + 1);
        let situation = state[at];
        for number in 0..self.players.messages.len().min(MESSAGES_MAX as usize) as u32 {
            let is_sent = state[SENT + (number / 32) as usize] & 1 << (number % 32) != 0;
            let message = &self.players.messages[number as usize];
            if !is_sent || message.station() != self.stations[nth] {
                continue;
            }
            let mut next = state.to_vec();
            next[at] = self.machines[nth].hear(situation, number, |machine| match message {
                StationMessage::Order(order) => machine.order(order),
                StationMessage::Secure { key, way, alarmed, .. } => machine.secure(*key, *way, *alarmed),
            });
            self.station(from, next, nth, ProtocolArc::Message(number));
        }
        for index in 0..self.machines[nth].acts[situation as usize].len() {
            let act = self.machines[nth].acts[situation as usize][index];
            let costs = matches!(
                act,
                TaskStationAct::Fail | TaskStationAct::Restart | TaskStationAct::Forget | TaskStationAct::Led { .. }
            );
            if costs && state[LEFT] == 0 {
                continue;
            }
            let mut next = state.to_vec();
            next[LEFT] -= u32::from(costs);
            next[at] = self.machines[nth].act(situation, act);
            self.station(from, next, nth, ProtocolArc::Act(nth as u32, act));
        }
        let says = self.machines[nth].says[situation as usize] + 1;
        // Received at once; a report still on its way is older, and dropped.
        let mut next = state.to_vec();
        next[pending] = 0;
        self.player(from, next, PlayerMove::Heard(nth as u32, says - 1));
        if state[pending] == 0 && state[LEFT] > 0 {
            let mut next = state.to_vec();
            next[LEFT] -= 1;
            next[pending] = says;
            self.enter(next.into(), from, ProtocolArc::Says(nth as u32));
        }
        if state[pending] != 0 {
            let mut next = state.to_vec();
            next[pending] = 0;
            self.player(from, next, PlayerMove::Heard(nth as u32, state[pending] - 1));
        }
    }

    fn station(&mut self, from: u32, next: Vec<u32>, nth: usize, by: ProtocolArc) {
        let machine = &self.machines[nth].all[next[STATIONS + 2 * nth] as usize];
        let name = &self.setting.line.station(self.stations[nth]).name;
        let twice = machine.twice.then(|| (TWICE, format!("{name} does again what it has done")));
        let on = machine.moves_on.then(|| (STOPPED, format!("{name} moves after receiving the alarm")));
        let ended = machine.goes_on().then(|| (ENDED, format!("{name} reports an order ended that is in progress")));
        for (rule, end) in twice.into_iter().chain(on).chain(ended).chain(self.goes_back(&next)) {
            self.found(from, by, rule, end);
        }
        self.enter(next.into(), from, by);
    }

    /// A station that goes back while another one is in a handshake with it.
    fn goes_back(&self, state: &[u32]) -> Option<(&'static str, String)> {
        let retreat = |nth: usize| self.machines[nth].retreats[state[STATIONS + 2 * nth] as usize];
        let all = 0..self.stations.len();
        let pairs = all.clone().flat_map(|back| all.clone().map(move |other| (back, other)));
        let mut pairs = pairs.filter(|(back, other)| back != other && retreat(*back).goes_back);
        let (back, other) = pairs.find(|&(_, other)| retreat(other).is_involved)?;
        let [back, other] = [back, other].map(|nth| &self.setting.line.station(self.stations[nth]).name);
        Some((BACK, format!("{back} goes back while {other} may be in a handshake with it")))
    }

    fn player(&mut self, from: u32, mut next: Vec<u32>, event: PlayerMove) {
        let (stations, machines) = (&self.stations, &self.machines);
        let said =
            |nth: u32, number: u32| (stations[nth as usize], machines[nth as usize].said[number as usize].clone());
        let stepped = self.players.step(next[PLAYER], event, said).clone();
        let by = ProtocolArc::Player(event);
        let is_at = |station: StationId| {
            let nth = self.stations.iter().position(|of| *of == station)?;
            let (slot, moves) = self.machines[nth].at[next[STATIONS + 2 * nth] as usize];
            Some((&self.setting.line.station(station).name, slot, moves))
        };
        let mut wrong = Vec::new();
        for &(reason, station, key) in &stepped.stand {
            if let Some((name, slot, moves)) = is_at(station).filter(|(_, slot, moves)| *slot == Some(key) || *moves) {
                let doing =
                    slot.map_or_else(|| "moves".to_owned(), |key| format!("is at order {}", words::number(key)));
                let (rule, what) = match reason {
                    StandReason::Answered => (ANSWERED, "the answer is taken"),
                    StandReason::Restored => (RESTORED, "tokens and part are placed by the answer"),
                    StandReason::Asked => (STOPPED, "the operator is asked"),
                };
                let and = if moves && slot.is_some() { ", and moves" } else { "" };
                wrong.push((rule, format!("{what} while {name} {doing}{and}")));
            }
        }
        let running = self.players.all[next[PLAYER] as usize].coordination.state();
        for &station in &stepped.given {
            let is_running = |key| {
                running
                    .order(key)
                    .is_some_and(|(of, _)| of.phase == linewright_coordinator_cell::ActivityPhase::Running)
            };
            if let Some((name, Some(key), _)) =
                is_at(station).filter(|(_, slot, _)| slot.is_some_and(|key| !is_running(key)))
            {
                let what = format!("{name} is given the next order while it is at order {}", words::number(key));
                wrong.push((GIVEN, what));
            }
        }
        for (rule, end) in wrong {
            self.found(from, by, rule, end);
        }
        stepped.sends.iter().for_each(|&message| sent(&mut next, message));
        next[PLAYER] = stepped.to;
        self.enter(next.into(), from, by);
    }

    /// The first violation counts, if its rule is to be checked.
    fn found(&mut self, from: u32, by: ProtocolArc, rule: &'static str, end: String) {
        if self.wrong.is_none() && self.setting.asked.is_none_or(|asked| asked == rule) {
            self.wrong = Some((from, by, rule, end));
        }
    }

    /// From every state one must lead on in which the activity is closed, or waits for people alone.
    fn look_for_ends(&mut self) {
        let mut ends: Vec<bool> = self.states.iter().map(|state| self.players.closed[state[PLAYER] as usize]).collect();
        let mut back: Vec<Vec<u32>> = vec![Vec::new(); self.states.len()];
        self.arcs.iter().for_each(|&(from, to)| back[to as usize].push(from));
        let mut open: Vec<u32> = (0..ends.len() as u32).filter(|&at| ends[at as usize]).collect();
        while let Some(at) = open.pop() {
            for &from in &back[at as usize] {
                if !std::mem::replace(&mut ends[from as usize], true) {
                    open.push(from);
                }
            }
        }
        if let Some(stuck) = ends.iter().position(|ends| !ends).filter(|&at| at > 0) {
            let (from, by) = self.came[stuck];
            self.found(from, by, CLOSED, "the activity cannot be closed any more".to_owned());
        }
    }

    fn tell(&self, (from, by, rule, end): (u32, ProtocolArc, &'static str, String)) -> BrokenRule {
        let mut way = vec![(from, by)];
        let mut at = from;
        while !matches!(self.came[at as usize].1, ProtocolArc::Begins) {
            way.push(self.came[at as usize]);
            at = self.came[at as usize].0;
        }
        let line = self.setting.line;
        let steps = way.into_iter().rev().map(|(from, by)| {
            let state = &self.states[from as usize];
            let machine = |nth: u32| &self.machines[nth as usize].all[state[STATIONS + 2 * nth as usize] as usize];
            match by {
                ProtocolArc::Begins => String::new(),
                ProtocolArc::Message(number) => words::message(line, &self.players.messages[number as usize]),
                ProtocolArc::Act(nth, act) => words::act(line, machine(nth), act),
                ProtocolArc::Says(nth) => {
                    format!("on its way: {}", words::says(line, self.stations[nth as usize], &machine(nth).says()))
                }
                ProtocolArc::Player(PlayerMove::Heard(nth, number)) => {
                    let said = &self.machines[nth as usize].said[number as usize];
                    format!("the coordinator receives: {}", words::says(line, self.stations[nth as usize], said))
                }
                ProtocolArc::Player(event) => words::event(&self.players.all[state[PLAYER] as usize], event),
            }
        });
        BrokenRule { rule, steps: steps.collect(), end }
    }
}
