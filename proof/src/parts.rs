//! A line too large to explore, looked at in parts: for each conflict, the stations it takes to decide it.
//!
//! A part is some stations of the line with the arrows among them. Arrows to and from the others are left out, which
//! gives the stations of the part more freedom and never less:
//! * an arrow that is not there lets its operation start whenever it likes;
//! * a station that nobody outside builds on needs fewer agreements to take a count back; a command that was refused
//!   by somebody outside leaves its station as if it had not been given;
//! * what stations outside ask for only ever blocks.
//!
//! There is one exception: where one button both leads on and leads back, it leads back exactly if the arrows into the
//! next step do *not* hold. A station that has such a step brings along everybody those arrows come from. So whatever
//! the stations of a part can do within the line, they can do in the part; a conflict that the part never reaches, the
//! line never reaches.
//!
//! The converse does not hold: a conflict reached in a part may be prevented by somebody outside it, and stations that
//! run away from each other in a part may be held back.

use linewright_line::net::{ControlMode, StationNet, Var};
use linewright_line::{Arrow, Conflict, Console, Line, MaterialFlow, StateSpan, StationId};

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
    /// The names of its stations.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.line.stations.iter().map(|station| station.name.as_str()).collect();
        names.join(", ")
    }

    /// Whether the two differ in nothing but names: what is decided of one is decided of the other.
    pub fn is_like(&self, other: &SubLine) -> bool {
        nameless(&self.line) == nameless(&other.line)
    }
}

/// Parts that decide every conflict of a line but for those of tasks, each part once, in the order of the conflicts.
pub fn parts(line: &Line) -> Vec<SubLine> {
    let reads_absence = absence_read(line);
    let mut parts: Vec<SubLine> = Vec::new();
    let of_arrows = line.conflicts.iter().enumerate().filter(|(_, conflict)| !line.is_of_tasks(conflict));
    for (nth, conflict) in of_arrows {
        let stations = closure(&reads_absence, [conflict.a.station, conflict.b.station]);
        match parts.iter_mut().find(|part| part.stations == stations) {
            Some(part) => part.conflicts.push(nth),
            None => parts.push(SubLine { line: part_of(line, &stations), stations, conflicts: vec![nth] }),
        }
    }
    parts
}

/// Each station that works on order, alone: nothing joins it to another, and who gives it orders gives any.
pub fn on_order(line: &Line) -> Vec<SubLine> {
    let alone = |id| SubLine { stations: vec![id], conflicts: Vec::new(), line: part_of(line, &[id]) };
    line.station_ids().filter(|&id| line.station(id).is_task_driven()).map(alone).collect()
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

fn closure(reads_absence: &[Vec<StationId>], start: [StationId; 2]) -> Vec<StationId> {
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

/// The line with every name taken away that no controller sees.
fn nameless(line: &Line) -> Line {
    let mut line = line.clone();
    for station in &mut line.stations {
        station.name.clear();
        station.title.clear();
        let names = station.inputs.iter_mut().chain(&mut station.outputs);
        names.for_each(String::clear);
        station.axes.iter_mut().for_each(|axis| axis.name.clear());
        station.operations.iter_mut().for_each(|operation| operation.name.clear());
    }
    line.conflicts.iter_mut().for_each(|conflict| conflict.why.clear());
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_line::{TransferLine, parse};

    fn transfer_line(machines: usize) -> Line {
        parse("line.toml", &TransferLine { machines, time_scale: 1.0 }.text()).expect("the shipped line is sound").line
    }

    #[test]
    fn a_line_of_one_machine_is_its_own_part() {
        let line = transfer_line(1);
        let parts = parts(&line);
        assert_eq!(parts.len(), 1);
        assert_eq!(parts[0].names(), "transfer, clamp_1, mill_1");
        assert_eq!((&parts[0].line.arrows, &parts[0].line.conflicts), (&line.arrows, &line.conflicts));
        assert_eq!(parts[0].conflicts, [0, 1]);
    }

    #[test]
    fn machines_beside_each_other_are_parts_that_differ_in_names_alone() {
        let line = transfer_line(4);
        let parts = parts(&line);
        assert_eq!(parts.len(), 4);
        assert!(parts.iter().all(|part| part.is_like(&parts[0])));
        assert!(parts.iter().enumerate().all(|(nth, part)| part.names().contains(&format!("mill_{}", nth + 1))));
        let decided: usize = parts.iter().map(|part| part.conflicts.len()).sum();
        assert_eq!(decided, line.conflicts.len());
    }
}
