//! Faults and people of one run, all from its seed.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, OpId, StationId, Tick};
use linewright_plant::MotionFault;
use linewright_simulation::Rng;

use crate::disk::DiskState;
use crate::lines;
use crate::network::Weather;
use crate::provoke::Provocation;

/// Something that happens to a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultEvent {
    /// A process ends after so many further effects, and is started again when the fault ends, with its journal or without.
    Kill { node: usize, after: u32, remembers: bool },
    /// Every process of the line ends, and is started again with its journal when the fault ends.
    KillAll,
    /// A host loses its power until the fault ends, with what was not on its disk.
    PowerCut(usize),
    /// A process stands; `suspends`: with its timers, as a machine that sleeps.
    Stall { node: usize, suspends: bool },
    /// A disk is slow, or fails.
    Disk(usize, DiskState),
    /// Nothing from one process reaches another; what was sent last arrives when the fault ends (`late`).
    Cut { from: usize, to: usize, late: bool },
    /// What one process sends to another takes longer: each message as much, or each something of it, so that they overtake each
    /// other.
    Slow { from: usize, to: usize, by: Duration, is_even: bool },
    /// The network is bad.
    Network(Weather),
    /// An order that the coordinator gave so long ago arrives once more.
    OldOrder { station: usize, age: Duration },
    /// A mode order of a stranger.
    ForgedOrder { station: usize, mode: ControlMode, epoch: ForgedEpoch, is_followed: bool, is_long: bool },
    /// A station's state, sent by a stranger under another life, number or epoch.
    ForgedState { station: usize, to: usize, boot_id: bool, sequence: bool, epoch: bool },
    /// The devices of an owner lose their power for a moment.
    Reboot(usize),
    /// The bus of an owner is off.
    BusOff(usize),
    /// A motion fails.
    Motion(StationId, OpId, bool, MotionFault),
    /// A switch stays off.
    SwitchOff(StationId, InputId),
    /// A switch that is on stays on; one that is off is not touched.
    SwitchOn(StationId, InputId),
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
    /// *Resume* is held at the console.
    Resume,
    /// Faults and people by where the line stands then, and by a number.
    Provoked(Provocation, u64),
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
    /// A shipped line, or one like it.
    pub is_shipped: bool,
    pub faults: Vec<PlannedFault>,
    /// The operator at the end follows the recovery plan; otherwise the rules of the manual alone.
    pub follows_plan: bool,
    /// When the faults are over.
    pub end: Tick,
}

impl FaultPlan {
    /// The plan of a seed.
    pub fn of(seed: u64) -> Self {
        let mut rng = Rng::named(seed, "plan");
        let theme = rng.below(8);
        let provokes = theme >= 6;
        let (line, is_shipped) = lines::drawn(&mut rng, seed, provokes);
        let begins = rng.within(1_000_000, 3_000_000);
        let lasts = if provokes { rng.within(4_000_000, 8_000_000) } else { rng.within(500_000, 8_000_000) };
        let count = if provokes { rng.within(0, 4) } else { rng.within(1, 24) };
        let mut drawn = DrawnPlan { rng, line: &line, theme };
        let mut faults: Vec<PlannedFault> = Vec::new();
        if provokes {
            drawn.provoke(begins, &mut faults);
        }
        if theme == 3 && drawn.rng.chance(200) {
            faults.push(drawn.restart_while_founding());
        }
        for _ in 0..count {
            drawn.add((begins, begins + lasts), &mut faults);
        }
        faults.sort_by_key(|fault| fault.at);
        let end = Tick::from_micros(begins + lasts);
        FaultPlan { seed, line, is_shipped, faults, follows_plan: seed.is_multiple_of(2), end }
    }
}

