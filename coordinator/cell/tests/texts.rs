//! All texts of a cell in one list. A new variant without a text, or without a place in the list, does not compile.

use std::time::Duration;

use linewright_coordinator_cell::dispatch::{DispatchRule, Measure};
use linewright_coordinator_cell::exception::{
    AlarmAnswerRefusal, ExceptionStage, LeadDirection, OutOfServiceReason, RecoveryDecision, ResourceRequest, Strategy,
    Whereabouts,
};
use linewright_coordinator_cell::production::{ProductionRefusal, RequestProblem};
use linewright_coordinator_cell::schedule::RevisionReason;
use linewright_coordinator_cell::texts::alarm::{AlarmText, StationStanding};
use linewright_coordinator_cell::texts::{self, CellWait, LimitText, TimeLimitOf, TokenOwner};
use linewright_coordinator_cell::{
    ActivityFailure, AlarmId, BadAnswer, CellId, CellTable, DecidingRule, FiringId, Gain, HoldReason, LostDecision,
    ModeId, OrderFailure, OrderKey, PartId, ProductionCommandError, ProgressComparison, ResourceId, StationUnavailable,
};
use linewright_line::{StationId, Tick};
use linewright_orders::TaskRefusal;

use crate::player::dispatch::rules::machine;
use linewright_testkit::samples::{listed, samples};

const MODE: ModeId = ModeId(5);
const OTHER: ModeId = ModeId(6);
const PART: PartId = PartId(3);
const NAMED: &str = "part 3 (order rush, 2 of 5)";
const FIRING: FiringId = FiringId(12);
const KEY: OrderKey = OrderKey { epoch: 1, id: 5 };
const STATION: StationId = StationId(1);
const RESOURCE: ResourceId = ResourceId(0);

fn failures() -> Vec<OrderFailure> {
    samples!(OrderFailure {
        OrderFailure::Code(_) => OrderFailure::Code(12), OrderFailure::Code(1006);
        OrderFailure::Refused(_) => OrderFailure::Refused(TaskRefusal::Busy);
        OrderFailure::TimedOut => OrderFailure::TimedOut;
        OrderFailure::Forgotten => OrderFailure::Forgotten;
        OrderFailure::Lost => OrderFailure::Lost;
        OrderFailure::DevicesLost => OrderFailure::DevicesLost;
    })
}

fn activity_failures() -> Vec<ActivityFailure> {
    samples!(ActivityFailure {
        ActivityFailure::Order { .. } => ActivityFailure::Order { key: KEY, failure: OrderFailure::TimedOut };
        ActivityFailure::TimedOut => ActivityFailure::TimedOut;
        ActivityFailure::ByHand { .. } => ActivityFailure::ByHand { resource: RESOURCE };
    })
}

fn out_of_service() -> Vec<OutOfServiceReason> {
    samples!(OutOfServiceReason {
        OutOfServiceReason::ByHand { .. } => OutOfServiceReason::ByHand { text: String::new() },
            OutOfServiceReason::ByHand { text: "new tool".to_owned() };
        OutOfServiceReason::Alarm { .. } => OutOfServiceReason::Alarm { text: String::new() },
            OutOfServiceReason::Alarm { text: "smoke".to_owned() };
        OutOfServiceReason::Rule(_) => OutOfServiceReason::Rule(FIRING);
        OutOfServiceReason::Station(_) => OutOfServiceReason::Station(FIRING);
        OutOfServiceReason::Unheard(_) => OutOfServiceReason::Unheard(FIRING);
        OutOfServiceReason::Mismatch => OutOfServiceReason::Mismatch;
        OutOfServiceReason::Rest => OutOfServiceReason::Rest;
        OutOfServiceReason::EmergencyStop(_) => OutOfServiceReason::EmergencyStop(FIRING);
    })
}

