//! `/diagnostics`: the checks of a node, each in a status of its own, once a period.

use std::sync::Arc;
use std::time::Duration;

use linewright_line::Tick;
use linewright_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue, fitting};
use linewright_node_shell::{Publisher, RosNode, TopicError, qos, stamp};
use linewright_station_shell::{HealthCheck, HealthLevel};

/// Period until [`HealthTopic::report_every`] sets another one.
const EVERY: Duration = Duration::from_secs(1);

/// The diagnostics of a node.
pub struct HealthTopic {
    publisher: Arc<Publisher<DiagnosticArray>>,
    /// Name of the node, before the name of each check.
    node: String,
    hardware_id: String,
    every: Duration,
    last: Tick,
    due: Tick,
}

impl HealthTopic {
    /// Opens the topic. `hardware_id`: the machine that the node controls.
    ///
    /// # Errors
    /// When the middleware refuses the topic.
    pub fn open(node: &mut RosNode, hardware_id: &str) -> Result<Self, TopicError> {
        Ok(HealthTopic {
            publisher: Arc::new(node.publisher("/diagnostics", qos::event())?),
            node: node.name().to_owned(),
            hardware_id: hardware_id.to_owned(),
            every: EVERY,
            last: Tick::ZERO,
            due: Tick::ZERO,
        })
    }

    /// The publisher, for the diagnostics of the node's devices.
    pub fn publisher(&self) -> &Arc<Publisher<DiagnosticArray>> {
        &self.publisher
    }

    /// Sets the period.
    pub fn report_every(&mut self, every: Duration) {
        self.every = every;
        self.due = self.due.min(self.last + every);
    }

    /// When the next report is due.
    pub fn deadline(&self) -> Tick {
        self.due
    }

    /// Publishes `checks`.
    pub fn publish(&mut self, now: Tick, checks: Vec<HealthCheck>) {
        self.last = now;
        self.due = now + self.every;
        let status = checks.into_iter().map(|check| status_message(&self.node, &self.hardware_id, check)).collect();
        self.publisher.send(DiagnosticArray { header: stamp(), status });
    }
}

/// A check as a status. There is no level for what is not heard: that is decided by the reader.
pub fn status_message(node: &str, hardware_id: &str, check: HealthCheck) -> DiagnosticStatus {
    let HealthCheck { name, level, message, values } = check;
    DiagnosticStatus {
        level: match level {
            HealthLevel::Ok => DiagnosticStatus::OK,
            HealthLevel::Warn => DiagnosticStatus::WARN,
            HealthLevel::Error => DiagnosticStatus::ERROR,
        },
        name: format!("{node}: {name}"),
        message: fitting(message),
        hardware_id: hardware_id.to_owned(),
        values: values.into_iter().map(|(key, value)| KeyValue::new(key, fitting(value))).collect(),
    }
}
