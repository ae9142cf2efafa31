//! The plan for what is received now.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use linewright_console_view::permitted;
use linewright_coordinator_cell::AlarmId;
use linewright_coordinator_cell::exception::ExceptionStage;
use linewright_coordinator_cell::texts::recovery;
use linewright_coordinator_logic::ModeStanding;
use linewright_line::{Line, StationId};
use linewright_msgs::{ActivityState, AlarmState, CellState, LineState};
use linewright_node_line::{Confirmation, mode_from_code, report_from_message};
use linewright_recovery::{
    ActivityEnd, DecidedEnd, EndsReached, InterruptedTask, LineSituation, PanelButton, RecoveryAction, RecoveryEnd,
    RecoveryPlan, StandingAlarm, plan,
};

use crate::cell::CellClient;
use crate::client::OperatorClient;
use crate::watch::next_of;

/// Most searches have ended by then, and are waited for.
const AT_ONCE: Duration = Duration::from_millis(20);
/// A situation that changes all the time has no plan.
const SETTLED_WITHIN: Duration = Duration::from_secs(30);

/// A plan, with the reason of each step that needs one.
#[derive(Clone)]
pub struct ReasonedPlan {
    pub plan: RecoveryPlan,
    pub reasons: Vec<Option<String>>,
    /// The stations that a fault signal has stopped, and it is off now.
    pub signals_off: Vec<StationId>,
    /// Whether *return* alone leads home the station whose *advance* comes next.
    pub returns_home: bool,
}

/// The newest plan, with the situation that it was made for: the same situation needs no other search.
///
/// A search may take seconds, in which states have to be received: it is done in a thread, and what it finds is a plan only while the
/// situation is the one that it was made for.
#[derive(Default)]
pub struct NewestPlan {
    known: Option<(LineSituation, ReasonedPlan)>,
    /// Stations that are to be led on.
    lead_on: Vec<StationId>,
    reached: EndsReached,
    /// The search that is under way.
    search: Option<Receiver<(LineSituation, ReasonedPlan)>>,
    /// Since when the plan of what is received is not known; none while it is, or nothing is received to plan for.
    unknown_since: Option<Instant>,
    /// Whether the known plan is that of the situation looked at last.
    is_current: bool,
}

impl ReasonedPlan {
    /// Whether auto is in force.
    pub fn is_done(&self) -> bool {
        self.plan.end == RecoveryEnd::Auto && self.plan.steps.is_empty()
    }
}

/// Looks for the plan of a situation.
fn reasoned(line: &Line, situation: &LineSituation) -> ReasonedPlan {
    let plan = plan(line, situation);
    let reasons = plan.reasons(line, situation).into_iter().map(|why| why.map(|why| why.text(line))).collect();
    let next = plan.behind_signals().map(|at| &plan.steps[at].action);
    let returns_home = match next {
        Some(RecoveryAction::Press(station, PanelButton::Advance)) => plan.returns_home(line, situation, *station),
        _ => false,
    };
    ReasonedPlan { signals_off: situation.signals_off(line), plan, reasons, returns_home }
}

impl NewestPlan {
    /// Plans that lead these stations on, not back.
    pub fn leading_on(lead_on: Vec<StationId>) -> Self {
        NewestPlan { lead_on, ..NewestPlan::default() }
    }

    /// The plan for what is received now, as far as it is known by now: a search goes on beside, and is asked for at the next look. None
    /// also where the coordinator is not received.
    pub fn look(&mut self, client: &OperatorClient, cell: Option<&CellClient>) -> Option<&ReasonedPlan> {
        let mut now = situation_now(client, cell);
        if let Some(situation) = &mut now {
            self.reached.complete(client.line(), situation);
            situation.lead_on.clone_from(&self.lead_on);
        }
        self.take_found(Duration::ZERO);
        self.is_current = self.known.as_ref().map(|(known, _)| known) == now.as_ref();
        let is_wanted = now.is_some();
        if let Some(situation) = now.filter(|_| !self.is_current && self.search.is_none()) {
            let (to, found) = channel();
            let (line, of) = (client.line().clone(), situation.clone());
            thread::spawn(move || drop(to.send((of, reasoned(&line, &situation)))));
            self.search = Some(found);
            self.is_current = self.take_found(AT_ONCE);
        }
        let is_unknown = is_wanted && !self.is_current;
        self.unknown_since = is_unknown.then(|| self.unknown_since.unwrap_or_else(Instant::now));
        self.known.as_ref().filter(|_| self.is_current).map(|(_, found)| found)
    }

