//! Refused commands: why the mode does not change, and what to do.

use linewright_line::{Device, Line, Owner, StationId};

use crate::decision::ModeCommand;
use crate::refusal::{ApartCause, ModeRefusal, OperatorCommand, RefusedCommand};

const POSITION_LOST: &str = "position lost; see its fault: check mechanism and switch, or look, then rejoin";

const BEGIN_ANEW: &str = "lead all stations home in manual, then give auto";

impl RefusedCommand {
    /// The refusal, e.g. `auto refused in stand-by: mill_1: operation incomplete; complete or undo it in manual`.
    pub fn text(&self, line: &Line) -> String {
        self.text_with(line, |_| String::new())
    }

    /// The same, with the diagnostics of an owner's devices that are lost (empty where it is unknown).
    pub fn text_with(&self, line: &Line, trouble: impl Fn(Owner) -> String) -> String {
        let trouble_of = |reason: &ModeRefusal| match reason {
            ModeRefusal::DevicesLost(station) | ModeRefusal::DevicesAwaited(station) => {
                trouble(Owner::Station(*station))
            }
            ModeRefusal::ConsoleLost | ModeRefusal::ConsoleNeverHeard => trouble(Owner::Console),
            _ => String::new(),
        };
        let reasons = reason_texts(&self.reasons, line, trouble_of);
        let of = match self.command {
            OperatorCommand::Single(station, _) => format!(" of {}", line.station(station).name),
            OperatorCommand::Mode(_) | OperatorCommand::Buttons | OperatorCommand::Resume => String::new(),
        };
        format!("{}{of} refused in {}: {}", self.command.name(), self.mode, reasons.join("; "))
    }
}

/// The station that a reason has led to manual, beside all `reasons`: what was restarted there is looked at on that way, and *start* leads
/// nowhere before it. Where all stations are at home *start* itself lets them begin anew.
fn leads_to_manual(reason: &ModeRefusal, reasons: &[ModeRefusal]) -> Option<StationId> {
    let is_away = || reasons.iter().any(|of| matches!(of, ModeRefusal::NotAtHome(_)));
    match *reason {
        ModeRefusal::Incomplete(station, _)
        | ModeRefusal::PositionLost(station)
        | ModeRefusal::BetweenRests(station) => Some(station),
        ModeRefusal::NoCommonStart(station, _) if is_away() => Some(station),
        _ => None,
    }
}

/// The reasons, each with what is known of its cause (empty where nothing is). What several stations lack is one reason.
pub(crate) fn reason_texts(
    reasons: &[ModeRefusal],
    line: &Line,
    trouble: impl Fn(&ModeRefusal) -> String,
) -> Vec<String> {
    let apart = |reason: &ModeRefusal| match reason {
        ModeRefusal::NoCommonStart(station, cause) => Some((*cause, line.station(*station).name.as_str())),
        _ => None,
    };
    let text = |reason: &ModeRefusal| {
        let (text, trouble) = (reason.text(line), trouble(reason));
        if trouble.is_empty() { text } else { format!("{text}: {trouble}") }
    };
    let is_looked_at = |reason: &ModeRefusal| match reason {
        ModeRefusal::Restarted(station) => {
            reasons.iter().filter_map(|of| leads_to_manual(of, reasons)).any(|of| of == *station)
        }
        _ => false,
    };
    let single = |reason: &&ModeRefusal| apart(reason).is_none() && !is_looked_at(reason);
    let mut texts: Vec<String> = reasons.iter().filter(single).map(text).collect();
    let of_cause = |cause: ApartCause| {
        let names: Vec<&str> = reasons.iter().filter_map(apart).filter(|of| of.0 == cause).map(|of| of.1).collect();
        (!names.is_empty()).then(|| format!("{}: {}", names.join(", "), cause.text()))
    };
    let causes: Vec<String> = ApartCause::ALL.into_iter().filter_map(of_cause).collect();
    if !causes.is_empty() {
        texts.push(format!("{}; {BEGIN_ANEW}", causes.join(", and ")));
    }
    texts
}

impl ApartCause {
    const fn text(self) -> &'static str {
        match self {
            ApartCause::NoMemory => "no memory of the cycle",
            ApartCause::OtherStart => "began anew apart from the other stations",
        }
    }
}

