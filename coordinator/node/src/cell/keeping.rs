//! The log of a cell on a disk that may be full, or fail.
//!
//! ```text
//!   written ── no more room can be made ──▶ short: no activity starts, no production order is taken, what runs ends;
//!      ▲                                      its records have room that was made before
//!      └── written again ◀── each second ── halted: a step could not be written. Nothing of it is sent, nothing is taken
//! ```
//!
//! In both the line goes on, and stations end the orders that they have. Time is an argument.

use std::time::Duration;

use linewright_coordinator_cell::{PlayerOutbox, PlayerState};
use linewright_line::Tick;

use super::log::{CellLog, CellLogError};

/// Room for the end of what runs: an activity takes some thousand bytes.
pub const ROOM_BYTES: u64 = 1 << 20;
/// From here on only what stations report is written.
const LAST_BYTES: u64 = ROOM_BYTES / 4;
/// Period in which a disk is tried again.
const TRY_EVERY: Duration = Duration::from_secs(1);
/// A disk that took a write so long ago takes a request without another.
const TRUSTED_FOR: Duration = Duration::from_millis(200);

/// A log, and whether it can be written.
#[derive(Debug)]
pub struct CellLogKeeper {
    log: CellLog,
    /// Why nothing can be written; the step that was not, if it was one.
    halted: Option<(String, Option<PlayerOutbox>)>,
    /// Why no room can be made.
    short: Option<String>,
    /// Not tried again before.
    try_due: Tick,
    /// A write has succeeded last.
    wrote: Option<Tick>,
}

impl CellLogKeeper {
    /// Takes the room that the end of a production needs, if there is any.
    pub fn new(log: CellLog, now: Tick) -> Self {
        let mut keeper = CellLogKeeper { log, halted: None, short: None, try_due: Tick::ZERO, wrote: None };
        keeper.make_room(now);
        keeper
    }

    /// Writes a step down. False if that fails: nothing of it may be sent then, and it is kept until it is
    /// [written again](Self::try_again).
    pub fn write(&mut self, now: Tick, out: &mut PlayerOutbox) -> bool {
        match self.log.write(out) {
            Ok(()) => {
                if !out.records.is_empty() {
                    self.make_room(now);
                }
                true
            }
            Err(error) => {
                self.halt(now, &error, Some(std::mem::take(out)));
                false
            }
        }
    }

    /// Tries to write again, when that is due; the step that could not be written, if it is there now. `state` is that after it.
    pub fn try_again(&mut self, now: Tick, state: &PlayerState) -> Option<PlayerOutbox> {
        let (_, out) = self.halted.as_ref().filter(|_| now >= self.try_due)?;
        // Where the content of the file is unknown another is begun, with all of the state.
        let tried = match out {
            _ if self.log.has_failed() => self.log.begin_anew(state),
            Some(out) => self.log.write(out),
            None => self.log.probe(),
        };
        self.try_due = now + TRY_EVERY;
        match tried {
            Ok(()) => {
                tracing::info!("the log of the cell is written again");
                self.make_room(now);
                self.halted.take().and_then(|(_, out)| out)
            }
            Err(_) => None,
        }
    }

    /// Whether nothing can be written: nothing may be decided then.
    pub fn is_halted(&self) -> bool {
        self.halted.is_some()
    }

    /// Whether there is no room for more than the end of what runs.
    pub fn is_short(&self) -> bool {
        self.short.is_some()
    }

    /// Time of the next trial.
    pub fn next_deadline(&self) -> Option<Tick> {
        (self.is_halted() || self.is_short()).then_some(self.try_due)
    }

    /// Why a request cannot be taken now; `is_new` for production orders, which make work. A request is taken only by a disk
    /// that can be written.
    pub fn refusal(&mut self, now: Tick, is_new: bool) -> Option<String> {
        let is_trusted = self.wrote.is_some_and(|at| now.since(at) < TRUSTED_FOR && at <= now);
        if self.halted.is_none() && !is_trusted {
            match self.log.probe() {
                Ok(()) => self.wrote = Some(now),
                Err(error) => self.halt(now, &error, None),
            }
        }
        let is_refused = is_new || self.log.room() < LAST_BYTES;
        let short = self.short.as_ref().filter(|_| is_refused);
        let why = self.trouble().filter(|_| self.is_halted() || short.is_some())?;
        Some(format!("not taken: {why}"))
    }

    /// What is wrong with the disk, with what follows and what to do; none while it is well.
    pub fn trouble(&self) -> Option<String> {
        match (&self.halted, &self.short) {
            (Some((why, _)), _) => Some(format!(
                "the log of the cell cannot be written: {why}; nothing is decided until it can, stations end the orders that \
                 they have; make the disk writable"
            )),
            (None, Some(why)) => Some(format!(
                "there is no room for the log of the cell: {why}; no activity starts and no production order is taken, what runs \
                 ends; make room on the disk"
            )),
            (None, None) => None,
        }
    }

    /// Replaces the records by a snapshot, if there are many and the database has them. One that cannot be written is no harm: the log
    /// goes on.
    pub fn shorten(&mut self, now: Tick, state: &PlayerState, is_kept: impl FnOnce(bool) -> bool) {
        if !self.log.is_long() || self.is_halted() || !is_kept(self.log.is_very_long()) {
            return;
        }
        let Err(error) = self.log.begin_anew(state) else { return };
        if self.log.has_failed() {
            self.halt(now, &error, None);
        } else {
            tracing::warn!(
                "{error}; the log of the cell could not be shortened and goes on as it is; make room on the disk"
            );
        }
    }

    /// Makes room where it is missing, at most once a second; whether any has been missing is logged.
    pub fn make_room(&mut self, now: Tick) {
        let was_short = self.is_short();
        if self.is_halted() || was_short && now < self.try_due || !was_short && self.log.room() >= ROOM_BYTES {
            return;
        }
        match self.log.make_room(ROOM_BYTES) {
            Err(error) if self.log.room() < ROOM_BYTES => {
                self.short = Some(error.to_string());
                self.try_due = now + TRY_EVERY;
                if !was_short && let Some(trouble) = self.trouble() {
                    tracing::error!("{trouble}");
                }
            }
            // Some of it may be there, and is enough.
            Ok(()) | Err(_) => {
                self.short = None;
                if was_short {
                    tracing::info!("there is room for the log of the cell again");
                }
            }
        }
    }

    fn halt(&mut self, now: Tick, error: &CellLogError, out: Option<PlayerOutbox>) {
        self.halted = Some((error.to_string(), out));
        self.try_due = now + TRY_EVERY;
        self.wrote = None;
        if let Some(trouble) = self.trouble() {
            tracing::error!("{trouble}");
        }
    }
}
