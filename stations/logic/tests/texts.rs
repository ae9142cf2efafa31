//! All texts of a station in one list. A new variant without a text, or without a place in the list, does not compile.

use linewright_line::net::{Block, ControlMode};
use linewright_line::{InputId, Line, OpId, StationId, TaskId, TransferLine, parse};
use linewright_orders::{TaskFailure, TaskRefusal};
use linewright_station_logic::{
    CompileError, HappeningKind, Ignored, NoReturn, PanelChoice, PlacesApart, PositionDoubt, RejoinAdvice,
    StationHappening, StationWait, StopCause,
};

use linewright_testkit::samples::{listed, samples};

const TRANSFER: StationId = StationId(0);
const CLAMP: StationId = StationId(1);
const M1: StationId = StationId(0);
const OP: OpId = OpId(1);
const INPUT: InputId = InputId(0);
const TASK: TaskId = TaskId(0);
const APART: PlacesApart = PlacesApart { measured: 1, known: 3 };

fn transfer_line() -> Line {
    parse("line.toml", &TransferLine::default().text()).expect("sound").line
}

fn task_driven() -> Line {
    let text = include_str!("../../../model/line/tests/descriptions/task_driven.toml");
    parse("task_driven.toml", text).expect("sound").line
}

fn causes() -> Vec<StopCause> {
    samples!(StopCause {
        StopCause::Signal => StopCause::Signal;
        StopCause::Watchdog => StopCause::Watchdog;
        StopCause::SwitchStuck => StopCause::SwitchStuck;
        StopCause::BothSwitchesOn { .. } => StopCause::BothSwitchesOn { behind: INPUT };
        StopCause::Devices => StopCause::Devices;
        StopCause::Released => StopCause::Released;
        StopCause::EStop => StopCause::EStop;
        StopCause::Ordered => StopCause::Ordered;
        StopCause::Restart => StopCause::Restart;
        StopCause::NotAtHome => StopCause::NotAtHome;
        StopCause::Interlock { .. } => StopCause::Interlock { station: CLAMP, input: Some(INPUT), is_on: false },
            StopCause::Interlock { station: CLAMP, input: Some(INPUT), is_on: true },
            StopCause::Interlock { station: TRANSFER, input: None, is_on: false },
            StopCause::Interlock { station: CLAMP, input: None, is_on: false };
        StopCause::PositionLost { .. } => StopCause::PositionLost { op: OP, input: INPUT };
        StopCause::IndexDoubtful { .. } => StopCause::IndexDoubtful { op: OP, input: INPUT, places: None },
            StopCause::IndexDoubtful { op: OP, input: INPUT, places: Some(APART) };
        StopCause::Ambiguous => StopCause::Ambiguous;
    })
}

fn happenings() -> Vec<HappeningKind> {
    samples!(HappeningKind {
        HappeningKind::Started(..) => HappeningKind::Started(OP, Block::Normal),
            HappeningKind::Started(OP, Block::Recovery);
        HappeningKind::Completed(..) => HappeningKind::Completed(OP, Block::Normal),
            HappeningKind::Completed(OP, Block::Recovery);
        HappeningKind::Stopped(..) => HappeningKind::Stopped(OP, Block::Normal, StopCause::Watchdog),
            HappeningKind::Stopped(OP, Block::Recovery, StopCause::Released);
        HappeningKind::Withdrawn(_) => HappeningKind::Withdrawn(0), HappeningKind::Withdrawn(0b11);
        HappeningKind::HomeAgain => HappeningKind::HomeAgain;
        HappeningKind::Founded => HappeningKind::Founded;
        HappeningKind::Rejoined => HappeningKind::Rejoined;
        HappeningKind::PositionLost(..) => HappeningKind::PositionLost(OP, INPUT);
        HappeningKind::IndexDoubtful(..) => HappeningKind::IndexDoubtful(OP, INPUT, None),
            HappeningKind::IndexDoubtful(OP, INPUT, Some(APART));
        HappeningKind::PositionFound => HappeningKind::PositionFound;
        HappeningKind::Asked(_) => HappeningKind::Asked(3);
        HappeningKind::NotAgreed { .. } => HappeningKind::NotAgreed { by: TRANSFER, in_the_way: OP };
        HappeningKind::Refused => HappeningKind::Refused;
        HappeningKind::Mode(_) => HappeningKind::Mode(ControlMode::Auto);
        HappeningKind::Devices(_) => HappeningKind::Devices(true), HappeningKind::Devices(false);
        HappeningKind::Ordered(_) => HappeningKind::Ordered(TASK);
        HappeningKind::OrderRefused(_) => HappeningKind::OrderRefused(TaskRefusal::Busy);
        HappeningKind::OrderDone(_) => HappeningKind::OrderDone(TASK);
        HappeningKind::OrderFailed(..) => HappeningKind::OrderFailed(TASK, TaskFailure::TimedOut);
        HappeningKind::OrderLeft(..) => HappeningKind::OrderLeft(TASK, 12);
        HappeningKind::Securing(_) => HappeningKind::Securing(TASK);
    })
}

