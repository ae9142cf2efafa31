//! Report on a net, as data: the JSON of `--json`, and the source of the table.

use linewright_nets::certificate::{NetProperty, TokenBound};
use linewright_nets::semiflows::{Semiflow, Semiflows};
use linewright_nets::{Net, explicit};
use serde::Serialize;

use super::decide::Findings;
use super::plays::{ViolationPath, plays};

/// Most semiflows listed; all are counted.
const FLOWS_LISTED: usize = 1000;

/// Most names kept of a list.
const NAMES_LISTED: usize = 1000;

/// All results. Unknown ones are `null`, with the reason in `undecided`.
#[derive(Debug, Serialize)]
pub struct AnalysisReport {
    /// The net's name.
    pub net: String,
    /// Number of places.
    pub places: usize,
    /// Number of transitions.
    pub transitions: usize,
    /// Number of reachable markings.
    pub states: Option<u64>,
    /// Number of arcs of the reachability graph.
    pub arcs: Option<u64>,
    /// Number of reachable markings in which nothing is enabled.
    pub deadlocks: Option<u64>,
    /// The most tokens that any place ever holds; `null` for an unbounded net, too.
    pub bound: Option<u64>,
    /// Whether every place has a bound.
    pub bounded: Option<bool>,
    /// Whether that bound is 1.
    pub safe: Option<bool>,
    /// Whether something is enabled in every reachable marking.
    pub deadlock_free: Option<bool>,
    /// Whether every transition can always be made to fire again.
    pub live: Option<bool>,
    /// Whether the initial marking can be reached from every reachable one.
    pub reversible: Option<bool>,
    /// Number of minimal place semiflows (conserved sums).
    pub p_semiflows: Option<usize>,
    /// Number of minimal transition semiflows (repetitions).
    pub t_semiflows: Option<usize>,
    /// Time of the analysis in seconds, reading included.
    pub seconds: f64,
    /// The most bytes that the search for markings held at a time.
    pub bytes: Option<usize>,
    /// The class of the net.
    pub class: Vec<&'static str>,
    /// Analysis that decided each answer.
    pub decided_by: DecidedBy,
    /// Markings that can be reached from every reachable one.
    pub home_states: Option<u64>,
    /// Transitions that never fire.
    pub dead_transitions: Option<Vec<String>>,
    /// Transitions that can be lost for ever, dead ones included.
    pub transitions_not_live: Option<Vec<String>>,
    /// Places without a bound.
    pub unbounded_places: Option<Vec<String>>,
    /// The places and weights of the first conserved sums, and what each is initially.
    pub place_semiflows: Vec<ReportedFlow>,
    /// The transitions and counts of the first repetitions.
    pub transition_semiflows: Vec<ReportedFlow>,
    /// Ways to play the net that show what does not hold.
    pub counterexamples: Vec<ViolationPath>,
    /// Open questions, with reasons.
    pub undecided: Vec<String>,
}

/// Source of an answer: "structure" (with a certificate that has been checked), "exploration" or "coverability".
#[derive(Debug, Default, Serialize)]
pub struct DecidedBy {
    pub bounded: Option<&'static str>,
    pub safe: Option<&'static str>,
    pub deadlock_free: Option<&'static str>,
    pub live: Option<&'static str>,
    pub reversible: Option<&'static str>,
}

/// A minimal semiflow.
#[derive(Debug, Serialize)]
pub struct ReportedFlow {
    /// Node and weight.
    pub weights: Vec<(String, u64)>,
    /// Of a place semiflow, the sum that never changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sum: Option<u64>,
}

/// Puts the results of the analyses together.
pub fn report(net: &Net, findings: &Findings, seconds: f64) -> AnalysisReport {
    let answer = |property: NetProperty| {
        let by = [
            ("structure", findings.by_structure(property)),
            ("exploration", findings.by_exploration(property)),
            ("coverability", findings.by_coverability(net, property)),
        ];
        by.into_iter().find_map(|(by, holds)| Some((holds?, by)))
    };
    let [deadlock_free, live, bounded, safe, reversible] = NetProperty::ALL.map(answer);
    let holds = |answer: Option<(bool, _)>| answer.map(|(holds, _)| holds);
    let by = |answer: Option<(_, &'static str)>| answer.map(|(_, by)| by);
    let facts = findings.facts();
    let initial = net.initial_marking();
    let sum = |flow: &Semiflow<_>| u64::try_from(flow.sum(&initial)).ok();
    AnalysisReport {
        net: net.name().to_owned(),
        places: net.place_count(),
        transitions: net.transition_count(),
        states: facts.map(|facts| facts.states),
        arcs: facts.map(|facts| facts.arcs),
        deadlocks: facts.map(|facts| facts.deadlocks).or(holds(deadlock_free).filter(|&free| free).map(|_| 0)),
        bound: bound(net, findings),
        bounded: holds(bounded),
        safe: holds(safe),
        deadlock_free: holds(deadlock_free),
        live: holds(live),
        reversible: holds(reversible),
        p_semiflows: findings.place_flows.as_ref().ok().map(|flows| flows.all().len()),
        t_semiflows: findings.transition_flows.as_ref().ok().map(|flows| flows.all().len()),
        seconds,
        bytes: facts.map(|facts| facts.bytes),
        class: classes(net),
        decided_by: DecidedBy {
            bounded: by(bounded),
            safe: by(safe),
            deadlock_free: by(deadlock_free),
            live: by(live),
            reversible: by(reversible),
        },
        home_states: facts.map(|facts| facts.home.as_ref().map_or(0, |home| home.states)),
        dead_transitions: dead(net, findings, holds(live)),
        transitions_not_live: not_live(net, findings, holds(live)),
        unbounded_places: unbounded(net, findings, holds(bounded)),
        place_semiflows: listed(&findings.place_flows, |p| net.place_name(p).to_owned(), sum),
        transition_semiflows: listed(&findings.transition_flows, |t| net.transition_name(t).to_owned(), |_| None),
        counterexamples: plays(net, findings),
        undecided: undecided(net, findings),
    }
}

/// All classes that the net is in.
fn classes(net: &Net) -> Vec<&'static str> {
    let classes = [
        ("state machine", net.is_state_machine().is_ok()),
        ("marked graph", net.is_marked_graph().is_ok()),
        ("free-choice", net.is_free_choice().is_ok()),
        ("extended free-choice", net.is_extended_free_choice().is_ok()),
        ("asymmetric choice", net.is_asymmetric_choice().is_ok()),
        ("strongly connected", net.is_strongly_connected().is_ok()),
    ];
    classes.into_iter().filter(|(_, is)| *is).map(|(class, _)| class).collect()
}

