//! The loop of a cell: messages received go to the token player; its output is written down, sent, and published.
//!
//! It has a thread of its own, because it waits for the disk before every order. The rest of the coordinator (the mode, the
//! console, the gateway to the devices) must not wait for that, and gives this one nothing but whether activities may start.
//! No decision waits for a schedule: those are made on another thread ([`super::planning`]). Should this thread end, the
//! coordinator ends with it; should it stand still, its watchdog ends the process with outputs off.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, Unplayable, compile_cell, follower_beside};
use linewright_coordinator_cell::dispatch::{Reasons, ShortestRoutes};
use linewright_coordinator_cell::exception::{RecoveryPolicy, StationUnavailable};
use linewright_coordinator_cell::schedule::{PlanActualBar, RolloutScheduler};
use linewright_coordinator_cell::{
    CellEvent, CellMessage, Coordination, OldEpoch, PlayerInput, PlayerOutbox, RecordKind, TaskReport,
};
use linewright_fieldbus::Clock;
use linewright_history::Note;
use linewright_line::{InputId, Line, Tick};
use linewright_msgs::{CellState, DispatchOrder, WhyNotResponse};
use linewright_node_shell::{ActionOwner, Forward, RosNode, TopicError, Watchdog, stamp};
use linewright_station_shell::NewestBySequence;
use thiserror::Error;
use tokio::sync::{mpsc, oneshot, watch};

use super::dispatched::DispatchedOrders;
use super::history::{HistoryFeeder, begin};
use super::keeping::CellLogKeeper;
use super::log::{CellLogError, known};
use super::pending_replies::PendingReplies;
use super::planning::CellPlanning;
use super::requests::PlayerMessage;
use super::topics::{CellInbound, CellPublishers, CellTopics, open};
use super::why::why;
use super::wire;
use super::words::{NewestReports, describe};
use crate::situation::{IsolatedStations, LineSituation};

