//! The timing bar chart as an event graph: operations, and what each waits for.
//!
//! An edge from A to B with lag k says that B starts in its cycle c only when A is done in cycle c − k: the arrows, the
//! order inside a station (lag 0), and the step from a station's last operation to its first (lag 1). It is a marked
//! graph, with an operation for each transition and an edge for each place; at home an edge holds as many tokens as
//! starts it already allows. Firing never changes the tokens on a circuit, and these are the sum of its lags.
//!
//! This is forward motion alone: nothing here knows of faults, or of operations taken back.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use linewright_line::{Conflict, Line, OpId, Span, StationId};

use super::full_name;

type Operation = (StationId, OpId);

struct Edge {
    to: usize,
    lag: u32,
}

/// Operations numbered through all stations, and for each what waits for it.
struct Chart<'a> {
    line: &'a Line,
    operations: Vec<Operation>,
    /// The number of a station's first operation.
    first: Vec<usize>,
    followers: Vec<Vec<Edge>>,
}

/// Which arrows count.
#[derive(Clone, Copy)]
enum Arrows {
    /// All of them: what has to be waited for at worst, however modes change.
    Any,
    /// Those that hold in both modes: what has to be waited for at least, however modes change.
    InBothModes,
    InAuto,
}

impl<'a> Chart<'a> {
    fn of(line: &'a Line, arrows: Arrows) -> Self {
        let operations: Vec<Operation> =
            line.station_ids().flat_map(|id| line.station(id).op_ids().map(move |op| (id, op))).collect();
        let mut first = Vec::with_capacity(line.stations.len());
        let mut count = 0;
        for station in &line.stations {
            first.push(count);
            count += station.operations.len();
        }
        let followers = operations.iter().map(|_| Vec::new()).collect();
        let mut chart = Chart { line, operations, first, followers };
        chart.add_cycles();
        for arrow in &line.arrows {
            let counts = match arrows {
                Arrows::Any => arrow.auto || arrow.manual,
                Arrows::InBothModes => arrow.auto && arrow.manual,
                Arrows::InAuto => arrow.auto,
            };
            if counts {
                chart.add(arrow.from, arrow.to, arrow.lag);
            }
        }
        chart
    }

    fn number(&self, (station, op): Operation) -> usize {
        self.first[station.index()] + op.index()
    }

    fn add(&mut self, from: Operation, to: Operation, lag: u32) {
        let (from, to) = (self.number(from), self.number(to));
        self.followers[from].push(Edge { to, lag });
    }

    fn add_cycles(&mut self) {
        for id in self.line.station_ids() {
            let steps = &self.line.station(id).steps;
            for (index, step) in steps.iter().enumerate() {
                let next = (index + 1) % steps.len();
                for &from in step {
                    for &to in &steps[next] {
                        self.add((id, from), (id, to), u32::from(next == 0));
                    }
                }
            }
        }
    }

    fn edges(&self) -> impl Iterator<Item = (usize, &Edge)> {
        self.followers.iter().enumerate().flat_map(|(from, edges)| edges.iter().map(move |edge| (from, edge)))
    }

    /// The tokens of an edge while every station stands at home.
    fn tokens_at_home(&self, from: usize, edge: &Edge) -> i64 {
        let count = |number: usize| {
            let (station, op) = self.operations[number];
            let station = self.line.station(station);
            i64::from(station.home_count(op, station.initial_round()))
        };
        count(from) - count(edge.to) + i64::from(edge.lag)
    }

    fn name(&self, number: usize) -> String {
        full_name(self.line, self.operations[number])
    }

    /// The least sum of lags on a way, if it is at most `limit`.
    fn least_lag(&self, from: Operation, to: Operation, limit: u32) -> Option<u32> {
        let (from, to) = (self.number(from), self.number(to));
        // Ordered, not hashed, and only as large as what is within the limit.
        let mut least = BTreeMap::from([(from, 0)]);
        let mut open = BinaryHeap::from([Reverse((0, from))]);
        while let Some(Reverse((lag, at))) = open.pop() {
            if at == to {
                return Some(lag);
            }
            if least.get(&at).is_some_and(|&known| known < lag) {
                continue;
            }
            for edge in &self.followers[at] {
                let there = lag + edge.lag;
                if there <= limit && least.get(&edge.to).is_none_or(|&known| there < known) {
                    least.insert(edge.to, there);
                    open.push(Reverse((there, edge.to)));
                }
            }
        }
        None
    }

