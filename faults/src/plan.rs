//! Faults and people of one run, all from its seed.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId, Tick, TransferLine};
use linewright_plant::MotionFault;
use linewright_proof::generate::{self, LineShape};
use linewright_simulation::Rng;

use crate::disk::DiskState;
use crate::network::Weather;

/// Something that happens to a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultEvent {
    /// A process ends after so many further effects, and is started again when the fault ends, with its journal or without.
    Kill { node: usize, after: u32, remembers: bool },
    /// Every process of the line ends, and is started again with its journal when the fault ends.
    KillAll,
    /// A host loses its power until the fault ends, with what was not on its disk.
    PowerCut(usize),
    /// A process stands; `suspends`: with its clock, as a machine that sleeps.
    Stall { node: usize, suspends: bool },
    /// A disk is slow, or fails.
    Disk(usize, DiskState),
    /// Nothing from one process reaches another; what was sent last arrives when the fault ends (`late`).
    Cut { from: usize, to: usize, late: bool },
    /// The network is bad.
    Network(Weather),
    /// A mode order of a stranger.
    ForgedOrder { station: usize, mode: ControlMode, epoch: ForgedEpoch, is_followed: bool },
    /// A station's state, sent by a stranger under another life, number or epoch.
    ForgedState { station: usize, to: usize, boot_id: bool, sequence: bool, epoch: bool },
    /// The devices of an owner lose their power for a moment.
    Reboot(usize),
    /// The bus of an owner is off.
    BusOff(usize),
    /// A motion fails.
    Motion(StationId, OpId, bool, MotionFault),
    /// Another coordinator is started.
    Rival,
    /// A command.
    Command(ModeCommand),
    /// A panel button is held.
    Press(usize, bool),
    /// Hand-mode buttons are held.
    Buttons(u32),
    /// A selector is turned to manual.
    Selector(usize),
}

/// Epoch of a forged order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForgedEpoch {
    Zero,
    Next,
    Last,
}

/// An event of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedFault {
    pub at: Tick,
    pub lasts: Duration,
    pub event: FaultEvent,
}

/// A line, and what happens to it.
pub struct FaultPlan {
    pub seed: u64,
    pub line: Line,
    /// The shipped line, or one like it.
    pub is_transfer_line: bool,
    pub faults: Vec<PlannedFault>,
    /// When the faults are over.
    pub end: Tick,
}

impl FaultPlan {
    /// The plan of a seed.
    pub fn of(seed: u64) -> Self {
        let mut rng = Rng::named(seed, "plan");
        let is_transfer_line = rng.chance(750);
        let line = if is_transfer_line {
            let machines = if rng.chance(150) { 2 } else { 1 };
            let time_scale = *rng.pick(&[0.1, 0.1, 0.3, 1.0]);
            let text = TransferLine { machines, time_scale }.text();
            linewright_line::parse("line.toml", &text).map_or_else(|_| generated(seed), |parsed| parsed.line)
        } else {
            generated(seed)
        };
        let begins = rng.within(1_000_000, 3_000_000);
        let lasts = rng.within(500_000, 8_000_000);
        let count = rng.within(1, 24);
        let theme = rng.below(4);
        let mut drawn = DrawnPlan { rng, line: &line, theme };
        let mut faults: Vec<PlannedFault> = (0..count).map(|_| drawn.fault((begins, begins + lasts))).collect();
        faults.sort_by_key(|fault| fault.at);
        let end = Tick::from_micros(begins + lasts);
        FaultPlan { seed, line, is_transfer_line, faults, end }
    }
}

fn generated(seed: u64) -> Line {
    generate::line(&LineShape { operations: 2..=4, ..LineShape::default() }, seed)
}

struct DrawnPlan<'l> {
    rng: Rng,
    line: &'l Line,
    /// What most of its faults are about: a coincidence of several is rare where all are equally likely.
    theme: u64,
}

