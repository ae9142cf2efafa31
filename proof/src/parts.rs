//! A line too large to explore, looked at in parts: for each conflict, the stations it takes to decide it.
//!
//! A part is some stations of the line with the arrows among them. Arrows to and from the others are left out, which
//! gives the stations of the part more freedom and never less:
//! * an arrow that is not there lets its operation start whenever it likes;
//! * a station without dependents outside needs fewer agreements to take a count back; a command that was refused from
//!   outside leaves its station as if it had not been given;
//! * requests of stations outside only ever block.
//!
//! There is one exception: where one button both leads on and leads back, it leads back exactly if the arrows into the
//! next step do *not* hold. A station that has such a step brings along all stations those arrows come from. So
//! whatever the stations of a part can do within the line, they can do in the part; a conflict that the part never
//! reaches, the line never reaches.
//!
//! # Stars
//! A station that many others wait for would bring all of them along. Where that is more than a few, it gets **buttons
//! of its own for each direction of each hand-mode sequence** instead (`divide`), and its reads of stations outside are
//! left out like any arrow. This too gives more freedom and never less. Let a button B of the line be `next` and `back`
//! of an operation o; in the part it becomes N, which runs what follows, and K, which takes o back.
//! * Conditions of hand mode read buttons in few places: held `forward` where an operation runs or leads on within its
//!   sequence, held `back` where it runs back or leads back within its sequence, pressed `forward` where it is undone,
//!   and pressed `back` or `next` where it is complete. `forward` and `back` of one sequence differ. So B is read in
//!   one meaning at a time, but for the last place, where both of its meanings are possible.
//! * There, pressing B leads on if all arrows into the next step hold. Then those of the part hold, which are some of
//!   them, and pressing N leads on in the part. Otherwise B leads back; pressing K does so in the part, which does not
//!   read arrows.
//! * Everywhere else the part holds or presses whichever of N and K is meant. That may change while B stays held: then the
//!   operator of the part lets go and presses the other one, which moves nothing where an operation runs or stands, and
//!   fires what is meant where it is complete or undone.
//! * Which buttons are pressed at one station has no bearing on another: in the exploration each receives buttons by
//!   itself. Auto and manual mode do not read them.
//!
//! The second point needs a station with one token where B has two meanings: of operations side by side one could be led
//! back by K that B would leave alone. Such a station brings the others along, as does one with more sequences than there
//! are buttons. `tests/parts.rs` holds generated lines and stars against their parts.
//!
//! # Restarts
//! A station that restarts does so in the part as in the line, with its buttons released in both. One without its memory knows no
//! counts: every arrow into it blocks, and those that the part leaves out do not. Manual mode ends for the line once any station
//! has lost its memory, for the part once one of its own has. So this holds of restarts as well
//! (`docs/decisions/0026-restarts-in-parts.md`).
//!
//! The converse does not hold: a conflict reached in a part may be prevented by somebody outside it, and stations that
//! run away from each other in a part may be held back.

use std::collections::HashSet;

use linewright_line::net::{ControlMode, StationNet, Var};
use linewright_line::{
    Arrow, BUTTONS_MAX, ButtonId, Conflict, Console, DeviceBus, Line, MaterialFlow, OperationModule, StateSpan,
    Station, StationId,
};

/// A part of more stations than this is divided further where it can be.
const TOGETHER_MAX: usize = 3;

/// Some stations of a line, as a line of their own.
#[derive(Clone, Debug)]
pub struct SubLine {
    /// The stations, by their ids in the whole line, in its order.
    pub stations: Vec<StationId>,
    /// The conflicts of the whole line that it decides.
    pub conflicts: Vec<usize>,
    /// They alone.
    pub line: Line,
}

impl SubLine {
    /// The two stations of a conflict, with all conflicts between them; this one first.
    pub fn of_conflict(line: &Line, conflict: &Conflict) -> Self {
        let stations = vec![conflict.a.station, conflict.b.station];
        let mut part = part_of(line, &stations);
        let span = |span: StateSpan, station: u16| StateSpan { station: StationId(station), ..span };
        // First the one to be decided. The others between the two stay: their guards stand as well, and two pairs are
        // alike only if all of them are.
        let asked = Conflict { why: conflict.why.clone(), a: span(conflict.a, 0), b: span(conflict.b, 1) };
        part.conflicts.retain(|other| *other != asked);
        part.conflicts.insert(0, asked);
        SubLine { stations, conflicts: Vec::new(), line: part }
    }