/// The largest bound of a place, where all are exact.
fn bound(net: &Net, findings: &Findings) -> Option<u64> {
    if let Some(facts) = findings.facts() {
        return Some(facts.bound().into());
    }
    if let Some(graph) = findings.coverability() {
        return net
            .places()
            .map(|p| graph.bound_of(p))
            .try_fold(0, |most, bound| Some(most.max(bound?)))
            .map(u64::from);
    }
    findings.by_structure(NetProperty::Bounded).filter(|&bounded| bounded)?;
    findings.structure.bounds.iter().try_fold(0, |most: u64, bound| match bound {
        TokenBound::Exactly(bound) => Some(most.max(u64::try_from(*bound).ok()?)),
        TokenBound::AtMost(_) | TokenBound::Unbounded | TokenBound::Unknown => None,
    })
}

fn some<I>(nodes: impl Iterator<Item = I>, name: impl Fn(I) -> String) -> Vec<String> {
    nodes.take(NAMES_LISTED).map(name).collect()
}

fn dead(net: &Net, findings: &Findings, live: Option<bool>) -> Option<Vec<String>> {
    let name = |t| net.transition_name(t).to_owned();
    if let Some(facts) = findings.facts() {
        return Some(some(net.transitions().filter(|t| !facts.fires[t.index()]), name));
    }
    let covered = findings.coverability().map(|graph| some(graph.dead_transitions().iter().copied(), name));
    covered.or(live.filter(|&live| live).map(|_| Vec::new()))
}

fn not_live(net: &Net, findings: &Findings, live: Option<bool>) -> Option<Vec<String>> {
    let lost = |facts: &explicit::NetFacts| {
        let lost = net.transitions().filter(|&t| !facts.is_transition_live(t));
        some(lost, |t| net.transition_name(t).to_owned())
    };
    findings.facts().map(lost).or(live.filter(|&live| live).map(|_| Vec::new()))
}

fn unbounded(net: &Net, findings: &Findings, bounded: Option<bool>) -> Option<Vec<String>> {
    let covered = findings.coverability().map(|graph| some(graph.unbounded(), |p| net.place_name(p).to_owned()));
    covered.or(bounded.filter(|&bounded| bounded).map(|_| Vec::new()))
}

fn listed<I: Copy + Ord, E>(
    flows: &Result<Semiflows<I>, E>,
    name: impl Fn(I) -> String,
    sum: impl Fn(&Semiflow<I>) -> Option<u64>,
) -> Vec<ReportedFlow> {
    let Ok(flows) = flows else { return Vec::new() };
    let flow = |flow: &Semiflow<I>| ReportedFlow {
        weights: flow.weights.iter().map(|&(node, weight)| (name(node), weight)).collect(),
        sum: sum(flow),
    };
    flows.all().iter().take(FLOWS_LISTED).map(flow).collect()
}

/// Open questions, with the reason from the last analysis run.
fn undecided(net: &Net, findings: &Findings) -> Vec<String> {
    let mut open = Vec::new();
    let is_unbounded = findings.coverability().is_some_and(|graph| graph.is_bounded().is_err())
        || findings.by_structure(NetProperty::Bounded) == Some(false);
    if is_unbounded {
        open.push("states, arcs: the net is unbounded, there is no end to its markings".to_owned());
    } else if let Some(Err(why)) = &findings.explored {
        open.push(match why.cause {
            explicit::ExplorationLimit::States { limit } if findings.is_short => {
                format!(
                    "states, arcs: more than {limit}, and all else is known without them; --states N counts further"
                )
            }
            explicit::ExplorationLimit::States { limit } => {
                format!("states, arcs: more than {limit}; --states N looks further")
            }
            explicit::ExplorationLimit::Bytes { .. } => format!("states, arcs: {why}; --memory MB allows more"),
            explicit::ExplorationLimit::Overflow(_) => format!("states, arcs: {why}"),
        });
    }
    if let Some(Err(why)) = &findings.covered {
        open.push(format!("unbounded places: {why}"));
    }
    for property in NetProperty::ALL {
        let is_known = findings.by_structure(property).is_some()
            || findings.by_exploration(property).is_some()
            || findings.by_coverability(net, property).is_some();
        if !is_known
            && let linewright_nets::certificate::CertificateAnswer::Unknown(why) = findings.structure.answer(property)
        {
            open.push(format!("{property}: {why}"));
        }
    }
    for (property, why) in &findings.rejected {
        open.push(format!("{property} by structure: the certificate is not accepted: {why}"));
    }
    if let Err(why) = &findings.place_flows {
        open.push(format!("place semiflows: {why}"));
    }
    if let Err(why) = &findings.transition_flows {
        open.push(format!("transition semiflows: {why}"));
    }
    open
}
