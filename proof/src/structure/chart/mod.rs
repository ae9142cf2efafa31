//! The timing bar chart as an event graph: operations, and what each waits for.
//!
//! An edge from A to B with lag k means that B starts in its cycle c only when A is done in cycle c − k: the arrows,
//! the order inside a station (lag 0), and the step from a station's last operation to its first (lag 1). Operations
//! side by side start together, when the arrows into all of them hold: an arrow into one is an edge to each. The chart
//! is a marked graph, with an operation for each transition and an edge for each place; at home an edge holds as many
//! tokens as starts it already allows. This is forward motion alone, without faults, and without operations taken back.
//!
//! **Tokens.** Let x(A) be the cycles that A counts as done, and y(B) those that B has started; y(B) is x(B), or one
//! more while B moves. B may start once more when x(A) ≥ y(B) + 1 − k for each edge into it. So an edge carries
//! m = x(A) − y(B) + k tokens, a start takes one from each edge into B, and completion gives one to each edge out of
//! it. Neither makes m negative: if home is consistent, m ≥ 0 for ever. On a circuit the x and y cancel but for
//! operations under way, so that its tokens and the operations moving on it come to the sum of its lags, always.
//!
//! **Live iff every circuit has a token**, where home is consistent. If the lags of a circuit come to 0, nothing on it
//! can ever start: each edge of it is empty and stays so. If on the other hand none do, take B in cycle c. What that
//! needs and is not done is the end of some A in cycle c − k, and so on. Cycles never grow on the way back, and below
//! those counted at home everything is done; so if this never ended it would come to an operation again in the same
//! cycle, round a circuit whose lags are 0. It ends, with something that may start at once. Motions end if nothing
//! fails, so by running what is needed in that order every operation comes to every cycle, from every state.
//!
//! Arrows of all modes count for this. A line that is only ever in auto goes round a circuit that an arrow of manual
//! alone closes; but a hand mode observes both, and it would stand still.

mod ahead;
mod separated;

use linewright_line::{Line, OpId, StationId};

pub use ahead::{RunAhead, run_ahead};
pub use separated::{ChartOverlap, Gap, all_separated, direct_arrows, separated, written};

use super::full_name;

type ChartIndex = (StationId, OpId);

/// A wait, with its lag and modes.
struct ChartEdge {
    to: usize,
    lag: u32,
    /// Waited for in auto mode.
    auto: bool,
    /// Waited for in manual mode.
    manual: bool,
    /// The arrow leads into an operation beside this one.
    beside: bool,
}

/// Operations numbered through all stations, and for each what waits for it.
struct EventGraph<'a> {
    line: &'a Line,
    operations: Vec<ChartIndex>,
    /// The number of a station's first operation.
    first: Vec<usize>,
    followers: Vec<Vec<ChartEdge>>,
}

impl<'a> EventGraph<'a> {
    fn of(line: &'a Line) -> Self {
        let operations: Vec<ChartIndex> =
            line.station_ids().flat_map(|id| line.station(id).op_ids().map(move |op| (id, op))).collect();
        let mut first = Vec::with_capacity(line.stations.len());
        let mut count = 0;
        for station in &line.stations {
            first.push(count);
            count += station.operations.len();
        }
        let followers = operations.iter().map(|_| Vec::new()).collect();
        let mut chart = EventGraph { line, operations, first, followers };
        chart.add_cycles();
        for arrow in line.arrows.iter().filter(|arrow| arrow.auto || arrow.manual) {
            let station = line.station(arrow.to.0);
            for &op in &station.steps[station.step_of(arrow.to.1)] {
                let (auto, manual, beside) = (arrow.auto, arrow.manual, op != arrow.to.1);
                let to = chart.number((arrow.to.0, op));
                chart.add(arrow.from, ChartEdge { to, lag: arrow.lag, auto, manual, beside });
            }
        }
        chart
    }

    fn number(&self, (station, op): ChartIndex) -> usize {
        self.first[station.index()] + op.index()
    }

    fn add(&mut self, from: ChartIndex, edge: ChartEdge) {
        let from = self.number(from);
        self.followers[from].push(edge);
    }

    fn add_cycles(&mut self) {
        for id in self.line.station_ids() {
            let steps = &self.line.station(id).steps;
            for (index, step) in steps.iter().enumerate() {
                let next = (index + 1) % steps.len();
                for &from in step {
                    for &to in &steps[next] {
                        let (to, lag) = (self.number((id, to)), u32::from(next == 0));
                        self.add((id, from), ChartEdge { to, lag, auto: true, manual: true, beside: false });
                    }
                }
            }
        }
    }

    fn edges(&self) -> impl Iterator<Item = (usize, &ChartEdge)> {
        self.followers.iter().enumerate().flat_map(|(from, edges)| edges.iter().map(move |edge| (from, edge)))
    }

    /// The tokens of an edge while every station stands at home.
    fn tokens_at_home(&self, from: usize, edge: &ChartEdge) -> i64 {
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
}

/// Operations counted as done at home needed none that are not: no edge is in debt.
pub fn home_is_consistent(line: &Line) -> Result<String, String> {
    let chart = EventGraph::of(line);
    match chart.edges().find(|(from, edge)| chart.tokens_at_home(*from, edge) < 0) {
        None => Ok("all stations can be at home together".to_owned()),
        Some((from, edge)) => Err(format!(
            "at home `{}` counts as done, though it waits for `{}`, which does not",
            chart.name(edge.to),
            chart.name(from)
        )),
    }
}

/// The operation causality condition: every circuit carries a token, so the event graph is live (see the module's
/// proof).
pub fn every_circuit_has_a_token(line: &Line) -> Result<String, String> {
    let chart = EventGraph::of(line);
    if let Some(circuit) = circuit_without_token(&chart) {
        let names: Vec<String> = circuit.iter().map(|&number| chart.name(number)).collect();
        return Err(format!("each of these waits for the one before it: {}", names.join(" → ")));
    }
    Ok(format!(
        "{} operations, {} waits, every circuit of them has a token",
        chart.operations.len(),
        chart.edges().count()
    ))
}

/// A circuit of edges without lag, if there is one; closed by naming its first operation again.
///
/// Lags and not the tokens at home: on a circuit their sums are the same, and lags exist where home is inconsistent.
fn circuit_without_token(chart: &EventGraph<'_>) -> Option<Vec<usize>> {
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
    // An operation that still waits does so for another that waits: going back from one of them must come round.
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
