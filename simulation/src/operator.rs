//! Actions of people, and faults, on a line.
//!
//! Commands and buttons go by message, like those of a console or a page; held buttons are sent again every refresh
//! period, as long as they are held, and a release a few times, since one message can get lost. Faults act on the
//! mechanisms, the devices and the processes themselves.

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{InputId, OpId, Owner, StationId, Tick};
use linewright_plant::{MotionFault, NestPosition, PartByHand, Rack};
use linewright_station_logic::{ModeOrder, PanelCommand};

use crate::error::StartError;
use crate::field::SimulatedField;
use crate::held_buttons::RELEASES;
use crate::link::{LinkPayload, WholeMessage};
use crate::options::{Network, NetworkChange, SimOptions};
use crate::sim::LineSim;

/// A node's process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeProcess {
    /// A station's.
    Station(StationId),
    /// The coordinator's.
    Coordinator,
}

/// Motions of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionSelection {
    Normal,
    /// The one that undoes it.
    Recovery,
    Both,
}

/// One thing done to a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OperatorAction {
    /// A command at the console.
    Command(ModeCommand),
    /// A panel button goes down (`true`) or up, advance (`true`) or return.
    Panel {
        station: StationId,
        /// Advance rather than return.
        advance: bool,
        /// Down rather than up.
        down: bool,
    },
    /// Exactly these hand-mode buttons are held, a bit each.
    Buttons(u32),
    /// Resume at the console goes down (`true`) or up.
    Resume(bool),
    /// A station's selector: true is manual.
    Selector(StationId, bool),
    /// Motions of an operation fail, or work again (`None`).
    Fail((StationId, OpId), MotionSelection, Option<MotionFault>),
    /// An input of a station, or of the console (`None`), is held on or off, or released.
    Force(Option<StationId>, InputId, Option<bool>),
    /// A part is taken out of a place, or put in.
    Part(PartByHand, NestPosition),
    /// A device, by its place in the description, is unplugged (`true`) or plugged in.
    Device(usize, bool),
    /// A process dies.
    Kill(NodeProcess),
    /// A process is started again, with its journal.
    Restart(NodeProcess),
    /// The same, but its journal is lost.
    RestartEmpty(NodeProcess),
    /// A station's process dies (`true`) at its next change, between its record and everything after it; or it does not.
    DieAtRecord(StationId, bool),
    /// The coordinator's disk takes no record any more (`true`), or takes them again.
    FillDisk(bool),
    /// An operator confirms where a station stands.
    Rejoin(StationId, Option<OpId>),
    /// Another coordinator, which no station follows, orders the emergency stop once.
    ForeignStop,
    /// The operator's screen hangs (`true`): held buttons are not repeated.
    Hang(bool),
    /// Change of the network from now on.
    Network(NetworkChange),
    /// Nothing from one process reaches another any more.
    Cut(NodeProcess, NodeProcess),
    /// Whatever was cut is joined.
    Heal,
}

impl LineSim {
    /// Does something to the line now.
    ///
    /// # Errors
    /// When a process that is to be started does not come up.
    pub fn act(&mut self, action: OperatorAction) -> Result<(), StartError> {
        let text = action.text(self.line());
        self.note(text);
        let now = self.now;
        // The effect takes a moment.
        self.last_event = now;
        match action {
            OperatorAction::Command(command) => self.say_word(self.coordinator_node(), LinkPayload::Command(command)),
            OperatorAction::Panel { station, advance, down } => {
                let changes = if down {
                    self.hands.press(station, advance)
                } else {
                    self.hands.release(station, advance, RELEASES)
                };
                if changes {
                    self.say_panel(station, advance, down);
                }
            }
            OperatorAction::Buttons(held) => {
                self.hands.hold(held, RELEASES);
                self.say_word(self.coordinator_node(), LinkPayload::Buttons(held));
            }
            OperatorAction::Resume(held) => {
                self.hands.resume(held, RELEASES);
                self.say_word(self.coordinator_node(), LinkPayload::Resume(held));
            }
            OperatorAction::Rejoin(station, within) => self.say_word(station.index(), LinkPayload::Rejoin(within)),
            OperatorAction::ForeignStop => self.say_foreign_stop(),
            OperatorAction::Hang(hangs) => self.hangs = hangs,
            OperatorAction::Selector(station, manual) => {
                self.say_word(station.index(), LinkPayload::Panel(PanelCommand::Selector(manual)));
            }
            OperatorAction::Fail(op, way, fault) => {
                if way != MotionSelection::Recovery {
                    self.field.fail(&self.line, now, op, true, fault);
                }
                if way != MotionSelection::Normal {
                    self.field.fail(&self.line, now, op, false, fault);
                }
                self.wake_devices_of(op.0.index());
            }
            OperatorAction::Force(owner, input, value) => {
                let at = owner.map_or(self.coordinator_node(), StationId::index);
                self.field.force(now, at, input, value);
                self.wake_devices_of(at);
            }
            OperatorAction::Part(what, place) => {
                let at = linewright_plant::station_of(&self.line, place.nest).map_or(0, StationId::index);
                self.field.by_hand(now, at, what, place);
                (0..self.stations.len()).for_each(|at| self.wake_devices_of(at));
            }
            OperatorAction::Device(device, unplugged) => {
                if let Some(at) = self.field.unplug(&self.line, now, device, unplugged) {
                    self.wake_field(at);
                }
            }
            OperatorAction::Kill(NodeProcess::Station(station)) => self.kill_station(station.index()),
            OperatorAction::Kill(NodeProcess::Coordinator) => self.kill_coordinator(),
            OperatorAction::Restart(NodeProcess::Station(station)) => self.restart_station(station.index(), true)?,
            OperatorAction::Restart(NodeProcess::Coordinator) => self.restart_coordinator(true),
            OperatorAction::RestartEmpty(NodeProcess::Station(station)) => {
                self.restart_station(station.index(), false)?
            }
            OperatorAction::RestartEmpty(NodeProcess::Coordinator) => self.restart_coordinator(false),
            OperatorAction::DieAtRecord(station, dies) => self.stations[station.index()].dies_at_next_record = dies,
            OperatorAction::FillDisk(full) => self.coordinator.disk_is_full = full,
            OperatorAction::Network(change) => {
                let SimOptions { network, images, .. } = self.options;
                self.set_networks(change.of(network), change.of(images));
            }
            OperatorAction::Cut(from, to) => {
                let (from, to) = (self.node_of(from), self.node_of(to));
                self.links.iter_mut().filter(|link| (link.from, link.to) == (from, to)).for_each(|l| l.is_cut = true);
            }
            OperatorAction::Heal => self.links.iter_mut().for_each(|link| link.is_cut = false),
        }
        Ok(())
    }

