//! Diagnosis of a device, for `/diagnostics`.

use linewright_line::Owner;

/// The state of a silent device, in the words of `ros2_canopen`.
pub const NOT_HEARD: &str = "ERROR";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// It works.
    Ok,
    /// It works, or is about to, but something is to be looked at.
    Warn,
    /// It does not work.
    Error,
    /// It is silent.
    Stale,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    pub device: String,
    pub owner: Owner,
    pub level: Level,
    pub message: String,
    /// Its identity and its place.
    pub hardware_id: String,
    /// Its state in the words of `ros2_canopen`, of a kind that has one.
    pub state: Option<&'static str>,
    /// The code of its last error report, of a kind that has such.
    pub error: Option<u16>,
    /// Number of times it was operational and then was not.
    pub losses: u32,
    /// More, by name.
    pub values: Vec<(&'static str, String)>,
}

impl Diagnosis {
    /// Key whose change makes a diagnosis news: sentences count milliseconds, and differ each time.
    pub fn key(&self) -> (Level, Option<&'static str>, Option<u16>, u32) {
        (self.level, self.state, self.error, self.losses)
    }
}
