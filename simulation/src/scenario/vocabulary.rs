//! The words of a scenario: operations, buttons, conditions, by the names of the line.
//!
//! An operation is `station: operation`, as in a description's arrows. A condition is one or more clauses joined by
//! ` and `; a clause compares (`cycles >= 3`) or states what something is (`clamp_1 is incomplete`).

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{HolderId, InputId, Line, OpId, StationId};
use linewright_plant::NestPosition;
use linewright_text::{LocatedName, Problem, Report, TextRange, suggestion};

use crate::condition::{Compare, OperationCondition, ScenarioCondition, StationCondition};
use crate::operator::{MotionSelection, NodeProcess};

/// A word and its place.
type ScenarioWord<'a> = (&'a str, TextRange);

fn of(name: &LocatedName) -> ScenarioWord<'_> {
    (&name.value, name.at.clone())
}

fn one_of<T: Copy>(known: &[(&str, T)], what: &str, (word, at): ScenarioWord<'_>, report: &mut Report) -> Option<T> {
    let found = known.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
    if found.is_none() {
        let hint = suggestion(word, known.iter().map(|(name, _)| *name));
        report.add(Problem::error(at, format!("unknown {what} `{word}`")).maybe_hint(hint));
    }
    found
}

pub(super) fn command(name: &LocatedName, report: &mut Report) -> Option<ModeCommand> {
    one_of(&ModeCommand::ALL.map(|command| (command.name(), command)), "command", of(name), report)
}

pub(super) fn way(name: &LocatedName, report: &mut Report) -> Option<MotionSelection> {
    let known =
        [("normal", MotionSelection::Normal), ("recovery", MotionSelection::Recovery), ("both", MotionSelection::Both)];
    one_of(&known, "motion", of(name), report)
}

fn station(line: &Line, word: ScenarioWord<'_>, report: &mut Report) -> Option<StationId> {
    let known: Vec<(&str, StationId)> = line.station_ids().map(|id| (line.station(id).name.as_str(), id)).collect();
    one_of(&known, "station", word, report)
}

/// The two sides of `station: something`, each with its place.
fn sides<'a>(
    (text, at): ScenarioWord<'a>,
    what: &str,
    report: &mut Report,
) -> Option<(ScenarioWord<'a>, ScenarioWord<'a>)> {
    let Some((left, right)) = text.split_once(':') else {
        report.add(Problem::error(at, format!("`{text}` names no {what}")).hint(format!("write `station: {what}`")));
        return None;
    };
    Some((within(text, &at, left), within(text, &at, right)))
}

/// A part of a text, trimmed, with its place in the file; `at` includes the quotes.
fn within<'a>(text: &str, at: &TextRange, part: &'a str) -> ScenarioWord<'a> {
    let trimmed = part.trim();
    // An escape in the text moves everything behind it; the whole is then close enough.
    if at.len() != text.len() + 2 {
        return (trimmed, at.clone());
    }
    let start = at.start + 1 + (trimmed.as_ptr() as usize - text.as_ptr() as usize);
    (trimmed, start..start + trimmed.len())
}

pub(super) fn operation(line: &Line, name: &LocatedName, report: &mut Report) -> Option<(StationId, OpId)> {
    operation_in(line, of(name), report)
}

fn operation_in(line: &Line, text: ScenarioWord<'_>, report: &mut Report) -> Option<(StationId, OpId)> {
    let (left, right) = sides(text, "operation", report)?;
    let id = station(line, left, report)?;
    let described = line.station(id);
    let known: Vec<(&str, OpId)> =
        described.op_ids().map(|op| (described.operations[op.index()].name.as_str(), op)).collect();
    Some((id, one_of(&known, "operation", right, report)?))
}

pub(super) fn panel(line: &Line, name: &LocatedName, report: &mut Report) -> Option<(StationId, bool)> {
    let (left, right) = sides(of(name), "advance", report)?;
    let side = one_of(&[("advance", true), ("return", false)], "panel button", right, report);
    Some((station(line, left, report)?, side?))
}

