//! The shell's loop: wait for anything, hand it to the logic, perform what it gives.

use std::path::PathBuf;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_coordinator_logic::{Command, Coordinator, Gateway, Heard, InForce, Input, Outbox, OutputImage};
use linewright_fieldbus::{Bus as CanBus, BusError, Clock, Driver, Event as BusEvent, Manager, ManagerError};
use linewright_line::net::ControlMode;
use linewright_line::{Bus, Line, Owner, StationId, Tick};
use linewright_msgs::{LineState, ModeOrder, Text, fitting};
use linewright_node_shell::{
    Forward, Journal, JournalError, NewestBySequence, OpenError, Participant, TopicError, Watchdog, fresh_boot_id,
    stamp,
};
use linewright_station_node::devices::{Devices, in_words};
use linewright_station_node::{mode_to_code, quoted, report_from_message};
use thiserror::Error;
use tokio::sync::{mpsc, watch};

use crate::behind::{Behind, ToldInputs};
use crate::cell::{CellError, CellOptions, Playing, Situation};
use crate::remembered::{Remembered, remembered};
use crate::topics::{Arrived, Says, open};

/// Why the coordinator's node cannot run, or had to end.
#[derive(Debug, Error)]
pub enum NodeError {
    /// ROS 2 is not to be had.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A topic is not to be had.
    #[error(transparent)]
    Topic(#[from] TopicError),
    /// The line's bus is not to be had.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The devices cannot share a bus.
    #[error(transparent)]
    Manager(#[from] ManagerError),
    /// The journal cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The journal holds something else.
    #[error("the coordinator's journal {path} does not hold an epoch; remove it to start afresh")]
    Record {
        /// The journal.
        path: PathBuf,
    },
    /// The cell is not played any more.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A subscription has ended; the middleware has failed.
    #[error("the middleware has failed; see the log")]
    Middleware,
}

/// What the coordinator's node needs.
pub struct Options {
    /// The checked description.
    pub line: Line,
    /// Its cell, if its stations work on order.
    pub cell: Option<Cell>,
    /// The line's bus, by the CAN interface's name.
    pub interface: String,
    /// Where the journal is kept; `None`: nothing is remembered.
    pub state_dir: Option<PathBuf>,
    /// Where the bus is found.
    pub bus: linewright_fieldbus::Options,
    /// The process's clock.
    pub clock: Clock,
}

/// Runs the coordinator until `stop` turns true, then lets go of all outputs.
///
/// # Errors
/// When it cannot start, or when the middleware or the journal fails under it. The line then falls to stand-by by its
/// lease, and the devices on its bus let go of their outputs by their own heartbeat consumers.
pub async fn run(
    options: Options,
    participant: &Participant,
    mut stop: watch::Receiver<bool>,
) -> Result<(), NodeError> {
    let watchdog = Watchdog::start("coordinator", Watchdog::LIMIT);
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
            events = node.driver.next() => node.bus_events(&events),
            asked = node.devices.next() => node.devices.ask(asked, &mut node.driver),
            arrived = node.from.recv() => match arrived {
                Some(arrived) => node.arrived(arrived),
                None => return Err(NodeError::Middleware),
            },
            failed = Playing::failure(&mut node.cell) => return Err(failed.into()),
            () = node.clock.sleep_until(Some(deadline)) => {}
            () = tokio::time::sleep(Watchdog::FEED) => {}
        }
        node.act();
        if let Some(error) = node.failed.take() {
            return Err(error);
        }
        let cut_off = node.cell.as_ref().is_some_and(Playing::is_cut_off);
        if node.tasks.iter().any(Forward::is_finished) || node.devices.is_failed() || cut_off {
            return Err(NodeError::Middleware);
        }
    }
    node.driver.release_outputs();
    tracing::info!("coordinator ends");
    Ok(())
}

/// How soon a refusal may follow another one in what is sent and logged.
const ANSWER_EVERY: Duration = Duration::from_millis(20);
/// How often the mode is told in words when it does not change.
const TEXT_EVERY: Duration = Duration::from_secs(1);

