//! An activity of a cell as a whole: the real token player, the order protocol, and the real controllers of its stations.
//!
//! Events: an order or a message to leave one arrives, at any time after it was sent, any number of times or never; a
//! station's report arrives late or never; motions arrive and fail, inputs that are waited for come and go; the time of
//! an order is over at the station, at the coordinator, in either order; nodes of stations are started again, with
//! their memories and without, and so is the coordinator; a person gives alarm, before the activity fails or
//! afterwards, and gives any permitted answer as soon as there is an alarm. Afterwards anything may start that uses the
//! same stations.
//!
//! **Why one activity at a time is enough.** What is in progress holds the tokens of all that takes part, so another
//! activity uses none of its stations meanwhile, but for what may start when it is over, which is explored behind it.
//! Activities that share no station have no message, no order and no answer in common: each record of the player
//! concerns one of them. A station without an order of an activity reports nothing that the activity reads. So a state
//! of the whole cell that breaks a rule has, restricted to one activity and what followed it at its stations, a state
//! here that does.
//!
//! **One report under way is enough.** Readers keep the newest. A report that arrives after a later one was sent has the same
//! effect as one that arrived just before that: messages sent because of it may arrive at any later time in both cases.
//!
//! Disturbances, that is faults, restarts, alarms given by hand, reports that arrive late and people who lead a station
//! on or back by one motion in manual mode, are limited in number ([`ProtocolSetting::disturbances`]). What was sent to
//! stations may always be lost, late and doubled. Nothing is explored after the next start at these stations. Not
//! explored: hand mode, emergency stops, what happens while a station is led, sensors that contradict an answer, and a
//! station that is silent for so long that the player goes on without it and records that.

mod players;
mod search;
mod stage;
mod station;
mod words;

use linewright_cell::Cell;
use linewright_coordinator_cell::ProtocolRules;
use linewright_line::Line;
use linewright_station_logic::OrderRules;

pub use stage::NotPlayable;

use super::{CellPath, CellProperty, Verdict};
use crate::explore::{LimitReached, SearchProgress};

/// States of one exploration, unless others are asked for.
pub const STATES: usize = 1_000_000;

/// Subject and extent of an exploration.
#[derive(Clone, Debug)]
pub struct ProtocolSetting<'c> {
    pub cell: &'c Cell,
    pub line: &'c Line,
    /// The player's rules.
    pub rules: ProtocolRules,
    /// The stations' rules.
    pub order_rules: OrderRules,
    /// At most so many faults, restarts, alarms given by hand, reports that arrive late, and motions led by people.
    pub disturbances: u8,
    /// Most states of each exploration.
    pub states: usize,
    /// Most memory of each exploration, about.
    pub bytes: usize,
    /// Only activities of this name, if there is one.
    pub only: Option<&'c str>,
    /// Only this property, if there is one: what else is wrong is passed over, to see what comes of it.
    pub asked: Option<&'static str>,
}

impl<'c> ProtocolSetting<'c> {
    /// All rules, no disturbance: messages are lost, late and doubled, and times run out.
    pub fn new(cell: &'c Cell, line: &'c Line) -> Self {
        ProtocolSetting {
            cell,
            line,
            rules: ProtocolRules::default(),
            order_rules: OrderRules::default(),
            disturbances: 0,
            states: STATES,
            bytes: usize::MAX,
            only: None,
            asked: None,
        }
    }
}

/// One activity, explored.
#[derive(Clone, Debug)]
pub struct ActivityExplored {
    pub name: String,
    pub stations: Vec<String>,
    /// States seen.
    pub states: usize,
    /// Faults, restarts and alarms given by hand were allowed.
    pub disturbed: bool,
    /// Everything was seen, or something wrong.
    pub exhausted: bool,
    /// The limit that ended it before that. None for an activity with too many different messages, where no limit helps.
    pub limit: Option<LimitReached>,
    /// The rule that is broken, if one is.
    pub wrong: Option<BrokenRule>,
}

/// A rule that is broken, and the way there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokenRule {
    pub rule: &'static str,
    /// Steps, in order.
    pub steps: Vec<String>,
    /// Violation at the end.
    pub end: String,
}

