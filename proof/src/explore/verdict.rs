//! Verdicts of an exploration of a line: each property, whether it holds, and a counterexample where it does not.

use std::thread;

use linewright_line::net::{ControlMode, StationNet};
use linewright_nets::TransitionId;

use super::counterexample::LinePath;
use super::properties::{Violation, counted};
use super::search::{LimitReached, LineSearch, SearchEnd};
use super::station::Situations;
use super::system::FixedSituation;

/// Verdict on a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// In every state.
    Holds,
    /// There is a counterexample, or nothing that would have to be there.
    Fails,
    /// The search ended before it was decided.
    Undecided,
    /// Nothing is wrong, but something may not be as it was meant.
    Remark,
}

/// One property of the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineProperty {
    /// Name of the property.
    pub name: String,
    /// The answer.
    pub verdict: Verdict,
    /// Why, in words.
    pub reason: String,
    /// Path to the violation.
    pub counterexample: Option<LinePath>,
    /// It holds of a line if it holds of its parts: that no state of some stations is reached, or what is of each station by itself.
    pub holds_by_parts: bool,
}

/// Result of an exploration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineExplored {
    /// States seen.
    pub states: u64,
    /// States that were kept and looked at. Each stands for all that differ from it only in what stations come and go between by
    /// themselves.
    pub kept: usize,
    /// Moves from state to state that were looked at.
    pub arcs: u64,
    /// Memory it took, about.
    pub bytes: usize,
    /// Every state was seen: there are no others.
    pub exhausted: bool,
    /// What ended it before that, unless something wrong did.
    pub limit: Option<LimitReached>,
    /// For each station, how many situations its controller, operator and view of the others were met in.
    pub situations: Vec<usize>,
    pub properties: Vec<LineProperty>,
}

impl LineExplored {
    /// Whether every property holds; a remark counts as holding.
    pub fn holds(&self) -> bool {
        self.properties.iter().all(|property| matches!(property.verdict, Verdict::Holds | Verdict::Remark))
    }

    /// The first counterexample, if there is one.
    pub fn counterexample(&self) -> Option<&LinePath> {
        self.properties.iter().find_map(|property| property.counterexample.as_ref())
    }
}

/// Draws the conclusions.
pub(crate) fn judge<const N: usize>(mut search: LineSearch<N>) -> LineExplored {
    let mut properties = never_wrong(&mut search);
    properties.extend(of_all_states(&mut search));
    LineExplored {
        states: search.tally.states,
        kept: search.looked_at,
        arcs: search.tally.arcs,
        bytes: search.bytes(),
        exhausted: search.end == SearchEnd::Exhausted,
        limit: limit_of(search.end),
        situations: search.system.stations.iter().map(|station| station.all.len()).collect(),
        properties,
    }
}

/// Properties of each state.
fn never_wrong<const N: usize>(search: &mut LineSearch<N>) -> Vec<LineProperty> {
    let found = match search.end {
        SearchEnd::Wrong(number) => {
            let state = search.state(number);
            search.system.wrong(&state).map(|(wrong, pins)| (wrong, story(search, number, wrong, &pins)))
        }
        SearchEnd::Exhausted | SearchEnd::Limit(_) => None,
    };
    let conflicts = search.system.setting.line.conflicts.iter().enumerate();
    let names = conflicts.map(|(nth, conflict)| (format!("never: {}", conflict.why), Violation::Conflict(nth)));
    let others = [
        (
            "stations sound: one token in each branch, counts of one cycle, no output without a motion",
            Violation::Station(0),
        ),
        ("stations stay within the cycles their arrows allow", Violation::Apart(0, 0)),
    ];
    let others = others.map(|(name, wrong)| (name.to_owned(), wrong));
    let properties: Vec<(String, Violation)> = names.chain(others).collect();
    properties
        .into_iter()
        .map(|(name, kind)| {
            let story = found.as_ref().filter(|(wrong, _)| is_kind(*wrong, kind)).map(|(_, story)| story.clone());
            let states = search.tally.states;
            let (verdict, reason) = match (&story, search.end) {
                (Some(story), _) => {
                    let after = format!("after {} steps", story.steps.len());
                    // A violation is not repeated: a conflict's property is named by it.
                    let is_named = name.ends_with(&story.end);
                    (Verdict::Fails, if is_named { after } else { format!("{}, {after}", story.end) })
                }
                (None, SearchEnd::Exhausted) => (Verdict::Holds, format!("in all {} states", counted(states))),
                (None, end) => (Verdict::Undecided, undecided(states, limit_of(end))),
            };
            let holds_by_parts = matches!(kind, Violation::Conflict(_) | Violation::Station(_));
            LineProperty { name, verdict, reason, counterexample: story, holds_by_parts }
        })
        .collect()
}

fn is_kind(wrong: Violation, kind: Violation) -> bool {
    match (wrong, kind) {
        (Violation::Conflict(a), Violation::Conflict(b)) => a == b,
        (Violation::Station(_), Violation::Station(_)) | (Violation::Apart(..), Violation::Apart(..)) => true,
        (Violation::Conflict(_) | Violation::Station(_) | Violation::Apart(..), _) => false,
    }
}

fn limit_of(end: SearchEnd) -> Option<LimitReached> {
    match end {
        SearchEnd::Limit(limit) => Some(limit),
        SearchEnd::Exhausted | SearchEnd::Wrong(_) => None,
    }
}

