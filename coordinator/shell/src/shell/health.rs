//! The checks of the coordinator for diagnostics.

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick};
use linewright_station_shell::{HealthCheck, HealthLevel};

use super::CoordinatorShell;

/// The checks of the coordinator's node, in the order of its reports: the last where it runs a flexible cell.
const COORDINATOR_CHECKS: [&str; 6] = ["mode", "stations", "journal", "commands", "messages", "cell"];

/// The checks of the coordinator's node, in the order of its reports.
pub fn coordinator_checks(has_cell: bool) -> &'static [&'static str] {
    if has_cell { &COORDINATOR_CHECKS } else { &COORDINATOR_CHECKS[..5] }
}

/// The check of a cell's decisions, which stop while its log cannot be written.
pub fn cell_check(is_unattended: bool) -> HealthCheck {
    match is_unattended {
        true => HealthCheck::new("cell", HealthLevel::Error, "no decisions: its log is not writable"),
        false => HealthCheck::new("cell", HealthLevel::Ok, "it decides, and its log is written"),
    }
}

/// What the coordinator's node has refused, by sender.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RefusalFacts<'a> {
    /// Commands refused since the node started.
    pub count: u64,
    /// The refusal that stands; empty for none.
    pub standing: &'a str,
    /// Senders, and how many commands of each were refused.
    pub senders: &'a [(String, u64)],
}

/// The check of the commands. A command that is refused is no fault of the coordinator: it is answered with the reason.
pub fn commands_check(facts: RefusalFacts<'_>) -> HealthCheck {
    let (level, message) = match (facts.standing, facts.count) {
        ("", 0) => (HealthLevel::Ok, "none refused".to_owned()),
        ("", count) => (HealthLevel::Ok, format!("{count} refused since the coordinator started")),
        (standing, _) => (HealthLevel::Warn, format!("refused: {standing}")),
    };
    let check = HealthCheck::new("commands", level, message).with("refused", facts.count);
    facts.senders.iter().fold(check, |check, (sender, count)| check.with(format!("refused of {sender}"), count))
}

impl CoordinatorShell {
    /// The checks of mode and stations; `text` is the mode as operators read it. Those of journal, commands and messages are the node's.
    pub fn health(&self, line: &Line, now: Tick, text: &str) -> Vec<HealthCheck> {
        vec![self.mode_check(line, text), self.stations_check(line, now)]
    }

    /// Whether the last record could not be written.
    pub fn is_unwritten(&self) -> bool {
        self.write_again.is_some()
    }

    fn mode_check(&self, line: &Line, text: &str) -> HealthCheck {
        let (order, waiting) = (self.coordinator.order(), self.coordinator.waiting_for());
        let waits: Vec<&str> = waiting.iter().map(|&id| line.station(id).name.as_str()).collect();
        let level = match order.mode {
            ControlMode::EStop => HealthLevel::Error,
            _ if !self.coordinator.standing().obstacles.is_empty() => HealthLevel::Error,
            _ if self.coordinator.is_troubled() || !waits.is_empty() => HealthLevel::Warn,
            _ => HealthLevel::Ok,
        };
        HealthCheck::new("mode", level, text)
            .with("mode", order.mode)
            .with("epoch", order.epoch)
            .with("enabled", order.enabled)
            .with("stops at home", order.master_stop.is_some())
            .with("waits for", waits.join(", "))
            .with("lease", format!("{} ms", order.lease.as_millis()))
            .with("boot id", self.boot_id)
    }

    fn stations_check(&self, line: &Line, now: Tick) -> HealthCheck {
        let name = |id: StationId| line.station(id).name.as_str();
        let named = |ids: &[StationId]| ids.iter().map(|&id| name(id)).collect::<Vec<_>>().join(", ");
        let (received, missing): (Vec<StationId>, Vec<StationId>) =
            line.station_ids().partition(|&id| self.coordinator.hears(id));
        let (inactive, silent): (Vec<StationId>, Vec<StationId>) =
            missing.into_iter().partition(|&id| self.coordinator.inactive_node(id).is_some());
        let mut parts = Vec::new();
        for (what, ids) in [("not received", &silent), ("node not active", &inactive)] {
            if !ids.is_empty() {
                parts.push(format!("{what}: {}", named(ids)));
            }
        }
        let (level, message) = match (silent.is_empty(), inactive.is_empty()) {
            (false, _) => (HealthLevel::Error, parts.join("; ")),
            (true, false) => (HealthLevel::Warn, parts.join("; ")),
            (true, true) => (HealthLevel::Ok, format!("{} received", received.len())),
        };
        let mut check = HealthCheck::new("stations", level, message);
        for id in line.station_ids() {
            let states = &self.states[id.index()];
            let age = states.current().map(|_| format!("{} ms", now.since(states.heard()).as_millis()));
            check = check
                .with(format!("{}: age of the state", name(id)), age.unwrap_or_else(|| "none received".to_owned()))
                .with(format!("{}: states missed", name(id)), states.missed())
                .with(format!("{}: restarts seen", name(id)), states.replaced())
                .with(format!("{}: devices operational", name(id)), self.has_devices[id.index()]);
        }
        check
    }
}
