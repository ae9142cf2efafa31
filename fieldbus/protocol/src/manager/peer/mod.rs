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
//! Booting (`manager/boot.rs`) comes before starting, also for a device found operational: it must be the device that
//! is expected, and its heartbeat consumer must watch *this* manager before an output is energised. A stopped device
//! stays stopped: another node ordered that, and the manager does not override it. Only frames from the device change
//! its phase; the manager's own frames prove nothing.
//!
//! Here are the phases and what leads from one to another. Beside it: bringing it up (`boot.rs`), its share of the outputs
//! (`outputs.rs`), its SDO channel while it runs (`sdo_channel.rs`), SYNC (`sync.rs`), whether its inputs are trusted
//! (`trust.rs`), and its state in words (`explain.rs`).

mod boot;
mod explain;
mod outputs;
mod sdo_channel;
mod sync;
mod trust;

use std::time::Duration;

use linewright_fieldbus_seam::Budget;
use linewright_line::{Device, DeviceSetup, Owner, Reaction, Tick, Timing};
pub(super) use sdo_channel::SdoChannelState;

use super::boot::{Boot, BootError, BootPlan, DEVICE_TYPE, plan};
use super::channels::AnalogueChannels;
use super::errors::Errors;
use super::event::{BusEvent, BusOutbox};
use super::fault::IgnoreReason;
use super::process::ProcessData;
use super::rate_limit::NodeRateLimits;
use super::status::DeviceCondition;
use super::sync::inputs_within;
use super::transfer::Transfer;
use super::{REPORTS, RETRY};
use crate::codec::{CanopenMessage, Emergency, NmtCommand, NmtState, NodeId, Payload};
use crate::sdo::SdoWrite;
use crate::sdo::wire::{ClientFrame, SdoBytes};

/// Effect of a frame or the passing of time on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PeerChange {
    /// No effect on its owner.
    Unchanged,
    /// The frame has no meaning here.
    Ignored(IgnoreReason),
    /// It has become operational.
    Up,
    /// It has sent inputs, or whether it can be trusted has changed.
    Inputs,
    /// It was operational, and is no longer, or not to be trusted.
    Lost,
}

/// Why a device is not operational any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NotOperationalReason {
    /// Its heartbeat stopped, and none has come since.
    Silent,
    Booted,
    /// The inputs that come with SYNC have stopped.
    NoSync,
    /// Its heartbeat has another state.
    Left(NmtState),
    /// It has reported that it let go by itself.
    Reported(Emergency),
    /// The manager's interface has left the bus.
    BusOff,
    Contested,
    /// It sent too much.
    Babbled,
}

#[derive(Debug)]
pub(super) enum PeerPhase {
    /// Silent; probed again at `probe`.
    Absent { probe: Tick },
    /// Alive; it is being identified and configured.
    Booting(Boot),
    /// It must not be started. Looked at again at `retry`, and when it boots: it may have been repaired.
    Refused { why: BootError, retry: Tick },
    /// Configured and ordered to start; ordered again at `retry`.
    Starting { retry: Tick },
    /// Exchanging process data.
    Operational,
    /// In a state that another node put it in.
    Stopped,
}

pub(super) struct Peer {
    pub(super) node: NodeId,
    pub(super) name: String,
    pub(super) owner: Owner,
    /// Its owner depends on it.
    pub(super) is_vital: bool,
    pub(super) process: ProcessData,
    pub(super) errors: Errors,
    pub(super) flood: NodeRateLimits,
    /// Limit of reports of it, and limit of its boots and start orders.
    pub(super) reports: Budget,
    pub(super) orders: Budget,
    /// Setting being written while it runs.
    pub(super) writing: Option<(SdoWrite, Transfer)>,
    /// Its SDO channel is lent to a request (`manager/request.rs`). Whatever the manager begins there takes it back.
    pub(super) lent: bool,
    pub(super) plan: BootPlan,
    /// Why it was last refused, so that it is reported once.
    pub(super) refusal: Option<BootError>,
    pub(super) timeout: Duration,
    pub(super) refresh: Duration,
    pub(super) phase: PeerPhase,
    /// When it last gave a sign of life; meaningless while absent.
    pub(super) alive_at: Tick,
    /// When its last heartbeat came, if one ever did.
    pub(super) beat: Option<Tick>,
    /// Another node has stopped it, and it has not been brought up since.
    pub(super) held: bool,
    /// Why it was last lost; `None` while it is operational, or was never lost.
    pub(super) why: Option<NotOperationalReason>,
    /// When it last sent its first process data object; `None` since the last boot or loss.
    pub(super) updated: Option<Tick>,
    /// When it was last sent its outputs; `None` since the last boot or loss.
    pub(super) sent: Option<Tick>,
    /// When it became operational.
    pub(super) up_since: Tick,
    /// Most time between inputs that come with SYNC; `None` where they come by event.
    pub(super) inputs_within: Option<Duration>,
    /// Number of times in a row that it has lost SYNC.
    pub(super) sync_losses: u32,
}