struct Shell {
    line: Line,
    clock: Clock,
    coordinator: Coordinator,
    gateway: Gateway,
    cell: Option<Playing>,
    outbox: Outbox,
    driver: Driver,
    devices: Devices,
    journal: Option<Journal>,
    journaled: Remembered,
    says: Says,
    from: mpsc::Receiver<Arrived>,
    tasks: Vec<Forward>,
    behind: Vec<Behind>,
    /// What is wrong with the devices of stations that have a bus of their own, as they tell it.
    troubles: Vec<String>,
    states: Vec<NewestBySequence>,
    /// Stations that say that they have lost their devices, or were stopped in the middle of something.
    in_trouble: Vec<bool>,
    /// What the cell is told of the line.
    situation: Situation,
    boot_id: u64,
    order_sequence: u64,
    state_sequence: u64,
    image_sequence: u64,
    refusals: u64,
    refusal: String,
    text: String,
    text_due: Tick,
    refresh_due: Tick,
    /// When state and order were last sent.
    told: Tick,
    refusal_log_due: Tick,
    ignored: u64,
    failed: Option<NodeError>,
    // The node must outlive its publishers and subscriptions.
    _node: linewright_node_shell::Node,
}

impl Shell {
    fn start(options: Options, participant: &Participant) -> Result<Self, NodeError> {
        let Options { line, cell, interface, state_dir, bus, clock } = options;
        let (journal, record) = match &state_dir {
            Some(dir) => {
                let path = dir.join("coordinator.journal");
                let (journal, record) = Journal::open(&path)?;
                (Some(journal), record.map(|record| remembered(&record, path)).transpose()?)
            }
            None => (None, None),
        };
        let remembered = record.unwrap_or_default();
        let coordinator = Coordinator::new(line.clone(), remembered.epoch);
        let bus = CanBus::open(&interface, &bus)?;
        tracing::info!("line devices on {}", bus.describe());
        let devices = line.devices.iter().filter(|device| device.bus == Bus::Line);
        let driver = Driver::new(bus, Manager::new(devices, line.timing)?, clock);
        let mut node = participant.node(&format!("/{}", line.name), "coordinator")?;
        let (says, from, tasks) = open(&mut node, &line)?;
        let on_bus = line.devices.iter().filter(|device| device.bus == Bus::Line);
        let devices = Devices::open(&mut node, &line, on_bus)?;
        let mut behind = Vec::new();
        for station in line.station_ids().filter(|&id| line.station(id).bus == Bus::Line) {
            behind.push(Behind::open(&mut node, &line, station)?);
        }
        let boot_id = fresh_boot_id();
        let cell = cell.map(|cell| CellOptions { cell, line: line.clone(), state_dir, boot_id });
        let cell = cell.map(|options| Playing::open(options, &mut node)).transpose()?;
        Ok(Shell {
            cell,
            coordinator: if remembered.estop { coordinator.with_estop() } else { coordinator },
            gateway: Gateway::new(line.stations.len(), line.timing.stale),
            outbox: Outbox::default(),
            driver,
            devices,
            journal,
            journaled: Remembered::default(),
            says,
            from,
            tasks,
            behind,
            troubles: vec![String::new(); line.stations.len()],
            states: line.stations.iter().map(|_| NewestBySequence::new()).collect(),
            in_trouble: vec![false; line.stations.len()],
            situation: Situation::new(line.stations.len()),
            boot_id,
            order_sequence: 0,
            state_sequence: 0,
            image_sequence: 0,
            refusals: 0,
            refusal: String::new(),
            text: String::new(),
            text_due: Tick::ZERO,
            refresh_due: Tick::ZERO,
            told: Tick::ZERO,
            refusal_log_due: Tick::ZERO,
            ignored: 0,
            failed: None,
            clock,
            line,
            _node: node,
        })
    }

    fn deadline(&self) -> Tick {
        let now = self.clock.now();
        [self.coordinator.next_deadline(), self.gateway.next_deadline(now)]
            .into_iter()
            .flatten()
            .fold(self.refresh_due.min(self.devices.deadline()), Tick::min)
    }

    fn ignore(&mut self, why: impl std::fmt::Display) {
        self.ignored += 1;
        if self.ignored.is_power_of_two() {
            tracing::warn!(ignored = self.ignored, "ignored a message: {why}");
        }
    }