    /// The names of its stations.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.line.stations.iter().map(|station| station.name.as_str()).collect();
        names.join(", ")
    }

    /// Whether the two differ in nothing but names and times: what is decided of one is decided of the other.
    pub fn is_like(&self, other: &SubLine) -> bool {
        nameless(&self.line) == nameless(&other.line)
    }
}

/// Parts that decide every conflict of a line but for those of tasks, each part once, in the order of the conflicts.
pub fn parts(line: &Line) -> Vec<SubLine> {
    parts_around(line, &of_conflicts(line), TOGETHER_MAX)
}

/// The same with every part as small as it can be, and every station in one: a station without a conflict alone, or with
/// those that it brings along. None if one of them has all stations of the line.
pub fn smallest_parts(line: &Line) -> Vec<SubLine> {
    let mut parts = parts_around(line, &of_conflicts(line), 0);
    let in_none = |id: &StationId| !parts.iter().any(|part| part.stations.contains(id));
    let alone: Vec<PartCore> = line.station_ids().filter(in_none).map(|id| ([id, id], None)).collect();
    parts.extend(parts_around(line, &alone, 0));
    if parts.iter().any(|part| part.stations.len() == line.stations.len()) { Vec::new() } else { parts }
}

/// What a part is made around: two stations, and the conflict between them if it is one.
type PartCore = ([StationId; 2], Option<usize>);

fn of_conflicts(line: &Line) -> Vec<PartCore> {
    let of_arrows = line.conflicts.iter().enumerate().filter(|(_, conflict)| !line.is_of_tasks(conflict));
    of_arrows.map(|(nth, conflict)| ([conflict.a.station, conflict.b.station], Some(nth))).collect()
}

fn parts_around(line: &Line, cores: &[PartCore], together_max: usize) -> Vec<SubLine> {
    let joins = StationJoins::of(line);
    let mut parts: Vec<SubLine> = Vec::new();
    for &(pair, conflict) in cores {
        let mut stations = closure(&joins.reads_absence, &pair);
        if stations.len() > together_max {
            stations = closure(&joins.inseparable, &pair);
        }
        if let Some(part) = parts.iter_mut().find(|part| part.stations == stations) {
            part.conflicts.extend(conflict);
            continue;
        }
        parts.push(SubLine {
            line: joins.part_with(line, &stations),
            stations,
            conflicts: conflict.into_iter().collect(),
        });
    }
    parts
}

/// The part with the stations besides through which arrows lead from one of its stations to another one by the
/// shortest way: they may prevent what the part reaches. None where there are none.
pub fn larger(line: &Line, part: &SubLine) -> Option<SubLine> {
    let joins = StationJoins::of(line);
    let between = between(line, &part.stations)?;
    let stations = closure(&joins.inseparable, &[&part.stations[..], &between].concat());
    Some(SubLine { line: joins.part_with(line, &stations), stations, conflicts: part.conflicts.clone() })
}

/// The stations outside on the shortest way along arrows, in either direction, from one of these stations to another one of them.
fn between(line: &Line, stations: &[StationId]) -> Option<Vec<StationId>> {
    let mut ways: Vec<Vec<StationId>> = stations.iter().map(|&id| vec![id]).collect();
    // Each station outside is reached first by one of the shortest ways to it from each station inside.
    let mut reached: HashSet<(StationId, StationId)> = HashSet::new();
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in &ways {
            let (first, last) = (way[0], way[way.len() - 1]);
            for next in line.arrows.iter().filter_map(|arrow| other_end(arrow, last)) {
                if stations.contains(&next) {
                    if next != first && way.len() > 1 {
                        return Some(way[1..].to_vec());
                    }
                } else if reached.insert((first, next)) {
                    longer.push([&way[..], &[next]].concat());
                }
            }
        }
        ways = longer;
    }
    None
}

fn other_end(arrow: &Arrow, of: StationId) -> Option<StationId> {
    let (from, to) = (arrow.from.0, arrow.to.0);
    if from == of { Some(to) } else { (to == of).then_some(from) }
}