/// No station is given an order while it is still at another one.
pub const GIVEN: &str = "no station is given an order while it moves for another one";
/// Tokens are given back only when the stations stand.
pub const RESTORED: &str = "tokens restored only at standstill of the stations";
/// No answer is taken while anything moves.
pub const ANSWERED: &str = "no answer is taken while anything moves";
/// A station does not move by itself after it has reported the end of its order.
pub const ENDED: &str = "a station with an ended order moves only on a secure request";
/// Nothing is done twice.
pub const TWICE: &str = "nothing is done twice";
/// An alarm given by hand stops the stations.
pub const STOPPED: &str = "an alarm raised by hand stops the stations; standstill before the operator is asked";
/// A robot that has come to a clamp does not leave it when the clamp may have closed.
pub const BACK: &str = "a station goes back only while no other station of its activity is in a handshake with it";
/// From every state the activity can be closed, if people lead to a rest what stands between two.
pub const CLOSED: &str = "every activity can be closed";
/// All rules, as named in verdicts.
pub const ALL: [&str; 8] = [GIVEN, RESTORED, ANSWERED, ENDED, TWICE, STOPPED, BACK, CLOSED];

/// Explores every activity of a cell that orders something from stations; those that order the same from the same stations
/// once.
///
/// # Errors
/// When the cell cannot be played.
pub fn check_protocol(setting: &ProtocolSetting<'_>) -> Result<Vec<ActivityExplored>, NotPlayable> {
    check_protocol_watched(setting, &SearchProgress::default(), |_, _, _| ())
}

/// The same, with its progress written down as it goes; `begins` is called before each activity, with its place among them from 1,
/// their number and its name.
///
/// # Errors
/// When the cell cannot be played.
pub fn check_protocol_watched(
    setting: &ProtocolSetting<'_>,
    progress: &SearchProgress,
    mut begins: impl FnMut(usize, usize, &str),
) -> Result<Vec<ActivityExplored>, NotPlayable> {
    // Positions of other stations are not seen here. They keep motions from starting and stop them: a motion that does not
    // arrive, and one that fails.
    let line = setting.line.without_conflicts_of_tasks();
    let setting = &ProtocolSetting { line: &line, ..setting.clone() };
    let stages = stage::stages(setting)?;
    let number = stages.len();
    let one = |(nth, stage): (usize, stage::ActivityStart)| {
        begins(nth + 1, number, &stage.name);
        search::explore(setting, stage, progress)
    };
    Ok(stages.into_iter().enumerate().map(one).collect())
}

/// Properties of a cell that follow.
pub fn properties(found: &[ActivityExplored]) -> Vec<CellProperty> {
    let states: usize = found.iter().map(|one| one.states).sum();
    // Without alarms given by hand this property is left out.
    let asked = ALL.iter().filter(|&&name| name != STOPPED || found.iter().any(|one| one.disturbed));
    let all = asked.map(|&name| {
        let wrong = found.iter().find_map(|one| one.wrong.as_ref().filter(|of| of.rule == name).map(|of| (one, of)));
        let open = found.iter().find(|one| !one.exhausted || one.wrong.is_some());
        let (verdict, reason) = match (wrong, open) {
            (Some((one, of)), _) => (Verdict::Fails, format!("not in {}, after {} steps", one.name, of.steps.len())),
            (None, Some(one)) if one.exhausted => {
                (Verdict::Undecided, format!("{} was looked at until something else was found wrong", one.name))
            }
            (None, Some(one)) => {
                let why = match one.limit {
                    Some(LimitReached::States) => "the limit of states was reached".to_owned(),
                    Some(LimitReached::Memory) => "the limit of memory was reached".to_owned(),
                    None => format!("it has more than {} different messages", search::MESSAGES_MAX),
                };
                (Verdict::Undecided, format!("{}: undecided after {} states: {why}", one.name, one.states))
            }
            (None, None) => (Verdict::Holds, format!("in all {states} states of {} activities", found.len())),
        };
        let story = |(_, of): (&ActivityExplored, &BrokenRule)| CellPath {
            steps: of.steps.clone(),
            end: of.end.clone(),
            resources: Vec::new(),
        };
        CellProperty { name, verdict, reason, help: None, counterexample: wrong.map(story) }
    });
    all.collect()
}
