//! Diagnosis of a device, and why its inputs are invalid.

use linewright_fieldbus_seam::{Diagnosis, Level, NOT_HEARD};
use linewright_line::{Owner, Tick};

use super::ModbusManager;
use super::peer::ModbusPeer;
use crate::texts::ModbusCondition;

impl ModbusManager {
    /// Why the inputs of `owner` are invalid at `now`: a sentence for each of its devices that is in the way.
    pub fn trouble(&self, now: Tick, owner: Owner) -> Vec<String> {
        let own = self.peers.iter().filter(|peer| peer.owner == owner && !peer.is_trusted(now));
        own.map(|peer| format!("{} ({}): {}", peer.name, peer.modbus.place(), peer.trouble(now))).collect()
    }

    pub fn diagnoses(&self, now: Tick) -> Vec<Diagnosis> {
        self.peers.iter().map(|peer| peer.diagnosis(now)).collect()
    }

    /// The name of each device, and its state in the words of `ros2_canopen`.
    pub fn states(&self) -> impl Iterator<Item = (&str, &'static str)> {
        self.peers.iter().map(|peer| (peer.name.as_str(), peer.state()))
    }
}

impl ModbusPeer {
    fn state(&self) -> &'static str {
        if self.is_operational() {
            "START"
        } else if self.is_preparing() {
            "PREOP"
        } else {
            NOT_HEARD
        }
    }

    fn level(&self, now: Tick) -> Level {
        match &self.why {
            None if !self.is_operational() => Level::Warn,
            None if !self.is_trusted(now) => Level::Error,
            None if self.is_slow => Level::Warn,
            None => Level::Ok,
            Some(why) if why.is_refusal() => Level::Error,
            Some(_) => Level::Stale,
        }
    }

    /// Why it cannot be used at `now`.
    fn trouble(&self, now: Tick) -> ModbusCondition<'_> {
        match (&self.why, self.pending()) {
            (Some(trouble), _) => ModbusCondition::Down { trouble, retry: self.retry().map(|retry| retry.since(now)) },
            (None, Some(request)) if self.is_operational() => ModbusCondition::Unanswered(request),
            (None, Some(request)) => ModbusCondition::Preparing(request),
            (None, None) if self.is_operational() => ModbusCondition::Unasked,
            (None, None) => ModbusCondition::Connecting,
        }
    }

    fn condition(&self, now: Tick) -> ModbusCondition<'_> {
        match self.updated {
            _ if !self.is_trusted(now) => self.trouble(now),
            _ if self.is_slow => ModbusCondition::Slow { took: self.took, cycle: self.modbus.cycle },
            updated => ModbusCondition::Operational { inputs: updated.map(|at| now.since(at)) },
        }
    }

    fn diagnosis(&self, now: Tick) -> Diagnosis {
        Diagnosis {
            device: self.name.clone(),
            owner: self.owner,
            level: self.level(now),
            message: self.condition(now).to_string(),
            hardware_id: format!("Modbus {}", self.modbus.place()),
            state: Some(self.state()),
            error: None,
            losses: self.losses,
            values: vec![
                ("address", self.modbus.place()),
                ("state", self.state().to_owned()),
                ("last answer took", format!("{} ms", self.took.as_millis())),
                ("losses", self.losses.to_string()),
            ],
        }
    }
}