    /// Looks until the plan is known, or the coordinator is not received, and receives all the while: what is shown beside the plan has
    /// to be of now as well.
    ///
    /// # Errors
    /// When the middleware has failed.
    pub async fn settle(&mut self, client: &mut OperatorClient, cell: &mut Option<CellClient>) -> miette::Result<()> {
        let end = Instant::now() + SETTLED_WITHIN;
        loop {
            self.look(client, cell.as_ref());
            if self.searching().is_none() || Instant::now() > end {
                return Ok(());
            }
            tokio::select! {
                heard = client.next() => drop(heard?),
                heard = next_of(cell) => heard?,
                () = tokio::time::sleep(AT_ONCE) => {}
            }
        }
    }

    /// For how long the plan of what is received has not been known, over all searches; none where it is known.
    pub fn searching(&self) -> Option<Duration> {
        self.unknown_since.map(|since| since.elapsed())
    }

    /// Takes what a search has found, if it ends within so long: whether there is a plan by it.
    fn take_found(&mut self, within: Duration) -> bool {
        let Some(search) = &self.search else { return false };
        match search.recv_timeout(within) {
            Ok(found) => self.known = Some(found),
            Err(RecvTimeoutError::Timeout) => return false,
            // The search has failed: the plan before is none of this situation.
            Err(RecvTimeoutError::Disconnected) => {
                self.search = None;
                return false;
            }
        }
        self.search = None;
        true
    }

    /// Whether a station moves, as it was received last.
    pub fn moves(&self, station: StationId) -> bool {
        let report = self.known.as_ref().and_then(|(now, _)| now.stations.get(station.index())?.as_ref());
        report.is_some_and(|report| !report.stopped)
    }
}

/// What is received now; none where the coordinator is not received, or was started with another description: what a plan by this one
/// leads to is not known there.
fn situation_now(client: &OperatorClient, cell: Option<&CellClient>) -> Option<LineSituation> {
    if client.other_coordinator().is_some() {
        return None;
    }
    let line = client.line();
    let state = client.coordinator()?;
    let mode = mode_from_code(state.mode).ok()?;
    // A station with another description is the misfit.
    let report = |id| {
        client
            .station(id)
            .and_then(|state| report_from_message((line, state.description), state).ok())
            .map(|(_, report)| report)
    };
    let stations = line.station_ids().map(report).collect();
    let mut situation = LineSituation::read(line, mode, state.enabled, standing(line, state), stations);
    situation.misfit = client.other_station();
    match cell.map(CellClient::heard_lately) {
        Some(Some(cell)) => {
            (situation.alarms, situation.unsettled) = (alarms(line, cell), unsettled(cell));
            situation.interrupted = interrupted(line, cell);
        }
        // What has failed is not known, nor which of its stations belong together.
        Some(None) => situation.unsettled = vec!["the state of the cell is not received".to_owned()],
        None => {}
    }
    Some(situation)
}

fn named(line: &Line, names: &[String]) -> Vec<StationId> {
    names.iter().filter_map(|name| line.station_named(name)).collect()
}

/// What keeps the mode, as the coordinator reports it.
fn standing(line: &Line, state: &LineState) -> ModeStanding {
    ModeStanding {
        is_stopping: state.master_stop,
        is_latched: state.estop_latched,
        is_pressed: state.estop_pressed,
        without_console: state.console_lost,
        resumes: state.resume,
        restarted: named(line, &state.restarted),
        left_out: named(line, &state.left_out),
        obstacles: state.obstacles.to_vec(),
    }
}

fn alarms(line: &Line, cell: &CellState) -> Vec<StandingAlarm> {
    let alarm = |alarm: &AlarmState| StandingAlarm {
        id: alarm.id,
        text: alarm.text.clone(),
        answers: permitted(alarm),
        lead: named(line, &alarm.lead),
        reset: named(line, &alarm.reset),
        at_order: named(line, &alarm.at_order),
        end: led_to(alarm.lead_to).map(|end| DecidedEnd { end, because: alarm.lead_because.clone() }),
        bring: line.station_named(&alarm.bring).and_then(|id| Some((id, line.station(id).rest_named(&alarm.to_rest)?))),
    };
    cell.alarms.as_slice().iter().map(alarm).collect()
}

