//! The real token player, under a number for each situation it can be in.
//!
//! Time advances only to its next deadline, by an event of the exploration; stations have their own clocks. Only the records
//! of a step are evaluated here; the exploration compares them with the stations.

use std::time::Duration;

use linewright_coordinator_cell::exception::{AlarmSubject, ExceptionStep, SecuredState};
use linewright_coordinator_cell::{
    ActivityPhase, CellMessage, Coordination, DispatchDecision, Dispatcher, FiringId, ModeId, OrderKey, OrderMessage,
    PlayerInput, PlayerOutbox, ProtocolRules, Question, RecordKind, Start, TaskReply,
};
use linewright_line::{StationId, Tick};
use linewright_orders::LeaveWay;
use rustc_hash::FxHashMap;

use super::station::StationAnswer;

/// Longer than every limit and shorter than the time after which a message is repeated.
const RESENT: Duration = Duration::from_secs(12 * 3600);

/// Message to a station: an order, or to leave one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum StationMessage {
    Order(OrderMessage),
    Secure {
        station: StationId,
        key: OrderKey,
        way: LeaveWay,
        /// It was sent after a person had given alarm of the activity: nothing may move for this order any more.
        alarmed: bool,
    },
}

impl StationMessage {
    pub fn station(&self) -> StationId {
        match self {
            StationMessage::Order(order) => order.station,
            StationMessage::Secure { station, .. } => *station,
        }
    }
}

/// Something that may happen to the player. Stations by their position in the exploration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PlayerMove {
    /// It receives a station's report, by number.
    Heard(u32, u32),
    /// Time goes on to its next deadline.
    Time,
    /// A person answers the alarm of the activity, with its first word.
    Answer,
    /// A person gives alarm of a resource of the activity.
    Alarm,
    /// Its node is started again, with all its records.
    Restart,
    /// The dispatcher lets this mode start.
    Start(ModeId),
}

/// Decisions of a step that concern stations.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Stepped {
    pub to: u32,
    /// By number.
    pub sends: Vec<u32>,
    /// These have to stand: why, and of which order.
    pub stand: Vec<(StandReason, StationId, OrderKey)>,
    /// These have got an order, and must be at none of something that is not in progress any more.
    pub given: Vec<StationId>,
}

/// Why a station has to stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StandReason {
    /// An answer that concerns it is taken.
    Answered,
    /// Tokens are given back.
    Restored,
    /// A question to the operator, after an alarm given by hand.
    Asked,
}

#[derive(Clone)]
pub(super) struct ProtocolPlayer {
    pub coordination: Coordination,
    pub now: Tick,
    /// Number of activities started since the first.
    pub starts: u8,
    /// The activity that is explored.
    pub firing: Option<FiringId>,
    /// Its orders, once a person has given alarm of it.
    pub alarmed: Vec<OrderKey>,
}

/// Lets one mode start, and nothing else.
pub(super) struct SingleStart(pub Option<ModeId>);

impl Dispatcher for SingleStart {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let wanted = self.0;
        let found = question.candidates.iter().position(|candidate| Some(candidate.mode) == wanted);
        let start =
            found.map(|candidate| Start { candidate, part: question.parts(&question.candidates[candidate]).next() });
        if start.is_some() {
            self.0 = None;
        }
        DispatchDecision { start: start.into_iter().collect(), held: Vec::new() }
    }
}

/// The modes that could start.
#[derive(Default)]
pub(super) struct StartableModes(pub Vec<ModeId>);

impl Dispatcher for StartableModes {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        self.0 = question.candidates.iter().map(|candidate| candidate.mode).collect();
        DispatchDecision::default()
    }
}

pub(super) struct Players {
    numbers: FxHashMap<String, u32>,
    pub all: Vec<ProtocolPlayer>,
    /// By situation, what may happen besides hearing stations.
    pub events: Vec<Vec<PlayerMove>>,
    /// The activity is over, or waits for nothing but people: one of its stations stands between two rests, and an answer is taken
    /// when they have led it to one. That they can is explored of each station by itself.
    pub closed: Vec<bool>,
    /// Something else has started after it.
    pub over: Vec<bool>,
    pub messages: Vec<StationMessage>,
    stepped: FxHashMap<(u32, PlayerMove), Stepped>,
    rules: ProtocolRules,
    /// The stations that are looked at.
    stations: Vec<StationId>,
    scratch: String,
}