fn failures() -> Vec<TaskFailure> {
    samples!(TaskFailure {
        TaskFailure::Waiting(_) => TaskFailure::Waiting(12);
        TaskFailure::TimedOut => TaskFailure::TimedOut;
        TaskFailure::Fault => TaskFailure::Fault;
        TaskFailure::Interrupted => TaskFailure::Interrupted;
        TaskFailure::Restarted => TaskFailure::Restarted;
        TaskFailure::Cancelled => TaskFailure::Cancelled;
        TaskFailure::Held => TaskFailure::Held;
        TaskFailure::Stopped => TaskFailure::Stopped;
        TaskFailure::Other(_) => TaskFailure::Other(1999);
    })
}

fn refusals() -> Vec<TaskRefusal> {
    samples!(TaskRefusal {
        TaskRefusal::Busy => TaskRefusal::Busy;
        TaskRefusal::Mode => TaskRefusal::Mode;
        TaskRefusal::OtherMemory => TaskRefusal::OtherMemory;
        TaskRefusal::OldEpoch => TaskRefusal::OldEpoch;
        TaskRefusal::Old => TaskRefusal::Old;
        TaskRefusal::Late => TaskRefusal::Late;
        TaskRefusal::NotThere => TaskRefusal::NotThere;
        TaskRefusal::Devices => TaskRefusal::Devices;
        TaskRefusal::Unknown => TaskRefusal::Unknown;
        TaskRefusal::Incomplete => TaskRefusal::Incomplete;
        TaskRefusal::Isolated => TaskRefusal::Isolated;
    })
}

fn ignored() -> Vec<Ignored> {
    samples!(Ignored {
        Ignored::OlderEpoch => Ignored::OlderEpoch;
        Ignored::NotAPeer => Ignored::NotAPeer;
        Ignored::Misfit => Ignored::Misfit;
        Ignored::NoTasks => Ignored::NoTasks;
        Ignored::OtherLife => Ignored::OtherLife;
        Ignored::EpochTooHigh => Ignored::EpochTooHigh;
        Ignored::LeaseTooLong => Ignored::LeaseTooLong;
        Ignored::Moving => Ignored::Moving;
        Ignored::NotLost => Ignored::NotLost;
        Ignored::InSingleManual => Ignored::InSingleManual;
        Ignored::PositionUnclear => Ignored::PositionUnclear;
        Ignored::NumberMissing => Ignored::NumberMissing;
        Ignored::NoSuchNumber => Ignored::NoSuchNumber;
        Ignored::NumberOutOfRange => Ignored::NumberOutOfRange;
        Ignored::NumbersKnown => Ignored::NumbersKnown;
    })
}

fn advice() -> Vec<RejoinAdvice<'static>> {
    samples!(RejoinAdvice<'static> {
        RejoinAdvice::Confirm { .. } => RejoinAdvice::Confirm { ops: "close" };
        RejoinAdvice::ConfirmIndex { .. } => RejoinAdvice::ConfirmIndex { op: "index" };
        RejoinAdvice::ConfirmPlace => RejoinAdvice::ConfirmPlace;
        RejoinAdvice::NoOperation => RejoinAdvice::NoOperation;
        RejoinAdvice::Between { .. } => RejoinAdvice::Between { ops: &["close", "open"] };
        RejoinAdvice::NoPlace => RejoinAdvice::NoPlace;
        RejoinAdvice::Rest { .. } => RejoinAdvice::Rest { rest: "open" };
        RejoinAdvice::Rests { .. } => RejoinAdvice::Rests { rests: &["open", "open with a part"] };
        RejoinAdvice::Several { .. } => RejoinAdvice::Several { ops: &["unlock", "index"] };
    })
}

