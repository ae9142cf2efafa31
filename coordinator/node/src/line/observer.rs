//! Changes of a station, from one of its states to the next.
//!
//! Pure: states in, notes out. States are whole and the newest alone is kept on its way, so a motion may pass between two of
//! them: the counts show that, and it is noted without times.

use linewright_history::{MotionOutcome, Note};
use linewright_line::Tick;
use linewright_msgs::StationState;

use crate::situation::fault_note;

/// A motion that goes on.
#[derive(Clone, Copy, Debug)]
struct OpenMotion {
    from: Tick,
    cycle: i32,
    is_back: bool,
}

/// The state before, of one station.
#[derive(Debug)]
pub struct StationObserver {
    /// The life and the generation that the counts are of.
    life: Option<(u64, u64)>,
    open: Vec<Option<OpenMotion>>,
    started: Vec<i32>,
    /// The fault as it was last noted.
    fault: Option<String>,
    /// Reason it waits for, and since when.
    waits: Option<(Tick, String)>,
}

impl StationObserver {
    pub fn new(operations: usize) -> Self {
        StationObserver {
            life: None,
            open: vec![None; operations],
            started: Vec::new(),
            fault: Some(String::new()),
            waits: None,
        }
    }

    /// Notes on a station when the observation begins: its fault. Operations in progress are counted from now on.
    pub fn begin(&mut self, station: u16, at: Tick, out: &mut Vec<Note>) {
        if let Some(text) = self.fault.clone().filter(|text| !text.is_empty()) {
            out.push(Note::Fault { station, text });
        }
        self.open.iter_mut().flatten().for_each(|open| open.from = at);
        self.waits.iter_mut().for_each(|waits| waits.0 = at);
    }

    /// Its newest state.
    pub fn state(&mut self, station: u16, at: Tick, state: &StationState, out: &mut Vec<Note>) {
        // Of another description; its controller is not used either.
        if state.places.len() != self.open.len() || state.started.len() != self.open.len() {
            return;
        }
        let life = Some((state.boot_id, state.generation));
        if self.life != life {
            self.stop(station, at, out);
            (self.life, self.started) = (life, state.started.clone());
        }
        for operation in 0..self.open.len() {
            self.operation(station, operation, at, state, out);
        }
        self.started.clone_from(&state.started);
        out.extend(fault_note(&mut self.fault, station, &state.fault));
        let is_waiting =
            state.mode == StationState::MODE_AUTO && state.fault.is_empty() && self.open.iter().all(Option::is_none);
        // The first reason: what else there is follows from the same, as an interlock beside its arrow.
        self.wait(station, at, state.blocked_by.first().filter(|_| is_waiting).cloned(), out);
    }

    fn operation(&mut self, station: u16, operation: usize, at: Tick, state: &StationState, out: &mut Vec<Note>) {
        let (place, started) = (state.places[operation], state.started[operation]);
        let is_back = place == StationState::PLACE_UNDOING;
        let is_moving = is_back || place == StationState::PLACE_OPERATING;
        let motion = |cycle, from, end| Note::Motion {
            station,
            operation: u16::try_from(operation).unwrap_or(u16::MAX),
            cycle,
            from,
            to: at,
            end,
        };
        let before = self.started[operation];
        match self.open[operation] {
            Some(open) if is_moving && open.is_back == is_back && open.cycle == started => return,
            // It has ended, and another one has begun since.
            Some(open) if is_moving => out.push(motion(open.cycle, at, MotionOutcome::Unseen)),
            Some(open) => {
                let end = match place {
                    StationState::PLACE_INCOMPLETE | StationState::PLACE_UNDO_INCOMPLETE => MotionOutcome::Stopped,
                    _ if open.is_back => MotionOutcome::Undone,
                    _ => MotionOutcome::Done,
                };
                out.push(motion(open.cycle, open.from, end));
            }
            None if started > before && !is_moving => out.push(motion(started, at, MotionOutcome::Unseen)),
            None => {}
        }
        self.open[operation] = is_moving.then_some(OpenMotion { from: at, cycle: started, is_back });
    }

    fn wait(&mut self, station: u16, at: Tick, why: Option<String>, out: &mut Vec<Note>) {
        if self.waits.as_ref().map(|(_, why)| why) == why.as_ref() {
            return;
        }
        self.flush(station, at, out);
        self.waits = why.map(|why| (at, why));
    }

    /// Notes a wait that goes on as far as it has come.
    pub fn flush(&mut self, station: u16, at: Tick, out: &mut Vec<Note>) {
        if let Some((from, why)) = &mut self.waits
            && *from < at
        {
            out.push(Note::Waited { station, why: why.clone(), from: *from, to: at });
            *from = at;
        }
    }

    /// The station is not received any more: its operations are unknown.
    pub fn lost(&mut self, station: u16, at: Tick, out: &mut Vec<Note>) {
        self.stop(station, at, out);
        self.life = None;
    }

    fn stop(&mut self, station: u16, at: Tick, out: &mut Vec<Note>) {
        for (operation, open) in self.open.iter_mut().enumerate() {
            if let Some(OpenMotion { from, cycle, .. }) = open.take() {
                let operation = u16::try_from(operation).unwrap_or(u16::MAX);
                out.push(Note::Motion { station, operation, cycle, from, to: at, end: MotionOutcome::Stopped });
            }
        }
        self.wait(station, at, None, out);
    }
}
