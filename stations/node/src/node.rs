//! The shell's loop: wait for anything, hand it to the controller, perform what it gives.

use std::path::PathBuf;

use linewright_fieldbus::{BusOpenError as NoBus, Clock};
use linewright_fieldbus_seam::{BusLost, Joined, News};
use linewright_line::{DeviceBus, Line, Owner, StationId, Tick};
use linewright_msgs::{ProcessImage, StationState};
use linewright_node_line::devices::{DeviceDiagnosticsTopic, DeviceServiceRequest, Devices};
use linewright_node_line::quoted;
use linewright_node_line::{Confirmation, HealthTopic, Waiting, open_buses};
use linewright_node_line::{order_from_message, report_from_message};
use linewright_node_shell::{
    ChangeRequest, Forward, JournalError, JournalWriter, Lifecycle, OpenError, Parameters, Participant, Rosout,
    TopicError, Watchdog, fresh_boot_id, stamp,
};
use linewright_parameters::ParameterSet;
use linewright_station_logic::{CompileError, LeaveWay, PanelCommand, Restore};
use linewright_station_shell::parameters::DIAGNOSTICS_PERIOD;
use linewright_station_shell::{Driven, RecentGrowth, StationArrival, StationEffect, StationShell};
use thiserror::Error;
use tokio::sync::{mpsc, watch};

use crate::device_texts::DeviceTexts;
use crate::journal::from_record;
use crate::orders::REFUSED_SENDER;
use crate::topics::{StationInbound, StationPublishers, inputs_from_message, open};

