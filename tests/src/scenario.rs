//! Actions of a scenario on a line, and its queries.

use std::time::Duration;

use linewright_canopen::NodeId;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{AxisId, ButtonId, Device, Line, OpId, OutputId, Owner, StationId, TransferLine, parse};
use linewright_plant::{DeviceFault, FrameFaults, MotionFault};
use linewright_simulation::{MotionSelection, Network, NodeProcess, OperatorAction};
use linewright_station_logic::Controller;
use linewright_testkit::cases::cases;

use crate::observer::IndependentObserver;
use crate::sim::WatchedLine;

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

impl WatchedLine {
    /// The shipped line in auto, some milliseconds into the second cycle.
    pub fn in_second_cycle(moment: u64, seed: u64) -> WatchedLine {
        let mut sim = WatchedLine::new(&transfer_line(1.0), seed);
        sim.start_auto();
        sim.run_until_done("clamp_1", "return clamp", 2);
        sim.run_for(Duration::from_millis(moment));
        sim
    }

    /// The observer of positions.
    pub fn observer(&self) -> &IndependentObserver {
        &self.observer
    }

    /// A station's id.
    pub fn id(&self, station: &str) -> StationId {
        self.line().station_named(station).unwrap_or_else(|| panic!("no station {station}"))
    }

    /// An operation's id.
    pub fn op(&self, station: &str, operation: &str) -> (StationId, OpId) {
        let id = self.id(station);
        let op = self.line().station(id).operation_named(operation);
        (id, op.unwrap_or_else(|| panic!("{station} has no {operation}")))
    }

    /// Makes the normal motion of an operation fail.
    pub fn fail(&mut self, station: &str, operation: &str, fault: MotionFault) {
        self.act(OperatorAction::Fail(self.op(station, operation), MotionSelection::Normal, Some(fault)));
    }

    /// Makes the recovery motion of an operation fail, or work again.
    pub fn fail_recovery(&mut self, station: &str, operation: &str, fault: Option<MotionFault>) {
        self.act(OperatorAction::Fail(self.op(station, operation), MotionSelection::Recovery, fault));
    }

    pub fn repair(&mut self, station: &str, operation: &str) {
        self.act(OperatorAction::Fail(self.op(station, operation), MotionSelection::Both, None));
    }

    fn device(&self, name: &str) -> Device {
        let found = self.line().devices.iter().find(|device| device.name == name);
        found.unwrap_or_else(|| panic!("no device {name}")).clone()
    }

    /// Makes a device fail, or work again.
    pub fn fail_device(&mut self, device: &str, fault: Option<DeviceFault>) {
        let device = self.device(device);
        let said = format!("{}: {fault:?}", device.name);
        self.inner().disturb(device.owner, said, |rack, now| rack.fail_device(now, &device, fault));
    }

    /// Makes the line to a device lose and double frames.
    pub fn disturb(&mut self, device: &str, faults: FrameFaults) {
        let device = self.device(device);
        let said = format!("{}: {faults:?}", device.name);
        self.inner().disturb(device.owner, said, |rack, _| rack.disturb(node_of(&device), faults));
    }

    /// Holds the output bit of a device that carries this output, or lets it follow process data again.
    pub fn stick(&mut self, device: &str, output: OutputId, value: Option<bool>) {
        let device = self.device(device);
        let bit = device.output_bits().iter().position(|bound| *bound == Some(output));
        let bit = bit.unwrap_or_else(|| panic!("no such output"));
        let said = format!("{}: output bit {bit} {value:?}", device.name);
        self.inner().disturb(device.owner, said, |rack, _| rack.stick(node_of(&device), bit, value));
    }

    /// The manager's interface leaves the bus, or comes back to it.
    pub fn bus_off(&mut self, off: bool) {
        self.inner().bus_off(off);
    }

    /// Faults of a station's devices, in the words of the bus's manager; empty while the coordinator is down.
    pub fn trouble(&self, station: StationId) -> Vec<String> {
        self.trouble_of(Owner::Station(station))
    }

    /// Kills a station's process, now.
    pub fn kill_station(&mut self, station: StationId) {
        self.act(OperatorAction::Kill(NodeProcess::Station(station)));
    }

    /// Lets a station's process die at its next change, between its record and its messages.
    pub fn kill_station_at_its_next_record(&mut self, station: StationId) {
        self.act(OperatorAction::DieAtRecord(station, true));
    }

    /// Takes [`WatchedLine::kill_station_at_its_next_record`] back.
    pub fn spare_station(&mut self, station: StationId) {
        self.act(OperatorAction::DieAtRecord(station, false));
    }

    /// Whether a station's process runs.
    pub fn is_running(&self, station: StationId) -> bool {
        self.controller(station).is_some()
    }

    /// Starts a killed station again without its journal: it remembers nothing, and its mechanisms stand where they stood.
    pub fn restart_station_without_memory(&mut self, station: StationId) {
        self.observer.lose_parts();
        self.act(OperatorAction::RestartEmpty(NodeProcess::Station(station)));
    }

    /// An operator confirms where a station stands.
    pub fn rejoin(&mut self, station: StationId, within: Option<OpId>) {
        self.act(OperatorAction::Rejoin(station, within));
    }

    /// Starts a killed station again, from its journal.
    pub fn restart_station(&mut self, station: StationId) {
        self.act(OperatorAction::Restart(NodeProcess::Station(station)));
    }

    /// Kills the coordinator's process, and with it the gateway and the manager of the bus.
    pub fn kill_coordinator(&mut self) {
        self.act(OperatorAction::Kill(NodeProcess::Coordinator));
    }

