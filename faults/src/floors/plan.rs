//! What happens on a floor, and the shipped cells that are played.

use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell};
use linewright_coordinator_cell::{CellTable, ProtocolRules};
use linewright_coordinator_logic::ModeCommand;
use linewright_line::{HolderId, Line, OpId, StationId, Tick};
use linewright_plant::{MotionFault, PlantOptions};
use linewright_simulation::Rng;
use linewright_simulation::cell::{ShopFloor, nests};
use linewright_station_logic::OrderRules;

const C1: [&str; 2] = [
    include_str!("../../../launch-config/lines/workcell-c1/cell.toml"),
    include_str!("../../../launch-config/lines/workcell-c1/line.toml"),
];
const ASSEMBLY: [&str; 2] = [
    include_str!("../../../launch-config/lines/assembly-cell/cell.toml"),
    include_str!("../../../launch-config/lines/assembly-cell/line.toml"),
];
const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
/// Faults begin before that.
const FAULTS_UNTIL: u64 = 120_000_000;
/// The operations by which a part is worked on, of the shipped cells.
const WORK: [&str; 3] = ["cut", "assemble", "work on the part"];

/// A disturbance of a cell: of a station's process, its messages, its motions, or by people.
#[derive(Clone, Copy, Debug)]
pub(super) enum FloorTrouble {
    /// The station's process is killed, and starts again, with its journal or without.
    Killed { forgets: bool },
    /// Nothing is received from the station, and it receives no mode order.
    Away,
    /// An operation, done or undone.
    Motion(OpId, MotionFault, bool),
    /// A command at the wrong moment.
    Command(ModeCommand),
    /// The station's panel, whatever the mode.
    Press(bool),
}

/// A trouble, with its time.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlannedTrouble {
    pub at: Tick,
    pub lasts: Duration,
    pub station: StationId,
    pub what: FloorTrouble,
}

impl PlannedTrouble {
    /// Whether a part may fall: a grip fails, an axis leaves by itself where it has just been seen, or the slot that a part is on its way
    /// to is forgotten.
    pub const fn may_drop_a_part(&self) -> bool {
        use FloorTrouble::{Killed, Motion};
        matches!(
            self.what,
            Motion(_, MotionFault::Miss | MotionFault::Drop | MotionFault::SlipBack, _) | Killed { forgets: true }
        )
    }
}

/// A broken rule of the order protocol or of stations' orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloorMutant {
    /// The alarm is raised, and an answer taken, before the stations stand.
    AskedWhileMoving,
    /// A station is ordered back beside another one that is in a handshake, or has completed its order.
    GoesBackBeside,
    /// An order whose time is over has ended while the station still moves.
    EndsMoving,
    /// Every copy of the order to go back moves it.
    GoesBackAgain,
    /// Ordered to stop, a station goes back.
    StopGoesBack,
}

/// Broken rules of orders, with the first seed that finds each.
pub const FLOOR_MUTANTS: &[(FloorMutant, u64)] = &[
    (FloorMutant::AskedWhileMoving, 253),
    (FloorMutant::GoesBackBeside, 84),
    (FloorMutant::EndsMoving, 121),
    (FloorMutant::GoesBackAgain, 84),
    (FloorMutant::StopGoesBack, 84),
];

impl FloorMutant {
    pub(super) fn rules(self) -> (ProtocolRules, OrderRules) {
        let (mut protocol, mut orders) = (ProtocolRules::default(), OrderRules::default());
        match self {
            FloorMutant::AskedWhileMoving => protocol.stands_first = false,
            FloorMutant::GoesBackBeside => protocol.goes_back_alone = false,
            FloorMutant::EndsMoving => orders.ends_standing = false,
            FloorMutant::GoesBackAgain => orders.secures_once = false,
            FloorMutant::StopGoesBack => orders.stops_at_once = false,
        }
        (protocol, orders)
    }
}

/// A shipped cell with its line, and a production of a few parts of each type.
pub(super) struct FloorWork {
    pub cell: Cell,
    pub line: Line,
    pub table: Arc<CellTable>,
    pub parts: u64,
    /// Work on each part.
    pub works: usize,
}

impl FloorWork {
    pub fn of(is_assembly: bool) -> Option<Self> {
        let ([cell, line], parts, works) =
            if is_assembly { (ASSEMBLY, &[1, 1, 1][..], 1) } else { (C1, &[2, 1][..], 2) };
        let line = linewright_line::parse("line.toml", line).ok()?.line;
        let cell = linewright_cell::parse("cell.toml", cell, Some(&line)).ok()?.cell;
        let table = Arc::new(compile_cell(&cell, Some(&line), Supply::Batch(parts), PACE).ok()?.table);
        Some(FloorWork { cell, line, table, parts: parts.iter().map(|&count| u64::from(count)).sum(), works })
    }

    pub fn floor(&self, seed: u64) -> Option<ShopFloor> {
        let options = PlantOptions { seed, variation: 0.1, people: false };
        let nests = nests(&self.cell, &self.line);
        let mut floor = ShopFloor::new(&self.line, &self.table, &nests, options).ok()?;
        for id in self.line.station_ids() {
            let station = self.line.station(id);
            let own = |nest: &HolderId| {
                let holder = &self.line.handling.holder(*nest).name;
                holder.strip_prefix(&station.name).is_some_and(|rest| rest.starts_with('.'))
            };
            let nest = nests.iter().map(|(_, nest)| *nest).find(own);
            let op = WORK.iter().find_map(|name| station.operation_named(name));
            if let (Some(nest), Some(op)) = (nest, op) {
                floor.watch(id, op, nest);
            }
        }
        Some(floor)
    }

    pub fn troubles(&self, rng: &mut Rng) -> Vec<PlannedTrouble> {
        let count = rng.below(6);
        let planned = (0..count).map(|_| {
            let station = StationId::at(rng.below(self.line.stations.len() as u64) as usize);
            let operations = self.line.station(station).operations.len() as u64;
            let commands =
                [ModeCommand::EStop, ModeCommand::Stop, ModeCommand::Manual, ModeCommand::Hand, ModeCommand::Start];
            let motion =
                FloorTrouble::Motion(OpId(rng.below(operations) as u16), *rng.pick(&MotionFault::ALL), rng.chance(300));
            let what = match rng.below(8) {
                0 | 1 => FloorTrouble::Killed { forgets: rng.chance(300) },
                2 => FloorTrouble::Away,
                3..6 => motion,
                6 => FloorTrouble::Command(*rng.pick(&commands)),
                _ => FloorTrouble::Press(rng.chance(500)),
            };
            let at = Tick::from_micros(rng.within(500_000, FAULTS_UNTIL));
            PlannedTrouble { at, lasts: Duration::from_micros(rng.within(50_000, 15_000_000)), station, what }
        });
        planned.collect()
    }
}
