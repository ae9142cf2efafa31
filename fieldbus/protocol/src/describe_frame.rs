//! Frames in words: the meaning of each by the predefined connection set, and whether it is new.
//!
//! Pure, for display. Nothing is decided by these words.

use std::collections::BTreeMap;

use linewright_line::Line;

use crate::bus_scan::state_name;
use crate::codec::{CanopenMessage, NmtCommand, NodeId, Payload};
use crate::frame::Frame;
use crate::sdo::wire::{ClientFrame, InitiateContent, SdoBytes, ServerFrame};

/// Names of the nodes of one bus.
#[derive(Clone, Debug, Default)]
pub struct NodeNames(BTreeMap<u8, String>);

impl NodeNames {
    /// The names in a description, on the bus that is reached over this interface.
    pub fn of(line: Option<&Line>, interface: &str) -> Self {
        let devices = line.into_iter().flat_map(|line| line.devices_on(interface));
        let names = devices.filter_map(|device| Some((device.node_id()?, device.name.clone())));
        let mut names: BTreeMap<u8, String> = names.collect();
        names.entry(crate::MANAGER_NODE.get()).or_insert_with(|| "manager".to_owned());
        NodeNames(names)
    }

    fn name(&self, node: NodeId) -> String {
        self.0.get(&node.get()).cloned().unwrap_or_else(|| format!("node {node}"))
    }
}

/// Meaning of a frame, in words.
pub fn describe_frame(frame: &Frame, names: &NodeNames) -> String {
    let message = match CanopenMessage::decode(frame) {
        Ok(message) => message,
        Err(error) => return error.to_string(),
    };
    match message {
        CanopenMessage::Nmt { command, node } => {
            let whom = node.map_or("all nodes".to_owned(), |node| names.name(node));
            format!("order to {whom}: {}", order(command))
        }
        CanopenMessage::Sync { counter: None } => "SYNC".to_owned(),
        CanopenMessage::Sync { counter: Some(counter) } => format!("SYNC {counter}"),
        CanopenMessage::Emergency { node, emergency } => format!("{}: emergency {emergency}", names.name(node)),
        CanopenMessage::Tpdo1 { node, payload } => format!("{}: inputs {}", names.name(node), bits(payload)),
        CanopenMessage::Rpdo1 { node, payload } => format!("to {}: outputs {}", names.name(node), bits(payload)),
        CanopenMessage::Tpdo { node, number, payload } => {
            format!("{}: analogue inputs {}", names.name(node), channels(number, payload))
        }
        CanopenMessage::Rpdo { node, number, payload } => {
            format!("to {}: analogue outputs {}", names.name(node), channels(number, payload))
        }
        CanopenMessage::SdoRequest { node, raw } => format!("to {}: {}", names.name(node), asked(&raw)),
        CanopenMessage::SdoResponse { node, raw } => format!("{}: {}", names.name(node), answered(&raw)),
        CanopenMessage::Heartbeat { node, state } => format!("{}: {}", names.name(node), state_name(state)),
    }
}

fn order(command: NmtCommand) -> String {
    match command {
        NmtCommand::Start => "start".to_owned(),
        NmtCommand::Stop => "stop".to_owned(),
        NmtCommand::EnterPreOperational => "enter pre-operational".to_owned(),
        NmtCommand::ResetNode => "reset".to_owned(),
        NmtCommand::ResetCommunication => "reset the communication".to_owned(),
        NmtCommand::Unknown(code) => format!("{code:02X}h, which CiA 301 does not have"),
    }
}

/// Request to an SDO server, in words. A segment of a block has no recognisable form, so only other frames are
/// described.
fn asked(raw: &SdoBytes) -> String {
    match ClientFrame::decode(raw) {
        Some(ClientFrame::Upload { object } | ClientFrame::BlockUpload { object, .. }) => format!("read {object}"),
        Some(ClientFrame::Download { object, content }) => format!("write {object}: {}", carried(&content)),
        Some(ClientFrame::BlockDownload { object, size, .. }) => format!("write {object} in blocks{}", of_size(size)),
        Some(ClientFrame::Abort { object, code }) => format!("{object} given up: {code}"),
        _ => "SDO, more of a transfer".to_owned(),
    }
}

/// Response of an SDO server, in words.
fn answered(raw: &SdoBytes) -> String {
    match ServerFrame::decode(raw) {
        Some(ServerFrame::Upload { object, content }) => format!("{object} is {}", carried(&content)),
        Some(ServerFrame::Download { object }) => format!("{object} written"),
        Some(ServerFrame::Abort { object, code }) => format!("{object} refused: {code}"),
        Some(ServerFrame::BlockUpload { object, size, .. }) => format!("{object} comes in blocks{}", of_size(size)),
        Some(ServerFrame::BlockDownload { object, .. }) => format!("{object} may come in blocks"),
        _ => "SDO, more of a transfer".to_owned(),
    }
}

