//! Faults of a device in words: which device, which object or frame shows it, and why.
//!
//! Two descriptions, without any decision; the sentences are those of `peer/explain.rs`. [`Manager::explain`]: the state of a device, and what it waits for.
//! [`Manager::trouble`]: the devices that keep an owner's image from being valid, and why. The second is what a person
//! reads at a station that has stopped, so it gives the cause before the remedy: a device that is being booted again is
//! first described as having fallen silent.

use linewright_line::{Owner, Tick};

use super::Manager;
use crate::codec::NodeId;

impl Manager {
    /// State of the device with this node id at `now`, and what it waits for, in one sentence.
    pub fn explain(&self, now: Tick, node: NodeId) -> Option<String> {
        self.peers.iter().find(|p| p.node == node).map(|peer| peer.explain(now))
    }

    /// Why the inputs of the device with this node id are invalid at `now`, in one sentence. `None` while they are
    /// valid, and for a device that no image depends on.
    pub fn trouble_of(&self, now: Tick, node: NodeId) -> Option<String> {
        let peer = self.peers.iter().find(|peer| peer.node == node && peer.is_vital)?;
        let what = peer.trouble(now)?;
        if let Some(rival) = self.rival.explain(now) {
            return Some(rival);
        }
        Some(match self.off_the_bus() {
            Some(off) => format!("the bus is off since {} ms: nothing is heard from it", now.since(off).as_millis()),
            None => what,
        })
    }

    /// Why the inputs of `owner` are invalid at `now`: one sentence for each of its devices that is in the way, with
    /// the device's name, its node id, the object or frame concerned, and the cause; or one for all of them, if another
    /// manager is there. Nothing while they are valid, and for an owner without devices on this bus.
    pub fn trouble(&self, now: Tick, owner: Owner) -> impl Iterator<Item = String> {
        let rival = self.rival.explain(now).filter(|_| self.images.iter().any(|image| image.owner == owner));
        let each = self.trouble_of_each(now, owner).filter({
            let contested = rival.is_some();
            move |_| !contested
        });
        rival.into_iter().chain(each)
    }

    fn trouble_of_each(&self, now: Tick, owner: Owner) -> impl Iterator<Item = String> {
        let own = self.peers.iter().filter(move |peer| peer.owner == owner && peer.is_vital);
        let of_peers = own.filter_map(move |peer| {
            let what = self.trouble_of(now, peer.node)?;
            Some(format!("{} (node {}): {what}", peer.name, peer.node))
        });
        let plains = self.plains.iter().filter(move |plain| plain.owner == owner && !plain.trusted(now));
        of_peers.chain(plains.map(move |plain| format!("{}: {}", plain.name, plain.explain(now))))
    }
}