/// A measure has private fields; it is read as the log has it.
fn measures() -> Vec<Measure> {
    let rules = samples!(DispatchRule {
        DispatchRule::Fifo => DispatchRule::Fifo;
        DispatchRule::ShortestProcessingTime => DispatchRule::ShortestProcessingTime;
        DispatchRule::EarliestDueDate => DispatchRule::EarliestDueDate;
        DispatchRule::LeastSlack => DispatchRule::LeastSlack;
        DispatchRule::CriticalRatio => DispatchRule::CriticalRatio;
        DispatchRule::Priority => DispatchRule::Priority;
        DispatchRule::Schedule => DispatchRule::Schedule;
    });
    let of = |rule: DispatchRule, class: u8, value: i64| {
        let text = format!(r#"{{"rule":"{rule}","class":{class},"value":{value},"over":1000000}}"#);
        serde_json::from_str(&text).expect("a measure as the log has it")
    };
    let first = |rule: DispatchRule| match rule {
        DispatchRule::Fifo | DispatchRule::EarliestDueDate | DispatchRule::Schedule => -2_000_000,
        DispatchRule::ShortestProcessingTime | DispatchRule::LeastSlack | DispatchRule::CriticalRatio => 3_000_000,
        DispatchRule::Priority => -5,
    };
    rules.into_iter().flat_map(|rule| [of(rule, 0, first(rule)), of(rule, 1, 3_000_000), of(rule, 2, 0)]).collect()
}

fn deciding_rules() -> Vec<DecidingRule> {
    let (theirs, ours) = (measures()[0], measures()[1]);
    samples!(DecidingRule {
        DecidingRule::Waited => DecidingRule::Waited;
        DecidingRule::Helps { .. } => DecidingRule::Helps { part: Some(PART) }, DecidingRule::Helps { part: None };
        DecidingRule::Inside => DecidingRule::Inside;
        DecidingRule::Rule { .. } => DecidingRule::Rule { rule: DispatchRule::Fifo, theirs, ours };
        DecidingRule::Order => DecidingRule::Order;
    })
}

fn gains() -> Vec<Gain> {
    let by = Duration::from_secs(4);
    samples!(Gain {
        Gain::Tardiness(_) => Gain::Tardiness(by);
        Gain::Work(_) => Gain::Work(by);
        Gain::Makespan(_) => Gain::Makespan(by);
        Gain::Flow(_) => Gain::Flow(by);
        Gain::Nothing => Gain::Nothing;
    })
}

fn hold_reasons() -> Vec<HoldReason> {
    let lost = |by| HoldReason::LostTo(LostDecision { to: OTHER, with: Some(PART), own: None, by });
    let worse = |instead, gain| HoldReason::LooksWorse(ProgressComparison { instead, gain });
    let mut reasons = samples!(HoldReason {
        HoldReason::LostTo(_) => lost(DecidingRule::Inside);
        HoldReason::NotYet(_) => HoldReason::NotYet(Tick::from_millis(61_000));
        HoldReason::ReservedFor { .. } => HoldReason::ReservedFor { part: Some(PART), mode: OTHER },
            HoldReason::ReservedFor { part: None, mode: OTHER };
        HoldReason::NotOrdered => HoldReason::NotOrdered;
        HoldReason::PlannedOtherwise(_) => HoldReason::PlannedOtherwise(OTHER);
        HoldReason::LooksWorse(_) => worse(None, Gain::Nothing);
    });
    reasons.extend(deciding_rules().into_iter().map(lost));
    let own = Some(PART);
    reasons.push(HoldReason::LostTo(LostDecision { to: OTHER, with: own, own, by: DecidingRule::Order }));
    reasons.extend(gains().into_iter().map(|gain| worse(Some((OTHER, Some(PART))), gain)));
    reasons
}

fn bad_answers() -> Vec<BadAnswer> {
    samples!(BadAnswer {
        BadAnswer::NoCandidate(_) => BadAnswer::NoCandidate(4);
        BadAnswer::Part { .. } => BadAnswer::Part { mode: MODE, part: Some(PART) },
            BadAnswer::Part { mode: MODE, part: None };
        BadAnswer::PartTwice(_) => BadAnswer::PartTwice(PART);
        BadAnswer::TooOften(_) => BadAnswer::TooOften(MODE);
        BadAnswer::NotCovered(_) => BadAnswer::NotCovered(CellId(2));
    })
}

fn revisions() -> Vec<RevisionReason> {
    samples!(RevisionReason {
        RevisionReason::First => RevisionReason::First;
        RevisionReason::Orders => RevisionReason::Orders;
        RevisionReason::Failed(_) => RevisionReason::Failed(FIRING);
        RevisionReason::Down(_) => RevisionReason::Down(RESOURCE);
        RevisionReason::Restored => RevisionReason::Restored;
        RevisionReason::Late { .. } =>
            RevisionReason::Late { mode: MODE, part: Some(PART), by: Duration::from_millis(1500) };
        RevisionReason::Over => RevisionReason::Over;
        RevisionReason::Ahead => RevisionReason::Ahead;
        RevisionReason::Stray(..) => RevisionReason::Stray(MODE, Some(PART));
    })
}

fn standings() -> Vec<StationStanding> {
    samples!(StationStanding {
        StationStanding::EmergencyStop => StationStanding::EmergencyStop;
        StationStanding::Done => StationStanding::Done;
        StationStanding::AtRest => StationStanding::AtRest;
        StationStanding::Held => StationStanding::Held;
        StationStanding::AtOrder => StationStanding::AtOrder;
        StationStanding::Unknown => StationStanding::Unknown;
        StationStanding::StoreReset => StationStanding::StoreReset;
        StationStanding::NotBegun => StationStanding::NotBegun;
    })
}

type Way = (&'static str, &'static str, bool);

fn wrong_rest(has_part: bool) -> AlarmText<'static> {
    let (resource, station, stands, wanted, next) = ("M1", "m1", "clamped", "open", "load M1");
    AlarmText::WrongRest { resource, station, stands, wanted, next, has_part, bring: "Bring m1 to \"open\": …." }
}

