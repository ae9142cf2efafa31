//! Limits that were reached, in alarms: of the time of an order, and of the repetitions of an activity. Each with where it is set.

use linewright_cell::NominalLimit;

use crate::exception::RecoveryPolicy;
use crate::firing::{OngoingActivity, OngoingOrder};
use crate::record::ActivityFailure;
use crate::state::PlayerState;

/// The sentences about limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LimitText<'a> {
    /// Behind a failed order: the limit of its time.
    Time { failure: &'a str, seconds: f64, by: TimeLimitOf<'a> },
    /// An activity was begun again as often as its rule allows.
    Repeated { times: u32 },
}

/// Where the limit of an order's time is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeLimitOf<'a> {
    /// `max_s` of the order.
    Order,
    /// `safety` of the cell times `time_s` of the activity, in s.
    Nominal { safety: f64, time: f64 },
    /// `safety` of the cell times the operations of the activity's tasks, in s, where `time_s` is left out.
    Charted { safety: f64, time: f64 },
    /// `limit_s` of the station's task, which is shorter.
    Task { task: &'a str },
}

impl LimitText<'_> {
    pub fn text(self) -> String {
        match self {
            LimitText::Time { failure, seconds, by } => {
                let by = match by {
                    TimeLimitOf::Order => "`max_s` of its order in cell.toml".to_owned(),
                    TimeLimitOf::Nominal { safety, time } => {
                        format!("in cell.toml `safety` = {safety} times `time_s` = {}", tenths(time))
                    }
                    TimeLimitOf::Charted { safety, time } => {
                        format!(
                            "in cell.toml `safety` = {safety} times the {} s of the operations of its tasks",
                            tenths(time)
                        )
                    }
                    TimeLimitOf::Task { task } => format!("`limit_s` of its task \"{task}\" in line.toml"),
                };
                format!("{failure}: {} s, {by}", tenths(seconds))
            }
            LimitText::Repeated { times } => {
                let times = if times == 1 { "once".to_owned() } else { format!("{times} times") };
                format!("repeated {times} already, as often as `retries` of its [[exception]] in cell.toml allows")
            }
        }
    }
}

/// Seconds to a tenth: by clocks of stations and of the coordinator no more is known.
pub(crate) fn tenths(seconds: f64) -> f64 {
    (seconds * 10.0).round() / 10.0
}

/// The limit of an order whose time was over, behind its failure.
pub(crate) fn time(state: &PlayerState, of: &OngoingActivity, order: &OngoingOrder, failure: &str) -> String {
    let (table, handling) = (state.table(), state.table().handling());
    // Its orders are those of the activity, in their order.
    let at = of.orders.iter().position(|other| other.key == order.key);
    let Some((at, template)) = at.and_then(|at| Some((at, table.activity(of.mode).orders.get(at)?))) else {
        return failure.to_owned();
    };
    let nominal = handling.mode(of.mode).nominal.get(at).copied().flatten();
    let own = handling.task_limit(order.station, &template.task).filter(|own| *own < template.limit);
    let (limit, by) = match (own, nominal) {
        (Some(own), _) => (own, TimeLimitOf::Task { task: &template.task }),
        (None, Some(NominalLimit { time, limit, is_charted })) => {
            let time = time.as_secs_f64();
            let safety = (limit.as_secs_f64() / time * 100.0).round() / 100.0;
            let by =
                if is_charted { TimeLimitOf::Charted { safety, time } } else { TimeLimitOf::Nominal { safety, time } };
            (limit, by)
        }
        (None, None) => (template.limit, TimeLimitOf::Order),
    };
    LimitText::Time { failure, seconds: limit.as_secs_f64(), by }.text()
}

/// That a failed activity was repeated as often as its rule allows; none where it may be repeated.
pub(crate) fn repeated(
    state: &PlayerState,
    handling: &RecoveryPolicy,
    of: &OngoingActivity,
    cause: ActivityFailure,
) -> Option<String> {
    let times = state.exceptions().times(of.mode, of.part);
    let most = handling.rule(of.mode, cause).map_or(0, |rule| rule.retries);
    (most > 0 && times >= most).then(|| LimitText::Repeated { times }.text())
}