impl ModeRefusal {
    /// The reason; it begins with the station where it is one station's.
    pub fn text(&self, line: &Line) -> String {
        let (station, text) = match self {
            ModeRefusal::WrongMode { takes, way } => return wrong_mode(takes, way),
            ModeRefusal::NothingToReset => return "nothing to reset, no emergency stop is in force".to_owned(),
            ModeRefusal::OtherCoordinator(life) => {
                return format!(
                    "second coordinator active on this line (boot id {life}), no motion; stop one of the two"
                );
            }
            ModeRefusal::GivenUp(after) => return format!("given up after {} s: command it again", after.as_secs()),
            ModeRefusal::Stopping => return "stopping at home; give start to take the stop back".to_owned(),
            ModeRefusal::Already => return "mode already in force".to_owned(),
            ModeRefusal::EStop => return "emergency stop active; reset it, then select manual".to_owned(),
            ModeRefusal::EStopPressed => return "emergency stop button pressed; release it first".to_owned(),
            ModeRefusal::ConsoleLost => return "console: I/O devices not operational".to_owned(),
            ModeRefusal::JournalLost => {
                return "coordinator journal not writable (file and cause in its log); correct it, then reset"
                    .to_owned();
            }
            ModeRefusal::ConsoleNeverHeard => {
                return "no console input received yet, emergency stop state unknown; check supply and bus of the \
                        console device"
                    .to_owned();
            }
            ModeRefusal::NotManual => return "takes effect in manual only; give manual first, then hold it".to_owned(),
            ModeRefusal::ManualBySelectors => {
                return "manual by selectors, each panel is its station's own; turn the selectors to auto, give manual, then \
                        hold it"
                    .to_owned();
            }
            ModeRefusal::TwoConsoles => {
                return "two consoles send it, nothing goes on; release it at both, then hold it at one".to_owned();
            }
            ModeRefusal::Unreleased => {
                return "not seen released since it was held before; release it first".to_owned();
            }
            ModeRefusal::NotHeard(station) => (station, "no state received"),
            ModeRefusal::Inactive(station, state) => {
                let (name, state, way) = (&line.station(*station).name, state.label(), state.way_to_active());
                return format!("{name}: node {state}; {way}");
            }
            ModeRefusal::CoordinatorInactive(state) => {
                return format!("coordinator {}, no motion; {}", state.label(), state.way_to_active());
            }
            ModeRefusal::DevicesLost(station) => (station, "I/O devices lost"),
            ModeRefusal::DevicesAwaited(station) => {
                (station, "I/O devices not operational yet; after 10 s check supply and bus")
            }
            ModeRefusal::Incomplete(station, Some(op)) if line.station(*station).index_of(*op).is_some() => {
                (station, "index incomplete; complete it in manual, it has no way back")
            }
            ModeRefusal::Incomplete(station, _) => (station, "operation incomplete; complete or undo it in manual"),
            ModeRefusal::PositionLost(station) => {
                let described = line.station(*station);
                let turns = described.op_ids().any(|op| described.index_of(op).is_some());
                let of_station = line.devices_of(Owner::Station(*station)).filter_map(Device::drive);
                let is_homed = of_station.into_iter().any(|drive| drive.index.is_some() && drive.homing.is_some());
                let text = match (turns, is_homed) {
                    (true, true) => "position lost; see its fault: home its drive in manual, or look, then rejoin",
                    (true, false) => "position lost; see its fault, look, then rejoin",
                    (false, _) => POSITION_LOST,
                };
                (station, text)
            }
            ModeRefusal::NoCommonStart(station, cause) => {
                return format!("{}: {}; {BEGIN_ANEW}", line.station(*station).name, cause.text());
            }
            ModeRefusal::NotFounded(station, cause) => {
                let (name, cause) = (&line.station(*station).name, cause.text());
                return format!("{name}: {cause}, and the line cannot begin anew now; give start, then manual");
            }
            ModeRefusal::Restarted(station) => (station, "restarted; give start, or select manual first"),
            ModeRefusal::SelectorManual(station) => (station, "selector at manual"),
            ModeRefusal::Moving(station) => (station, "motion in progress"),
            ModeRefusal::Unaware(station) => (station, "stand-by not acknowledged yet"),
            ModeRefusal::NotAtHome(station) => (station, "not at home"),
            ModeRefusal::BetweenRests(station) => (
                station,
                "between two rests, with no task order; lead it to a rest in manual, or take its resource out of service",
            ),
            ModeRefusal::NotInAuto(station) => {
                (station, "one station is led in manual while the others are in auto only; give manual for the line")
            }
            ModeRefusal::NotSingle(station) => (station, "not in manual by itself, it follows the mode of the line"),
            ModeRefusal::NoSingleManual(station) => (
                station,
                "in a cell only; the stations of a line depend on each other in each cycle, so it has one mode; give stop --wait, then \
                 manual",
            ),
            ModeRefusal::InService(station) => (
                station,
                "takes part in auto; take its resource out of service, which lets its task end, or give the alarm of its \
                 resource, which stops it",
            ),
            ModeRefusal::Securing(station) => {
                (station, "stations of its failed activity come to rest; wait for the alarm, then give manual again")
            }
            ModeRefusal::Unattended(station) => {
                (station, "the log of the cell cannot be written, so no failure is followed up; restore the disk")
            }
            ModeRefusal::OutsideTask(station) => (
                station,
                "between two rests in a task of no failed activity, other stations may have work there; give stop --wait, \
                 then manual for the line",
            ),
            ModeRefusal::Turns(station) => (
                station,
                "has an index, which manual may home at rest beside stations in auto; give stop --wait, then manual for the \
                 line",
            ),
            ModeRefusal::SelectorUnclear(station) => (
                station,
                "selector not at manual, or unknown since a restart; give auto for the station, or turn the selector to manual",
            ),
            ModeRefusal::ManualUnaware(station) => (station, "manual not acknowledged yet"),
            ModeRefusal::CellUnaware(station) => (station, "the cell has not acknowledged manual yet"),
            ModeRefusal::StoppedByCell(station) => {
                (station, "in emergency stop; clear the cause, then reset it with `linewright resource … reset`")
            }
            ModeRefusal::Behind(station) => (station, "at home one cycle behind the others; give auto, then stop"),
        };
        format!("{}: {text}", line.station(*station).name)
    }
}

/// A stop is waited for: what follows it is possible only then.
fn wrong_mode(takes: &[ModeCommand], way: &[ModeCommand]) -> String {
    let names = |of: &[ModeCommand]| of.iter().map(|command| command.name()).collect::<Vec<_>>();
    let takes = if takes.is_empty() { String::new() } else { format!("; possible: {}", names(takes).join(", ")) };
    let step = |command: &ModeCommand| match command {
        ModeCommand::Stop => "stop --wait".to_owned(),
        ModeCommand::Start if way[0] == ModeCommand::Stop => "start if it ended at home".to_owned(),
        command => command.name().to_owned(),
    };
    let way = way.iter().map(step).collect::<Vec<_>>().join(", then ");
    let way = if way.is_empty() { way } else { format!("; the way: {way}") };
    format!("not possible from this mode{takes}{way}")
}