/// Reason why a cell cannot be played, or not any more.
#[derive(Debug, Error)]
pub enum CellError {
    /// Its description cannot be played.
    #[error(transparent)]
    Unplayable(#[from] Unplayable),
    /// Its log cannot be used.
    #[error(transparent)]
    Log(#[from] CellLogError),
    /// A topic is not to be had.
    #[error(transparent)]
    Topic(#[from] TopicError),
    /// Its life would not be a new one.
    #[error(transparent)]
    Epoch(#[from] OldEpoch),
    /// Another coordinator has begun after this one.
    #[error("station {station} reports a newer coordinator epoch ({epoch}); this one stops giving task orders")]
    Superseded {
        /// Station that reports the newer epoch.
        station: String,
        /// The later life.
        epoch: u64,
    },
    /// The operating system gives no thread, or the thread has ended unexpectedly.
    #[error("the cell's thread: {0}")]
    Thread(String),
}

/// Options of a cell.
pub struct CellNodeOptions {
    /// The checked description.
    pub cell: Cell,
    pub line: Line,
    /// Directory of its log; `None`: nothing is kept.
    pub state_dir: Option<PathBuf>,
    /// What its database has to keep; everything if none.
    pub retention: Option<Duration>,
    /// Boot id of the process.
    pub boot_id: u64,
}

/// A cell that is played.
pub struct CellThread {
    situation: watch::Sender<LineSituation>,
    apart: watch::Receiver<IsolatedStations>,
    ended: oneshot::Receiver<CellError>,
    tasks: Vec<Forward>,
}

/// Period of publication of an unchanged state; shortest time between two publications.
const TELL_EVERY: Duration = Duration::from_secs(1);
const TELL_AT_MOST_EVERY: Duration = Duration::from_millis(100);
/// The thread has stood if it is called so late. Shorter than reports are of use, longer than a busy machine holds it up.
const STANDSTILL: Duration = Duration::from_secs(1);

/// Factor on the time that makes a view stale: a station with an order whose state is older than that is lost. Its mode
/// does not wait for that; a process that is started again meanwhile reports itself what has become of its order.
const LOST_AFTER: u32 = 20;

impl CellThread {
    /// Opens everything and begins. Must be called inside a tokio runtime. `last_orders` switches outputs off, before a
    /// process ends whose cell stands still.
    ///
    /// # Errors
    /// When it cannot begin.
    pub fn open(
        options: CellNodeOptions,
        node: &mut RosNode,
        last_orders: impl FnOnce() + Send + 'static,
    ) -> Result<Self, CellError> {
        let CellTopics { says, dispatch, from, tasks } = open(node, &options.line)?;
        let (say, situation) = watch::channel(LineSituation::new(options.line.stations.len()));
        let (tell_apart, apart) = watch::channel(IsolatedStations::default());
        let mut player = CellLoop::new(options, (says, dispatch), from, situation, tell_apart)?;
        // Before any station is received: a station that is stopped is no emergency stop of the line.
        player.tell_apart(false);
        let (end, ended) = oneshot::channel();
        let watchdog = Watchdog::start("the cell's thread", Watchdog::LIMIT);
        watchdog.before_the_end(last_orders);
        let play = move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
            let outcome = match runtime {
                Ok(runtime) => runtime.block_on(player.play(&watchdog)),
                Err(error) => Err(CellError::Thread(error.to_string())),
            };
            if let Err(error) = outcome {
                // There is no receiver where the process is ending anyway.
                let _ = end.send(error);
            }
        };
        let spawned = std::thread::Builder::new().name("cell".to_owned()).spawn(play);
        spawned.map_err(|error| CellError::Thread(error.to_string()))?;
        Ok(CellThread { situation: say, apart, ended, tasks })
    }

    /// Passes the situation of the line, if it has changed.
    pub fn tell(&self, now: &LineSituation) {
        self.situation.send_if_modified(|known| {
            let changed = known != now;
            if changed {
                known.clone_from(now);
            }
            changed
        });
    }

    /// The stations that are not treated like the others.
    pub fn apart(&self) -> watch::Ref<'_, IsolatedStations> {
        self.apart.borrow()
    }

    /// Waits until other stations are apart than before, or for an end that should not be; where there is no cell, for ever.
    pub async fn news(playing: &mut Option<Self>) -> Result<(), CellError> {
        let Some(playing) = playing else { return std::future::pending().await };
        let ended =
            |end: Result<CellError, _>| Err(end.unwrap_or_else(|_| CellError::Thread("it has ended".to_owned())));
        tokio::select! {
            end = &mut playing.ended => ended(end),
            changed = playing.apart.changed() => match changed {
                Ok(()) => Ok(()),
                Err(_) => ended((&mut playing.ended).await),
            },
        }
    }

    /// Whether the middleware has failed.
    pub fn is_cut_off(&self) -> bool {
        self.tasks.iter().any(Forward::is_finished)
    }
}

pub(super) struct CellLoop {
    line: Line,
    /// Fingerprint of the line, which states of stations have to have.
    description: u64,
    ways: ShortestRoutes,
    reasons: Reasons,
    pub(super) coordination: Coordination,
    planning: CellPlanning,
    pub(super) log: Option<CellLogKeeper>,
    /// The database beside the log; none where there is no log.
    chronicle: Option<HistoryFeeder>,
    /// Situation of the line, as last written to the database.
    noted: LineSituation,
    says: CellPublishers,
    from: mpsc::Receiver<CellInbound>,
    situation: watch::Receiver<LineSituation>,
    states: Vec<NewestBySequence>,
    pub(super) reports: NewestReports,
    /// The time when this life began, and by which clock it goes on.
    origin: Tick,
    clock: Clock,
    pub(super) told: Vec<PlayerMessage>,
    pub(super) people: PendingReplies,
    /// Orders that programs follow.
    pub(super) dispatched: DispatchedOrders,
    /// Reasons why stations can do nothing now, from their states; and the inputs that sense their parts.
    unable: Vec<Option<StationUnavailable>>,
    /// The fault text of each station.
    faults: Vec<String>,
    sensors: Vec<Option<InputId>>,
    apart: watch::Sender<IsolatedStations>,
    message: CellState,
    /// Time of the last publication of the state, by the player's time; and whether it has changed since.
    said: Tick,
    changed: bool,
}

impl CellLoop {
    fn new(
        options: CellNodeOptions,
        (says, dispatch): (CellPublishers, ActionOwner<DispatchOrder>),
        from: mpsc::Receiver<CellInbound>,
        situation: watch::Receiver<LineSituation>,
        apart: watch::Sender<IsolatedStations>,
    ) -> Result<Self, CellError> {
        let CellNodeOptions { cell, line, state_dir, retention, boot_id } = options;
        let pace = OrderTiming { repeat_interval: line.timing.stale, grace: line.timing.stale * 2 };
        let mut made = compile_cell(&cell, Some(&line), Supply::Open, pace)?;
        let handling =
            RecoveryPolicy { lost_after: Some(line.timing.stale * LOST_AFTER), ..made.table.handling().clone() };
        made.table = made.table.with_handling(handling);
        let table = Arc::new(made.table.clone());
        let (state, mut log) = known(state_dir.as_deref(), &cell.name, &table)?;
        let kept = log.as_ref().and(state_dir.as_deref());
        let mut chronicle = kept.map(|dir| begin(dir, (&cell, &line, &made), &state, retention));
        let follower = follower_beside(&cell, &made, &state);
        let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        // A clock that was set back does not stop what is timed: time goes on from the newest record.
        let origin = (Tick::ZERO + wall).max(state.now());
        // Stations remember epochs whose log is lost; by whole seconds none begins twice.
        let epoch = (state.epoch() + 1).max(wall.as_secs());
        let mut out = PlayerOutbox::default();
        let coordination = Coordination::begin(state, origin, epoch, &mut out)?;
        if let Some(log) = &mut log {
            log.write(&out)?;
        }
        if let Some(chronicle) = &mut chronicle {
            chronicle.tell(coordination.state(), &out);
        }
        Ok(CellLoop {
            ways: ShortestRoutes::new(&table),
            reasons: Reasons::default(),
            coordination,
            planning: CellPlanning::new(follower, || Box::new(RolloutScheduler::default())),
            log: log.map(|log| CellLogKeeper::new(log, origin)),
            chronicle,
            noted: LineSituation::new(line.stations.len()),
            says,
            from,
            situation,
            states: vec![NewestBySequence::new(line.timing.stale); line.stations.len()],
            reports: NewestReports::new(),
            origin,
            clock: Clock::start(),
            told: Vec::new(),
            people: PendingReplies::default(),
            dispatched: DispatchedOrders::new(dispatch),
            unable: vec![None; line.stations.len()],
            faults: vec![String::new(); line.stations.len()],
            sensors: wire::sensors(&cell, &line),
            apart,
            message: CellState { boot_id, cell: cell.name, ..CellState::default() },
            said: Tick::ZERO,
            changed: true,
            description: line.fingerprint(),
            line,
        })
    }

    pub(super) fn now(&self) -> Tick {
        self.origin + self.clock.now().since(Tick::ZERO)
    }

    async fn play(&mut self, watchdog: &Watchdog) -> Result<(), CellError> {
        loop {
            // At least as often as the state is published.
            watchdog.feed();
            self.act()?;
            let expected = self.deadline().max(self.now());
            let wake = self.clock.instant(Tick::ZERO + expected.since(self.origin));
            tokio::select! {
                news = self.from.recv() => match news {
                    Some(news) => self.take(news),
                    None => return Ok(()),
                },
                changed = self.situation.changed() => {
                    if changed.is_err() {
                        return Ok(());
                    }
                }
                news = self.planning.news() => {
                    let now = self.now();
                    self.planning.take(now, news, &mut self.coordination);
                }
                () = tokio::time::sleep_until(wake) => {}
            }
            // Inputs that have come together are decided together.
            while let Ok(news) = self.from.try_recv() {
                self.take(news);
            }
            if self.now() > expected + STANDSTILL {
                self.stood();
            }
        }
    }

    fn deadline(&self) -> Tick {
        let tell = self.said + if self.changed { TELL_AT_MOST_EVERY } else { TELL_EVERY };
        let log = self.log.as_ref();
        // A cell that decides nothing has no deadlines.
        let next = self.coordination.next_deadline().filter(|_| log.is_none_or(|log| !log.is_halted()));
        next.into_iter().chain(log.and_then(CellLogKeeper::next_deadline)).fold(tell, Tick::min)
    }

    fn take(&mut self, news: CellInbound) {
        match news {
            CellInbound::Heard(station, message) => {
                let (now, known) = (self.now(), self.states.get_mut(station.index()));
                let is_its =
                    message.description == self.description && message.station == self.line.station(station).name;
                // One of another description says nothing about this one: the station counts as not received.
                if is_its && known.is_some_and(|known| known.offer(now, message.boot_id, message.sequence)) {
                    let (unable, sensor) = (self.unable[station.index()], self.sensors[station.index()]);
                    let (heard, refused) = wire::heard(&message, self.line.station(station), unable, sensor);
                    let heard = TaskReport { fault: self.faults[station.index()].clone(), ..heard };
                    let secured = wire::secured(&message, &heard);
                    self.reports.insert(station, (now, heard.clone()));
                    self.told.push(PlayerMessage::State(station, heard));
                    self.told.extend(secured.map(|(key, way, reply)| PlayerMessage::Secured(station, key, way, reply)));
                    self.told.extend(refused.into_iter().map(|(key, reply)| PlayerMessage::Reply(station, key, reply)));
                }
            }
            CellInbound::State(station, message) => {
                if message.description == self.description && message.station == self.line.station(station).name {
                    self.unable[station.index()] = wire::unable(&message);
                    self.faults[station.index()].clone_from(&message.fault);
                    let now = self.now();
                    self.chronicle.iter_mut().for_each(|chronicle| chronicle.fault(now, station, &message.fault));
                }
            }
            CellInbound::Answer(..)
            | CellInbound::Resource(..)
            | CellInbound::Submit(..)
            | CellInbound::Goal(..)
            | CellInbound::Cancel(..)
            | CellInbound::Withdraw(..) => self.request(news),
            CellInbound::Why(about, reply) => {
                let lines = why(&self.ways, &self.reasons, &self.coordination, self.now(), &about);
                let known = lines.is_ok();
                let mut lines = lines.unwrap_or_else(|unknown| vec![unknown]);
                lines.extend(self.log.as_ref().and_then(CellLogKeeper::trouble));
                reply.send(WhyNotResponse { known, lines });
            }
        }
    }

    /// One step: arrivals go in; records are written before anything is sent. While they cannot be there is no step.
    fn act(&mut self) -> Result<(), CellError> {
        let now = self.now();
        let (situation, in_manual) = {
            let situation = self.situation.borrow_and_update();
            (situation.starts, situation.in_manual.clone())
        };
        if let Some(log) = &mut self.log {
            log.make_room(now);
            if let Some(mut out) = log.try_again(now, self.coordination.state()) {
                // What was to be sent has waited for the disk. The step below sends what is still due, with the time that is left.
                out.sends.clear();
                self.perform(now, out)?;
            }
        }
        // While nothing can be written nothing is taken, and nothing is kept for later.
        if let Some(trouble) = self.log.as_ref().filter(|log| log.is_halted()).and_then(CellLogKeeper::trouble) {
            self.drop_arrivals(&trouble);
        }
        let may_start = situation && !self.log.as_ref().is_some_and(|log| log.is_halted() || log.is_short());
        if !self.is_halted() {
            let told = std::mem::take(&mut self.told);
            let mut inputs = vec![PlayerInput::Starts(may_start), PlayerInput::InManual(&in_manual)];
            inputs.extend(told.iter().map(PlayerMessage::input));
            let mut out = PlayerOutbox::default();
            self.coordination.step(now, &inputs, self.planning.dispatcher(), &mut out);
            // Like the line's, a station's emergency stop is in force before it is written down.
            self.tell_apart(true);
            if self.log.as_mut().is_none_or(|log| log.write(now, &mut out)) {
                self.perform(now, out)?;
            }
            self.planning.request(now, self.coordination.state());
        }
        self.follow_goals();
        let is_unattended = self.is_halted();
        self.apart.send_if_modified(|now| std::mem::replace(&mut now.is_unattended, is_unattended) != is_unattended);
        self.changed |= self.message.starting != may_start;
        self.tell(may_start);
        // What a snapshot removes from the log must be in the database; unless there is none, or it could not be written for long.
        let state = self.coordination.state();
        let is_kept = |is_very_long: bool| {
            let chronicle = self.chronicle.as_ref();
            chronicle.is_none_or(|chronicle| chronicle.has(state) || is_very_long && chronicle.is_failing())
        };
        self.log.iter_mut().for_each(|log| log.shorten(now, state, is_kept));
        Ok(())
    }

    fn is_halted(&self) -> bool {
        self.log.as_ref().is_some_and(CellLogKeeper::is_halted)
    }

    /// Sends and publishes what follows from a step that is written down.
    fn perform(&mut self, now: Tick, mut out: PlayerOutbox) -> Result<(), CellError> {
        for send in &out.sends {
            match send {
                CellMessage::Order(order) => self.says.order(order),
                CellMessage::Secure { station, key, way } => self.says.secure(*station, *key, *way),
            }
        }
        self.note(now, &out);
        self.changed |= !out.records.is_empty();
        out.records.iter().for_each(|record| self.reasons.note(record));
        self.people.reply(&self.line, self.coordination.state(), &mut out);
        self.tell_apart(false);
        out.events.into_iter().try_for_each(|event| self.event(event))
    }

    /// Publishes which stations are the cell's affair alone. It follows from the state, which only records change. Before
    /// they are on disk only additional stops are published.
    fn tell_apart(&self, only_stops: bool) {
        let apart = IsolatedStations::of(&self.coordination, &self.line, self.now(), self.is_halted());
        self.apart.send_if_modified(|now| {
            let before = now.clone();
            if !only_stops {
                *now = apart;
            } else if !apart.stopped.is_subset(&now.stopped) {
                now.isolated.extend(&apart.stopped);
                now.stopped.extend(apart.stopped);
            }
            *now != before
        });
    }

    /// Writes to the database, which may fail: the cell goes on.
    fn note(&mut self, now: Tick, out: &PlayerOutbox) {
        let Some(chronicle) = &mut self.chronicle else { return };
        if chronicle.has_resumed() {
            self.noted = self.situation.borrow().opposite();
        }
        chronicle.tell(self.coordination.state(), out);
        for record in &out.records {
            let RecordKind::Started { firing, mode, part, orders: _ } = record.fact else { continue };
            let is_its = |bar: &PlanActualBar| {
                (bar.mode, bar.part, bar.actual.map(|(began, _)| began)) == (mode, part, Some(record.at))
            };
            if let Some((from, to)) = self.planning.follower().bars().find(is_its).and_then(|bar| bar.promised) {
                chronicle.note(record.at, Note::Planned { firing, from, to });
            }
        }
        let situation = self.situation.borrow();
        if *situation != self.noted {
            situation.notes_since(&self.noted).for_each(|note| chronicle.note(now, note));
            self.noted.clone_from(&situation);
        }
    }

    fn event(&self, event: CellEvent) -> Result<(), CellError> {
        match event {
            CellEvent::BadAnswer { question, why } => {
                tracing::error!("dispatch decision {question} not valid: {why}; first come, first served instead");
                Ok(())
            }
            // Sent as a reply.
            CellEvent::Objected { .. } => Ok(()),
            CellEvent::Busy { mode } => {
                let name = self.coordination.state().table().mode_name(mode).to_owned();
                tracing::warn!("too many firings at one time, `{name}` last; check activities without duration");
                Ok(())
            }
            CellEvent::Superseded { by, epoch } => {
                Err(CellError::Superseded { station: self.line.station(by).name.clone(), epoch })
            }
        }
    }

    fn tell(&mut self, may_start: bool) {
        // The time of a decision does not shorten that until the next publication.
        let now = self.now();
        if now < self.said + if self.changed { TELL_AT_MOST_EVERY } else { TELL_EVERY } {
            return;
        }
        (self.said, self.changed) = (now, false);
        describe(&self.line, &self.coordination, &self.reports, may_start, now, &mut self.message);
        self.message.header = stamp();
        self.message.sequence += 1;
        self.says.state.send(self.message.clone());
    }
}
