//! A life of the coordinator with stations that obey at once, without faults, and in the nominal time.
//!
//! A message takes no time; an order is taken on and then done. Nothing is written to a disk.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::{
    ActivityTiming, CellMessage, CellTable, Coordination, Dispatcher, ModeId, OrderKey, PlayerInput, PlayerOutbox,
    PlayerState, RecordKind, TaskOutcome, TaskReply, TaskReport,
};
use linewright_line::{StationId, Tick};

/// Player and stations.
#[derive(Clone)]
pub struct Floor {
    pub player: Coordination,
    pub now: Tick,
    working: BinaryHeap<Reverse<(Tick, StationId, OrderKey)>>,
    replies: Vec<(StationId, OrderKey, TaskReply)>,
    out: PlayerOutbox,
    /// Number of activities that have started or happened.
    pub firings: u64,
    /// Number of questions with something to start that were answered.
    pub decisions: u64,
    /// Number of records written.
    pub records: u64,
    /// Hash of all starts in their order.
    pub trace: u64,
}

/// Takes one more firing into the number of all so far.
pub fn traced(trace: u64, at: Tick, mode: ModeId) -> u64 {
    (trace.rotate_left(5) ^ at.as_micros() ^ u64::from(mode.0)).wrapping_mul(0x517C_C1B7_2722_0A95)
}

/// Time of a mode.
pub fn time(table: &CellTable, mode: ModeId) -> Duration {
    match table.activity(mode).kind {
        ActivityTiming::Immediate => Duration::ZERO,
        ActivityTiming::Decided { time, limit: _ } => time,
    }
}

impl Floor {
    pub fn new(table: &Arc<CellTable>, dispatcher: &mut dyn Dispatcher) -> Self {
        let mut out = PlayerOutbox::default();
        let player =
            Coordination::begin(PlayerState::new(table.clone()), Tick::ZERO, 1, &mut out).expect("a first life");
        let (working, replies) = (BinaryHeap::new(), Vec::new());
        let mut new =
            Floor { player, now: Tick::ZERO, working, replies, out, firings: 0, decisions: 0, records: 0, trace: 0 };
        let (heard, stations) = (TaskReport { memory: 1, ..TaskReport::default() }, table.handling().stations.len());
        let hears = (0..stations).map(|at| PlayerInput::Station(StationId::at(at), &heard));
        let inputs: Vec<_> = hears.chain([PlayerInput::Starts(true)]).collect();
        new.player.step(Tick::ZERO, &inputs, dispatcher, &mut new.out);
        new.take();
        new
    }

    /// Plays until so many more have started.
    pub fn play(&mut self, dispatcher: &mut dyn Dispatcher, firings: u64) {
        let until = self.firings + firings;
        while self.firings < until {
            self.turn(dispatcher);
        }
    }

    /// One step of the player, at the next moment at which there is something to do.
    fn turn(&mut self, dispatcher: &mut dyn Dispatcher) {
        if self.replies.is_empty() {
            let ends = self.working.peek().map(|Reverse((at, ..))| *at);
            let next = ends.into_iter().chain(self.player.next_deadline()).min();
            self.now = next.expect("a cell that never gets stuck").max(self.now);
            while let Some(&Reverse((at, station, key))) =
                self.working.peek().filter(|Reverse((at, ..))| *at <= self.now)
            {
                debug_assert!(at <= self.now);
                self.working.pop();
                self.replies.push((station, key, TaskReply::Ended(TaskOutcome::Done)));
            }
        }
        let inputs: Vec<_> = self.replies.drain(..).map(|(s, key, reply)| PlayerInput::Reply(s, key, reply)).collect();
        self.player.step(self.now, &inputs, dispatcher, &mut self.out);
        self.take();
    }

    /// Obeys messages, and counts records.
    fn take(&mut self) {
        let (player, table) = (&self.player, self.player.state().table());
        for record in self.out.records.drain(..) {
            self.records += 1;
            match record.fact {
                RecordKind::Started { mode, .. } | RecordKind::Fired { mode, .. } => {
                    self.firings += 1;
                    self.trace = traced(self.trace, record.at, mode);
                }
                RecordKind::Decided { .. } => self.decisions += 1,
                RecordKind::Epoch { .. }
                | RecordKind::Memory { .. }
                | RecordKind::Acknowledged { .. }
                | RecordKind::OrderEnded { .. }
                | RecordKind::Ended { .. }
                | RecordKind::Production { .. } => (),
                RecordKind::OrderFailed { .. } | RecordKind::Raised { .. } | RecordKind::Exception(_) => {
                    panic!("nothing fails here: {:?}", record.fact)
                }
            }
        }
        for send in self.out.sends.drain(..) {
            let CellMessage::Order(order) = send else { panic!("nobody has to be secured here") };
            let (firing, _) = player.state().order(order.order.key).expect("what is sent is in progress");
            self.working.push(Reverse((self.now + time(table, firing.mode), order.station, order.order.key)));
            self.replies.push((order.station, order.order.key, TaskReply::Running));
        }
        assert!(self.out.events.is_empty(), "{:?}", self.out.events);
    }

    /// Sends whole states of all stations, without news; their number.
    pub fn hear_all(&mut self, dispatcher: &mut dyn Dispatcher) -> usize {
        let stations = self.player.state().table().handling().stations.len();
        let mut heard = TaskReport { memory: 1, epoch: 1, ..TaskReport::default() };
        let mut slots = vec![None; stations];
        self.working.iter().for_each(|Reverse((_, station, key))| slots[station.index()] = Some(*key));
        for (at, slot) in slots.into_iter().enumerate() {
            heard.slot = slot;
            self.player.step(self.now, &[PlayerInput::Station(StationId::at(at), &heard)], dispatcher, &mut self.out);
        }
        self.take();
        stations
    }
}
