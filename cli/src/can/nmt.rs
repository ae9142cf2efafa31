//! `can nmt`: an order, and whether the nodes obey.

use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, ValueEnum};
use linewright_canopen::bus_scan::state_name;
use linewright_canopen::codec::{NmtCommand, NmtState};
use linewright_canopen::{CanopenMessage, NodeId};
use linewright_fieldbus::Bus;
use miette::IntoDiagnostic;
use tokio::time::{Instant, timeout_at};

use super::node;

/// Time for a node to show that it has obeyed. Its heartbeat may come once a second.
const PATIENCE: Duration = Duration::from_millis(1500);

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NmtRequest {
    /// Enter operational.
    Start,
    /// Stop: no process data, no SDO.
    Stop,
    /// Enter pre-operational: SDO, no process data.
    PreOperational,
    /// Reset the application, and with it the communication.
    ResetNode,
    /// Reset the communication.
    ResetCommunication,
}

impl NmtRequest {
    fn command(self) -> NmtCommand {
        match self {
            NmtRequest::Start => NmtCommand::Start,
            NmtRequest::Stop => NmtCommand::Stop,
            NmtRequest::PreOperational => NmtCommand::EnterPreOperational,
            NmtRequest::ResetNode => NmtCommand::ResetNode,
            NmtRequest::ResetCommunication => NmtCommand::ResetCommunication,
        }
    }

    /// The state in which a node that has obeyed reports itself.
    fn leads_to(self) -> NmtState {
        match self {
            NmtRequest::Start => NmtState::Operational,
            NmtRequest::Stop => NmtState::Stopped,
            NmtRequest::PreOperational => NmtState::PreOperational,
            NmtRequest::ResetNode | NmtRequest::ResetCommunication => NmtState::BootUp,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NmtTarget {
    All,
    One(NodeId),
}

/// Order a node to another state.
#[derive(Debug, Args)]
pub struct NmtArgs {
    /// NMT command.
    order: NmtRequest,
    /// Node id, or `all`.
    #[arg(value_parser = whom)]
    whom: NmtTarget,
}

fn whom(text: &str) -> Result<NmtTarget, String> {
    if text == "all" { Ok(NmtTarget::All) } else { node(text).map(NmtTarget::One) }
}

pub async fn run(bus: &mut Bus, args: &NmtArgs) -> miette::Result<ExitCode> {
    let addressed = match args.whom {
        NmtTarget::All => None,
        NmtTarget::One(node) => Some(node),
    };
    bus.send(&CanopenMessage::Nmt { command: args.order.command(), node: addressed }.encode());
    let expected = args.order.leads_to();
    let until = Instant::now() + PATIENCE;
    let mut seen = Vec::new();
    while let Ok(frame) = timeout_at(until, bus.recv()).await {
        let Ok(CanopenMessage::Heartbeat { node, state }) = CanopenMessage::decode(&frame.into_diagnostic()?) else {
            continue;
        };
        if state != expected || addressed.is_some_and(|addressed| addressed != node) || seen.contains(&node) {
            continue;
        }
        crate::out::say!("node {node}: {}", state_name(state));
        seen.push(node);
        if addressed.is_some() {
            return Ok(ExitCode::SUCCESS);
        }
    }
    if seen.is_empty() {
        let node = addressed.map_or("all nodes".to_owned(), |node| format!("node {node}"));
        crate::out::complain!("{node}: state {} not reached within {} ms", state_name(expected), PATIENCE.as_millis());
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}
