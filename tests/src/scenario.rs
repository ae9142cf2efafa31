//! What a scenario does to a line and what it asks about it.

use std::time::Duration;

use linewright_coordinator_shell::Remembered;
use linewright_fieldbus::NodeId;
use linewright_line::net::{ControlMode, Place};
use linewright_line::{ButtonId, Line, OpId, OutputId, Owner, StationId, Tick, TransferLine, parse};
use linewright_plant::{DeviceFault, Fault, FrameFaults};
use linewright_station_logic::{Controller, ModeOrder, Restore};

use crate::ledger::Ledger;
use crate::network::{Conditions, Message, Node};
use crate::observer::Observer;
use crate::sim::{Process, Sim};
use linewright_simulation::Log;

/// The shipped transfer line with its times multiplied.
pub fn transfer_line(time_scale: f64) -> Line {
    transfer_line_with(1, time_scale)
}

/// A transfer line with several clamps and mills.
pub fn transfer_line_with(machines: usize, time_scale: f64) -> Line {
    let text = TransferLine { machines, time_scale }.text();
    parse("line.toml", &text).unwrap_or_else(|problems| panic!("{problems:?}")).line
}

/// A hand-mode button by name.
pub fn hand_button(line: &Line, name: &str) -> ButtonId {
    let at = line.buttons.iter().position(|button| button == name);
    ButtonId::at(at.unwrap_or_else(|| panic!("no button {name}")))
}

impl Sim {
    /// The shipped line in auto, some milliseconds into the second cycle.
    pub fn in_second_cycle(moment: u64, seed: u64) -> Sim {
        let mut sim = Sim::new(&transfer_line(1.0), seed);
        sim.start_auto();
        sim.run_until_done("clamp_1", "return clamp", 2);
        sim.run_for(Duration::from_millis(moment));
        sim
    }

    /// The line.
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// The present moment.
    pub fn now(&self) -> Tick {
        self.now
    }

    /// What has happened.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// The book-keeping of cycles.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// The one who looks at positions.
    pub fn observer(&self) -> &Observer {
        self.field.observer()
    }

    /// A station's id.
    pub fn id(&self, station: &str) -> StationId {
        self.line.station_named(station).unwrap_or_else(|| panic!("no station {station}"))
    }

    /// An operation's id.
    pub fn op(&self, station: &str, operation: &str) -> (StationId, OpId) {
        let id = self.id(station);
        let op = self.line.station(id).operation_named(operation);
        (id, op.unwrap_or_else(|| panic!("{station} has no {operation}")))
    }

    /// Makes the normal motion of an operation fail.
    pub fn fail(&mut self, station: &str, operation: &str, fault: Fault) {
        let (id, op) = self.op(station, operation);
        self.act(format!("{station}: {operation}: {fault:?}"));
        self.field.fail(self.now, id, op, Some(fault));
        self.wake_field();
    }

    /// Makes the recovery motion of an operation fail, or work again.
    pub fn fail_recovery(&mut self, station: &str, operation: &str, fault: Option<Fault>) {
        let (id, op) = self.op(station, operation);
        self.act(format!("{station}: undoing {operation}: {fault:?}"));
        self.field.fail_recovery(self.now, id, op, fault);
        self.wake_field();
    }

    /// Repairs an operation.
    pub fn repair(&mut self, station: &str, operation: &str) {
        let (id, op) = self.op(station, operation);
        self.act(format!("{station}: {operation} repaired"));
        self.field.fail(self.now, id, op, None);
        self.field.fail_recovery(self.now, id, op, None);
        self.wake_field();
    }

    /// Makes a device fail, or work again.
    pub fn fail_device(&mut self, device: &str, fault: Option<DeviceFault>) {
        let number = self.number_of(device);
        self.act(format!("{device}: {fault:?}"));
        match NodeId::new(number) {
            Some(node) => self.field.fail_device(self.now, node, fault),
            None => self.field.fail_plain(self.now, device, fault),
        }
        self.wake_field();
    }

    /// Makes the line to a device lose and double frames.
    pub fn disturb(&mut self, device: &str, faults: FrameFaults) {
        let node = self.node_of(device);
        self.act(format!("{device}: {faults:?}"));
        self.field.disturb(node, faults);
    }

    /// Holds the output bit of a device that carries this output, or lets it follow process data again.
    pub fn stick(&mut self, device: &str, output: OutputId, value: Option<bool>) {
        let node = self.node_of(device);
        let bits = self.line.devices.iter().find(|d| d.name == device).map(|d| d.outputs.clone()).unwrap_or_default();
        let bit = bits.iter().position(|bound| *bound == Some(output)).unwrap_or_else(|| panic!("no such output"));
        self.act(format!("{device}: output bit {bit} {value:?}"));
        self.field.stick(self.now, node, bit, value);
        self.wake_field();
    }

