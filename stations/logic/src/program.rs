//! A station's net compiled to tables.
//!
//! For every place and mode there is a row per term of each outgoing transition, and a row is two bit masks over one
//! word of condition variables: the bits that must be on and those that must be off. What does not fit a mask — the
//! causal arrows, the neighbours of a concurrent operation — is looked at only once the masks match. The conditions
//! themselves are [`linewright_line::net`]'s; this module changes their form and nothing else.

use linewright_line::net::{
    Block, Conjunction, ControlMode, Literal, MotionStage, StationNet, StationPlace, TransitionKind, Var,
};
use linewright_line::{ButtonId, Line, MotionSignals, OpId, OperationModule, RestId, StationId, TaskId};

use crate::axis_place::{NumberedPlaces, index_drive};
use crate::conflict_spans::ConflictSpans;
use crate::peer_set::{PEERS_MAX, PeerSet};
use crate::place_table::PlaceTable;
use crate::position_guard::{Interlocks, partners};
use crate::tasks::StationTasks;

/// The bits of the word of condition variables.
pub(crate) mod bit {
    /// The token's own motion has failed.
    pub const FAULT: u128 = 1 << 0;
    /// The token's own motion has arrived.
    pub const ARRIVED: u128 = 1 << 1;
    /// The token's own motion was held in manual mode, which has ended.
    pub const HOLD_LOST: u128 = 1 << 2;
    pub const ADVANCE: u128 = 1 << 3;
    pub const RETRACT: u128 = 1 << 5;
    pub const ANY_PATH: u128 = 1 << 7;
    pub const MASTER_STOP: u128 = 1 << 8;
    /// A task-driven station is to go back to the rest it came from.
    pub const SECURE: u128 = 1 << 9;
    /// *Resume* is held at a console; see `resume`.
    pub const RESUME: u128 = 1 << 10;
    /// One bit for each recovery path.
    pub const PATH_0: u32 = 16;
    pub const PATHS_MAX: usize = 16;
    pub const PATHS: u128 = 0xFFFF << PATH_0;
    /// One bit for each hand-mode button held.
    pub const HELD_0: u32 = 32;
    pub const HELD: u128 = 0xFFFF_FFFF << HELD_0;
    /// One bit for each task: the station is to do it.
    pub const TASK_0: u32 = 96;
    pub const ORDERS: u128 = SECURE | 0xFFFF << TASK_0;
    /// The rising edges of ADVANCE and RETRACT stand one bit above their levels, those of HELD 32 bits above.
    pub const PANEL: u128 = ADVANCE | RETRACT;

    /// The rising edges that belong to a word of levels that have just come on.
    pub const fn edges(risen: u128) -> u128 {
        ((risen & PANEL) << 1) | ((risen & HELD) << 32)
    }

    /// The levels that belong to a word of edges and levels: what a command must keep holding.
    pub const fn levels(word: u128) -> u128 {
        (word & (PANEL | HELD)) | ((word >> 1) & PANEL) | ((word >> 32) & HELD)
    }
}

/// Condition of a row on the causal arrows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Causal {
    /// Nothing.
    Free,
    /// The arrows into this step hold.
    Holds(u8),
    /// They do not, and every view they read is known.
    Fails(u8),
    /// The arrows into everything the recovery path skips hold: an index into [`Program::ways_home`].
    WayHome(u8),
}

/// One term of one transition, in one mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConditionRow {
    pub need: u128,
    pub forbid: u128,
    /// Concurrent neighbours that must be settled, a bit per operation.
    pub settled: u64,
    pub transition: u16,
    pub causal: Causal,
    /// Fires only when every token of the station stands in the same stage and block (a join).
    pub join: bool,
    /// It starts a motion, so measured positions are checked.
    pub starts: bool,
    /// Takes counts back: needs the agreement of the stations that build on them.
    pub withdraws: bool,
}

