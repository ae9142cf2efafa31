//! Whether the arrows keep the two states of a conflict apart in forward motion: least sums of lags on the chart.
//!
//! The proof here is of forward motion, in every mode and across changes of mode, of a line whose home is consistent
//! and whose circuits have tokens. That it is not circumvented by taking something back does not follow from the chart,
//! but from the rule that a count is withdrawn only when nothing has started on it. That rule goes along the arrows, so
//! it guards an order that follows from arrows and the order in a station. It does not guard one that only follows from
//! operations starting side by side: of these, each is taken back alone, and the one that waits for an arrow may be
//! undone while its neighbour is not. So such waits count for the line's going on, but not for keeping a conflict apart
//! ([`Gap::TakenBack`]).
//!
//! **What must have come before.** B, in cycle c, has waited for A of cycle c − k if some edge into B leads back to it,
//! of those that were observed. A start observes the arrows of one mode, auto's or manual's, and any start may be in
//! either, since modes may change between any two. (Hand mode observes both: it waits for no less.) So B needs A with
//! lag k iff it does so in each of the two modes: D(B) = max over the two modes of the min over that mode's edges C → B
//! of D(C) + lag, and D(A) = 0. Every operation that can avoid an event avoids it by one and the same choice of its
//! mode, whatever the others choose: so the least solution is exactly what cannot be avoided. It is found in the order
//! of D, as least ways are, since max and min only grow with what they are given.
//!
//! **Separated iff every pair of cycles is ordered.** Let `b` begin only after `a` of P cycles before has ended: P is
//! D(b.from) from `a.until`, and Q the same the other way round. The i-th `a` ends in cycle i, or in the next one if it
//! crosses the boundary (w = 1). So it is over before the j-th `b` begins if i ≤ j − P − w(a), and begins after it if
//! j ≤ i − Q − w(b). Every pair i, j is in one of the two cases exactly if P + Q + w(a) + w(b) ≤ 1.
//! * If so, no two ever hold together: while `a` holds in its cycle i and `b` in its j, neither had to be over before
//!   the other began. At home too: with all edges free of debt, what is counted there has come in such an order.
//! * If not, take a pair i, j that is in neither case, late enough to be beyond home; if there is one, there is one
//!   with i and j as much later as one likes. Let each operation that leads to the start of `a` in i choose its mode so
//!   as to avoid the end of `b` in j, and each that leads to that of `b` so as to avoid the end of `a`. One that leads
//!   to both has nothing to choose: were the end of `b` on a way to it, this would be on a way to the start of `b`, and
//!   close a circuit without a token. Running what is then needed, and no more, starts both and ends neither.

use std::collections::VecDeque;

use linewright_line::{Arrow, Conflict, Line, StateSpan, StationId};
use thiserror::Error;

use super::every_circuit_has_a_token;
use super::{ChartIndex, EventGraph};
use crate::parts::SubLine;
use crate::structure::full_name;

/// The most that the lags and the crossings of a separated conflict come to.
const SUM_MAX: u32 = 1;
/// Beyond every lag of interest.
const FAR: u32 = u32::MAX;

/// Waits that count.
#[derive(Clone, Copy)]
enum ConsideredWaits {
    /// Those that cannot be got round by changing the mode.
    InEveryMode,
    /// Of these, those that stay when operations side by side are taken back one by one.
    Guarded,
    /// Those of auto mode.
    InAuto,
}

/// How the two states of a conflict can come together, or why that is not proved impossible.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Gap {
    /// In forward motion, for certain.
    #[error("forward motion can reach it: {0}")]
    Forward(ChartOverlap),
    /// Forward motion keeps them apart, but only because operations side by side start together.
    #[error(
        "forward motion keeps them apart, but of operations side by side one can be taken back alone, and then {0}; an \
         arrow of its own to each of them would hold"
    )]
    TakenBack(ChartOverlap),
}

