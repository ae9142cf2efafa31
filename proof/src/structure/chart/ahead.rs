//! Stations that nothing holds back: in auto they begin cycle after cycle, however far others are behind.
//!
//! A station waits for another one through arrows of auto, also through further stations. What waits for each other stays together
//! within the lags of its arrows. Where the stations are not all one such group, there are groups that wait for none outside (they
//! begin whatever happens) and groups that none outside waits for (they may be left behind). An arrow from each of the latter back to
//! each of the former joins all of them.

use linewright_line::{Arrow, Line, StationId};

use super::separated::{meant_arrows, missing_arrows, written};

/// Stations that may run ahead of others without limit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunAhead {
    /// Which ones, of which others, and by what.
    pub text: String,
    /// Consequence and remedy.
    pub help: String,
}

/// More names are no help to read.
const NAMES_MAX: usize = 6;
/// Of more pairs the rest is counted.
const PAIRS_MAX: usize = 3;

/// The groups of stations that may run ahead of others. Task-driven stations do what is ordered, and have no cycle.
pub fn run_ahead(line: &Line) -> Vec<RunAhead> {
    let stations: Vec<StationId> = line.station_ids().filter(|&id| !line.station(id).is_task_driven()).collect();
    let arrows: Vec<&Arrow> = line.arrows.iter().filter(|arrow| arrow.auto).collect();
    let first = closed(&stations, |at| arrows.iter().filter(|of| of.to.0 == at).map(|of| of.from.0).collect());
    let last = closed(&stations, |at| arrows.iter().filter(|of| of.from.0 == at).map(|of| of.to.0).collect());
    let mut pairs = Vec::new();
    for ahead in &first {
        for behind in last.iter().filter(|behind| *behind != ahead) {
            let is_joined = leads(&arrows, ahead, behind);
            // Groups that have nothing to do with each other are one pair.
            if is_joined || !pairs.iter().any(|(a, b, _)| (a, b) == (&behind, &ahead)) {
                pairs.push((ahead, behind, is_joined));
            }
        }
    }
    // An arrow that is the wrong way round is reported with the conflict that it does not keep apart.
    let meant = if pairs.is_empty() { Vec::new() } else { meant_arrows(line) };
    pairs.retain(|(ahead, behind, _)| {
        !meant.iter().any(|arrow| behind.contains(&arrow.from.0) && ahead.contains(&arrow.to.0))
    });
    let more = pairs.len().saturating_sub(PAIRS_MAX);
    pairs.truncate(PAIRS_MAX);
    let last = pairs.len().saturating_sub(1);
    let missing = if pairs.is_empty() { Vec::new() } else { missing_arrows(line) };
    let about = |(nth, (ahead, behind, is_joined)): (usize, &(&Vec<StationId>, &Vec<StationId>, bool))| {
        let found =
            if *is_joined { one_way(line, (&arrows, &missing), ahead, behind) } else { apart(line, ahead, behind) };
        if nth == last && more > 0 {
            RunAhead { text: format!("{}; and {more} more such pairs", found.text), ..found }
        } else {
            found
        }
    };
    pairs.iter().enumerate().map(about).collect()
}

/// All that is reached from these stations.
fn reached(start: &[StationId], next: impl Fn(StationId) -> Vec<StationId>) -> Vec<StationId> {
    let (mut seen, mut open) = (start.to_vec(), start.to_vec());
    while let Some(at) = open.pop() {
        for id in next(at) {
            if !seen.contains(&id) {
                seen.push(id);
                open.push(id);
            }
        }
    }
    seen.sort_unstable();
    seen
}

/// Groups of stations that reach each other and no station outside the group.
fn closed(stations: &[StationId], next: impl Fn(StationId) -> Vec<StationId>) -> Vec<Vec<StationId>> {
    let all: Vec<Vec<StationId>> = stations.iter().map(|&station| reached(&[station], &next)).collect();
    let mut groups: Vec<Vec<StationId>> = Vec::new();
    for of in &all {
        let is_closed = of.iter().all(|id| stations.iter().zip(&all).any(|(own, other)| own == id && other == of));
        if is_closed && !groups.contains(of) {
            groups.push(of.clone());
        }
    }
    groups
}

/// Whether one group holds the other, through further stations too.
fn leads(arrows: &[&Arrow], from: &[StationId], to: &[StationId]) -> bool {
    let next = |at: StationId| arrows.iter().filter(|of| of.from.0 == at).map(|of| of.to.0).collect();
    reached(from, next).iter().any(|id| to.contains(id))
}

/// The second group waits for the first, and the first for none of the second.
fn one_way(
    line: &Line,
    (arrows, missing): (&[&Arrow], &[Arrow]),
    ahead: &[StationId],
    behind: &[StationId],
) -> RunAhead {
    let (own, of) = (names(line, ahead), names(line, behind));
    let begins = if ahead.len() == 1 { "begins" } else { "begin" };
    // Of the arrows on the way: where they leave the first group, and where they enter the second.
    let onward = arrows.iter().find(|arrow| ahead.contains(&arrow.from.0) && !ahead.contains(&arrow.to.0));
    let into = arrows.iter().find(|arrow| !behind.contains(&arrow.from.0) && behind.contains(&arrow.to.0));
    let leads_back = |arrow: &&Arrow| behind.contains(&arrow.from.0) && ahead.contains(&arrow.to.0);
    let back = match (missing.iter().find(leads_back), onward.zip(into)) {
        (Some(arrow), _) => {
            format!("The arrow that keeps a conflict of theirs apart leads back too: {}. ", written(line, arrow))
        }
        // The whole cycle waits: an arrow to a later operation lets those before it run ahead.
        (None, Some((onward, into))) => {
            let (station, from) = (onward.from.0, into.to);
            let first = line.station(station).steps.first().and_then(|step| step.first());
            let to = (station, first.copied().unwrap_or(onward.from.1));
            let arrow = Arrow { from, to, lag: 1, auto: true, manual: false };
            let name = &line.station(station).name;
            format!(
                "Draw an arrow back, such as {} (done in the cycle before); to a later operation of {name} only where those before it \
                 may be done again before the part is taken. ",
                written(line, &arrow)
            )
        }
        (None, None) => String::new(),
    };
    RunAhead {
        text: format!(
            "{own} may run ahead of {of} in auto without limit: no arrow leads back from there, through others either"
        ),
        help: format!(
            "{own} {begins} the next cycle, and the one after it, while {of} may still stand in an earlier one: parts are handed on \
             before those before them were taken. {back}Where nothing is handed on, all is as it should be"
        ),
    }
}

/// Neither group waits for the other.
fn apart(line: &Line, one: &[StationId], other: &[StationId]) -> RunAhead {
    let (one, other) = (names(line, one), names(line, other));
    RunAhead {
        text: format!("{one} and {other} may run ahead of each other in auto without limit: no arrow joins them"),
        help: format!(
            "each begins its next cycle wherever the other stands. If a part goes from {one} to {other} or back, draw an arrow for it, \
             and one back with `lag = 1`. Where nothing is handed on, all is as it should be"
        ),
    }
}

fn names(line: &Line, stations: &[StationId]) -> String {
    let name = |id: &StationId| line.station(*id).name.clone();
    let shown: Vec<String> = stations.iter().take(NAMES_MAX).map(name).collect();
    let more = stations.len().saturating_sub(NAMES_MAX);
    let text = shown.join(", ");
    if more == 0 { text } else { format!("{text} and {more} more") }
}