fn planned(at: u64, lasts: u64, event: FaultEvent) -> PlannedFault {
    PlannedFault { at: Tick::from_micros(at), lasts: Duration::from_micros(lasts), event }
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

    /// One or two situations that are looked for.
    fn provoke(&mut self, begins: u64, faults: &mut Vec<PlannedFault>) {
        let mut at = begins + self.rng.below(1_500_000);
        for _ in 0..self.rng.within(1, 2) {
            let what = *self.rng.pick(&[
                Provocation::TwoPanels,
                Provocation::TwoPanels,
                Provocation::TwoLives,
                Provocation::Standstill,
                Provocation::CutOff,
                Provocation::WayHome,
                Provocation::WayHome,
                Provocation::NoGeneration,
                Provocation::OffAtHome,
                Provocation::StaysOn,
            ]);
            if matches!(what, Provocation::TwoPanels | Provocation::TwoLives) {
                at = self.lead_to_manual(at, faults);
            }
            faults.push(planned(at, 1_000, FaultEvent::Provoked(what, self.rng.next())));
            at += self.rng.within(1_500_000, 3_000_000);
            let auto = [ModeCommand::Auto, ModeCommand::EStop];
            faults.push(planned(at, 1_000, FaultEvent::Command(*self.rng.pick(&auto))));
        }
    }

    /// A line in auto comes to manual: it loses sight of a station for a moment, ends what is under way, and stands. Gives when it
    /// does so at the latest, as a rule.
    fn lead_to_manual(&mut self, at: u64, faults: &mut Vec<PlannedFault>) -> u64 {
        let cut = FaultEvent::Cut { from: self.station(), to: self.line.stations.len(), late: false };
        faults.push(planned(at, 330_000, cut));
        let times = [400_000, 700_000, 1_200_000];
        faults.extend(times.map(|after| planned(at + after, 1_000, FaultEvent::Command(ModeCommand::Manual))));
        at + self.rng.within(850_000, 1_700_000)
    }

    /// A station that is restarted when its line is about to found the first generation.
    fn restart_while_founding(&mut self) -> PlannedFault {
        let node = self.station();
        let (at, lasts) = (self.rng.within(200_000, 402_000), self.rng.within(20_000, 120_000));
        planned(at, lasts, FaultEvent::Kill { node, after: 0, remembers: true })
    }

    /// A fault, and sometimes others close behind it.
    fn add(&mut self, (from, until): (u64, u64), faults: &mut Vec<PlannedFault>) {
        let at = self.rng.within(from, until);
        let longest = *self.rng.pick(&[5_000, 60_000, 400_000, 2_500_000]);
        let lasts = self.rng.within(500, longest);
        if !self.rng.chance(200) {
            faults.push(planned(at, lasts, self.event()));
            return;
        }
        let station = self.station();
        match self.theme {
            // An emergency stop that one station does not receive, and that ends soon.
            1 if self.rng.chance(400) => {
                let node = self.line.stations.len();
                faults.push(planned(at, 600_000, FaultEvent::Cut { from: node, to: station, late: false }));
                let times = [(5_000, ModeCommand::EStop), (60_000, ModeCommand::Reset), (110_000, ModeCommand::Manual)];
                faults.extend(times.map(|(after, command)| planned(at + after, 1_000, FaultEvent::Command(command))));
            }
            // An emergency stop while a record of another command is being written.
            1 => {
                let takes = Duration::from_micros(*self.rng.pick(&[40_000, 120_000, 400_000]));
                let node = *self.rng.pick(&[self.line.stations.len(), station]);
                let other = *self.rng.pick(&[ModeCommand::Manual, ModeCommand::Auto, ModeCommand::Stop]);
                faults.push(planned(at, lasts.max(500_000), FaultEvent::Disk(node, DiskState::Slow(takes))));
                faults.push(planned(at + 1_000, 1_000, FaultEvent::Command(other)));
                let stop = at + 1_000 + self.rng.within(1_000, 80_000);
                faults.push(planned(stop, 1_000, FaultEvent::Command(ModeCommand::EStop)));
            }
            // Two stations do not receive each other while the coordinator receives both.
            2 if self.rng.chance(300) => {
                let modes = [ControlMode::Auto, ControlMode::Manual];
                let mode = *self.rng.pick(&modes);
                let forged = FaultEvent::ForgedOrder {
                    station,
                    mode,
                    epoch: ForgedEpoch::Next,
                    is_followed: true,
                    is_long: true,
                };
                let node = self.line.stations.len();
                faults.push(planned(at, 1_000, forged));
                faults.push(planned(at + 1_000, 2_500_000, FaultEvent::Cut { from: node, to: station, late: false }));
            }
            2 if self.rng.chance(300) => {
                let age = Duration::from_micros(self.rng.within(100_000, 3_000_000));
                let other = *self.rng.pick(&[ModeCommand::Manual, ModeCommand::EStop]);
                faults.push(planned(at, 1_000, FaultEvent::Command(other)));
                let late = at + self.rng.within(300_000, 900_000);
                faults.push(planned(late, 1_000, FaultEvent::OldOrder { station, age }));
            }
            2 => {
                let other = self.station();
                faults.push(planned(at, lasts.max(600_000), FaultEvent::Cut { from: other, to: station, late: false }));
            }
            // The coordinator is killed in the middle of its effects, just after a command.
            3 => {
                let after = self.rng.below(8) as u32;
                let node = self.line.stations.len();
                let command = *self.rng.pick(&[ModeCommand::EStop, ModeCommand::Manual, ModeCommand::Stop]);
                faults.push(planned(at, lasts, FaultEvent::Kill { node, after, remembers: true }));
                faults.push(planned(at, 1_000, FaultEvent::Command(command)));
            }
            // A person begins to lead a station back, leaves off, and begins again, while another one is led on.
            4 if self.rng.chance(400) => {
                let other = self.station();
                let weather = Weather { loss: 200, double: 0, jitter: Duration::from_millis(120) };
                let at = self.lead_to_manual(at, faults);
                faults.push(planned(at, 1_500_000, FaultEvent::Network(weather)));
                for nth in 0..4 {
                    let (from, short) = (at + 100_000 + nth * 150_000, self.rng.within(5_000, 120_000));
                    faults.push(planned(from, short, FaultEvent::Press(station, false)));
                }
                let (from, long) = (self.rng.within(0, 400_000), self.rng.within(100_000, 900_000));
                faults.push(planned(at + 100_000 + from, long, FaultEvent::Press(other, true)));
            }
            // A person leads one station on, and another one back.
            4 => {
                let long = self.rng.within(200_000, 2_000_000);
                let advance = self.rng.chance(400);
                let at = self.lead_to_manual(at, faults);
                faults.push(planned(at, long, FaultEvent::Press(station, advance)));
                let other = self.station();
                faults.push(planned(at + long / 2, long, FaultEvent::Press(other, !advance)));
            }
            // A motion fails, and the station is led back.
            5 if self.rng.chance(500) => {
                let faulty = [MotionFault::Stick, MotionFault::Break];
                let id = StationId::at(station);
                let op = OpId::at(self.rng.below(self.line.station(id).operations.len() as u64) as usize);
                let fault = *self.rng.pick(&faulty);
                faults.push(planned(at, 800_000, FaultEvent::Motion(id, op, true, fault)));
                faults.push(planned(at + 900_000, 1_000, FaultEvent::Command(ModeCommand::Manual)));
                let long = self.rng.within(200_000, 2_000_000);
                let pressed = if self.rng.chance(300) { FaultEvent::Resume } else { FaultEvent::Press(station, false) };
                faults.push(planned(at + 1_500_000, long, pressed));
                let other = self.station();
                faults.push(planned(at + 1_600_000, long, FaultEvent::Press(other, true)));
            }
            // Devices restart while their manager stands.
            5 => {
                let stands = self.rng.within(40_000, 180_000);
                let node = *self.rng.pick(&[self.line.stations.len(), station]);
                faults.push(planned(at, stands, FaultEvent::Stall { node, suspends: false }));
                faults.push(planned(at + 1_000, 1_000, FaultEvent::Reboot(station)));
            }
            _ => {
                faults.push(planned(at, lasts, self.event()));
                let stop = at + self.rng.within(1_000, 60_000);
                faults.push(planned(stop, 1_000, FaultEvent::Command(ModeCommand::EStop)));
            }
        }
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
            // People, beside memories that are lost.
            (4, true) => *self.rng.pick(&[0, 38, 80, 88, 88, 88, 88, 94, 95, 98]),
            // Devices and what is between them and their managers.
            (5, true) => *self.rng.pick(&[22, 22, 50, 62, 65, 65, 68, 94, 99]),
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
            46..48 => FaultEvent::Slow {
                from: node,
                to: self.node(),
                by: Duration::from_micros(*self.rng.pick(&[10_000, 60_000, 150_000])),
                is_even: self.rng.chance(500),
            },
            38..50 => FaultEvent::Cut { from: node, to: self.node(), late: yes(&mut self.rng) },
            50..55 => {
                let jitter = Duration::from_millis(*self.rng.pick(&[0, 5, 40, 120]));
                let (loss, double) = (*self.rng.pick(&[0, 50, 200, 500]), *self.rng.pick(&[0, 200]));
                FaultEvent::Network(Weather { loss, double, jitter })
            }
            55 => FaultEvent::OldOrder { station, age: Duration::from_micros(self.rng.within(100_000, 3_000_000)) },
            56..59 => {
                let modes = [ControlMode::Auto, ControlMode::Manual, ControlMode::StandBy, ControlMode::EStop];
                let epoch = *self.rng.pick(&[ForgedEpoch::Zero, ForgedEpoch::Next, ForgedEpoch::Last]);
                let mode = *self.rng.pick(&modes);
                let (is_followed, is_long) = (yes(&mut self.rng), self.rng.chance(300));
                FaultEvent::ForgedOrder { station, mode, epoch, is_followed, is_long }
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
                if self.rng.chance(200) {
                    return FaultEvent::SwitchOff(id, self.line.operation((id, op)).normal.complete);
                }
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
            88..94 => FaultEvent::Press(station, self.rng.chance(600)),
            94 => FaultEvent::Resume,
            95..98 => FaultEvent::Buttons(1 << self.rng.below(self.line.buttons.len().max(1) as u64)),
            _ => FaultEvent::Selector(station),
        }
    }
}