impl Gap {
    /// The arrows that its text names, by their place in the line.
    pub fn arrows(&self) -> &[usize] {
        let (Gap::Forward(overlap) | Gap::TakenBack(overlap)) = self;
        &overlap.arrows
    }
}

/// How two states come to overlap.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{text}")]
pub struct ChartOverlap {
    pub text: String,
    /// The arrows that the text names, by their place in the line.
    pub arrows: Vec<usize>,
}

/// Least lags on a chart; room to work in, kept from one question to the next.
struct Lags<'a> {
    chart: EventGraph<'a>,
    /// For each operation, number of cycles back that auto and manual make it wait, the least found so far.
    least: Vec<[u32; 2]>,
    touched: Vec<usize>,
    /// Operations by number of cycles back that they wait.
    open: [VecDeque<usize>; SUM_MAX as usize + 1],
}

impl<'a> Lags<'a> {
    fn of(line: &'a Line) -> Self {
        let chart = EventGraph::of(line);
        let least = vec![[FAR; 2]; chart.operations.len()];
        Lags { chart, least, touched: Vec::new(), open: Default::default() }
    }

    /// Number of cycles back that `to` waits for the end of `from`, if it is at most [`SUM_MAX`].
    fn least(&mut self, from: ChartIndex, to: ChartIndex, waits: ConsideredWaits) -> Option<u32> {
        let (from, to) = (self.chart.number(from), self.chart.number(to));
        for number in self.touched.drain(..) {
            self.least[number] = [FAR; 2];
        }
        self.open.iter_mut().for_each(VecDeque::clear);
        self.least[from] = [0; 2];
        self.touched.push(from);
        self.open[0].push_back(from);
        for lag in 0..=SUM_MAX {
            // First come, first served: what waits for something directly is found before the whole line is.
            while let Some(at) = self.open[lag as usize].pop_front() {
                let [auto, manual] = self.least[at];
                if auto.max(manual) < lag {
                    continue;
                }
                if at == to {
                    return Some(lag);
                }
                self.look_on(at, lag, waits);
            }
        }
        None
    }

    fn look_on(&mut self, at: usize, lag: u32, waits: ConsideredWaits) {
        for edge in &self.chart.followers[at] {
            let there = lag.saturating_add(edge.lag);
            let modes = match waits {
                ConsideredWaits::InEveryMode => [edge.auto, edge.manual],
                ConsideredWaits::Guarded => [edge.auto, edge.manual].map(|counts| counts && !edge.beside),
                ConsideredWaits::InAuto => [edge.auto; 2],
            };
            let known = &mut self.least[edge.to];
            let before = known[0].max(known[1]);
            if there >= before {
                continue;
            }
            for (known, _) in known.iter_mut().zip(modes).filter(|(_, counts)| *counts) {
                *known = there.min(*known);
            }
            self.touched.push(edge.to);
            let now = known[0].max(known[1]);
            if now < before && now <= SUM_MAX {
                self.open[now as usize].push_back(edge.to);
            }
        }
    }

    fn judge(&mut self, conflict: &Conflict) -> Result<String, Gap> {
        let Err(unguarded) = self.gaps(conflict, ConsideredWaits::Guarded) else {
            return Ok("forward motion keeps them apart in every mode; for the rest see below".to_owned());
        };
        let Err(mut overlap) = self.gaps(conflict, ConsideredWaits::InEveryMode) else {
            return Err(Gap::TakenBack(unguarded));
        };
        if self.is_separated(conflict, ConsideredWaits::InAuto) {
            let ChartOverlap { text, arrows } = &mut overlap;
            let line = self.chart.line;
            *text = match of_auto_alone(line, conflict) {
                Some(at) => {
                    *arrows = vec![at];
                    let arrow = written(line, &line.arrows[at]);
                    format!(
                        "in auto alone arrows keep them apart; manual gets round this one, which has to be without `modes`: {arrow}"
                    )
                }
                None => format!("in auto alone arrows keep them apart, and manual gets round them; {text}"),
            };
        }
        Err(Gap::Forward(overlap))
    }

