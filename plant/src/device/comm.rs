//! The CANopen part of every simulated device: network management, heartbeats both ways, emergencies, and the server of
//! its dictionary.
//!
//! ```text
//!  Booting ──boot-up message──▶ PreOperational ──start──▶ Operational
//!     ▲                             ▲    ▲                 │      │
//!     │                             │    └─ pre-op, manager lost  │ stop
//!     │                             └────────────── Stopped ◀─────┘   (start leads back to Operational)
//!     └── reset node, reset communication: from every state
//! ```
//!
//! It has no profile: a device that leaves the operational state gets a [`CommChange`], and lets go in its own way.

use std::sync::Arc;
use std::time::Duration;

use linewright_canopen::MANAGER_NODE;
use linewright_canopen::codec::{
    BUS_OFF_RECOVERED, CanopenMessage, Emergency, HEARTBEAT_LOST, NO_ERROR, NmtCommand, NmtState, NodeId,
};
use linewright_canopen::sdo::{Abort, ObjectId, SdoServer};
use linewright_line::{Tick, Timing};

use super::DeviceOutbox;
use super::bytes::exactly;
use super::on_error::Behaviour;
use super::trouble::InjectedFaults;
use crate::fault::DeviceFault;

/// Duration of a boot. Short against any timeout, long enough that a reboot is a gap and not an instant.
const BOOT: Duration = Duration::from_millis(20);
/// Error register (object 1001h): generic and communication error.
const COMMUNICATION_ERROR: u8 = 0x11;
/// Bytes of an object written at most; all of them are shorter.
const LEN_MAX: usize = 64;
/// What a device is part of that belongs to no line.
const NO_LINE: &str = "no line";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CommState {
    Booting { until: Tick },
    PreOperational,
    Operational,
    Stopped,
}

/// Effect of a frame or the passing of time on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CommChange {
    Nothing,
    /// It has been started.
    Started,
    /// It has been stopped.
    Stopped,
    /// It has been sent to pre-operational.
    PreOperational,
    /// It has lost its manager while that mattered.
    Lost,
    /// It boots: everything but its mechanics begins anew.
    Boots,
}

#[derive(Debug)]
pub(super) struct Comm {
    pub node: NodeId,
    pub state: CommState,
    pub trouble: InjectedFaults,
    /// Object 1017h.
    heartbeat: Duration,
    next_heartbeat: Tick,
    /// Object 1016h sub 1: the watched node, and its timeout.
    watched: Option<(NodeId, Duration)>,
    /// When the watched node counts as lost; `None` until its first heartbeat (CiA 301 §7.2.8.3.2.2).
    lost_at: Option<Tick>,
    /// Object 1001h, communication part.
    pub error_register: u8,
    pub server: SdoServer,
    /// Object 5F06h.
    pub part_of: Arc<str>,
}

impl Comm {
    pub fn new(now: Tick, node: NodeId, timing: &Timing) -> Self {
        Comm {
            node,
            state: CommState::Booting { until: now + BOOT },
            trouble: InjectedFaults::default(),
            heartbeat: timing.heartbeat,
            next_heartbeat: Tick::NEVER,
            watched: Some((MANAGER_NODE, timing.heartbeat_timeout)),
            lost_at: None,
            error_register: 0,
            server: SdoServer::new(LEN_MAX),
            part_of: NO_LINE.into(),
        }
    }

    pub fn nmt_state(&self) -> NmtState {
        match self.state {
            CommState::Booting { .. } => NmtState::BootUp,
            CommState::PreOperational => NmtState::PreOperational,
            CommState::Operational => NmtState::Operational,
            CommState::Stopped => NmtState::Stopped,
        }
    }

    pub fn is_operational(&self) -> bool {
        self.state == CommState::Operational
    }

    /// Whether it receives frames at all.
    pub fn hears(&self) -> bool {
        !self.trouble.is_mute() && !matches!(self.state, CommState::Booting { .. })
    }

    /// Takes a message that is not process data and no service data.
    /// `behaviour` is what it does when it has lost its manager.
    pub fn handle(
        &mut self,
        now: Tick,
        message: &CanopenMessage,
        behaviour: Behaviour,
        out: &mut DeviceOutbox,
    ) -> CommChange {
        match *message {
            CanopenMessage::Nmt { command, node } if node.is_none_or(|node| node == self.node) => {
                self.obey(now, command)
            }
            CanopenMessage::Heartbeat { node, state } => self.watch(now, (node, state), behaviour, out),
            _ => CommChange::Nothing,
        }
    }