    fn arrived(&mut self, arrived: Arrived) {
        let now = self.clock.now();
        match arrived {
            Arrived::Command(word) => match Command::parse(&word) {
                Some(command) => {
                    tracing::info!("operator: {}", command.name());
                    self.coordinator.handle(now, Input::Command(command));
                }
                None => {
                    let known: Vec<&str> = Command::ALL.iter().map(|command| command.name()).collect();
                    self.refuse(format!("'{}' is no command; commands are {}", quoted(word.trim()), known.join(", ")));
                }
            },
            Arrived::Buttons(names) => match self.buttons(&names) {
                Ok(held) => self.coordinator.handle(now, Input::Buttons(held)),
                Err(unknown) => self.refuse(unknown),
            },
            Arrived::State(message) => match report_from_message(&self.line, &message) {
                Ok((station, report)) => {
                    if self.states[station.index()].offer(message.boot_id, message.sequence).is_newest() {
                        self.situation.devices[station.index()] = report.devices_valid;
                        self.in_trouble[station.index()] = !report.incomplete.is_empty() || !report.devices_valid;
                        let heard = Heard {
                            boot_id: report.boot_id,
                            mode_epoch: report.mode_epoch,
                            at_home: report.at_home,
                            round: report.round,
                            stopped: report.stopped,
                            incomplete: !report.incomplete.is_empty(),
                            selector_manual: report.selector_manual,
                            devices_valid: report.devices_valid,
                        };
                        self.coordinator.handle(now, Input::Station(station, heard));
                    }
                }
                Err(error) => self.ignore(error),
            },
            Arrived::Trouble(station, text) => self.troubles[station.index()] = text,
            Arrived::Outputs(station, message) => {
                let Some(behind) = self.behind.iter_mut().find(|b| b.station == station) else { return };
                if behind.newest.offer(message.boot_id, message.sequence).is_newest() {
                    let image = OutputImage {
                        bits: message.word(),
                        valid: message.valid,
                        losses: message.lives,
                        boot_id: message.boot_id,
                        number: message.number,
                    };
                    self.gateway.hear(now, station, image);
                }
            }
        }
    }

    fn buttons(&self, names: &str) -> Result<u32, String> {
        let mut held = 0;
        for name in names.split_whitespace() {
            let index = self.line.buttons.iter().position(|button| button == name);
            let known = || self.line.buttons.join(", ");
            let index = index.ok_or_else(|| format!("'{}' is no button; buttons are {}", quoted(name), known()))?;
            held |= 1 << index;
        }
        Ok(held)
    }

    fn refuse(&mut self, text: String) {
        self.refusals += 1;
        let now = self.clock.now();
        if now >= self.refusal_log_due {
            self.refusal_log_due = now + ANSWER_EVERY;
            tracing::warn!(refusals = self.refusals, "{text}");
        }
        // With many devices lost there is more to say than a message carries.
        self.refusal = fitting(text);
        // Tell it now, but a flood of foolish commands no faster than reliable topics can bear.
        self.refresh_due = self.refresh_due.min(self.told + ANSWER_EVERY);
    }

    fn bus_events(&mut self, events: &[BusEvent]) {
        for event in events {
            match event {
                BusEvent::InputsChanged { .. } | BusEvent::Answered { .. } => {}
                BusEvent::Ignored { reason, frame } => self.ignore(format_args!("frame {frame}: {reason}")),
                other => tracing::info!("{other}"),
            }
        }
        self.devices.bus_events(events, &mut self.driver);
        let image = self.driver.inputs(Owner::Console);
        self.coordinator.handle(self.clock.now(), Input::Console { bits: image.bits, valid: image.valid });
    }

    /// Steps the logic and performs what it gives: the journal first, then outputs, then what is told.
    fn act(&mut self) {
        let now = self.clock.now();
        self.isolate();
        self.coordinator.step(now, &mut self.outbox);
        let changed = std::mem::take(&mut self.outbox.changed);
        if let Err(error) = self.remember() {
            self.failed = Some(error);
            return;
        }
        self.driver.set_outputs(Owner::Console, self.outbox.lamps);
        self.devices.act(now, &self.driver);
        let due = now >= self.refresh_due;
        if due {
            self.refresh_due = now + self.line.timing.refresh;
        }
        self.gate(now, due);
        for mode in std::mem::take(&mut self.outbox.modes) {
            tracing::info!(epoch = self.coordinator.epoch(), "mode {mode}");
        }
        for refusal in std::mem::take(&mut self.outbox.refusals) {
            let text = refusal.text_with(&self.line, |owner| match owner {
                Owner::Station(id) if !self.troubles[id.index()].is_empty() => self.troubles[id.index()].clone(),
                owner => in_words(&self.driver, owner),
            });
            self.refuse(text);
        }
        if let Some(cell) = &self.cell {
            let order = self.coordinator.order();
            let (now, ids) = (&mut self.situation, self.line.station_ids());
            now.starts = order.mode == ControlMode::Auto && order.enabled && order.master_stop.is_none();
            now.mode = order.mode;
            now.heard.iter_mut().zip(ids).for_each(|(heard, id)| *heard = self.coordinator.hears(id));
            cell.tell(now);
        }
        if changed || due {
            self.tell(now);
        }
    }

