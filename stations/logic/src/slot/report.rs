//! Report of a station on its orders.

use crate::controller::Controller;
use crate::order::{SlotReport, TaskOrderReport, TaskReply};

impl Controller {
    /// Adds the state of its orders to `report`.
    pub(crate) fn report_orders(&self, report: &mut Option<TaskOrderReport>) {
        let Some(orders) = &self.orders else {
            *report = None;
            return;
        };
        let report = report.get_or_insert_with(TaskOrderReport::default);
        report.memory = orders.memory;
        report.epoch = orders.epoch;
        report.slot =
            orders.slot.map(|slot| SlotReport { key: slot.key, task: slot.task, is_securing: slot.phase.goes_back() });
        report.results.clear();
        report.results.extend(orders.results.iter().filter_map(|(key, reply)| match reply {
            TaskReply::Ended(outcome) => Some((*key, *outcome)),
            TaskReply::Running | TaskReply::Refused(_) => None,
        }));
        report.refused.clear();
        report.refused.extend(orders.results.iter().filter_map(|(key, reply)| match reply {
            TaskReply::Refused(refusal) => Some((*key, *refusal)),
            TaskReply::Running | TaskReply::Ended(_) => None,
        }));
        report.rest = self.rest();
        report.is_in_handshake = self.is_in_handshake();
    }
}