impl Players {
    pub fn new(rules: ProtocolRules, stations: Vec<StationId>) -> Self {
        Players {
            numbers: FxHashMap::default(),
            all: Vec::new(),
            events: Vec::new(),
            closed: Vec::new(),
            over: Vec::new(),
            messages: Vec::new(),
            stepped: FxHashMap::default(),
            rules,
            stations,
            scratch: String::new(),
        }
    }

    pub fn enter(&mut self, player: ProtocolPlayer) -> u32 {
        self.scratch.clear();
        player.coordination.situation(&mut self.scratch);
        self.scratch.push_str(&format!("{} {}", player.now, player.starts));
        if let Some(&number) = self.numbers.get(&self.scratch) {
            return number;
        }
        let number = self.all.len() as u32;
        let state = player.coordination.state();
        let firing = player.firing.and_then(|id| state.firing(id));
        let over = player.starts > 1;
        self.numbers.insert(self.scratch.clone(), number);
        let is_ordered =
            |id: StationId| firing.is_some_and(|firing| firing.orders.iter().any(|order| order.station == id));
        let is_led = alarm_of(&player).is_some() && player.coordination.held_stations().any(is_ordered);
        self.closed.push(firing.is_none() || is_led);
        self.over.push(over);
        let events = if over { Vec::new() } else { self.events_of(&player) };
        self.events.push(events);
        self.all.push(player);
        number
    }

    /// The same situation, of which another activity is looked at.
    pub fn enter_anew(&mut self, player: ProtocolPlayer) -> u32 {
        self.numbers.clear();
        self.enter(player)
    }

    fn events_of(&self, player: &ProtocolPlayer) -> Vec<PlayerMove> {
        let (state, mut events) = (player.coordination.state(), Vec::new());
        // Limits, not when something is sent once more: copies of it may come at any time anyway.
        if player.coordination.next_deadline().is_some_and(|at| at > player.now && at < player.now + RESENT) {
            events.push(PlayerMove::Time);
        }
        // Whether an answer is taken does not depend on its content.
        if alarm_of(player).is_some() {
            events.push(PlayerMove::Answer);
        }
        if player.alarmed.is_empty() && player.firing.is_some_and(|id| state.firing(id).is_some()) {
            events.push(PlayerMove::Alarm);
        }
        events.push(PlayerMove::Restart);
        if player.starts == 1
            && player.firing.is_none_or(|id| state.firing(id).is_none_or(|of| of.phase != ActivityPhase::Running))
        {
            let (mut asked, mut copy) = (StartableModes::default(), player.coordination.clone());
            copy.reconsider();
            copy.step(player.now, &[], &mut asked, &mut PlayerOutbox::default());
            let table = state.table();
            let ours =
                |mode: &ModeId| table.activity(*mode).orders.iter().any(|order| self.stations.contains(&order.station));
            events.extend(asked.0.into_iter().filter(ours).map(PlayerMove::Start));
        }
        events
    }

    /// Result of an event in a situation.
    pub fn step(
        &mut self,
        from: u32,
        event: PlayerMove,
        said: impl FnOnce(u32, u32) -> (StationId, StationAnswer),
    ) -> &Stepped {
        if !self.stepped.contains_key(&(from, event)) {
            let stepped = self.work_out(from, event, said);
            self.stepped.insert((from, event), stepped);
        }
        &self.stepped[&(from, event)]
    }

