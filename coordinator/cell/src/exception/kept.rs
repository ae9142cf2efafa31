//! Form of exceptions in a snapshot.

use linewright_line::StationId;
use serde::{Deserialize, Serialize};

use super::super::firing::ActivityPhase;
use super::super::ids::{AlarmId, FiringId, ModeId, NUMBER_MAX, OrderKey, PartId, ResourceId};
use super::super::state::PlayerState;
use super::book::{Alarm, ExceptionStage, Exceptions, FailedActivity, OutOfService, Retry};
use super::fact::AlarmSubject;

/// Exceptions to be written down.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedExceptions {
    open: Vec<(FiringId, FailedActivity)>,
    alarms: Vec<Alarm>,
    down: Vec<(ResourceId, OutOfService)>,
    retries: Vec<(ModeId, Option<PartId>, Retry)>,
    #[serde(default)]
    stopped: Vec<(u16, FiringId)>,
    /// Of snapshots of earlier versions; no order of an activity that is over is gone back from any more.
    #[serde(default, skip_serializing)]
    unstopped: Vec<(u16, OrderKey)>,
    last_alarm: u64,
    scrapped: u64,
}

impl Exceptions {
    /// Their parts, to be written down.
    pub(in super::super) fn kept(&self) -> SavedExceptions {
        SavedExceptions {
            open: self.open.iter().map(|(&firing, trouble)| (firing, trouble.clone())).collect(),
            alarms: self.alarms.values().cloned().collect(),
            down: self.down.iter().map(|(&resource, down)| (resource, down.clone())).collect(),
            retries: self.retries.iter().map(|(&(mode, part), &retry)| (mode, part, retry)).collect(),
            stopped: self.stopped.iter().map(|(&StationId(station), &firing)| (station, firing)).collect(),
            unstopped: Vec::new(),
            last_alarm: self.last_alarm,
            scrapped: self.scrapped,
        }
    }
}

impl PlayerState {
    /// Takes exceptions over into a state that has everything else, and has none yet.
    ///
    /// # Errors
    /// Reason why they are none of this state.
    pub(in super::super) fn with_exceptions(mut self, of: SavedExceptions) -> Result<Self, String> {
        if of.last_alarm >= NUMBER_MAX || of.scrapped >= NUMBER_MAX {
            return Err("counter out of range".to_owned());
        }
        let mut new = Exceptions { last_alarm: of.last_alarm, scrapped: of.scrapped, ..Exceptions::default() };
        let (open, alarms, down, retries) = (of.open.len(), of.alarms.len(), of.down.len(), of.retries.len());
        new.open = of.open.into_iter().collect();
        new.alarms = of.alarms.into_iter().map(|alarm| (alarm.id, alarm)).collect();
        new.down = of.down.into_iter().collect();
        new.retries = of.retries.into_iter().map(|(mode, part, retry)| ((mode, part), retry)).collect();
        new.stopped = of.stopped.into_iter().map(|(station, firing)| (StationId(station), firing)).collect();
        let handling = self.table().handling();
        if let Some(station) = new.stopped.keys().find(|id| !handling.knows_station(**id)) {
            return Err(format!("station {} in it is none of this cell", station.0));
        }
        let has = (new.open.len(), new.alarms.len(), new.down.len(), new.retries.len());
        if has != (open, alarms, down, retries) {
            return Err("something of an exception is in it twice".to_owned());
        }
        self.fits(&new)?;
        self.exceptions = new;
        self.block_down();
        Ok(self)
    }

    fn fits(&self, of: &Exceptions) -> Result<(), String> {
        let failed =
            self.firings.values().filter(|firing| firing.phase != ActivityPhase::Running).map(|firing| firing.id);
        if !failed.eq(of.open.keys().copied()) {
            return Err("the exceptions in it are not those of what has failed".to_owned());
        }
        let resources = self.table.handling();
        if of.down.keys().any(|&id| resources.resource(id).is_none()) {
            return Err("a resource is down that there is not".to_owned());
        }
        if of.retries.keys().any(|&(mode, _)| !self.table.has_mode(mode)) {
            return Err("something is tried again that there is not".to_owned());
        }
        for (id, trouble) in &of.open {
            let orders = &self.firings[id].orders;
            if trouble.standing.iter().any(|(key, _)| orders.iter().all(|order| order.key != *key)) {
                return Err(format!("station state recorded for an order that does not belong to {id}"));
            }
            if let ExceptionStage::Waiting(alarm) = trouble.stage
                && of.alarms.get(&alarm).is_none_or(|alarm| alarm.about != AlarmSubject::Firing(*id))
            {
                return Err(format!("{id} waits for an alarm that does not exist"));
            }
        }
        of.alarms.values().try_for_each(|alarm| {
            let AlarmId(number) = alarm.id;
            let fits = number >= 1
                && number <= of.last_alarm
                && match alarm.about {
                    AlarmSubject::Firing(id) => {
                        of.open.get(&id).is_some_and(|trouble| trouble.stage == ExceptionStage::Waiting(alarm.id))
                    }
                    AlarmSubject::Resource(id) => resources.resource(id).is_some(),
                };
            if fits { Ok(()) } else { Err(format!("{} is about nothing", alarm.id)) }
        })
    }
}
