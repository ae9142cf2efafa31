//! One device as the manager sees it.
//!
//! ```text
//!            heard               all as planned             operational heartbeat or TPDO
//!  Absent ──────────▶ Booting ─────────────────▶ Starting ───────────────────────────────▶ Operational
//!    ▲                │   ▲  another device,        ▲                                              │
//!    │                │   │  setting refused,       │ operational                                  │
//!    │                ▼   │  SYNC lost              │                                              │
//!    │               Refused                     Stopped ◀───────── stopped, unknown ──────────────┘
//!    └── from every state but Refused, when it is silent for too long
//!  Boot-up leads from every state to Booting; so does pre-operational from Stopped and Operational, for it may have
//!  booted unheard, and a start that has no effect.
//! ```
//!
//! Booting (`boot.rs`) comes before starting, also for a device found operational: it must be the device that is
//! expected, and its heartbeat consumer must watch *this* manager before an output is energised. A stopped device stays
//! stopped: somebody ordered that, and the manager does not argue. Only frames from the device move it along; what the
//! manager sends proves nothing.

use std::time::Duration;

use linewright_fieldbus_seam::Budget;
use linewright_line::{Device, Owner, Reaction, Setup, Tick, Timing};

use super::boot::{Boot, BootError, DEVICE_TYPE, Plan, plan};
use super::channels::Channels;
use super::errors::Errors;
use super::event::{Event, IgnoreReason, Outbox};
use super::flood::Flood;
use super::process::Process;
use super::sync;
use super::transfer::Transfer;
use super::trouble::Why;
use super::{RETRY, TOLD};
use crate::codec::{Message, NmtCommand, NmtState, NodeId, Payload};
use crate::sdo::Setting;
use crate::sdo::wire::{Raw, Request};

/// What a frame or the passing of time did to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Nothing its owner need know.
    Unchanged,
    /// The frame says nothing.
    Ignored(IgnoreReason),
    /// It has become operational.
    Up,
    /// It has sent inputs, or whether it can be trusted has changed.
    Inputs,
    /// It was operational, and is no longer, or not to be trusted.
    Lost,
}

#[derive(Debug)]
pub(super) enum Phase {
    /// Not heard; asked for again at `probe`.
    Absent { probe: Tick },
    /// Alive; it is being identified and configured.
    Booting(Boot),
    /// It must not be started. Looked at again at `retry`, and when it boots: somebody may have seen to it.
    Refused { why: BootError, retry: Tick },
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
    /// Its owner depends on it.
    pub(super) is_vital: bool,
    pub(super) process: Process,
    pub(super) errors: Errors,
    pub(super) flood: Flood,
    /// How much is reported of it, and how often it is ordered to start and booted.
    pub(super) told: Budget,
    pub(super) orders: Budget,
    /// What it is being written while it runs.
    pub(super) writing: Option<(Setting, Transfer)>,
    /// Its SDO channel is lent to a request (`request.rs`). Whatever the manager begins there takes it back.
    pub(super) lent: bool,
    pub(super) plan: Plan,
    /// Why it was last refused, so that it is reported once.
    pub(super) refusal: Option<BootError>,
    pub(super) timeout: Duration,
    pub(super) refresh: Duration,
    pub(super) phase: Phase,
    /// When it last gave a sign of life; meaningless while absent.
    pub(super) heard: Tick,
    /// When its last heartbeat came, if one ever did.
    pub(super) beat: Option<Tick>,
    /// Somebody else has stopped it, and it has not been brought up since.
    pub(super) held: bool,
    /// Why it was last lost; `None` while it is operational, or was never lost.
    pub(super) why: Option<Why>,
    /// When it last sent its first process data object; `None` since the last boot or loss.
    pub(super) updated: Option<Tick>,
    /// When it was last sent its outputs; `None` since the last boot or loss.
    pub(super) sent: Option<Tick>,
    /// When it became operational.
    pub(super) up_since: Tick,
    /// How long inputs that come with SYNC may stay away; `None` where they come by event.
    pub(super) inputs_within: Option<Duration>,
    /// How often in a row it has lost SYNC.
    pub(super) sync_losses: u32,
}

impl Peer {
    pub(super) fn new(node: NodeId, device: &Device, setup: &Setup, process: Process, timing: &Timing) -> Self {
        Peer {
            node,
            name: device.name.clone(),
            owner: device.owner,
            plan: plan(node, setup, &process, timing),
            is_vital: setup.when_lost == Reaction::Fault,
            process,
            errors: Errors::new(device.on_emergency()),
            flood: Flood::default(),
            told: TOLD,
            orders: ORDERS,
            writing: None,
            lent: false,
            refusal: None,
            timeout: timing.heartbeat_timeout,
            refresh: timing.refresh,
            phase: Phase::Absent { probe: Tick::ZERO },
            heard: Tick::ZERO,
            beat: None,
            held: false,
            why: None,
            updated: None,
            sent: None,
            up_since: Tick::ZERO,
            inputs_within: sync::inputs_within(device, timing),
            sync_losses: 0,
        }
    }