    /// Whether every operation waits, through others, for every other: then no station can run away from another.
    fn is_strongly_connected(&self) -> bool {
        let mut predecessors: Vec<Vec<usize>> = self.followers.iter().map(|_| Vec::new()).collect();
        self.edges().for_each(|(from, edge)| predecessors[edge.to].push(from));
        let reaches_all = |next: &dyn Fn(usize) -> Vec<usize>| {
            let mut seen = vec![false; self.operations.len()];
            let mut stack = vec![0];
            while let Some(at) = stack.pop() {
                if !std::mem::replace(&mut seen[at], true) {
                    stack.extend(next(at));
                }
            }
            seen.into_iter().all(|seen| seen)
        };
        reaches_all(&|at| self.followers[at].iter().map(|edge| edge.to).collect())
            && reaches_all(&|at| predecessors[at].clone())
    }
}

/// What counts as done at home did not need what is not done: no edge is in debt.
pub fn home_is_consistent(line: &Line) -> Result<String, String> {
    let chart = Chart::of(line, Arrows::Any);
    match chart.edges().find(|(from, edge)| chart.tokens_at_home(*from, edge) < 0) {
        None => Ok("all stations can stand at home together".to_owned()),
        Some((from, edge)) => Err(format!(
            "at home `{}` counts as done, though it waits for `{}`, which does not",
            chart.name(edge.to),
            chart.name(from)
        )),
    }
}

/// The operation causality condition: the event graph is live, since every circuit carries a token.
pub fn every_circuit_has_a_token(line: &Line) -> Result<String, String> {
    let chart = Chart::of(line, Arrows::Any);
    if let Some(circuit) = circuit_without_token(&chart) {
        let names: Vec<String> = circuit.iter().map(|&number| chart.name(number)).collect();
        return Err(format!("each of these waits for the one before it: {}", names.join(" → ")));
    }
    let waits = if chart.is_strongly_connected() {
        "no station can run away from another"
    } else {
        "some stations may run ahead of others without limit"
    };
    Ok(format!(
        "{} operations, {} waits, every circuit of them has a token; {waits}",
        chart.operations.len(),
        chart.edges().count()
    ))
}

/// A circuit of edges without lag, if there is one; closed by naming its first operation again.
///
/// Lags and not the tokens at home: on a circuit their sums are the same, and lags exist where home is inconsistent.
fn circuit_without_token(chart: &Chart<'_>) -> Option<Vec<usize>> {
    let mut waits_for = vec![0usize; chart.operations.len()];
    chart.edges().filter(|(_, edge)| edge.lag == 0).for_each(|(_, edge)| waits_for[edge.to] += 1);
    let mut ready: Vec<usize> = (0..waits_for.len()).filter(|&number| waits_for[number] == 0).collect();
    while let Some(number) = ready.pop() {
        for edge in chart.followers[number].iter().filter(|edge| edge.lag == 0) {
            waits_for[edge.to] -= 1;
            if waits_for[edge.to] == 0 {
                ready.push(edge.to);
            }
        }
    }
    // Whoever still waits waits for another who does: going back from one of them must come round.
    let stuck = |number: usize| waits_for[number] > 0;
    let mut before = vec![None; waits_for.len()];
    let lagless = chart.edges().filter(|(from, edge)| edge.lag == 0 && stuck(*from) && stuck(edge.to));
    lagless.for_each(|(from, edge)| before[edge.to] = Some(from));
    let mut at = (0..waits_for.len()).find(|&number| stuck(number))?;
    let mut way = vec![at];
    loop {
        at = before[at]?;
        if let Some(start) = way.iter().position(|&number| number == at) {
            let mut circuit = way.split_off(start);
            circuit.push(at);
            circuit.reverse();
            return Some(circuit);
        }
        way.push(at);
    }
}