    /// The arrow that separates two states of which one waits for the other already; none where neither or both do.
    fn missing(&mut self, a: &StateSpan, b: &StateSpan, waits: ConsideredWaits) -> Option<Arrow> {
        let mut ends = |before: &StateSpan, after: &StateSpan| {
            let (from, to) = ((before.station, before.until), (after.station, after.from));
            (from, to, self.least(from, to, waits))
        };
        let (from, to, known) = match (ends(a, b), ends(b, a)) {
            ((from, to, None), (.., Some(known))) | ((.., Some(known)), (from, to, None)) => (from, to, known),
            _ => return None,
        };
        let lag = SUM_MAX.checked_sub(known + crosses(a) + crosses(b))?;
        Some(Arrow { from, to, lag, auto: true, manual: true })
    }

    fn is_separated(&mut self, Conflict { a, b, .. }: &Conflict, waits: ConsideredWaits) -> bool {
        let mut lag = |before: &StateSpan, after: &StateSpan| {
            self.least((before.station, before.until), (after.station, after.from), waits)
        };
        let sum = lag(a, b).zip(lag(b, a)).map(|(there, back)| there + back + crosses(a) + crosses(b));
        sum.is_some_and(|sum| sum <= SUM_MAX)
    }

    fn gaps(&mut self, conflict: &Conflict, waits: ConsideredWaits) -> Result<(), ChartOverlap> {
        let (line, Conflict { a, b, .. }) = (self.chart.line, conflict);
        let advice = match self.missing(a, b, waits) {
            Some(arrow) => format!("; an arrow {} in both modes does", written(line, &arrow)),
            None => String::new(),
        };
        let mut lag = |before: &StateSpan, after: &StateSpan| {
            let (from, to) = ((before.station, before.until), (after.station, after.from));
            self.least(from, to, waits).ok_or_else(|| {
                let late = arrows_between(line, from.0, to.0, |arrow| arrow.from.0 == from.0 && arrow.lag > SUM_MAX);
                let swapped = swapped(line, conflict, waits);
                let (from, to) = (full_name(line, from), full_name(line, to));
                let unseen = format!("nothing in both modes makes `{to}` wait for `{from}`");
                match (late, swapped) {
                    (Some((late, arrows)), _) => ChartOverlap {
                        text: format!(
                            "an arrow makes `{to}` wait for an end of `{from}` that is too many cycles back: {late}; a \
                             lag of {SUM_MAX} is the most that keeps the two apart"
                        ),
                        arrows,
                    },
                    (None, Some(at)) => {
                        let (from, to) = (line.arrows[at].from, line.arrows[at].to);
                        let (from, to) = (full_name(line, from), full_name(line, to));
                        let text = format!("{unseen}; the arrow from `{from}` to `{to}` may be the wrong way round");
                        ChartOverlap { text, arrows: vec![at] }
                    }
                    (None, None) => ChartOverlap { text: format!("{unseen}{advice}"), arrows: Vec::new() },
                }
            })
        };
        let (there, back) = (lag(a, b)?, lag(b, a)?);
        let sum = there + back + crosses(a) + crosses(b);
        if sum <= SUM_MAX {
            return Ok(());
        }
        let mut closer = Vec::new();
        for (before, after, opposite) in [(a, b, back), (b, a, there)] {
            closer.extend(self::closer(line, before, after, SUM_MAX.checked_sub(opposite + crosses(a) + crosses(b))));
        }
        Err(overlap(line, (a, back), (b, there), &closer))
    }
}

/// The arrow by which a state waits for the end of another one, this number of cycles back at most; none where operations would wait for each
/// other in a circuit then.
fn closer(line: &Line, before: &StateSpan, after: &StateSpan, lag: Option<u32>) -> Option<Arrow> {
    let (from, to) = ((before.station, before.until), (after.station, after.from));
    let arrow = Arrow { from, to, lag: lag?, auto: true, manual: true };
    let mut with = line.clone();
    with.arrows.push(arrow);
    every_circuit_has_a_token(&with).is_ok().then_some(arrow)
}