fn bring(way: Option<Way>, back: Option<(&'static str, &'static str)>) -> AlarmText<'static> {
    AlarmText::Bring { station: "m1", wanted: "open", way, back, too: &[] }
}

static BOTH: std::sync::LazyLock<[String; 2]> = std::sync::LazyLock::new(|| ["robot", "m1"].map(str::to_owned));
static STOPPED: std::sync::LazyLock<[String; 1]> = std::sync::LazyLock::new(|| ["robot".to_owned()]);

fn alarms() -> Vec<AlarmText<'static>> {
    let (activity, again, found) = ("load M1", "M1 failed. Answer where the part is.", "M1: part expected, sensor off");
    samples!(AlarmText<'static> {
        AlarmText::Failed { .. } => AlarmText::Failed { activity, part: Some(NAMED) },
            AlarmText::Failed { activity, part: None };
        AlarmText::WithFacts { .. } => AlarmText::WithFacts { tell: again, facts: "load M1: …" };
        AlarmText::LeadFirst { .. } => AlarmText::LeadFirst { stopped: &[], stations: &*STOPPED, why: None, then: again },
            AlarmText::LeadFirst { stopped: &*STOPPED, stations: &*BOTH, why: None, then: again },
            AlarmText::LeadFirst { stopped: &[], stations: &*STOPPED, why: Some((LeadDirection::On, "m1 …")), then: again },
            AlarmText::LeadFirst { stopped: &[], stations: &*STOPPED, why: Some((LeadDirection::Back, "m1 …")), then: again };
        AlarmText::Meaning { .. } =>
            AlarmText::Meaning { part: Whereabouts::To, then: Strategy::Forward, at: "part at M1" },
            AlarmText::Meaning { part: Whereabouts::From, then: Strategy::Backward, at: "part at ST" },
            AlarmText::Meaning { part: Whereabouts::From, then: Strategy::Redo, at: "part at ST" },
            AlarmText::Meaning { part: Whereabouts::Gone, then: Strategy::Backward, at: "part gone" };
        AlarmText::PartAt { .. } => AlarmText::PartAt { place: "M1" };
        AlarmText::PartGone => AlarmText::PartGone;
        AlarmText::MeansUp => AlarmText::MeansUp;
        AlarmText::Completed { .. } => AlarmText::Completed { station: "m1" };
        AlarmText::AtEnd { .. } => AlarmText::AtEnd { station: "m1" };
        AlarmText::AtBeginning { .. } => AlarmText::AtBeginning { station: "m1" };
        AlarmText::OnlyDone => AlarmText::OnlyDone;
        AlarmText::OnlyBefore => AlarmText::OnlyBefore;
        AlarmText::WrongRest { .. } => wrong_rest(false), wrong_rest(true);
        AlarmText::OtherRest { .. } =>
            AlarmText::OtherRest { station: "m1", stands: "clamped", wanted: "open", bring: "Bring m1 to \"open\": …." };
        AlarmText::Bring { .. } => bring(Some(("PB_clear_1", "clear", false)), None),
            bring(Some(("PB_load_1", "clamp", true)), None),
            bring(Some(("PB_unload_1", "release", true)), Some(("PB_back_1", "clamp"))),
            bring(None, Some(("PB_back_1", "clamp"))), bring(None, None);
        AlarmText::Facts { .. } => AlarmText::Facts { activity: Some(activity), cause: "m1: time limit exceeded", seconds: 26.0 },
            AlarmText::Facts { activity: None, cause: "m1: time limit exceeded", seconds: 26.0 };
        AlarmText::Contradicted { .. } => AlarmText::Contradicted { word: "in-machine", found };
        AlarmText::Moved { .. } => AlarmText::Moved { station: "robot", word: "as-before" };
        AlarmText::LedByHand { .. } => AlarmText::LedByHand { station: "robot", word: "as-before" };
        AlarmText::Because { .. } =>
            AlarmText::Because {
                failure: "robot: awaited input not on in time (code 32)",
                detail: "lathe_chucked at `carry to the lathe`",
            },
            AlarmText::Because {
                failure: "robot: station fault",
                detail: "carry to the lathe: watchdog: at_lathe (robot io, node 11h, 6000h:01 bit 3) not on within 1 s",
            };
        AlarmText::LeftWaiting { .. } =>
            AlarmText::LeftWaiting { station: "lathe", inputs: Some("part_present"), code: 12 },
            AlarmText::LeftWaiting { station: "lathe", inputs: None, code: 12 };
        AlarmText::Agrees { .. } => AlarmText::Agrees { resource: "M1" };
        AlarmText::Carried => AlarmText::Carried;
        AlarmText::Mismatch { .. } => AlarmText::Mismatch { found, missing: None, bring: None },
            AlarmText::Mismatch { found, missing: Some(NAMED), bring: None },
            AlarmText::Mismatch { found, missing: None, bring: Some("Bring m1 to \"open\": ….") };
        AlarmText::PartGivenUp { .. } => AlarmText::PartGivenUp { resource: "M1" };
        AlarmText::GivenUp { .. } => {
            AlarmText::GivenUp { found: "The part of M1 is given up.", resource: "M1", why: "m1: no state received" }
        };
        AlarmText::MovesToo { .. } => AlarmText::MovesToo { button: "PB_load_1", station: "robot" };
        AlarmText::PartMissing { .. } => AlarmText::PartMissing { resource: "M1" };
        AlarmText::PartUnexpected { .. } => AlarmText::PartUnexpected { resource: "M1" };
    })
}

