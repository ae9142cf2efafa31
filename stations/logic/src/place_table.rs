//! What a marked place of a station's net drives and watches.

use std::time::Duration;

use linewright_line::net::StationPlace;

/// Outputs and watched inputs of a place.
#[derive(Clone, Debug)]
pub(crate) struct PlaceTable {
    pub place: StationPlace,
    /// Range of its rows, for each mode.
    pub rows: [(u16, u16); 6],
    /// The actuator, while operating.
    pub actuator: u128,
    /// The fault lamp, while incomplete.
    pub lamp: u128,
    /// The completion input, while operating.
    pub complete: u128,
    /// The switch of the end that the motion leaves, while operating; 0 where there is none.
    pub behind: u128,
    /// The fault input, while operating.
    pub fault: u128,
    /// Time limit of the motion.
    pub watchdog: Duration,
    /// The switch of an index, while it is under way: operating or stopped. 0 elsewhere.
    pub turns: u128,
    /// An index that is complete after less than this is in doubt.
    pub least: Duration,
    /// Of an index: a drive measures at which place its axis stands.
    pub is_measured: bool,
    /// This motion ends where its axis stands while the index of the station turns, as that of a bolt that is drawn.
    pub frees: bool,
    /// The switches that are on while this place is marked: the axes that stand still there.
    pub rest: u128,
    /// Of each of these, one at least is on while this place is marked: axes that stand still where several switches measure.
    pub rest_any: Box<[u128]>,
    /// The hand-mode button that must be held for the actuator to be driven in hand mode; 0 where no type has one.
    pub hold: u128,
}

impl PlaceTable {
    /// The switches of the axes that stand still here by the chart, and that are off though they have to be on.
    pub fn off_at_rest(&self, image: u128) -> u128 {
        let none_on = self.rest_any.iter().filter(|any| *any & image == 0);
        none_on.fold(self.rest & !image, |off, any| off | any)
    }

    /// All switches that the axes that stand still here are measured by.
    pub fn watched_at_rest(&self) -> u128 {
        self.rest_any.iter().fold(self.rest, |bits, any| bits | any)
    }
}
