//! One device as the manager sees it.
//!
//! ```text
//!            heard                 all answered             operational heartbeat or TPDO
//!  Absent ──────────▶ Configuring ─────────────▶ Starting ───────────────────────────────▶ Operational
//!    ▲                  │   ▲  refused              ▲  ▲                                      │    │
//!    │                  ▼   │ boot-up               │  └────────── pre-operational ───────────┘    │
//!    │               Refused┘                    Stopped ◀───────── stopped, unknown ──────────────┘
//!    └── from every state, when no heartbeat came for the timeout; boot-up leads from every state to Configuring
//! ```
//!
//! Configuring comes before starting, also for a device found operational: its heartbeat consumer must watch *this*
//! manager before an output is energised. A stopped device stays stopped: somebody ordered that, and the manager does
//! not argue. Only frames from the device move it along; what the manager sends proves nothing.

use std::time::Duration;

use linewright_line::{Device, InputId, OutputId, Owner, Tick, Timing};

use super::event::{Event, IgnoreReason, Outbox};
use super::{MANAGER_NODE, RETRY, image};
use crate::codec::{Emergency, HEARTBEAT_LOST, Message, NmtCommand, NmtState, NodeId, Payload};
use crate::sdo::ObjectId;
use crate::sdo::wire::{Content, Raw, Request, Response};

/// What a frame or the passing of time did to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Nothing its owner need know.
    Unchanged,
    /// The frame says nothing.
    Ignored(IgnoreReason),
    /// It has become operational.
    Up,
    /// It has sent inputs.
    Inputs,
    /// It was operational, and is no longer.
    Lost,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Not heard; asked for again at `probe`.
    Absent { probe: Tick },
    /// Alive; the setting `step` was sent and is repeated at `retry`.
    Configuring { step: usize, retry: Tick },
    /// It refused a setting, and is left alone until it boots.
    Refused,
    /// Configured and ordered to start; ordered again at `retry`.
    Starting { retry: Tick },
    /// Exchanging process data.
    Operational,
    /// In a state somebody else put it in.
    Stopped,
}

pub(super) struct Peer {
    pub(super) node: NodeId,
    pub(super) name: String,
    pub(super) owner: Owner,
    inputs: Vec<Option<InputId>>,
    outputs: Vec<Option<OutputId>>,
    settings: Vec<Request>,
    timeout: Duration,
    refresh: Duration,
    phase: Phase,
    /// When its last heartbeat came; meaningless while absent.
    heard: Tick,
    /// Its input bits as last sent; kept for showing after a loss.
    bits: u64,
    /// When it last sent its inputs; `None` since the last boot or loss.
    updated: Option<Tick>,
    /// The outputs it was last sent, and when; `None` since the last boot or loss.
    sent: Option<(u64, Tick)>,
}

impl Peer {
    pub(super) fn new(node: NodeId, device: &Device, timing: &Timing) -> Self {
        Peer {
            node,
            name: device.name.clone(),
            owner: device.owner,
            inputs: device.inputs.clone(),
            outputs: device.outputs.clone(),
            settings: settings(device, timing),
            timeout: timing.heartbeat_timeout,
            refresh: timing.refresh,
            phase: Phase::Absent { probe: Tick::ZERO },
            heard: Tick::ZERO,
            bits: 0,
            updated: None,
            sent: None,
        }
    }

    /// Its inputs may be acted upon: it is operational, recently heard, and has sent them since it came up.
    pub(super) fn trusted(&self, now: Tick) -> bool {
        self.phase == Phase::Operational
            && now.since(self.heard) < self.timeout
            && (self.inputs.is_empty() || self.updated.is_some())
    }

    pub(super) fn input_bits(&self) -> u128 {
        image::gather(self.bits, &self.inputs)
    }

    pub(super) fn updated(&self) -> Option<Tick> {
        self.updated
    }

