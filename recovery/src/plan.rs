//! The plan: what has to be done first, the commands, the presses in manual between them.

use std::rc::Rc;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{InputId, Line, OpId, StationId};
use linewright_station_logic::StationReport;

use crate::beside;
use crate::bring;
use crate::by_hand;
use crate::desk::Desk;
use crate::ends::{CommonEnds, LedActivity};
use crate::first::{before_all, fault_signals, held, planned};
use crate::grouped::grouped;
use crate::image;
use crate::led_back::{self, LedBack};
use crate::restore::{RestoreMisfit, is_unknown, unit};
use crate::search::{self, Move, Search};
use crate::situation::{LineSituation, StandingAlarm};
use crate::step::{Need, PlannedMotion, RecoveryAction, RecoveryStep, StationAfter};
use crate::units::{PlayedLine, PlayedStations, in_manual};

/// What a plan leads to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecoveryEnd {
    /// Auto is in force after its last step; it is now, where there is none.
    Auto,
    /// After its steps, what is known then shows how to go on.
    LookAgain,
    /// No actions lead to auto: what each station waits for in manual.
    NoWay {
        reasons: Vec<(StationId, Vec<String>)>,
        /// Every state that presses and confirmations lead to was looked at.
        is_certain: bool,
    },
    /// A report does not fit the description.
    Misfit(RestoreMisfit),
}

/// A list of operator actions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoveryPlan {
    pub steps: Vec<RecoveryStep>,
    pub end: RecoveryEnd,
    /// No other list has fewer presses, or as few with less time of motion, in which *return* counts for a little more.
    pub is_shortest: bool,
    /// Auto founds a new generation of counts: no station knows what the others have done to the parts between them.
    pub begins_anew: bool,
    /// Stations that are led back to where their cycle began, which auto then begins anew.
    pub led_back: Vec<LedBack>,
    /// Stations that were to be led on, and no presses lead to auto that way: the steps are those without that.
    pub not_led_on: Vec<StationId>,
    /// Activities of a cell whose stations are led, and to which end of them.
    pub led: Vec<LedActivity>,
    /// States from which all presses were tried.
    pub expanded: usize,
}

impl RecoveryPlan {
    /// A plan of these steps, with nothing else to be known of it.
    pub const fn ends(steps: Vec<RecoveryStep>, end: RecoveryEnd) -> Self {
        RecoveryPlan {
            steps,
            end,
            is_shortest: true,
            begins_anew: false,
            led_back: Vec::new(),
            not_led_on: Vec::new(),
            led: Vec::new(),
            expanded: 0,
        }
    }

    /// Whether a failed activity of a cell has no alarm that could be answered.
    pub fn is_unsettled(&self) -> bool {
        self.steps.iter().any(|step| matches!(step.action, RecoveryAction::First(Need::Settled { .. })))
    }

    /// Whether an alarm of a cell waits for its answer.
    pub fn has_alarms(&self) -> bool {
        self.steps.iter().any(|step| matches!(step.action, RecoveryAction::First(Need::Answer(_))))
    }

    /// The place of its first step behind fault signals.
    pub fn behind_signals(&self) -> Option<usize> {
        self.steps.iter().position(|step| !step.is_fault_signal())
    }

    /// Whether its steps lead to auto, and no alarm waits for the decision of a person.
    pub fn leads_to_auto(&self) -> bool {
        self.end == RecoveryEnd::Auto && !self.has_alarms()
    }

    /// Presses, of panels and of resume, and confirmations in it.
    pub fn presses(&self) -> usize {
        let is_press = |step: &&RecoveryStep| {
            matches!(step.action, RecoveryAction::Press(..) | RecoveryAction::Resume | RecoveryAction::Rejoin { .. })
        };
        self.steps.iter().filter(is_press).count()
    }
}

/// The shortest list of actions from a situation to auto. As long as a failed activity has no alarm, what follows is not known.
pub fn plan(line: &Line, situation: &LineSituation) -> RecoveryPlan {
    let mut found = planned_from(line, situation);
    if matches!(found.end, RecoveryEnd::NoWay { .. }) && !situation.lead_on.is_empty() {
        let without = LineSituation { lead_on: Vec::new(), ..situation.clone() };
        found = planned_from(line, &without);
        found.not_led_on.clone_from(&situation.lead_on);
    }
    found.led_back = led_back::all(line, situation, &found);
    found
}

