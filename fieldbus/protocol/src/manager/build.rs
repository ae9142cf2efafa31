//! From the devices of a description to the manager of their bus, or why there can be none.

use super::fault::IGNORE_REASONS;
use super::pace::SendQueue;
use super::peer::Peer;
use super::process::ProcessData;
use super::request::Requests;
use super::rival::Rival;
use super::status::DeviceMemory;
use super::{MANAGER_NODE, ManagedImage, Manager, REPORTS};
use crate::codec::NodeId;
use linewright_fieldbus_seam::InputImage;
use linewright_line::{Canopen, Device, DeviceKind, FrameId, Timing};

/// Why a manager cannot be built from a set of devices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ManagerError {
    /// Not a node id, or the manager's own.
    NodeId {
        device: String,
        /// Node id found; allowed are 1 to 127.
        node: u8,
    },
    /// Two devices of one bus with the same id.
    Duplicate {
        /// The device described first.
        first: String,
        second: String,
        node: u8,
    },
    /// The DBC file of a device without CANopen has not been read.
    Unread { device: String, file: String },
    /// An identifier with two meanings.
    FrameId { device: String, id: FrameId, other: String },
    /// More bits than one PDO carries.
    TooWide { device: String, bits: usize },
}

impl Manager {
    /// The manager of the bus that carries these devices. Nothing is sent before the first [`Manager::poll`].
    pub fn new<'a>(devices: impl IntoIterator<Item = &'a Device>, timing: Timing) -> Result<Self, ManagerError> {
        let mut peers: Vec<Peer> = Vec::new();
        let mut images: Vec<ManagedImage> = Vec::new();
        let mut plains = Vec::new();
        for device in devices.into_iter().filter(|device| device.is_on_can()) {
            if !images.iter().any(|i| i.owner == device.owner) {
                images.push(ManagedImage { owner: device.owner, outputs: 0, inputs: InputImage::NEVER });
            }
            let (canopen, process) = match &device.kind {
                DeviceKind::Frames(frames) => {
                    let unread =
                        || ManagerError::Unread { device: device.name.clone(), file: frames.file.name.clone() };
                    plains.push((device, frames.bound.as_ref().ok_or_else(unread)?));
                    continue;
                }
                DeviceKind::Io(canopen, io) => (canopen, ProcessData::of_io(io, &timing)),
                DeviceKind::Drive(canopen, drive) => (canopen, ProcessData::of_drive(drive)),
                DeviceKind::Modbus(_) => continue,
            };
            let Canopen { node_id, setup } = canopen;
            let node = NodeId::new(*node_id).filter(|node| *node != MANAGER_NODE);
            let node = node.ok_or_else(|| ManagerError::NodeId { device: device.name.clone(), node: *node_id })?;
            if let Some(other) = peers.iter().find(|p| p.node == node) {
                let (first, second) = (other.name.clone(), device.name.clone());
                return Err(ManagerError::Duplicate { first, second, node: *node_id });
            }
            let bits = device.input_bits().len().max(device.output_bits().len());
            if bits > 64 {
                return Err(ManagerError::TooWide { device: device.name.clone(), bits });
            }
            peers.push(Peer::new(node, device, setup, process, &timing));
        }
        let records = vec![DeviceMemory::default(); peers.len()];
        let mut manager = Manager {
            timing,
            peers,
            plains: Vec::new(),
            records,
            requests: Requests::default(),
            images,
            next_heartbeat: None,
            next_sync: None,
            off: None,
            ignored: [0; IGNORE_REASONS],
            reports: [REPORTS; IGNORE_REASONS + 1],
            rival: Rival::new(&timing),
            pace: SendQueue::new(),
            turn: 0,
        };
        for (device, binding) in plains {
            manager.add_plain(device, binding);
        }
        manager.check_ids()?;
        Ok(manager)
    }
}
