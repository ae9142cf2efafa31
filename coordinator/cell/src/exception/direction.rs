//! Which way the stations of a failed activity are led: all on, or all back.
//!
//! An activity ends as a whole: it is done at every station, or at none. So a station that has completed its order decides for the
//! others, and so does one that stands where its order began. Where neither is so, and every answer leaves the part on the same side,
//! the answers decide; else a person may choose, once for all stations.

use linewright_line::{StationId, Tick};

use super::super::firing::{OngoingActivity, OngoingOrder};
use super::super::player::Coordination;
use super::fact::{AlarmSubject, SecuredState, Whereabouts};
use super::policy::RestTask;
use crate::texts::alarm::StationStanding;

/// A way out of a task that was stopped half-way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeadDirection {
    /// To the end of the task.
    On,
    /// To where it began.
    Back,
}

/// Reason for a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeadReason {
    /// This station has completed its order.
    Completed(StationId),
    /// This station has been led to the end of its task.
    LedToEnd(StationId),
    /// The activity can only be answered as done.
    OnlyDone,
    /// The activity can only be answered as not done.
    OnlyBefore,
    /// This station stands where its order began.
    AtBeginning(StationId),
}

/// Stations that are to be led by hand before an alarm can be answered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StationsToLead {
    /// Between two rests.
    pub lead: Vec<StationId>,
    /// Those of them that are in emergency stop by themselves.
    pub reset: Vec<StationId>,
    /// Those that still have an order of what has failed: they end it by themselves, in auto. Until then no answer is taken.
    pub at_order: Vec<StationId>,
    /// Why they are led on or back; none where either will do, for all of them alike.
    pub reason: Option<LeadReason>,
}

impl LeadReason {
    pub const fn direction(self) -> LeadDirection {
        match self {
            LeadReason::Completed(_) | LeadReason::LedToEnd(_) | LeadReason::OnlyDone => LeadDirection::On,
            LeadReason::OnlyBefore | LeadReason::AtBeginning(_) => LeadDirection::Back,
        }
    }
}

impl Coordination {
    /// Stations of a failed activity that stand between two rests, and which way they are led.
    pub(crate) fn stations_to_lead(&self, now: Tick, firing: &OngoingActivity) -> StationsToLead {
        let is_held = |order: &&OngoingOrder| self.standing_if_reset(now, firing.id, order) == StationStanding::Held;
        let lead: Vec<StationId> = firing.orders.iter().filter(is_held).map(|order| order.station).collect();
        let is_stopped = |station: &StationId| self.state().exceptions().is_stopped(*station);
        let reset = lead.iter().copied().filter(is_stopped).collect();
        let reason = if lead.is_empty() { None } else { self.lead_reason(now, firing) };
        let mut at_order: Vec<StationId> = self.moving(now, firing).collect();
        at_order.sort_unstable();
        at_order.dedup();
        StationsToLead { lead, reset, at_order, reason }
    }

    fn lead_reason(&self, now: Tick, firing: &OngoingActivity) -> Option<LeadReason> {
        let stands = |order: &OngoingOrder| self.standing_if_reset(now, firing.id, order);
        let orders = firing.orders.iter().enumerate();
        let known = orders.filter_map(|(at, order)| match stands(order) {
            standing @ (StationStanding::Done | StationStanding::AtRest | StationStanding::NotBegun) => {
                self.reached(now, firing, at, standing)
            }
            StationStanding::Held
            | StationStanding::EmergencyStop
            | StationStanding::AtOrder
            | StationStanding::Unknown
            | StationStanding::StoreReset => None,
        });
        let known: Vec<LeadReason> = known.collect();
        let of = |direction| known.iter().copied().find(move |reason| reason.direction() == direction);
        of(LeadDirection::On).or_else(|| self.by_answers(firing)).or_else(|| of(LeadDirection::Back))
    }

    /// The end of its task at which a station rests: a person may have led it away from where its order left it. Where the task ends
    /// at the rest where it began, the rest alone does not show it, and the record counts: one that went there by itself went back,
    /// of one that was led there it is not known.
    fn reached(&self, now: Tick, firing: &OngoingActivity, at: usize, standing: StationStanding) -> Option<LeadReason> {
        let order = firing.orders.get(at)?;
        let rest = self.fresh(now, order.station).and_then(|heard| heard.rest);
        let way = self.way_of(firing, at, order.station).filter(|task| task.from != task.to);
        let is_done = standing == StationStanding::Done;
        if let (Some(rest), Some(task)) = (rest, way) {
            return match (rest == task.from, rest == task.to) {
                (true, _) => Some(LeadReason::AtBeginning(order.station)),
                (_, true) if is_done => Some(LeadReason::Completed(order.station)),
                (_, true) => Some(LeadReason::LedToEnd(order.station)),
                (false, false) => None,
            };
        }
        if is_done {
            return Some(LeadReason::Completed(order.station));
        }
        let went_itself = self.state().exceptions().stands(firing.id, order.key) == Some(SecuredState::AtRest);
        (went_itself || standing == StationStanding::NotBegun).then_some(LeadReason::AtBeginning(order.station))
    }

    /// The task of an order, as a way from rest to rest.
    fn way_of(&self, firing: &OngoingActivity, at: usize, station: StationId) -> Option<&RestTask> {
        let table = self.state().table();
        let name = &table.activity(firing.mode).orders.get(at)?.task;
        let of = table.handling().rests.iter().find(|of| of.station == station)?;
        of.tasks.iter().find(|task| task.name == *name)
    }

    /// The direction after which something can be answered, where that is one alone.
    fn by_answers(&self, firing: &OngoingActivity) -> Option<LeadReason> {
        let about = AlarmSubject::Firing(firing.id);
        let alarm = self.state().exceptions().alarms().find(|alarm| alarm.about == about);
        // Those of the alarm that stands, which a person sees; of the rule before there is one.
        let answers: Vec<_> = match alarm {
            Some(alarm) => self.rulings(alarm.id),
            None => {
                let (_, cause) = self.failed(firing.id)?;
                self.answers(firing, cause).into_iter().map(|answer| answer.ruling).collect()
            }
        };
        let has = |part| answers.iter().any(|answer| answer.part == part);
        match (has(Whereabouts::From), has(Whereabouts::To)) {
            (false, true) => Some(LeadReason::OnlyDone),
            (true, false) => Some(LeadReason::OnlyBefore),
            (true, true) | (false, false) => None,
        }
    }
}
