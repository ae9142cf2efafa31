//! The shell's loop: wait for anything, hand it to the controller, perform what it gives.

use std::path::PathBuf;
use std::time::Duration;

use linewright_fieldbus::{Bus as CanBus, BusError, Clock, Driver, Event as BusEvent, Manager, ManagerError};
use linewright_line::net::Block;
use linewright_line::{Bus, Line, OpId, Owner, StationId, Tick};
use linewright_msgs::{ModeOrder, ProcessImage, StationEvent, StationState, fitting};
use linewright_node_shell::{
    Forward, Journal, JournalError, NewestBySequence, OpenError, Participant, TopicError, Watchdog, fresh_boot_id,
    stamp,
};
use linewright_station_logic::{
    CompileError, Controller, Event, Happening, Input, ModeOrder as Order, NO_DELAY, Outbox, PanelCommand, Restore,
};
use thiserror::Error;
use tokio::sync::{mpsc, watch};

use crate::convert::{mode_from_code, report_from_message, report_to_message};
use crate::devices::{Asked, Devices, Trouble};
use crate::foreign::quoted;
use crate::journal::{RecordError, from_record, to_record};
use crate::topics::{Arrived, Says, open};
use crate::words::Words;

/// Why a station's node cannot run, or had to end.
#[derive(Debug, Error)]
pub enum NodeError {
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
    Bus(#[from] BusError),
    /// The station's devices cannot share a bus.
    #[error(transparent)]
    Manager(#[from] ManagerError),
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The journal's record cannot be used.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A subscription has ended; the middleware has failed.
    #[error("{station}: the middleware has failed; see the log")]
    Middleware {
        /// The station.
        station: String,
    },
}

/// What a station's node needs.
pub struct Options {
    /// The checked description.
    pub line: Line,
    /// Which station to be.
    pub station: StationId,
    /// Where the journal is kept; `None`: nothing is remembered.
    pub state_dir: Option<PathBuf>,
    /// Where a bus of the station's own is found.
    pub bus: linewright_fieldbus::Options,
    /// The process's clock.
    pub clock: Clock,
}

/// Runs the station until `stop` turns true, then lets go of its outputs.
///
/// # Errors
/// When it cannot start, or when the middleware or the journal fails under it. Its outputs go off by themselves then:
/// the devices watch the heartbeat of whoever drives them, and the gateway the age of the image.
pub async fn run(
    options: Options,
    participant: &Participant,
    mut stop: watch::Receiver<bool>,
) -> Result<(), NodeError> {
    let watchdog = Watchdog::start(&options.line.station(options.station).name, Watchdog::LIMIT);
    let mut node = Shell::start(options, participant)?;
    node.act();
    loop {
        watchdog.feed();
        let deadline = node.deadline();
        tokio::select! {
            biased;
            changed = stop.changed() => {
                if changed.is_err() || *stop.borrow() {
                    break;
                }
            }
            arrived = node.from.recv() => match arrived {
                Some(arrived) => node.arrived(arrived),
                None => return Err(NodeError::Middleware { station: node.name.clone() }),
            },
            events = next_bus_events(&mut node.driver) => node.bus_events(&events),
            asked = next_asked(&mut node.devices) => node.asked(asked),
            () = node.clock.sleep_until(deadline) => {}
            () = tokio::time::sleep(Watchdog::FEED) => {}
        }
        node.act();
        if let Some(error) = node.failed.take() {
            return Err(error);
        }
        if node.tasks.iter().any(Forward::is_finished) || node.devices.as_ref().is_some_and(Devices::is_failed) {
            return Err(NodeError::Middleware { station: node.name.clone() });
        }
    }
    node.end();
    Ok(())
}

async fn next_bus_events(driver: &mut Option<Driver>) -> Vec<BusEvent> {
    match driver {
        Some(driver) => driver.next().await,
        None => std::future::pending().await,
    }
}

async fn next_asked(devices: &mut Option<Devices>) -> Asked {
    match devices {
        Some(devices) => devices.next().await,
        None => std::future::pending().await,
    }
}

struct Shell {
    line: Line,
    station: StationId,
    name: String,
    clock: Clock,
    controller: Controller,
    outbox: Outbox,
    unperformed: bool,
    /// Which outputs were last sent: their number, and the life of the devices.
    driven: Option<(u64, u64)>,
    driver: Option<Driver>,
    /// What ROS 2 sees of the devices on its own bus.
    devices: Option<Devices>,
    trouble: Option<Trouble>,
    words: Words,
    journal: Option<Journal>,
    says: Says,
    from: mpsc::Receiver<Arrived>,
    tasks: Vec<Forward>,
    boot_id: u64,
    state_sequence: u64,
    image_sequence: u64,
    event_sequence: u64,
    orders: NewestBySequence,
    images: NewestBySequence,
    states: Vec<NewestBySequence>,
    /// Changes when the devices are lost: of the input image the controller last saw, told with the outputs.
    lives: u64,
    /// The input image the controller last saw.
    inputs: u128,
    refresh_due: Tick,
    message: StationState,
    ignored: u64,
    failed: Option<NodeError>,
    // The node must outlive its publishers and subscriptions.
    _node: linewright_node_shell::Node,
}

impl Shell {
    fn start(options: Options, participant: &Participant) -> Result<Self, NodeError> {
        let Options { line, station, state_dir, bus, clock } = options;
        let name = line.station(station).name.clone();
        let mut journal = None;
        let mut restore = Restore::Fresh;
        if let Some(dir) = state_dir {
            let path = dir.join(format!("{name}.journal"));
            let (opened, record) = Journal::open(&path)?;
            if let Some(record) = record {
                restore = Restore::From(from_record(&line, station, &record, &path.display().to_string())?);
                tracing::info!(station = name, "goes on from its journal");
            }
            journal = Some(opened);
        }
        let boot_id = fresh_boot_id();
        let controller = Controller::new(&line, station, boot_id, restore)?;
        let driver = match &line.station(station).bus {
            Bus::Line => None,
            Bus::Own(interface) => {
                let bus = CanBus::open(interface, &bus)?;
                tracing::info!(station = name, "devices on {}", bus.describe());
                let manager = Manager::new(line.devices_of(Owner::Station(station)), line.timing)?;
                Some(Driver::new(bus, manager, clock))
            }
        };
        let mut node = participant.node(&format!("/{}", line.name), &name)?;
        let (says, from, tasks) = open(&mut node, &line, station, boot_id, controller.peers())?;
        let own = line.devices_of(Owner::Station(station));
        let devices = driver.as_ref().map(|_| Devices::open(&mut node, &line, own)).transpose()?;
        let owner = Owner::Station(station);
        let trouble = driver.as_ref().map(|_| Trouble::open(&mut node, "~/trouble", owner)).transpose()?;
        let states = line.stations.iter().map(|_| NewestBySequence::new()).collect();
        Ok(Shell {
            line,
            station,
            name,
            clock,
            controller,
            outbox: Outbox::default(),
            unperformed: false,
            driven: None,
            driver,
            devices,
            trouble,
            words: Words::default(),
            journal,
            says,
            from,
            tasks,
            boot_id,
            state_sequence: 0,
            image_sequence: 0,
            event_sequence: 0,
            orders: NewestBySequence::new(),
            images: NewestBySequence::new(),
            states,
            lives: 0,
            inputs: 0,
            refresh_due: Tick::ZERO,
            message: StationState::default(),
            ignored: 0,
            failed: None,
            _node: node,
        })
    }

    fn deadline(&self) -> Option<Tick> {
        let devices = self.devices.as_ref().map_or(Tick::NEVER, Devices::deadline);
        Some(self.controller.next_deadline().unwrap_or(Tick::NEVER).min(self.refresh_due).min(devices))
    }

    fn handle(&mut self, input: Input<'_>) {
        let now = self.clock.now();
        if !self.controller.handle(now, input) {
            self.ignore("it does not apply here");
        }
    }

    /// Counted, and said for the 1st, 2nd, 4th, 8th …: a sender of rubbish must not fill a disk.
    fn ignore(&mut self, why: impl std::fmt::Display) {
        self.ignored += 1;
        if self.ignored.is_power_of_two() {
            tracing::warn!(station = self.name, ignored = self.ignored, "ignored a message: {why}");
            self.event_sequence += 1;
            self.says.event.send(StationEvent {
                header: stamp(),
                station: self.name.clone(),
                sequence: self.event_sequence,
                kind: StationEvent::KIND_IGNORED,
                operation: String::new(),
                cycle: self.controller.cycle(),
                text: format!("ignored {} so far: {why}", self.ignored),
            });
        }
    }

    fn arrived(&mut self, arrived: Arrived) {
        let stale = self.line.timing.stale;
        match arrived {
            Arrived::Order(message) => {
                if self.orders.offer(message.boot_id, message.sequence).is_newest() {
                    match order_from_message(&message) {
                        Ok(order) => self.handle(Input::Order(order)),
                        Err(error) => self.ignore(error),
                    }
                }
            }
            Arrived::State(message) => match report_from_message(&self.line, &message) {
                Ok((station, report)) => {
                    if self.states[station.index()].offer(message.boot_id, message.sequence).is_newest() {
                        self.handle(Input::View(station, &report));
                    }
                }
                Err(error) => self.ignore(error),
            },
            Arrived::Inputs(message) => {
                if self.images.offer(message.boot_id, message.sequence).is_newest() {
                    let until = self.clock.now() + stale;
                    let under = if message.number_boot_id == self.boot_id { message.number } else { 0 };
                    self.image(message.word(), message.valid, message.lives, until, under);
                }
            }
            Arrived::Trouble(text) => self.words.trouble(&text),
            Arrived::Selector(text) => match text.trim() {
                "manual" => self.handle(Input::Panel(PanelCommand::Selector(true))),
                "auto" => self.handle(Input::Panel(PanelCommand::Selector(false))),
                other => self.ignore(format!("selector '{}': expected auto or manual", quoted(other))),
            },
            Arrived::Goal(asked) => {
                if let Some(told) = self.says.orders.as_mut().and_then(|orders| orders.asked(asked)) {
                    self.handle(Input::Task(told.command()));
                }
            }
            Arrived::Secure(key) => {
                if let Some(told) = self.says.orders.as_mut().map(|orders| orders.secure(key)) {
                    self.handle(Input::Task(told.command()));
                }
            }
            Arrived::Advance(held) => self.handle(Input::Panel(PanelCommand::Advance(held))),
            Arrived::Retract(held) => self.handle(Input::Panel(PanelCommand::Retract(held))),
        }
    }

    fn bus_events(&mut self, events: &[BusEvent]) {
        let owner = Owner::Station(self.station);
        for event in events {
            match event {
                BusEvent::InputsChanged { owner: changed } if *changed == owner => {}
                BusEvent::Answered { .. } => {}
                BusEvent::Ignored { reason, frame } => self.ignore(format_args!("frame {frame}: {reason}")),
                other => tracing::info!(station = self.name, "{other}"),
            }
        }
        if let (Some(devices), Some(driver)) = (&mut self.devices, &mut self.driver) {
            devices.bus_events(events, driver);
        }
        self.tell_trouble(self.clock.now());
        if let Some(driver) = &self.driver {
            let image = driver.inputs(owner);
            self.image(image.bits, image.valid, u64::from(image.losses), Tick::NEVER, NO_DELAY);
        }
    }

    /// What is wrong with the devices on its own bus, if it has one.
    fn tell_trouble(&mut self, now: Tick) {
        if let (Some(trouble), Some(driver)) = (&mut self.trouble, &self.driver) {
            trouble.act(now, driver);
            self.words.trouble(trouble.text());
        }
    }

    fn asked(&mut self, asked: Asked) {
        if let (Some(devices), Some(driver)) = (&mut self.devices, &mut self.driver) {
            devices.ask(asked, driver);
        }
    }

    fn image(&mut self, bits: u128, valid: bool, lives: u64, until: Tick, under: u64) {
        if self.lives != lives {
            // A loss shorter than our scan: the devices have started over, so the controller must see it.
            self.lives = lives;
            self.handle(Input::Inputs { bits: 0, valid: false, until: Tick::NEVER, under });
            let now = self.clock.now();
            self.controller.step(now, &mut self.outbox);
            // What this step has changed is performed after the one that follows.
            self.unperformed |= self.outbox.changed;
        }
        self.inputs = bits;
        self.handle(Input::Inputs { bits, valid, until, under });
    }

    /// Steps the controller and performs its outbox: remember, drive, tell.
    fn act(&mut self) {
        let now = self.clock.now();
        self.controller.step(now, &mut self.outbox);
        let changed = std::mem::take(&mut self.outbox.changed) | std::mem::take(&mut self.unperformed);
        if changed && let Some(journal) = &mut self.journal {
            let record = to_record(&self.line, self.station, &self.controller.snapshot());
            if let Err(error) = journal.write(&record) {
                // Without its journal a restarted station would tell a past state. Better to end now, outputs off.
                self.failed = Some(error.into());
                self.drive(0, true);
                return;
            }
        }
        if let (Some(devices), Some(driver)) = (&mut self.devices, &self.driver) {
            devices.act(now, driver);
        }
        self.tell_trouble(now);
        let due = now >= self.refresh_due;
        let outputs = self.outbox.outputs;
        self.drive(outputs, due || self.driven != Some((self.outbox.number, self.lives)));
        if changed || due {
            self.tell_state(now);
        }
        if let Some(orders) = &mut self.says.orders {
            orders.tell(&self.line, &self.controller, self.outbox.replies.drain(..), self.inputs, changed || due);
        }
        if due {
            self.refresh_due = now + self.line.timing.refresh;
        }
        let events: Vec<Event> = self.outbox.events.drain(..).collect();
        for event in events {
            self.tell_event(&event);
        }
    }

    fn drive(&mut self, outputs: u128, send: bool) {
        if !send {
            return;
        }
        self.driven = Some((self.outbox.number, self.lives));
        if let Some(driver) = &mut self.driver {
            driver.set_outputs(Owner::Station(self.station), outputs);
        }
        if let Some(publisher) = &self.says.outputs {
            self.image_sequence += 1;
            let mut image = ProcessImage {
                header: stamp(),
                boot_id: self.boot_id,
                sequence: self.image_sequence,
                valid: true,
                lives: self.lives,
                number: self.outbox.number,
                ..ProcessImage::default()
            };
            image.set_word(outputs);
            publisher.send(image);
        }
    }

    fn tell_state(&mut self, now: Tick) {
        self.state_sequence += 1;
        report_to_message(&self.line, &self.controller, now, &mut self.message);
        let StationState { devices_valid, fault, blocked_by, .. } = &mut self.message;
        self.words.complete(*devices_valid, fault, blocked_by);
        self.message.header = stamp();
        self.message.boot_id = self.boot_id;
        self.message.sequence = self.state_sequence;
        self.says.state.send(self.message.clone());
    }

    fn tell_event(&mut self, event: &Event) {
        let text = self.text_of(event);
        tracing::info!(station = self.name, cycle = event.cycle, "{text}");
        self.event_sequence += 1;
        let (kind, op) = kind_of(event);
        self.says.event.send(StationEvent {
            header: stamp(),
            station: self.name.clone(),
            sequence: self.event_sequence,
            kind,
            operation: op.map(|op| self.line.operation((self.station, op)).name.clone()).unwrap_or_default(),
            cycle: event.cycle,
            text: fitting(text),
        });
    }

    fn text_of(&self, event: &Event) -> String {
        let text = self.words.event(event, self.controller.event_text(&self.line, event));
        if event.what == Happening::Refused {
            // The reasons are those of the state it was refused in, which is still the present one.
            let reasons = self.controller.blocked_by(&self.line, self.clock.now());
            format!("{text}: waits for {}", reasons.join("; "))
        } else {
            text
        }
    }

    fn end(&mut self) {
        self.drive(0, true);
        if let Some(driver) = &mut self.driver {
            driver.release_outputs();
        }
        tracing::info!(station = self.name, "ends");
    }
}

fn order_from_message(message: &ModeOrder) -> Result<Order, crate::ConvertError> {
    Ok(Order {
        boot_id: message.boot_id,
        epoch: message.epoch,
        mode: mode_from_code(message.mode)?,
        enabled: message.enabled,
        master_stop: message.master_stop.then_some(message.stop_round),
        manual_all: message.manual_all,
        buttons: message.buttons,
        lease: Duration::from_millis(message.lease_ms.into()),
    })
}

fn kind_of(event: &Event) -> (u8, Option<OpId>) {
    match event.what {
        Happening::Started(op, Block::Normal) => (StationEvent::KIND_STARTED, Some(op)),
        Happening::Started(op, Block::Recovery) => (StationEvent::KIND_UNDO_STARTED, Some(op)),
        Happening::Completed(op, Block::Normal) => (StationEvent::KIND_COMPLETED, Some(op)),
        Happening::Completed(op, Block::Recovery) => (StationEvent::KIND_UNDONE, Some(op)),
        Happening::Stopped(op, _, cause) if cause.is_fault() => (StationEvent::KIND_FAULT, Some(op)),
        Happening::Stopped(op, _, _) => (StationEvent::KIND_STOPPED, Some(op)),
        Happening::Withdrawn(_) | Happening::HomeAgain | Happening::Asked(_) => (StationEvent::KIND_WITHDRAWN, None),
        Happening::NotAgreed { .. } | Happening::Refused => (StationEvent::KIND_REFUSED, None),
        Happening::Mode(_) => (StationEvent::KIND_MODE, None),
        Happening::Devices(_) => (StationEvent::KIND_DEVICES, None),
        Happening::Ordered(_) | Happening::Securing(_) => (StationEvent::KIND_STARTED, None),
        Happening::OrderDone(_) => (StationEvent::KIND_COMPLETED, None),
        Happening::OrderFailed(..) => (StationEvent::KIND_STOPPED, None),
        Happening::OrderRefused(_) => (StationEvent::KIND_REFUSED, None),
    }
}