    fn work_out(
        &mut self,
        from: u32,
        event: PlayerMove,
        said: impl FnOnce(u32, u32) -> (StationId, StationAnswer),
    ) -> Stepped {
        let mut next = self.all[from as usize].clone();
        let (mut out, mut wanted) = (PlayerOutbox::default(), SingleStart(None));
        let starts = PlayerInput::Starts(true);
        match event {
            PlayerMove::Heard(nth, number) => {
                let (station, said) = said(nth, number);
                let mut inputs = vec![starts, PlayerInput::Station(station, &said.heard)];
                inputs.extend(said.secured.map(|(key, way, reply)| PlayerInput::Secured(station, key, way, reply)));
                let refused =
                    said.refused.iter().map(|&(key, why)| PlayerInput::Reply(station, key, TaskReply::Refused(why)));
                inputs.extend(refused);
                next.coordination.step(next.now, &inputs, &mut wanted, &mut out);
            }
            PlayerMove::Time => {
                next.now = next.coordination.next_deadline().unwrap_or(next.now).max(next.now);
                next.coordination.step(next.now, &[starts], &mut wanted, &mut out);
            }
            PlayerMove::Answer => {
                if let Some(alarm) = alarm_of(&next).cloned() {
                    let input = PlayerInput::Answer { alarm: alarm.id, word: &alarm.words[0] };
                    next.coordination.step(next.now, &[starts, input], &mut wanted, &mut out);
                }
            }
            PlayerMove::Alarm => {
                let state = next.coordination.state();
                let firing = next.firing.and_then(|id| state.firing(id));
                next.alarmed = firing.iter().flat_map(|firing| &firing.orders).map(|order| order.key).collect();
                let mode = firing.map(|firing| firing.mode);
                let resource = mode.and_then(|mode| state.table().handling().mode(mode).resources().next());
                if let Some(resource) = resource {
                    let input = PlayerInput::Alarm { resource, text: "alarm" };
                    next.coordination.step(next.now, &[starts, input], &mut wanted, &mut out);
                }
            }
            PlayerMove::Restart => {
                let state = next.coordination.state().clone();
                let epoch = state.epoch() + 1;
                if let Ok(life) = Coordination::begin(state, next.now, epoch, &mut out) {
                    next.coordination = life.with_rules(self.rules);
                    next.coordination.step(next.now, &[starts], &mut wanted, &mut out);
                }
            }
            PlayerMove::Start(mode) => {
                wanted.0 = Some(mode);
                next.coordination.reconsider();
                next.coordination.step(next.now, &[starts], &mut wanted, &mut out);
            }
        }
        let mut stepped = self.must_stand(from, &out, &next.alarmed);
        next.starts +=
            out.records.iter().filter(|record| matches!(record.fact, RecordKind::Started { .. })).count() as u8;
        for send in out.sends {
            let message = match send {
                CellMessage::Order(mut message) => {
                    message.order.limit = Duration::ZERO;
                    StationMessage::Order(message)
                }
                CellMessage::Secure { station, key, way } => {
                    StationMessage::Secure { station, key, way, alarmed: next.alarmed.contains(&key) }
                }
            };
            if !self.stations.contains(&message.station()) {
                continue;
            }
            let known = self.messages.iter().position(|known| *known == message);
            let number = known.unwrap_or_else(|| {
                self.messages.push(message);
                self.messages.len() - 1
            });
            stepped.sends.push(number as u32);
        }
        stepped.to = self.enter(next);
        stepped
    }

    /// Standstills that its records require of stations. Left out are stations recorded as unknown.
    fn must_stand(&self, from: u32, out: &PlayerOutbox, alarmed: &[OrderKey]) -> Stepped {
        let mut stepped = Stepped::default();
        let mut state = self.all[from as usize].coordination.state().clone();
        for record in &out.records {
            let reason = match &record.fact {
                RecordKind::Exception(ExceptionStep::Answered { firing, .. }) => Some((StandReason::Answered, *firing)),
                RecordKind::Exception(ExceptionStep::Closed { firing, .. }) => Some((StandReason::Restored, *firing)),
                RecordKind::Exception(ExceptionStep::Alarmed { about: AlarmSubject::Firing(firing), .. })
                    if !alarmed.is_empty() =>
                {
                    Some((StandReason::Asked, *firing))
                }
                _ => None,
            };
            if let Some((reason, id)) = reason {
                let orders = state.firing(id).map(|firing| firing.orders.clone()).unwrap_or_default();
                let trouble = state.exceptions().trouble(id);
                let unknown = |key| trouble.is_some_and(|of| of.standing.contains(&(key, SecuredState::Unknown)));
                let known = orders.iter().filter(|order| !unknown(order.key));
                stepped.stand.extend(known.map(|order| (reason, order.station, order.key)));
            }
            if let RecordKind::Started { mode, .. } = &record.fact {
                stepped.given.extend(state.table().activity(*mode).orders.iter().map(|order| order.station));
            }
            // It wrote what fits.
            let _ = state.apply(record);
        }
        stepped
    }
}

fn alarm_of(player: &ProtocolPlayer) -> Option<&linewright_coordinator_cell::exception::Alarm> {
    let about = AlarmSubject::Firing(player.firing?);
    player.coordination.state().exceptions().alarms().find(|alarm| alarm.about == about)
}