    /// Its inputs may be acted upon: it is operational, recently heard, and has sent them since it came up.
    pub(super) fn trusted(&self, now: Tick) -> bool {
        matches!(self.phase, Phase::Operational)
            && now.since(self.heard) < self.timeout
            && !self.errors.stand()
            && (!self.process.has_inputs() || self.updated.is_some())
            && self.process.fault(now).is_none()
    }

    /// It was lost because its heartbeat stopped, and none has come since.
    pub(super) fn lacks_heartbeat(&self) -> bool {
        self.why == Some(Why::Silent)
    }

    /// Its share of its owner's inputs. What it last said is kept for showing after a loss that makes the whole image
    /// invalid; of a device whose loss does not, nothing is kept.
    pub(super) fn input_bits(&self, now: Tick) -> u128 {
        if self.is_vital || self.trusted(now) { self.process.inputs() } else { 0 }
    }

    pub(super) fn updated(&self) -> Option<Tick> {
        self.updated.max(self.process.channels().and_then(Channels::updated))
    }

    pub(super) fn is_operational(&self) -> bool {
        matches!(self.phase, Phase::Operational)
    }

    pub(super) fn deadline(&self) -> Tick {
        let lost = self.heard + self.timeout;
        match &self.phase {
            Phase::Absent { probe } => *probe,
            Phase::Booting(boot) => boot.deadline(),
            Phase::Refused { retry, .. } => *retry,
            Phase::Starting { retry } => lost.min(*retry),
            Phase::Stopped => lost,
            Phase::Operational => {
                let refresh = self.sent.map_or(Tick::NEVER, |at| at + self.refresh);
                let writing = self.writing.as_ref().map_or(Tick::NEVER, |(_, transfer)| transfer.deadline());
                lost.min(refresh)
                    .min(self.process.deadline())
                    .min(writing)
                    .min(self.errors.deadline())
                    .min(self.misses_inputs_at())
            }
        }
        .min(self.flood.deadline())
    }

    /// Does what is due: noticing silence, asking again, refreshing outputs.
    pub(super) fn poll(&mut self, now: Tick, out: &mut Outbox) -> Outcome {
        self.flood.ends(now);
        // A device that is being configured may be silent for longer than its heartbeats are apart: it may not have
        // been told to send them yet, or be writing to its memory. The transfer knows how long to wait.
        // One that is refused may never have been told; its next boot finds out whether it is still there.
        let watched = !matches!(self.phase, Phase::Absent { .. } | Phase::Booting(_) | Phase::Refused { .. });
        if watched && self.heard + self.timeout <= now {
            // Said once: one that is heard otherwise is looked at again and again.
            if !self.lacks_heartbeat() {
                out.events.push(Event::DeviceLost { node: self.node, silent_for: now.since(self.heard) });
            }
            // Perhaps its heartbeat alone has ceased: then it hears this manager's, and would keep its outputs.
            self.send_rest(out);
            return self.leave(now, Phase::Absent { probe: now + RETRY }, Why::Silent);
        }
        if self.is_operational() && self.misses_inputs_at() <= now {
            return self.lose_sync(now, out);
        }
        match &mut self.phase {
            Phase::Absent { probe } if *probe <= now => {
                *probe = now + RETRY;
                if self.flood.is_on() {
                    return Outcome::Unchanged;
                }
                let raw = Request::Upload { object: DEVICE_TYPE }.encode();
                out.frames.push(Message::SdoRequest { node: self.node, raw }.encode());
            }
            Phase::Booting(boot) => {
                let step = boot.poll(now, &self.plan, &mut out.frames);
                self.booted(now, step, out);
            }
            Phase::Refused { retry, .. } if *retry <= now => self.boot(now, out),
            // One that watches SYNC by itself gives up before it is heard to run.
            Phase::Starting { retry } if *retry <= now && self.sync_losses > 0 => return self.lose_sync(now, out),
            // It is not started as it is: perhaps it has booted since, and nobody heard.
            Phase::Starting { retry } if *retry <= now => self.boot(now, out),
            Phase::Operational => {
                self.process.poll(now);
                self.go_on_writing(now, None, out);
                let free = self.writing.is_none() && !self.lent;
                let read = self.errors.poll(now, self.node, free, &mut out.frames);
                let news = self.register_read(now, read, out);
                if self.sent.is_some_and(|at| at + self.refresh <= now) {
                    self.send_outputs(now, out);
                }
                self.send_if_wanted(now, out);
                match self.judge_channels(now, out) {
                    Outcome::Unchanged if news => return Outcome::Inputs,
                    outcome => return outcome,
                }
            }
            _ => {}
        }
        Outcome::Unchanged
    }

