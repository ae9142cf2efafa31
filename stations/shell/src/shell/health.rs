//! The checks of a station for diagnostics.

use linewright_line::{DeviceBus, Line, StationId, Tick};

use super::StationShell;
use crate::health::{HealthCheck, HealthLevel, ms};

/// What a station's node has published last about itself, for its checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StationFacts<'a> {
    /// What each branch does.
    pub operation: &'a str,
    /// The fault; empty for none.
    pub fault: &'a str,
    /// Conditions it waits for.
    pub waits_for: &'a [String],
}

impl StationShell {
    /// The checks of the station itself; those of journal and messages are the node's.
    pub fn health(&self, line: &Line, now: Tick, facts: StationFacts<'_>) -> Vec<HealthCheck> {
        vec![self.operation_check(line, now, facts), self.coordinator_check(now), self.peers_check(line, now)]
    }

    /// Messages ignored since the node started.
    pub fn ignored(&self) -> u64 {
        self.ignored
    }

    fn operation_check(&self, line: &Line, now: Tick, facts: StationFacts<'_>) -> HealthCheck {
        let report = self.controller.report();
        let waits = facts.waits_for.join("; ");
        let mode = self.controller.mode();
        let (level, message) = if !self.is_active() {
            let (state, way) = (self.lifecycle.label(), self.lifecycle.way_to_active());
            (HealthLevel::Warn, format!("node {state}: {way}"))
        } else if !facts.fault.is_empty() {
            (HealthLevel::Error, facts.fault.to_owned())
        } else if !report.devices_valid {
            (HealthLevel::Error, format!("devices not operational: {waits}"))
        } else if !report.incomplete.is_empty() || report.recovering_home {
            (HealthLevel::Warn, format!("{mode}: {}; waits for {waits}", facts.operation))
        } else if waits.is_empty() {
            (HealthLevel::Ok, format!("{mode}: {}", facts.operation))
        } else {
            (HealthLevel::Ok, format!("{mode}: {}; waits for {waits}", facts.operation))
        };
        let check = HealthCheck::new("operation", level, message)
            .with("mode", mode)
            .with("node", self.lifecycle.label())
            .with("operation", facts.operation)
            .with("waits for", waits)
            .with("cycle", report.cycle)
            .with("stopped", report.stopped)
            .with("devices operational", report.devices_valid);
        // A bus of its own is read in the same process: its image has no age between two nodes.
        if line.station(self.controller.station()).bus != DeviceBus::Line {
            return check;
        }
        let age = self.images.current().map(|_| ms(now.since(self.images.heard())));
        check
            .with("age of the input image", age.unwrap_or_else(|| "none received".to_owned()))
            .with("input images missed", self.images.missed())
    }

    fn coordinator_check(&self, now: Tick) -> HealthCheck {
        let age = self.orders.current().map(|_| now.since(self.orders.heard()));
        let (level, message) = match (self.contest, age) {
            (Some(contest), _) if now < contest.until => {
                let (followed, other) = contest.lives;
                (HealthLevel::Error, format!("two coordinators give orders, boot ids {followed} and {other}"))
            }
            (_, None) => (HealthLevel::Warn, "no order of the mode received for this start of the station".to_owned()),
            (_, Some(age)) if age >= self.lease && self.is_active() => {
                (HealthLevel::Error, format!("no order of the mode for {}: the lease has run out", ms(age)))
            }
            (_, Some(age)) if age >= self.lease => {
                (HealthLevel::Warn, format!("no order of the mode for {}, as the node is not active", ms(age)))
            }
            (_, Some(_)) => (HealthLevel::Ok, format!("epoch {} followed", self.controller.mode_epoch())),
        };
        HealthCheck::new("coordinator", level, message)
            .with("boot id", self.orders.current().map_or(0, |(boot_id, _)| boot_id))
            .with("epoch", self.controller.mode_epoch())
            .with("age of the order", age.map_or_else(|| "none received".to_owned(), ms))
            .with("lease", ms(self.lease))
            .with("orders missed", self.orders.missed())
            .with("restarts seen", self.orders.replaced())
    }

    fn peers_check(&self, line: &Line, now: Tick) -> HealthCheck {
        let name = |id: StationId| line.station(id).name.clone();
        let age = |id: StationId| {
            let states = &self.states[id.index()];
            states.current().map(|_| now.since(states.heard()))
        };
        let peers = self.controller.peers();
        let missing = peers.iter().filter(|id| age(**id).is_none_or(|age| age >= self.stale));
        let missing: Vec<String> = missing.map(|id| name(*id)).collect();
        let mut check = match missing.is_empty() {
            true if peers.is_empty() => HealthCheck::new("stations", HealthLevel::Ok, "none that it works with"),
            true => HealthCheck::new("stations", HealthLevel::Ok, format!("{} received", peers.len())),
            false => HealthCheck::new("stations", HealthLevel::Warn, format!("not received: {}", missing.join(", "))),
        };
        for &id in peers {
            let states = &self.states[id.index()];
            let age = age(id).map_or_else(|| "none received".to_owned(), ms);
            check = check
                .with(format!("{}: age of the state", name(id)), age)
                .with(format!("{}: states missed", name(id)), states.missed())
                .with(format!("{}: restarts seen", name(id)), states.replaced());
        }
        check
    }
}