/// Why a search decides nothing that ended by a limit, or with something wrong (`None`).
fn undecided(states: u64, limit: Option<LimitReached>) -> String {
    let states = counted(states);
    match limit {
        None => format!("not met in {states} states; the search ended with the first thing wrong"),
        Some(LimitReached::States) => format!("undecided after {states} states: the limit of states was reached"),
        Some(LimitReached::Memory) => format!("undecided after {states} states: the limit of memory was reached"),
    }
}

fn story<const N: usize>(
    search: &mut LineSearch<N>,
    number: u32,
    wrong: Violation,
    pins: &[FixedSituation],
) -> LinePath {
    let (way, last) = search.way_to(number, pins);
    debug_assert!(search.system.shows(&last, wrong), "nothing is wrong at the end of the way to state {number}");
    let end = search.system.wrong_text(&last, wrong);
    LinePath::tell(&search.system, &way, &last, end)
}

fn tell<const N: usize>(search: &mut LineSearch<N>, number: u32, end: String) -> LinePath {
    let (way, last) = search.way_to(number, &[]);
    LinePath::tell(&search.system, &way, &last, end)
}

/// Properties of all states together.
fn of_all_states<const N: usize>(search: &mut LineSearch<N>) -> Vec<LineProperty> {
    let mut properties = Vec::new();
    if search.system.setting.forgets {
        return properties;
    }
    let (states, limit) = (search.tally.states, limit_of(search.end));
    let ask = |name: &str, found: Option<Result<String, (String, Option<LinePath>)>>| {
        let (verdict, reason, counterexample) = match found {
            None => (Verdict::Undecided, undecided(states, limit), None),
            Some(Ok(reason)) => (Verdict::Holds, reason, None),
            Some(Err((reason, story))) => (Verdict::Fails, reason, story),
        };
        LineProperty { name: name.to_owned(), verdict, reason, counterexample, holds_by_parts: false }
    };
    let exhausted = search.end == SearchEnd::Exhausted;
    let deadlocks = exhausted.then(|| match search.tally.deadlocks {
        0 => Ok("something can follow every state".to_owned()),
        found => Err((format!("nothing can follow {found} states"), None)),
    });
    properties.push(ask("no deadlock", deadlocks));
    if search.system.setting.asks_for_ways() {
        let cut_off = exhausted.then(|| cut_off(search));
        let homes = cut_off.map(|(stranded, _)| home(search, stranded));
        properties.push(ask("home can be reached from every state", homes));
        let back = cut_off.map(|(_, no_return)| reversible(search, no_return));
        properties.push(ask("reversible and live", back));
    }
    let setting = &search.system.setting;
    if setting.faults
        && [ControlMode::Auto, ControlMode::Hand, ControlMode::Manual].iter().all(|m| setting.modes.contains(m))
    {
        let fires = exhausted.then(|| every_transition(search));
        let mut property = ask("every transition fires", fires);
        // A way that the description gives operators no command for is no danger.
        if property.verdict == Verdict::Fails {
            property.verdict = Verdict::Remark;
        }
        properties.push(property);
    }
    properties
}

type Occurrence = Result<String, (String, Option<LinePath>)>;

/// A state from which home cannot be reached, and one from which the start cannot, looked for side by side.
fn cut_off<const N: usize>(search: &LineSearch<N>) -> (Option<u32>, Option<u32>) {
    thread::scope(|scope| {
        let stranded = scope.spawn(|| search.stranded());
        let no_return = search.no_return();
        (stranded.join().expect("a search among known states ends"), no_return)
    })
}

fn home<const N: usize>(search: &mut LineSearch<N>, stranded: Option<u32>) -> Occurrence {
    let by = if search.home_by_manual().is_some() { ", by manual mode alone" } else { "" };
    match stranded {
        None => Ok(format!("from all {} states{by}", counted(search.tally.states))),
        Some(number) => {
            let story = tell(search, number, format!("from here on there is no way home{by}"));
            Err((format!("not from the state after {} steps{by}", story.steps.len()), Some(story)))
        }
    }
}

fn reversible<const N: usize>(search: &mut LineSearch<N>, no_return: Option<u32>) -> Occurrence {
    match no_return {
        None => {
            Ok("every state leads back to the start, so whatever fires once can fire again from anywhere".to_owned())
        }
        Some(number) => {
            let story = tell(search, number, "from here on nothing leads back to the start".to_owned());
            Err((format!("nothing leads back from the state after {} steps", story.steps.len()), Some(story)))
        }
    }
}

fn every_transition<const N: usize>(search: &LineSearch<N>) -> Occurrence {
    let line = &search.system.setting.line;
    let mut count = 0;
    let mut idle = Vec::new();
    for (id, Situations { fired, .. }) in line.station_ids().zip(&search.system.stations) {
        let net = StationNet::of(line, id);
        count += fired.len();
        for (index, _) in fired.iter().enumerate().filter(|(_, fired)| !**fired) {
            let name = net.net().transition_name(TransitionId(index as u32));
            idle.push(format!("{}: {name}", line.station(id).name));
        }
    }
    if idle.is_empty() {
        return Ok(format!("all {count} transitions of all stations"));
    }
    Err((format!("{} of {count} transitions never fire: {}", idle.len(), idle.join("; ")), None))
}
