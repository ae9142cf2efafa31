//! The shell's loop: wait for anything, hand it to the logic, perform what it gives.

use std::path::PathBuf;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_coordinator_shell::parameters::{MODE_TEXT_EVERY_S, MODE_TEXT_PERIOD};
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorShell, InputsImage};
use linewright_fieldbus::{BusOpenError as NoBus, Clock};
use linewright_fieldbus_seam::{BusLost, Joined, News};
use linewright_line::{DeviceBus, Line, Owner, StationId, Tick};
use linewright_node_line::devices::Devices;
use linewright_node_line::{HealthTopic, Waiting, open_buses};
use linewright_node_shell::{
    ChangeRequest, Forward, JournalError, JournalWriter, Lifecycle, OpenError, Parameters, Participant, Rosout,
    TopicError, Watchdog, fresh_boot_id,
};
use linewright_parameters::ParameterSet;
use linewright_station_shell::RecentGrowth;
use linewright_station_shell::parameters::DIAGNOSTICS_PERIOD;
use thiserror::Error;
use tokio::sync::{mpsc, watch};

use crate::cell::{CellError, CellNodeOptions, CellThread};
use crate::gateway_topics::{GatewayTopics, inputs_message};
use crate::line::LineHistory;
use crate::mode_services::TakenCommand;
use crate::refusals::Refusals;
use crate::remembered::remembered;
use crate::situation::LineSituation;
use crate::stop_time::StopTime;
use crate::topics::{CoordinatorInbound, CoordinatorPublishers, cycle_time_message, open};

/// Reason why the coordinator's node cannot run, or had to end.
#[derive(Debug, Error)]
pub enum CoordinatorNodeError {
    /// ROS 2 is not to be had.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A topic is not to be had.
    #[error(transparent)]
    Topic(#[from] TopicError),
    /// The line's bus is not to be had.
    #[error(transparent)]
    Bus(#[from] NoBus),
    /// The line's bus is gone, or another manager's.
    #[error("coordinator: {0}")]
    BusLost(#[from] BusLost),
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Another coordinator was there first.
    #[error(
        "second coordinator: one with boot id {0} is active on this line; this one ends. Use another ROS_DOMAIN_ID or \
         namespace, or stop the other one first"
    )]
    Second(u64),
    /// The cell is not played any more.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A subscription has ended; the middleware has failed.
    #[error("the middleware has failed; see the log")]
    Middleware,
}

/// Options of the coordinator's node.
pub struct CoordinatorOptions {
    /// The checked description.
    pub line: Line,
    /// Its cell, if its stations are task-driven.
    pub cell: Option<Cell>,
    /// The line's bus, by the CAN interface's name.
    pub interface: String,
    /// Directory of the journal; `None`: nothing is kept.
    pub state_dir: Option<PathBuf>,
    /// What the database has to keep; everything if none.
    pub retention: Option<Duration>,
    /// Options of the bus.
    pub bus: linewright_fieldbus::BusOptions,
    /// The process's clock.
    pub clock: Clock,
    /// The parameters, with the values that they are started with.
    pub parameters: ParameterSet,
    /// The node is active at once; otherwise it waits for the transitions configure and activate.
    pub autostart: bool,
}

/// Runs the coordinator until `stop` turns true, then switches all outputs off.
///
/// # Errors
/// When it cannot start, or when the middleware or the cell fails under it. It switches all outputs off on every way out.
/// The line then falls to stand-by by its lease; where no way out is left, the devices on its bus switch off by their own
/// heartbeat consumers.
pub async fn run(
    options: CoordinatorOptions,
    participant: &Participant,
    stop: watch::Receiver<bool>,
) -> Result<(), CoordinatorNodeError> {
    let watchdog = Watchdog::start_of_node("coordinator", Watchdog::LIMIT);
    let mut node = CoordinatorLoop::start(options, participant)?;
    watchdog.before_the_end(node.buses.last_orders());
    let outcome = node.work(&watchdog, stop).await;
    node.end();
    outcome
}

/// Outcome of writing a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recorded {
    Yes,
    No,
    /// It is still being written, and there is an emergency stop to obey first.
    Interrupted,
}

/// Fingerprints of what the coordinator was started with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fingerprints {
    /// Of the line alone, which is what stations are started with.
    pub(crate) line: u64,
    /// Of the cell with its line; of the line where there is none.
    pub(crate) whole: u64,
}

