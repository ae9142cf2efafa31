//! Choice of the analyses, and their order.
//!
//! Nothing here reads a clock: how far a search goes depends on the net and the limits alone, so that the answer to the
//! same question is always the same.

use linewright_nets::certificate::{NetProperty, StructuralVerdict, check, decide_by_structure};
use linewright_nets::coverability::{self, Coverability, coverability};
use linewright_nets::explicit::{self, ExplorationLimits, NetFacts};
use linewright_nets::semiflows::{self, Semiflows, place_semiflows, transition_semiflows};
use linewright_nets::{Net, PlaceId, TransitionId};

/// States explored first when it is unknown whether they are finite.
const STATES_BEFORE_COVERABILITY: u64 = 1_000_000;

/// Labels of a coverability graph that are tried before anything else where there is reason to.
const LABELS_BEFORE_EXPLORATION: usize = 20_000;

/// States explored only to count them, when all else is decided and there may be any number.
const STATES_TO_COUNT: u64 = 500_000;

/// Result of each analysis. One that was not run is absent.
pub struct Findings {
    /// Result of structure; its certificates have been checked.
    pub structure: StructuralVerdict,
    /// Certificates that the checker did not accept, in words: their claims count for nothing.
    pub rejected: Vec<(NetProperty, String)>,
    /// The conserved sums.
    pub place_flows: Result<Semiflows<PlaceId>, semiflows::SemiflowsUndecided>,
    /// The repetitions.
    pub transition_flows: Result<Semiflows<TransitionId>, semiflows::SemiflowsUndecided>,
    /// The markings played out.
    pub explored: Option<Result<NetFacts, explicit::ExplorationUndecided>>,
    /// The exploration was for the count alone, and kept short.
    pub is_short: bool,
    /// The coverability graph.
    pub covered: Option<Result<Coverability, coverability::CoverabilityUndecided>>,
    /// Properties on which two analyses disagree; neither result is used.
    pub contradiction: Option<String>,
}

impl Findings {
    /// Answer of structure on a property, if it has one and the checker agrees.
    pub fn by_structure(&self, property: NetProperty) -> Option<bool> {
        let is_rejected = self.rejected.iter().any(|(rejected, _)| *rejected == property);
        self.structure.answer(property).holds().filter(|_| !is_rejected)
    }

    /// Facts on the markings, if they have been explored.
    pub fn facts(&self) -> Option<&NetFacts> {
        self.explored.as_ref()?.as_ref().ok()
    }

    /// The coverability graph, if there is one.
    pub fn coverability(&self) -> Option<&Coverability> {
        self.covered.as_ref()?.as_ref().ok()
    }

    /// Answer of exploration on a property.
    pub fn by_exploration(&self, property: NetProperty) -> Option<bool> {
        let facts = self.facts()?;
        Some(match property {
            NetProperty::DeadlockFree => facts.deadlocks == 0,
            NetProperty::Live => facts.is_live(),
            NetProperty::Bounded => true,
            NetProperty::Safe => facts.is_safe(),
            NetProperty::Reversible => facts.is_reversible(),
        })
    }

    /// Answer of the coverability graph on a property.
    pub fn by_coverability(&self, net: &Net, property: NetProperty) -> Option<bool> {
        let graph = self.coverability()?;
        match property {
            NetProperty::Bounded => Some(graph.is_bounded().is_ok()),
            NetProperty::Safe => Some(net.places().all(|p| graph.bound_of(p).is_some_and(|bound| bound <= 1))),
            // A transition that never fires is not live; the graph decides no more.
            NetProperty::Live if !graph.dead_transitions().is_empty() => Some(false),
            NetProperty::Live | NetProperty::DeadlockFree | NetProperty::Reversible => None,
        }
    }
}

