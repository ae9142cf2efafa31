//! A coordinator and the stations it receives, as far as a table needs them.

use std::time::Duration;

use linewright_coordinator_logic::{Coordinator, ManualPermit, ModeCommand, ModeInput, ModeOutbox, StationView};
use linewright_line::net::ControlMode;
use linewright_line::{Line, Rest, RestId, StationId, Task, Tick, TransferLine, parse};

/// The shipped transfer line.
pub fn line() -> Line {
    let text = TransferLine::default().text();
    parse("line.toml", &text).unwrap_or_else(|problems| panic!("{problems:?}")).line
}

/// A coordinator with three stations that answer at once.
pub struct CoordinatorBench {
    pub line: Line,
    pub coordinator: Coordinator,
    pub now: Tick,
    pub heard: Vec<StationView>,
    pub out: ModeOutbox,
    /// Whether the stations acknowledge epochs.
    pub acknowledge: bool,
    /// What the cell permits at every station, if it is set here: it takes at once what is in manual by itself.
    pub permit: Option<ManualPermit>,
}

impl CoordinatorBench {
    /// Switched on: every station at home, standing, in order.
    pub fn new() -> Self {
        CoordinatorBench::with_last_epoch(0)
    }

    pub fn with_last_epoch(last_epoch: u64) -> Self {
        CoordinatorBench::of(line(), last_epoch)
    }

    pub fn of(line: Line, last_epoch: u64) -> Self {
        let mut bench = CoordinatorBench::of_unheard_console(line, last_epoch);
        let untouched = bench.line.console.estop.filter(|contact| !contact.pressed);
        let bits = untouched.map_or(0, |contact| 1 << contact.input.0);
        bench.input(ModeInput::Console { bits, valid: true });
        bench
    }

    /// The console's devices are not up yet.
    pub fn of_unheard_console(line: Line, last_epoch: u64) -> Self {
        let heard = StationView {
            boot_id: 7,
            at_home: true,
            stopped: true,
            devices_valid: true,
            generation: 1,
            ..StationView::default()
        };
        let mut bench = CoordinatorBench {
            coordinator: Coordinator::new(line.clone(), 1, last_epoch),
            heard: vec![heard; line.stations.len()],
            line,
            now: Tick::from_millis(1000),
            out: ModeOutbox::default(),
            acknowledge: true,
            permit: None,
        };
        bench.beat();
        bench
    }

    /// With the second station task-driven. What it can be ordered to do does not matter here.
    pub fn with_one_task_driven() -> Self {
        CoordinatorBench::with_task_driven(&[1])
    }

    /// With these stations task-driven.
    pub fn with_task_driven(stations: &[usize]) -> Self {
        let mut line = line();
        for &at in stations {
            let station = &mut line.stations[at];
            station.rests = vec![Rest { name: "home".to_owned(), at: Vec::new() }];
            station.tasks = vec![Task {
                name: "everything".to_owned(),
                steps: 0..station.steps.len(),
                from: RestId(0),
                to: RestId(0),
                limit: Duration::from_secs(1),
                parameters: Vec::new(),
            }];
        }
        CoordinatorBench::of(line, 0)
    }

    /// A bench in this mode, by commands alone.
    pub fn in_mode(mode: ControlMode) -> Self {
        let mut bench = CoordinatorBench::new();
        let commands: &[ModeCommand] = match mode {
            ControlMode::Home => &[],
            ControlMode::StandBy => &[ModeCommand::Start],
            ControlMode::Auto => &[ModeCommand::Start, ModeCommand::Auto],
            ControlMode::Hand => &[ModeCommand::Start, ModeCommand::Hand],
            ControlMode::Manual => &[ModeCommand::Start, ModeCommand::Manual],
            ControlMode::EStop => &[ModeCommand::EStop],
        };
        for &command in commands {
            assert_eq!(bench.command(command), None);
        }
        assert_eq!(bench.mode(), mode);
        bench
    }

    pub fn mode(&self) -> ControlMode {
        self.coordinator.mode()
    }

    /// Every station reports, and acknowledges what it has received.
    pub fn beat(&mut self) {
        for _ in 0..2 {
            self.give_permit();
            for at in 0..self.heard.len() {
                if self.acknowledge {
                    self.heard[at].mode_epoch = self.heard[at].mode_epoch.max(self.coordinator.epoch());
                }
                self.say(at);
            }
        }
    }

    fn give_permit(&mut self) {
        let Some(permit) = self.permit else { return };
        let epochs: Vec<u64> = self.line.station_ids().map(|id| self.coordinator.single_epoch(id)).collect();
        self.coordinator.permit_manual(|id| {
            Some(match permit {
                ManualPermit::LeftOut { tasks, kept_in: Some(_) } => {
                    ManualPermit::LeftOut { tasks, kept_in: Some(epochs[id.index()]) }
                }
                other => other,
            })
        });
    }

    /// One station reports as it stands.
    pub fn say(&mut self, station: usize) {
        self.input(ModeInput::Station(StationId::at(station), self.heard[station]));
    }

    pub fn input(&mut self, input: ModeInput) {
        self.coordinator.handle(self.now, input);
        self.coordinator.step(self.now, &mut self.out);
    }

    /// Time passes without any message.
    pub fn wait(&mut self, time: Duration) {
        self.now = self.now + time;
        self.coordinator.step(self.now, &mut self.out);
    }

    /// Gives a command; the refusal in words if it was refused.
    pub fn command(&mut self, command: ModeCommand) -> Option<String> {
        self.out.refusals.clear();
        self.input(ModeInput::Command(command));
        let refusal = self.out.refusals.first().map(|refusal| refusal.text(&self.line));
        self.beat();
        refusal
    }
}
