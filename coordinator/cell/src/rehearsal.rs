//! What would become of an answer to an alarm if it were given now: played by a copy of the coordination that is thrown away.
//!
//! So the verdict is that of the rules by which answers are judged, and there are no others: whether it is refused, and whether the sensors,
//! as they were received last, contradict it.

use linewright_line::{StationId, Tick};

use crate::exception::{AlarmAnswerRefusal, AlarmSubject, ExceptionStep, Presence, SensorMismatch, Whereabouts};
use crate::fifo::Fifo;
use crate::ids::{AlarmId, ModeId, ResourceId};
use crate::orders::{CellEvent, PlayerInput, PlayerOutbox, TaskReport};
use crate::player::Coordination;
use crate::record::RecordKind;

/// What becomes of an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AnswerVerdict {
    /// It is refused at once.
    Refused(AlarmAnswerRefusal),
    /// Sensors contradict it: it is asked for again.
    Contradicted(Vec<SensorMismatch>),
    /// It is taken. Sensors confirm it but for these resources, where none sees what it claims: a person has to look.
    Taken { unseen: Vec<ResourceId> },
    /// It is taken. The part is at this resource before its activity and afterwards, and the sensor there sees it both times: a
    /// person has to look whether it was worked on.
    WorkUnseen { at: ResourceId },
    /// It depends on what is not known now: these stations are not received.
    Open { silent: Vec<StationId> },
}

impl Coordination {
    /// The verdict on an answer, by the reports of stations that were received last.
    pub fn rehearsed(
        &self,
        now: Tick,
        alarm: AlarmId,
        word: &str,
        reports: &[(StationId, &TaskReport)],
    ) -> AnswerVerdict {
        let Some(about) = self.state().exceptions().alarm(alarm).map(|alarm| alarm.about) else {
            return AnswerVerdict::Refused(AlarmAnswerRefusal::NoSuchAlarm);
        };
        let mut copy = self.clone();
        // Nothing else is begun meanwhile.
        copy.starts = false;
        let mut out = PlayerOutbox::default();
        copy.step(now, &[PlayerInput::Answer { alarm, word }], &mut Fifo, &mut out);
        if let Some(why) = out.events.iter().find_map(refusal) {
            return AnswerVerdict::Refused(why);
        }
        // Sensors are compared by reports that are newer than the answer.
        let later = now.max(copy.state().now()) + copy.state().table().repeat_interval();
        let newer: Vec<PlayerInput<'_>> =
            reports.iter().map(|&(id, report)| PlayerInput::Station(id, report)).collect();
        copy.step(later, &newer, &mut Fifo, &mut out);
        let steps = out.records.iter().filter_map(|record| match &record.fact {
            RecordKind::Exception(step) => Some(step),
            _ => None,
        });
        let verdict = |step: &ExceptionStep| match step {
            ExceptionStep::Mismatch { about: of, found } if *of == about => {
                Some(AnswerVerdict::Contradicted(found.clone()))
            }
            ExceptionStep::Closed { firing, mode, ruling, unchecked, .. } if AlarmSubject::Firing(*firing) == about => {
                let unseen = self.unseen(*mode, ruling.part, unchecked);
                let worked_at = self.worked_at(*mode, ruling.part).filter(|_| unseen.is_empty());
                Some(worked_at.map_or(AnswerVerdict::Taken { unseen }, |at| AnswerVerdict::WorkUnseen { at }))
            }
            ExceptionStep::Carried { firing } if AlarmSubject::Firing(*firing) == about => {
                let mode = self.state().firing(*firing).map(|firing| firing.mode);
                let unseen = |mode| self.unseen(mode, Whereabouts::Carrier, &[]);
                Some(AnswerVerdict::Taken { unseen: mode.map(unseen).unwrap_or_default() })
            }
            ExceptionStep::Up { resource, unchecked } if AlarmSubject::Resource(*resource) == about => {
                // It is taken by the sensor as it was received last, however long ago.
                let silent = self.silent(about, reports);
                if !silent.is_empty() {
                    return Some(AnswerVerdict::Open { silent });
                }
                let is_seen = self.presence(*resource) != Presence::NoSensor && !unchecked;
                Some(AnswerVerdict::Taken { unseen: (!is_seen).then_some(*resource).into_iter().collect() })
            }
            _ => None,
        };
        let steps: Vec<&ExceptionStep> = steps.collect();
        // A part that is given up where its resource is not counted on yet.
        let given_up = |step: &&ExceptionStep| match **step {
            ExceptionStep::Missing { resource, .. } if AlarmSubject::Resource(resource) == about => {
                let is_seen = self.silent(about, reports).is_empty() && self.presence(resource).is_known();
                Some(AnswerVerdict::Taken { unseen: (!is_seen).then_some(resource).into_iter().collect() })
            }
            _ => None,
        };
        let found = steps.iter().copied().find_map(verdict).or_else(|| steps.iter().find_map(given_up));
        found.unwrap_or_else(|| AnswerVerdict::Open { silent: self.silent(about, reports) })
    }

