//! `can scan`: the nodes on a bus.
//!
//! The one object of every CANopen device, its type (1000h), is read from all node ids at once; of the nodes that
//! answer, the rest is read. Nodes that only send heartbeats, because they are stopped, are listed too.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_canopen::bus_scan::state_name;
use linewright_canopen::codec::NmtState;
use linewright_canopen::sdo::wire::ClientFrame;
use linewright_canopen::sdo::{ObjectId, TransferMode, TransferOptions};
use linewright_canopen::{CanopenMessage, NodeId};
use linewright_fieldbus::{Bus, sdo_client};
use miette::IntoDiagnostic;
use serde::Serialize;
use tokio::time::{Instant, timeout_at};

/// Ask every node id for its identity.
#[derive(Debug, Args)]
pub struct ScanArgs {
    /// Time to wait for answers and heartbeats, in ms.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(10..=60_000))]
    wait: u64,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

/// Limits of one read from a node that is there.
const ANSWER: TransferOptions = TransferOptions {
    timeout: Duration::from_millis(300),
    retries: 1,
    mode: TransferMode::Segmented,
    block_above: 0,
    burst: 1,
    len_max: 1024,
};

#[derive(Debug, Default, Serialize)]
struct ScannedNode {
    node: u8,
    state: Option<String>,
    device_type: Option<u32>,
    profile: Option<String>,
    vendor: Option<u32>,
    product: Option<u32>,
    revision: Option<u32>,
    serial: Option<u32>,
    name: Option<String>,
}

pub async fn run(bus: &mut Bus, args: &ScanArgs) -> miette::Result<ExitCode> {
    let states = listen_and_ask(bus, Duration::from_millis(args.wait)).await?;
    let mut found = Vec::new();
    for (node, state) in states {
        found.push(question(bus, node, state).await);
    }
    if args.json {
        crate::out::say!("{}", serde_json::json!({ "bus": bus.describe(), "nodes": found }));
    } else {
        table(&found);
    }
    Ok(if found.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Every node that sends, with the state it reports, if it does.
async fn listen_and_ask(bus: &mut Bus, wait: Duration) -> miette::Result<BTreeMap<NodeId, Option<NmtState>>> {
    for node in (1..=127).filter_map(NodeId::new) {
        let raw = ClientFrame::Upload { object: ObjectId::new(0x1000, 0) }.encode();
        bus.send(&CanopenMessage::SdoRequest { node, raw }.encode());
    }
    let until = Instant::now() + wait;
    let mut heard = BTreeMap::new();
    while let Ok(frame) = timeout_at(until, bus.recv()).await {
        match CanopenMessage::decode(&frame.into_diagnostic()?) {
            Ok(CanopenMessage::Heartbeat { node, state }) => _ = heard.insert(node, Some(state)),
            Ok(
                CanopenMessage::SdoResponse { node, .. }
                | CanopenMessage::Tpdo1 { node, .. }
                | CanopenMessage::Emergency { node, .. },
            ) => {
                heard.entry(node).or_default();
            }
            _ => {}
        }
    }
    Ok(heard)
}

async fn question(bus: &mut Bus, node: NodeId, state: Option<NmtState>) -> ScannedNode {
    let mut found = ScannedNode { node: node.get(), state: state.map(state_name), ..ScannedNode::default() };
    // A stopped node answers nothing (CiA 301 §7.3.2.2), and a manager need not be a server at all.
    let Some(device_type) = number(bus, node, 0x1000, 0).await else { return found };
    found.device_type = Some(device_type);
    found.profile = Some(profile(device_type));
    found.vendor = number(bus, node, 0x1018, 1).await;
    found.product = number(bus, node, 0x1018, 2).await;
    found.revision = number(bus, node, 0x1018, 3).await;
    found.serial = number(bus, node, 0x1018, 4).await;
    let name = sdo_client::read(bus, node, ObjectId::new(0x1008, 0), ANSWER).await.ok();
    found.name = name.map(|bytes| String::from_utf8_lossy(&bytes).trim_end_matches('\0').to_owned());
    found
}

async fn number(bus: &mut Bus, node: NodeId, index: u16, sub: u8) -> Option<u32> {
    let bytes = sdo_client::read(bus, node, ObjectId::new(index, sub), ANSWER).await.ok()?;
    bytes.try_into().ok().map(u32::from_le_bytes)
}

/// Meaning of object 1000h: the profile's number in the low half, the device's functions in it above.
fn profile(device_type: u32) -> String {
    let [low, high, kinds, _] = device_type.to_le_bytes();
    match u16::from_le_bytes([low, high]) {
        0 => "no standard profile".to_owned(),
        401 => {
            let names = ["digital inputs", "digital outputs", "analogue inputs", "analogue outputs"];
            let has = names.iter().enumerate().filter(|(bit, _)| kinds >> bit & 1 == 1);
            let has: Vec<&str> = has.map(|(_, name)| *name).collect();
            format!("CiA 401 I/O: {}", has.join(", "))
        }
        402 => "CiA 402 drive".to_owned(),
        other => format!("CiA {other}"),
    }
}

fn table(found: &[ScannedNode]) {
    if found.is_empty() {
        crate::out::complain!("no node answered");
        return;
    }
    let hex = |number: Option<u32>| number.map_or("-".to_owned(), |number| format!("{number:08X}h"));
    crate::out::say!("node  state            vendor     product    revision   serial     device");
    for node in found {
        let state = node.state.as_deref().unwrap_or("no heartbeat");
        let [vendor, product, revision, serial] = [node.vendor, node.product, node.revision, node.serial].map(hex);
        let name = node.name.as_deref().filter(|name| !name.is_empty()).map(|name| format!(" ({name})"));
        let what = node.profile.as_deref().unwrap_or("answers no SDO");
        let number = format!("{:02X}h", node.node);
        let line = format!("{number:>4}  {state:16} {vendor:10} {product:10} {revision:10} {serial:10} {what}");
        crate::out::say!("{line}{}", name.unwrap_or_default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_type_is_told_in_words() {
        assert_eq!(profile(0x0003_0191), "CiA 401 I/O: digital inputs, digital outputs");
        assert_eq!(profile(0x0002_0192), "CiA 402 drive");
        assert_eq!(profile(0), "no standard profile");
        assert_eq!(profile(406), "CiA 406");
    }
}