    pub(super) fn state_name(&self) -> &'static str {
        match self.phase {
            Phase::Absent { .. } => "absent",
            Phase::Configuring { .. } => "being configured",
            Phase::Refused => "refuses its configuration",
            Phase::Starting { .. } => "being started",
            Phase::Operational => "operational",
            Phase::Stopped => "stopped",
        }
    }

    pub(super) fn deadline(&self) -> Tick {
        let lost = self.heard + self.timeout;
        match self.phase {
            Phase::Absent { probe } => probe,
            Phase::Configuring { retry, .. } | Phase::Starting { retry } => lost.min(retry),
            Phase::Refused | Phase::Stopped => lost,
            Phase::Operational => self.sent.map_or(lost, |(_, at)| lost.min(at + self.refresh)),
        }
    }

    /// Does what is due: noticing silence, asking again, refreshing outputs.
    pub(super) fn poll(&mut self, now: Tick, image: u128, out: &mut Outbox) -> Outcome {
        let absent = matches!(self.phase, Phase::Absent { .. });
        if !absent && self.heard + self.timeout <= now {
            out.events.push(Event::DeviceLost { node: self.node, silent_for: now.since(self.heard) });
            return self.leave(Phase::Absent { probe: now + RETRY });
        }
        match self.phase {
            Phase::Absent { probe } if probe <= now => {
                self.phase = Phase::Absent { probe: now + RETRY };
                self.send_setting(0, out);
            }
            Phase::Configuring { step, retry } if retry <= now => self.configure(now, step, out),
            Phase::Starting { retry } if retry <= now => self.order_start(now, out),
            Phase::Operational if self.sent.is_some_and(|(_, at)| at + self.refresh <= now) => {
                self.send_outputs(now, image, out);
            }
            _ => {}
        }
        Outcome::Unchanged
    }

    pub(super) fn heartbeat(&mut self, now: Tick, state: NmtState, out: &mut Outbox) -> Outcome {
        self.heard = now;
        match (self.phase, state) {
            (Phase::Absent { .. }, _) => {
                self.configure(now, 0, out);
                Outcome::Unchanged
            }
            (_, NmtState::BootUp) => {
                out.events.push(Event::DeviceRebooted { node: self.node });
                let outcome = self.leave(Phase::Starting { retry: now });
                self.configure(now, 0, out);
                outcome
            }
            // A stopped device answers no SDO: to be configured it must be woken.
            (Phase::Configuring { .. }, NmtState::Stopped) => {
                self.order(NmtCommand::EnterPreOperational, out);
                Outcome::Unchanged
            }
            (Phase::Starting { .. } | Phase::Stopped, NmtState::Operational) => self.up(out),
            // Still pre-operational after an order to start: `retry` repeats it, this heartbeat may have crossed it.
            (Phase::Configuring { .. } | Phase::Refused, _)
            | (Phase::Starting { .. }, NmtState::PreOperational)
            | (Phase::Operational, NmtState::Operational) => Outcome::Unchanged,
            (Phase::Stopped, NmtState::PreOperational) => {
                self.order_start(now, out);
                Outcome::Unchanged
            }
            (Phase::Operational, NmtState::PreOperational) => {
                out.events.push(Event::DeviceLeft { node: self.node, state });
                let outcome = self.leave(Phase::Stopped);
                self.order_start(now, out);
                outcome
            }
            (Phase::Starting { .. } | Phase::Operational, NmtState::Stopped | NmtState::Unknown(_)) => {
                out.events.push(Event::DeviceLeft { node: self.node, state });
                self.leave(Phase::Stopped)
            }
            (Phase::Stopped, NmtState::Stopped | NmtState::Unknown(_)) => Outcome::Unchanged,
        }
    }

    /// Only an operational device sends process data (CiA 301 §7.3.2.2), so hearing it is as good as being told.
    pub(super) fn inputs_heard(&mut self, now: Tick, payload: Payload, out: &mut Outbox) -> Outcome {
        match self.phase {
            Phase::Absent { .. } => {
                // Alive, but not configured by this manager: its inputs wait until it is.
                self.heard = now;
                self.configure(now, 0, out);
                return Outcome::Ignored(IgnoreReason::NotOperational);
            }
            Phase::Configuring { .. } | Phase::Refused | Phase::Stopped => {
                return Outcome::Ignored(IgnoreReason::NotOperational);
            }
            Phase::Starting { .. } | Phase::Operational => {}
        }
        if payload.bytes().len() * 8 < self.inputs.len() {
            return Outcome::Ignored(IgnoreReason::ShortPdo);
        }
        self.bits = payload.bits();
        self.updated = Some(now);
        if self.phase == Phase::Operational { Outcome::Inputs } else { self.up(out) }
    }

    pub(super) fn emergency(&mut self, now: Tick, emergency: Emergency, out: &mut Outbox) -> Outcome {
        out.events.push(Event::Emergency { node: self.node, emergency });
        // It has let go of its outputs because it did not hear us; its next heartbeat would say the same, later.
        if emergency.code == HEARTBEAT_LOST && self.phase == Phase::Operational {
            let outcome = self.leave(Phase::Stopped);
            self.order_start(now, out);
            return outcome;
        }
        Outcome::Unchanged
    }

    pub(super) fn sdo_answer(&mut self, now: Tick, raw: &Raw, out: &mut Outbox) -> Outcome {
        let step = match self.phase {
            Phase::Absent { .. } => 0,
            Phase::Configuring { step, .. } => step,
            _ => return Outcome::Ignored(IgnoreReason::NotForManager),
        };
        let Request::Download { object, .. } = self.settings[step] else {
            return Outcome::Ignored(IgnoreReason::NotForManager);
        };
        match Response::decode(raw) {
            Some(Response::Download { object: answered }) if answered == object => {
                self.heard = now;
                self.configure(now, step + 1, out);
            }
            Some(Response::Abort { object: answered, code }) if answered == object => {
                self.heard = now;
                self.phase = Phase::Refused;
                let ObjectId { index, sub } = object;
                out.events.push(Event::ConfigurationRefused { node: self.node, index, sub, code });
            }
            _ => return Outcome::Ignored(IgnoreReason::NotForManager),
        }
        Outcome::Unchanged
    }

    /// Sends its share of the owner's image if it is operational and has something else.
    pub(super) fn send_outputs_if_changed(&mut self, now: Tick, image: u128, out: &mut Outbox) {
        let bits = image::scatter(image, &self.outputs);
        if self.sent.is_some_and(|(sent, _)| sent != bits) {
            self.send_outputs(now, image, out);
        }
    }

    /// Sends its share of the owner's image, provided it is operational: before that it would drop the frame, and the
    /// manager would believe it has the outputs.
    pub(super) fn send_outputs(&mut self, now: Tick, image: u128, out: &mut Outbox) {
        if self.phase == Phase::Operational && !self.outputs.is_empty() {
            let bits = image::scatter(image, &self.outputs);
            out.frames.push(self.rpdo(bits));
            self.sent = Some((bits, now));
        }
    }

    /// Sends all outputs off, whatever state it is in.
    pub(super) fn send_zero(&self, out: &mut Outbox) {
        if !self.outputs.is_empty() {
            out.frames.push(self.rpdo(0));
        }
    }

    fn rpdo(&self, bits: u64) -> crate::Frame {
        let payload = Payload::from_bits(bits, self.outputs.len());
        Message::Rpdo1 { node: self.node, payload }.encode()
    }

    fn up(&mut self, out: &mut Outbox) -> Outcome {
        self.phase = Phase::Operational;
        out.events.push(Event::DeviceUp { node: self.node });
        Outcome::Up
    }

    /// Leaves for `phase`. From here on its inputs are unknown and its outputs are taken to be off.
    fn leave(&mut self, phase: Phase) -> Outcome {
        let was = self.phase;
        self.phase = phase;
        self.updated = None;
        self.sent = None;
        if was == Phase::Operational { Outcome::Lost } else { Outcome::Unchanged }
    }

    /// Sends setting `step`, or the order to start after the last one.
    fn configure(&mut self, now: Tick, step: usize, out: &mut Outbox) {
        if step < self.settings.len() {
            self.phase = Phase::Configuring { step, retry: now + RETRY };
            self.send_setting(step, out);
        } else {
            self.order_start(now, out);
        }
    }

    fn send_setting(&self, step: usize, out: &mut Outbox) {
        out.frames.push(Message::SdoRequest { node: self.node, raw: self.settings[step].encode() }.encode());
    }

    fn order_start(&mut self, now: Tick, out: &mut Outbox) {
        self.phase = Phase::Starting { retry: now + RETRY };
        self.order(NmtCommand::Start, out);
    }

    fn order(&self, command: NmtCommand, out: &mut Outbox) {
        out.frames.push(Message::Nmt { command, node: Some(self.node) }.encode());
    }
}

/// What every device is told before it is started. Never empty: the first setting also serves to ask whether the
/// device is there.
fn settings(device: &Device, timing: &Timing) -> Vec<Request> {
    let millis = |span: Duration| u16::try_from(span.as_millis()).unwrap_or(u16::MAX);
    // Object 1017h, producer heartbeat time in ms.
    let produce = write(ObjectId::new(0x1017, 0), &millis(timing.heartbeat).to_le_bytes());
    // Object 1016h sub 1, consumer heartbeat time: node id in bits 16 to 23, ms below. What makes outputs safe when
    // the manager is gone, so a device that has outputs must accept it; one that has none need not know the object.
    let watched = u32::from(MANAGER_NODE.get()) << 16 | u32::from(millis(timing.heartbeat_timeout));
    let consume = write(ObjectId::new(0x1016, 1), &watched.to_le_bytes());
    let consume = consume.filter(|_| !device.outputs.is_empty());
    produce.into_iter().chain(consume).collect()
}

/// Writes up to four bytes.
fn write(object: ObjectId, data: &[u8]) -> Option<Request> {
    Content::expedited(data).map(|content| Request::Download { object, content })
}