/// Decides what can be decided within the limits. `insists`: whether the user gave them: then they are used up.
pub fn decide(net: &Net, limits: &ExplorationLimits, insists: bool) -> Findings {
    let structure = decide_by_structure(net);
    let rejected = structure.certificates().filter_map(|certificate| {
        check(net, certificate).err().map(|rejected| (certificate.property, rejected.to_string()))
    });
    let mut findings = Findings {
        rejected: rejected.collect(),
        structure,
        place_flows: place_semiflows(net, &semiflows::SemiflowLimits::default()),
        transition_flows: transition_semiflows(net, &semiflows::SemiflowLimits::default()),
        explored: None,
        is_short: false,
        covered: None,
        contradiction: None,
    };
    match findings.by_structure(NetProperty::Bounded) {
        // There is no end to its markings.
        Some(false) => findings.covered = Some(coverability(net, &coverability::CoverabilityLimits::default())),
        Some(true) => explore_bounded(net, limits, insists, &mut findings),
        None => explore_or_cover(net, limits, &mut findings),
    }
    findings.contradiction = contradiction(net, &findings);
    findings
}

fn explore_bounded(net: &Net, limits: &ExplorationLimits, insists: bool, findings: &mut Findings) {
    let all_known = NetProperty::ALL.into_iter().all(|property| findings.by_structure(property).is_some());
    let fits = possible_markings_log2(net, findings) <= ((limits.bytes as f64) * 8.0).log2();
    findings.is_short = all_known && !fits && !insists;
    let states = if findings.is_short { limits.states.min(STATES_TO_COUNT) } else { limits.states };
    findings.explored = Some(explicit::decide(net, &ExplorationLimits { states, ..*limits }));
}

fn explore_or_cover(net: &Net, limits: &ExplorationLimits, findings: &mut Findings) {
    // A place in no conserved sum is suspicious, and a net that grows is mostly seen to do so at once.
    if !findings.place_flows.as_ref().is_ok_and(|flows| flows.uncovered(net).next().is_none()) {
        let few = coverability::CoverabilityLimits { labels: LABELS_BEFORE_EXPLORATION, ..Default::default() };
        let covered = coverability(net, &few);
        if covered.as_ref().is_ok_and(|graph| graph.is_bounded().is_err()) {
            findings.covered = Some(covered);
            return;
        }
    }
    let first = ExplorationLimits { states: limits.states.min(STATES_BEFORE_COVERABILITY), ..*limits };
    let explored = explicit::decide(net, &first);
    if explored.is_ok() {
        findings.explored = Some(explored);
        return;
    }
    let covered = coverability(net, &coverability::CoverabilityLimits::default());
    let is_unbounded = covered.as_ref().is_ok_and(|graph| graph.is_bounded().is_err());
    findings.covered = Some(covered);
    if !is_unbounded {
        findings.explored = Some(if first.states < limits.states { explicit::decide(net, limits) } else { explored });
    }
}

/// The binary logarithm of a number of markings that conserved sums allow: where that many bits fit in memory, a search
/// goes over them quickly. Sum by sum: the rest for the places not counted yet follows from the others, and s tokens
/// are distributed over k places in k to the power of s ways at most.
fn possible_markings_log2(net: &Net, findings: &Findings) -> f64 {
    let Ok(flows) = &findings.place_flows else { return f64::INFINITY };
    let initial = net.initial_marking();
    let mut is_counted = vec![false; net.place_count()];
    let mut log2 = 0.0;
    let mut by_size: Vec<_> = flows.all().iter().map(|flow| (flow.sum(&initial), flow)).collect();
    by_size.sort_by_key(|(sum, flow)| (*sum, std::cmp::Reverse(flow.support().len())));
    for (sum, flow) in by_size {
        let fresh = flow.support().filter(|place| !std::mem::replace(&mut is_counted[place.index()], true)).count();
        log2 += sum as f64 * (fresh.max(1) as f64).log2();
    }
    if is_counted.contains(&false) { f64::INFINITY } else { log2 }
}

/// The first property that two analyses answer differently.
fn contradiction(net: &Net, findings: &Findings) -> Option<String> {
    NetProperty::ALL.into_iter().find_map(|property| {
        let answers = [
            ("structure", findings.by_structure(property)),
            ("exploration", findings.by_exploration(property)),
            ("coverability", findings.by_coverability(net, property)),
        ];
        let given: Vec<_> = answers.into_iter().filter_map(|(by, holds)| Some((by, holds?))).collect();
        let (first, holds) = *given.first()?;
        let (other, _) = given.iter().find(|(_, other)| *other != holds)?;
        let word = |holds: bool| if holds { "holds" } else { "does not hold" };
        Some(format!("'{property}' {} by {first}, and {} by {other}", word(holds), word(!holds)))
    })
}