    /// 0 for a device that speaks no CANopen.
    fn number_of(&self, device: &str) -> u8 {
        let found = self.line.devices.iter().find(|d| d.name == device);
        found.unwrap_or_else(|| panic!("no device {device}")).node_id
    }

    fn node_of(&self, device: &str) -> NodeId {
        NodeId::new(self.number_of(device)).unwrap_or_else(|| panic!("{device} has no node id"))
    }

    /// What the manager of the bus says is wrong with a station's devices; nothing while the coordinator is down.
    pub fn trouble(&self, station: StationId) -> Vec<String> {
        let of = |node: &crate::coordinator::CoordinatorProcess| node.trouble(self.now, Owner::Station(station));
        self.coordinator.as_ref().map(of).unwrap_or_default()
    }

    /// The lives of the coordinator and of every station, 0 for one that is down: whoever was restarted has another.
    pub fn lives(&self) -> Vec<u64> {
        let station = |process: &Process| match process {
            Process::Running(node) => node.boot_id(),
            Process::Killed(_) => 0,
        };
        let coordinator = self.coordinator.as_ref().map_or(0, |node| node.boot_id());
        std::iter::once(coordinator).chain(self.stations.iter().map(station)).collect()
    }

    /// Kills a station's process, now.
    pub fn kill_station(&mut self, station: StationId) {
        self.act(format!("{} killed", self.line.station(station).name));
        if let Process::Running(node) = &self.stations[station.index()] {
            let journal = node.journal.clone();
            self.stations[station.index()] = Process::Killed(journal);
        }
    }

    /// Lets a station's process die at its next change, between its record and everything it would have said.
    pub fn kill_station_at_its_next_record(&mut self, station: StationId) {
        self.act(format!("{} to die at its next record", self.line.station(station).name));
        if let Process::Running(node) = &mut self.stations[station.index()] {
            node.dies_at_next_record = true;
        }
    }

    /// Takes [`Sim::kill_station_at_its_next_record`] back.
    pub fn spare_station(&mut self, station: StationId) {
        if let Process::Running(node) = &mut self.stations[station.index()] {
            node.dies_at_next_record = false;
        }
    }

    /// Whether a station's process runs.
    pub fn is_running(&self, station: StationId) -> bool {
        matches!(self.stations[station.index()], Process::Running(_))
    }

    /// Starts a killed station again without its journal: it remembers nothing, and its mechanisms stand where they stood.
    pub fn restart_station_without_memory(&mut self, station: StationId) {
        self.act(format!("{} restarted without memory", self.line.station(station).name));
        self.ledger.lose(station);
        self.field.lose_parts();
        self.start_station(station, Restore::Fresh);
    }

    /// An operator confirms where a station stands.
    pub fn rejoin(&mut self, station: StationId, within: Option<OpId>) {
        self.act(format!("rejoin of {}", self.line.station(station).name));
        self.say(Node::Operator, Node::Station(station), Message::Rejoin(within));
    }

    /// Starts a killed station again, from its journal.
    pub fn restart_station(&mut self, station: StationId) {
        let Process::Killed(journal) = &self.stations[station.index()] else { return };
        let journal = journal.clone();
        self.act(format!("{} restarted", self.line.station(station).name));
        self.start_station(station, Restore::From(journal));
    }

    /// Kills the coordinator's process, and with it the gateway and the manager of the bus.
    pub fn kill_coordinator(&mut self) {
        self.act("coordinator killed".to_owned());
        if let Some(node) = self.coordinator.take() {
            self.journal = node.journal;
        }
    }

    /// Starts a coordinator that has the journal of the one before, or has lost it.
    pub fn restart_coordinator(&mut self, remembers: bool) {
        if self.coordinator.is_none() {
            self.act(format!("coordinator restarted, remembers its epoch: {remembers}"));
            self.start_coordinator(if remembers { self.journal } else { Remembered::default() });
        }
    }

    /// The coordinator's disk takes no record any more, or takes them again.
    pub fn fill_disk(&mut self, is_full: bool) {
        self.act(format!("the coordinator's disk is full: {is_full}"));
        if let Some(node) = &mut self.coordinator {
            node.disk_is_full = is_full;
        }
    }

    /// A coordinator that nobody follows orders the emergency stop, once.
    pub fn foreign_stop(&mut self) {
        self.act("emergency stop of another coordinator".to_owned());
        let order = ModeOrder::of(u64::MAX, 1, ControlMode::EStop, self.line.timing.lease);
        for id in self.line.clone().station_ids() {
            self.say(Node::Operator, Node::Station(id), Message::Order(1, order));
        }
    }

    /// Cuts everything from one node to another.
    pub fn cut(&mut self, from: Node, to: Node) {
        self.act(format!("cut from {from:?} to {to:?}"));
        self.network.cut(from, to);
    }