impl Fingerprints {
    fn of(line: &Line, cell: Option<&Cell>) -> Self {
        let own = line.fingerprint();
        Fingerprints { line: own, whole: cell.map_or(own, |cell| cell.fingerprint(line)) }
    }
}

pub(crate) struct CoordinatorLoop {
    pub(crate) line: Line,
    pub(crate) descriptions: Fingerprints,
    pub(crate) clock: Clock,
    pub(crate) shell: CoordinatorShell,
    /// Effects to be performed, in this order.
    effects: Vec<CoordinatorEffect>,
    pub(crate) cell: Option<CellThread>,
    pub(crate) buses: Joined,
    devices: Devices,
    pub(crate) journal: Option<JournalWriter>,
    pub(crate) waiting: Waiting<CoordinatorInbound>,
    pub(crate) says: CoordinatorPublishers,
    pub(crate) from: mpsc::Receiver<CoordinatorInbound>,
    tasks: Vec<Forward>,
    pub(crate) behind: Vec<GatewayTopics>,
    /// Diagnostics of the devices of stations that have a bus of their own, as published by them.
    pub(crate) troubles: Vec<String>,
    /// Situation of the line, for the cell or the database.
    pub(crate) situation: LineSituation,
    /// The database of a line; none where there is a cell, or none can be used.
    pub(crate) history: Option<LineHistory>,
    pub(crate) refusals: Refusals,
    /// Commands by services that are not answered yet.
    pub(crate) taken: Vec<TakenCommand>,
    pub(crate) stop_time: StopTime,
    pub(crate) text: String,
    pub(crate) text_due: Tick,
    /// Period of the mode as text while it does not change.
    pub(crate) text_every: Duration,
    pub(crate) ignored: u64,
    pub(crate) health: HealthTopic,
    rosout: Rosout,
    /// Messages ignored or not sent.
    pub(crate) lost: RecentGrowth,
    has_ended: bool,
    parameters: Parameters,
    pub(crate) lifecycle: Lifecycle,
    pub(crate) asked: Option<ChangeRequest>,
    // The node must outlive its publishers and subscriptions.
    _node: linewright_node_shell::RosNode,
}

/// An unplanned end switches the outputs off as well.
impl Drop for CoordinatorLoop {
    fn drop(&mut self) {
        self.end();
    }
}

impl CoordinatorLoop {
    fn start(options: CoordinatorOptions, participant: &Participant) -> Result<Self, CoordinatorNodeError> {
        let CoordinatorOptions { line, cell, interface, state_dir, retention, bus, clock, .. } = options;
        let CoordinatorOptions { parameters, autostart, .. } = options;
        let descriptions = Fingerprints::of(&line, cell.as_ref());
        let (journal, record) = match &state_dir {
            Some(dir) => {
                let path = dir.join("coordinator.journal");
                let (journal, record) = JournalWriter::open_synced(&path)?;
                (Some(journal), record.map(|record| remembered(&record, &path)))
            }
            None => (None, None),
        };
        let on_bus = line.devices.iter().filter(|device| device.bus == DeviceBus::Line);
        let buses = open_buses(on_bus.clone(), &interface, &bus, line.timing, clock)?;
        tracing::info!("line devices on {}", buses.describe());
        let mut node = participant.node(&format!("/{}", line.name), "coordinator")?;
        let (says, from, tasks) = open(&mut node, &line)?;
        let rosout = Rosout::open(&mut node)?;
        let health = HealthTopic::open(&mut node, &line.name)?;
        let devices = Devices::open(&mut node, health.publisher(), &line, on_bus)?;
        let mut behind = Vec::new();
        for station in line.station_ids().filter(|&id| line.station(id).bus == DeviceBus::Line) {
            behind.push(GatewayTopics::open(&mut node, &line, station)?);
        }
        let boot_id = fresh_boot_id();
        let for_line = state_dir.as_deref().filter(|_| cell.is_none());
        let history = for_line.map(|dir| LineHistory::begin(dir, &line, clock.now(), retention));
        let cell = cell.map(|cell| CellNodeOptions { cell, line: line.clone(), state_dir, retention, boot_id });
        let last = buses.last_orders();
        let cell = cell.map(|options| CellThread::open(options, &mut node, last)).transpose()?;
        let parameters = Parameters::serve(&mut node, parameters)?;
        let lifecycle = Lifecycle::serve(&mut node)?;
        let mut node = CoordinatorLoop {
            shell: CoordinatorShell::new(&line, boot_id, record.unwrap_or_default()),
            effects: Vec::new(),
            cell,
            buses,
            devices,
            journal,
            waiting: Waiting::default(),
            says,
            from,
            tasks,
            behind,
            troubles: vec![String::new(); line.stations.len()],
            situation: LineSituation::new(line.stations.len()),
            history,
            refusals: Refusals::default(),
            taken: Vec::new(),
            stop_time: StopTime::default(),
            text: String::new(),
            text_due: Tick::ZERO,
            text_every: Duration::from_secs_f64(MODE_TEXT_EVERY_S),
            ignored: 0,
            health,
            rosout,
            lost: RecentGrowth::default(),
            has_ended: false,
            clock,
            line,
            descriptions,
            parameters,
            lifecycle,
            asked: None,
            _node: node,
        };
        node.follow_parameters();
        node.come_up(autostart);
        Ok(node)
    }