/// An arrow into an operation of this station.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IncomingArrow {
    pub peer: u16,
    pub from: OpId,
    pub to: OpId,
    pub lag: i32,
    /// For each mode of [`ControlMode::ALL`], whether it is observed.
    pub modes: [bool; 6],
}

#[derive(Clone, Debug)]
pub(crate) struct CompiledTransition {
    pub kind: TransitionKind,
    /// Place indices the tokens come from.
    pub from: Vec<u16>,
    /// Place indices the tokens stand in afterwards.
    pub to: Vec<u16>,
}

/// Largest distance of the cycles of neighbours, for each station of the line: a pair of arrows, one of lag 0 and one of lag
/// 1, lets the one be a cycle ahead, and operations listed before the arrow's end may have begun another. `check` finds a
/// line whose arrows allow more.
const CYCLES_APART_MAX: i32 = 2;

/// Reason why a controller cannot be set up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CompileError {
    /// More irreversible operations than a station's word of variables has room for.
    TooManyPaths {
        station: String,
        has: usize,
        /// Largest number.
        most: usize,
    },
    /// More stations that it exchanges counts or positions with than a set of peers has room for.
    TooManyPeers { station: String, has: usize },
    /// The snapshot to start from is not one of this station's: the description has changed, or the file is damaged.
    SnapshotDoesNotFit {
        /// Contradiction.
        why: &'static str,
    },
}

impl std::error::Error for CompileError {}

/// The compiled controller of one station. Immutable; a [`crate::Controller`] plays it.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) station: StationId,
    pub(crate) places: Vec<PlaceTable>,
    pub(crate) rows: Vec<ConditionRow>,
    pub(crate) actions: Vec<CompiledTransition>,
    /// Arrows into the operations of each step.
    pub(crate) causes: Vec<Vec<IncomingArrow>>,
    /// For each operation, the peers with an arrow from it.
    pub(crate) dependents: Vec<PeerSet>,
    /// Stations this one reads or is read by, in chart order.
    pub(crate) peers: Vec<StationId>,
    /// Irreversible operations, in chart order: path `i` is that of `paths[i]`.
    pub(crate) paths: Vec<OpId>,
    /// For each recovery path, the steps from its irreversible operation to home, and whether they lie in the cycle
    /// after the operation's.
    pub(crate) ways_home: Vec<Vec<(u8, i32)>>,
    pub(crate) first: OpId,
    pub(crate) home: OpId,
    pub(crate) home_place: u16,
    pub(crate) step_of: Vec<u8>,
    /// Place index by operation and the seed's number of the place, 0 where the module has no such place.
    place_of: Vec<[u16; 7]>,
    /// The hand-mode buttons that mean anything to this station.
    pub(crate) buttons: u128,
    /// Measurements required for its motions.
    pub(crate) interlocks: Interlocks,
    /// The two states of each of its conflicts, by markings.
    pub(crate) spans: Vec<ConflictSpans>,
    /// All switches of its axes.
    pub(crate) switches: u128,
    /// All switches of its indexes.
    pub(crate) index_switches: u128,
    /// For each step, which of them are on when it is complete; none where a place has no switch, or several.
    pub(crate) measured_after: Vec<Option<u128>>,
    /// For each rest, the operation that stands for it.
    pub(crate) rest_arrivals: Vec<Option<OpId>>,
    /// For each operation, which of them are on while its axis is on its way; none for the other axes.
    pub(crate) measured_within: Vec<Option<u128>>,
    /// Largest number of cycles that a peer can be ahead on a checked line; counts further ahead are treated as
    /// unknown.
    pub(crate) ahead_max: i32,
    /// The numbered places of the endless axis that a drive turns.
    pub(crate) places_of_axis: Option<NumberedPlaces>,
    /// What only a task-driven station has.
    pub(crate) tasks: Option<StationTasks>,
}