fn planned_from(line: &Line, situation: &LineSituation) -> RecoveryPlan {
    let (asked, alone) = (situation.asked_to_lead(line), situation.without_journal(line));
    let both = line.station_ids().filter(|id| asked.contains(id) || alone.contains(id)).collect();
    let mut found = planned_now(line, situation, both);
    if matches!(found.end, RecoveryEnd::NoWay { .. }) && !alone.is_empty() {
        found = planned_now(line, situation, asked);
    }
    until_confirmed(line, situation, &mut found);
    let is_away = |id: &StationId| {
        let report = situation.stations.get(id.index()).and_then(Option::as_ref);
        report.is_some_and(|report| !report.stopped || !report.at_home)
    };
    let stations: Vec<StationId> = situation.left_out.iter().copied().filter(is_away).collect();
    let settled = situation.unsettled.iter().map(|activity| RecoveryStep {
        action: RecoveryAction::First(Need::Settled { activity: activity.clone(), stations: stations.clone() }),
        moves: Vec::new(),
        is_doubtful: false,
        mode: situation.mode,
        after: None,
    });
    // In stand-by a station that was stopped on its way back stays where it is: what gives auto comes before the wait.
    let gives_auto = |step: &RecoveryStep| matches!(step.action, RecoveryAction::Command(_));
    let is_first = situation.mode != ControlMode::StandBy || !found.steps.iter().all(gives_auto);
    let at = if is_first { 0 } else { found.steps.len() };
    found.steps.splice(at..at, settled);
    if !situation.unsettled.is_empty() && found.end == RecoveryEnd::Auto {
        found.end = RecoveryEnd::LookAgain;
    }
    found
}

/// A task-driven station without its journal is in a task that is known when a person has confirmed where it stands: what follows is not
/// known before, nor to which end of its activity it is led.
fn until_confirmed(line: &Line, situation: &LineSituation, found: &mut RecoveryPlan) {
    let is_open = |station: StationId| {
        let report = situation.stations.get(station.index()).and_then(Option::as_ref);
        line.station(station).is_task_driven() && report.is_some_and(|report| is_unknown(line.station(station), report))
    };
    let confirms =
        |step: &RecoveryStep| matches!(step.action, RecoveryAction::Rejoin { station, .. } if is_open(station));
    if let Some(last) = found.steps.iter().rposition(confirms) {
        let is_all = found.steps.len() == last + 1;
        found.steps.truncate(last + 1);
        if !is_all {
            found.end = RecoveryEnd::LookAgain;
            found.led.clear();
        }
    }
}