pub(super) fn selector(line: &Line, name: &LocatedName, report: &mut Report) -> Option<(StationId, bool)> {
    let (left, right) = sides(of(name), "manual", report)?;
    let side = one_of(&[("manual", true), ("auto", false)], "selector position", right, report);
    Some((station(line, left, report)?, side?))
}

pub(super) fn button(line: &Line, name: &LocatedName, report: &mut Report) -> Option<usize> {
    let known: Vec<(&str, usize)> = line.buttons.iter().enumerate().map(|(at, button)| (button.as_str(), at)).collect();
    one_of(&known, "hand-mode button", of(name), report)
}

pub(super) fn input(line: &Line, name: &LocatedName, report: &mut Report) -> Option<(Option<StationId>, InputId)> {
    let (left, right) = sides(of(name), "input", report)?;
    let owner = if left.0 == "console" { None } else { Some(station(line, left, report)?) };
    let inputs = owner.map_or(&line.console.inputs, |id| &line.station(id).inputs);
    let known: Vec<(&str, InputId)> =
        inputs.iter().enumerate().map(|(at, input)| (input.as_str(), InputId::at(at))).collect();
    Some((owner, one_of(&known, "input", right, report)?))
}

/// The input that a text names, if it names one and no operation.
pub(super) fn known_input(line: &Line, name: &LocatedName) -> Option<(Option<StationId>, InputId)> {
    let mut unread = Report::default();
    if operation(line, name, &mut unread).is_some() {
        return None;
    }
    input(line, name, &mut unread)
}

/// A place of parts: the name of a holder, and behind a colon the position where it has several.
pub(super) fn place(line: &Line, name: &LocatedName, report: &mut Report) -> Option<NestPosition> {
    let (text, at) = of(name);
    let (holder, position) = text.rsplit_once(':').unwrap_or((text, "1"));
    let holders = line.handling.holders.iter().enumerate();
    let known: Vec<(&str, HolderId)> = holders.map(|(id, holder)| (holder.name.as_str(), HolderId::at(id))).collect();
    let nest = one_of(&known, "place for parts", within(text, &at, holder), report)?;
    let Ok(position) = position.trim().parse() else {
        let message = format!("`{}` is no position", position.trim());
        let hint = format!("write `{}: 1`, or the name alone", holder.trim());
        report.add(Problem::error(at, message).hint(hint));
        return None;
    };
    Some(NestPosition { nest, position })
}

pub(super) fn device(line: &Line, name: &LocatedName, report: &mut Report) -> Option<usize> {
    let known: Vec<(&str, usize)> =
        line.devices.iter().enumerate().map(|(at, device)| (device.name.as_str(), at)).collect();
    one_of(&known, "device", of(name), report)
}

pub(super) fn process(line: &Line, name: &LocatedName, report: &mut Report) -> Option<NodeProcess> {
    let stations = line.station_ids().map(|id| (line.station(id).name.as_str(), NodeProcess::Station(id)));
    let known: Vec<(&str, NodeProcess)> = stations.chain([("coordinator", NodeProcess::Coordinator)]).collect();
    one_of(&known, "process", of(name), report)
}

pub(super) fn condition(line: &Line, name: &LocatedName, report: &mut Report) -> Option<ScenarioCondition> {
    let (text, at) = of(name);
    let clauses: Vec<Option<ScenarioCondition>> =
        clauses(line, text).into_iter().map(|part| clause(line, within(text, &at, part), report)).collect();
    let mut clauses: Vec<ScenarioCondition> = clauses.into_iter().collect::<Option<_>>()?;
    if clauses.len() == 1 { clauses.pop() } else { Some(ScenarioCondition::All(clauses)) }
}

/// A text cut at its ` and `s, except for those within an operation's name.
fn clauses<'a>(line: &Line, text: &'a str) -> Vec<&'a str> {
    const AND: &str = " and ";
    let goes_on = |part: &str| {
        part.split_once(':').is_some_and(|(station, begun)| {
            let begun = format!("{}{AND}", begun.trim());
            let id = line.station_named(station.trim());
            id.is_some_and(|id| line.station(id).operations.iter().any(|operation| operation.name.starts_with(&begun)))
        })
    };
    let (mut clauses, mut start) = (Vec::new(), 0);
    for (at, _) in text.match_indices(AND) {
        if !goes_on(&text[start..at]) {
            clauses.push(&text[start..at]);
            start = at + AND.len();
        }
    }
    clauses.push(&text[start..]);
    clauses
}

