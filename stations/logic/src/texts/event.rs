//! Events; each follows the station's name.

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId};

use super::place::op_names;
use crate::event::{HappeningKind, StationHappening, StopCause};

impl StationHappening {
    /// The event as a text, for the station it belongs to.
    pub fn text(&self, line: &Line, station: StationId) -> String {
        let name = |op: OpId| line.operation((station, op)).name.as_str();
        let task = |task| line.station(station).task(task).name.as_str();
        let undoing = |block: Block| match block {
            Block::Normal => "",
            Block::Recovery => "undoing ",
        };
        match self.what {
            HappeningKind::Started(op, block) => format!("started {}{}", undoing(block), name(op)),
            HappeningKind::Completed(op, block) => format!("completed {}{}", undoing(block), name(op)),
            HappeningKind::Stopped(op, block, cause) => {
                format!("stopped {}{}: {}", undoing(block), name(op), cause.text_of(line, station, op, block))
            }
            HappeningKind::Withdrawn(0) => "takes nothing back".to_owned(),
            HappeningKind::Withdrawn(ops) => format!("takes back {}", op_names(line, station, ops)),
            HappeningKind::HomeAgain if line.station(station).is_task_driven() => {
                "returned to the rest where the task began".to_owned()
            }
            HappeningKind::HomeAgain => "returned home by recovery; the cycle will be repeated".to_owned(),
            HappeningKind::Founded => "began anew at home, with all stations".to_owned(),
            HappeningKind::Rejoined => "took its place from the limit switches, confirmed by an operator".to_owned(),
            HappeningKind::PositionLost(op, input) => StopCause::PositionLost { op, input }.detail(line, station),
            HappeningKind::IndexDoubtful(op, input, places) => {
                StopCause::IndexDoubtful { op, input, places }.detail(line, station)
            }
            HappeningKind::PositionFound => "position confirmed by the limit switches".to_owned(),
            HappeningKind::Asked(number) => format!("requested agreement (request {number})"),
            HappeningKind::NotAgreed { by, in_the_way } => {
                format!(
                    "request rejected by {}: {} has started",
                    line.station(by).name,
                    line.operation((by, in_the_way)).name
                )
            }
            HappeningKind::Refused => "rejected the command".to_owned(),
            HappeningKind::Mode(mode) => format!("changed to mode {mode}"),
            HappeningKind::Devices(true) => "I/O devices operational".to_owned(),
            HappeningKind::Devices(false) => StopCause::Devices.text().to_owned(),
            HappeningKind::Ordered(id) => format!("accepted a task order: {}", task(id)),
            HappeningKind::OrderRefused(refusal) => format!("task order {}", refusal.text()),
            HappeningKind::OrderDone(id) => format!("completed task {}", task(id)),
            HappeningKind::OrderFailed(id, failure) => format!("task {} failed: {}", task(id), failure.text()),
            HappeningKind::OrderLeft(id, code) => {
                format!("left task {} on request, while it waited for an input (code {code})", task(id))
            }
            HappeningKind::Securing(id) => format!("started undoing task {}", task(id)),
        }
    }
}