    /// Puts the parameters into force that concern the node's loop.
    fn follow_parameters(&mut self) {
        if let Some(every) = self.parameters.seconds(DIAGNOSTICS_PERIOD.name) {
            self.devices.report_every(every);
            self.health.report_every(every);
        }
        if let Some(every) = self.parameters.seconds(MODE_TEXT_PERIOD.name) {
            self.text_every = every;
            self.text_due = self.text_due.min(self.clock.now() + every);
        }
    }

    async fn work(&mut self, watchdog: &Watchdog, mut stop: watch::Receiver<bool>) -> Result<(), CoordinatorNodeError> {
        self.act().await?;
        loop {
            watchdog.feed();
            let due = self.shell.next_deadline(self.clock.now()).min(self.devices.deadline());
            let due = due.min(self.health.deadline());
            let deadline = if self.waiting.is_empty() && self.asked.is_none() { due } else { Tick::ZERO };
            tokio::select! {
                biased;
                changed = stop.changed() => {
                    if changed.is_err() || *stop.borrow() {
                        return Ok(());
                    }
                }
                // On another manager's bus nothing is sent, and on one that is gone nothing arrives.
                news = self.buses.next_news() => {
                    self.waiting.news.extend(news?);
                    let news = std::mem::take(&mut self.waiting.news);
                    self.bus_news(&news);
                }
                asked = self.devices.next() => self.devices.ask(asked, &mut self.buses),
                arrived = self.from.recv() => match arrived {
                    Some(arrived) => self.waiting.arrived.push_back(arrived),
                    None => return Err(CoordinatorNodeError::Middleware),
                },
                news = CellThread::news(&mut self.cell) => news?,
                () = self.parameters.changed() => self.follow_parameters(),
                asked = self.lifecycle.next(), if self.asked.is_none() => self.asked = Some(asked),
                () = self.clock.sleep_until(Some(deadline)) => {}
                () = tokio::time::sleep(Watchdog::FEED) => {}
            }
            self.take();
            self.act().await?;
            if let Some(asked) = self.asked.take() {
                self.change(asked).await?;
            }
            if let Some(other) = self.shell.gives_way_to(self.clock.now()) {
                return Err(CoordinatorNodeError::Second(other));
            }
            let cut_off = self.cell.as_ref().is_some_and(CellThread::is_cut_off);
            let has_failed = self.devices.is_failed() || self.parameters.is_failed() || self.lifecycle.is_failed();
            let has_failed = has_failed || self.rosout.is_failed();
            if self.tasks.iter().any(Forward::is_finished) || has_failed || cut_off {
                return Err(CoordinatorNodeError::Middleware);
            }
        }
    }

    pub(crate) fn ignore(&mut self, why: impl std::fmt::Display) {
        self.ignored += 1;
        if self.ignored.is_power_of_two() {
            tracing::warn!(ignored = self.ignored, "ignored a message: {why}");
        }
    }

    pub(crate) fn handle(&mut self, arrival: CoordinatorArrival) {
        self.shell.handle(self.clock.now(), arrival);
    }

    pub(crate) fn bus_news(&mut self, news: &[News]) {
        for one in news {
            match one {
                News::InputsChanged { .. } | News::Answered => {}
                News::Ignored(what) => self.ignore(what),
                News::Noted(what) => tracing::info!("{what}"),
            }
        }
        self.devices.bus_news(news, &mut self.buses);
    }

