//! State of a device in one sentence, put together from its phase and what it has sent.

use linewright_line::Tick;

use super::super::RETRY;
use super::super::rate_limit::{FRAMES_MAX, WINDOW};
use super::{NotOperationalReason, Peer, PeerPhase};
use crate::codec::NmtState;

impl Peer {
    /// Its state at `now`, and what it waits for, in one sentence.
    pub(in crate::manager) fn explain(&self, now: Tick) -> String {
        let silent = now.since(self.alive_at).as_millis();
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
                    let inputs = now.since(at).as_millis();
                    let error = self.errors.explain(self.process.profile());
                    let own = self.process.explain().into_iter().chain(error).map(|own| format!("; {own}"));
                    let own: String = own.collect();
                    format!("operational; its heartbeat came {silent} ms ago, its inputs {inputs} ms ago{own}")
                }
                None => format!("operational; its heartbeat came {silent} ms ago, its inputs have not come yet"),
            },
            PeerPhase::Stopped => {
                format!("stopped by somebody else, and left so; its heartbeat came {silent} ms ago")
            }
        }
    }

    /// Why it cannot be trusted at `now`: first the cause, then what it waits for. `None` if it can.
    pub(in crate::manager) fn trouble(&self, now: Tick) -> Option<String> {
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
                    self.reported_state()
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
        if now.since(self.alive_at) >= self.timeout {
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

    /// Text of its silence, with its duration.
    fn silence(&self, now: Tick) -> String {
        let Some(beat) = self.beat else {
            let nothing = format!("never heard: no boot-up and no heartbeat ({}, 1017h)", self.beat_id());
            return if self.alive_at == Tick::ZERO {
                nothing
            } else {
                format!("no heartbeat ({}, 1017h) ever came", self.beat_id())
            };
        };
        let since = now.since(beat).as_millis();
        // Whatever came clearly later than its last heartbeat shows that it lives.
        let lives = self.alive_at > beat + self.timeout;
        let other = if lives { ", though it answers (SDO)" } else { "" };
        format!("no heartbeat (1017h) for {since} ms{other}")
    }

    /// The identifier of its heartbeat.
    fn beat_id(&self) -> String {
        format!("{:03X}h", 0x700 + u16::from(self.node.get()))
    }

    fn reported_state(&self) -> String {
        match self.why {
            Some(NotOperationalReason::Left(state)) => format!("{:02X}h ({})", state.code(), self.beat_id()),
            _ => self.beat_id(),
        }
    }
}
