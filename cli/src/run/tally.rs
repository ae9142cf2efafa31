//! Tally of a run, for its report: cycles, operations, durations, faults.
//!
//! Counts are taken from the states, which are authoritative; durations from the events, whose stamps are the stations'
//! own. A lost event loses one duration and no count.

use std::collections::HashMap;

use linewright_line::{Line, OpId, Station, StationId};
use linewright_msgs::{Header, StationEvent, StationState};
use serde::Serialize;

use super::observer::BusObserver;

/// At most this many different faults of one station are kept.
const FAULTS_LISTED: usize = 5;

/// The tally of a run.
pub struct RunTally {
    line: Line,
    stations: Vec<StationTally>,
    /// When each cycle of the line ended, in seconds; the first entry is when auto began.
    ends: Vec<f64>,
}

#[derive(Default)]
struct StationTally {
    /// An arrow leads to or from it: its rounds mean something only within a generation.
    compares: bool,
    /// The generation of its counts: those of different ones mean nothing to each other.
    generation: u64,
    /// Counts of this generation when it was first heard, and now.
    first_done: Option<Vec<i32>>,
    done: Vec<i32>,
    /// Rounds it had completed where the count of cycles begins in this generation, and now.
    first_round: i32,
    round: i32,
    /// What was done in the generations before it: cycles of the line, and each operation.
    cycles_before: i32,
    done_before: Vec<i32>,
    started: HashMap<OpId, f64>,
    durations: Vec<Vec<f64>>,
    faults: u64,
    /// Different faults, the last one last, each with how often it came; more than [`FAULTS_LISTED`] are only counted.
    fault_texts: Vec<(String, u64)>,
    /// The station's last fault text: with device, object and cause, where it has them.
    fault: Option<String>,
}

/// The report, in the form `--json` prints.
#[derive(Serialize)]
pub struct RunReport {
    /// The line's name.
    pub line: String,
    /// Cycles ended.
    pub cycles: usize,
    /// Of a cell, how many of the parts that were ordered are made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts_made: Option<u32>,
    /// Number of parts ordered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts_wanted: Option<u32>,
    /// Alarms of the cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarms: Option<usize>,
    /// Parts ordered that were lost and made again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts_lost: Option<u32>,
    /// The mode at the end.
    pub mode: String,
    /// Time of each cycle, end to end, in seconds; the first one from the start of auto.
    pub cycle_time_s: Vec<f64>,
    /// Each station.
    pub stations: serde_json::Map<String, serde_json::Value>,
    /// Conflicts the observer of the CAN frames has seen.
    pub conflicts_seen: Vec<String>,
    /// Conflicts that cannot be seen from the frames it reads.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conflicts_not_watched: Vec<String>,
    /// CAN frames it has looked at.
    pub frames_seen: u64,
    /// Processes that had to be started again.
    pub restarts: u32,
    /// Why the run failed, if it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// The faults that stand, by the states of the stations.
pub fn standing<'s>(stations: impl Iterator<Item = (&'s Station, Option<&'s StationState>)>) -> Vec<String> {
    let faults = stations.filter_map(|(station, state)| {
        let fault = &state?.fault;
        (!fault.is_empty()).then(|| format!("{} {fault}", station.name))
    });
    faults.collect()
}

fn seconds(header: &Header) -> f64 {
    f64::from(header.stamp.sec) + f64::from(header.stamp.nanosec) * 1e-9
}

impl RunTally {
    /// Nothing yet.
    pub fn new(line: &Line) -> Self {
        let station = |(id, s): (StationId, &Station)| StationTally {
            compares: line.arrows.iter().any(|arrow| arrow.from.0 == id || arrow.to.0 == id),
            durations: vec![Vec::new(); s.operations.len()],
            done_before: vec![0; s.operations.len()],
            ..StationTally::default()
        };
        let stations = line.station_ids().zip(&line.stations).map(station).collect();
        RunTally { stations, line: line.clone(), ends: Vec::new() }
    }

    /// Auto has begun.
    pub fn begin(&mut self, header: &Header) {
        if self.ends.is_empty() {
            self.ends.push(seconds(header));
        }
    }

    /// Cycles of the line that have ended: every operation of every station is done in them.
    pub fn cycles(&self) -> usize {
        self.ends.len().saturating_sub(1)
    }