impl Program {
    /// Compiles the controller of `station`.
    ///
    /// # Errors
    /// When the station has more irreversible operations, or more peers, than fit.
    pub fn compile(line: &Line, station: StationId) -> Result<Self, CompileError> {
        let described = line.station(station);
        let net = StationNet::of(line, station);
        let paths: Vec<OpId> = described.op_ids().filter(|&op| !is_reversible(line, station, op)).collect();
        if paths.len() > bit::PATHS_MAX {
            return Err(CompileError::TooManyPaths {
                station: described.name.clone(),
                has: paths.len(),
                most: bit::PATHS_MAX,
            });
        }
        let peers = peers_of(line, station);
        if peers.len() > PEERS_MAX {
            return Err(CompileError::TooManyPeers { station: described.name.clone(), has: peers.len() });
        }
        let index_of = |place: StationPlace| {
            let index = net.place_index(place).expect("a net's transitions join its own places");
            u16::try_from(index).expect("OPERATIONS_MAX keeps places far below u16::MAX")
        };
        let mut rows = Vec::new();
        let mut places: Vec<PlaceTable> =
            net.places().iter().map(|&place| compile_place(line, station, &net, &paths, place, &mut rows)).collect();
        let actions = net
            .transitions()
            .iter()
            .map(|t| CompiledTransition {
                kind: t.kind,
                from: t.from.iter().map(|&p| index_of(p)).collect(),
                to: t.to.iter().map(|&p| index_of(p)).collect(),
            })
            .collect();
        let index_switches = places.iter().fold(0, |bits, table| bits | table.turns);
        let measured = places.iter().find(|table| table.is_measured && table.turns != 0);
        let places_of_axis = index_drive(line, station)
            .zip(measured)
            .map(|((drive, numbers), table)| NumberedPlaces::of(drive, numbers, (line, station), table.place.op));
        places_of_axis.iter().for_each(|axis| axis.mark_freeing(&mut places));
        Ok(Program {
            station,
            places,
            rows,
            actions,
            causes: described.steps.iter().map(|step| causes_of(line, station, step, &peers)).collect(),
            dependents: described.op_ids().map(|op| dependents_of(line, (station, op), &peers)).collect(),
            ways_home: paths.iter().map(|&op| way_home(line, station, op)).collect(),
            first: OpId(0),
            home: described.home,
            home_place: index_of(StationPlace::completed(described.home)),
            step_of: described.op_ids().map(|op| described.step_of(op) as u8).collect(),
            place_of: described
                .op_ids()
                .map(|op| {
                    std::array::from_fn(|n| {
                        StationPlace::from_number(op, n as u8).and_then(|p| net.place_index(p)).unwrap_or(0) as u16
                    })
                })
                .collect(),
            buttons: described.operations.iter().fold(0, |bits, operation| {
                let hand = operation.hand;
                let all = [Some(hand.forward()), hand.back(), hand.next()];
                all.into_iter().flatten().fold(bits, |bits, button| bits | held(button))
            }),
            interlocks: Interlocks::of(line, station, &peers, &paths),
            spans: ConflictSpans::of(line, station, &peers),
            switches: described.all_switches(),
            index_switches,
            measured_after: (0..described.steps.len()).map(|step| described.measured_after(step)).collect(),
            rest_arrivals: (0..described.rests.len()).map(|rest| described.arrival_at(RestId::at(rest))).collect(),
            measured_within: described.op_ids().map(|op| described.measured_within(op)).collect(),
            ahead_max: CYCLES_APART_MAX.saturating_mul(line.stations.len() as i32),
            peers,
            paths,
            places_of_axis,
            tasks: StationTasks::of(described),
        })
    }

    pub fn station(&self) -> StationId {
        self.station
    }

    /// The stations whose state this one needs: those with an arrow to or from it, or a conflict with it.
    pub fn peers(&self) -> &[StationId] {
        &self.peers
    }

