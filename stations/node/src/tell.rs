//! What the station publishes about itself: its state, and what has happened.

use linewright_line::{OpId, Tick};
use linewright_msgs::{StationEvent, StationState, fitting};
use linewright_node_line::{kind_of, report_to_message};
use linewright_node_shell::{JournalWriter, RecordTimes, stamp, unsent_messages};
use linewright_station_logic::{HappeningKind, StationHappening};
use linewright_station_shell::{JournalFacts, StationFacts, journal_check, messages_check};

use crate::node::StationLoop;

impl StationLoop {
    pub(crate) fn tell_state(&mut self, now: Tick, sequence: u64) {
        report_to_message(&self.line, self.shell.controller(), now, &mut self.message);
        let StationState { devices_valid, fault, blocked_by, .. } = &mut self.message;
        self.words.complete(*devices_valid, fault, blocked_by);
        if !self.shell.is_active() {
            let (state, way) = (self.shell.lifecycle().label(), self.shell.lifecycle().way_to_active());
            self.message.blocked_by.insert(0, format!("node {state}: {way}"));
        }
        self.message.lifecycle = self.shell.lifecycle().code();
        self.message.header = stamp();
        self.message.boot_id = self.shell.boot_id();
        self.message.sequence = sequence;
        self.says.state.send(self.message.clone());
    }

    /// Publishes the checks of the node, where they are due.
    pub(crate) fn tell_health(&mut self, now: Tick) {
        if now < self.health.deadline() {
            return;
        }
        let StationState { operation, fault, blocked_by, .. } = &self.message;
        let facts = StationFacts { operation, fault, waits_for: blocked_by };
        let mut checks = self.shell.health(&self.line, now, facts);
        // A record that cannot be written ends the node.
        let journal = self.journal.as_ref().map(JournalWriter::times);
        let journal = journal.map_or(JournalFacts::None, |RecordTimes { records, last, longest }| JournalFacts::Kept {
            records,
            last,
            longest,
        });
        checks.push(journal_check(journal, self.line.timing.refresh));
        let (ignored, unsent) = (self.shell.ignored(), unsent_messages());
        checks.push(messages_check((ignored, unsent), self.lost.offer(now, ignored + unsent)));
        self.health.publish(now, checks);
    }

    pub(crate) fn tell_ignored(&mut self, count: u64, why: &str) {
        tracing::warn!(station = self.name, ignored = count, "ignored a message: {why}");
        let cycle = self.shell.controller().cycle();
        self.send_event(StationEvent::KIND_IGNORED, None, cycle, format!("ignored {count} so far: {why}"));
    }

    pub(crate) fn tell_event(&mut self, event: &StationHappening) {
        let text = self.text_of(event);
        tracing::info!(station = self.name, cycle = event.cycle, "{text}");
        let (kind, op) = kind_of(event);
        self.send_event(kind, op, event.cycle, text);
    }

    fn send_event(&mut self, kind: u8, op: Option<OpId>, cycle: i32, text: String) {
        self.event_sequence += 1;
        self.says.event.send(StationEvent {
            header: stamp(),
            station: self.name.clone(),
            sequence: self.event_sequence,
            kind,
            operation: op.map(|op| self.line.operation((self.station, op)).name.clone()).unwrap_or_default(),
            cycle,
            text: fitting(text),
        });
    }

    fn text_of(&self, event: &StationHappening) -> String {
        let text = self.words.event(event, self.shell.controller().event_text(&self.line, event));
        if event.what == HappeningKind::Refused {
            // The reasons are those of the state it was refused in, which is still the present one.
            let reasons = self.shell.controller().blocked_by(&self.line, self.clock.now());
            format!("{text}: waits for {}", reasons.join("; "))
        } else {
            text
        }
    }
}
