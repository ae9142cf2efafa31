//! What would become of an answer to an alarm if it were given now: played by a copy of the coordination that is thrown away.
//!
//! So the verdict is that of the rules by which answers are judged, and there are no others: whether it is refused, and whether the sensors,
//! as they were received last, contradict it.

use linewright_line::{StationId, Tick};

use crate::exception::{AlarmAnswerRefusal, AlarmSubject, ExceptionStep, SensorMismatch};
use crate::fifo::Fifo;
use crate::ids::AlarmId;
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
    /// It is taken; whether a sensor confirms it.
    Taken { is_confirmed: bool },
    /// It depends on what is not known now.
    Open,
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
            ExceptionStep::Closed { firing, mode, unchecked, .. } if AlarmSubject::Firing(*firing) == about => {
                let handling = self.state().table().handling();
                let sensed = |id: &_| handling.resource(*id).is_some_and(|of| of.is_sensed);
                let is_any = handling.mode(*mode).resources().any(|id| sensed(&id));
                let is_confirmed = is_any && unchecked.is_empty();
                Some(AnswerVerdict::Taken { is_confirmed })
            }
            ExceptionStep::Carried { firing } if AlarmSubject::Firing(*firing) == about => {
                Some(AnswerVerdict::Taken { is_confirmed: false })
            }
            ExceptionStep::Up { resource, unchecked } if AlarmSubject::Resource(*resource) == about => {
                Some(AnswerVerdict::Taken { is_confirmed: !unchecked })
            }
            _ => None,
        };
        let found = steps.into_iter().find_map(verdict);
        found.unwrap_or(AnswerVerdict::Open)
    }
}

fn refusal(event: &CellEvent) -> Option<AlarmAnswerRefusal> {
    match *event {
        CellEvent::Objected { why, .. } => Some(why),
        CellEvent::BadAnswer { .. } | CellEvent::Superseded { .. } | CellEvent::Busy { .. } => None,
    }
}
