//! The order and the state of the line as messages.

use std::time::SystemTime;

use linewright_coordinator_logic::EStopCause;
use linewright_coordinator_shell::{RefusalFacts, cell_check, commands_check};
use linewright_line::{StationId, Tick};
use linewright_msgs::{LineState, ModeOrder, Text};
use linewright_node_line::mode_to_code;
use linewright_node_shell::{JournalWriter, RecordTimes, stamp, unsent_messages};
use linewright_station_shell::{JournalFacts, journal_check, messages_check};

use crate::node::CoordinatorLoop;
use crate::topics::standing_message;

impl CoordinatorLoop {
    pub(crate) fn send_order(&mut self, sequence: u64) {
        let order = self.shell.order();
        let coordinator = self.shell.coordinator();
        let names = |is_it: &dyn Fn(StationId) -> bool| {
            let all = self.line.station_ids().filter(|&id| is_it(id));
            all.map(|id| self.line.station(id).name.clone()).collect()
        };
        self.says.order.send(ModeOrder {
            header: stamp(),
            boot_id: order.boot_id,
            sequence,
            epoch: order.epoch,
            mode: mode_to_code(order.mode),
            enabled: order.enabled,
            master_stop: order.master_stop.is_some(),
            stop_round: order.master_stop.unwrap_or(0),
            manual_all: order.manual_all,
            buttons: order.buttons,
            resume: order.resume,
            lease_ms: u32::try_from(order.lease.as_millis()).unwrap_or(u32::MAX),
            lives: self.line.station_ids().map(|id| coordinator.life_of(id)).collect(),
            found_generation: order.found.unwrap_or(0),
            stopped: names(&|id| self.shell.stopped().contains(&id)),
            manual: names(&|id| coordinator.is_led(id)),
            standing_by: names(&|id| coordinator.is_single(id) && !coordinator.is_led(id)),
        });
    }

    pub(crate) fn tell(&mut self, now: Tick, sequence: u64) {
        let coordinator = self.shell.coordinator();
        let order = coordinator.order();
        let since =
            coordinator.stop_cause().filter(|(cause, _)| *cause != EStopCause::Restarted).map(|(_, since)| since);
        let text = coordinator.text_with(self.stop_time.text((now, SystemTime::now()), since));
        // Latched for readers that request it, and repeated for those that do not, as `ros2 topic echo` may not.
        if text != self.text || now >= self.text_due {
            self.text_due = now + self.text_every;
            self.text.clone_from(&text);
            self.says.mode_text.send(Text { data: text.clone() });
        }
        let names = |ids: Vec<StationId>| ids.iter().map(|&id| self.line.station(id).name.clone()).collect();
        let heard = |id| match (coordinator.hears(id), self.shell.has_heard(id)) {
            (true, _) => LineState::HEARD_FRESH,
            (false, true) => LineState::HEARD_STALE,
            (false, false) => LineState::HEARD_UNKNOWN,
        };
        self.says.state.send(LineState {
            header: stamp(),
            boot_id: self.shell.boot_id(),
            sequence,
            description: self.descriptions.whole,
            epoch: order.epoch,
            mode: mode_to_code(order.mode),
            enabled: order.enabled,
            master_stop: order.master_stop.is_some(),
            text,
            stations: self.line.stations.iter().map(|station| station.name.clone()).collect(),
            station_heard: self.line.station_ids().map(heard).collect(),
            waiting_for: names(coordinator.waiting_for()),
            ..self.refusals.message(now, standing_message(&self.line, coordinator.standing()))
        });
    }

    /// Publishes the checks of the node, where they are due.
    pub(crate) fn tell_health(&mut self, now: Tick) {
        if now < self.health.deadline() {
            return;
        }
        let mut checks = self.shell.health(&self.line, now, &self.text);
        let journal = match self.journal.as_ref().map(JournalWriter::times) {
            Some(_) if self.shell.is_unwritten() => JournalFacts::Lost,
            Some(RecordTimes { records, last, longest }) => JournalFacts::Kept { records, last, longest },
            None => JournalFacts::None,
        };
        checks.push(journal_check(journal, self.line.timing.refresh));
        let (standing, senders) = (self.refusals.standing(now).0, self.refusals.senders());
        checks.push(commands_check(RefusalFacts { count: self.refusals.count, standing, senders: &senders }));
        let unsent = unsent_messages();
        checks.push(messages_check((self.ignored, unsent), self.lost.offer(now, self.ignored + unsent)));
        checks.extend(self.cell.as_ref().map(|cell| cell_check(cell.apart().is_unattended)));
        self.health.publish(now, checks);
    }
}
