//! `can status`: how each device of a line is, in a sentence, by listening alone.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_canopen::bus_scan::BusScan;
use linewright_canopen::codec::NmtState;
use linewright_canopen::{BusOutbox, MANAGER_NODE, Manager, NodeId};
use linewright_fieldbus::{Bus, Clock};
use linewright_line::{Device, Line, Tick};
use miette::IntoDiagnostic as _;
use serde::Serialize;
use tokio::time::{Instant, timeout_at};

use crate::load;

/// Listen, and say how each device of a line is.
#[derive(Debug, Args)]
pub struct StatusArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// How long to listen, in milliseconds; by default four heartbeats of the description.
    #[arg(long, value_parser = clap::value_parser!(u64).range(10..=60_000))]
    listen: Option<u64>,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct StatusNode {
    /// `None` for a device that speaks no CANopen.
    node: Option<u8>,
    name: Option<String>,
    owner: Option<String>,
    operational: bool,
    is: String,
}

pub async fn run(bus: &mut Bus, interface: &str, args: &StatusArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let plain: Vec<&Device> = line.devices_on(interface).filter(|device| device.frames().is_some()).collect();
    let mut plain = Manager::new(plain, line.timing).into_diagnostic()?;
    let listen = args.listen.map_or_else(|| long_enough(&line, interface), Duration::from_millis);
    let clock = Clock::start();
    let mut survey = BusScan::default();
    let until = Instant::now() + listen;
    while let Ok(frame) = timeout_at(until, bus.recv()).await {
        let frame = frame.into_diagnostic()?;
        survey.hear(clock.now(), &frame);
        // It takes what it hears as the line's own manager does; what it would send is not sent.
        plain.handle(clock.now(), &frame, &mut BusOutbox::default());
    }
    let mut nodes = nodes(&line, interface, &survey, clock.now(), listen);
    nodes.extend(plain.plain_statuses(clock.now()).map(|status| StatusNode {
        node: None,
        name: Some(status.name.to_owned()),
        owner: Some(line.owner_name(status.owner).to_owned()),
        operational: status.live,
        is: status.is,
    }));
    let all_well = nodes.iter().all(|node| node.operational || node.name.is_none());
    if args.json {
        let BusScan { other, bus_errors, .. } = survey;
        let told = serde_json::json!({
            "bus": bus.describe(), "nodes": nodes, "frames_of_no_node": other, "bus_errors": bus_errors, "ok": all_well,
        });
        crate::out::say!("{told}");
    } else {
        table(&nodes, &survey);
    }
    Ok(if all_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Four heartbeats; where devices speak no CANopen, as long as the slowest of their messages may stay away.
fn long_enough(line: &Line, interface: &str) -> Duration {
    let heard = line.devices_on(interface).filter_map(|device| device.frames()?.bound.as_ref());
    let slowest = heard.flat_map(|bound| bound.heard.iter().map(|heard| heard.timeout)).max().unwrap_or_default();
    (line.timing.heartbeat * 4).max(slowest) + Duration::from_millis(50)
}

/// The description's CANopen devices on this bus, then whoever else was heard.
fn nodes(line: &Line, interface: &str, survey: &BusScan, now: Tick, listened: Duration) -> Vec<StatusNode> {
    let canopen = line.devices_on(interface).filter_map(|device| Some((device, device.node_id()?)));
    let described = canopen.map(|(device, node)| {
        let heard = NodeId::new(node).and_then(|node| survey.node(node));
        StatusNode {
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
    let others = survey.heard().filter(|(node, _)| !known(*node)).map(|(node, heard)| StatusNode {
        node: Some(node.get()),
        name: None,
        owner: (node == MANAGER_NODE).then(|| "the manager".to_owned()),
        operational: heard.state == Some(NmtState::Operational),
        is: heard.explain(now),
    });
    described.chain(others).collect()
}

fn table(nodes: &[StatusNode], survey: &BusScan) {
    let name = |node: &StatusNode| match (&node.name, &node.owner) {
        (Some(name), Some(owner)) => format!("{name} ({owner})"),
        (None, Some(owner)) => owner.clone(),
        _ => "not in the description".to_owned(),
    };
    let width = nodes.iter().map(|node| name(node).chars().count()).max().unwrap_or(0);
    for node in nodes {
        let mark = if node.operational {
            "✓"
        } else if node.name.is_some() {
            "✗"
        } else {
            "·"
        };
        let number = node.node.map_or_else(|| "-".to_owned(), |number| number.to_string());
        crate::out::say!("{mark} {number:>3}  {:width$}  {}", name(node), node.is);
    }
    if !nodes.iter().any(|node| node.node == Some(MANAGER_NODE.get())) {
        crate::out::say!("no manager on the bus (node {MANAGER_NODE}): devices are not started");
    }
    if survey.bus_errors > 0 {
        crate::out::say!("the kernel reports {} errors of the bus", survey.bus_errors);
    }
}
