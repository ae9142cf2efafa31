//! Bus scan by listening alone: the state of every node of a bus.
//!
//! Pure: frames go in with the time they were received, one sentence for each node comes out. It is passive. The state
//! of a node follows from its own frames alone, not from the manager's commands. Memory is bounded by the number of
//! node ids.

use std::time::Duration;

use linewright_line::Tick;

use crate::codec::{CanopenMessage, Emergency, NmtState, NodeId};
use crate::frame::Frame;
pub use crate::texts::state_name;

/// Heartbeats that stay away for so many of their own periods are missed.
pub(crate) const PERIODS_MISSED: u32 = 3;

/// State of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScannedState {
    /// Its state by its last heartbeat or boot-up message; `None` if it has sent none.
    pub state: Option<NmtState>,
    /// Arrival of its last heartbeat or boot-up message.
    pub heartbeat: Option<Tick>,
    /// The time between its last two heartbeats.
    pub period: Option<Duration>,
    /// Arrival of its last frame of any kind.
    pub last: Tick,
    /// Boot-up messages.
    pub boots: u32,
    /// Its last emergency, whether that was an error or that errors are gone.
    pub emergency: Option<(Tick, Emergency)>,
    /// Process data it has sent.
    pub inputs: u64,
}

/// All nodes received on a bus.
#[derive(Clone, Debug)]
pub struct BusScan {
    nodes: [Option<ScannedState>; 128],
    /// Frames that belong to no node: NMT orders, SYNC, foreign identifiers.
    pub other: u64,
    /// Error frames of the kernel.
    pub bus_errors: u64,
}

impl Default for BusScan {
    fn default() -> Self {
        BusScan { nodes: [None; 128], other: 0, bus_errors: 0 }
    }
}

impl BusScan {
    pub fn take(&mut self, now: Tick, frame: &Frame) {
        let message = match CanopenMessage::decode(frame) {
            Ok(message) => message,
            Err(crate::FrameDecodeError::ErrorFrame { .. }) => {
                self.bus_errors += 1;
                return;
            }
            Err(_) => {
                self.other += 1;
                return;
            }
        };
        match message {
            CanopenMessage::Heartbeat { node, state } => self.of(now, node).heartbeat(now, state),
            CanopenMessage::Emergency { node, emergency } => self.of(now, node).emergency = Some((now, emergency)),
            CanopenMessage::Tpdo1 { node, .. } | CanopenMessage::Tpdo { node, .. } => self.of(now, node).inputs += 1,
            CanopenMessage::SdoResponse { node, .. } => _ = self.of(now, node),
            // Sent to a node, not by it.
            CanopenMessage::Nmt { .. }
            | CanopenMessage::Sync { .. }
            | CanopenMessage::Rpdo1 { .. }
            | CanopenMessage::Rpdo { .. }
            | CanopenMessage::SdoRequest { .. } => {
                self.other += 1;
            }
        }
    }

    /// State of a node; `None` if nothing was received from it.
    pub fn node(&self, node: NodeId) -> Option<&ScannedState> {
        self.nodes[usize::from(node.get())].as_ref()
    }

    /// Every node that was received, by id.
    pub fn nodes(&self) -> impl Iterator<Item = (NodeId, &ScannedState)> {
        let numbered = (0u8..).zip(&self.nodes);
        numbered.filter_map(|(id, state)| Some((NodeId::new(id)?, state.as_ref()?)))
    }

    fn of(&mut self, now: Tick, node: NodeId) -> &mut ScannedState {
        let blank = ScannedState {
            state: None,
            heartbeat: None,
            period: None,
            last: now,
            boots: 0,
            emergency: None,
            inputs: 0,
        };
        let state = self.nodes[usize::from(node.get())].get_or_insert(blank);
        state.last = now;
        state
    }
}

impl ScannedState {
    fn heartbeat(&mut self, now: Tick, state: NmtState) {
        if state == NmtState::BootUp {
            self.boots = self.boots.saturating_add(1);
            self.period = None;
        } else if self.state != Some(NmtState::BootUp) {
            // The first heartbeat after booting comes when it is configured, not a period later.
            self.period = self.heartbeat.map(|before| now.since(before));
        }
        self.state = Some(state);
        self.heartbeat = Some(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Tick {
        Tick::from_millis(ms)
    }

    fn survey(frames: &[(u64, &str)]) -> BusScan {
        let mut survey = BusScan::default();
        for (ms, frame) in frames {
            survey.take(at(*ms), &frame.parse().expect("a frame"));
        }
        survey
    }

    fn sentence(frames: &[(u64, &str)], now: u64) -> String {
        let node = NodeId::new(4).expect("4 is a node id");
        survey(frames).node(node).map_or_else(|| "nothing received".to_owned(), |state| state.explain(at(now)))
    }

    #[test]
    fn a_node_is_what_its_frames_say() {
        assert_eq!(sentence(&[], 10), "nothing received");
        assert_eq!(sentence(&[(5, "704#00")], 10), "has booted 5 ms ago, waits to be configured");
        let beats = [(0, "704#00"), (10, "704#7F"), (60, "704#05"), (110, "704#05")];
        assert_eq!(sentence(&beats, 130), "operational, a heartbeat every 50 ms");
        assert_eq!(sentence(&beats, 1110), "silent for 1000 ms, it was operational and sent a heartbeat every 50 ms");
        assert_eq!(sentence(&beats[..2], 30), "pre-operational, one heartbeat 20 ms ago");
        assert_eq!(sentence(&[(0, "184#01")], 10), "sends, but no heartbeat: its state is unknown");
        let emergency = [(0, "704#05"), (50, "704#05"), (60, "084#3081110000000000")];
        let said = sentence(&emergency, 70);
        assert!(said.starts_with("operational, a heartbeat every 50 ms; 10 ms ago it reported 8130h"), "{said}");
    }

    #[test]
    fn what_is_sent_to_a_node_says_nothing_of_it() {
        let found = survey(&[(0, "000#0104"), (1, "204#01"), (2, "604#4000100000000000"), (3, "080#"), (4, "123#00")]);
        assert_eq!((found.nodes().count(), found.other), (0, 5));
        let found = survey(&[(0, "584#4300100091010300"), (1, "20000040#0000000000000000")]);
        assert_eq!((found.nodes().count(), found.bus_errors), (1, 1));
    }

    proptest::proptest! {
        #[test]
        fn any_frames_at_any_time_have_a_sentence(
            frames in proptest::collection::vec((proptest::prelude::any::<[u8; 16]>(), 0u64..100_000), 0..40),
        ) {
            let mut survey = BusScan::default();
            for (bytes, ms) in &frames {
                if let Ok(frame) = Frame::from_bytes(bytes) {
                    survey.take(at(*ms), &frame);
                }
            }
            for (_, state) in survey.nodes() {
                proptest::prop_assert!(!state.explain(at(50_000)).is_empty());
            }
        }
    }
}