fn carried(content: &InitiateContent) -> String {
    match content {
        InitiateContent::Expedited { bytes, len, .. } => {
            let digits = bytes[..usize::from(*len)].iter().rev().map(|byte| format!("{byte:02X}"));
            format!("{}h", digits.collect::<String>())
        }
        InitiateContent::Segmented { size } => format!("to come in segments{}", of_size(*size)),
    }
}

fn of_size(size: Option<u32>) -> String {
    size.map(|size| format!(", {size} bytes")).unwrap_or_default()
}

/// Bit 0 first, as the description lists them, in groups of eight.
fn bits(payload: Payload) -> String {
    let bytes = payload.bytes().iter().map(|byte| format!("{:08b}", byte.reverse_bits()));
    let groups: Vec<String> = bytes.collect();
    if groups.is_empty() { "none".to_owned() } else { groups.join(" ") }
}

/// The numbers of the channels of one object, each with its channel.
fn channels(object: u8, payload: Payload) -> String {
    let first = usize::from(object.saturating_sub(2)) * 4 + 1;
    let numbers = payload.bytes().chunks_exact(2).map(|pair| i16::from_le_bytes([pair[0], pair[1]]));
    let each: Vec<String> = (first..).zip(numbers).map(|(channel, number)| format!("{channel}: {number}")).collect();
    if each.is_empty() { "none".to_owned() } else { each.join(", ") }
}

/// Distinguishes frames that repeat their sender's last data from those with new data.
#[derive(Clone, Debug, Default)]
pub struct ChangeFilter {
    /// The last data of each identifier that is sent again and again: at most one for each of the 11-bit ones.
    last: BTreeMap<u16, Vec<u8>>,
}

impl ChangeFilter {
    /// Whether a frame is new: heartbeats without a change and repeated process data are not.
    pub fn is_news(&mut self, frame: &Frame) -> bool {
        match CanopenMessage::decode(frame) {
            Ok(
                CanopenMessage::Heartbeat { .. }
                | CanopenMessage::Tpdo1 { .. }
                | CanopenMessage::Tpdo { .. }
                | CanopenMessage::Rpdo1 { .. }
                | CanopenMessage::Rpdo { .. },
            ) => {}
            Ok(CanopenMessage::Sync { .. }) => return false,
            _ => return true,
        }
        let Some(cob_id) = frame.cob_id() else { return true };
        let before = self.last.insert(cob_id, frame.data().to_vec());
        before.as_deref() != Some(frame.data())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(frame: &str) -> String {
        let mut names = NodeNames::of(None, "vcan0");
        names.0.insert(4, "clamp_1_io".to_owned());
        describe_frame(&frame.parse().expect("a frame"), &names)
    }

    #[test]
    fn frames_are_told_in_words() {
        assert_eq!(said("000#0104"), "order to clamp_1_io: start");
        assert_eq!(said("000#8100"), "order to all nodes: reset");
        assert_eq!(said("704#05"), "clamp_1_io: operational");
        assert_eq!(said("77F#05"), "manager: operational");
        assert_eq!(said("705#7F"), "node 05h: pre-operational");
        assert_eq!(said("184#0180"), "clamp_1_io: inputs 10000000 00000001");
        assert_eq!(said("204#03"), "to clamp_1_io: outputs 11000000");
        assert_eq!(said("080#"), "SYNC");
        assert_eq!(said("604#4000100000000000"), "to clamp_1_io: read 1000h:00");
        assert_eq!(said("604#2B17100032000000"), "to clamp_1_io: write 1017h:00: 0032h");
        assert_eq!(said("584#4300100091010300"), "clamp_1_io: 1000h:00 is 00030191h");
        assert!(said("584#8016100111000906").starts_with("clamp_1_io: 1016h:01 refused: 06090011h"));
        assert!(said("084#3081110000000000").starts_with("clamp_1_io: emergency 8130h"));
        assert!(said("123#00").contains("has no meaning here"));
    }

    #[test]
    fn only_what_changes_is_news() {
        let mut news = ChangeFilter::default();
        let mut is_news = |text: &str| news.is_news(&text.parse().expect("a frame"));
        let heard = ["704#05", "704#05", "184#01", "184#01", "184#00", "704#7F", "000#0104", "000#0104", "080#"];
        let new = heard.map(&mut is_news);
        assert_eq!(new, [true, false, true, false, true, true, true, true, false]);
    }
}