/// What joins the stations of a line besides arrows.
struct StationJoins {
    /// By station: those whose arrows it acts on when they do not hold.
    reads_absence: Vec<Vec<StationId>>,
    /// The same of those that cannot be given buttons of their own instead.
    inseparable: Vec<Vec<StationId>>,
    divided: Vec<Option<Sequences>>,
}

impl StationJoins {
    fn of(line: &Line) -> Self {
        let reads_absence = absence_read(line);
        let divided: Vec<Option<Sequences>> = line.stations.iter().map(Sequences::of).collect();
        let inseparable = std::iter::zip(&reads_absence, &divided)
            .map(|(read, divided)| if divided.is_some() { Vec::new() } else { read.clone() })
            .collect();
        StationJoins { reads_absence, inseparable, divided }
    }

    /// These stations alone; those that act on arrows from outside have buttons of their own for each direction.
    fn part_with(&self, line: &Line, stations: &[StationId]) -> Line {
        let mut part = part_of(line, stations);
        let all_here = |id: StationId| self.reads_absence[id.index()].iter().all(|read| stations.contains(read));
        let outside: Vec<usize> = (0..stations.len()).filter(|&nth| !all_here(stations[nth])).collect();
        outside.iter().for_each(|&nth| divide(&mut part, nth, &self.divided[stations[nth].index()]));
        part
    }
}

/// The hand-mode sequences of a station in which one button has two meanings, and can be two.
#[derive(Debug)]
struct Sequences {
    /// For each step, its sequence.
    of_step: Vec<usize>,
    count: usize,
}

impl Sequences {
    /// `None` where one button means two things beside another operation, and where the buttons do not suffice.
    fn of(station: &Station) -> Option<Self> {
        let steps = station.steps.len();
        let hand = |step: usize| station.operations[station.steps[step % steps][0].index()].hand;
        // A sequence may go on beyond the end of the list: count from where one begins.
        let begins = |step: usize| hand(step + steps - 1).next().is_some();
        let first = (0..steps).find(|&step| begins(step))?;
        let mut sequences = Sequences { of_step: vec![0; steps], count: 0 };
        for step in first..first + steps {
            sequences.count += usize::from(begins(step));
            sequences.of_step[step % steps] = sequences.count - 1;
        }
        let leads_on = |step: usize| hand(step).next().is_none_or(|next| next == hand(step + 1).forward());
        let one_meaning = |step: usize| hand(step).next().is_none() || hand(step).next() != hand(step).back();
        let one_by_one = |step: usize| station.steps[step].len() == 1 || one_meaning(step);
        let fits = 2 * sequences.count <= BUTTONS_MAX && !station.is_task_driven();
        (fits && (0..steps).all(|step| leads_on(step) && one_by_one(step))).then_some(sequences)
    }
}

/// Gives a station of a part two buttons for each of its sequences, one for each direction. Those of other stations may
/// be the same: each station receives buttons by itself.
fn divide(part: &mut Line, station: usize, sequences: &Option<Sequences>) {
    let Some(Sequences { of_step, count }) = sequences else { return };
    let others = part.stations.iter().enumerate().filter(|&(nth, _)| nth != station);
    let hands = others.flat_map(|(_, other)| other.operations.iter().map(|operation| operation.hand));
    let used: Vec<ButtonId> =
        hands.flat_map(|hand| [Some(hand.forward()), hand.back(), hand.next()]).flatten().collect();
    // Where there are not enough for names of their own, the names are those of two stations; within a station no two are
    // the same, since one that leads on and back again would need the arrows that were left out.
    let is_used = |button: &ButtonId| used.contains(button);
    let all = || (0..BUTTONS_MAX).map(ButtonId::at);
    let buttons: Vec<ButtonId> =
        all().filter(|button| !is_used(button)).chain(all().filter(is_used)).take(2 * count).collect();
    let names = part.buttons.clone();
    part.buttons.resize(BUTTONS_MAX, String::new());
    let station = &mut part.stations[station];
    for (step, ops) in station.steps.iter().enumerate() {
        let [forward, back] = [0, 1].map(|way| buttons[2 * of_step[step] + way]);
        let next = buttons[2 * of_step[(step + 1) % of_step.len()]];
        for op in ops {
            let hand = &mut station.operations[op.index()].hand;
            part.buttons[forward.index()] = names[hand.forward().index()].clone();
            if let Some(named) = hand.back() {
                part.buttons[back.index()] = format!("{} (back)", names[named.index()]);
            }
            *hand = hand.kind().with(forward, Some(back), Some(next)).unwrap_or(*hand);
        }
    }
}

