//! Stretches in which two stations are in one another's way, the arrows that keep them apart, and more arrows.
//!
//! Let `b` begin when `a` of P cycles before has ended, and `a` when `b` of Q cycles before has. They exclude each
//! other if P + Q and the number of stretches that cross a cycle's boundary come to 1. What is drawn must let the line
//! go on, and hold while it stands at home: what does not is taken back, and tried again with other stretches.

use linewright_line::{Arrow, Conflict, Line, OpId, StateSpan, Station, StationId};

use super::{LineShape, Random};

/// Number of attempts to find stretches of two stations that go together with everything drawn before.
const TRIES: usize = 20;

type ArrowEnd = (StationId, OpId);

pub(super) fn draw(line: &mut Line, shape: &LineShape, random: &mut Random) {
    let count = line.stations.len();
    for station in 1..count {
        try_to_keep_apart(line, (station - 1, station), shape, random);
    }
    if count < 2 {
        return;
    }
    for _ in 0..shape.more_conflicts {
        let pair = two(count, random);
        try_to_keep_apart(line, pair, shape, random);
    }
    for _ in 0..shape.more_arrows {
        let (from, to) = two(count, random);
        let (from, to) = (any_end(line, from, random), any_end(line, to, random));
        let (auto, manual) = *random.pick(&[(true, true), (true, false), (false, true)]);
        add_if_fits(line, &[Arrow { from, to, lag: random.below(3) as u32, auto, manual }]);
    }
}

/// Two stations, near each other: they share a room.
fn two(count: usize, random: &mut Random) -> (usize, usize) {
    let first = random.below(count);
    let near = (first + 1 + random.below(3.min(count - 1))) % count;
    if random.chance(50) { (first, near) } else { (near, first) }
}

fn any_end(line: &Line, station: usize, random: &mut Random) -> ArrowEnd {
    let count = line.stations[station].operations.len();
    (StationId::at(station), OpId::at(random.below(count)))
}

fn try_to_keep_apart(line: &mut Line, pair: (usize, usize), shape: &LineShape, random: &mut Random) {
    for _ in 0..TRIES {
        let (a, b) = (stretch(line, pair.0, random), stretch(line, pair.1, random));
        let crossing = usize::from(a.until < a.from) + usize::from(b.until < b.from);
        let Some(left) = 1usize.checked_sub(crossing) else { continue };
        let there = random.below(left + 1);
        let mut arrows = both_ways(line, &a, &b, there as u32, shape, random);
        arrows.extend(both_ways(line, &b, &a, (left - there) as u32, shape, random));
        if add_if_fits(line, &arrows) {
            let name = |span: &StateSpan| &line.station(span.station).name;
            let why = format!("{} and {} meet ({})", name(&a), name(&b), line.conflicts.len() + 1);
            line.conflicts.push(Conflict { why, a, b });
            return;
        }
    }
}

/// Any stretch of the cycle, up to all of it. Within a group it begins and ends with one and the same operation.
fn stretch(line: &Line, number: usize, random: &mut Random) -> StateSpan {
    let station = &line.stations[number];
    let steps = &station.steps;
    let first = random.below(steps.len());
    // Short ones are as likely as long ones.
    let length = random.below(steps.len());
    let last = (first + random.below(length + 1)) % steps.len();
    let from = *random.pick(&steps[first]);
    let until = if first == last { from } else { *random.pick(&steps[last]) };
    StateSpan { station: StationId::at(number), from, until }
}

/// The arrow for `after` to wait for the end of `before`; or one for auto, and one for manual from there or from a
/// later operation of the cycle.
fn both_ways(
    line: &Line,
    before: &StateSpan,
    after: &StateSpan,
    lag: u32,
    shape: &LineShape,
    random: &mut Random,
) -> Vec<Arrow> {
    let to = (after.station, after.from);
    let arrow = |from: OpId, auto, manual| Arrow { from: (before.station, from), to, lag, auto, manual };
    if !random.chance(shape.divided) {
        return vec![arrow(before.until, true, true)];
    }
    let station = line.station(before.station);
    let later: Vec<OpId> = station
        .op_ids()
        .filter(|&op| op == before.until || station.step_of(op) > station.step_of(before.until))
        .collect();
    vec![arrow(before.until, true, false), arrow(*random.pick(&later), false, true)]
}

fn add_if_fits(line: &mut Line, arrows: &[Arrow]) -> bool {
    let fits = |line: &Line, new: &Arrow| is_new(line, new) && holds_at_home(line, new);
    let known = line.arrows.len();
    for arrow in arrows {
        if !fits(line, arrow) {
            line.arrows.truncate(known);
            return false;
        }
        line.arrows.push(*arrow);
    }
    let goes_on = goes_on(line);
    if !goes_on {
        line.arrows.truncate(known);
    }
    goes_on
}

fn is_new(line: &Line, new: &Arrow) -> bool {
    let same = |old: &&Arrow| (old.from, old.to) == (new.from, new.to);
    !line.arrows.iter().filter(same).any(|old| (old.auto && new.auto) || (old.manual && new.manual))
}

/// Operations counted as done at home needed none that are not.
fn holds_at_home(line: &Line, arrow: &Arrow) -> bool {
    let count = |(station, op): ArrowEnd| {
        let station: &Station = line.station(station);
        station.home_count(op, station.initial_round())
    };
    count(arrow.to) - (arrow.lag as i32) <= count(arrow.from)
}

/// Whether all operations of a cycle can be put in an order, with the arrows of all modes. Operations of one step
/// start together, when all of them may.
fn goes_on(line: &Line) -> bool {
    let mut first = Vec::with_capacity(line.stations.len());
    let mut steps = 0;
    for station in &line.stations {
        first.push(steps);
        steps += station.steps.len();
    }
    let step_of = |(station, op): ArrowEnd| first[station.index()] + line.station(station).step_of(op);
    let mut followers: Vec<Vec<usize>> = vec![Vec::new(); steps];
    for arrow in line.arrows.iter().filter(|arrow| arrow.lag == 0) {
        followers[step_of(arrow.from)].push(step_of(arrow.to));
    }
    for (station, &first) in line.stations.iter().zip(&first) {
        (first + 1..first + station.steps.len()).for_each(|step| followers[step - 1].push(step));
    }
    let mut waits = vec![0; steps];
    followers.iter().flatten().for_each(|&to| waits[to] += 1);
    let mut ready: Vec<usize> = (0..steps).filter(|&step| waits[step] == 0).collect();
    let mut done = 0;
    while let Some(step) = ready.pop() {
        done += 1;
        for &to in &followers[step] {
            waits[to] -= 1;
            if waits[to] == 0 {
                ready.push(to);
            }
        }
    }
    done == steps
}
