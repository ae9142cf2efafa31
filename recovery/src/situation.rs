//! What is known of a line when a plan is made.

use std::time::Duration;

use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_coordinator_logic::ModeStanding;
use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, OpId, Parameter, RestId, StationId, TaskId};
use linewright_station_logic::{StationReport, StopCause};

use crate::first::fault_signals;
use crate::restore::is_unknown;

/// State of the console's devices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConsoleSituation {
    #[default]
    Heard,
    /// Its emergency stop button is pressed.
    ButtonPressed,
    /// Its devices are not operational, or were never heard.
    Lost,
}

/// A way out of the tasks of an activity that was stopped half-way: an activity is done at every station, or at none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActivityEnd {
    /// Every station goes on to the end of its task.
    Done,
    /// Every station goes back to where its task began.
    TakenBack,
}

/// The end to which the stations of an alarm have to be led.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecidedEnd {
    pub end: ActivityEnd,
    /// Why, e.g. a station that has completed its order.
    pub because: String,
}

/// An alarm of a cell that waits for its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StandingAlarm {
    pub id: u64,
    /// What has happened, and what to do.
    pub text: String,
    /// What can be answered, when it is done.
    pub answers: Vec<ListedAnswer>,
    /// Stations that are to be led to a rest by hand before that.
    pub lead: Vec<StationId>,
    /// Those of them that are in emergency stop by themselves, to be reset before they are led.
    pub reset: Vec<StationId>,
    /// Stations that end an order of what has failed by themselves, in auto: before that no answer is taken.
    pub at_order: Vec<StationId>,
    /// Which way; none where either will do, for all of them alike.
    pub end: Option<DecidedEnd>,
    /// The station that is to be brought to another rest in hand mode before that, and the rest.
    pub bring: Option<(StationId, RestId)>,
}

/// A task that a station was ordered to do for an activity of a cell that is not over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InterruptedTask {
    pub station: StationId,
    pub task: TaskId,
    /// The activity with its part, e.g. `` `load M1` of part 7 ``.
    pub activity: String,
    /// The numbers of the order, by the names of the task's parameters.
    pub numbers: Vec<(String, i32)>,
}

impl InterruptedTask {
    /// The number of a parameter; none where the order has no such number, or one that does not fit its outputs.
    pub(crate) fn number(&self, of: &Parameter) -> Option<i32> {
        let (_, number) = self.numbers.iter().find(|(name, _)| *name == of.name)?;
        (0..=of.most()).contains(number).then_some(*number)
    }
}

/// A situation of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSituation {
    pub mode: ControlMode,
    /// Every station has acknowledged it.
    pub enabled: bool,
    /// Master stop was given: in auto, the line halts at home.
    pub is_stopping: bool,
    /// The emergency stop has been reset, or there is none.
    pub is_reset: bool,
    /// Resume is held at the console.
    pub resumes: bool,
    pub console: ConsoleSituation,
    /// Stations that were restarted and have not been looked at since.
    pub restarted: Vec<StationId>,
    /// Task-driven stations that the mode does not depend on: an alarm of their cell asks about them, or they are out of service.
    pub left_out: Vec<StationId>,
    pub alarms: Vec<StandingAlarm>,
    /// Failed activities of a cell that have no alarm yet, or none any more, and what they wait for, in words.
    pub unsettled: Vec<String>,
    /// The orders of a cell that stations were at, as its coordinator has them: of a station without its journal they tell which task it was
    /// in, and for what.
    pub interrupted: Vec<InterruptedTask>,
    /// What else keeps every mode from being given, in words: a second coordinator, a journal that cannot be written.
    pub obstacles: Vec<String>,
    /// Stations that may not be led back. A person has seen where their part is, which no state shows.
    pub lead_on: Vec<StationId>,
    /// A station whose node runs with another description.
    pub misfit: Option<StationId>,
    /// By station; none where it is not heard.
    pub stations: Vec<Option<StationReport>>,
}

