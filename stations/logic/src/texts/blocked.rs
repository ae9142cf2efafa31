//! Texts of what a station waits for; each follows `waits for`.

use linewright_line::net::ControlMode;

use crate::event::StopCause;

/// Wait of a station with invalid devices. Which device and why, their manager reports.
pub const DEVICES_INVALID: &str = "its I/O devices: no process data, or not operational";

/// What waits for something where a drive is to be homed at a rest.
pub(crate) const HOMING: &str = "the homing of its drive";

/// The way back of a station that stands somewhere else than its chart has it, in its fault.
pub(crate) const REJOIN_WAY: &str = "its switches fit another place: look where it stands, then confirm it with rejoin";

/// Something that a station waits for, with the names that its text contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationWait<'a> {
    /// Two coordinators are active; their boot ids.
    RivalCoordinators { followed: u64, other: u64 },
    /// The process image is not valid.
    Devices,
    /// An axis is not measured at its place; the detail of [`StopCause::PositionLost`].
    PositionLost(&'a str),
    /// An operator's confirmation of where the station stands.
    Rejoin(PositionDoubt, RejoinAdvice<'a>),
    /// The homing of a drive, by this index.
    Homing { op: &'a str },
    /// The homing of the drive, at a rest.
    HomingAtRest,
    /// The end of the drive's fault, before it is homed.
    HomingFault { input: &'a str },
    /// The standstill of another station, before the drive is homed.
    Standstill { station: &'a str },
    /// Its state of a conflict, before the drive is homed.
    LedOut { station: &'a str, why: &'a str },
    /// All stations at home: this one shares no counts with the others.
    NewGeneration,
    /// A motion that was stopped is not complete: where advance and return lead it.
    Stopped { op: &'a str, advance: Option<PanelChoice>, back: Option<PanelChoice>, cause: StopCause },
    /// An index that was stopped is not complete. It is led on, and never back.
    IndexStopped { op: &'a str, cause: StopCause },
    /// The end of a fault signal, before a motion that was stopped is led on.
    FaultSignal { input: &'a str, op: &'a str },
    /// The button of a motion.
    Held { button: &'a str },
    /// An operation of the same step.
    Concurrent { op: &'a str },
    /// The end of the master stop at home.
    MasterStop,
    /// The end of the master stop of a task-driven station.
    MasterStopOfOrders,
    /// The next task order.
    TaskOrder,
    /// A rest: no task begins where the station stands.
    Rest,
    /// An input of a task.
    Input { input: &'a str, own: &'a str },
    /// The input of the `result` of an operation that is complete: it has to be on before the next operation starts.
    Result { input: &'a str, of: &'a str },
    /// A button in hand mode; none has a function where both are empty.
    Button { onward: Option<&'a str>, back: Option<&'a str> },
    /// A button in hand mode within a sequence, which its other button takes back only from its end.
    ButtonMidway { onward: &'a str, back: &'a str },
    /// A button in hand mode where a task was taken back to its beginning: only this task's, until the station is led on
    /// to the rest.
    ButtonUndone { again: &'a str },
    /// A button in hand mode that begins a task: the choices, each from [`StationWait::task_button`].
    TaskButton { choices: &'a [String] },
    /// One console at the station's panel: two send a button of it.
    OneConsole,
    /// A command of the station's panel.
    Panel,
    /// At a rest in manual: what begins a task, or takes one back.
    PanelAtRest,
    /// At the rest where a task was taken back to, in manual: advance begins its first operation again.
    TakenBackAtRest { op: &'a str },
    /// The station's selector.
    Selector,
    /// A mode in which stations move.
    Mode(ControlMode),
    /// What ends the emergency stop. A station does not know whether it has been reset.
    EStop,
    /// Advance at the station's panel; return leads nowhere.
    PanelAdvance { op: &'a str, no_return: NoReturn },
    /// Return, which leads on along the recovery path. In no other mode than manual does anything lead on there.
    RecoveryPath,
    /// A motion forbidden by measured positions; the detail of [`StopCause::Interlock`].
    Position { detail: &'a str, own: &'a str },
    /// A need of the recovery path; another wait.
    WayHome { cause: &'a str },
    /// An arrow: the state of its station is unknown.
    NoState { station: &'a str, own: &'a str },
    /// An arrow: this station has no generation.
    OwnGeneration { own: &'a str },
    /// An arrow: its station is of another generation.
    OtherGeneration { station: &'a str, own: &'a str },
    /// An arrow: its station's position is lost.
    PositionOf { station: &'a str, own: &'a str },
    /// An arrow: its station reports a cycle that cannot be.
    Implausible { station: &'a str, cycle: i32, own: &'a str },
    /// An arrow: the count is being withdrawn.
    BeingWithdrawn { station: &'a str, op: &'a str, own: &'a str },
    /// An arrow: the count is not reached.
    Arrow { station: &'a str, op: &'a str, cycle: i32, own: &'a str },
    /// The agreement of another station to withdraw counts.
    Agreement { station: &'a str, is_heard: bool, ops: &'a str },
    /// The agreement of another station to a motion that relies on its measured position alone.
    EntryAgreement { station: &'a str, is_heard: bool },
    /// A motion that relies on the measured position of another station alone; that has its own operation under way, or is about
    /// to begin one.
    EntryRejected { station: &'a str, op: Option<&'a str> },
    /// Counts that another station does not agree to take back, because of its operation.
    Disagreement { station: &'a str, op: &'a str, ops: &'a str },
}

/// Where a button of the panel leads an operation that was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelChoice {
    GoOn,
    DoAgain,
    TakeBack,
    /// Along the recovery path.
    WayHome,
}

impl PanelChoice {
    const fn text(self) -> &'static str {
        match self {
            PanelChoice::GoOn => "go on",
            PanelChoice::DoAgain => "do it again",
            PanelChoice::TakeBack => "take back",
            PanelChoice::WayHome => "go home along the recovery path",
        }
    }
}

/// Reason why return leads nowhere from the end of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoReturn {
    AtHome,
    /// The operation is undone, and its hand type leads no further back.
    Undone,
    Irreversible,
}

/// Reason why the position of a station is in doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionDoubt {
    /// It has no generation.
    NoJournal,
    /// An axis is not measured where the chart has it.
    AxisOff,
    /// It is not certain whether an index is done.
    Index,
    /// An axis with numbered places is measured at another one than it was left at, or sent to.
    AnotherPlace,
}

/// Advice on clearing up the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RejoinAdvice<'a> {
    /// The switches determine a step: these operations are complete.
    Confirm { ops: &'a str },
    /// The switch of this index is on, before it as after it.
    ConfirmIndex { op: &'a str },
    /// The place is measured: an operator confirms it.
    ConfirmPlace,
    /// The switches fit no operation.
    NoOperation,
    /// The switches fit these operations, each in progress.
    Between { ops: &'a [&'a str] },
    /// The switches fit no place.
    NoPlace,
    /// The switches fit this rest of a task-driven station.
    Rest { rest: &'a str },
    /// The switches fit these rests alike.
    Rests { rests: &'a [&'a str] },
    /// The switches fit the ends of these operations alike.
    Several { ops: &'a [&'a str] },
}

impl StationWait<'_> {
    /// A choice of [`StationWait::TaskButton`].
    pub fn task_button(button: &str, task: &str) -> String {
        format!("{button} for {task}")
    }

    /// The text; it follows `waits for`.
    pub fn text(self) -> String {
        match self {
            StationWait::RivalCoordinators { followed, other } => {
                format!("one coordinator: two are active (boot ids {followed} and {other}); stop one of them")
            }
            StationWait::OneConsole => {
                "one console at its panel: two consoles send a button of it; release it at both, then hold it at one"
                    .to_owned()
            }
            StationWait::Devices => DEVICES_INVALID.to_owned(),
            StationWait::PositionLost(detail) => detail.to_owned(),
            StationWait::Rejoin(doubt, advice) => format!("rejoin: {}; {}", doubt.text(), advice.text()),
            StationWait::Homing { op } => format!(
                "the homing of its drive: hold advance at its panel in manual, as far as the end of `{op}`; the axis turns \
                 to its reference first, forwards or back"
            ),
            StationWait::HomingAtRest => {
                "the homing of its drive: hold advance at its panel in manual until its place is \
                                          measured; the axis turns to its reference, forwards or back"
                    .to_owned()
            }
            StationWait::HomingFault { input } => format!("{input} to go off, for {HOMING}"),
            StationWait::Standstill { station } => format!("{station} to stand still, for {HOMING}"),
            StationWait::LedOut { station, why } => {
                format!("{station} to be led out of its state of the conflict `{why}`, for {HOMING}")
            }
            StationWait::NewGeneration => "a new start of all stations: it has no memory of the cycle; lead all \
                                           stations home in manual, then give auto"
                .to_owned(),
            StationWait::Stopped { op, advance, back, cause } => {
                let choice = |button, choice: Option<PanelChoice>| choice.map(|to| format!("{button} ({})", to.text()));
                let buttons: Vec<String> =
                    [choice("advance", advance), choice("return", back)].into_iter().flatten().collect();
                format!("{} at its panel in manual, for {op} ({})", buttons.join(" or "), cause.text())
            }
            StationWait::FaultSignal { input, op } => {
                format!("fault signal {input} to go off, for {op}: it is on; remove its cause")
            }
            StationWait::Held { button } => format!("{button} to be held"),
            StationWait::IndexStopped { op, cause } => {
                format!("advance at its panel in manual, to complete {op} ({}); an index has no return", cause.text())
            }
            StationWait::Concurrent { op } => format!("concurrent operation {op}"),
            StationWait::MasterStop => "master stop: halted at home".to_owned(),
            StationWait::MasterStopOfOrders => "master stop: no task orders accepted".to_owned(),
            StationWait::TaskOrder => "a task order".to_owned(),
            StationWait::Rest => "an operator: no task begins here; lead the station to a rest in manual".to_owned(),
            StationWait::Input { input, own } => format!("{input} to be on, for {own}"),
            StationWait::Result { input, of } => format!("{input} to be on, after {of}"),
            StationWait::Button { onward, back } => match (onward, back) {
                (Some(onward), Some(back)) if onward == back => format!("a button: {onward}"),
                (Some(onward), Some(back)) => format!("a button: {onward} to go on, {back} to go back"),
                (Some(onward), None) => format!("a button: {onward} to go on"),
                (None, Some(back)) => format!("a button: {back} to go back"),
                (None, None) => "a button: none assigned here; use manual or auto".to_owned(),
            },
            StationWait::ButtonMidway { onward, back } => {
                format!(
                    "a button: {onward} to go on; {back} takes back only from the end of the sequence (from here: \
                     return at its panel in manual)"
                )
            }
            StationWait::ButtonUndone { again } => {
                format!("a button: {again} to do it again; for another task, return at its panel in manual, or auto")
            }
            StationWait::TaskButton { choices } => format!("a button: {}", choices.join(", ")),
            StationWait::Panel => "advance or return at its panel".to_owned(),
            StationWait::PanelAtRest => {
                "a task: its order in auto, or its button in hand mode; at a rest its panel moves nothing".to_owned()
            }
            StationWait::TakenBackAtRest { op } => {
                format!(
                    "a task: its order in auto, or advance at its panel to begin {op} again; it is at rest, its task taken back"
                )
            }
            StationWait::Selector => "its selector at manual".to_owned(),
            StationWait::Mode(mode) => format!("a mode that allows motion (now {mode})"),
            StationWait::EStop => "manual, possible once the emergency stop is reset".to_owned(),
            StationWait::PanelAdvance { op, no_return } => {
                let why = match no_return {
                    NoReturn::AtHome => "it is at home".to_owned(),
                    NoReturn::Undone => format!("{op} is undone, and return leads no further back"),
                    NoReturn::Irreversible => format!("{op} cannot be undone"),
                };
                format!("advance at its panel; no return: {why}")
            }
            StationWait::RecoveryPath => {
                "return at its panel in manual: it is on its recovery path, half-way home".to_owned()
            }
            StationWait::Position { detail, own } => format!("{detail}, for {own}"),
            StationWait::WayHome { cause } => format!("{cause}, needed on the recovery path"),
            StationWait::NoState { station, own } => format!("the state of {station}, for {own}"),
            StationWait::OwnGeneration { own } => {
                format!("a new start of all stations, for {own}: it has no memory of the cycle")
            }
            StationWait::OtherGeneration { station, own } => {
                format!("a new start together with {station}, for {own}: the two began anew apart")
            }
            StationWait::PositionOf { station, own } => format!("the position of {station} (lost), for {own}"),
            StationWait::Implausible { station, cycle, own } => {
                format!("a plausible cycle of {station} (it reports {cycle}), for {own}")
            }
            StationWait::BeingWithdrawn { station, op, own } => {
                format!("{station}: {op} (being taken back), for {own}")
            }
            StationWait::Arrow { station, op, cycle, own } => format!("{station}: {op} (cycle {cycle}), for {own}"),
            StationWait::Agreement { station, is_heard, ops } => {
                format!("agreement of {station}{} to take back {ops}", heard(is_heard))
            }
            StationWait::EntryAgreement { station, is_heard } => {
                format!(
                    "agreement of {station}{} to stand meanwhile: nothing else keeps the two apart",
                    heard(is_heard)
                )
            }
            StationWait::EntryRejected { station, op } => {
                let what = op.map_or("is about to move".to_owned(), |op| format!("{op} is under way"));
                format!("{station} to stand ({what}): nothing else keeps the two apart; command it again then")
            }
            StationWait::Disagreement { station, op, ops } => {
                format!("{ops} to be taken back: rejected by {station}, {op} has started")
            }
        }
    }
}

const fn heard(is_heard: bool) -> &'static str {
    if is_heard { "" } else { " (no state received)" }
}

/// In the advice on a confirmation that is refused without them.
pub const NUMBERS_LOST: &str = "the numbers of its task are lost";

/// Behind the advice on a confirmation within a task that has these parameters.
pub(crate) fn numbers_text(parameters: &[&str]) -> String {
    let all: Vec<String> = parameters.iter().map(|name| format!("--with {name}=NUMBER")).collect();
    match all.as_slice() {
        [] => String::new(),
        all => format!("; {NUMBERS_LOST}: give them too ({})", all.join(" ")),
    }
}

impl PositionDoubt {
    const fn text(self) -> &'static str {
        match self {
            PositionDoubt::NoJournal => "position unknown, no valid journal",
            PositionDoubt::AxisOff => "axis not where the chart has it",
            PositionDoubt::Index => "not certain whether its index is done",
            PositionDoubt::AnotherPlace => "at another place than expected",
        }
    }
}

impl RejoinAdvice<'_> {
    fn text(self) -> String {
        match self {
            RejoinAdvice::Confirm { ops } => format!("by its switches `{ops}` is complete; confirm it with rejoin"),
            RejoinAdvice::ConfirmIndex { op } => {
                format!("its switch is on before `{op}` and after it; look at the mechanism, then confirm with rejoin")
            }
            RejoinAdvice::ConfirmPlace => "look at the mechanism, then confirm its place with rejoin".to_owned(),
            RejoinAdvice::NoOperation => {
                "its switches fit no operation; move its axes onto a switch by hand".to_owned()
            }
            RejoinAdvice::Between { ops } => format!(
                "between two switches; check it, then name its operation with rejoin; possible: `{}`",
                ops.join("`, `")
            ),
            RejoinAdvice::Several { ops } => format!(
                "its switches fit more than one place; look which operation was done last, then name it with rejoin; \
                 possible: `{}`",
                ops.join("`, `")
            ),
            RejoinAdvice::Rest { rest } => {
                format!("by its switches it stands at rest `{rest}`; look at the mechanism, then confirm with rejoin")
            }
            RejoinAdvice::Rests { rests } => format!(
                "its switches fit more than one rest; look, then name the rest with rejoin --rest; possible: `{}`",
                rests.join("`, `")
            ),
            RejoinAdvice::NoPlace => "its switches fit no place; move the axis onto its switch by hand, or name its \
                                      operation with rejoin"
                .to_owned(),
        }
    }
}
