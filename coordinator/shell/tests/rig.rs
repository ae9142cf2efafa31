//! The coordinator of the shipped line, with stations whose reports are set by the test.

use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, OutputImage, StationView};
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord, CoordinatorShell};
use linewright_line::net::ControlMode;
use linewright_line::{Line, Rest, RestId, StationId, Task, Tick, TransferLine, parse};

pub const LIFE: u64 = 3;

pub struct Rig {
    pub line: Line,
    pub shell: CoordinatorShell,
    pub now: Tick,
    pub effects: Vec<CoordinatorEffect>,
    pub heard: Vec<StationView>,
    pub disk_is_full: bool,
    /// Time of a write.
    pub disk_takes: Duration,
    pub record: CoordinatorRecord,
    /// Times of attempts to write.
    pub writes: Vec<Tick>,
    sequence: u64,
}

impl Rig {
    pub fn new(remembered: CoordinatorRecord) -> Self {
        Rig::of(parse("line.toml", &TransferLine::default().text()).expect("the shipped line").line, remembered)
    }

    /// With one task-driven station.
    pub fn with_one_task_driven(remembered: CoordinatorRecord) -> Self {
        let mut line = parse("line.toml", &TransferLine::default().text()).expect("the shipped line").line;
        let id = line.station_named("clamp_1").expect("a clamp");
        let station = &mut line.stations[id.index()];
        station.rests = vec![Rest { name: "home".to_owned(), at: Vec::new() }];
        let (name, steps, limit) = ("everything".to_owned(), 0..station.steps.len(), Duration::from_secs(1));
        station.tasks = vec![Task { name, steps, from: RestId(0), to: RestId(0), limit, parameters: Vec::new() }];
        Rig::of(line, remembered)
    }

    /// With a table that a drive turns from place to place.
    pub fn with_a_table(remembered: CoordinatorRecord) -> Self {
        let text = include_str!("../../../examples/driven-table.toml");
        Rig::of(parse("driven-table.toml", text).expect("the shipped table").line, remembered)
    }

    fn of(line: Line, remembered: CoordinatorRecord) -> Self {
        let at_home = StationView {
            boot_id: 7,
            follows: LIFE,
            at_home: true,
            stopped: true,
            devices_valid: true,
            generation: 1,
            ..StationView::default()
        };
        let mut shell = CoordinatorShell::new(&line, LIFE, remembered);
        shell.handle(Tick::from_millis(1000), CoordinatorArrival::Console { bits: 0, valid: true });
        Rig {
            shell,
            heard: vec![at_home; line.stations.len()],
            line,
            now: Tick::from_millis(1000),
            effects: Vec::new(),
            disk_is_full: false,
            disk_takes: Duration::ZERO,
            record: remembered,
            writes: Vec::new(),
            sequence: 0,
        }
    }

    pub fn mode(&self) -> ControlMode {
        self.shell.coordinator().mode()
    }

    /// Every station sends its state, with the epoch that is ordered.
    pub fn hear_all(&mut self) {
        let epoch = self.shell.coordinator().epoch();
        for (at, heard) in self.heard.clone().into_iter().enumerate() {
            self.sequence += 1;
            let heard = StationView { mode_epoch: heard.mode_epoch.max(epoch), ..heard };
            let (station, sequence) = (StationId::at(at), self.sequence);
            self.shell.handle(self.now, CoordinatorArrival::State { station, sequence, heard });
        }
    }

    pub fn outputs(&mut self, station: StationId, bits: u128) {
        self.sequence += 1;
        let image = OutputImage {
            bits,
            valid: true,
            losses: LIFE << 32,
            boot_id: 7,
            number: self.sequence,
            mode_epoch: self.shell.coordinator().epoch(),
        };
        let sequence = self.sequence;
        self.shell.handle(self.now, CoordinatorArrival::Outputs { station, sequence, image });
    }

    pub fn command(&mut self, command: ModeCommand) {
        self.shell.handle(self.now, CoordinatorArrival::Command(command));
    }

    /// Acts and performs, as a node does; gives the effects that were performed, in order.
    pub fn act(&mut self) -> Vec<CoordinatorEffect> {
        let mut performed = Vec::new();
        loop {
            self.shell.act(self.now, &mut self.effects);
            let mut goes_on = true;
            for effect in std::mem::take(&mut self.effects) {
                performed.push(effect.clone());
                if let CoordinatorEffect::Remember(record) = effect {
                    self.writes.push(self.now);
                    let is_written = !self.disk_is_full;
                    self.now = self.now + self.disk_takes;
                    if is_written {
                        self.record = record;
                    }
                    goes_on = self.shell.remembered(self.now, record, is_written);
                    if !goes_on {
                        break;
                    }
                }
            }
            if goes_on {
                return performed;
            }
        }
    }

    /// In auto, acknowledged by all.
    pub fn in_auto(&mut self) {
        self.refresh();
        self.command(ModeCommand::Start);
        self.refresh();
        self.command(ModeCommand::Auto);
        self.refresh();
        self.refresh();
        assert_eq!(self.mode(), ControlMode::Auto, "{}", self.shell.coordinator().text());
    }

    /// A period passes in which all stations are received.
    pub fn refresh(&mut self) -> Vec<CoordinatorEffect> {
        self.now = self.now + Duration::from_millis(50);
        self.hear_all();
        self.act()
    }
}