    /// Disturbs the devices of an owner, and their mechanisms. Without frames there are none.
    pub fn disturb(&mut self, owner: Owner, what: String, does: impl FnOnce(&mut Rack, Tick)) {
        self.note(what);
        let now = self.now;
        if let SimulatedField::Frames(frames) = &mut self.field {
            let reader = frames.disturb(now, owner, |rack| does(rack, now));
            self.wake_field(reader);
        }
    }

    /// The interface of the line's manager leaves its bus, or comes back to it. Without frames there is none.
    pub fn bus_off(&mut self, off: bool) {
        self.note(format!("the manager's interface is off the bus: {off}"));
        if let SimulatedField::Frames(frames) = &mut self.field {
            frames.turn_off(self.now, off);
            self.wake_field(self.coordinator_node());
        }
    }

    /// Sets the network from now on: for everything but images, and for images.
    pub fn set_networks(&mut self, network: Network, images: Network) {
        (self.options.network, self.options.images) = (network, images);
    }

    fn node_of(&self, process: NodeProcess) -> usize {
        match process {
            NodeProcess::Station(station) => station.index(),
            NodeProcess::Coordinator => self.coordinator_node(),
        }
    }

    /// Something was done to the devices of a station, or of the console at the end.
    fn wake_devices_of(&mut self, at: usize) {
        self.wake_field(self.field.reader_of(at));
    }

    fn say_foreign_stop(&mut self) {
        let order = ModeOrder::of(u64::MAX, 1, ControlMode::EStop, self.line.timing.lease);
        for station in 0..self.stations.len() {
            self.send(self.operator_node(), station, 1, WholeMessage::Order(order));
        }
    }

    /// Reason why an action would change nothing, if so: an error in the scenario.
    pub(crate) fn idle(&self, action: &OperatorAction) -> Option<String> {
        let line = self.line();
        let is_up = |process: NodeProcess| self.is_up(self.node_of(process));
        match *action {
            OperatorAction::Panel { station, advance, down } if down == self.hands.holds(station, advance) => {
                let side = if advance { "advance" } else { "return" };
                let state = if down { "held already" } else { "not held" };
                Some(format!("{side} of {} is {state}", line.station(station).name))
            }
            OperatorAction::Device(device, unplugged) if unplugged == self.field.is_unplugged(device) => Some(format!(
                "{} is {}",
                line.devices[device].name,
                if unplugged { "lost already" } else { "not lost" }
            )),
            OperatorAction::Part(what, place) => {
                let station = linewright_plant::station_of(line, place.nest).unwrap_or(StationId(0));
                let why = self.field.plant_of(station).objection(what, place)?;
                Some(why.text(line, place))
            }
            OperatorAction::Kill(process) if !is_up(process) => Some(format!("{} is down already", process.name(line))),
            OperatorAction::Restart(process) | OperatorAction::RestartEmpty(process) if is_up(process) => {
                Some(format!("{} is up", process.name(line)))
            }
            _ => None,
        }
    }

