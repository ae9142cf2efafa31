//! Successors of a state that the search keeps: everything that may happen in any of the states it stands for.
//!
//! A move is tried with every station in the one situation at hand. Most moves depend on the other stations only by
//! what is the same throughout a class. Where a move needs more of a station, it is tried again with each of its
//! situations.

use super::state::ComposedState;
use super::system::{FixedSituation, RelevantStation, System, SystemMove};

/// Something that may happen.
pub(crate) struct SuccessorMove<'a> {
    /// The stations for which it matters in which situation they are, and that situation.
    pub pins: &'a [FixedSituation],
    pub what: SystemMove,
    pub next: Successor<'a>,
    /// Bytes that situations and classes take by now, about: one state's followers can bring in very many.
    pub bytes: usize,
}

/// Result of a move.
pub(crate) enum Successor<'a> {
    /// One station is in another situation, and nothing else has changed.
    Beside { station: usize, to: u32 },
    /// The whole of it.
    State(&'a ComposedState),
}

/// Goes through what follows states, without allocating.
pub(crate) struct Successors {
    next: ComposedState,
    pins: Vec<FixedSituation>,
    spare: Vec<ComposedState>,
}

impl Successors {
    /// `like` gives the shape.
    pub fn new(like: &ComposedState) -> Self {
        Successors { next: like.clone(), pins: Vec::new(), spare: Vec::new() }
    }

    /// Visits everything that may happen, until the visitor has had enough.
    pub fn each<E>(
        &mut self,
        system: &mut System,
        here: &ComposedState,
        visit: &mut impl FnMut(&SuccessorMove<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.pins.clear();
        let loose = system.loose(here);
        for link in 0..system.setting.links.len() {
            for nth in 0..system.waiting(here, link) {
                self.follow(system, here, loose, SystemMove::Hear { link, nth }, visit)?;
            }
        }
        for station in 0..here.situations.len() {
            self.of_one(system, here, loose & !(1 << station), station, visit)?;
        }
        for mode in system.grants(here) {
            self.grant(system, here, mode, visit)?;
        }
        Ok(())
    }

    /// Moves of one station by itself.
    fn of_one<E>(
        &mut self,
        system: &mut System,
        here: &ComposedState,
        loose: u32,
        station: usize,
        visit: &mut impl FnMut(&SuccessorMove<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        for &(act, to) in &system.class(here, station).leads {
            let pins = &[FixedSituation { station, member: act.from }];
            let what = SystemMove::Act { station, nth: act.nth as usize };
            visit(&SuccessorMove {
                pins,
                what,
                next: Successor::Beside { station, to },
                bytes: system.bytes_classified,
            })?;
        }
        let mut pinned = self.spare(here);
        for nth in 0..system.class(here, station).acts.len() {
            let act = system.class(here, station).acts[nth];
            self.pins.push(FixedSituation { station, member: act.from });
            pinned.situations[station] = act.from;
            self.follow(system, &pinned, loose, SystemMove::Act { station, nth: act.nth as usize }, visit)?;
            self.pins.pop();
        }
        self.spare.push(pinned);
        Ok(())
    }

    /// A mode is granted when no station acts on any. Nothing else changes: situations that are of one class then lead
    /// to the same.
    fn grant<E>(
        &mut self,
        system: &mut System,
        here: &ComposedState,
        mode: usize,
        visit: &mut impl FnMut(&SuccessorMove<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut pinned = self.spare(here);
        let stations = here.situations.len();
        let idle: Vec<Vec<u32>> = (0..stations).map(|station| system.idle_by_class(here, station, mode)).collect();
        let mut nth = vec![0; stations];
        loop {
            self.pins.clear();
            for (station, &nth) in nth.iter().enumerate() {
                let member = idle[station][nth];
                pinned.situations[station] = member;
                self.pins.push(FixedSituation { station, member });
            }
            self.follow(system, &pinned, 0, SystemMove::Grant(mode), visit)?;
            // The next combination, as a number with a digit for each station.
            let more = (0..stations).find(|&station| {
                nth[station] = (nth[station] + 1) % idle[station].len();
                nth[station] != 0
            });
            if more.is_none() {
                break;
            }
        }
        self.pins.clear();
        self.spare.push(pinned);
        Ok(())
    }

    fn follow<E>(
        &mut self,
        system: &mut System,
        from: &ComposedState,
        loose: u32,
        what: SystemMove,
        visit: &mut impl FnMut(&SuccessorMove<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.next.take(from);
        let Err(RelevantStation(station)) = system.play(&mut self.next, what, loose) else {
            system.settle(&mut self.next);
            let next = Successor::State(&self.next);
            return visit(&SuccessorMove { pins: &self.pins, what, next, bytes: system.bytes_classified });
        };
        let mut pinned = self.spare(from);
        for nth in 0..system.class(from, station).members.len() {
            let member = system.class(from, station).members[nth];
            self.pins.push(FixedSituation { station, member });
            pinned.situations[station] = member;
            self.follow(system, &pinned, loose & !(1 << station), what, visit)?;
            self.pins.pop();
        }
        self.spare.push(pinned);
        Ok(())
    }

    fn spare(&mut self, like: &ComposedState) -> ComposedState {
        let mut spare = self.spare.pop().unwrap_or_else(|| like.clone());
        spare.take(like);
        spare
    }
}