    /// Takes the inputs that the buses have now.
    fn look(&mut self) {
        let image = self.buses.take_inputs(Owner::Console);
        self.handle(CoordinatorArrival::Console { bits: image.bits, valid: image.valid });
        for at in 0..self.behind.len() {
            let station = self.behind[at].station;
            let image = self.buses.take_inputs(Owner::Station(station));
            let (bits, valid, losses) = (image.bits, image.valid, u64::from(image.losses));
            self.handle(CoordinatorArrival::Devices { station, bits, valid, losses });
        }
    }

    /// Performs the effects of arrivals and of the time. After a record that could not be written there is one more:
    /// the emergency stop.
    ///
    /// # Errors
    /// When the bus or the middleware fails while a record is being written.
    pub(crate) async fn act(&mut self) -> Result<(), CoordinatorNodeError> {
        while self.is_interrupted().await? {
            self.take();
        }
        self.answer_commands();
        self.tell_situation(self.clock.now());
        self.tell_health(self.clock.now());
        Ok(())
    }

    /// Acts once. True if an emergency stop has arrived while a record was being written: it comes before the effects
    /// that followed.
    async fn is_interrupted(&mut self) -> Result<bool, CoordinatorNodeError> {
        let now = self.clock.now();
        self.look();
        if let Some(cell) = &self.cell {
            let apart = cell.apart();
            self.shell.plays_cell(apart.isolated.iter().copied(), apart.stopped.iter().copied());
            self.shell.hold(|id| apart.held.contains(&id));
            self.shell.permit_manual(|id| apart.permit(id));
            self.shell.leaves_unattended(apart.is_unattended);
        }
        self.devices.act(now, &self.buses);
        // The reason first, so that a station that sees the loss can report it.
        self.behind.iter_mut().for_each(|behind| behind.trouble.act(now, &self.buses));
        let mut effects = std::mem::take(&mut self.effects);
        self.shell.act(now, &mut effects);
        let mut is_interrupted = false;
        for effect in effects.drain(..) {
            let CoordinatorEffect::Remember(record) = effect else {
                self.perform(now, effect);
                continue;
            };
            let is_written = match self.remember(record).await? {
                Recorded::Yes => true,
                Recorded::No => false,
                Recorded::Interrupted => {
                    is_interrupted = true;
                    self.shell.interrupted(self.clock.now());
                    break;
                }
            };
            // After a record that failed or took long the rest is dropped. It is to act again at once, and takes in first
            // what has waited meanwhile.
            if !self.shell.remembered(self.clock.now(), record, is_written) {
                break;
            }
        }
        self.effects = effects;
        Ok(is_interrupted)
    }

    fn perform(&mut self, now: Tick, effect: CoordinatorEffect) {
        match effect {
            CoordinatorEffect::Refused(refusal) => self.refused(&refusal),
            CoordinatorEffect::Obeyed => self.refusals.end(),
            CoordinatorEffect::Entered(mode) => {
                self.refusals.end();
                tracing::info!(epoch = self.shell.coordinator().epoch(), "mode {mode}");
            }
            // It is awaited where effects are performed in order.
            CoordinatorEffect::Remember(_) => {}
            CoordinatorEffect::Lamps(bits) => self.buses.set_outputs(Owner::Console, bits),
            CoordinatorEffect::Energise(station, bits) => self.buses.set_outputs(Owner::Station(station), bits),
            CoordinatorEffect::Inputs { station, sequence, image } => self.send_inputs(station, sequence, image),
            CoordinatorEffect::Order { sequence } => self.send_order(sequence),
            CoordinatorEffect::Tell { sequence } => self.tell(now, sequence),
            CoordinatorEffect::Completed(cycle) => {
                if let Some(message) = cycle_time_message(cycle) {
                    self.says.cycle_time.send(message);
                }
                self.history.iter_mut().for_each(|history| history.cycle(now, cycle));
            }
        }
    }

    fn send_inputs(&mut self, station: StationId, sequence: u64, image: InputsImage) {
        if let Some(publisher) = &self.says.inputs[station.index()] {
            publisher.send(inputs_message(image, self.shell.boot_id(), sequence, self.descriptions.line));
        }
    }

    /// Switches all outputs off.
    fn end(&mut self) {
        if !std::mem::replace(&mut self.has_ended, true) {
            self.buses.release_outputs();
            tracing::info!("coordinator ends");
            self.history.take().into_iter().for_each(|history| history.end(self.clock.now()));
        }
    }
}