    fn say_panel(&mut self, station: StationId, advance: bool, down: bool) {
        let command = if advance { PanelCommand::Advance(down) } else { PanelCommand::Retract(down) };
        self.say_word(station.index(), LinkPayload::Panel(command));
    }

    /// Repeats held buttons, and recent releases.
    pub(crate) fn say_held(&mut self) {
        if self.hangs {
            return;
        }
        for (station, advance, down) in self.hands.panel_again() {
            self.say_panel(station, advance, down);
        }
        if let Some(held) = self.hands.buttons_again() {
            self.say_word(self.coordinator_node(), LinkPayload::Buttons(held));
        }
        if let Some(held) = self.hands.resume_again() {
            self.say_word(self.coordinator_node(), LinkPayload::Resume(held));
        }
    }
}

impl OperatorAction {
    /// The action in words.
    pub fn text(&self, line: &linewright_line::Line) -> String {
        let name = |id: StationId| line.station(id).name.as_str();
        match *self {
            OperatorAction::Command(command) => format!("command {}", command.name()),
            OperatorAction::Panel { station, advance, down } => {
                let (side, way) = (if advance { "advance" } else { "return" }, if down { "down" } else { "up" });
                format!("{side} of {} {way}", name(station))
            }
            OperatorAction::Resume(down) => format!("resume {}", if down { "down" } else { "up" }),
            OperatorAction::Buttons(0) => "hand-mode buttons released".to_owned(),
            OperatorAction::Buttons(held) => {
                let buttons = line.buttons.iter().enumerate().filter(|(at, _)| held >> at & 1 == 1);
                format!("{} held", buttons.map(|(_, name)| name.as_str()).collect::<Vec<_>>().join(" and "))
            }
            OperatorAction::Selector(station, manual) => {
                format!("selector of {} to {}", name(station), if manual { "manual" } else { "auto" })
            }
            OperatorAction::Fail((station, op), way, fault) => {
                let undoing = if way == MotionSelection::Recovery { "undoing " } else { "" };
                let what = fault.map_or("works again", fault_text);
                format!("{}: {undoing}{} {what}", name(station), line.operation((station, op)).name)
            }
            OperatorAction::Force(owner, input, value) => {
                let (who, inputs) = match owner {
                    Some(id) => (name(id), &line.station(id).inputs),
                    None => ("console", &line.console.inputs),
                };
                let how = match value {
                    Some(true) => "held on",
                    Some(false) => "held off",
                    None => "let go",
                };
                format!("{who}: {} {how}", inputs[input.index()])
            }
            OperatorAction::Part(what, place) => what.done(line, place),
            OperatorAction::Device(device, unplugged) => {
                format!("{} {}", line.devices[device].name, if unplugged { "lost" } else { "back" })
            }
            OperatorAction::Kill(process) => format!("{} killed", process.name(line)),
            OperatorAction::Restart(process) => format!("{} restarted", process.name(line)),
            OperatorAction::RestartEmpty(process) => format!("{} restarted without its journal", process.name(line)),
            OperatorAction::DieAtRecord(station, true) => format!("{} to die at its next record", name(station)),
            OperatorAction::DieAtRecord(station, false) => format!("{} spared", name(station)),
            OperatorAction::FillDisk(full) => format!("the coordinator's disk is full: {full}"),
            OperatorAction::Rejoin(station, _) => format!("rejoin of {}", name(station)),
            OperatorAction::ForeignStop => "emergency stop of another coordinator".to_owned(),
            OperatorAction::Hang(hangs) => format!("the operator's screen hangs: {hangs}"),
            OperatorAction::Cut(from, to) => format!("nothing from {} reaches {}", from.name(line), to.name(line)),
            OperatorAction::Heal => "every link joined".to_owned(),
            OperatorAction::Network(change) => {
                let delay = change.delay.map(|delay| format!("{delay:?} delay"));
                let jitter = change.jitter.map(|jitter| format!("{jitter:?} jitter"));
                let loss = change.loss_per_mille.map(|loss| format!("{loss} of 1000 lost"));
                let parts: Vec<String> = [delay, jitter, loss].into_iter().flatten().collect();
                format!("network: {}", if parts.is_empty() { "as before".to_owned() } else { parts.join(", ") })
            }
        }
    }
}

impl NodeProcess {
    /// Its node's name.
    pub fn name(self, line: &linewright_line::Line) -> &str {
        match self {
            NodeProcess::Station(id) => &line.station(id).name,
            NodeProcess::Coordinator => "coordinator",
        }
    }
}

fn fault_text(fault: MotionFault) -> &'static str {
    match fault {
        MotionFault::Stick => "jams",
        MotionFault::Slip => "slows down",
        MotionFault::Break => "breaks",
        MotionFault::SlipBack => "slips back",
        MotionFault::Miss => "misses parts",
        MotionFault::Drop => "drops parts",
    }
}