    /// The index of a place of this station.
    #[inline]
    pub(crate) fn index_of(&self, place: StationPlace) -> u16 {
        let index = self.place_of[place.op.index()][place.number() as usize];
        debug_assert_eq!(self.places[index as usize].place, place, "the place is one of this station's");
        index
    }
}

fn is_reversible(line: &Line, station: StationId, op: OpId) -> bool {
    matches!(line.operation((station, op)).module, OperationModule::Reversible { .. })
}

fn peers_of(line: &Line, station: StationId) -> Vec<StationId> {
    let mut peers: Vec<StationId> = line
        .arrows
        .iter()
        .filter_map(|arrow| match (arrow.from.0 == station, arrow.to.0 == station) {
            (true, false) => Some(arrow.to.0),
            (false, true) => Some(arrow.from.0),
            (true, true) | (false, false) => None,
        })
        .chain(partners(line, station))
        .collect();
    peers.sort_unstable();
    peers.dedup();
    peers
}

fn peer_index(peers: &[StationId], station: StationId) -> u16 {
    peers.iter().position(|&p| p == station).expect("both ends of an arrow are peers") as u16
}

fn causes_of(line: &Line, station: StationId, step: &[OpId], peers: &[StationId]) -> Vec<IncomingArrow> {
    let into = line.arrows.iter().filter(|a| a.to.0 == station && step.contains(&a.to.1));
    into.map(|arrow| {
        let mut modes = [false; 6];
        modes[ControlMode::Auto as usize] = arrow.auto;
        modes[ControlMode::Manual as usize] = arrow.manual;
        // The steps of hand mode satisfy the conditions of both other modes (seed 002 §5.5.2).
        modes[ControlMode::Hand as usize] = true;
        IncomingArrow {
            peer: peer_index(peers, arrow.from.0),
            from: arrow.from.1,
            to: arrow.to.1,
            lag: i32::try_from(arrow.lag).unwrap_or(i32::MAX),
            modes,
        }
    })
    .collect()
}

fn dependents_of(line: &Line, from: (StationId, OpId), peers: &[StationId]) -> PeerSet {
    let out = line.arrows.iter().filter(|a| a.from == from);
    out.map(|arrow| usize::from(peer_index(peers, arrow.to.0))).collect()
}

fn compile_place(
    line: &Line,
    station: StationId,
    net: &StationNet,
    paths: &[OpId],
    place: StationPlace,
    rows: &mut Vec<ConditionRow>,
) -> PlaceTable {
    let operation = line.operation((station, place.op));
    let (signals, watchdog, hold) = match (&operation.module, place.block) {
        (_, Block::Normal) => (operation.normal, operation.watchdog, Some(operation.hand.forward())),
        (OperationModule::Reversible { recovery, recovery_watchdog, .. }, Block::Recovery) => {
            (*recovery, *recovery_watchdog, operation.hand.back())
        }
        (OperationModule::Irreversible { .. }, Block::Recovery) => unreachable!("an I-module has no recovery block"),
    };
    let ranges = ControlMode::ALL.map(|mode| {
        let start = rows.len() as u16;
        for (number, transition) in net.transitions().iter().enumerate() {
            // A join is looked at from its first place alone.
            if transition.from.first() == Some(&place) {
                let join = transition.from.len() > 1;
                rows.extend(transition.terms(mode).iter().map(|t| {
                    let starts = transition.to.iter().any(|place| place.is_operating());
                    compile_term(t, number, transition.kind, (join, starts), paths)
                }));
            }
        }
        (start, rows.len() as u16)
    });
    let operating = |bits: u128| if place.is_operating() { bits } else { 0 };
    let is_index = line.station(station).index_of(place.op).is_some();
    let under_way = is_index && place.stage != MotionStage::Completed;
    PlaceTable {
        place,
        rows: ranges,
        actuator: operating(output(&signals)),
        lamp: if place.is_incomplete() { signals.lamp.map_or(0, |lamp| 1 << lamp.0) } else { 0 },
        complete: operating(1 << signals.complete.0),
        behind: operating(line.station(station).switch_left_behind(place.op, place.block)),
        fault: operating(signals.fault.map_or(0, |fault| 1 << fault.0)),
        watchdog,
        turns: if under_way { signals.complete.bit() } else { 0 },
        least: operation.duration / 2,
        is_measured: is_index
            && index_drive(line, station).is_some_and(|(drive, _)| drive.axis == operation.motion.axis),
        frees: false,
        rest: line.station(station).rest_inputs(place),
        rest_any: line.station(station).rest_alternatives(place).into(),
        hold: operating(hold.map_or(0, held)),
    }
}

