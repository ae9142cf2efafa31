//! The plan as a JSON object, for programs. Its form is in `docs/recover.md`.

use std::collections::BTreeMap;

use linewright_console_view::AnswerJson;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::Block;
use linewright_line::{Line, OperationModule};
use linewright_recovery::{
    ActivityEnd, LedActivity, LedBack, Need, PlannedMotion, RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep,
};
use serde::Serialize;

use super::newest::ReasonedPlan;
use crate::client::OperatorClient;
use crate::states::ModeJson;

/// A plan.
#[derive(Serialize)]
pub struct RecoveryJson {
    line: String,
    mode: Option<ModeJson>,
    not_heard: Vec<String>,
    /// `auto`, `look again`, `no way`; null where the coordinator is not heard, or was started with another description.
    end: Option<&'static str>,
    /// What is to be known of the list and its end.
    remarks: Vec<String>,
    /// Faults that stand, as their stations report them.
    causes: Vec<CauseJson>,
    shortest: bool,
    /// Activities of a cell whose stations are led.
    activities: Vec<LedJson>,
    /// Stations that are led back to where their cycle began, which auto begins anew.
    led_back: Vec<LedBackJson>,
    steps: Vec<StepJson>,
}

/// To which end the stations of an activity are led.
#[derive(Serialize)]
struct LedJson {
    alarm: u64,
    stations: Vec<String>,
    /// `done`, `taken back`; null where they end differently.
    end: Option<&'static str>,
    text: String,
}

impl LedJson {
    fn of(line: &Line, led: &LedActivity) -> Self {
        let end = |end| match end {
            ActivityEnd::Done => "done",
            ActivityEnd::TakenBack => "taken back",
        };
        LedJson {
            alarm: led.alarm,
            stations: led.stations.iter().map(|id| line.station(*id).name.clone()).collect(),
            end: led.end.map(end),
            text: led.text(line),
        }
    }
}

/// A station that is led back, and its other way.
#[derive(Serialize)]
struct LedBackJson {
    station: String,
    /// How many presses of advance lead it on instead; null where advance alone does not.
    presses_on: Option<usize>,
    text: String,
    /// The arguments of `linewright` that list the other way; null where *advance* alone does not lead on.
    arguments: Option<Vec<String>>,
}

impl LedBackJson {
    fn of(line: &Line, path: &str, back: &LedBack) -> Self {
        LedBackJson {
            station: line.station(back.station).name.clone(),
            presses_on: back.presses_on,
            text: back.text(line),
            arguments: back.presses_on.map(|_| super::led_on(line, path, back)),
        }
    }
}

/// A fault of a station.
#[derive(Serialize)]
struct CauseJson {
    station: String,
    text: String,
    /// It was a loss of devices, and they are there again.
    over: bool,
}

/// One of its steps.
#[derive(Serialize)]
struct StepJson {
    kind: &'static str,
    text: String,
    /// Why it is there; null of a press alone that leads on.
    reason: Option<String>,
    station: Option<String>,
    /// `advance` or `return`; of a selector `manual` or `auto`.
    button: Option<&'static str>,
    /// Of the mode.
    command: Option<&'static str>,
    moves: Vec<MotionJson>,
    /// The mode after it.
    mode: &'static str,
    /// By operation, the number of its marked place after it, 1 to 6.
    places: Option<BTreeMap<String, u8>>,
    at_home: Option<bool>,
    /// The arguments of `linewright` that do it; null where no command does, or one of several.
    arguments: Option<Vec<String>>,
    /// Of several commands the arguments of each; one is given, by what is so at the machine.
    choices: Vec<Vec<String>>,
    /// For a position of which one of several is confirmed: how the station stands in each, in the order of `choices`.
    stands: Vec<String>,
    /// For a step that answers an alarm: each permitted answer with its meaning and verdict, in the order of `choices`.
    answers: Vec<AnswerJson>,
}

#[derive(Serialize)]
struct MotionJson {
    station: String,
    operation: String,
    undoing: bool,
    axis: String,
    /// A position; of an index the number of the place, null where none is known.
    to: Option<f64>,
    /// The drive of the index is homed.
    homes: bool,
    /// The switch that it waits for.
    until: String,
    seconds: f64,
}

