//! The shipped transfer bar in auto, with a clamp that is always ahead of it: for measuring.

use std::time::Duration;

use linewright_line::net::{Block, ControlMode};
use linewright_line::{Line, StationId, Tick};
use linewright_station_logic::{Controller, ModeOrder, Restore, Rules, StationInput, StationOutbox, StationReport};

pub const NOW: Tick = Tick::from_millis(1000);

pub struct TransferBar {
    pub controller: Controller,
    pub out: StationOutbox,
    line: Line,
}

impl TransferBar {
    /// The 1st lift is running.
    pub fn lifting() -> Self {
        let text = include_str!("../../../../launch-config/lines/transfer-line/line.toml");
        let mut line = linewright_line::parse("line.toml", text).expect("the shipped line is sound").line;
        line.timing.stale = Duration::from_secs(1 << 20);
        let controller =
            Controller::new(&line, StationId(0), 1, Restore::Fresh).expect("compiles").with_rules(Rules::COUNTS);
        let out = StationOutbox { events: Vec::with_capacity(1024), ..StationOutbox::default() };
        let mut bar = TransferBar { controller, out, line };
        bar.image(1 << bar.line.operation((StationId(0), bar.line.stations[0].home)).normal.complete.0);
        let ahead = vec![i32::MAX / 4; 2];
        let clamp = StationReport { boot_id: 1, done: ahead.clone(), started: ahead, ..StationReport::default() };
        bar.controller.handle(NOW, StationInput::View(StationId(1), &clamp));
        let order = ModeOrder::of(1, 1, ControlMode::Auto, Duration::from_secs(1 << 20));
        bar.controller.handle(NOW, StationInput::Order(order));
        bar.step();
        bar.image(0);
        bar.step();
        assert!(bar.out.outputs != 0, "it lifts");
        bar
    }

    pub fn step(&mut self) {
        self.controller.step(NOW, &mut self.out);
        self.out.events.clear();
    }

    pub fn image(&mut self, bits: u128) {
        self.controller.handle(
            NOW,
            StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: linewright_station_logic::NO_DELAY },
        );
    }

    /// The input that completes what is running.
    pub fn completion(&self) -> u128 {
        let place = self.controller.marking().next().expect("a token");
        let operation = self.line.operation((StationId(0), place.op));
        assert_eq!(place.block, Block::Normal);
        1 << operation.normal.complete.0
    }

    /// An input that completes nothing that is running.
    #[allow(dead_code, reason = "the bench's")]
    pub fn unused_input(&self) -> u128 {
        1 << self.line.operation((StationId(0), self.line.stations[0].home)).normal.complete.0
    }

    /// Every operation once.
    pub fn round(&mut self) {
        for _ in 0..10 {
            let arrived = self.completion();
            self.image(arrived);
            self.step();
            self.image(0);
            self.step();
        }
    }
}