impl LineSituation {
    /// A situation in which nothing is amiss but what the stations report.
    pub fn of(line: &Line, mode: ControlMode, stations: Vec<Option<StationReport>>) -> Self {
        debug_assert_eq!(stations.len(), line.stations.len());
        LineSituation {
            mode,
            enabled: true,
            is_stopping: false,
            is_reset: false,
            resumes: false,
            console: ConsoleSituation::Heard,
            restarted: Vec::new(),
            left_out: Vec::new(),
            alarms: Vec::new(),
            unsettled: Vec::new(),
            interrupted: Vec::new(),
            obstacles: Vec::new(),
            lead_on: Vec::new(),
            misfit: None,
            stations,
        }
    }

    /// A situation as the state of the line and those of the stations show it: the mode, whether every station has
    /// acknowledged it, and what keeps it.
    pub fn read(
        line: &Line,
        mode: ControlMode,
        enabled: bool,
        standing: ModeStanding,
        mut stations: Vec<Option<StationReport>>,
    ) -> Self {
        for report in stations.iter_mut().flatten() {
            // It differs in every state, and no plan follows from it: the same situation is to compare as equal.
            report.measured_age = Duration::ZERO;
        }
        let console = match (standing.without_console, standing.is_pressed) {
            (true, _) => ConsoleSituation::Lost,
            (false, true) => ConsoleSituation::ButtonPressed,
            (false, false) => ConsoleSituation::Heard,
        };
        let ModeStanding { is_stopping, is_latched, resumes, restarted, left_out, obstacles, .. } = standing;
        LineSituation {
            enabled,
            is_stopping,
            is_reset: !is_latched,
            resumes,
            console,
            restarted,
            left_out,
            obstacles,
            ..LineSituation::of(line, mode, stations)
        }
    }

    /// The stations of which an operation was stopped by a fault signal, and no such signal is on now.
    pub fn signals_off(&self, line: &Line) -> Vec<StationId> {
        let was_stopped =
            |report: &StationReport| report.incomplete.iter().any(|(_, cause)| *cause == StopCause::Signal);
        let is_off = |id: &StationId| {
            let report = self.stations.get(id.index()).and_then(Option::as_ref);
            report.is_some_and(|of| {
                of.devices_valid && was_stopped(of) && fault_signals(line.station(*id), of).is_empty()
            })
        };
        line.station_ids().filter(is_off).collect()
    }

    /// The stations that alarms ask to be led to a rest by hand and that are not there.
    pub(crate) fn asked_to_lead(&self, line: &Line) -> Vec<StationId> {
        let asks = |id: &StationId| self.alarms.iter().any(|alarm| alarm.lead.contains(id));
        let is_away =
            |report: &StationReport| !report.at_home || !report.incomplete.is_empty() || report.position_lost.is_some();
        let is_to_be = |id: &StationId| asks(id) && self.report(*id).is_some_and(is_away);
        line.station_ids().filter(is_to_be).collect()
    }

    /// The stations that are left out since they were started without their journal, of which no alarm asks: without an activity none is
    /// raised, and nothing begins at them. Others that are left out and stand away from a rest may work, or be in repair.
    pub(crate) fn without_journal(&self, line: &Line) -> Vec<StationId> {
        let asks =
            |id: &StationId| self.alarms.iter().any(|alarm| alarm.lead.contains(id) || alarm.at_order.contains(id));
        let is_lost = |id: &StationId| {
            let report = self.report(*id).filter(|report| report.stopped);
            report.is_some_and(|report| is_unknown(line.station(*id), report))
        };
        let is_alone = |id: &StationId| self.left_out.contains(id) && !asks(id) && is_lost(id);
        line.station_ids().filter(|id| self.unsettled.is_empty() && is_alone(id)).collect()
    }

    fn report(&self, id: StationId) -> Option<&StationReport> {
        self.stations.get(id.index())?.as_ref()
    }
}

/// The part of a report that its message has, for simulations whose consoles receive none: the switches of a doubt are not in it,
/// and no order.
pub fn as_received(report: StationReport) -> StationReport {
    StationReport { position_lost: report.position_lost.map(|_| (OpId(0), InputId(0))), order: None, ..report }
}