    pub fn poll(&mut self, now: Tick, behaviour: Behaviour, out: &mut DeviceOutbox) -> CommChange {
        if let CommState::Booting { until } = self.state
            && until <= now
        {
            self.state = CommState::PreOperational;
            self.send(&CanopenMessage::Heartbeat { node: self.node, state: NmtState::BootUp }, out);
            self.schedule_heartbeat(now);
        }
        self.speak_up(now, out);
        let mut change = CommChange::Nothing;
        if self.lost_at.is_some_and(|at| at <= now) {
            change = self.lose_manager(behaviour, out);
        }
        if self.next_heartbeat <= now {
            if !self.trouble.no_heartbeat {
                self.send(&CanopenMessage::Heartbeat { node: self.node, state: self.nmt_state() }, out);
            }
            self.schedule_heartbeat(now);
        }
        change
    }

    /// When [`Comm::poll`] or its server has something to do next; [`Tick::NEVER`] if nothing.
    pub fn next_deadline(&self) -> Tick {
        let boot = match self.state {
            CommState::Booting { until } => until,
            _ => Tick::NEVER,
        };
        let unsaid = self.trouble.unsaid.filter(|_| self.hears());
        let own =
            self.lost_at.into_iter().chain(self.server.next_deadline()).chain(self.trouble.off_until).chain(unsaid);
        own.fold(boot.min(self.next_heartbeat), Tick::min)
    }

    fn obey(&mut self, now: Tick, command: NmtCommand) -> CommChange {
        match command {
            NmtCommand::Start if self.state != CommState::Operational => {
                self.state = CommState::Operational;
                CommChange::Started
            }
            NmtCommand::Start | NmtCommand::Unknown(_) => CommChange::Nothing,
            NmtCommand::Stop => {
                self.enter(CommState::Stopped);
                CommChange::Stopped
            }
            NmtCommand::EnterPreOperational => {
                self.enter(CommState::PreOperational);
                CommChange::PreOperational
            }
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => self.boot(now),
        }
    }

    pub fn boot(&mut self, now: Tick) -> CommChange {
        self.enter(CommState::Booting { until: if self.trouble.dead { Tick::NEVER } else { now + BOOT } });
        self.next_heartbeat = Tick::NEVER;
        self.lost_at = None;
        self.error_register = 0;
        CommChange::Boots
    }

    fn enter(&mut self, state: CommState) {
        self.state = state;
        if state != CommState::PreOperational {
            self.server.reset();
        }
    }

    /// Takes the heartbeat of another node.
    fn watch(
        &mut self,
        now: Tick,
        (node, state): (NodeId, NmtState),
        behaviour: Behaviour,
        out: &mut DeviceOutbox,
    ) -> CommChange {
        let Some((_, timeout)) = self.watched.filter(|(watched, _)| *watched == node) else {
            return CommChange::Nothing;
        };
        let mut change = CommChange::Nothing;
        if state == NmtState::BootUp && self.lost_at.is_some() {
            // It has booted: its earlier orders are forgotten.
            change = self.lose_manager(behaviour, out);
        }
        if self.lost_at.is_none() && self.error_register != 0 {
            self.error_register = 0;
            self.report(NO_ERROR, 0, out);
        }
        self.lost_at = Some(now + timeout);
        change
    }

    fn lose_manager(&mut self, behaviour: Behaviour, out: &mut DeviceOutbox) -> CommChange {
        self.lose(behaviour, HEARTBEAT_LOST, out)
    }

    /// The heartbeat or SYNC that it depends on has stopped; `code` is the emergency for it.
    pub fn lose(&mut self, behaviour: Behaviour, code: u16, out: &mut DeviceOutbox) -> CommChange {
        self.lost_at = None;
        self.error_register = COMMUNICATION_ERROR;
        match (self.state, behaviour) {
            (CommState::Operational | CommState::PreOperational, Behaviour::Stopped) => {
                // Sent before it may no longer send.
                self.report(code, 0, out);
                self.enter(CommState::Stopped);
                return CommChange::Lost;
            }
            (CommState::Operational, Behaviour::PreOperational) => self.enter(CommState::PreOperational),
            (CommState::Operational, Behaviour::NoChange) => {}
            (CommState::Booting { .. } | CommState::PreOperational | CommState::Stopped, _) => {
                self.report(code, 0, out);
                return CommChange::Nothing;
            }
        }
        self.report(code, 0, out);
        CommChange::Lost
    }

    /// Sends an emergency; `more` are bits of the error register beyond those of communication.
    pub fn report(&self, code: u16, more: u8, out: &mut DeviceOutbox) {
        let emergency = Emergency { code, register: self.register() | more, vendor: [0; 5] };
        // A stopped device sends nothing but heartbeats (CiA 301 §7.3.2.2).
        if self.state != CommState::Stopped {
            self.send(&CanopenMessage::Emergency { node: self.node, emergency }, out);
        }
    }

