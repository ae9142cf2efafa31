//! Checks of counts against the chart, with the counts that the stations have themselves.

use linewright_line::net::{Block, ControlMode};
use linewright_line::{Arrow, Line, OpId, StationId, Tick};
use linewright_plant::Plant;
use linewright_station_logic::StationSnapshot;

use crate::observer::{Observer, TOLERANCE};

/// What another station has now; none where it is not running and its memory is lost.
type Counts<'a> = &'a dyn Fn(usize) -> Option<StationSnapshot>;

impl Observer {
    /// A station is about to write a record. `of` gives what another station has now.
    pub(crate) fn counted(
        &mut self,
        line: &Line,
        plant: &Plant,
        (now, at, mode): (Tick, usize, ControlMode),
        record: StationSnapshot,
        of: Counts<'_>,
    ) {
        let id = StationId::at(at);
        let before = self.stations[at].record.take().filter(|before| before.generation == record.generation);
        if let Some(before) = &before {
            self.taken_back(line, (now, id), before, &record, of);
            self.counted_where_it_stands(line, plant, (now, id, mode), before, &record);
            self.begins_by_the_chart(line, (now, id, mode), before, &record, of);
            self.leaves_nothing_out(line, (now, id), before, &record);
        }
        self.stations[at].record = Some(record);
    }

    /// A count is taken back before the motion starts, and only when no other station has built on it.
    fn taken_back(
        &mut self,
        line: &Line,
        (now, id): (Tick, StationId),
        before: &StationSnapshot,
        record: &StationSnapshot,
        of: Counts<'_>,
    ) {
        let name = &line.station(id).name;
        let on_path = before.path.is_some() || record.path.is_some();
        for (op, operation) in line.station(id).operations.iter().enumerate() {
            let moves = |state: &StationSnapshot| {
                let back = |place: &&linewright_line::net::StationPlace| place.block == Block::Recovery;
                state.marking.iter().filter(back).any(|place| place.op.index() == op && place.is_operating())
            };
            if !on_path && moves(record) && !moves(before) && record.done[op] >= before.started[op] {
                let op = &operation.name;
                self.find(now, format!("{name}: {op} is undone while it counts as done"));
                return;
            }
            if record.done[op] >= before.done[op] {
                continue;
            }
            // What holds in auto alone is no agreement of those who are led in manual.
            let from_here = |arrow: &&Arrow| arrow.manual && arrow.from.0 == id && arrow.from.1.index() == op;
            for arrow in line.arrows.iter().filter(from_here) {
                let Some(other) = of(arrow.to.0.index()) else { continue };
                let started = other.started[arrow.to.1.index()];
                if other.generation == record.generation
                    && record.generation != 0
                    && started >= before.done[op] + arrow.lag as i32
                {
                    let (what, by, cycle) = (&operation.name, &line.station(arrow.to.0).name, before.done[op]);
                    let text = format!("{name}: {what} is taken back in cycle {cycle}, and {by} has started on it");
                    return self.find(now, text);
                }
            }
        }
    }

    /// In auto a count rises only where the mechanism stands at the end of the operation.
    fn counted_where_it_stands(
        &mut self,
        line: &Line,
        plant: &Plant,
        (now, id, mode): (Tick, StationId, ControlMode),
        before: &StationSnapshot,
        record: &StationSnapshot,
    ) {
        if mode != ControlMode::Auto {
            return;
        }
        let station = line.station(id);
        for (op, operation) in station.operations.iter().enumerate() {
            let motion = &operation.motion;
            let stroke = (motion.to - motion.from).abs();
            if record.done[op] == before.done[op] + 1 && stroke > 0.0 {
                let position = plant.position(id, motion.axis);
                if (position - motion.to).abs() > TOLERANCE * stroke {
                    let (name, op) = (&station.name, &operation.name);
                    self.find(now, format!("{name}: {op} is counted at {position:.2}, not at {:.2}", motion.to));
                }
            }
        }
    }

    /// An operation starts only when what it waits for in this mode is done, in the counts of the other station itself. A
    /// recovery path starts only when that holds for every operation that it skips: on the way home the mechanism passes
    /// through all that they keep clear.
    fn begins_by_the_chart(
        &mut self,
        line: &Line,
        (now, id, mode): (Tick, StationId, ControlMode),
        before: &StationSnapshot,
        record: &StationSnapshot,
        of: Counts<'_>,
    ) {
        let station = line.station(id);
        let begun = record.path.filter(|_| before.path.is_none());
        let skipped = |op: OpId| cycle_skipped(line, id, begun?, op).map(|ahead| record.cycle + ahead);
        for op in station.op_ids() {
            let has_started = record.started[op.index()] > before.started[op.index()];
            let Some(cycle) = skipped(op).or(has_started.then_some(record.started[op.index()])) else { continue };
            for arrow in line.arrows.iter().filter(|arrow| arrow.to == (id, op)) {
                let is_observed = match mode {
                    ControlMode::Auto => arrow.auto,
                    ControlMode::Manual => arrow.manual,
                    ControlMode::Hand => true,
                    ControlMode::Home | ControlMode::StandBy | ControlMode::EStop => false,
                };
                let Some(other) = of(arrow.from.0.index()).filter(|_| is_observed) else { continue };
                let done = other.done[arrow.from.1.index()];
                if record.generation != 0 && other.generation == record.generation && done + (arrow.lag as i32) < cycle
                {
                    let (name, what) = (&station.name, &line.operation((id, op)).name);
                    let (from, waits) = (&line.station(arrow.from.0).name, &line.operation(arrow.from).name);
                    let how = if begun.is_some() { "is skipped on the way home" } else { "starts" };
                    let text =
                        format!("{name}: {what} {how} in cycle {cycle}, and {from} has done {waits} {done} times");
                    return self.find(now, text);
                }
            }
        }
    }

    /// An operation counts as done in a cycle only when all that are listed before it are done in that cycle.
    fn leaves_nothing_out(
        &mut self,
        line: &Line,
        (now, id): (Tick, StationId),
        before: &StationSnapshot,
        record: &StationSnapshot,
    ) {
        let station = line.station(id);
        if record.generation == 0 {
            return;
        }
        for op in station.op_ids().filter(|op| record.done[op.index()] > before.done[op.index()]) {
            let is_before = |other: &OpId| station.step_of(*other) < station.step_of(op);
            let left_out = |other: &OpId| record.done[other.index()] < record.done[op.index()];
            if let Some(other) = station.op_ids().filter(is_before).find(left_out) {
                let (name, cycle) = (&station.name, record.done[op.index()]);
                let (op, other) = (&line.operation((id, op)).name, &line.operation((id, other)).name);
                return self
                    .find(now, format!("{name}: {op} counts as done in cycle {cycle}, and {other} was left out"));
            }
        }
    }
}

/// Whether a recovery path of `failed` skips an operation, and how many cycles later that one would have been done.
fn cycle_skipped(line: &Line, id: StationId, failed: OpId, op: OpId) -> Option<i32> {
    let station = line.station(id);
    let count = station.steps.len();
    let (home, failed, step) = (station.step_of(station.home), station.step_of(failed), station.step_of(op));
    let after = |step: usize| (step + count - failed) % count;
    (after(step) >= 1 && after(step) <= after(home)).then_some(i32::from(step < failed))
}
