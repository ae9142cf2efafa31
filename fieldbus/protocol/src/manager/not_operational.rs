//! Faults of a device in words: which device, which object or frame shows it, and why.
//!
//! Two descriptions, without any decision. [`Manager::explain`]: the state of a device, and what it waits for.
//! [`Manager::trouble`]: the devices that keep an owner's image from being valid, and why. The second is what a person
//! reads at a station that has stopped, so it gives the cause before the remedy: a device that is being booted again is
//! first described as having fallen silent.

use linewright_line::{Owner, Tick};

use super::peer::{NotOperationalReason, Peer, PeerPhase};
use super::rate_limit::{FRAMES_MAX, WINDOW};
use super::{Manager, RETRY};
use crate::codec::{NmtState, NodeId};

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
            Some(format!("{} (node {:02X}h): {what}", peer.name, peer.node.get()))
        });
        let plains = self.plains.iter().filter(move |plain| plain.owner == owner && !plain.trusted(now));
        of_peers.chain(plains.map(move |plain| format!("{}: {}", plain.name, plain.explain(now))))
    }
}

impl Peer {
    /// Its state at `now`, and what it waits for, in one sentence.
    pub(super) fn explain(&self, now: Tick) -> String {
        let silent = now.since(self.heard).as_millis();
        match &self.phase {
            _ if self.flood.is_on() => self.distrusted(now),
            PeerPhase::Absent { .. } => {
                let asked = format!("asked for its device type (1000h) every {} ms", RETRY.as_millis());
                format!("{}; {asked}", self.silence(now))
            }
            PeerPhase::Booting(boot) => boot.stage(&self.plan).to_string(),
            PeerPhase::Refused { why, retry } => {
                let again = retry.since(now).as_millis();
                format!("not started: {why}; looked at again in {again} ms, and when it boots")
            }
            PeerPhase::Starting { .. } => "configured and ordered to start; waits for it to say that it has".to_owned(),
            PeerPhase::Operational if self.errors.stand() => {
                format!("operational, but not trusted: {}", self.distrusted(now))
            }
            PeerPhase::Operational if self.process.fault(now).is_some() => self.distrusted(now),
            PeerPhase::Operational => match self.updated() {
                Some(at) => {
                    let heard = now.since(at).as_millis();
                    let error = self.errors.explain(self.process.profile());
                    let own = self.process.explain().into_iter().chain(error).map(|own| format!("; {own}"));
                    let own: String = own.collect();
                    format!("operational; its heartbeat came {silent} ms ago, its inputs {heard} ms ago{own}")
                }
                None => format!("operational; its heartbeat came {silent} ms ago, its inputs have not come yet"),
            },
            PeerPhase::Stopped => {
                format!("stopped by somebody else, and left so; its heartbeat came {silent} ms ago")
            }
        }
    }

    /// Why it cannot be trusted at `now`: first the cause, then what it waits for. `None` if it can.
    fn trouble(&self, now: Tick) -> Option<String> {
        if self.trusted(now) {
            return None;
        }
        if matches!(self.phase, PeerPhase::Operational) || self.flood.is_on() {
            return Some(self.distrusted(now));
        }
        let now_is = self.explain(now);
        Some(match self.why {
            None => now_is,
            // The phase explains itself; what the device waits for then is no help.
            Some(NotOperationalReason::Silent) => match &self.phase {
                PeerPhase::Refused { .. } => format!("{}; {now_is}", self.silence(now)),
                _ => self.silence(now),
            },
            Some(NotOperationalReason::Left(NmtState::Stopped | NmtState::Unknown(_)))
                if matches!(self.phase, PeerPhase::Stopped) =>
            {
                format!(
                    "stopped by somebody else (NMT), and left so until it is started; its heartbeat says {}",
                    self.said()
                )
            }
            Some(NotOperationalReason::NoSync) if matches!(self.phase, PeerPhase::Refused { .. }) => now_is,
            Some(NotOperationalReason::NoSync) => format!("it hears no SYNC (080h): TPDO1 has stopped; {now_is}"),
            Some(NotOperationalReason::Babbled) => format!("it babbled; {now_is}"),
            Some(NotOperationalReason::Contested) => format!("another manager was on the bus; {now_is}"),
            Some(NotOperationalReason::BusOff) => format!("the bus was off; {now_is}"),
            Some(NotOperationalReason::Booted) => format!("it has booted (boot-up, {}); {now_is}", self.beat_id()),
            Some(NotOperationalReason::Left(state)) => {
                format!("it has left the operational state ({} says {:02X}h); {now_is}", self.beat_id(), state.code())
            }
            Some(NotOperationalReason::Reported(emergency)) => {
                format!("emergency {}; {now_is}", emergency.text(self.process.profile()))
            }
        })
    }

    /// Why it cannot be trusted although it is operational.
    fn distrusted(&self, now: Tick) -> String {
        if self.flood.is_on() {
            let window = WINDOW.as_millis();
            return format!("it babbles: more than {FRAMES_MAX} frames within {window} ms; it is not listened to");
        }
        if now.since(self.heard) >= self.timeout {
            return self.silence(now);
        }
        if let Some(error) = self.errors.explain(self.process.profile()).filter(|_| self.errors.stand()) {
            return error;
        }
        match self.process.fault(now).filter(|_| !self.process.has_inputs() || self.updated.is_some()) {
            Some(fault) => format!("operational, but {fault}"),
            None => {
                let id = 0x180 + u16::from(self.node.get());
                format!("operational, but its inputs (TPDO1, {id:03X}h) have not come yet")
            }
        }
    }

    /// That it is silent, and since when.
    fn silence(&self, now: Tick) -> String {
        let Some(beat) = self.beat else {
            let nothing = format!("never heard: no boot-up and no heartbeat ({}, 1017h)", self.beat_id());
            return if self.heard == Tick::ZERO {
                nothing
            } else {
                format!("no heartbeat ({}, 1017h) ever came", self.beat_id())
            };
        };
        let since = now.since(beat).as_millis();
        // Whatever came clearly later than its last heartbeat shows that it lives.
        let lives = self.heard > beat + self.timeout;
        let other = if lives { ", though it answers (SDO)" } else { "" };
        format!("no heartbeat (1017h) for {since} ms{other}")
    }

    /// The identifier of its heartbeat.
    fn beat_id(&self) -> String {
        format!("{:03X}h", 0x700 + u16::from(self.node.get()))
    }

    fn said(&self) -> String {
        match self.why {
            Some(NotOperationalReason::Left(state)) => format!("{:02X}h ({})", state.code(), self.beat_id()),
            _ => self.beat_id(),
        }
    }
}