/// Each task-driven station, alone: nothing joins it to another, and its orders are arbitrary.
pub fn task_driven(line: &Line) -> Vec<SubLine> {
    line.station_ids().filter(|&id| line.station(id).is_task_driven()).map(|id| alone(line, id)).collect()
}

/// One station, without arrows and conflicts.
pub fn alone(line: &Line, id: StationId) -> SubLine {
    SubLine { stations: vec![id], conflicts: Vec::new(), line: part_of(line, &[id]) }
}

/// The stations that go round a cycle, as a line of their own with all conflicts.
pub fn cyclic(line: &Line) -> Line {
    let stations: Vec<StationId> = line.station_ids().filter(|&id| !line.station(id).is_task_driven()).collect();
    part_of(line, &stations)
}

/// For each station, those whose arrows it acts on when they do not hold.
fn absence_read(line: &Line) -> Vec<Vec<StationId>> {
    line.station_ids()
        .map(|id| {
            let net = StationNet::of(line, id);
            let terms = net.transitions().iter().flat_map(|t| ControlMode::ALL.iter().flat_map(|&mode| t.terms(mode)));
            let mut steps: Vec<usize> = terms
                .flatten()
                .filter_map(|literal| match literal.var {
                    Var::Causal(step) if !literal.on => Some(step),
                    _ => None,
                })
                .collect();
            steps.sort_unstable();
            steps.dedup();
            let into = |arrow: &&Arrow| arrow.to.0 == id && steps.contains(&line.station(id).step_of(arrow.to.1));
            let mut from: Vec<StationId> = line.arrows.iter().filter(into).map(|arrow| arrow.from.0).collect();
            from.sort_unstable();
            from.dedup();
            from
        })
        .collect()
}

fn closure(reads_absence: &[Vec<StationId>], start: &[StationId]) -> Vec<StationId> {
    let mut stations = Vec::new();
    let mut open = start.to_vec();
    while let Some(station) = open.pop() {
        if !stations.contains(&station) {
            stations.push(station);
            open.extend(&reads_absence[station.index()]);
        }
    }
    stations.sort_unstable();
    stations
}

fn part_of(line: &Line, stations: &[StationId]) -> Line {
    let number = |id: StationId| stations.iter().position(|&s| s == id).map(StationId::at);
    let arrow = |arrow: &Arrow| {
        let (from, to) = (number(arrow.from.0)?, number(arrow.to.0)?);
        Some(Arrow { from: (from, arrow.from.1), to: (to, arrow.to.1), ..*arrow })
    };
    let span = |span: &StateSpan| Some(StateSpan { station: number(span.station)?, ..*span });
    let conflict = |conflict: &Conflict| {
        Some(Conflict { why: conflict.why.clone(), a: span(&conflict.a)?, b: span(&conflict.b)? })
    };
    Line {
        name: line.name.clone(),
        title: line.title.clone(),
        stations: stations.iter().map(|&id| line.station(id).clone()).collect(),
        arrows: line.arrows.iter().filter_map(arrow).collect(),
        conflicts: line.conflicts.iter().filter_map(conflict).collect(),
        devices: Vec::new(),
        buttons: line.buttons.clone(),
        console: Console::default(),
        timing: line.timing,
        handling: MaterialFlow::default(),
    }
}

/// The line with every name and time taken away that no exploration sees.
fn nameless(line: &Line) -> Line {
    let mut line = line.clone();
    for station in &mut line.stations {
        station.name.clear();
        station.title.clear();
        station.bus = DeviceBus::Line;
        let names = station.inputs.iter_mut().chain(&mut station.outputs);
        names.for_each(String::clear);
        station.axes.iter_mut().for_each(|axis| axis.name.clear());
        for operation in &mut station.operations {
            operation.name.clear();
            // Time stands still in an exploration.
            (operation.duration, operation.watchdog) = Default::default();
            if let OperationModule::Reversible { recovery_duration, recovery_watchdog, .. } = &mut operation.module {
                (*recovery_duration, *recovery_watchdog) = Default::default();
            }
        }
    }
    line.buttons.clear();
    line.conflicts.iter_mut().for_each(|conflict| conflict.why.clear());
    line
}