    /// In a cell trouble of a station on order is an exception of its order, and the others work on: what has come to be one,
    /// and in auto also what is about to, since a station tells of its trouble here and there at once.
    fn isolate(&mut self) {
        let Some(cell) = &self.cell else { return };
        let in_auto = self.coordinator.order().mode == ControlMode::Auto;
        let isolated = cell.isolated();
        let in_trouble = |id: StationId, is_heard: bool| in_auto && (self.in_trouble[id.index()] || !is_heard);
        self.coordinator.isolate(|id, is_heard| isolated.contains(&id) || in_trouble(id, is_heard));
    }

    fn remember(&mut self) -> Result<(), NodeError> {
        let now = Remembered { epoch: self.coordinator.epoch(), estop: self.coordinator.is_estopped() };
        if let Some(journal) = &mut self.journal
            && self.journaled != now
        {
            journal.write(format!("epoch {} {}", now.epoch, if now.estop { "estop" } else { "-" }).as_bytes())?;
            self.journaled = now;
        }
        Ok(())
    }

    /// The gateway: outputs to the bus, inputs to the stations.
    fn gate(&mut self, now: Tick, due: bool) {
        // The emergency stop does not wait for the stations to take their outputs back.
        let stopped = self.coordinator.mode() == ControlMode::EStop;
        for behind in &mut self.behind {
            let station = behind.station;
            // The reason first, so that a station that sees the loss can say why.
            behind.trouble.act(now, &self.driver);
            let image = self.driver.inputs(Owner::Station(station));
            let lives = self.boot_id.wrapping_add(u64::from(image.losses));
            let in_force = if stopped { InForce::default() } else { self.gateway.in_force(now, station, lives) };
            behind.put_out(&mut self.driver, in_force.bits, lives);
            let news = ToldInputs { bits: image.bits, valid: image.valid, lives, under: in_force.image };
            if behind.is_news(news, due)
                && let Some(publisher) = &self.says.inputs[station.index()]
            {
                self.image_sequence += 1;
                publisher.send(news.message(self.boot_id, self.image_sequence));
            }
        }
    }

    fn tell(&mut self, now: Tick) {
        self.told = now;
        let order = self.coordinator.order();
        self.order_sequence += 1;
        self.says.order.send(ModeOrder {
            header: stamp(),
            boot_id: self.boot_id,
            sequence: self.order_sequence,
            epoch: order.epoch,
            mode: mode_to_code(order.mode),
            enabled: order.enabled,
            master_stop: order.master_stop.is_some(),
            stop_round: order.master_stop.unwrap_or(0),
            manual_all: order.manual_all,
            buttons: order.buttons,
            lease_ms: u32::try_from(order.lease.as_millis()).unwrap_or(u32::MAX),
        });
        let text = self.coordinator.text();
        // Latched for readers that ask for it, and repeated for those that do not, as `ros2 topic echo` may not.
        if text != self.text || now >= self.text_due {
            self.text_due = now + TEXT_EVERY;
            self.text.clone_from(&text);
            self.says.mode_text.send(Text { data: text.clone() });
        }
        self.state_sequence += 1;
        let names = |ids: Vec<StationId>| ids.iter().map(|&id| self.line.station(id).name.clone()).collect();
        self.says.state.send(LineState {
            header: stamp(),
            boot_id: self.boot_id,
            sequence: self.state_sequence,
            epoch: order.epoch,
            mode: mode_to_code(order.mode),
            enabled: order.enabled,
            master_stop: order.master_stop.is_some(),
            text,
            refusal: self.refusal.clone(),
            refusals: self.refusals,
            stations: self.line.stations.iter().map(|station| station.name.clone()).collect(),
            station_heard: self
                .line
                .station_ids()
                .map(|id| match (self.coordinator.hears(id), self.states[id.index()].current()) {
                    (true, _) => LineState::HEARD_FRESH,
                    (false, Some(_)) => LineState::HEARD_STALE,
                    (false, None) => LineState::HEARD_UNKNOWN,
                })
                .collect(),
            waiting_for: names(self.coordinator.waiting_for()),
        });
    }
}