    /// Faults of all stations.
    pub fn faults(&self) -> u64 {
        self.stations.iter().map(|s| s.faults).sum()
    }

    /// The faults of each station, each with how often it came; without what to do about it where it stands no more, by the states now.
    /// The counts add up to [`RunTally::faults`].
    pub fn fault_texts<'s>(&self, now: impl Iterator<Item = Option<&'s StationState>>) -> Vec<String> {
        let stations = self.line.stations.iter().zip(&self.stations).zip(now);
        let all = stations.flat_map(|((station, tally), state)| {
            let name = &station.name;
            let is_over = state.is_some_and(|state| state.fault.is_empty());
            let listed: u64 = tally.fault_texts.iter().map(|(_, times)| times).sum();
            let one = move |(text, times): &(String, u64), is_over: bool| {
                let what = text.split_once("; ").map_or(text.as_str(), |(what, _)| what);
                let times = (*times > 1).then(|| format!("{times} times"));
                let notes: Vec<String> = is_over.then(|| "recovered".to_owned()).into_iter().chain(times).collect();
                let text = if is_over { what } else { text };
                let notes = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join(", ")) };
                format!("{name} {text}{notes}")
            };
            let others =
                (listed < tally.faults).then(|| format!("{name} {} faults before these", tally.faults - listed));
            let last = tally.fault_texts.len().saturating_sub(1);
            // Those before the last one do not stand any more.
            let of_station =
                tally.fault_texts.iter().enumerate().map(move |(at, fault)| one(fault, is_over || at < last));
            others.into_iter().chain(of_station)
        });
        all.collect()
    }

    /// Takes a station's state.
    pub fn state(&mut self, id: StationId, state: &StationState) {
        // Generations begin with all stations at home, so each counts on from what the line has done.
        let before = self.ended();
        let counts = !self.ends.is_empty();
        let station = &mut self.stations[id.index()];
        station.count(state, before, counts);
        if !state.fault.is_empty() {
            station.fault = Some(state.fault.clone());
        }
        if !counts {
            return;
        }
        while self.cycles() < usize::try_from(self.ended()).unwrap_or(0) {
            self.ends.push(seconds(&state.header));
        }
    }

    /// Cycles that every station has completed.
    fn ended(&self) -> i32 {
        self.stations.iter().map(|station| self.rounds(station, station.round)).min().unwrap_or(0)
    }

    /// Number of rounds that the station has begun in this run. A round leads from home to home, as the stop does.
    pub fn begun(&self, id: StationId, state: &StationState) -> usize {
        usize::try_from(self.rounds(&self.stations[id.index()], state.round)).unwrap_or(0)
    }

    /// Rounds since the run began to count, of a station that is in this one. Those of one generation count from one
    /// beginning: a station that was a round behind has not done one more than the others.
    fn rounds(&self, station: &StationTally, round: i32) -> i32 {
        if !station.compares {
            return round.saturating_sub(station.first_round);
        }
        if station.generation == 0 {
            return station.cycles_before;
        }
        let shared = self.stations.iter().filter(|other| other.compares && other.generation == station.generation);
        let first = shared.map(|other| other.first_round).min().unwrap_or(station.first_round);
        station.cycles_before.saturating_add(round.saturating_sub(first))
    }

    /// Takes an event.
    pub fn event(&mut self, id: StationId, event: &StationEvent) {
        let station = &mut self.stations[id.index()];
        let op = self.line.station(id).operation_named(&event.operation);
        match (event.kind, op) {
            (StationEvent::KIND_STARTED, Some(op)) => {
                station.started.insert(op, seconds(&event.header));
            }
            (StationEvent::KIND_COMPLETED, Some(op)) => {
                if let Some(start) = station.started.remove(&op) {
                    station.durations[op.index()].push(seconds(&event.header) - start);
                }
            }
            (StationEvent::KIND_FAULT, _) => {
                station.faults += 1;
                let known = station.fault_texts.iter().position(|(text, _)| *text == event.text);
                let times = known.map_or(0, |at| station.fault_texts.remove(at).1);
                station.fault_texts.push((event.text.clone(), times + 1));
                if station.fault_texts.len() > FAULTS_LISTED {
                    station.fault_texts.remove(0);
                }
            }
            _ => {}
        }
    }

    pub fn report(&self, mode: &str, observer: &BusObserver, restarts: u32, error: Option<String>) -> RunReport {
        let mut stations = serde_json::Map::new();
        for (id, tally) in self.line.station_ids().zip(&self.stations) {
            stations.insert(self.line.station(id).name.clone(), self.station_report(id, tally));
        }
        RunReport {
            parts_made: None,
            parts_wanted: None,
            alarms: None,
            parts_lost: None,
            line: self.line.name.clone(),
            cycles: self.cycles(),
            mode: mode.to_owned(),
            cycle_time_s: self.ends.windows(2).map(|pair| round(pair[1] - pair[0])).collect(),
            stations,
            conflicts_seen: observer.conflicts().to_vec(),
            conflicts_not_watched: observer.unwatched(),
            frames_seen: observer.frames(),
            restarts,
            error,
        }
    }

    fn station_report(&self, id: StationId, tally: &StationTally) -> serde_json::Value {
        let mut operations = serde_json::Map::new();
        let mut least = i32::MAX;
        for (index, operation) in self.line.station(id).operations.iter().enumerate() {
            let count = tally.done_of(index);
            least = least.min(count);
            let durations = &tally.durations[index];
            let mean = (!durations.is_empty()).then(|| round(durations.iter().sum::<f64>() / durations.len() as f64));
            operations.insert(operation.name.clone(), serde_json::json!({ "count": count, "duration_s": mean }));
        }
        serde_json::json!({ "cycles": least, "operations": operations, "faults": tally.faults, "fault": tally.fault })
    }
}