fn doubts() -> Vec<PositionDoubt> {
    samples!(PositionDoubt {
        PositionDoubt::NoJournal => PositionDoubt::NoJournal;
        PositionDoubt::AxisOff => PositionDoubt::AxisOff;
        PositionDoubt::Index => PositionDoubt::Index;
        PositionDoubt::AnotherPlace => PositionDoubt::AnotherPlace;
    })
}

fn waits<'a>(choices: &'a [String], cause: &'a str, detail: &'a str, lost: &'a str) -> Vec<StationWait<'a>> {
    let (station, op, own) = ("clamp_1", "close", "advance");
    let mut waits = samples!(StationWait<'_> {
        StationWait::OneConsole => StationWait::OneConsole;
        StationWait::RivalCoordinators { .. } => StationWait::RivalCoordinators { followed: 17, other: 23 };
        StationWait::Devices => StationWait::Devices;
        StationWait::PositionLost(_) => StationWait::PositionLost(lost);
        StationWait::Rejoin(..) => StationWait::Rejoin(doubts()[0], advice()[0]);
        StationWait::Homing { .. } => StationWait::Homing { op: "index" };
        StationWait::HomingAtRest => StationWait::HomingAtRest;
        StationWait::HomingFault { .. } => StationWait::HomingFault { input: "drive_fault" };
        StationWait::Standstill { .. } => StationWait::Standstill { station };
        StationWait::LedOut { .. } => StationWait::LedOut { station, why: "the table turns under clamp_1" };
        StationWait::NewGeneration => StationWait::NewGeneration;
        StationWait::Stopped { .. } => StationWait::Stopped {
            op,
            advance: Some(PanelChoice::GoOn),
            back: Some(PanelChoice::TakeBack),
            cause: StopCause::Watchdog,
        };
        StationWait::IndexStopped { .. } => StationWait::IndexStopped { op, cause: StopCause::EStop };
        StationWait::FaultSignal { .. } => StationWait::FaultSignal { input: "drive_fault (press drive, node 32h)", op };
        StationWait::Held { .. } => StationWait::Held { button: "PB_2" };
        StationWait::Concurrent { .. } => StationWait::Concurrent { op };
        StationWait::MasterStop => StationWait::MasterStop;
        StationWait::MasterStopOfOrders => StationWait::MasterStopOfOrders;
        StationWait::TaskOrder => StationWait::TaskOrder;
        StationWait::Rest => StationWait::Rest;
        StationWait::Result { .. } => StationWait::Result { input: "part_in_hand (robot io, node 11h)", of: own };
        StationWait::Input { .. } => StationWait::Input { input: "part_present (m1 io, node 02h)", own };
        StationWait::Button { .. } => StationWait::Button { onward: Some("PB_2"), back: Some("PB_2") },
            StationWait::Button { onward: Some("PB_2"), back: Some("PB_3") },
            StationWait::Button { onward: Some("PB_2"), back: None },
            StationWait::Button { onward: None, back: Some("PB_3") },
            StationWait::Button { onward: None, back: None };
        StationWait::ButtonMidway { .. } => StationWait::ButtonMidway { onward: "PB_2", back: "PB_4" };
        StationWait::ButtonUndone { .. } => StationWait::ButtonUndone { again: "PB_2" };
        StationWait::TaskButton { .. } => StationWait::TaskButton { choices };
        StationWait::Panel => StationWait::Panel;
        StationWait::PanelAdvance { .. } => StationWait::PanelAdvance { op: "decel", no_return: NoReturn::AtHome },
            StationWait::PanelAdvance { op: "decel", no_return: NoReturn::Undone },
            StationWait::PanelAdvance { op: "feed main slide", no_return: NoReturn::Irreversible };
        StationWait::PanelAtRest => StationWait::PanelAtRest;
        StationWait::TakenBackAtRest { .. } => StationWait::TakenBackAtRest { op: "close" };
        StationWait::Selector => StationWait::Selector;
        StationWait::RecoveryPath => StationWait::RecoveryPath;
        StationWait::Mode(_) => StationWait::Mode(ControlMode::StandBy);
        StationWait::EStop => StationWait::EStop;
        StationWait::Position { .. } => StationWait::Position { detail, own };
        StationWait::WayHome { .. } => StationWait::WayHome { cause };
        StationWait::NoState { .. } => StationWait::NoState { station, own };
        StationWait::OwnGeneration { .. } => StationWait::OwnGeneration { own };
        StationWait::OtherGeneration { .. } => StationWait::OtherGeneration { station, own };
        StationWait::PositionOf { .. } => StationWait::PositionOf { station, own };
        StationWait::Implausible { .. } => StationWait::Implausible { station, cycle: 900, own };
        StationWait::BeingWithdrawn { .. } => StationWait::BeingWithdrawn { station, op, own };
        StationWait::Arrow { .. } => StationWait::Arrow { station, op, cycle: 7, own };
        StationWait::Agreement { .. } => StationWait::Agreement { station, is_heard: true, ops: op },
            StationWait::Agreement { station, is_heard: false, ops: op };
        StationWait::EntryAgreement { .. } => StationWait::EntryAgreement { station, is_heard: true },
            StationWait::EntryAgreement { station, is_heard: false };
        StationWait::EntryRejected { .. } => StationWait::EntryRejected { station, op: Some(own) },
            StationWait::EntryRejected { station, op: None };
        StationWait::Disagreement { .. } => StationWait::Disagreement { station, op: own, ops: op };
    });
    waits.extend(doubts().into_iter().map(|doubt| StationWait::Rejoin(doubt, RejoinAdvice::NoOperation)));
    waits.extend(advice().into_iter().map(|advice| StationWait::Rejoin(PositionDoubt::NoJournal, advice)));
    waits
}