/// `led`: the stations that are led to a rest though the mode does not depend on them.
fn planned_now(line: &Line, situation: &LineSituation, led: Vec<StationId>) -> RecoveryPlan {
    if let Some(station) = situation.misfit {
        return RecoveryPlan::ends(Vec::new(), RecoveryEnd::Misfit(RestoreMisfit(station)));
    }
    let is_in_auto = situation.mode == ControlMode::Auto && situation.enabled;
    if is_in_auto && situation.alarms.is_empty() && led.is_empty() {
        return RecoveryPlan::ends(Vec::new(), RecoveryEnd::Auto);
    }
    let first = |need| RecoveryStep {
        action: RecoveryAction::First(need),
        moves: Vec::new(),
        is_doubtful: false,
        mode: situation.mode,
        after: None,
    };
    let answered = |alarm: &StandingAlarm, is_brought: bool| {
        let bring = alarm.bring.filter(|_| !is_brought).map(|(station, rest)| first(Need::Bring(station, rest)));
        bring.into_iter().chain([first(Need::Answer(alarm.clone()))])
    };
    let answers = |is_brought| situation.alarms.iter().flat_map(move |alarm| answered(alarm, is_brought));
    let mut steps: Vec<RecoveryStep> = before_all(line, situation).into_iter().map(first).collect();
    steps.extend(held(line, situation));
    let heard: Option<Vec<StationReport>> = situation.stations.iter().cloned().collect();
    let Some(mut reports) = heard.filter(|reports| reports.len() == line.stations.len()) else {
        // Their answers say what to do where a station stays away.
        steps.extend(answers(false));
        return RecoveryPlan::ends(steps, RecoveryEnd::LookAgain);
    };
    if is_in_auto && let Some(beside) = beside::plan(line, situation, &led, &reports) {
        steps.extend(beside.steps);
        steps.extend(answers(false));
        return RecoveryPlan { led: beside.led, ..RecoveryPlan::ends(steps, RecoveryEnd::Auto) };
    }
    let is_to_bring = led.is_empty() && situation.alarms.iter().any(|alarm| alarm.bring.is_some());
    if situation.mode == ControlMode::Auto && (!is_in_auto || (led.is_empty() && !is_to_bring)) {
        steps.extend((!is_in_auto).then(|| first(Need::Acknowledged)).into_iter().chain(answers(false)));
        return RecoveryPlan::ends(steps, RecoveryEnd::Auto);
    }
    let halted;
    let situation = if is_in_auto {
        // The others end their tasks, and stand at rests then. Auto could not be left for manual at once without stopping them.
        let action = match situation.is_stopping {
            true => RecoveryAction::First(Need::Halt),
            false => RecoveryAction::Command(ModeCommand::Stop),
        };
        for (id, report) in line.station_ids().zip(&mut reports) {
            if !situation.left_out.contains(&id) {
                image::end_task(line.station(id), report);
            }
        }
        let mode = match led.is_empty() && reports.iter().all(|report| report.at_home) {
            true => ControlMode::Home,
            false => ControlMode::StandBy,
        };
        steps.push(RecoveryStep { mode, action, ..first(Need::Halt) });
        let left_out = line.station_ids().collect();
        halted = LineSituation { mode, left_out, ..situation.clone() };
        &halted
    } else {
        situation
    };
    let resets = situation.alarms.iter().flat_map(|alarm| &alarm.reset);
    steps.extend(resets.map(|&station| first(Need::Reset(station))));
    for (id, report) in line.station_ids().zip(&mut reports) {
        let faults = fault_signals(line.station(id), report);
        for input in faults {
            steps.push(first(Need::FaultSignal(id, input)));
            report.measured &= !input.bit();
        }
    }
    // Each axis that has to be put back by hand is one more round.
    let mut axes = Vec::new();
    loop {
        let units: Result<PlayedStations, RestoreMisfit> =
            line.station_ids().zip(&reports).map(|(id, report)| unit(line, id, report).map(Rc::new)).collect();
        let units = match units {
            Ok(units) => units,
            Err(misfit) => return RecoveryPlan::ends(steps, RecoveryEnd::Misfit(misfit)),
        };
        let lost: Vec<(StationId, OpId, InputId)> = line
            .station_ids()
            .zip(&units)
            .filter_map(|(id, unit)| unit.controller.position_lost().map(|(op, input)| (id, op, input)))
            .filter(|&(id, op, _)| line.station(id).index_of(op).is_none())
            .collect();
        let brought = Some(&units).filter(|_| is_to_bring).and_then(|units| brought(line, situation, units));
        let mut found = brought.unwrap_or_else(|| by_commands_and_presses(line, situation, &led, units));
        let is_open = matches!(found.end, RecoveryEnd::NoWay { .. });
        let unplaced = || {
            line.station_ids().find_map(|id| by_hand::unplaced(line, id, &reports).map(|(op, input)| (id, op, input)))
        };
        if is_open
            && let Some((station, op, input)) = lost.first().copied().or_else(unplaced)
            && axes.len() < line.stations.len() * 4
        {
            axes.push(first(by_hand::need(line, (station, op, input), &reports)));
            let report = &mut reports[station.index()];
            report.measured = image::put_onto(line.station(station), report.measured, input.bit());
            report.position_lost = (lost.iter().filter(|lost| lost.0 == station).count() > 1).then_some((op, input));
            continue;
        }
        steps.append(&mut axes);
        let is_brought = found.steps.iter().any(|step| matches!(step.action, RecoveryAction::Hold { .. }));
        // Answered when what they ask for is done, and a resource is led to a rest by then.
        let last = found.steps.len() - usize::from(found.end == RecoveryEnd::Auto && !found.steps.is_empty());
        // A station that still has an order ends it in auto.
        let (before, after): (Vec<_>, Vec<_>) =
            situation.alarms.iter().partition(|of: &&StandingAlarm| of.at_order.is_empty());
        // Where its stations cannot be led, there is no answer to it yet.
        let is_led = |alarm: &&StandingAlarm| !is_open || !alarm.lead.iter().any(|id| led.contains(id));
        found.steps.splice(last..last, before.into_iter().filter(is_led).flat_map(|alarm| answered(alarm, is_brought)));
        found.steps.extend(after.into_iter().filter(is_led).flat_map(|alarm| answered(alarm, is_brought)));
        steps.append(&mut found.steps);
        return RecoveryPlan { steps, ..found };
    }
}