    pub(super) fn heartbeat(&mut self, now: Tick, state: NmtState, out: &mut Outbox) -> Outcome {
        self.heard = now;
        self.beat = Some(now);
        if self.lacks_heartbeat() {
            self.why = None;
        }
        if state == NmtState::BootUp {
            // Another one may hang there now: what was found out about the last one does not count.
            self.errors.gone();
            self.refusal = None;
            self.sync_losses = 0;
        }
        match (&self.phase, state) {
            // Nothing was heard of it for a while, and it is as somebody left it.
            (Phase::Absent { .. }, NmtState::Stopped) if self.held => self.leave(now, Phase::Stopped, Why::Left(state)),
            (Phase::Absent { .. }, _) => {
                self.boot(now, out);
                Outcome::Unchanged
            }
            (_, NmtState::BootUp) => {
                self.tell(now, Event::DeviceRebooted { node: self.node }, out);
                let outcome = self.leave(now, Phase::Starting { retry: now }, Why::Booted);
                self.boot(now, out);
                outcome
            }
            // The order to stop it was lost: its outputs wait for a SYNC.
            (Phase::Refused { why: BootError::NoSync { .. }, .. }, NmtState::Operational) => {
                if self.orders.take(now) {
                    self.order(NmtCommand::Stop, out);
                }
                Outcome::Unchanged
            }
            // A stopped device answers no SDO: to be configured it must be woken.
            (Phase::Booting(_), NmtState::Stopped) => {
                if self.orders.take(now) {
                    self.order(NmtCommand::EnterPreOperational, out);
                }
                Outcome::Unchanged
            }
            (Phase::Starting { .. } | Phase::Stopped, NmtState::Operational) => self.up(now, out),
            // Still pre-operational after an order to start: this heartbeat may have crossed it, or `retry` boots it anew.
            (Phase::Booting(_) | Phase::Refused { .. }, _)
            | (Phase::Starting { .. }, NmtState::PreOperational)
            | (Phase::Operational, NmtState::Operational) => Outcome::Unchanged,
            // Somebody sent it there, or it has booted and nobody heard: its boot-up message was lost, and with it all it
            // had been told, the watch of this manager's heartbeat among it. It is never started as it is.
            (Phase::Stopped, NmtState::PreOperational) => {
                self.boot(now, out);
                Outcome::Unchanged
            }
            // It was started, and gave up before anything came with SYNC: one that watches SYNC by itself.
            (Phase::Operational, NmtState::PreOperational)
                if self.inputs_within.is_some() && self.updated.is_none() =>
            {
                self.lose_sync(now, out)
            }
            (Phase::Operational, NmtState::PreOperational) => {
                self.tell(now, Event::DeviceLeft { node: self.node, state }, out);
                let outcome = self.leave(now, Phase::Stopped, Why::Left(state));
                self.boot(now, out);
                outcome
            }
            (Phase::Starting { .. } | Phase::Operational, NmtState::Stopped | NmtState::Unknown(_)) => {
                self.tell(now, Event::DeviceLeft { node: self.node, state }, out);
                self.leave(now, Phase::Stopped, Why::Left(state))
            }
            (Phase::Stopped, NmtState::Stopped | NmtState::Unknown(_)) => Outcome::Unchanged,
        }
    }

    /// Takes its first process data object (its bits, or a drive's words), or one with channels, 2 to 4.
    /// Only an operational device sends process data (CiA 301 §7.3.2.2), so hearing it is as good as being told.
    pub(super) fn inputs_heard(&mut self, now: Tick, object: u8, payload: Payload, out: &mut Outbox) -> Outcome {
        match &self.phase {
            // Without heartbeats nobody would notice its end: process data alone do not make up for them. It is asked
            // and configured anew as one that is absent.
            Phase::Absent { .. } | Phase::Starting { .. } if self.lacks_heartbeat() => {
                return Outcome::Ignored(IgnoreReason::NotOperational);
            }
            Phase::Absent { .. } => {
                // Alive, but not configured by this manager: its inputs wait until it is.
                self.heard = now;
                self.boot(now, out);
                return Outcome::Ignored(IgnoreReason::NotOperational);
            }
            Phase::Booting(_) | Phase::Refused { .. } | Phase::Stopped => {
                return Outcome::Ignored(IgnoreReason::NotOperational);
            }
            Phase::Starting { .. } | Phase::Operational => {}
        }
        match self.process.take(now, object, payload) {
            Ok(()) if object == 1 => {
                self.updated = Some(now);
                self.hears_sync(now);
            }
            Ok(()) => {}
            Err(why) => return Outcome::Ignored(why),
        }
        if !self.is_operational() {
            return self.up(now, out);
        }
        // What it says may call for an answer: a drive's handshake.
        self.send_if_wanted(now, out);
        match self.judge_channels(now, out) {
            Outcome::Unchanged => Outcome::Inputs,
            news => news,
        }
    }