/// Whether the two states of a conflict exclude each other in forward motion, in every mode and across changes of mode.
///
/// Let `b` start only after `a` of P cycles before has ended (P the least lag from `a.until` to `b.from`), and the
/// other way round with Q. The i-th `a` ends in cycle i, or in the next one if it crosses the boundary (w = 1). So it
/// is over before the j-th `b` begins if i ≤ j − P − w(a), and begins after it if j ≤ i − Q − w(b). Every pair i, j is
/// in one of the two cases exactly if P + Q + w(a) + w(b) ≤ 1. If it is not, nothing orders some pair, and a run exists
/// in which both states hold: forward motion needs no more than what its own waits ask for.
///
/// Only arrows that hold in both modes count: an arrow of one mode can be got round by changing to the other.
pub fn separated(line: &Line, conflict: &Conflict) -> Result<String, String> {
    match gaps(line, conflict, Arrows::InBothModes) {
        Ok(()) => Ok("forward motion keeps them apart in every mode; for the rest see below".to_owned()),
        Err(why) => {
            let only_auto = gaps(line, conflict, Arrows::InAuto).is_ok();
            let hint = if only_auto { "; arrows of auto alone would, and manual gets round them" } else { "" };
            Err(format!("forward motion can reach it: {why}{hint}"))
        }
    }
}

fn gaps(line: &Line, Conflict { a, b, .. }: &Conflict, arrows: Arrows) -> Result<(), String> {
    let chart = Chart::of(line, arrows);
    let crosses = |span: &Span| u32::from(span.until < span.from);
    let lag = |before: &Span, after: &Span| {
        let (from, to) = ((before.station, before.until), (after.station, after.from));
        chart.least_lag(from, to, 1).ok_or_else(|| {
            format!("nothing in both modes makes `{}` wait for `{}`", full_name(line, to), full_name(line, from))
        })
    };
    let (there, back) = (lag(a, b)?, lag(b, a)?);
    let sum = there + back + crosses(a) + crosses(b);
    if sum <= 1 {
        return Ok(());
    }
    Err(format!(
        "`{}` and `{}` wait for each other's ends, but for those of too early a cycle ({sum} in all, 1 at most)",
        full_name(line, (a.station, a.from)),
        full_name(line, (b.station, b.from))
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_line::{TransferLine, parse};

    fn shipped(machines: usize) -> Line {
        parse("line.toml", &TransferLine { machines, time_scale: 1.0 }.text()).expect("the shipped line is sound").line
    }

    #[test]
    fn the_shipped_line_holds_with_any_number_of_machines() {
        for machines in [1, 2, 31] {
            let line = shipped(machines);
            home_is_consistent(&line).unwrap();
            assert!(every_circuit_has_a_token(&line).unwrap().contains("no station can run away"));
            for conflict in &line.conflicts {
                separated(&line, conflict).unwrap();
            }
        }
    }

    #[test]
    fn every_arrow_in_both_modes_is_needed_to_keep_the_conflicts_apart() {
        for index in 0..4 {
            let mut line = shipped(1);
            line.arrows.remove(index);
            let found: Vec<_> = line.conflicts.iter().filter_map(|conflict| separated(&line, conflict).err()).collect();
            assert!(!found.is_empty(), "without arrow {index} a conflict must be found");
            assert!(found[0].contains("wait for"), "{}", found[0]);
        }
    }

    #[test]
    fn an_arrow_for_auto_alone_does_not_separate() {
        let mut line = shipped(1);
        line.arrows[0].manual = false;
        let why = separated(&line, &line.conflicts[0]).unwrap_err();
        assert!(why.contains("manual gets round them"), "{why}");
    }

    #[test]
    fn a_lag_more_lets_the_states_overlap() {
        let mut line = shipped(1);
        line.arrows[1].lag = 1;
        let why = separated(&line, &line.conflicts[0]).unwrap_err();
        assert!(why.contains("too early a cycle (2 in all"), "{why}");
    }

    #[test]
    fn a_circuit_without_lag_is_found_and_named() {
        let mut line = shipped(1);
        line.arrows[3].lag = 0;
        let why = every_circuit_has_a_token(&line).unwrap_err();
        assert!(why.contains("clamp_1: return clamp") && why.contains("mill_1: reset main slide"), "{why}");
        let names: Vec<&str> = why.split_once(": ").unwrap().1.split(" → ").collect();
        assert_eq!(names.first(), names.last(), "{why}");
    }

    #[test]
    fn a_home_that_needs_what_is_not_done_is_found() {
        let mut line = shipped(1);
        // Standing at home, the clamp would already have needed this cycle's mill.
        line.arrows[3].lag = 0;
        let why = home_is_consistent(&line).unwrap_err();
        assert!(why.contains("`clamp_1: return clamp` counts as done"), "{why}");
    }
}