const COMPARISONS: [(&str, Compare); 5] = [
    (">=", Compare::AtLeast),
    ("<=", Compare::AtMost),
    ("==", Compare::Equal),
    (">", Compare::More),
    ("<", Compare::Less),
];

fn clause(line: &Line, (text, at): ScenarioWord<'_>, report: &mut Report) -> Option<ScenarioCondition> {
    let part = |part| within_trimmed(text, &at, part);
    let comparison = COMPARISONS.iter().find_map(|&(sign, how)| Some((how, text.split_once(sign)?)));
    if let Some((how, (left, right))) = comparison {
        let Ok(number) = right.trim().parse::<i64>() else {
            let (right, at) = part(right);
            report.add(Problem::error(at, format!("`{right}` is no whole number")));
            return None;
        };
        return Some(match part(left) {
            ("cycles", _) => ScenarioCondition::Cycles(how, number),
            left => ScenarioCondition::Count(operation_in(line, left, report)?, how, number),
        });
    }
    if let Some((left, right)) = text.split_once(" obeys ").or_else(|| text.split_once(" obey ")) {
        let mode = mode(part(right), report);
        return about(line, part(left), StationCondition::Obeys(mode?), report);
    }
    // The last one: an operation's name may have such a word in it.
    let Some((left, right)) = text.rsplit_once(" is ").or_else(|| text.rsplit_once(" are ")) else {
        let hint = "`cycles >= 3`, `line is auto`, `clamp_1 is incomplete`, `all are home`, `clamp_1: advance clamp is \
                    operating`, joined by `and`";
        report.add(Problem::error(at.clone(), format!("`{text}` is no condition")).hint(hint));
        return None;
    };
    match part(left) {
        ("line", _) => Some(ScenarioCondition::Mode(mode(part(right), report)?)),
        left if left.0.contains(':') => {
            let known = [
                ("operating", OperationCondition::Operating),
                ("incomplete", OperationCondition::Incomplete),
                ("done", OperationCondition::Done),
                ("undone", OperationCondition::Undone),
            ];
            let state = one_of(&known, "state of an operation", part(right), report);
            Some(ScenarioCondition::Operation(operation_in(line, left, report)?, state?))
        }
        left => {
            let known = [
                ("home", StationCondition::Home),
                ("stopped", StationCondition::Stopped),
                ("moving", StationCondition::Moving),
                ("incomplete", StationCondition::Incomplete),
                ("blocked", StationCondition::Blocked),
                ("up", StationCondition::Up),
                ("down", StationCondition::Down),
                ("heard", StationCondition::Heard),
            ];
            let state = one_of(&known, "state of a station", part(right), report);
            about(line, left, state?, report)
        }
    }
}

fn about(
    line: &Line,
    who: ScenarioWord<'_>,
    state: StationCondition,
    report: &mut Report,
) -> Option<ScenarioCondition> {
    if who.0 == "all" {
        return Some(ScenarioCondition::Every(state));
    }
    Some(ScenarioCondition::Station(station(line, who, report)?, state))
}

fn mode(word: ScenarioWord<'_>, report: &mut Report) -> Option<ControlMode> {
    one_of(&ControlMode::ALL.map(|mode| (mode.name(), mode)), "mode", word, report)
}

/// A part of a part, with its place without quotes.
fn within_trimmed<'a>(text: &str, at: &TextRange, part: &'a str) -> ScenarioWord<'a> {
    let trimmed = part.trim();
    if at.len() != text.len() {
        return (trimmed, at.clone());
    }
    let start = at.start + (trimmed.as_ptr() as usize - text.as_ptr() as usize);
    (trimmed, start..start + trimmed.len())
}