fn unavailable() -> Vec<StationUnavailable> {
    samples!(StationUnavailable {
        StationUnavailable::Inactive => StationUnavailable::Inactive;
        StationUnavailable::Devices => StationUnavailable::Devices;
        StationUnavailable::Incomplete => StationUnavailable::Incomplete;
        StationUnavailable::ByHand => StationUnavailable::ByHand;
        StationUnavailable::InManual => StationUnavailable::InManual;
    })
}

fn answer_refusals() -> Vec<AlarmAnswerRefusal> {
    let mut refusals = samples!(AlarmAnswerRefusal {
        AlarmAnswerRefusal::NoSuchAlarm => AlarmAnswerRefusal::NoSuchAlarm;
        AlarmAnswerRefusal::NoSuchWord => AlarmAnswerRefusal::NoSuchWord;
        AlarmAnswerRefusal::NoSuchResource => AlarmAnswerRefusal::NoSuchResource;
        AlarmAnswerRefusal::AlreadySo => AlarmAnswerRefusal::AlreadySo;
        AlarmAnswerRefusal::Moves(_) => AlarmAnswerRefusal::Moves(STATION);
        AlarmAnswerRefusal::HasPart(_) => AlarmAnswerRefusal::HasPart(RESOURCE);
        AlarmAnswerRefusal::HasNoPart(_) => AlarmAnswerRefusal::HasNoPart(RESOURCE);
        AlarmAnswerRefusal::NotHeard(_) => AlarmAnswerRefusal::NotHeard(STATION);
        AlarmAnswerRefusal::Unheard(..) => AlarmAnswerRefusal::Unheard(STATION, RESOURCE);
        AlarmAnswerRefusal::NotAtRest(_) => AlarmAnswerRefusal::NotAtRest(STATION);
        AlarmAnswerRefusal::CannotWork(..) => AlarmAnswerRefusal::CannotWork(STATION, StationUnavailable::Devices);
        AlarmAnswerRefusal::WrongRest(_) => AlarmAnswerRefusal::WrongRest(RESOURCE);
        AlarmAnswerRefusal::Contradicted(_) => AlarmAnswerRefusal::Contradicted(RESOURCE);
        AlarmAnswerRefusal::Open(_) => AlarmAnswerRefusal::Open(RESOURCE);
        AlarmAnswerRefusal::EmergencyStop(_) => AlarmAnswerRefusal::EmergencyStop(STATION);
    });
    refusals.extend(unavailable().into_iter().map(|why| AlarmAnswerRefusal::CannotWork(STATION, why)));
    refusals
}