/// Failed activities that no alarm asks about: their stations are still on the way to rest, or sensors are compared with an answer.
fn unsettled(cell: &CellState) -> Vec<String> {
    let is_asked = |of: &ActivityState| {
        let waits = |alarm: &AlarmState| recovery(Some(&ExceptionStage::Waiting(AlarmId(alarm.id))));
        cell.alarms.as_slice().iter().any(|alarm| of.text.ends_with(&waits(alarm)))
    };
    let failed = cell.activities.as_slice().iter().filter(|of| !of.running && !is_asked(of));
    failed.map(|of| format!("`{}` of part {} {}", of.name, of.part, of.text)).collect()
}

/// The orders that stations are or were at.
fn interrupted(line: &Line, cell: &CellState) -> Vec<InterruptedTask> {
    let activities = cell.activities.as_slice().iter();
    let orders =
        activities.flat_map(|of| of.stations.iter().zip(&of.tasks).zip(&of.numbers).map(move |order| (of, order)));
    let task = |(of, ((station, task), numbers)): (&ActivityState, ((&String, &String), &String))| {
        let station = line.station_named(station)?;
        let task = line.station(station).task_ids().find(|id| line.station(station).task(*id).name == *task)?;
        let numbers = numbers.lines().map(|text| Confirmation::number(text).ok());
        let numbers = numbers.map(|of| of.map(|(name, number)| (name.to_string(), number))).collect::<Option<_>>()?;
        let activity = match of.part {
            0 => format!("`{}`", of.name),
            part => format!("`{}` of part {part}", of.name),
        };
        Some(InterruptedTask { station, task, activity, numbers })
    };
    orders.filter_map(task).collect()
}

/// A code that is not known is no decision.
fn led_to(code: u8) -> Option<ActivityEnd> {
    match code {
        AlarmState::LEAD_ON => Some(ActivityEnd::Done),
        AlarmState::LEAD_BACK => Some(ActivityEnd::TakenBack),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use linewright_msgs::Bounded;

    use super::*;

    #[test]
    fn a_failed_activity_without_an_alarm_is_unsettled() {
        let activity = |id: u64, running, stage: Option<ExceptionStage>| ActivityState {
            id,
            name: "load M1".to_owned(),
            part: 7,
            running,
            text: format!("failed, waits for {}", recovery(stage.as_ref())),
            ..ActivityState::default()
        };
        let waiting = |alarm| activity(1, false, Some(ExceptionStage::Waiting(AlarmId(alarm))));
        let cell = |activities, alarms: &[u64]| CellState {
            activities: Bounded::new(activities).expect("few"),
            alarms: Bounded::new(alarms.iter().map(|&id| AlarmState { id, ..AlarmState::default() }).collect())
                .expect("few"),
            ..CellState::default()
        };
        let securing = || activity(2, false, Some(ExceptionStage::Securing));
        let text = "`load M1` of part 7 failed, waits for its stations to come to rest";
        assert_eq!(unsettled(&cell(vec![securing()], &[])), [text]);
        assert_eq!(unsettled(&cell(vec![waiting(31), securing()], &[3, 31])), [text]);
        assert_eq!(unsettled(&cell(vec![waiting(31)], &[1])).len(), 1);
        assert!(unsettled(&cell(vec![waiting(31), activity(2, true, None)], &[31])).is_empty());
    }

    #[test]
    fn an_order_of_an_activity_has_the_numbers_of_its_task() {
        let text = include_str!("../../../launch-config/lines/workcell-c1/line.toml");
        let line = linewright_line::parse("line.toml", text).expect("it is sound").line;
        let robot = line.station_named("robot").expect("a station");
        let texts = |of: [&str; 2]| of.map(str::to_owned).to_vec();
        let load = ActivityState {
            name: "load M1".to_owned(),
            part: 7,
            stations: texts(["robot", "m1"]),
            tasks: texts(["load m1", "none of its tasks"]),
            numbers: texts(["slot=2", ""]),
            ..ActivityState::default()
        };
        let cell = CellState { activities: Bounded::new(vec![load]).expect("few"), ..CellState::default() };
        let [of] = &interrupted(&line, &cell)[..] else { panic!("one of them is known") };
        let task = line.station(robot).task(of.task).name.as_str();
        assert_eq!((of.station, task, of.activity.as_str()), (robot, "load m1", "`load M1` of part 7"));
        assert_eq!(of.numbers, [("slot".to_owned(), 2)]);
    }
}