/// Reason why a station's node cannot run, or had to end.
#[derive(Debug, Error)]
pub enum StationNodeError {
    /// The station does not compile.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// ROS 2 is not to be had.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A topic is not to be had.
    #[error(transparent)]
    Topic(#[from] TopicError),
    /// The station's own bus is not to be had.
    #[error(transparent)]
    Bus(#[from] NoBus),
    /// The station's own bus is gone, or another manager's.
    #[error("station {station}: {error}")]
    BusLost {
        station: String,
        /// The loss, and what to do.
        error: BusLost,
    },
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// A subscription has ended; the middleware has failed.
    #[error("{station}: the middleware has failed; see the log")]
    Middleware {
        /// Its name.
        station: String,
    },
}

/// Options of a station's node.
pub struct StationOptions {
    /// The checked description.
    pub line: Line,
    /// The station.
    pub station: StationId,
    /// Directory of the journal; `None`: nothing is kept.
    pub state_dir: Option<PathBuf>,
    /// Options of a bus of the station's own.
    pub bus: linewright_fieldbus::BusOptions,
    /// The process's clock.
    pub clock: Clock,
    /// The parameters, with the values that they are started with.
    pub parameters: ParameterSet,
    /// The node is active at once; otherwise it waits for the transitions configure and activate.
    pub autostart: bool,
}

/// Runs the station until `stop` turns true, then switches its outputs off.
///
/// # Errors
/// When it cannot start, or when the middleware or the journal fails under it. It switches its outputs off on every way
/// out; where none is left, the devices watch the heartbeat of their manager, and the gateway the age of the image.
pub async fn run(
    options: StationOptions,
    participant: &Participant,
    stop: watch::Receiver<bool>,
) -> Result<(), StationNodeError> {
    let watchdog = Watchdog::start_of_node(&options.line.station(options.station).name, Watchdog::LIMIT);
    let mut node = StationLoop::start(options, participant)?;
    if let Some(last) = node.buses.as_ref().map(Joined::last_orders) {
        watchdog.before_the_end(last);
    }
    let outcome = node.work(&watchdog, stop).await;
    node.end();
    outcome
}

pub(crate) async fn next_news(buses: &mut Option<Joined>) -> Result<Vec<News>, BusLost> {
    match buses {
        Some(buses) => buses.next_news().await,
        None => std::future::pending().await,
    }
}

async fn next_asked(devices: &mut Option<Devices>) -> DeviceServiceRequest {
    match devices {
        Some(devices) => devices.next().await,
        None => std::future::pending().await,
    }
}

/// Most messages taken between two steps, so that no flood of them keeps the bus waiting.
const TAKEN_AT_ONCE: usize = 64;

pub(crate) struct StationLoop {
    pub(crate) line: Line,
    pub(crate) station: StationId,
    pub(crate) name: String,
    pub(crate) clock: Clock,
    pub(crate) shell: StationShell,
    /// Effects to be performed, in this order.
    effects: Vec<StationEffect>,
    /// The buses of its own devices; `None` behind the gateway.
    pub(crate) buses: Option<Joined>,
    /// The devices on them, for ROS 2.
    pub(crate) devices: Option<Devices>,
    pub(crate) trouble: Option<DeviceDiagnosticsTopic>,
    pub(crate) words: DeviceTexts,
    pub(crate) journal: Option<JournalWriter>,
    pub(crate) waiting: Waiting<StationInbound>,
    /// Identity of this start of the host.
    pub(crate) host: String,
    pub(crate) says: StationPublishers,
    pub(crate) from: mpsc::Receiver<StationInbound>,
    tasks: Vec<Forward>,
    pub(crate) event_sequence: u64,
    /// State sent last; the next one overwrites all but the fingerprint of the description.
    pub(crate) message: StationState,
    pub(crate) health: HealthTopic,
    rosout: Rosout,
    /// Messages ignored or not sent.
    pub(crate) lost: RecentGrowth,
    has_ended: bool,
    parameters: Parameters,
    pub(crate) lifecycle: Lifecycle,
    /// A request that arrived while a record was being written.
    pub(crate) asked: Option<ChangeRequest>,
    // The node must outlive its publishers and subscriptions.
    _node: linewright_node_shell::RosNode,
}

/// An unplanned end switches the outputs off as well.
impl Drop for StationLoop {
    fn drop(&mut self) {
        self.end();
    }
}

impl StationLoop {
    fn start(options: StationOptions, participant: &Participant) -> Result<Self, StationNodeError> {
        let StationOptions { line, station, state_dir, bus, clock, parameters, autostart } = options;
        let name = line.station(station).name.clone();
        let mut journal = None;
        let mut restore = Restore::Fresh;
        let host = host_start();
        if let Some(dir) = state_dir {
            let path = dir.join(format!("{name}.journal"));
            let (opened, record) = JournalWriter::open(&path)?;
            if let Some(record) = record {
                match from_record(&line, station, &record, &host) {
                    Ok(snapshot) => {
                        let lost = if snapshot.generation == 0 { ", without a generation" } else { "" };
                        tracing::info!(station = name, "continued from its journal{lost}");
                        restore = Restore::From(snapshot);
                    }
                    // Without memory it has no generation, so no other station builds on it, and it on none.
                    Err(error) => tracing::warn!(station = name, "started without its journal: {error}"),
                }
            }
            journal = Some(opened);
        }
        let boot_id = fresh_boot_id();
        let shell = StationShell::new(&line, station, boot_id, restore)?;
        let shell = if autostart { shell } else { shell.unconfigured() };
        let buses = match &line.station(station).bus {
            DeviceBus::Line => None,
            DeviceBus::Own(interface) => {
                let own = line.devices_of(Owner::Station(station));
                let buses = open_buses(own, interface, &bus, line.timing, clock)?;
                tracing::info!(station = name, "devices on {}", buses.describe());
                Some(buses)
            }
        };
        let mut node = participant.node(&format!("/{}", line.name), &name)?;
        let (says, from, tasks) = open(&mut node, &line, station, boot_id, shell.controller().peers())?;
        let own = line.devices_of(Owner::Station(station));
        let rosout = Rosout::open(&mut node)?;
        let health = HealthTopic::open(&mut node, &format!("{}/{name}", line.name))?;
        let of_devices = |_| Devices::open(&mut node, health.publisher(), &line, own);
        let devices = buses.as_ref().map(of_devices).transpose()?;
        let owner = Owner::Station(station);
        let trouble = buses
            .as_ref()
            .map(|_| DeviceDiagnosticsTopic::open(&mut node, "~/trouble", owner, "station"))
            .transpose()?;
        let parameters = Parameters::serve(&mut node, parameters)?;
        let lifecycle = Lifecycle::serve(&mut node)?;
        let message = StationState { description: line.fingerprint(), ..StationState::default() };
        let mut node = StationLoop {
            line,
            station,
            name,
            clock,
            shell,
            effects: Vec::new(),
            buses,
            devices,
            trouble,
            words: DeviceTexts::default(),
            journal,
            waiting: Waiting::default(),
            host,
            says,
            from,
            tasks,
            event_sequence: 0,
            message,
            health,
            rosout,
            lost: RecentGrowth::default(),
            has_ended: false,
            parameters,
            lifecycle,
            asked: None,
            _node: node,
        };
        node.follow_parameters();
        if autostart {
            node.lifecycle.bring_up();
        }
        Ok(node)
    }

    /// Puts the parameters into force that concern the node's loop.
    fn follow_parameters(&mut self) {
        if let Some(every) = self.parameters.seconds(DIAGNOSTICS_PERIOD.name) {
            self.health.report_every(every);
            self.devices.iter_mut().for_each(|devices| devices.report_every(every));
        }
    }

    async fn work(&mut self, watchdog: &Watchdog, mut stop: watch::Receiver<bool>) -> Result<(), StationNodeError> {
        self.act().await?;
        loop {
            watchdog.feed();
            let is_idle = self.waiting.is_empty() && self.asked.is_none();
            let deadline = if is_idle { self.deadline() } else { Tick::ZERO };
            tokio::select! {
                biased;
                changed = stop.changed() => {
                    if changed.is_err() || *stop.borrow() {
                        return Ok(());
                    }
                }
                news = next_news(&mut self.buses) => match news {
                    Ok(news) => {
                        self.waiting.news.extend(news);
                        let news = std::mem::take(&mut self.waiting.news);
                        self.bus_news(&news);
                    }
                    // On another manager's bus nothing is sent, and on one that is gone nothing arrives.
                    Err(error) => return Err(StationNodeError::BusLost { station: self.name.clone(), error }),
                },
                arrived = self.from.recv() => match arrived {
                    Some(arrived) => self.waiting.arrived.push_back(arrived),
                    None => return Err(self.cut_off()),
                },
                asked = next_asked(&mut self.devices) => self.asked(asked),
                () = self.parameters.changed() => self.follow_parameters(),
                asked = self.lifecycle.next(), if self.asked.is_none() => self.asked = Some(asked),
                () = self.clock.sleep_until(Some(deadline)) => {}
                () = tokio::time::sleep(Watchdog::FEED) => {}
            }
            if let Some(news) = self.waiting.take_news() {
                self.bus_news(&news);
            }
            self.waiting.fill(&mut self.from, TAKEN_AT_ONCE);
            // All of it: an emergency stop among it must not wait for another record.
            while let Some(arrived) = self.waiting.arrived.pop_front() {
                self.arrived(arrived);
            }
            // First: what ends activity must not wait for a record, nor anything be switched on before it.
            if let Some(asked) = self.asked.take() {
                self.change(asked).await?;
            }
            self.act().await?;
            let devices_failed = self.devices.as_ref().is_some_and(Devices::is_failed);
            let services_failed = self.parameters.is_failed() || self.lifecycle.is_failed() || self.rosout.is_failed();
            if self.tasks.iter().any(Forward::is_finished) || devices_failed || services_failed {
                return Err(self.cut_off());
            }
        }
    }

    pub(crate) fn cut_off(&self) -> StationNodeError {
        StationNodeError::Middleware { station: self.name.clone() }
    }

    fn deadline(&self) -> Tick {
        let devices = self.devices.as_ref().map_or(Tick::NEVER, Devices::deadline);
        self.shell.next_deadline().min(devices).min(self.health.deadline())
    }

    pub(crate) fn handle(&mut self, arrival: StationArrival<'_>) {
        self.shell.handle(self.clock.now(), arrival, &mut self.effects);
    }

    pub(crate) fn ignore(&mut self, why: impl std::fmt::Display) {
        self.shell.ignore(why, &mut self.effects);
    }

    fn arrived(&mut self, arrived: StationInbound) {
        match arrived {
            StationInbound::Order(message, from) => match order_from_message(&message, (self.station, &self.name)) {
                Ok(order) => self.handle(StationArrival::Order { sequence: message.sequence, from, order }),
                Err(error) => self.ignore(error),
            },
            StationInbound::State(message) => {
                match report_from_message((&self.line, self.message.description), &message) {
                    Ok((station, report)) => {
                        self.handle(StationArrival::State { station, sequence: message.sequence, report: &report });
                    }
                    Err(error) => self.ignore(error),
                }
            }
            StationInbound::Inputs(message) => match inputs_from_message(self.message.description, &message) {
                Ok(inputs) => self.handle(StationArrival::Inputs(inputs)),
                Err(error) => self.ignore(error),
            },
            StationInbound::Trouble(text) => self.words.trouble(&text),
            StationInbound::Selector(text) => match text.trim() {
                "manual" => self.selector(true),
                "auto" => self.selector(false),
                other => self.ignore(format!("selector '{}': expected auto or manual", quoted(other))),
            },
            StationInbound::Goal(asked) if !self.shell.takes_tasks_of(asked.from) => {
                if let Some(orders) = &self.says.orders {
                    orders.refuse_sender(asked);
                }
                self.ignore(format!("task order: {REFUSED_SENDER}"));
            }
            // A stop only takes away: it is obeyed whichever node sends it, as the emergency stop is.
            StationInbound::Secure(_, way, from) if way != LeaveWay::Stop && !self.shell.takes_tasks_of(from) => {
                self.ignore(format!("order to leave a task: {REFUSED_SENDER}"));
            }
            StationInbound::Goal(asked) => {
                if let Some(told) = self.says.orders.as_mut().and_then(|orders| orders.asked(asked)) {
                    self.handle(StationArrival::Task(told.command()));
                }
            }
            StationInbound::Secure(key, way, _) => {
                if let Some(told) = self.says.orders.as_mut().map(|orders| orders.secure(key, way)) {
                    self.handle(StationArrival::Task(told.command()));
                }
            }
            StationInbound::Rejoin(text) => self.rejoin(&text),
            StationInbound::Button { console, command } => self.handle(StationArrival::Panel { console, command }),
        }
    }

    fn rejoin(&mut self, text: &str) {
        match Confirmation::read(self.line.station(self.station), text) {
            Ok(Confirmation { at, numbers }) => self.handle(StationArrival::Rejoin(at, &numbers)),
            Err(error) => self.ignore(format!("rejoin: {error}")),
        }
    }

    fn selector(&mut self, is_manual: bool) {
        // Set by whichever console turns it.
        self.handle(StationArrival::Panel { console: 0, command: PanelCommand::Selector(is_manual) });
    }

    /// Performs the effects of arrivals and of the time.
    ///
    /// # Errors
    /// When the journal cannot be written. A station restarted without its journal would report a past state: better to
    /// end now, with the outputs off.
    pub(crate) async fn act(&mut self) -> Result<(), StationNodeError> {
        let now = self.clock.now();
        if let (Some(devices), Some(buses)) = (&mut self.devices, &self.buses) {
            devices.act(now, buses);
        }
        self.tell_trouble(now);
        let mut effects = std::mem::take(&mut self.effects);
        self.shell.act(now, &mut effects);
        let (mut is_late, mut is_told, mut replies) = (false, false, Vec::new());
        for effect in effects.drain(..) {
            match effect {
                StationEffect::Remember => {
                    self.remember().await?;
                    is_late = !self.shell.remembered(self.clock.now());
                }
                // Decided before a record that took long: the loop goes round and decides again.
                StationEffect::Drive(_) if is_late => {}
                StationEffect::Drive(image) => self.drive(image),
                StationEffect::Tell { sequence } => {
                    is_told = true;
                    self.tell_state(self.clock.now(), sequence);
                }
                StationEffect::Reply(key, reply) => replies.push((key, reply)),
                StationEffect::Happened(event) => self.tell_event(&event),
                StationEffect::Ignored { count, why } => self.tell_ignored(count, &why),
            }
        }
        self.effects = effects;
        if let Some(orders) = &mut self.says.orders {
            let (controller, inputs) = (self.shell.controller(), self.shell.inputs());
            orders.tell(&self.line, controller, replies.into_iter(), inputs, is_told);
        }
        self.tell_health(now);
        Ok(())
    }

    pub(crate) fn drive(&mut self, image: Driven) {
        if let Some(buses) = &mut self.buses {
            buses.set_outputs(Owner::Station(self.station), image.bits);
        }
        if let Some(publisher) = &self.says.outputs {
            let mut message = ProcessImage {
                header: stamp(),
                boot_id: self.shell.boot_id(),
                sequence: image.sequence,
                description: self.message.description,
                valid: true,
                lives: image.lives,
                number: image.number,
                mode_epoch: image.mode_epoch,
                ..ProcessImage::default()
            };
            message.set_word(image.bits);
            publisher.send(message);
        }
    }

    /// Switches the outputs off, on the own bus or by way of the gateway.
    fn end(&mut self) {
        if std::mem::replace(&mut self.has_ended, true) {
            return;
        }
        let off = self.shell.off();
        self.drive(off);
        if let Some(buses) = &mut self.buses {
            buses.release_outputs();
        }
        tracing::info!(station = self.name, "ends");
    }
}

/// Identity of this start of the host, from the kernel; empty where it cannot be read, which matches no record.
fn host_start() -> String {
    let id = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    id.trim().to_owned()
}