fn answer_refused(why: AlarmAnswerRefusal, asked: ResourceRequest) -> String {
    why.text(asked, |_| "m1".to_owned(), |_| "M1".to_owned(), |_| "up, gone".to_owned())
}

fn waits() -> Vec<CellWait<'static>> {
    samples!(CellWait<'static> {
        CellWait::NotInCell(_) => CellWait::NotInCell(PART);
        CellWait::UnderWay { .. } => CellWait::UnderWay { part: NAMED, activity: "`load M1`, 3 s left" };
        CellWait::Resting { .. } => CellWait::Resting { part: NAMED, place: "in M1", seconds: 8.5 };
        CellWait::NoWay => CellWait::NoWay;
        CellWait::Activity { .. } => CellWait::Activity { activity: "`unload M1`", why: "no `slot` yet" };
        CellWait::First(_) => CellWait::First(NAMED);
        CellWait::Tokens { .. } => CellWait::Tokens { owners: "no `slot` yet", held: None },
            CellWait::Tokens { owners: "no `slot` yet", held: Some((61.0, "scheduled next: `load M2`")) };
        CellWait::InProgress => CellWait::InProgress;
        CellWait::Ready => CellWait::Ready;
        CellWait::Uncompared { .. } => CellWait::Uncompared { resource: "M1" };
        CellWait::OutOfService { .. } =>
            CellWait::OutOfService { resource: "M1", seconds: 9.0, why: "sensor contradicts the model" };
        CellWait::InService { .. } => CellWait::InService { resource: "M1" };
        CellWait::Failed => CellWait::Failed;
        CellWait::ToCountOn { .. } => CellWait::ToCountOn { resource: "M1" };
        CellWait::TakesPart { .. } => CellWait::TakesPart { activity: "`load M1`, 3 s left" };
    })
}

fn owners(by: &[String]) -> Vec<TokenOwner<'_>> {
    let name = "slot";
    samples!(TokenOwner<'_> {
        TokenOwner::InUse { .. } => TokenOwner::InUse { name, by };
        TokenOwner::Returned { .. } => TokenOwner::Returned { name, by };
        TokenOwner::NotYet { .. } => TokenOwner::NotYet { name };
        TokenOwner::Never { .. } => TokenOwner::Never { name };
    })
}

fn stages() -> Vec<ExceptionStage> {
    let ruling = RecoveryDecision { word: "up".to_owned(), part: Whereabouts::From, then: Strategy::Redo };
    samples!(ExceptionStage {
        ExceptionStage::Securing => ExceptionStage::Securing;
        ExceptionStage::Waiting(_) => ExceptionStage::Waiting(AlarmId(3));
        ExceptionStage::Restoring { .. } => ExceptionStage::Restoring { ruling: ruling.clone(), since: Tick::ZERO };
    })
}

fn requests() -> Vec<RequestProblem> {
    let name = || "batch 7".to_owned();
    let other = || "batch 6".to_owned();
    let hint = || Some("did you mean `A`?".to_owned());
    let (due, release) = (Tick::from_millis(8_000), Tick::from_millis(9_000));
    samples!(RequestProblem {
        RequestProblem::Name(_) => RequestProblem::Name(String::new());
        RequestProblem::NameTaken(_) => RequestProblem::NameTaken(name());
        RequestProblem::NameTwice(_) => RequestProblem::NameTwice(name());
        RequestProblem::KeyTaken { .. } => RequestProblem::KeyTaken { name: name(), other: other() };
        RequestProblem::Product { .. } =>
            RequestProblem::Product { name: name(), product: "C".to_owned(), hint: hint() };
        RequestProblem::Quantity { .. } => RequestProblem::Quantity { name: name(), quantity: 0 };
        RequestProblem::DueBeforeRelease { .. } => RequestProblem::DueBeforeRelease { name: name(), due, release };
        RequestProblem::NoSuchOrder { .. } =>
            RequestProblem::NoSuchOrder { name: name(), after: other(), hint: None };
        RequestProblem::AfterWithdrawn { .. } => RequestProblem::AfterWithdrawn { name: name(), after: other() };
        RequestProblem::Circle(_) => RequestProblem::Circle(vec![name(), other()]);
        RequestProblem::TooMany { .. } => RequestProblem::TooMany { open: 10_001 };
    })
}

