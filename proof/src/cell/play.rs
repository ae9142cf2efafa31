//! Number of parts that a group can take: sound, stuck, without an end, or too many states.

use linewright_nets::Marking;
use linewright_nets::explicit::{
    ExplorationLimit, ExplorationLimits, ExplorationUndecided, NetFacts, WitnessMarking, decide, find, find_marking,
};

use super::group::ResourceGroup;

/// Result for a group.
#[derive(Debug)]
pub(super) struct GroupSearch {
    /// With up to so many parts at a time, everything was seen and nothing is wrong.
    pub sound: u32,
    /// Of the largest sound search; where something is wrong, of the smallest in which it is.
    pub size: Size,
    /// By transition, whether it was seen to fire.
    pub fires: Vec<bool>,
    /// Result with one part more.
    pub end: Excess,
}

/// Size of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Size {
    pub parts: u32,
    pub states: u64,
    pub arcs: u64,
    pub bytes: usize,
}

/// Result with more parts than are sound.
#[derive(Debug)]
pub(super) enum Excess {
    /// No more are let in, or none fit.
    Sound,
    /// Parts stay where they are for good; with a shortest way there.
    Stuck(WitnessMarking),
    /// Something can always move, and yet the cell cannot become empty from here; with a shortest way there.
    Endless(WitnessMarking),
    /// As one of the two, but to find a way there took more than was allowed.
    Wrong(ExplorationUndecided),
    /// It could not be seen to the end.
    Limit(ExplorationUndecided),
}

/// The smallest number of parts that is not proved sound, and why.
enum Bad {
    Wrong(Marking, Size),
    Limit(ExplorationUndecided),
}

/// Tries numbers of parts upwards, in growing steps, and between the last two until they are neighbours.
pub(super) fn play(group: &ResourceGroup, wip_max: u32, limits: &ExplorationLimits) -> GroupSearch {
    let mut play = GroupSearch {
        sound: 0,
        size: Size::default(),
        fires: vec![false; group.transitions.len()],
        end: Excess::Sound,
    };
    let mut bad: Option<(u32, Bad)> = None;
    let mut parts = 1;
    loop {
        match once(group, parts, limits) {
            Ok(facts) => {
                play.fires.iter_mut().zip(&facts.fires).for_each(|(seen, &fires)| *seen |= fires);
                let size = Size { parts, states: facts.states, arcs: facts.arcs, bytes: facts.bytes };
                match facts.no_return {
                    Some(marking) => bad = Some((parts, Bad::Wrong(marking, size))),
                    None => {
                        let all_fit = facts.bounds[group.inside().index()] >= parts;
                        (play.sound, play.size) = (if all_fit { parts } else { wip_max }, size);
                    }
                }
            }
            Err(why) => bad = Some((parts, Bad::Limit(why))),
        }
        parts = match &bad {
            Some((least, _)) if *least > play.sound + 1 => play.sound + (least - play.sound) / 2,
            Some(_) => break,
            None if play.sound >= wip_max => break,
            None => (play.sound + play.sound / 2 + 1).min(wip_max),
        };
    }
    play.end = match bad {
        None => Excess::Sound,
        Some((_, Bad::Limit(why))) => Excess::Limit(why),
        Some((_, Bad::Wrong(marking, size))) => {
            play.size = size;
            wrong(group, size.parts, &marking, limits)
        }
    };
    play
}

fn once(group: &ResourceGroup, parts: u32, limits: &ExplorationLimits) -> Result<NetFacts, ExplorationUndecided> {
    match group.net(parts) {
        Some(net) => decide(&net, limits),
        None => Err(no_net(limits)),
    }
}

/// A net of that size could not be made.
fn no_net(limits: &ExplorationLimits) -> ExplorationUndecided {
    ExplorationUndecided { states: 0, cause: ExplorationLimit::States { limit: limits.states } }
}

/// A shortest way to where parts are stuck; or, if they never are, to where there is no way back from.
fn wrong(group: &ResourceGroup, parts: u32, no_return: &Marking, limits: &ExplorationLimits) -> Excess {
    let Some(net) = group.net(parts) else { return Excess::Wrong(no_net(limits)) };
    match find(&net, limits, |view| group.is_stuck(view)) {
        Ok(Some(found)) => Excess::Stuck(found),
        Ok(None) => match find_marking(&net, limits, no_return) {
            Ok(Some(found)) => Excess::Endless(found),
            Ok(None) => Excess::Endless(WitnessMarking { marking: no_return.clone(), path: Vec::new() }),
            Err(why) => Excess::Wrong(why),
        },
        Err(why) => Excess::Wrong(why),
    }
}
