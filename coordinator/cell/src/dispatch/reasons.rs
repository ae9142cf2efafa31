//! The last reason for which each mode was held, from the records.

use std::collections::BTreeMap;

use linewright_line::Tick;

use super::super::ids::ModeId;
use super::super::reason::HoldReason;
use super::super::record::{Record, RecordKind};

/// The last reason for which each mode was held, if it has not started since. It follows from the records.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reasons {
    last: BTreeMap<ModeId, (Tick, HoldReason)>,
}

impl Reasons {
    /// Takes a record; the older ones first.
    pub fn note(&mut self, record: &Record) {
        if let RecordKind::Decided { question: _, started, held } = &record.fact {
            started.iter().for_each(|(mode, _)| _ = self.last.remove(mode));
            self.last.extend(held.iter().map(|&(mode, reason)| (mode, (record.at, reason))));
        }
    }

    /// Time and reason of the last hold of a mode.
    pub fn of(&self, mode: ModeId) -> Option<(Tick, &HoldReason)> {
        self.last.get(&mode).map(|(at, reason)| (*at, reason))
    }
}