/// 1 for a state that lasts into the next cycle.
fn crosses(span: &StateSpan) -> u32 {
    u32::from(span.until < span.from)
}

/// How two states overlap that each begin only after an end of the other, each with the number of cycles back of that end.
/// `closer`: the arrows of which each would keep them apart.
fn overlap(line: &Line, (a, back): (&StateSpan, u32), (b, there): (&StateSpan, u32), closer: &[Arrow]) -> ChartOverlap {
    let waits = |state: &StateSpan, lag: u32, other: &StateSpan| {
        let cycle = match lag {
            0 => "in the same cycle".to_owned(),
            1 => "in the cycle before".to_owned(),
            lag => format!("{lag} cycles before"),
        };
        let (begins, ends) = ((state.station, state.from), (other.station, other.until));
        format!("`{}` waits for `{}` {cycle}", full_name(line, begins), full_name(line, ends))
    };
    let mut text =
        format!("{}, and {}, so both can begin before either has ended", waits(a, back, b), waits(b, there, a));
    for state in [a, b].into_iter().filter(|state| state.until < state.from) {
        let station = line.station(state.station);
        let [from, until] = [state.from, state.until].map(|op| &station.operations[op.index()].name);
        text += &format!(
            "; `{until}` comes before `{from}` in the cycle of {}, so the state lasts into the next cycle: its `from` and `until` \
             may be swapped",
            station.name
        );
    }
    if !closer.is_empty() {
        let closer: Vec<String> = closer.iter().map(|arrow| written(line, arrow)).collect();
        text += &format!("; an arrow {} in both modes keeps them apart", closer.join(" or "));
    }
    let Some((written, arrows)) = arrows_between(line, a.station, b.station, |_| true) else {
        return ChartOverlap { text, arrows: Vec::new() };
    };
    text += &format!("; an arrow may be the wrong way round: {written}");
    ChartOverlap { text, arrows }
}

/// The arrows between two stations, as they are written, with their places in the line; none where there is none of these.
fn arrows_between(
    line: &Line,
    a: StationId,
    b: StationId,
    is_meant: impl Fn(&Arrow) -> bool,
) -> Option<(String, Vec<usize>)> {
    let joins = |arrow: &Arrow| [(a, b), (b, a)].contains(&(arrow.from.0, arrow.to.0));
    let found = line.arrows.iter().enumerate().filter(|(_, arrow)| joins(arrow) && is_meant(arrow));
    let (places, texts): (Vec<usize>, Vec<String>) = found.map(|(at, arrow)| (at, written(line, arrow))).unzip();
    (!texts.is_empty()).then(|| (texts.join("; "), places))
}

/// An arrow as it is written in the description, but for its modes.
pub fn written(line: &Line, arrow: &Arrow) -> String {
    let lag = if arrow.lag == 0 { String::new() } else { format!(", lag = {}", arrow.lag) };
    format!("from = \"{}\", to = \"{}\"{lag}", full_name(line, arrow.from), full_name(line, arrow.to))
}

/// The arrows each of which separates a conflict that is not separated.
pub(super) fn missing_arrows(line: &Line) -> Vec<Arrow> {
    let mut lags = Lags::of(line);
    let open = line.conflicts.iter().filter(|of| lags.gaps(of, ConsideredWaits::Guarded).is_err()).collect::<Vec<_>>();
    open.into_iter().filter_map(|of| lags.missing(&of.a, &of.b, ConsideredWaits::Guarded)).collect()
}