impl StationTally {
    /// `before`: cycles that the line has ended. `counts`: auto has begun, so a round counts.
    fn count(&mut self, state: &StationState, before: i32, counts: bool) {
        let is_first = self.first_done.is_none();
        let completed = state.round.saturating_sub(i32::from(!state.at_home));
        if is_first || self.generation != state.generation {
            self.cycles_before = if is_first { 0 } else { before };
            self.done_before = (0..self.done_before.len()).map(|op| self.done_of(op)).collect();
            self.generation = state.generation;
            self.first_done = Some(state.done.clone());
            self.first_round = completed;
        }
        if !counts {
            // Led home in manual before, it has ended no cycle of the run.
            (self.cycles_before, self.first_round) = (0, completed);
        }
        self.round = completed;
        self.done.clone_from(&state.done);
    }

    /// How often an operation was done.
    fn done_of(&self, op: usize) -> i32 {
        let first = self.first_done.as_ref().and_then(|first| first.get(op));
        let done = self.done.get(op).zip(first).map_or(0, |(done, first)| done - first);
        self.done_before.get(op).copied().unwrap_or(0) + done
    }
}

/// To the microsecond: what lies below is noise.
fn round(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_line::TransferLine;

    /// All stations, each operation done this often, in a generation.
    fn heard(tally: &mut RunTally, generation: u64, done: i32) -> Vec<usize> {
        let line = tally.line.clone();
        let begun = line.station_ids().map(|id| {
            let done = vec![done; line.station(id).operations.len()];
            let round = done[0];
            let state = StationState { generation, done, round, at_home: true, ..StationState::default() };
            tally.state(id, &state);
            tally.begun(id, &state)
        });
        begun.collect()
    }

    #[test]
    fn a_fault_that_was_recovered_is_named_without_its_advice() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let mut tally = RunTally::new(&line);
        let text = "index in doubt: no switch; look at the mechanism, then confirm with rejoin".to_owned();
        tally.event(
            StationId(0),
            &StationEvent { kind: StationEvent::KIND_FAULT, text: text.clone(), ..Default::default() },
        );
        let name = &line.stations[0].name;
        let stands = StationState { fault: text.clone(), ..StationState::default() };
        let recovered = StationState::default();
        let now = |state| std::iter::once(Some(state)).chain(std::iter::repeat_n(None, line.stations.len() - 1));
        assert_eq!(tally.fault_texts(now(&stands)), [format!("{name} {text}")]);
        assert_eq!(tally.fault_texts(now(&recovered)), [format!("{name} index in doubt: no switch (recovered)")]);
        assert_eq!(standing(line.stations.iter().zip(now(&stands))), [format!("{name} {text}")]);
        assert!(standing(line.stations.iter().zip(now(&recovered))).is_empty());
    }

    /// The report begins with how many there were: those that are named are as many.
    #[test]
    fn the_last_faults_of_a_station_are_named_and_the_others_counted() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let mut tally = RunTally::new(&line);
        let mut fault = |station: u16, text: &str| {
            let event = StationEvent { kind: StationEvent::KIND_FAULT, text: text.to_owned(), ..Default::default() };
            tally.event(StationId(station), &event);
        };
        for text in ["a; look", "b", "a; look"] {
            fault(0, text);
        }
        fault(1, "c; do it");
        let (first, second) = (&line.stations[0].name, &line.stations[1].name);
        let (over, stands) = (StationState::default(), StationState { fault: "c".to_owned(), ..Default::default() });
        let now = || [Some(&over), Some(&stands), None].into_iter();
        assert_eq!(tally.faults(), 4);
        assert_eq!(
            tally.fault_texts(now()),
            [format!("{first} b (recovered)"), format!("{first} a (recovered, 2 times)"), format!("{second} c; do it")]
        );
        for number in 0..40 {
            let event = StationEvent { kind: StationEvent::KIND_FAULT, text: number.to_string(), ..Default::default() };
            tally.event(StationId(0), &event);
        }
        let all = tally.fault_texts(now());
        assert_eq!((all.len(), all[0].clone()), (FAULTS_LISTED + 2, format!("{first} 38 faults before these")));
    }

    /// One station, its operations done so often, in a round.
    fn hears_one(tally: &mut RunTally, id: StationId, generation: u64, done: i32, at_home: bool) -> usize {
        let done = vec![done; tally.line.station(id).operations.len()];
        let round = done[0] + i32::from(!at_home);
        let state = StationState { generation, done, round, at_home, ..StationState::default() };
        tally.state(id, &state);
        tally.begun(id, &state)
    }

    #[test]
    fn a_station_led_home_before_auto_has_begun_no_more_cycles_than_the_others() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let mut tally = RunTally::new(&line);
        heard(&mut tally, 0, 0);
        // Confirmed within its operation, then led on: it comes home once.
        hears_one(&mut tally, StationId(0), 0, 0, false);
        hears_one(&mut tally, StationId(0), 0, 1, true);
        tally.begin(&Header::default());
        assert_eq!(heard(&mut tally, 8, 0), [0, 0, 0]);
        assert_eq!(hears_one(&mut tally, StationId(0), 8, 0, false), 1, "in its first cycle");
        assert_eq!(heard(&mut tally, 8, 1), [1, 1, 1]);
        assert_eq!(tally.cycles(), 1);
    }

    #[test]
    fn stations_that_had_come_to_different_cycles_begin_a_new_generation_with_one_count() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let mut tally = RunTally::new(&line);
        heard(&mut tally, 7, 40);
        tally.begin(&Header::default());
        heard(&mut tally, 7, 41);
        // One is a cycle ahead as another loses its memory, is confirmed and led home.
        hears_one(&mut tally, StationId(0), 7, 42, true);
        hears_one(&mut tally, StationId(1), 0, 0, false);
        hears_one(&mut tally, StationId(1), 0, 1, true);
        assert_eq!(heard(&mut tally, 8, 0), [1, 1, 1]);
        assert_eq!(heard(&mut tally, 8, 1), [2, 2, 2]);
        assert_eq!(tally.cycles(), 2);
    }

    #[test]
    fn a_new_generation_counts_on_from_what_was_done_before_it() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let mut tally = RunTally::new(&line);
        heard(&mut tally, 7, 40);
        tally.begin(&Header::default());
        assert_eq!(heard(&mut tally, 7, 42), [2, 2, 2]);
        assert_eq!(tally.cycles(), 2);
        // The memory is lost: a new generation begins to count from nothing.
        heard(&mut tally, 8, 0);
        assert_eq!(tally.cycles(), 2);
        assert_eq!(heard(&mut tally, 8, 1), [3, 3, 3]);
        assert_eq!(tally.cycles(), 3);
        let report = tally.station_report(StationId(0), &tally.stations[0]);
        assert_eq!(report["cycles"], 3, "{report}");
    }
}