    /// Starts a coordinator that has the journal of the one before, or has lost it.
    pub fn restart_coordinator(&mut self, remembers: bool) {
        let (with, without) = (OperatorAction::Restart, OperatorAction::RestartEmpty);
        self.act(if remembers { with(NodeProcess::Coordinator) } else { without(NodeProcess::Coordinator) });
    }

    /// Cuts everything from one process to another.
    pub fn cut(&mut self, from: NodeProcess, to: NodeProcess) {
        self.act(OperatorAction::Cut(from, to));
    }

    /// Joins every link again.
    pub fn heal(&mut self) {
        self.act(OperatorAction::Heal);
    }

    /// Behaviour of the network from now on: for everything but process images, and for those.
    pub fn networks(&mut self, network: Network, images: Network) {
        self.inner().set_networks(network, images);
    }

    /// The operator's screen hangs: held buttons are not repeated. Or it goes on.
    pub fn freeze_fingers(&mut self, frozen: bool) {
        self.act(OperatorAction::Hang(frozen));
    }

    /// The marked places of a station; none while it is down.
    pub fn marking(&self, station: StationId) -> Vec<StationPlace> {
        self.controller(station).map(|c| c.marking().collect()).unwrap_or_default()
    }

    /// The mode a station acts on; none while it is down.
    pub fn mode_of(&self, station: StationId) -> Option<ControlMode> {
        self.controller(station).map(Controller::mode)
    }

    /// The mode of the line; none while the coordinator is down.
    pub fn mode(&self) -> Option<ControlMode> {
        self.coordinator().map(|coordinator| coordinator.mode())
    }

    /// The coordinator's epoch; 0 while it is down.
    pub fn epoch(&self) -> u64 {
        self.coordinator().map_or(0, |coordinator| coordinator.epoch())
    }

    /// Some operation of a station was stopped before its end.
    pub fn is_incomplete(&self, station: &str) -> bool {
        self.marking(self.id(station)).iter().any(|place| place.is_incomplete())
    }

    /// Nothing of a station is driven: by its own account, and on the wires.
    pub fn is_stopped(&self, station: StationId) -> bool {
        self.controller(station).is_none_or(|c| c.report().stopped) && self.energised(station) == 0
    }

    /// Some actuator of the line is energised.
    pub fn anything_energised(&self) -> bool {
        self.line().station_ids().any(|id| self.energised(id) != 0)
    }

    /// Every axis position, in the order of the description.
    pub fn positions(&self) -> Vec<f64> {
        let axes = |id: StationId| (0..self.line().station(id).axes.len()).map(move |a| (id, a));
        let all = self.line().station_ids().flat_map(axes);
        all.map(|(id, axis)| self.position(id, AxisId::at(axis))).collect()
    }

    /// The fault that a station announces; empty when there is none, or it is down.
    pub fn fault(&self, station: StationId) -> String {
        self.controller(station).map_or_else(String::new, |controller| controller.fault_text(self.line()))
    }

    /// Why a station waits, in words.
    pub fn blocked_by(&self, station: StationId) -> Vec<String> {
        self.controller(station).map(|c| c.blocked_by(self.line(), self.now())).unwrap_or_default()
    }

    /// Every station at home.
    pub fn all_home(&self) -> bool {
        self.line().station_ids().all(|id| self.controller(id).is_some_and(Controller::is_at_home))
    }

    /// To the end of so many cycles of the first mill, all parts before the last one machined once.
    pub fn makes_each_part_once(&mut self, cycles: i32) {
        self.run_until_done("mill_1", "reset main slide", cycles);
        self.machined_each_once(cycles as usize - 1);
    }

    /// Two more parts are made, and each has been machined once; no node was restarted since it had these lives.
    pub fn goes_on(&mut self, lives: &[u64]) {
        let parts = self.observer().places();
        self.run_until("two more parts", |s| s.observer().places() >= parts + 2);
        self.machined_each_once(parts + 1);
        assert_eq!(self.lives(), lives, "nobody was restarted");
    }

    fn machined_each_once(&self, parts: usize) {
        for part in 1..=parts {
            let machined = self.observer().machined(1, part);
            assert_eq!(machined, 1, "part {part} is machined {machined} times");
        }
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
                self.line().station(id).name,
                c.operation_text(self.line()),
                c.mode(),
                c.cycle(),
                c.blocked_by(self.line(), self.now())
            ),
            None => format!("{}: down\n", self.line().station(id).name),
        };
        let mode = self.coordinator().map_or("down".to_owned(), |coordinator| coordinator.text());
        let positions = self.positions();
        let troubles: Vec<String> = self.line().station_ids().flat_map(|id| self.trouble(id)).collect();
        self.line().station_ids().map(station).collect::<String>()
            + &troubles.iter().map(|said| format!("{said}\n")).collect::<String>()
            + &format!("line: {mode}\naxes stand at {positions:.1?}\n")
    }
}

fn node_of(device: &Device) -> NodeId {
    device.node_id().and_then(NodeId::new).unwrap_or_else(|| panic!("{} has no node id", device.name))
}

/// A cycle of the shipped line, in ms.
const CYCLE: u64 = 3560;

/// Moments of a cycle, in ms: `first`, and from there on about every so many, so that the cycle is divided evenly; more or fewer with
/// [`cases`].
pub fn moments(first: u64, every: u64) -> impl Iterator<Item = u64> {
    let step = CYCLE.div_ceil(cases(CYCLE.div_ceil(every)));
    (first % step..CYCLE).step_by(step as usize)
}