    /// Joins every link again.
    pub fn heal(&mut self) {
        self.act("every link joined".to_owned());
        self.network.heal();
    }

    /// What the network does from now on to everything but process images.
    pub fn conditions(&mut self, conditions: Conditions) {
        self.network.conditions = conditions;
    }

    /// What the network does to process images from now on.
    pub fn image_conditions(&mut self, conditions: Conditions) {
        self.network.image_conditions = conditions;
    }

    /// The operator's screen hangs: held buttons are not said again. Or it goes on.
    pub fn freeze_fingers(&mut self, frozen: bool) {
        self.act(format!("screen frozen: {frozen}"));
        self.fingers_frozen = frozen;
    }

    /// The controller of a station that runs.
    pub fn controller(&self, station: StationId) -> Option<&Controller> {
        match &self.stations[station.index()] {
            Process::Running(node) => Some(node.controller()),
            Process::Killed(_) => None,
        }
    }

    /// The marked places of a station; none while it is down.
    pub fn marking(&self, station: StationId) -> Vec<Place> {
        self.controller(station).map(|c| c.marking().collect()).unwrap_or_default()
    }

    /// The mode a station acts on; none while it is down.
    pub fn mode_of(&self, station: StationId) -> Option<ControlMode> {
        self.controller(station).map(Controller::mode)
    }

    /// The mode of the line; none while the coordinator is down.
    pub fn mode(&self) -> Option<ControlMode> {
        self.coordinator.as_ref().map(|node| node.coordinator().mode())
    }

    /// The coordinator's epoch; 0 while it is down.
    pub fn epoch(&self) -> u64 {
        self.coordinator.as_ref().map_or(0, |node| node.coordinator().epoch())
    }

    /// Some operation of a station was stopped before its end.
    pub fn is_incomplete(&self, station: &str) -> bool {
        self.marking(self.id(station)).iter().any(|place| place.is_incomplete())
    }

    /// Nothing of a station is driven: by its own account, and on the wires.
    pub fn is_stopped(&self, station: StationId) -> bool {
        self.controller(station).is_none_or(|c| c.report().stopped) && self.field.energised(station) == 0
    }

    /// The actuators of a station that are energised at its devices, a bit per output.
    pub fn energised(&self, station: StationId) -> u128 {
        self.field.energised(station)
    }

    /// Some actuator of the line is energised.
    pub fn anything_energised(&self) -> bool {
        self.line.station_ids().any(|id| self.field.energised(id) != 0)
    }

    /// Every axis position, in the order of the description.
    pub fn positions(&self) -> Vec<f64> {
        let axes = |id: StationId| (0..self.line.station(id).axes.len()).map(move |a| (id, a));
        let all = self.line.station_ids().flat_map(axes);
        all.map(|(id, axis)| self.field.plant().position(id, linewright_line::AxisId::at(axis))).collect()
    }

    /// The fault that a station announces; empty when there is none, or it is down.
    pub fn fault(&self, station: StationId) -> String {
        self.controller(station).map_or_else(String::new, |controller| controller.fault_text(&self.line))
    }

    /// Why a station waits, in words.
    pub fn blocked_by(&self, station: StationId) -> Vec<String> {
        self.controller(station).map(|c| c.blocked_by(&self.line, self.now)).unwrap_or_default()
    }

    /// Every station at home.
    pub fn all_home(&self) -> bool {
        self.line.station_ids().all(|id| self.controller(id).is_some_and(Controller::is_at_home))
    }

    /// Waits for everything that an operator would: devices, states, orders. A second is long enough for all of them.
    pub fn settle(&mut self) {
        self.run_for(Duration::from_secs(1));
    }

    /// Every station's state in words.
    pub(crate) fn states_text(&self) -> String {
        let station = |id: StationId| match self.controller(id) {
            Some(c) => format!(
                "{}: {} in {}, cycle {}, waits for {:?}\n",
                self.line.station(id).name,
                c.operation_text(&self.line),
                c.mode(),
                c.cycle(),
                c.blocked_by(&self.line, self.now)
            ),
            None => format!("{}: down\n", self.line.station(id).name),
        };
        let mode = self.coordinator.as_ref().map_or("down".to_owned(), |node| node.coordinator().text());
        let positions = self.positions();
        let troubles: Vec<String> = self.line.station_ids().flat_map(|id| self.trouble(id)).collect();
        self.line.station_ids().map(station).collect::<String>()
            + &troubles.iter().map(|said| format!("{said}\n")).collect::<String>()
            + &format!("line: {mode}\naxes stand at {positions:.1?}\n")
    }
}

/// By how much to multiply the seeds of a randomised test: the environment variable `LINEWRIGHT_SOAK`, or 1.
pub fn soak() -> u64 {
    std::env::var("LINEWRIGHT_SOAK").ok().and_then(|times| times.parse().ok()).unwrap_or(1)
}
