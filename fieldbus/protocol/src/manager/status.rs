//! Status of a device in detail, for diagnostics.

use linewright_line::{Owner, Tick};

use super::Manager;
use super::event::BusEvent;
use super::peer::PeerPhase;
use crate::codec::{Emergency, NmtState, NodeId, Profile};

/// Condition of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceCondition {
    /// Silent.
    Absent,
    /// Being identified, configured or started.
    Booting,
    Refused,
    /// It exchanges process data.
    Operational,
    /// Stopped by another node.
    Stopped,
}

/// State of a device, as its manager has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceStatus<'a> {
    pub node: NodeId,
    pub name: &'a str,
    pub owner: Owner,
    pub condition: DeviceCondition,
    /// Its network management state as last reported; `None` while it is silent.
    pub nmt: Option<NmtState>,
    /// The emergency it reported last, and when; with code 0 its errors are gone.
    pub emergency: Option<(Tick, Emergency)>,
    /// By which table its error codes are read.
    pub profile: Profile,
    /// Number of times it was operational and then was not.
    pub losses: u32,
    /// Number of its frames that were ignored.
    pub ignored: u64,
}

/// Memory of a device while it comes and goes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DeviceMemory {
    pub nmt: Option<NmtState>,
    pub emergency: Option<(Tick, Emergency)>,
    pub losses: u32,
    pub ignored: u64,
}

impl Manager {
    /// Forgets the states of devices that are absent or refused and have reported none for too long. Not every such
    /// transition has an event.
    pub(super) fn forget_states(&mut self, now: Tick) {
        for (peer, record) in self.peers.iter().zip(&mut self.records) {
            let said = peer.beat.is_some_and(|beat| now < beat + peer.timeout);
            if matches!(peer.phase, PeerPhase::Absent { .. } | PeerPhase::Refused { .. }) && !said {
                record.nmt = None;
            }
        }
    }

    /// Every device, in the order of the description.
    pub fn statuses(&self) -> impl Iterator<Item = DeviceStatus<'_>> {
        self.peers.iter().zip(&self.records).map(|(peer, record)| {
            let DeviceMemory { nmt, emergency, losses, ignored } = *record;
            let (node, name, owner) = (peer.node, peer.name.as_str(), peer.owner);
            let (condition, profile) = (peer.condition(), peer.process.profile());
            DeviceStatus { node, name, owner, condition, nmt, emergency, profile, losses, ignored }
        })
    }

    /// Records these events.
    pub(super) fn record(&mut self, now: Tick, events: &[BusEvent]) {
        for event in events {
            let (node, is) = match event {
                BusEvent::DeviceUp { node } => (node.get(), Some(NmtState::Operational)),
                BusEvent::DeviceLost { node, .. } => (node.get(), None),
                BusEvent::DeviceLeft { node, state } => (node.get(), Some(*state)),
                BusEvent::DeviceRebooted { node } => (node.get(), Some(NmtState::BootUp)),
                BusEvent::Emergency { node, emergency, .. } => {
                    if let Some(record) = self.record_of(node.get()) {
                        record.emergency = Some((now, *emergency));
                    }
                    continue;
                }
                BusEvent::Ignored { frame, .. } => {
                    // In the predefined connection set the lower seven bits are the node id.
                    let node = frame.cob_id().map_or(0, |id| (id & 0x7F) as u8);
                    if let Some(record) = self.record_of(node) {
                        record.ignored += 1;
                    }
                    continue;
                }
                _ => continue,
            };
            if let Some(record) = self.record_of(node) {
                record.nmt = is;
            }
        }
    }

    pub(super) fn record_of(&mut self, node: u8) -> Option<&mut DeviceMemory> {
        let at = self.peers.iter().position(|peer| peer.node.get() == node)?;
        self.records.get_mut(at)
    }
}
