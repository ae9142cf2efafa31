//! Restart of a station, with its memory and without.

use linewright_line::StationId;
use linewright_station_logic::{Controller, Restore, Rules, StationHappening, StationInput, StationReport};

use super::setting::LineExploration;
use super::station::Situation;

impl Situation {
    /// Comes up from its snapshot. It receives again the last report from each writer; buttons start released. With a rule off
    /// counts can contradict each other, which a station refuses in a snapshot: it does not come up, and stays as it is here.
    pub(super) fn restart(&mut self, setting: &LineExploration, events: &mut Vec<StationHappening>) {
        let station = self.controller.station();
        let held: Vec<(StationId, StationReport)> =
            setting.into(station.index()).filter_map(|link| self.heard_over(setting, link)).collect();
        if !self.begin_life(setting, Restore::From(self.controller.snapshot())) {
            return;
        }
        self.image(0, true, events);
        self.order(setting, events);
        for (writer, report) in held {
            self.controller.handle(self.now, StationInput::View(writer, &report));
            self.step(events);
        }
    }

    /// Comes up without its snapshot. Its switches show whether it is at home; reports it receives cannot be compared
    /// with anything.
    pub(super) fn forget(&mut self, setting: &LineExploration, events: &mut Vec<StationHappening>) {
        let (line, station) = (&setting.line, self.controller.station());
        self.stood = Some(self.controller.marking().collect());
        let home = line.operation((station, line.station(station).home)).normal.complete.bit();
        let at_home = if self.controller.is_at_home() { home } else { 0 };
        self.begin_life(setting, Restore::Fresh);
        self.open = 0;
        self.image(at_home, true, events);
        self.image(0, true, events);
        self.order(setting, events);
    }

    /// Whether it came up.
    fn begin_life(&mut self, setting: &LineExploration, restore: Restore) -> bool {
        let life = self.controller.writer().boot_id + 1;
        match Controller::new(&setting.line, self.controller.station(), life, restore) {
            Ok(controller) => self.controller = controller.with_rules(setting.rules),
            Err(why) => {
                let Rules { counted, withdraw_first, ask, fresh_numbers, redo_round, home_waits, .. } = setting.rules;
                let all = counted && withdraw_first && ask && fresh_numbers && redo_round && home_waits;
                assert!(!all, "its program has compiled before, and with all rules its own snapshot fits it: {why}");
                return false;
            }
        }
        (self.key, self.button, self.outputs) = (None, None, 0);
        true
    }

    /// The last report that it received over a link, but for the answer to a request that it has forgotten.
    fn heard_over(&self, setting: &LineExploration, link: usize) -> Option<(StationId, StationReport)> {
        let writer = StationId::at(setting.links[link].writer);
        let held = self.controller.held(writer)?;
        let (cycle, done) = (held.cycle, held.done.to_vec());
        let generation = held.generation;
        Some((
            writer,
            StationReport { boot_id: 1, generation, cycle, done, request: held.request, ..StationReport::default() },
        ))
    }
}