impl MotionJson {
    fn of(line: &Line, motion: &PlannedMotion) -> Self {
        let station = line.station(motion.station);
        let operation = line.operation((motion.station, motion.place.op));
        let undoing = motion.place.block == Block::Recovery;
        let signals = match &operation.module {
            OperationModule::Reversible { recovery, .. } if undoing => *recovery,
            OperationModule::Reversible { .. } | OperationModule::Irreversible { .. } => operation.normal,
        };
        MotionJson {
            station: station.name.clone(),
            operation: operation.name.clone(),
            undoing,
            axis: station.axes[operation.motion.axis.index()].name.clone(),
            to: match station.index_of(motion.place.op) {
                Some(_) => motion.to_place.map(f64::from),
                None => Some(if undoing { operation.motion.from } else { operation.motion.to }),
            },
            homes: motion.homes,
            until: station.inputs[signals.complete.index()].clone(),
            seconds: motion.time.as_secs_f64(),
        }
    }
}

impl StepJson {
    fn of(line: &Line, path: &str, (step, reason): (&RecoveryStep, &Option<String>)) -> Self {
        let (kind, button, command) = match &step.action {
            RecoveryAction::First(Need::Answer(_)) => ("answer", None, None),
            RecoveryAction::First(_) => ("first", None, None),
            RecoveryAction::Command(command) => ("command", None, Some(command.name())),
            RecoveryAction::ManualAlone(_) => ("manual_alone", None, Some(ModeCommand::Manual.name())),
            RecoveryAction::AutoAgain(_) => ("auto_again", None, Some(ModeCommand::Auto.name())),
            RecoveryAction::Press(_, button) => ("press", Some(button.name()), None),
            RecoveryAction::Hold { .. } => ("hold", None, None),
            RecoveryAction::Resume => ("resume", None, None),
            RecoveryAction::Selector(_, manual) => ("selector", Some(if *manual { "manual" } else { "auto" }), None),
            RecoveryAction::Rejoin { .. } => ("rejoin", None, None),
        };
        let mut commands = super::commands(line, path, step);
        let arguments = if commands.len() == 1 { commands.pop() } else { None };
        let places = |after: &linewright_recovery::StationAfter| {
            let name = |place: &linewright_line::net::StationPlace| {
                (line.operation((after.station, place.op)).name.clone(), place.number())
            };
            after.places.iter().map(name).collect()
        };
        StepJson {
            kind,
            text: step.text(line),
            reason: reason.clone(),
            station: step.action.station().map(|id| line.station(id).name.clone()),
            button,
            command,
            moves: step.moves.iter().map(|motion| MotionJson::of(line, motion)).collect(),
            mode: step.mode.name(),
            places: step.after.as_ref().map(places),
            at_home: step.after.as_ref().map(|after| after.at_home),
            arguments,
            choices: commands,
            stands: step.stands(line),
            answers: match &step.action {
                RecoveryAction::First(Need::Answer(alarm)) => alarm.answers.iter().map(AnswerJson::from).collect(),
                _ => Vec::new(),
            },
        }
    }
}

impl RecoveryJson {
    /// The plan for a line in the directory `path`; none where its coordinator is not heard.
    pub fn of(client: &OperatorClient, path: &str, found: Option<&ReasonedPlan>) -> Self {
        let plan = found.map(|found| &found.plan);
        let line = client.line();
        let end = |plan: &RecoveryPlan| match plan.end {
            RecoveryEnd::Auto => "auto",
            RecoveryEnd::LookAgain => "look again",
            RecoveryEnd::NoWay { .. } | RecoveryEnd::Misfit(_) => "no way",
        };
        RecoveryJson {
            line: line.name.clone(),
            mode: client.coordinator().map(ModeJson::of),
            not_heard: client.unheard().map(str::to_owned).collect(),
            end: plan.map(end),
            remarks: plan.map_or_else(
                || client.other_descriptions(),
                |plan| plan.begin_text(line).into_iter().chain(plan.end_text(line)).collect(),
            ),
            causes: super::causes(line, |id| client.station(id))
                .into_iter()
                .map(|(station, state)| {
                    let (text, over) = (state.fault.clone(), super::is_over_again(state));
                    CauseJson { station: station.to_owned(), text, over }
                })
                .collect(),
            shortest: plan.is_some_and(|plan| plan.is_shortest),
            activities: plan
                .map(|plan| plan.led.iter().map(|led| LedJson::of(line, led)).collect())
                .unwrap_or_default(),
            led_back: plan
                .map(|plan| plan.led_back.iter().map(|back| LedBackJson::of(line, path, back)).collect())
                .unwrap_or_default(),
            steps: found
                .map(|found| {
                    let steps = found.plan.steps.iter().zip(&found.reasons);
                    steps.map(|step| StepJson::of(line, path, step)).collect()
                })
                .unwrap_or_default(),
        }
    }
}
