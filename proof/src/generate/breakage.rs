//! Deliberate mistakes, one at a time, that a checker must find.
//!
//! Not every mistake does harm: an arrow may be reversed where another has the same effect, a conflict drawn longer
//! where there is room. Whether it does is decided by the two ways of judging a line, and they must agree.

use linewright_line::net::{ControlMode, StationNet, StationTransition};
use linewright_line::{Line, OpId, OperationModule, StateSpan, StationId};

/// One mistake in a line. Numbers are places in [`Line::arrows`] and [`Line::conflicts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breakage {
    /// An arrow points the other way.
    Reversed(usize),
    /// An arrow reaches one cycle further back.
    LagMore(usize),
    /// An arrow reaches one cycle less far back.
    LagLess(usize),
    /// An arrow is forgotten.
    Removed(usize),
    /// An arrow does not hold in manual mode.
    AutoOnly(usize),
    /// An arrow does not hold in auto mode.
    ManualOnly(usize),
    /// The first state of a conflict begins a step before its arrows have it.
    Earlier(usize),
    /// The first state of a conflict lasts a step longer than its arrows have it.
    Longer(usize),
    /// Home is where the next step ends.
    HomeMoved(StationId),
}

/// Every mistake that can be made in a line.
pub fn breakages(line: &Line) -> Vec<Breakage> {
    use Breakage::{AutoOnly, Earlier, HomeMoved, LagLess, LagMore, Longer, ManualOnly, Removed, Reversed};
    let arrows = (0..line.arrows.len())
        .flat_map(|n| [Reversed(n), LagMore(n), LagLess(n), Removed(n), AutoOnly(n), ManualOnly(n)]);
    let conflicts = (0..line.conflicts.len()).flat_map(|n| [Earlier(n), Longer(n)]);
    let all = arrows.chain(conflicts).chain(line.station_ids().map(HomeMoved));
    all.filter(|&breakage| break_it(line, breakage).is_some()).collect()
}

/// The line with this mistake; `None` where it cannot be made.
///
/// The result is a line that compiles. The parser may refuse it already.
pub fn break_it(line: &Line, breakage: Breakage) -> Option<Line> {
    let mut broken = line.clone();
    match breakage {
        Breakage::Reversed(n) => {
            let arrow = broken.arrows.get_mut(n)?;
            (arrow.from, arrow.to) = (arrow.to, arrow.from);
        }
        Breakage::LagMore(n) => broken.arrows.get_mut(n)?.lag += 1,
        Breakage::LagLess(n) => {
            let arrow = broken.arrows.get_mut(n)?;
            arrow.lag = arrow.lag.checked_sub(1)?;
        }
        Breakage::Removed(n) => {
            broken.arrows.get(n)?;
            broken.arrows.remove(n);
        }
        Breakage::AutoOnly(n) => {
            let arrow = broken.arrows.get_mut(n).filter(|arrow| arrow.auto && arrow.manual)?;
            arrow.manual = false;
        }
        Breakage::ManualOnly(n) => {
            let arrow = broken.arrows.get_mut(n).filter(|arrow| arrow.auto && arrow.manual)?;
            arrow.auto = false;
        }
        Breakage::Earlier(n) => {
            let span = &mut broken.conflicts.get_mut(n)?.a;
            span.from = step_from(line, span, span.from, line.station(span.station).steps.len() - 1)?;
        }
        Breakage::Longer(n) => {
            let span = &mut broken.conflicts.get_mut(n)?.a;
            span.until = step_from(line, span, span.until, 1)?;
        }
        Breakage::HomeMoved(station) => move_home(&mut broken, station)?,
    }
    Some(broken)
}

/// The first operation so many steps after that of `op`, unless the stretch is the whole cycle already.
fn step_from(line: &Line, span: &StateSpan, op: OpId, steps: usize) -> Option<OpId> {
    let station = line.station(span.station);
    let count = station.steps.len();
    let (from, until) = (station.step_of(span.from), station.step_of(span.until));
    if (until + 1) % count == from {
        return None;
    }
    station.steps[(station.step_of(op) + steps) % count].first().copied()
}

/// Home is one step later: where that is one reversible operation, and no recovery path was meant to end at home.
fn move_home(line: &mut Line, id: StationId) -> Option<()> {
    let station = line.stations.get_mut(id.index())?;
    let reversible = |op: &linewright_line::Operation| matches!(op.module, OperationModule::Reversible { .. });
    if !station.operations.iter().all(reversible) {
        return None;
    }
    let next = (station.step_of(station.home) + 1) % station.steps.len();
    let &[home] = &station.steps[next][..] else { return None };
    station.home = home;
    // The axis stands there at home now.
    let motion = station.operations[home.index()].motion;
    station.axes[motion.axis.index()].home = motion.to;
    Some(())
}

/// A station's transitions with one condition forgotten: the `nth` literal of all of them, counted through transitions,
/// modes and terms. `None` when there are not so many.
pub fn without_literal(net: &StationNet, nth: usize) -> Option<Vec<StationTransition>> {
    let mut transitions = net.transitions().to_vec();
    let mut left = nth;
    for transition in &mut transitions {
        for mode in ControlMode::ALL {
            for term in &mut transition.conditions[mode as usize] {
                if left < term.len() {
                    term.remove(left);
                    return Some(transitions);
                }
                left -= term.len();
            }
        }
    }
    None
}
