//! Counterexamples: a way to play the net that shows why something does not hold.

use linewright_nets::certificate::{Certificate, Evidence, RepeatedFiring};
use linewright_nets::explicit::{ExplorationLimits, find, find_marking};
use linewright_nets::{Marking, Net, TransitionId};
use serde::Serialize;

use super::decide::Findings;

/// A way to a marking is looked for in a search of its own, if there are no more states than these.
const STATES_MAX: u64 = 4_000_000;

/// The bytes that such a search may use.
const BYTES_MAX: usize = 512 << 20;

/// The steps of a sequence that are kept; certificates may repeat a transition a billion times.
const STEPS_MAX: usize = 10_000;

/// Why a property does not hold.
#[derive(Debug, Serialize)]
pub struct ViolationPath {
    /// Violation: "deadlock", "unsafe", "not live", "not reversible", "unbounded".
    pub shows: &'static str,
    /// Its subject: the transition that is lost, the place that overflows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// The names of the transitions to fire, from the initial marking.
    pub fire: Vec<String>,
    /// For an unbounded net: what can be fired again and again after that.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub repeat: Vec<String>,
    /// The marking after `fire`: place and tokens.
    pub marking: Vec<(String, u32)>,
}

/// Paths to violations of a net.
pub fn plays(net: &Net, findings: &Findings) -> Vec<ViolationPath> {
    let mut plays = explored(net, findings);
    if plays.iter().all(|play| play.shows != "deadlock")
        && let Some(Certificate { evidence: Evidence::Deadlock(run), .. }) =
            findings.structure.deadlock_free.certificate()
    {
        plays.extend(fired(run).and_then(|path| play(net, "deadlock", None, &path)));
    }
    if plays.iter().all(|play| play.shows != "unsafe")
        && let Some(Certificate { evidence: Evidence::Overfull(run, place), .. }) =
            findings.structure.safe.certificate()
    {
        let of = Some(net.place_name(*place).to_owned());
        plays.extend(fired(run).and_then(|path| play(net, "unsafe", of, &path)));
    }
    plays.extend(grows(net, findings));
    plays
}

/// From the facts of an exploration, with ways that a second search finds.
fn explored(net: &Net, findings: &Findings) -> Vec<ViolationPath> {
    let Some(facts) = findings.facts() else { return Vec::new() };
    let limits = ExplorationLimits { states: STATES_MAX.min(facts.states), bytes: BYTES_MAX, threads: 1 };
    let way_to = |marking: &Marking| {
        let found = (facts.states <= STATES_MAX).then(|| find_marking(net, &limits, marking));
        found.and_then(|found| found.ok().flatten()).map(|found| found.path)
    };
    let mut plays = Vec::new();
    if let Some(found) = &facts.deadlock {
        plays.extend(play(net, "deadlock", None, &found.path));
    }
    if !facts.is_safe() && facts.states <= STATES_MAX {
        let found = find(net, &limits, |view| net.places().any(|p| view.tokens(p) > 1));
        if let Ok(Some(found)) = found {
            let place = net.places().find(|&p| found.marking.tokens(p) > 1);
            plays.extend(play(net, "unsafe", place.map(|p| net.place_name(p).to_owned()), &found.path));
        }
    }
    // In a deadlock everything is lost and nothing leads back: it shows both.
    if facts.deadlock.is_none() {
        let lost = net.transitions().zip(&facts.lost).find_map(|(t, lost)| Some((t, lost.as_ref()?)));
        if let Some((t, marking)) = lost {
            let of = Some(net.transition_name(t).to_owned());
            plays.extend(way_to(marking).and_then(|path| play(net, "not live", of, &path)));
        }
        if let Some(marking) = &facts.no_return {
            plays.extend(way_to(marking).and_then(|path| play(net, "not reversible", None, &path)));
        }
    }
    plays
}

/// Path by which an unbounded net grows.
fn grows(net: &Net, findings: &Findings) -> Option<ViolationPath> {
    let pump = findings.coverability().and_then(|graph| graph.is_bounded().err());
    let (prefix, cycle, place) = match (pump, findings.structure.bounded.certificate()) {
        (Some(pump), _) => (pump.prefix.clone(), pump.cycle.clone(), *pump.grows.first()?),
        (None, Some(Certificate { evidence: Evidence::Pump(pump), .. })) => {
            (fired(&pump.prefix)?, fired(&pump.cycle)?, pump.place)
        }
        _ => return None,
    };
    let play = play(net, "unbounded", Some(net.place_name(place).to_owned()), &prefix)?;
    Some(ViolationPath { repeat: names(net, &cycle), ..play })
}

/// A sequence written out; none if it is too long to be read.
fn fired(runs: &[RepeatedFiring]) -> Option<Vec<TransitionId>> {
    let steps: u64 = runs.iter().map(|run| run.times).fold(0, u64::saturating_add);
    let each = |run: &RepeatedFiring| std::iter::repeat_n(run.transition, run.times as usize);
    (steps <= STEPS_MAX as u64).then(|| runs.iter().flat_map(each).collect())
}

/// Plays a sequence, so that what is shown is what happens; none if it cannot be played.
fn play(net: &Net, shows: &'static str, of: Option<String>, path: &[TransitionId]) -> Option<ViolationPath> {
    let mut marking = net.initial_marking();
    path.iter().try_for_each(|&t| net.fire(&mut marking, t)).ok()?;
    let marked = marking.marked().map(|p| (net.place_name(p).to_owned(), marking.tokens(p))).collect();
    Some(ViolationPath { shows, of, fire: names(net, path), repeat: Vec::new(), marking: marked })
}

fn names(net: &Net, path: &[TransitionId]) -> Vec<String> {
    path.iter().map(|&t| net.transition_name(t).to_owned()).collect()
}