fn production_refusals() -> Vec<ProductionRefusal> {
    let name = || "batch 7".to_owned();
    samples!(ProductionRefusal {
        ProductionRefusal::Unknown { .. } => ProductionRefusal::Unknown { name: name(), hint: None };
        ProductionRefusal::Over(_) => ProductionRefusal::Over(name());
        ProductionRefusal::Begun { .. } => ProductionRefusal::Begun { name: name(), entered: 6 };
        ProductionRefusal::Needed { .. } => ProductionRefusal::Needed { name: name(), by: "batch 8".to_owned() };
    })
}

fn command_errors() -> Vec<ProductionCommandError> {
    samples!(ProductionCommandError {
        ProductionCommandError::Request(_) => ProductionCommandError::Request(requests()[..2].to_vec());
        ProductionCommandError::Order(_) => ProductionCommandError::Order(production_refusals()[0].clone());
        ProductionCommandError::Superseded => ProductionCommandError::Superseded;
    })
}

fn limits() -> Vec<LimitText<'static>> {
    let time = |by| LimitText::Time { failure: "m1: time limit exceeded", seconds: 9.000_6, by };
    samples!(LimitText<'static> {
        LimitText::Time { .. } =>
            time(TimeLimitOf::Order), time(TimeLimitOf::Nominal { safety: 2.0, time: 4.5 }),
            time(TimeLimitOf::Charted { safety: 2.0, time: 4.5 }), time(TimeLimitOf::Task { task: "clamp" });
        LimitText::Repeated { .. } => LimitText::Repeated { times: 1 }, LimitText::Repeated { times: 3 };
    })
}

fn of_decisions(table: &CellTable) -> Vec<String> {
    let lost = HoldReason::LostTo(LostDecision { to: OTHER, with: None, own: Some(PART), by: DecidingRule::Inside });
    let decision = texts::decision(table, &[(MODE, Some(PART)), (OTHER, None)], &[(MODE, lost)]);
    vec![
        listed("why an activity is held", &hold_reasons(), |reason| texts::reason(table, reason)),
        listed("what rules measure", &measures(), |measure| format!("{}: {measure}", measure.rule)),
        format!("a decision\n  {}\n", decision.join("\n  ")),
        listed("decisions that are not valid", &bad_answers(), ToString::to_string),
        listed("why a schedule is made anew", &revisions(), |reason| reason.text(table)),
    ]
}

#[test]
fn all_texts_of_a_cell() {
    let by = ["`load M1` with part 3".to_owned(), "`load M2` with part 4".to_owned()];
    let mut lists = vec![
        listed("rejected task orders", &TaskRefusal::ALL, |refusal| refusal.text().to_owned()),
        listed("failed task orders", &failures(), ToString::to_string),
        listed("failed task orders, with the station", &failures(), |failure| failure.text_of("m1")),
        listed("failed activities, in reports", &activity_failures(), |cause| cause.summary()),
        listed("failed activities", &activity_failures(), |cause| cause.text_of("m1", "M1")),
        listed("stations of a failed activity, behind their names", &standings(), |how| how.text().to_owned()),
        listed("alarms", &alarms(), |alarm| alarm.text()),
        listed("limits, in alarms", &limits(), |limit| limit.text()),
        listed("rejected answers", &answer_refusals(), |why| answer_refused(*why, ResourceRequest::Answer(AlarmId(3)))),
        listed("rejected resets", &answer_refusals(), |why| answer_refused(*why, ResourceRequest::Reset(STATION))),
        listed("resources out of service", &out_of_service(), |why| why.text("`load M1` with part 3")),
        listed("resources out of service, in reports", &out_of_service(), |why| why.summary()),
        listed("why a part does not go on", &waits(), |wait| wait.text()),
        listed("where tokens are", &owners(&by), |owner| owner.text()),
        listed("failed activities in progress", &stages(), |stage| texts::failed("`load M1`", Some(stage))),
        listed("problems of requests", &requests(), ToString::to_string),
        listed("rejected changes of production orders", &production_refusals(), ToString::to_string),
        listed("rejected requests", &command_errors(), ToString::to_string),
    ];
    lists.extend(of_decisions(&machine().table));
    insta::assert_snapshot!(lists.join("\n"));
}
