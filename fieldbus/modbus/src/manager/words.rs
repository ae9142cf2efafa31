//! State of a device, in words.

use linewright_fieldbus_seam::{Diagnosis, Level, NOT_HEARD};
use linewright_line::{Owner, Tick};

use super::ModbusManager;
use super::peer::ModbusPeer;

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
            Some(why) if why.is_refusal => Level::Error,
            Some(_) => Level::Stale,
        }
    }

    /// Why it cannot be used at `now`: what happened, and what it waits for.
    fn trouble(&self, now: Tick) -> String {
        match (&self.why, self.retry()) {
            (Some(why), Some(retry)) => format!("{}; tried again in {} ms", why.text, retry.since(now).as_millis()),
            (Some(why), None) => why.text.clone(),
            (None, _) => self.doing(),
        }
    }

    fn doing(&self) -> String {
        match self.pending() {
            Some(request) if self.is_operational() => format!("no answer yet ({request})"),
            Some(request) => format!("connected; {request}"),
            None if self.is_operational() => "not asked for too long".to_owned(),
            None => "it is being connected to".to_owned(),
        }
    }

    fn diagnosis(&self, now: Tick) -> Diagnosis {
        let message = match self.updated {
            _ if !self.is_trusted(now) => self.trouble(now),
            _ if self.is_slow => format!("operational, but slow: {}", self.pace()),
            Some(at) => format!("operational; its inputs came {} ms ago", now.since(at).as_millis()),
            None => "operational".to_owned(),
        };
        Diagnosis {
            device: self.name.clone(),
            owner: self.owner,
            level: self.level(now),
            message,
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