/// Stations at rests where nothing begins are brought to others in hand mode.
fn brought(line: &Line, situation: &LineSituation, units: &PlayedStations) -> Option<RecoveryPlan> {
    let floor = PlayedLine::new(line, units);
    let mut units = units.clone();
    floor.meet(&mut units);
    let begins_anew = search::begins_anew(line, &units);
    let way = bring::in_hand(&floor, situation, Desk::new(&floor, situation, units))?;
    Some(RecoveryPlan { begins_anew, ..RecoveryPlan::ends(in_hand(line, way), RecoveryEnd::Auto) })
}

/// The steps of a way in hand mode.
fn in_hand(line: &Line, way: bring::WayInHand) -> Vec<RecoveryStep> {
    let held = |of: bring::HeldButton| {
        let moved =
            |&(id, place): &(StationId, StationPlace)| planned(line, id, place, of.after[id.index()].report.measured);
        RecoveryStep {
            moves: of.motions.iter().map(moved).collect(),
            action: RecoveryAction::Hold { button: of.button, station: of.station, rest: of.rest },
            is_doubtful: false,
            mode: ControlMode::Hand,
            after: None,
        }
    };
    let all = |way: &[(ModeCommand, Desk)]| -> Vec<RecoveryStep> {
        way.iter().map(|(command, desk)| commanded(*command, desk)).collect()
    };
    let (mut steps, to_auto) = (all(&way.to_hand), all(&way.to_auto));
    steps.extend(way.held.into_iter().map(held));
    steps.extend(to_auto);
    steps
}

/// `led`: stations that an alarm asks to be led to a rest, though the mode does not depend on them.
pub(crate) fn by_commands_and_presses(
    line: &Line,
    situation: &LineSituation,
    led: &[StationId],
    units: PlayedStations,
) -> RecoveryPlan {
    let floor = PlayedLine::new(line, &units);
    let mut units = units;
    floor.meet(&mut units);
    // Before the desk plays the commands that led to the mode: with all at home one of them may found a generation.
    let begins_anew = search::begins_anew(line, &units);
    let desk = Desk::new(&floor, situation, units);
    let mut steps = Vec::new();
    if let Some(way) = desk.way_to(&floor, ControlMode::Auto).filter(|_| led.is_empty()) {
        steps.extend(way.iter().map(|(command, desk)| commanded(*command, desk)));
        return RecoveryPlan { begins_anew, ..RecoveryPlan::ends(steps, RecoveryEnd::Auto) };
    }
    let Some(way) = desk.way_to(&floor, ControlMode::Manual) else {
        return RecoveryPlan::ends(steps, no_way(line, &desk.units, true));
    };
    steps.extend(way.iter().map(|(command, desk)| commanded(*command, desk)));
    let mut desk = way.into_iter().last().map_or(desk, |(_, desk)| desk);
    let by_selectors = desk.units.iter().any(|unit| unit.report.selector_manual);
    for at in 0..desk.units.len() {
        let epoch = desk.units[at].report.mode_epoch;
        floor.order(&mut desk.units, at, in_manual(epoch));
    }
    let led_to = |units: &PlayedStations| {
        let mut desk = desk.clone();
        desk.units.clone_from(units);
        desk.settle(&floor);
        let at_manual = |unit: &usize| units[*unit].report.selector_manual;
        for station in (0..units.len()).filter(at_manual) {
            desk.turn_selector(&floor, StationId::at(station), false);
        }
        desk
    };
    let accepted = |units: &PlayedStations| led_to(units).way_to(&floor, ControlMode::Auto).is_some();
    // Where selectors have led to manual the panels are not the console's.
    let stay: Vec<StationId> = situation.left_out.iter().copied().filter(|id| !led.contains(id)).collect();
    let ends = CommonEnds::of(line, situation, led);
    let search = |kept| Search::new(&floor, (&stay, situation), !by_selectors, (&ends, kept), &accepted);
    let (all_kept, mut failed) = (ends.kept(), Vec::new());
    let way = all_kept.iter().find_map(|kept| {
        let search = search(kept);
        let mut found = search.run(&desk.units).map_err(|none| failed.push(none)).ok()?;
        found.moves = grouped(&search, &desk.units, found.moves);
        Some((kept, found))
    });
    let is_certain = failed.iter().all(|none| none.is_certain);
    let Some((kept, found)) = way else {
        let expanded = failed.last().map_or(0, |none| none.expanded);
        return RecoveryPlan { expanded, ..RecoveryPlan::ends(steps, no_way(line, &desk.units, is_certain)) };
    };
    let last = found.moves.last().map_or_else(|| desk.units.clone(), |last| last.after.clone());
    steps.extend(pressed(line, &desk.units, &found.moves, by_selectors));
    let mut turned: Vec<StationId> =
        line.station_ids().filter(|id| desk.units[id.index()].report.selector_manual).collect();
    turned.extend(steps.iter().filter_map(|step| match step.action {
        RecoveryAction::Selector(station, true) => Some(station),
        _ => None,
    }));
    for (at, &station) in turned.iter().enumerate() {
        let mode = if at + 1 == turned.len() { ControlMode::StandBy } else { ControlMode::Manual };
        let action = match desk.wired_at_manual(line, station) {
            Some(input) => RecoveryAction::First(Need::Selector(station, input)),
            None => RecoveryAction::Selector(station, false),
        };
        steps.push(RecoveryStep { action, moves: Vec::new(), is_doubtful: false, mode, after: None });
    }
    let desk = led_to(&last);
    let to_auto = desk.way_to(&floor, ControlMode::Auto);
    match bring::in_hand(&floor, situation, desk) {
        Some(way) => steps.extend(in_hand(line, way)),
        None => steps.extend(to_auto.into_iter().flatten().map(|(command, desk)| commanded(command, &desk))),
    }
    RecoveryPlan {
        is_shortest: found.is_shortest && is_certain,
        begins_anew: search::begins_anew(line, &last),
        led: ends.led(&last, kept, is_certain),
        expanded: found.expanded,
        ..RecoveryPlan::ends(steps, RecoveryEnd::Auto)
    }
}