impl Peer {
    pub(super) fn new(
        node: NodeId,
        device: &Device,
        setup: &DeviceSetup,
        process: ProcessData,
        timing: &Timing,
    ) -> Self {
        Peer {
            node,
            name: device.name.clone(),
            owner: device.owner,
            plan: plan(node, setup, &process, timing),
            is_vital: setup.when_lost == Reaction::Fault,
            process,
            errors: Errors::new(device.on_emergency()),
            flood: NodeRateLimits::default(),
            reports: REPORTS,
            orders: ORDERS,
            writing: None,
            lent: false,
            refusal: None,
            timeout: timing.heartbeat_timeout,
            refresh: timing.refresh,
            phase: PeerPhase::Absent { probe: Tick::ZERO },
            alive_at: Tick::ZERO,
            beat: None,
            held: false,
            why: None,
            updated: None,
            sent: None,
            up_since: Tick::ZERO,
            inputs_within: inputs_within(device, timing),
            sync_losses: 0,
        }
    }

    /// Its inputs may be acted upon: it is operational, not silent, and has sent them since it came up.
    pub(super) fn trusted(&self, now: Tick) -> bool {
        matches!(self.phase, PeerPhase::Operational)
            && now.since(self.alive_at) < self.timeout
            && !self.errors.stand()
            && (!self.process.has_inputs() || self.updated.is_some())
            && self.process.fault(now).is_none()
    }

    /// It was lost because its heartbeat stopped, and none has come since.
    pub(super) fn lacks_heartbeat(&self) -> bool {
        self.why == Some(NotOperationalReason::Silent)
    }

    /// Its share of its owner's inputs. The last ones are kept for display after a loss that makes the whole image
    /// invalid; otherwise none are kept.
    pub(super) fn input_bits(&self, now: Tick) -> u128 {
        if self.is_vital || self.trusted(now) { self.process.inputs() } else { 0 }
    }

    pub(super) fn updated(&self) -> Option<Tick> {
        self.updated.max(self.process.channels().and_then(AnalogueChannels::updated))
    }

    pub(super) fn is_operational(&self) -> bool {
        matches!(self.phase, PeerPhase::Operational)
    }

    pub(super) fn condition(&self) -> DeviceCondition {
        match self.phase {
            PeerPhase::Absent { .. } => DeviceCondition::Absent,
            PeerPhase::Booting(_) | PeerPhase::Starting { .. } => DeviceCondition::Booting,
            PeerPhase::Refused { .. } => DeviceCondition::Refused,
            PeerPhase::Operational => DeviceCondition::Operational,
            PeerPhase::Stopped => DeviceCondition::Stopped,
        }
    }