fn compile_errors() -> Vec<CompileError> {
    let station = || "clamp_1".to_owned();
    samples!(CompileError {
        CompileError::TooManyPaths { .. } => CompileError::TooManyPaths { station: station(), has: 40, most: 32 };
        CompileError::TooManyPeers { .. } => CompileError::TooManyPeers { station: station(), has: 300 };
        CompileError::SnapshotDoesNotFit { .. } => CompileError::SnapshotDoesNotFit { why: "no marked place" };
    })
}

#[test]
fn all_texts_of_a_station() {
    let (line, tasks) = (transfer_line(), task_driven());
    let choices = [StationWait::task_button("PB_run", "machine"), StationWait::task_button("PB_open", "release")];
    let arrow = StationWait::Arrow { station: "clamp_1", op: "close", cycle: 7, own: "advance" }.text();
    let detail = StopCause::Interlock { station: CLAMP, input: Some(INPUT), is_on: false }.detail(&line, TRANSFER);
    let lost = StopCause::PositionLost { op: OP, input: INPUT }.detail(&line, CLAMP);
    let event = |line: &Line, station, what| StationHappening { cycle: 1, what }.text(line, station);
    let lists = [
        listed("causes of a stop", &causes(), |cause| cause.text().to_owned()),
        listed("causes of a stop, with signals", &causes(), |cause| cause.text_of(&line, CLAMP, OP, Block::Normal)),
        listed("events, behind the station", &happenings(), |what| match what {
            HappeningKind::Ordered(_)
            | HappeningKind::OrderDone(_)
            | HappeningKind::OrderFailed(..)
            | HappeningKind::OrderLeft(..)
            | HappeningKind::Securing(_) => event(&tasks, M1, *what),
            HappeningKind::HomeAgain => {
                format!("{}; task-driven: {}", event(&line, CLAMP, *what), event(&tasks, M1, *what))
            }
            _ => event(&line, CLAMP, *what),
        }),
        listed("what is waited for, behind `waits for`", &waits(&choices, &arrow, &detail, &lost), |wait| wait.text()),
        listed("task failures", &failures(), |failure| failure.text()),
        listed("rejected task orders", &refusals(), |refusal| refusal.text().to_owned()),
        listed("ignored inputs", &ignored(), |why| why.text().to_owned()),
        listed("controllers that cannot be made", &compile_errors(), ToString::to_string),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