impl DrawnPlan<'_> {
    fn node(&mut self) -> usize {
        self.rng.below(self.line.stations.len() as u64 + 1) as usize
    }

    fn station(&mut self) -> usize {
        self.rng.below(self.line.stations.len() as u64) as usize
    }

    fn fault(&mut self, (from, until): (u64, u64)) -> PlannedFault {
        let at = Tick::from_micros(self.rng.within(from, until));
        let longest = *self.rng.pick(&[5_000, 60_000, 400_000, 2_500_000]);
        let lasts = Duration::from_micros(self.rng.within(500, longest));
        PlannedFault { at, lasts, event: self.event() }
    }

    fn event(&mut self) -> FaultEvent {
        let node = self.node();
        let station = self.station();
        let yes = |rng: &mut Rng| rng.chance(500);
        let number = match (self.theme, self.rng.chance(500)) {
            // Disks and emergency stops.
            (1, true) => *self.rng.pick(&[0, 17, 18, 30, 31, 33, 37, 83, 83, 99]),
            // Networks, and coordinators beside each other.
            (2, true) => *self.rng.pick(&[22, 38, 42, 50, 51, 55, 59, 72, 83]),
            // Memories.
            (3, true) => *self.rng.pick(&[0, 5, 17, 18, 19, 20, 80]),
            _ => self.rng.below(100),
        };
        match number {
            17 => FaultEvent::KillAll,
            83 => FaultEvent::Command(ModeCommand::EStop),
            0..18 => {
                let after = self.rng.below(12) as u32;
                FaultEvent::Kill { node, after, remembers: self.rng.chance(750) }
            }
            18..22 => FaultEvent::PowerCut(node),
            22..30 => FaultEvent::Stall { node, suspends: self.rng.chance(350) },
            30..38 => {
                let takes = Duration::from_micros(*self.rng.pick(&[2_000, 40_000, 120_000, 400_000]));
                let fails = self.rng.chance(300);
                FaultEvent::Disk(node, if fails { DiskState::Failing(takes) } else { DiskState::Slow(takes) })
            }
            38..50 => FaultEvent::Cut { from: node, to: self.node(), late: yes(&mut self.rng) },
            50..55 => {
                let jitter = Duration::from_millis(*self.rng.pick(&[0, 5, 40, 120]));
                let (loss, double) = (*self.rng.pick(&[0, 50, 200, 500]), *self.rng.pick(&[0, 200]));
                FaultEvent::Network(Weather { loss, double, jitter })
            }
            55..59 => {
                let modes = [ControlMode::Auto, ControlMode::Manual, ControlMode::StandBy, ControlMode::EStop];
                let epoch = *self.rng.pick(&[ForgedEpoch::Zero, ForgedEpoch::Next, ForgedEpoch::Last]);
                let mode = *self.rng.pick(&modes);
                FaultEvent::ForgedOrder { station, mode, epoch, is_followed: yes(&mut self.rng) }
            }
            59..62 => FaultEvent::ForgedState {
                station,
                to: node,
                boot_id: yes(&mut self.rng),
                sequence: yes(&mut self.rng),
                epoch: yes(&mut self.rng),
            },
            62..65 => FaultEvent::Reboot(station),
            65..68 => FaultEvent::BusOff(self.node()),
            68..72 => {
                let faults = [MotionFault::Stick, MotionFault::Slip, MotionFault::Break, MotionFault::SlipBack];
                let id = StationId::at(station);
                let op = OpId::at(self.rng.below(self.line.station(id).operations.len() as u64) as usize);
                FaultEvent::Motion(id, op, self.rng.chance(700), *self.rng.pick(&faults))
            }
            72..75 => FaultEvent::Rival,
            75..80 => FaultEvent::Command(*self.rng.pick(&ModeCommand::ALL)),
            80..88 => {
                let likely = [ModeCommand::Auto, ModeCommand::Start, ModeCommand::Manual, ModeCommand::EStop];
                let other = [ModeCommand::Reset, ModeCommand::Hand, ModeCommand::Auto];
                let from: &[ModeCommand] = if yes(&mut self.rng) { &likely } else { &other };
                FaultEvent::Command(*self.rng.pick(from))
            }
            88..95 => FaultEvent::Press(station, self.rng.chance(600)),
            95..98 => FaultEvent::Buttons(1 << self.rng.below(self.line.buttons.len().max(1) as u64)),
            _ => FaultEvent::Selector(station),
        }
    }
}