    pub(super) fn deadline(&self) -> Tick {
        let lost = self.alive_at + self.timeout;
        match &self.phase {
            PeerPhase::Absent { probe } => *probe,
            PeerPhase::Booting(boot) => boot.deadline(),
            PeerPhase::Refused { retry, .. } => *retry,
            PeerPhase::Starting { retry } => lost.min(*retry),
            PeerPhase::Stopped => lost,
            PeerPhase::Operational => {
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

    /// Does what is due: detects silence, probes again, refreshes outputs.
    pub(super) fn poll(&mut self, now: Tick, out: &mut BusOutbox) -> PeerChange {
        self.flood.ends(now);
        // A device that is being configured may be silent for longer than its heartbeats are apart: they may not be
        // configured yet, or it may be writing to its memory. The transfer has its own time limit. One that is refused
        // may never have been configured; its next boot finds out whether it is still there.
        let watched =
            !matches!(self.phase, PeerPhase::Absent { .. } | PeerPhase::Booting(_) | PeerPhase::Refused { .. });
        if watched && self.alive_at + self.timeout <= now {
            // Reported once: one whose other frames arrive is looked at again and again.
            if !self.lacks_heartbeat() {
                out.events.push(BusEvent::DeviceLost { node: self.node, silent_for: now.since(self.alive_at) });
            }
            // Perhaps its heartbeat alone has ceased: then it receives this manager's, and would keep its outputs.
            self.send_rest(out);
            return self.leave(now, PeerPhase::Absent { probe: now + RETRY }, NotOperationalReason::Silent);
        }
        if self.is_operational() && self.misses_inputs_at() <= now {
            return self.lose_sync(now, out);
        }
        match &mut self.phase {
            PeerPhase::Absent { probe } if *probe <= now => {
                *probe = now + RETRY;
                if self.flood.is_on() {
                    return PeerChange::Unchanged;
                }
                let raw = ClientFrame::Upload { object: DEVICE_TYPE }.encode();
                out.frames.push(CanopenMessage::SdoRequest { node: self.node, raw }.encode());
            }
            PeerPhase::Booting(boot) => {
                let step = boot.poll(now, &self.plan, &mut out.frames);
                self.booted(now, step, out);
            }
            PeerPhase::Refused { retry, .. } if *retry <= now => self.boot(now, out),
            // One that watches SYNC by itself gives up before its running is received.
            PeerPhase::Starting { retry } if *retry <= now && self.sync_losses > 0 => return self.lose_sync(now, out),
            // It is not started as it is: it may have booted since without its boot-up message arriving.
            PeerPhase::Starting { retry } if *retry <= now => self.boot(now, out),
            PeerPhase::Operational => {
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
                    PeerChange::Unchanged if news => return PeerChange::Inputs,
                    outcome => return outcome,
                }
            }
            _ => {}
        }
        PeerChange::Unchanged
    }

    pub(super) fn heartbeat(&mut self, now: Tick, state: NmtState, out: &mut BusOutbox) -> PeerChange {
        self.alive_at = now;
        self.beat = Some(now);
        if self.lacks_heartbeat() {
            self.why = None;
        }
        if state == NmtState::BootUp {
            // It may have been replaced: findings about the last one do not count.
            self.errors.gone();
            self.refusal = None;
            self.sync_losses = 0;
        }
        match (&self.phase, state) {
            // It was silent for a while, and is still in the state that another node put it in.
            (PeerPhase::Absent { .. }, NmtState::Stopped) if self.held => {
                self.leave(now, PeerPhase::Stopped, NotOperationalReason::Left(state))
            }
            (PeerPhase::Absent { .. }, _) => {
                self.boot(now, out);
                PeerChange::Unchanged
            }
            (_, NmtState::BootUp) => {
                self.report(now, BusEvent::DeviceRebooted { node: self.node }, out);
                let outcome = self.leave(now, PeerPhase::Starting { retry: now }, NotOperationalReason::Booted);
                self.boot(now, out);
                outcome
            }
            // The order to stop it was lost: its outputs wait for a SYNC.
            (PeerPhase::Refused { why: BootError::NoSync { .. }, .. }, NmtState::Operational) => {
                if self.orders.take(now) {
                    self.order(NmtCommand::Stop, out);
                }
                PeerChange::Unchanged
            }
            // A stopped device answers no SDO: to be configured it must be woken.
            (PeerPhase::Booting(_), NmtState::Stopped) => {
                if self.orders.take(now) {
                    self.order(NmtCommand::EnterPreOperational, out);
                }
                PeerChange::Unchanged
            }
            (PeerPhase::Starting { .. } | PeerPhase::Stopped, NmtState::Operational) => self.up(now, out),
            // Still pre-operational after an order to start: this heartbeat may have crossed it, or `retry` boots it anew.
            (PeerPhase::Booting(_) | PeerPhase::Refused { .. }, _)
            | (PeerPhase::Starting { .. }, NmtState::PreOperational)
            | (PeerPhase::Operational, NmtState::Operational) => PeerChange::Unchanged,
            // Another node put it in this state, or it has booted and its boot-up message was lost, and with it all its
            // settings, the watch of this manager's heartbeat among them. It is never started as it is.
            (PeerPhase::Stopped, NmtState::PreOperational) => {
                self.boot(now, out);
                PeerChange::Unchanged
            }
            // It was started, and gave up before anything came with SYNC: one that watches SYNC by itself.
            (PeerPhase::Operational, NmtState::PreOperational)
                if self.inputs_within.is_some() && self.updated.is_none() =>
            {
                self.lose_sync(now, out)
            }
            (PeerPhase::Operational, NmtState::PreOperational) => {
                self.report(now, BusEvent::DeviceLeft { node: self.node, state }, out);
                let outcome = self.leave(now, PeerPhase::Stopped, NotOperationalReason::Left(state));
                self.boot(now, out);
                outcome
            }
            (PeerPhase::Starting { .. } | PeerPhase::Operational, NmtState::Stopped | NmtState::Unknown(_)) => {
                self.report(now, BusEvent::DeviceLeft { node: self.node, state }, out);
                self.leave(now, PeerPhase::Stopped, NotOperationalReason::Left(state))
            }
            (PeerPhase::Stopped, NmtState::Stopped | NmtState::Unknown(_)) => PeerChange::Unchanged,
        }
    }

    /// Takes its first process data object (its bits, or a drive's words), or one with channels, 2 to 4. Only an
    /// operational device sends process data (CiA 301 §7.3.2.2), so receiving it proves the state.
    pub(super) fn take_inputs(&mut self, now: Tick, object: u8, payload: Payload, out: &mut BusOutbox) -> PeerChange {
        match &self.phase {
            // Without heartbeats its end would go unnoticed: process data alone do not make up for them. It is probed
            // and configured anew as one that is absent.
            PeerPhase::Absent { .. } | PeerPhase::Starting { .. } if self.lacks_heartbeat() => {
                return PeerChange::Ignored(IgnoreReason::NotOperational);
            }
            PeerPhase::Absent { .. } => {
                // Alive, but not configured by this manager: its inputs wait until it is.
                self.alive_at = now;
                self.boot(now, out);
                return PeerChange::Ignored(IgnoreReason::NotOperational);
            }
            PeerPhase::Booting(_) | PeerPhase::Refused { .. } | PeerPhase::Stopped => {
                return PeerChange::Ignored(IgnoreReason::NotOperational);
            }
            PeerPhase::Starting { .. } | PeerPhase::Operational => {}
        }
        match self.process.take(now, object, payload) {
            Ok(()) if object == 1 => {
                self.updated = Some(now);
                self.sync_holds(now);
            }
            Ok(()) => {}
            Err(why) => return PeerChange::Ignored(why),
        }
        if !self.is_operational() {
            return self.up(now, out);
        }
        // The inputs may require an answer: a drive's handshake.
        self.send_if_wanted(now, out);
        match self.judge_channels(now, out) {
            PeerChange::Unchanged => PeerChange::Inputs,
            news => news,
        }
    }

    /// Eight bytes of its SDO server. Those of a transfer between others are none of the manager's business.
    pub(super) fn sdo_answer(&mut self, now: Tick, raw: &SdoBytes, out: &mut BusOutbox) -> PeerChange {
        match &mut self.phase {
            PeerPhase::Absent { .. } if !self.flood.is_on() => {
                self.alive_at = now;
                self.boot(now, out);
            }
            PeerPhase::Booting(boot) => {
                self.alive_at = now;
                let step = boot.handle(now, &self.plan, raw, &mut out.frames);
                self.booted(now, step, out);
            }
            PeerPhase::Operational if self.errors.is_reading() => {
                let read = self.errors.answer(now, raw, &mut out.frames);
                let news = self.register_read(now, read, out);
                self.send_if_wanted(now, out);
                return if news { PeerChange::Inputs } else { PeerChange::Unchanged };
            }
            PeerPhase::Operational if self.writing.is_some() => {
                self.go_on_writing(now, Some(raw), out);
                self.send_if_wanted(now, out);
            }
            _ => return PeerChange::Ignored(IgnoreReason::NotForManager),
        }
        PeerChange::Unchanged
    }

    fn up(&mut self, now: Tick, out: &mut BusOutbox) -> PeerChange {
        self.up_since = now;
        self.phase = PeerPhase::Operational;
        self.why = None;
        out.events.push(BusEvent::DeviceUp { node: self.node });
        PeerChange::Up
    }

    /// Leaves for `phase`. From here on its inputs are unknown and its outputs are taken to be off.
    pub(super) fn leave(&mut self, now: Tick, phase: PeerPhase, why: NotOperationalReason) -> PeerChange {
        let was_operational = self.is_operational();
        self.phase = phase;
        self.held |= matches!(why, NotOperationalReason::Left(NmtState::Stopped));
        self.why = Some(why);
        self.updated = None;
        self.sent = None;
        self.writing = None;
        self.lent = false;
        self.errors.lost();
        self.process.lost(now);
        if was_operational { PeerChange::Lost } else { PeerChange::Unchanged }
    }

    pub(super) fn order(&self, command: NmtCommand, out: &mut BusOutbox) {
        out.frames.push(CanopenMessage::Nmt { command, node: Some(self.node) }.encode());
    }
}

/// Limit on boots and start orders of a device: a few times at once, and then twice a second or so. Faster repetitions
/// are cut off.
const ORDERS: Budget = Budget::new(20, Duration::from_millis(200));
