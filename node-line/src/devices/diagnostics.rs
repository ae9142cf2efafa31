//! `/diagnostics`: each device in a status of its own.

use linewright_fieldbus_seam::{Diagnosis, Level};
use linewright_msgs::{DiagnosticStatus, KeyValue};

use super::Devices;

impl Devices {
    pub(super) fn message(&self, diagnosis: Diagnosis) -> DiagnosticStatus {
        let Diagnosis { device, owner, level, message, hardware_id, values, .. } = diagnosis;
        let owner = self.owners.iter().find(|(known, _)| *known == owner).map(|(_, name)| name.clone());
        let mut values: Vec<KeyValue> = values.into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
        values.push(KeyValue::new("belongs to", owner.unwrap_or_default()));
        let told = self.told.iter().find(|told| told.name == device);
        if let Some(told) = told.filter(|told| !told.failed.is_empty()) {
            values.push(KeyValue::new("last request", told.failed.clone()));
        }
        DiagnosticStatus {
            level: match level {
                Level::Ok => DiagnosticStatus::OK,
                Level::Warn => DiagnosticStatus::WARN,
                Level::Error => DiagnosticStatus::ERROR,
                Level::Stale => DiagnosticStatus::STALE,
            },
            name: format!("{}: {device}", self.node),
            message,
            hardware_id,
            values,
        }
    }
}
