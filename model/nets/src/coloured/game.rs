//! The coloured token game: modes that may fire, and the effect of firing.
//!
//! A mode is enabled if every place has the colours that it takes and the guard of its transition allows it (seed 000,
//! definitions 14 and 15). Firing takes and gives the colours of the arc functions (definition 17). As in
//! [`crate::game`], nothing is forced to fire and a move is all or nothing. Scheduled clauses of guards are taken as
//! decided for; the effect of a decision is in [`super::decide`].

use thiserror::Error;

use super::bind;
use super::marking::{ColouredMarking, collect, count_in};
use super::net::{ColouredArc, ColouredNet, NetMode};
use crate::{PlaceId, TransitionId};

/// Reason why a mode, or a set of modes, was refused. The marking is as it was.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColouredFireError {
    /// The guard excludes the mode.
    #[error("{mode} cannot fire: its guard excludes this colour")]
    Guard {
        /// The name of the mode.
        mode: String,
    },
    /// A place has too few tokens of a colour.
    #[error("{mode} cannot fire: `{cell}` has {has} of the {needs} tokens needed")]
    Lacking {
        /// The name of the mode, or of several.
        mode: String,
        /// The place and colour.
        cell: String,
        /// Tokens on the place.
        has: u32,
        /// Number needed.
        needs: u32,
    },
    /// A place would hold more tokens of a colour than can be counted.
    #[error("{mode} cannot fire: `{cell}` would have more tokens than can be counted")]
    Overflow {
        /// The name of the mode, or of several.
        mode: String,
        /// The place and colour.
        cell: String,
    },
}

impl ColouredNet {
    /// I⁻(p, (t, c)) and I⁺(p, (t, c)): what a mode takes from a place and gives to it, with tones from 1.
    pub fn moves(&self, mode: NetMode, place: PlaceId) -> [Vec<(Vec<u32>, u32)>; 2] {
        let transition = &self.transitions[mode.transition.index()];
        [&transition.inputs, &transition.outputs].map(|sides| {
            let mut entries = Vec::new();
            let own = sides.iter().filter(|side| side.place == place);
            own.for_each(|side| self.append(side, &self.tones_of(mode), &mut entries));
            collect(&mut entries).expect("the builder bounds what an arc moves");
            let place = &self.places[place.index()];
            entries.into_iter().map(|(cell, count)| (place.shape.tones(cell - place.offset), count)).collect()
        })
    }

    /// Whether the tokens and the guard allow a mode (seed 000, definition 15).
    pub fn is_enabled(&self, marking: &ColouredMarking, mode: NetMode) -> bool {
        self.guard_allows(mode) && self.lacking(marking, &[mode]).is_none()
    }

    /// Whether the modes can fire at once: each is allowed, and there are tokens for all of them together (seed 000,
    /// definitions 5 and 16). A mode may be listed more than once.
    pub fn is_enabled_together(&self, marking: &ColouredMarking, modes: &[NetMode]) -> bool {
        modes.iter().all(|&mode| self.guard_allows(mode)) && self.lacking(marking, modes).is_none()
    }

    /// The modes that are enabled, ordered by transition and colour.
    pub fn enabled(&self, marking: &ColouredMarking) -> Vec<NetMode> {
        self.transitions().flat_map(|transition| self.enabled_modes(marking, transition)).collect()
    }

    /// The modes of one transition that are enabled, in order.
    pub fn enabled_modes(&self, marking: &ColouredMarking, transition: TransitionId) -> Vec<NetMode> {
        let mut colours = Vec::new();
        bind::enabled(self, transition.index(), &marking.entries, false, usize::MAX, &mut colours);
        colours.into_iter().map(|colour| NetMode { transition, colour }).collect()
    }