fn output(signals: &MotionSignals) -> u128 {
    1 << signals.actuator.0
}

pub(crate) fn held(button: ButtonId) -> u128 {
    1 << (bit::HELD_0 + u32::from(button.0))
}

fn compile_term(
    term: &Conjunction,
    transition: usize,
    kind: TransitionKind,
    (join, starts): (bool, bool),
    paths: &[OpId],
) -> ConditionRow {
    let mut row = ConditionRow {
        need: 0,
        forbid: 0,
        settled: 0,
        transition: transition as u16,
        causal: Causal::Free,
        join,
        starts,
        withdraws: matches!(kind, TransitionKind::Undo(_) | TransitionKind::Back { .. } | TransitionKind::EnterPath(_)),
    };
    for &Literal { var, on } in term {
        let mask = match var {
            Var::Fault(..) => bit::FAULT,
            Var::Arrived(..) => bit::ARRIVED,
            Var::HoldLost => bit::HOLD_LOST,
            Var::Advance => bit::ADVANCE,
            Var::AdvancePressed => bit::edges(bit::ADVANCE),
            Var::Retract => bit::RETRACT,
            Var::RetractPressed => bit::edges(bit::RETRACT),
            Var::Held(button) => held(button),
            Var::Pressed(button) => bit::edges(held(button)),
            Var::OnPath(op) => path_bit(paths, op),
            Var::OnAnyPath => bit::ANY_PATH,
            Var::MasterStop => bit::MASTER_STOP,
            Var::Ordered(task) => task_bit(task),
            Var::Secure => bit::SECURE,
            Var::Causal(step) => {
                row.causal = if on { Causal::Holds(step as u8) } else { Causal::Fails(step as u8) };
                continue;
            }
            Var::WayHome(op) => {
                debug_assert!(on, "no condition asks for a way home that is not free");
                row.causal = Causal::WayHome(path_index(paths, op) as u8);
                continue;
            }
            Var::NeighbourSettled(op) => {
                debug_assert!(on, "no condition asks for an unsettled neighbour");
                row.settled |= 1 << op.0;
                continue;
            }
        };
        if on { row.need |= mask } else { row.forbid |= mask }
    }
    row
}

pub(crate) fn task_bit(task: TaskId) -> u128 {
    1 << (bit::TASK_0 + u32::from(task.0))
}

pub(crate) fn path_bit(paths: &[OpId], op: OpId) -> u128 {
    1 << (bit::PATH_0 + path_index(paths, op) as u32)
}

pub(crate) fn path_index(paths: &[OpId], op: OpId) -> usize {
    paths.iter().position(|&p| p == op).expect("a path belongs to an irreversible operation")
}

fn way_home(line: &Line, station: StationId, failed: OpId) -> Vec<(u8, i32)> {
    let described = line.station(station);
    if described.is_task_driven() {
        // It has no arrows, and what it skips has no dependents.
        return Vec::new();
    }
    let (count, home, failed) = (described.steps.len(), described.step_of(described.home), described.step_of(failed));
    let length = (home + count - failed) % count;
    (1..=length).map(|n| (((failed + n) % count) as u8, i32::from(failed + n >= count))).collect()
}
