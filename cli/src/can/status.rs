//! `can status`: how each device of a line is, in a sentence, by listening alone.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_canopen::bus_scan::BusScan;
use linewright_canopen::codec::NmtState;
use linewright_canopen::{BusOutbox, MANAGER_NODE, Manager, NodeId};
use linewright_fieldbus::{Bus, Clock};
use linewright_line::{Device, DeviceBus, Line, Tick};
use linewright_node_shell::RosArgs;
use miette::IntoDiagnostic as _;
use serde::Serialize;
use tokio::time::{Instant, timeout_at};

use super::simulated::are_own;
use crate::load;

/// Listen, and say how each device of a line is.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Time to listen, in ms [default: four heartbeat periods of the description].
    #[arg(long, value_parser = clap::value_parser!(u64).range(10..=60_000))]
    listen: Option<u64>,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct StatusNode {
    /// The interface of its bus; `None` for a device that is not on CAN.
    bus: Option<String>,
    /// `None` for a device without CANopen.
    node: Option<u8>,
    name: Option<String>,
    owner: Option<String>,
    operational: bool,
    is: String,
}

/// State of listening on one bus.
struct ListenedBus {
    interface: String,
    bus: Bus,
    survey: BusScan,
    /// Devices without CANopen.
    plain: Manager,
}

impl ListenedBus {
    fn new(interface: &str, bus: Bus, line: &Line) -> miette::Result<Self> {
        let plain: Vec<&Device> = line.devices_on(interface).filter(|device| device.frames().is_some()).collect();
        let plain = Manager::new(plain, line.timing).into_diagnostic()?;
        Ok(ListenedBus { interface: interface.to_owned(), bus, survey: BusScan::default(), plain })
    }

    async fn listen(&mut self, until: Instant, clock: Clock) -> miette::Result<()> {
        while let Ok(frame) = timeout_at(until, self.bus.recv()).await {
            let frame = frame.into_diagnostic()?;
            self.survey.take(clock.now(), &frame);
            // Frames go in as into the line's own manager; its own are not sent.
            self.plain.handle(clock.now(), &frame, &mut BusOutbox::default());
        }
        Ok(())
    }

    /// What is missing on a virtual bus without a manager.
    ///
    /// # Errors
    /// When its devices are another line's.
    async fn without_manager(&mut self, line: &Line, run: &str) -> miette::Result<Option<String>> {
        if self.survey.node(MANAGER_NODE).is_some() {
            return Ok(None);
        }
        if self.survey.nodes().next().is_none() {
            return Ok(Some(format!(
                "nothing was received on {}: neither plant nor coordinator of {run} is there; one that was started with another \
                 LINEWRIGHT_BUS_DIR or in another ROS domain has other buses",
                self.bus.describe()
            )));
        }
        let heard = |device: &&Device| {
            device.node_id().and_then(NodeId::new).is_some_and(|node| self.survey.node(node).is_some())
        };
        let first = line.devices_on(&self.interface).find(heard);
        if let Some(device) = first {
            are_own(&mut self.bus, device, (&line.name, run)).await?;
        }
        Ok(None)
    }

    fn nodes(&self, line: &Line, now: Tick, listened: Duration) -> Vec<StatusNode> {
        let plain = self.plain.plain_statuses(now).map(|status| StatusNode {
            bus: Some(self.interface.clone()),
            node: None,
            name: Some(status.name.to_owned()),
            owner: Some(line.owner_name(status.owner).to_owned()),
            operational: status.live,
            is: status.is,
        });
        nodes(line, &self.interface, &self.survey, now, listened).into_iter().chain(plain).collect()
    }
}

/// `bus` names the line's, if that was named; stations' own buses are opened by their names.
pub async fn run(bus: Option<&str>, args: &StatusArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let interface = &*super::line_bus(bus, Some(&line), ros);
    let of_run = super::run_of(&line, ros)?;
    let bus = super::open(interface, Some(&of_run))?;
    let mut buses = vec![ListenedBus::new(interface, bus, &line)?];
    let mut nodes = Vec::new();
    for own in own_buses(&line, interface) {
        match super::open(own, Some(&of_run)) {
            Ok(bus) => buses.push(ListenedBus::new(own, bus, &line)?),
            Err(error) => nodes.extend(line.devices_on(own).map(|device| not_asked(&line, device, &error.to_string()))),
        }
    }
    let listen = args.listen.map_or_else(|| long_enough(&line), Duration::from_millis);
    let (clock, until) = (Clock::start(), Instant::now() + listen);
    futures::future::try_join_all(buses.iter_mut().map(|bus| bus.listen(until, clock))).await?;
    let mut notes = Vec::new();
    for listened in buses.iter_mut().filter(|listened| listened.bus.is_virtual()) {
        notes.extend(listened.without_manager(&line, &of_run).await?);
    }
    let heard = buses.iter().flat_map(|bus| bus.nodes(&line, clock.now(), listen));
    let mut nodes: Vec<StatusNode> = heard.chain(nodes).collect();
    // A device in Modbus counts as one on the line's bus.
    let is_asked =
        |device: &&Device| device.is_on_can() && line.devices_on(interface).any(|asked| asked.name == device.name);
    nodes.extend(line.devices.iter().filter(|device| !is_asked(device)).filter_map(|device| match &device.bus {
        _ if !device.is_on_can() => {
            Some(not_asked(&line, device, "it is not on CAN: see linewright why, and /diagnostics"))
        }
        // `--bus` names a station's own.
        DeviceBus::Line => Some(not_asked(&line, device, "it is on the line's bus; name that by --bus")),
        DeviceBus::Own(_) => None,
    }));
    let all_well = nodes.iter().all(|node| node.operational || node.name.is_none());
    let bus_errors: u64 = buses.iter().map(|bus| bus.survey.bus_errors).sum();
    if args.json {
        let other: u64 = buses.iter().map(|bus| bus.survey.other).sum();
        let describe: Vec<String> = buses.iter().map(|bus| bus.bus.describe()).collect();
        let told = serde_json::json!({
            "bus": describe.join(", "), "nodes": nodes, "frames_of_no_node": other, "bus_errors": bus_errors,
            "notes": notes, "ok": all_well,
        });
        crate::out::say!("{told}");
    } else {
        table(&nodes, buses.iter().map(|bus| bus.interface.as_str()), bus_errors);
        notes.iter().for_each(|note| crate::out::say!("{note}"));
    }
    Ok(if all_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The buses of stations other than this one, each once.
fn own_buses<'a>(line: &'a Line, interface: &str) -> Vec<&'a str> {
    let mut names = Vec::new();
    for device in line.devices.iter().filter(|device| device.is_on_can()) {
        if let DeviceBus::Own(name) = &device.bus
            && name != interface
            && !names.contains(&name.as_str())
        {
            names.push(name);
        }
    }
    names
}