    /// Object 1001h as far as it is not the profile's.
    pub fn register(&self) -> u8 {
        self.error_register | self.trouble.register()
    }

    pub fn inject(&mut self, now: Tick, fault: Option<DeviceFault>, behaviour: Behaviour) -> CommChange {
        let trouble = &mut self.trouble;
        match fault {
            None => {
                let before = std::mem::take(trouble);
                trouble.unsaid = before.error.map(|_| now);
                // The emergency for it is sent at the next poll.
                trouble.off_until = before.off_until.map(|_| now);
                if before.dead {
                    return self.boot(now);
                }
            }
            Some(DeviceFault::Silent) => trouble.silent = true,
            Some(DeviceFault::Reboot) => {
                trouble.silent = false;
                return self.boot(now);
            }
            Some(DeviceFault::NoBoot) => {
                trouble.dead = true;
                return self.boot(now);
            }
            Some(DeviceFault::NoHeartbeat) => trouble.no_heartbeat = true,
            Some(DeviceFault::Identity { object, value }) => trouble.answer_falsely(object, value),
            Some(DeviceFault::Abort { object, code, reading, writing }) => {
                trouble.refuse(object, code, reading, writing);
            }
            Some(DeviceFault::Emergency { code, register }) => {
                trouble.error = Some((code, register));
                trouble.unsaid = Some(now);
            }
            Some(DeviceFault::BusOff { millis }) => {
                trouble.off_until = Some(now + Duration::from_millis(millis.into()));
                // An error of communication as any other (object 1029h).
                return self.lose_manager(behaviour, &mut DeviceOutbox::default());
            }
        }
        CommChange::Nothing
    }

    /// Reports changes: that it was off the bus, that it is in error or no longer.
    fn speak_up(&mut self, now: Tick, out: &mut DeviceOutbox) {
        if self.trouble.off_until.is_some_and(|until| until <= now) {
            self.trouble.off_until = None;
            self.report(BUS_OFF_RECOVERED, 0, out);
        }
        if self.hears() && self.trouble.unsaid.take_if(|since| *since <= now).is_some() {
            let code = self.trouble.error.map_or(NO_ERROR, |(code, _)| code);
            self.report(code, 0, out);
        }
    }

    /// From now, not from the last one: a caller that is late does not get a burst.
    fn schedule_heartbeat(&mut self, now: Tick) {
        self.next_heartbeat = if self.heartbeat.is_zero() { Tick::NEVER } else { now + self.heartbeat };
    }

    pub fn send(&self, message: &CanopenMessage, out: &mut DeviceOutbox) {
        if !self.trouble.is_mute() {
            out.frames.push(message.encode());
        }
    }

    /// Objects 1016h and 1017h; `None` for any other.
    pub fn read(&self, ObjectId { index, sub }: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
        let millis = |span: Duration| span.as_millis().min(0xFFFF) as u16;
        match (index, sub) {
            (0x1016, 0) => Some(Ok(vec![1])),
            (0x1016, 1) => {
                let watch = |(node, timeout): (NodeId, _)| u32::from(node.get()) << 16 | u32::from(millis(timeout));
                Some(Ok(self.watched.map_or(0, watch).to_le_bytes().into()))
            }
            (0x1017, 0) => Some(Ok(millis(self.heartbeat).to_le_bytes().into())),
            (0x1016 | 0x1017, _) => Some(Err(Abort::NO_SUBINDEX)),
            _ => None,
        }
    }

    /// The same objects written; `None` for any other, and for what can only be read.
    pub fn write(&mut self, now: Tick, object: ObjectId, data: &[u8]) -> Option<Result<(), Abort>> {
        match (object.index, object.sub) {
            (0x1016, 1) => Some(self.write_watched(now, data)),
            (0x1017, 0) => Some(exactly(data).map(|bytes| {
                self.heartbeat = Duration::from_millis(u16::from_le_bytes(bytes).into());
                self.schedule_heartbeat(now);
            })),
            _ => None,
        }
    }

    /// Object 1016h sub 1: node id in bits 16 to 23, time in ms below; 0 in either switches the watch off.
    fn write_watched(&mut self, now: Tick, data: &[u8]) -> Result<(), Abort> {
        let [low, high, node, reserved] = exactly(data)?;
        if reserved != 0 || node > 127 {
            return Err(Abort::VALUE);
        }
        let timeout = Duration::from_millis(u16::from_le_bytes([low, high]).into());
        self.watched = NodeId::new(node).filter(|_| !timeout.is_zero()).map(|node| (node, timeout));
        // The standard starts the watch with the first heartbeat. Here it starts at once: the node that configures the
        // watch is there, and if it goes away before its first heartbeat that is a loss too.
        self.lost_at = self.watched.map(|(_, timeout)| now + timeout);
        Ok(())
    }
}