/// The arrows between two stations of a part that keep its conflicts apart, and that arrows of stations outside it stand for: with them the
/// part is as ordered as the line is. Each with the place of its conflict in the part. Empty where the line does not keep them apart, or the part
/// does.
pub fn direct_arrows(line: &Line, part: &SubLine) -> Vec<(usize, Arrow)> {
    let (mut of_line, mut of_part) = (Lags::of(line), Lags::of(&part.line));
    let outside = |station: StationId| part.stations[station.index()];
    let in_line = |of: &StateSpan| StateSpan { station: outside(of.station), ..*of };
    let mut arrows = Vec::new();
    for (at, conflict) in part.line.conflicts.iter().enumerate() {
        let whole = Conflict { why: conflict.why.clone(), a: in_line(&conflict.a), b: in_line(&conflict.b) };
        if !of_line.is_separated(&whole, ConsideredWaits::Guarded) {
            continue;
        }
        for (before, after) in [(&conflict.a, &conflict.b), (&conflict.b, &conflict.a)] {
            let (from, to) = ((before.station, before.until), (after.station, after.from));
            let known = of_part.least(from, to, ConsideredWaits::Guarded).unwrap_or(FAR);
            let (from, to) = ((outside(from.0), from.1), (outside(to.0), to.1));
            let lag = of_line.least(from, to, ConsideredWaits::Guarded).filter(|lag| *lag < known);
            arrows.extend(lag.map(|lag| (at, Arrow { from, to, lag, auto: true, manual: true })));
        }
    }
    arrows
}

/// The arrow that separates a conflict when it is turned round, by its place in the line.
fn swapped(line: &Line, conflict: &Conflict, waits: ConsideredWaits) -> Option<usize> {
    separating(line, conflict, waits, |arrow| Some(round(arrow)))
}

/// The arrow for auto alone that separates a conflict when it is one for manual as well, by its place in the line.
fn of_auto_alone(line: &Line, conflict: &Conflict) -> Option<usize> {
    let in_both = |arrow: Arrow| (!arrow.manual).then_some(Arrow { manual: true, ..arrow });
    separating(line, conflict, ConsideredWaits::InEveryMode, in_both)
}

/// The arrow between the stations of a conflict that separates it when it is changed so, by its place in the line.
fn separating(
    line: &Line,
    conflict: &Conflict,
    waits: ConsideredWaits,
    change: impl Fn(Arrow) -> Option<Arrow>,
) -> Option<usize> {
    let stations = [conflict.a.station, conflict.b.station];
    let joins = |arrow: &Arrow| [arrow.from.0, arrow.to.0].iter().all(|station| stations.contains(station));
    (0..line.arrows.len()).filter(|&at| joins(&line.arrows[at])).find(|&at| {
        let Some(changed) = change(line.arrows[at]) else { return false };
        let mut with = line.clone();
        with.arrows[at] = changed;
        Lags::of(&with).is_separated(conflict, waits)
    })
}

fn round(arrow: Arrow) -> Arrow {
    Arrow { from: arrow.to, to: arrow.from, ..arrow }
}

/// The arrows that are reported as the wrong way round, as they are meant.
pub(super) fn meant_arrows(line: &Line) -> Vec<Arrow> {
    let mut lags = Lags::of(line);
    let open: Vec<_> =
        line.conflicts.iter().filter(|of| !lags.is_separated(of, ConsideredWaits::InEveryMode)).collect();
    let swapped = open.into_iter().filter_map(|of| swapped(line, of, ConsideredWaits::InEveryMode));
    swapped.map(|at| round(line.arrows[at])).collect()
}

/// Whether the two states of a conflict exclude each other in forward motion, in every mode and across changes of mode.
///
/// Where home is consistent and every circuit has a token, `Ok` and [`Gap::Forward`] are exact (see the module's proof).
pub fn separated(line: &Line, conflict: &Conflict) -> Result<String, Gap> {
    Lags::of(line).judge(conflict)
}

/// The same for each of the line's conflicts; the chart is drawn once.
pub fn all_separated(line: &Line) -> Vec<Result<String, Gap>> {
    let mut lags = Lags::of(line);
    line.conflicts.iter().map(|conflict| lags.judge(conflict)).collect()
}