fn not_asked(line: &Line, device: &Device, why: &str) -> StatusNode {
    StatusNode {
        bus: None,
        node: device.node_id(),
        name: Some(device.name.clone()),
        owner: Some(line.owner_name(device.owner).to_owned()),
        operational: false,
        is: format!("not asked: {why}"),
    }
}

/// Four heartbeats; with devices without CANopen, the longest time limit of their messages.
fn long_enough(line: &Line) -> Duration {
    let heard = line.devices.iter().filter_map(|device| device.frames()?.bound.as_ref());
    let slowest = heard.flat_map(|bound| bound.heard.iter().map(|heard| heard.timeout)).max().unwrap_or_default();
    (line.timing.heartbeat * 4).max(slowest) + Duration::from_millis(50)
}

/// The description's CANopen devices on this bus, then other nodes that sent.
fn nodes(line: &Line, interface: &str, survey: &BusScan, now: Tick, listened: Duration) -> Vec<StatusNode> {
    let canopen = line.devices_on(interface).filter_map(|device| Some((device, device.node_id()?)));
    let described = canopen.map(|(device, node)| {
        let heard = NodeId::new(node).and_then(|node| survey.node(node));
        StatusNode {
            bus: Some(interface.to_owned()),
            node: Some(node),
            name: Some(device.name.clone()),
            owner: Some(line.owner_name(device.owner).to_owned()),
            operational: heard.is_some_and(|heard| heard.state == Some(NmtState::Operational)),
            is: heard.map_or_else(
                || format!("no frames in {} ms: check supply, cable and node id", listened.as_millis()),
                |heard| heard.explain(now),
            ),
        }
    });
    let known = |node: NodeId| line.devices_on(interface).any(|device| device.node_id() == Some(node.get()));
    let others = survey.nodes().filter(|(node, _)| !known(*node)).map(|(node, heard)| StatusNode {
        bus: Some(interface.to_owned()),
        node: Some(node.get()),
        name: None,
        owner: (node == MANAGER_NODE).then(|| "the manager".to_owned()),
        operational: heard.state == Some(NmtState::Operational),
        is: heard.explain(now),
    });
    described.chain(others).collect()
}

fn table<'a>(nodes: &[StatusNode], buses: impl Iterator<Item = &'a str>, bus_errors: u64) {
    let name = |node: &StatusNode| match (&node.name, &node.owner) {
        (Some(name), Some(owner)) => format!("{name} ({owner})"),
        (None, Some(owner)) => owner.clone(),
        _ => "not in the description".to_owned(),
    };
    let bus = |node: &StatusNode| node.bus.clone().unwrap_or_else(|| "-".to_owned());
    let widest =
        |text: &dyn Fn(&StatusNode) -> String| nodes.iter().map(|node| text(node).chars().count()).max().unwrap_or(0);
    let (width, bus_width) = (widest(&name), widest(&bus));
    for node in nodes {
        let mark = if node.operational {
            "✓"
        } else if node.name.is_some() {
            "✗"
        } else {
            "·"
        };
        let number = node.node.map_or_else(|| "-".to_owned(), |number| format!("{number:02X}h"));
        crate::out::say!("{mark} {:bus_width$} {number:>3}  {:width$}  {}", bus(node), name(node), node.is);
    }
    for interface in buses {
        let is_here =
            |node: &StatusNode| node.bus.as_deref() == Some(interface) && node.node == Some(MANAGER_NODE.get());
        if !nodes.iter().any(is_here) {
            crate::out::say!(
                "no manager on the bus {interface} (node {MANAGER_NODE}), so devices are not started: the coordinator is missing, or the \
                 station whose bus it is"
            );
        }
    }
    if bus_errors > 0 {
        crate::out::say!("the kernel reports {bus_errors} errors of the bus");
    }
}
