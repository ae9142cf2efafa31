//! `/diagnostics`: each device in a status of its own.

use linewright_canopen::manager::{Condition, PlainStatus, Status};
use linewright_fieldbus::Driver;
use linewright_line::{Device, Tick};
use linewright_msgs::{Byte, DiagnosticStatus, KeyValue};

use super::{Devices, Plain, Told, names};

impl Devices {
    pub(super) fn diagnosis(&self, now: Tick, driver: &Driver, status: &Status<'_>, told: &Told) -> DiagnosticStatus {
        let manager = driver.manager();
        let trouble = manager.trouble_of(now, status.node);
        let emergency = status.emergency.map_or_else(
            || "none".to_owned(),
            |(at, emergency)| format!("{} ({} s ago)", emergency.text(status.profile), now.since(at).as_secs()),
        );
        let mut values = vec![
            KeyValue::new("node id", format!("{:02X}h", status.node.get())),
            KeyValue::new("state", names::state_word(status.nmt)),
            KeyValue::new("belongs to", told.owner.clone()),
            KeyValue::new("last emergency", emergency),
            KeyValue::new("losses", status.losses.to_string()),
            KeyValue::new("frames ignored", status.ignored.to_string()),
        ];
        if !told.failed.is_empty() {
            values.push(KeyValue::new("last request", told.failed.clone()));
        }
        DiagnosticStatus {
            level: level(status, trouble.is_some()),
            name: format!("{}: {}", self.node, status.name),
            message: trouble.or_else(|| manager.explain(now, status.node)).unwrap_or_default(),
            hardware_id: hardware_id(&told.device),
            values,
        }
    }

    pub(super) fn plain_diagnosis(&self, status: &PlainStatus<'_>, plain: &Plain) -> DiagnosticStatus {
        DiagnosticStatus {
            level: match (status.live, status.heard) {
                (true, _) => DiagnosticStatus::OK,
                (false, true) => DiagnosticStatus::ERROR,
                (false, false) => DiagnosticStatus::STALE,
            },
            name: format!("{}: {}", self.node, status.name),
            message: status.is.clone(),
            hardware_id: format!("frames of {}", plain.file),
            values: vec![
                KeyValue::new("belongs to", plain.owner.clone()),
                KeyValue::new("losses", status.losses.to_string()),
            ],
        }
    }
}

fn level(status: &Status<'_>, trouble: bool) -> Byte {
    let emergency = status.emergency.is_some_and(|(_, emergency)| emergency.code != 0);
    match status.condition {
        Condition::Absent => DiagnosticStatus::STALE,
        Condition::Refused | Condition::Stopped => DiagnosticStatus::ERROR,
        Condition::Booting => DiagnosticStatus::WARN,
        Condition::Operational if trouble => DiagnosticStatus::ERROR,
        Condition::Operational if emergency => DiagnosticStatus::WARN,
        Condition::Operational => DiagnosticStatus::OK,
    }
}

/// Its identity as far as the description knows it, and where it hangs.
fn hardware_id(device: &Device) -> String {
    let identity = &device.setup.identity;
    let numbers = [("vendor", identity.vendor), ("product", identity.product), ("serial", identity.serial)];
    let known = numbers.iter().filter_map(|(what, number)| Some(format!(", {what} {:08X}h", (*number)?)));
    format!("CANopen node {:02X}h{}", device.node_id, known.collect::<String>())
}
