//! A clamp of the transfer line behind the gateway, with what arrives there.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, OperationModule, StationId, Tick, TransferLine, parse};
use linewright_station_logic::{Controller, ModeOrder, PanelCommand, Restore, Rules, StationReport};
use linewright_station_shell::{Driven, InputsMessage, ParticipantId, StationArrival, StationEffect, StationShell};

/// The life of the coordinator that is followed, and of another one.
pub const FOLLOWED: u64 = 11;
pub const OTHER: u64 = 12;
/// The first life of the station.
pub const LIFE: u64 = 7;
/// The console at its panel.
pub const CONSOLE: u64 = 21;
pub const ADVANCE: OpId = OpId(1);

/// Participant of a coordinator in one of its lives.
pub fn sender_of(life: u64) -> ParticipantId {
    let mut id = [0; 12];
    id[..8].copy_from_slice(&life.to_le_bytes());
    id
}

pub struct Rig {
    pub line: Line,
    pub shell: StationShell,
    pub now: Tick,
    pub effects: Vec<StationEffect>,
    pub sequence: u64,
    pub lives: u64,
    station: StationId,
    peers: Vec<(StationId, StationReport)>,
}

impl Rig {
    /// In manual, as the coordinator's epoch 5 has it, and open.
    pub fn new() -> Self {
        let line = parse("line.toml", &TransferLine::default().text()).expect("the shipped line").line;
        let station = line.station_named("clamp_1").expect("a clamp");
        // The bar lies: all that the clamp waits for is done.
        let peer = |id| {
            let mut report = Controller::new(&line, id, 1, Restore::Fresh).expect("it compiles").report();
            report.done.fill(1);
            (id, report)
        };
        let peers = line.station_ids().filter(|&id| id != station).map(peer).collect();
        let shell = StationShell::new(&line, station, LIFE, Restore::Fresh).expect("it compiles");
        // Its peers were never at home with it, and do not report where they stand.
        let shell = shell.with_rules(Rules::COUNTS);
        let mut rig = Rig {
            line,
            shell,
            now: Tick::from_millis(1000),
            effects: Vec::new(),
            sequence: 0,
            lives: 40,
            station,
            peers,
        };
        rig.order(FOLLOWED, 5, ControlMode::Manual);
        rig.inputs(true);
        rig.act();
        rig.effects.clear();
        rig
    }

    /// The station is started again without its memory; it has followed no coordinator yet.
    pub fn restart(&mut self) {
        let shell = StationShell::new(&self.line, self.station, LIFE + 1, Restore::Fresh).expect("it compiles");
        self.shell = shell.with_rules(Rules::COUNTS);
    }

    pub fn timing(&self) -> linewright_line::Timing {
        self.line.timing
    }

    pub fn mode(&self) -> ControlMode {
        self.shell.controller().mode()
    }

    pub fn take(&mut self, arrival: StationArrival<'_>) {
        self.shell.handle(self.now, arrival, &mut self.effects);
    }

    pub fn order(&mut self, life: u64, epoch: u64, mode: ControlMode) {
        self.sequence += 1;
        self.order_numbered(self.sequence, life, epoch, mode);
    }

    pub fn order_numbered(&mut self, sequence: u64, life: u64, epoch: u64, mode: ControlMode) {
        self.order_to(self.shell.boot_id(), sequence, (life, epoch, mode));
    }

    /// An order to a life of the station, by its number and the coordinator's life, epoch and mode.
    pub fn order_to(&mut self, station_life: u64, sequence: u64, (life, epoch, mode): (u64, u64, ControlMode)) {
        let lease = self.timing().lease;
        let manual_all = mode == ControlMode::Manual;
        let order = ModeOrder { manual_all, station_life, ..ModeOrder::of(life, epoch, mode, lease) };
        self.take(StationArrival::Order { sequence, from: sender_of(life), order });
    }

    /// The image of the clamp standing open, or between its ends.
    pub fn inputs(&mut self, is_open: bool) {
        self.sequence += 1;
        let open = 1 << self.line.operation((self.station, OpId(0))).normal.complete.0;
        let number = self.driven().map_or(0, |image| image.number);
        self.take(StationArrival::Inputs(InputsMessage {
            boot_id: FOLLOWED,
            sequence: self.sequence,
            bits: if is_open { open } else { 0 },
            valid: true,
            lives: self.lives,
            under: (LIFE, number),
        }));
    }

    pub fn act(&mut self) {
        self.shell.act(self.now, &mut self.effects);
    }

    /// Time passes, and the loop stands still meanwhile.
    pub fn stand_still(&mut self, time: Duration) {
        self.now = self.now + time;
    }

    /// Time passes, and the loop goes round.
    pub fn pass(&mut self, time: Duration) {
        let end = self.now + time;
        while self.now < end {
            self.now = end.min(self.now + self.timing().refresh);
            self.act();
        }
    }

    /// Outputs among these that drive a motion.
    pub fn motion(&self, bits: u128) -> u128 {
        let operations = &self.line.station(self.station).operations;
        let actuators = operations.iter().fold(0, |bits, operation| {
            let recovery = match &operation.module {
                OperationModule::Reversible { recovery, .. } => 1 << recovery.actuator.0,
                OperationModule::Irreversible { .. } => 0,
            };
            bits | 1 << operation.normal.actuator.0 | recovery
        });
        bits & actuators
    }

    /// The image that was put out last, among the effects that were not looked at yet.
    pub fn driven(&self) -> Option<Driven> {
        self.effects.iter().rev().find_map(|effect| match effect {
            StationEffect::Drive(image) => Some(*image),
            _ => None,
        })
    }

    /// All messages are repeated, and the panel's button stays down.
    pub fn refresh(&mut self, epoch: u64, mode: ControlMode) {
        self.order(FOLLOWED, epoch, mode);
        for (station, report) in std::mem::take(&mut self.peers) {
            self.sequence += 1;
            self.take(StationArrival::State { station, sequence: self.sequence, report: &report });
            self.peers.push((station, report));
        }
        self.advance(true);
    }

    /// Advance at its panel is held, or released.
    pub fn advance(&mut self, held: bool) {
        self.take(StationArrival::Panel { console: CONSOLE, command: PanelCommand::Advance(held) });
    }

    /// The clamp closes, by its panel.
    pub fn close(&mut self) {
        for (station, report) in std::mem::take(&mut self.peers) {
            self.sequence += 1;
            self.take(StationArrival::State { station, sequence: self.sequence, report: &report });
            self.peers.push((station, report));
        }
        self.act();
        self.advance(true);
        self.act();
        let closes = self.shell.controller().marking().any(|place| place.is_operating() && place.op == ADVANCE);
        assert!(closes, "{:?}", self.shell.controller().blocked_by(&self.line, self.now));
        assert_ne!(self.driven().map_or(0, |image| self.motion(image.bits)), 0);
        self.inputs(false);
        self.act();
        self.effects.clear();
    }

    /// The kinds of the effects, in order, without messages.
    pub fn kinds(&self) -> Vec<&'static str> {
        let kind = |effect: &StationEffect| match effect {
            StationEffect::Remember => Some("remember"),
            StationEffect::Drive(image) if self.motion(image.bits) == 0 => Some("off"),
            StationEffect::Drive(_) => Some("on"),
            StationEffect::Tell { .. } => Some("tell"),
            StationEffect::Reply(..) | StationEffect::Happened(_) | StationEffect::Ignored { .. } => None,
        };
        self.effects.iter().filter_map(kind).collect()
    }
}