fn commanded(command: ModeCommand, after: &Desk) -> RecoveryStep {
    let action = RecoveryAction::Command(command);
    RecoveryStep { action, moves: Vec::new(), is_doubtful: false, mode: after.mode(), after: None }
}

/// The moves as steps. Where selectors have led to manual, the others' panels may need theirs too.
fn pressed(line: &Line, before: &PlayedStations, moves: &[Move], by_selectors: bool) -> Vec<RecoveryStep> {
    let mut steps = Vec::new();
    let mut live: Vec<bool> = before.iter().map(|unit| !by_selectors || unit.report.selector_manual).collect();
    for made in moves {
        let motion = |&(station, place): &(StationId, StationPlace)| {
            let motion = planned(line, station, place, made.after[station.index()].report.measured);
            let time = if made.homes { line.operation((station, place.op)).watchdog } else { motion.time };
            PlannedMotion { homes: made.homes, time, ..motion }
        };
        let planned = made.motions.iter().map(motion).collect();
        let Some(station) = made.action.station() else {
            let mode = ControlMode::Manual;
            let action = made.action.clone();
            steps.push(RecoveryStep { action, moves: planned, is_doubtful: false, mode, after: None });
            continue;
        };
        let is_press = matches!(made.action, RecoveryAction::Press(..));
        if is_press && !std::mem::replace(&mut live[station.index()], true) {
            let action = RecoveryAction::Selector(station, true);
            let mode = ControlMode::Manual;
            steps.push(RecoveryStep { action, moves: Vec::new(), is_doubtful: false, mode, after: None });
        }
        let described = line.station(station);
        let unit = &made.after[station.index()];
        let after = StationAfter {
            station,
            places: unit.controller.marking().collect(),
            at_home: unit.report.at_home,
            is_in_order: unit.is_in_order(described.is_task_driven()),
        };
        steps.push(RecoveryStep {
            action: made.action.clone(),
            moves: planned,
            is_doubtful: made.is_doubtful,
            mode: ControlMode::Manual,
            after: Some(after),
        });
    }
    steps
}

fn no_way(line: &Line, units: &PlayedStations, is_certain: bool) -> RecoveryEnd {
    let waits = |(id, unit): (StationId, &Rc<crate::units::PlayedStation>)| {
        let reasons = unit.controller.blocked_by(line, crate::units::NOW);
        let is_in_order = unit.is_in_order(line.station(id).is_task_driven());
        // Without counts in common, what is not at home is in the way too.
        (!is_in_order || !unit.report.at_home).then_some((id, reasons))
    };
    RecoveryEnd::NoWay { reasons: line.station_ids().zip(units).filter_map(waits).collect(), is_certain }
}