    /// Eight bytes of its SDO server. Those of a transfer between others are none of the manager's business.
    pub(super) fn sdo_answer(&mut self, now: Tick, raw: &Raw, out: &mut Outbox) -> Outcome {
        match &mut self.phase {
            Phase::Absent { .. } if !self.flood.is_on() => {
                self.heard = now;
                self.boot(now, out);
            }
            Phase::Booting(boot) => {
                self.heard = now;
                let step = boot.handle(now, &self.plan, raw, &mut out.frames);
                self.booted(now, step, out);
            }
            Phase::Operational if self.errors.is_reading() => {
                let read = self.errors.answer(now, raw, &mut out.frames);
                let news = self.register_read(now, read, out);
                self.send_if_wanted(now, out);
                return if news { Outcome::Inputs } else { Outcome::Unchanged };
            }
            Phase::Operational if self.writing.is_some() => {
                self.go_on_writing(now, Some(raw), out);
                self.send_if_wanted(now, out);
            }
            _ => return Outcome::Ignored(IgnoreReason::NotForManager),
        }
        Outcome::Unchanged
    }

    /// Takes the image its owner has set, and sends its share if it is operational and has something else.
    pub(super) fn set_image(&mut self, now: Tick, image: u128, out: &mut Outbox) {
        self.process.set_image(now, image);
        self.send_if_wanted(now, out);
    }

    /// Sends its share of the image if that is something else than it has.
    pub(super) fn send_if_wanted(&mut self, now: Tick, out: &mut Outbox) {
        if self.process.wants_to_send() {
            self.send_outputs(now, out);
        }
        self.write_if_wanted(now, out);
    }

    /// Sends its share of the image, provided it is operational: before that it would drop the frame, and the manager
    /// would believe it has the outputs.
    pub(super) fn send_outputs(&mut self, now: Tick, out: &mut Outbox) {
        if self.is_operational() && self.process.has_outputs() {
            let node = self.node;
            self.process.give(|object, payload| out.frames.push(rpdo(node, object, payload)));
            self.sent = Some(now);
        }
    }

    /// Lets go of all outputs, whatever state it is in.
    pub(super) fn send_rest(&self, out: &mut Outbox) {
        if self.process.has_outputs() {
            self.process.rest(|object, payload| out.frames.push(rpdo(self.node, object, payload)));
        }
    }

    fn up(&mut self, now: Tick, out: &mut Outbox) -> Outcome {
        self.up_since = now;
        self.phase = Phase::Operational;
        self.why = None;
        out.events.push(Event::DeviceUp { node: self.node });
        Outcome::Up
    }

    /// Leaves for `phase`. From here on its inputs are unknown and its outputs are taken to be off.
    pub(super) fn leave(&mut self, now: Tick, phase: Phase, why: Why) -> Outcome {
        let was_operational = self.is_operational();
        self.phase = phase;
        self.held |= matches!(why, Why::Left(NmtState::Stopped));
        self.why = Some(why);
        self.updated = None;
        self.sent = None;
        self.writing = None;
        self.lent = false;
        self.errors.lost();
        self.process.lost(now);
        if was_operational { Outcome::Lost } else { Outcome::Unchanged }
    }

    pub(super) fn order(&self, command: NmtCommand, out: &mut Outbox) {
        out.frames.push(Message::Nmt { command, node: Some(self.node) }.encode());
    }
}

/// How often a device is booted and ordered to start: a few times at once, and then twice a second or so. What goes on
/// faster than that does not go on.
const ORDERS: Budget = Budget::new(20, Duration::from_millis(200));

/// A process data object for a device: its first, or one with channels, 2 to 4.
fn rpdo(node: NodeId, object: u8, payload: Payload) -> crate::Frame {
    match object {
        1 => Message::Rpdo1 { node, payload },
        number => Message::Rpdo { node, number, payload },
    }
    .encode()
}