    /// Γ(t): the occurrence-mode function, for each mode that the guard allows whether it can fire now (seed 000,
    /// definition 34).
    pub fn occurrence_modes<'a>(
        &'a self,
        marking: &'a ColouredMarking,
        transition: TransitionId,
    ) -> impl Iterator<Item = (NetMode, bool)> + 'a {
        self.modes(transition).map(|mode| (mode, self.is_enabled(marking, mode)))
    }

    /// M' = M + I·Θ for one mode (seed 000, definition 17).
    pub fn fire(&self, marking: &mut ColouredMarking, mode: NetMode) -> Result<(), ColouredFireError> {
        self.fire_together(marking, &[mode])
    }

    /// M' = M + I·Θ for several modes at once, which need tokens for all of them together. Nothing is given before all
    /// is taken.
    pub fn fire_together(&self, marking: &mut ColouredMarking, modes: &[NetMode]) -> Result<(), ColouredFireError> {
        if let Some(&mode) = modes.iter().find(|&&mode| !self.guard_allows(mode)) {
            return Err(ColouredFireError::Guard { mode: self.mode_name(mode) });
        }
        if let Some((cell, has, needs)) = self.lacking(marking, modes) {
            return Err(ColouredFireError::Lacking { mode: self.names(modes), cell: self.cell_name(cell), has, needs });
        }
        let overflow = |cell| ColouredFireError::Overflow { mode: self.names(modes), cell: self.cell_name(cell) };
        let mut takes = Vec::new();
        self.demand(modes, &mut takes).map_err(overflow)?;
        let mut after = minus(&marking.entries, &takes);
        modes.iter().for_each(|&mode| self.append_outputs(mode, &mut after));
        collect(&mut after).map_err(overflow)?;
        marking.entries = after;
        Ok(())
    }

    /// The first cell that has less than the modes take together, with what it has and what they need.
    fn lacking(&self, marking: &ColouredMarking, modes: &[NetMode]) -> Option<(u32, u32, u32)> {
        let mut takes = Vec::new();
        if let Err(cell) = self.demand(modes, &mut takes) {
            return Some((cell, count_in(&marking.entries, cell), u32::MAX));
        }
        let with = takes.into_iter().map(|(cell, needs)| (cell, count_in(&marking.entries, cell), needs));
        with.into_iter().find(|&(_, has, needs)| has < needs)
    }

    /// Tokens that the modes take together, sorted by cell; or the cell for which that cannot be counted.
    pub(super) fn demand(&self, modes: &[NetMode], takes: &mut Vec<(u32, u32)>) -> Result<(), u32> {
        for &mode in modes {
            let tones = self.tones_of(mode);
            let inputs = &self.transitions[mode.transition.index()].inputs;
            inputs.iter().for_each(|side| self.append(side, &tones, takes));
        }
        collect(takes)
    }

    /// Appends what a mode gives, not yet sorted or added up.
    pub(super) fn append_outputs(&self, mode: NetMode, gives: &mut Vec<(u32, u32)>) {
        let tones = self.tones_of(mode);
        let outputs = &self.transitions[mode.transition.index()].outputs;
        outputs.iter().for_each(|side| self.append(side, &tones, gives));
    }

    fn append(&self, side: &ColouredArc, tones: &[u32], entries: &mut Vec<(u32, u32)>) {
        let place = &self.places[side.place.index()];
        let entry =
            |term: &super::linear::LinearTerm| (place.offset + term.apply(tones, &place.shape), term.weight as u32);
        entries.extend(side.terms.iter().map(entry));
    }

    /// The tones of a mode, from 0.
    pub(super) fn tones_of(&self, mode: NetMode) -> Vec<u32> {
        let shape = &self.transitions[mode.transition.index()].shape;
        assert!(mode.colour < shape.count, "mode #{} is not one of {}", mode.colour, self.transition(mode.transition));
        let mut tones = vec![0; shape.sizes.len()];
        shape.decode(mode.colour, &mut tones);
        tones
    }

    fn names(&self, modes: &[NetMode]) -> String {
        modes.iter().map(|&mode| self.mode_name(mode)).collect::<Vec<_>>().join(" with ")
    }
}

/// Rest of `entries` without `takes`, which they cover. Both are sorted.
pub(super) fn minus(entries: &[(u32, u32)], takes: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let mut takes = takes.iter().peekable();
    let mut left = Vec::with_capacity(entries.len() + 4);
    for &(cell, count) in entries {
        let taken = takes.next_if(|&&(taken, _)| taken == cell).map_or(0, |&(_, taken)| taken);
        if count > taken {
            left.push((cell, count - taken));
        }
    }
    left
}
