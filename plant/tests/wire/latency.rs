//! Measurements on the bus, and their printed form.

use std::fmt;
use std::time::Duration;

use linewright_line::Tick;

/// Latencies of states.
#[derive(Clone, Debug, Default)]
pub struct Latencies(Vec<Duration>);

impl Latencies {
    pub fn add(&mut self, took: Duration) {
        self.0.push(took);
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// So long or less it took for this share of them.
    pub fn within(&self, share: f64) -> Duration {
        let mut sorted = self.0.clone();
        sorted.sort();
        sorted.get((sorted.len() as f64 * share) as usize).or(sorted.last()).copied().unwrap_or_default()
    }

    pub fn worst(&self) -> Duration {
        self.0.iter().max().copied().unwrap_or_default()
    }
}

impl fmt::Display for Latencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [p50, p90, p99, worst] = [0.5, 0.9, 0.99, 1.0].map(|share| self.within(share).as_micros());
        write!(f, "{:>5} states, 50 % {p50} µs, 90 % {p90} µs, 99 % {p99} µs, worst {worst} µs", self.len())
    }
}

/// Result of an exchange of process data.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// When all devices were up.
    pub up_after: Tick,
    /// From a switch to the image.
    pub inputs: Latencies,
    /// From the image to the device.
    pub outputs: Latencies,
    /// Duration.
    pub long: Duration,
    /// Time for which others had the bus.
    pub foreign: Duration,
    /// Time for which manager and devices had it.
    pub own: Duration,
    /// Share of the time for which others had it.
    pub foreign_share: f64,
    /// Frames of the manager that its interface had no room for.
    pub refused: usize,
    /// Number of times a device was lost.
    pub lost_devices: usize,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = |part: Duration| 100.0 * part.as_secs_f64() / self.long.as_secs_f64();
        writeln!(f, "  devices up after {} ms", self.up_after.since(Tick::ZERO).as_millis())?;
        writeln!(f, "  others {:.1} %, own frames {:.1} % of the time", share(self.foreign), share(self.own))?;
        writeln!(f, "  switch to image: {}", self.inputs)?;
        writeln!(f, "  image to device: {}", self.outputs)?;
        write!(f, "  {} frames found the interface's queue full", self.refused)
    }
}