    /// The resources at which a sensor would have to see what an answer claims, and none does. Where the part is at a resource, its
    /// sensor alone confirms that; where it is outside or gone, all of the activity have to see none.
    fn unseen(&self, mode: ModeId, part: Whereabouts, unchecked: &[ResourceId]) -> Vec<ResourceId> {
        let handled = self.state().table().handling().mode(mode);
        let holder = match part {
            Whereabouts::From => handled.from,
            Whereabouts::To => handled.to,
            Whereabouts::Carrier => handled.carrier,
            Whereabouts::Gone => None,
        };
        // A carrier that another activity uses as well is not compared.
        let is_seen = |id: ResourceId| match part {
            Whereabouts::Carrier => self.presence(id) == Presence::On,
            Whereabouts::From | Whereabouts::To | Whereabouts::Gone => self.presence(id).is_known(),
        };
        let is_unseen = |id: &ResourceId| unchecked.contains(id) || !is_seen(*id);
        match holder {
            Some(id) => Some(id).filter(is_unseen).into_iter().collect(),
            None => handled.resources().filter(is_unseen).collect(),
        }
    }

    /// The resource at which a part is before its activity and afterwards, where an answer has it there. No sensor sees whether it was
    /// worked on.
    fn worked_at(&self, mode: ModeId, part: Whereabouts) -> Option<ResourceId> {
        let handled = self.state().table().handling().mode(mode);
        let is_there = matches!(part, Whereabouts::From | Whereabouts::To);
        handled.from.filter(|_| is_there && handled.from == handled.to)
    }

    /// The stations of an alarm that are not received.
    fn silent(&self, about: AlarmSubject, reports: &[(StationId, &TaskReport)]) -> Vec<StationId> {
        let handling = self.state().table().handling();
        let station = |id: ResourceId| handling.resource(id).and_then(|of| of.station);
        let mut stations: Vec<StationId> = match about {
            AlarmSubject::Resource(resource) => station(resource).into_iter().collect(),
            AlarmSubject::Firing(firing) => self.state().firing(firing).map_or_else(Vec::new, |firing| {
                let ordered = firing.orders.iter().map(|order| order.station);
                ordered.chain(handling.mode(firing.mode).resources().filter_map(station)).collect()
            }),
        };
        stations.sort_unstable();
        stations.dedup();
        stations.retain(|station| reports.iter().all(|(of, _)| of != station));
        stations
    }
}

fn refusal(event: &CellEvent) -> Option<AlarmAnswerRefusal> {
    match *event {
        CellEvent::Objected { why, .. } => Some(why),
        CellEvent::BadAnswer { .. } | CellEvent::Superseded { .. } | CellEvent::Busy { .. } => None,
    }
}
