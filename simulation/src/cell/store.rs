//! Store of the records of a cell, from which the next life of its coordinator begins.

use std::sync::Arc;

use linewright_coordinator_cell::{CellTable, PlayerState, Record};

use crate::rng::Rng;

/// Keeps records over the coordinator's lives.
pub trait RecordStore {
    /// Writes a record behind the others.
    fn append(&mut self, record: &Record);

    /// Makes what was written durable. It is called before anything is sent.
    fn sync(&mut self);

    /// The coordinator was killed. What is there now is what the next life begins from: at least all that was there at the
    /// last [`RecordStore::sync`], and otherwise perhaps less than was written.
    fn restart(&mut self, table: &Arc<CellTable>, rng: &mut Rng) -> PlayerState;

    /// A step is over, with this state. A store that keeps a snapshot may take one.
    fn settled(&mut self, state: &PlayerState) {
        let _ = state;
    }
}

/// Keeps everything.
#[derive(Clone, Debug, Default)]
pub struct InMemory {
    records: Vec<Record>,
}

impl RecordStore for InMemory {
    fn append(&mut self, record: &Record) {
        self.records.push(record.clone());
    }

    fn sync(&mut self) {}

    fn restart(&mut self, table: &Arc<CellTable>, _: &mut Rng) -> PlayerState {
        PlayerState::replay(table.clone(), &self.records).expect("what a player has written fits")
    }
}
