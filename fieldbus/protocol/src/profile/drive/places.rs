//! The places of an endless axis, on the circle that its drive counts.
//!
//! Object 607Bh (position range limit, CiA 402) makes the drive count from 0 up to a turn and begin anew there; 60F2h
//! (positioning option code) says which way it goes to a target. A position outside that range comes from a drive that counts
//! otherwise, and is none.

use linewright_line::{Drive, DriveIndex, TurnDirection};

/// The places on the circle, in increments.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivePlaces {
    /// Their numbers, and which way it turns.
    pub index: DriveIndex,
    /// After so many it is where it was.
    turn: i32,
    /// In the order in which the axis comes to them.
    positions: Vec<i32>,
    /// It is at a place within this distance.
    window: i32,
}

/// A position on the circle: the place it is at, or has left last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaceAt {
    /// Counted from 1.
    pub number: u16,
    /// It is there; else it has left it, and is on the way to the next one.
    pub is_there: bool,
}

impl DrivePlaces {
    pub(super) fn of(drive: &Drive, index: &DriveIndex) -> Self {
        let turn = drive.increments(index.turn).max(1);
        DrivePlaces {
            index: index.clone(),
            turn,
            positions: drive.targets.iter().map(|target| drive.increments(target.to).rem_euclid(turn)).collect(),
            window: drive.increments(drive.window).max(1),
        }
    }

    /// Increments of a turn.
    pub fn turn(&self) -> i32 {
        self.turn
    }

    pub(super) fn positions(&self) -> &[i32] {
        &self.positions
    }

    /// The way from one position to another in the direction in which it turns; less than a turn.
    fn way(&self, from: i32, to: i32) -> i32 {
        let way = match self.index.direction {
            TurnDirection::Positive => i64::from(to) - i64::from(from),
            TurnDirection::Negative => i64::from(from) - i64::from(to),
        };
        way.rem_euclid(i64::from(self.turn)) as i32
    }

    /// Whether a position is within the window of a place, before it or past it.
    fn is_there(&self, at: usize, actual: i32) -> bool {
        let past = self.way(self.positions[at], actual);
        past.min(self.turn - past) <= self.window
    }

    fn is_on_circle(&self, actual: i32) -> bool {
        (0..self.turn).contains(&actual)
    }

    /// Where a position is; none for one that no such drive has.
    pub fn at(&self, actual: i32) -> Option<PlaceAt> {
        if !self.is_on_circle(actual) {
            return None;
        }
        let place = |at: usize, is_there| PlaceAt { number: at as u16 + 1, is_there };
        if let Some(at) = (0..self.positions.len()).find(|&at| self.is_there(at, actual)) {
            return Some(place(at, true));
        }
        let left = (0..self.positions.len()).min_by_key(|&at| self.way(self.positions[at], actual))?;
        Some(place(left, false))
    }

    /// Whether it is at the place of target `at`.
    pub(super) fn has(&self, at: usize, actual: i32) -> bool {
        self.is_on_circle(actual) && self.is_there(at, actual)
    }

    /// Whether the place of target `at` is the next one it comes to: it is at the one before, or between the two.
    pub(super) fn is_next(&self, at: usize, actual: i32) -> bool {
        self.at(actual).is_some_and(|here| usize::from(self.index.next(here.number)) == at + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(direction: TurnDirection, places: [i32; 4]) -> DrivePlaces {
        let index = DriveIndex { places: 4, turn: 360.0, direction, to: Vec::new(), place: Vec::new() };
        DrivePlaces { index, turn: 3600, positions: places.to_vec(), window: 5 }
    }

    #[test]
    fn a_position_is_at_a_place_or_after_the_one_it_has_left_past_the_end_of_the_range_too() {
        let up = places(TurnDirection::Positive, [0, 900, 1800, 2700]);
        let down = places(TurnDirection::Negative, [0, 2700, 1800, 900]);
        for (circle, actual, number, is_there) in [
            (&up, 0, 1, true),
            (&up, 3595, 1, true),
            (&up, 5, 1, true),
            (&up, 6, 1, false),
            (&up, 894, 1, false),
            (&up, 895, 2, true),
            (&up, 3594, 4, false),
            (&down, 3594, 1, false),
            (&down, 2706, 1, false),
            (&down, 2700, 2, true),
            (&down, 6, 4, false),
        ] {
            assert_eq!(circle.at(actual), Some(PlaceAt { number, is_there }), "{:?} {actual}", circle.index.direction);
        }
        for outside in [-1, 3600, i32::MIN, i32::MAX] {
            assert_eq!(up.at(outside), None);
            assert!(!up.has(0, outside) && !up.is_next(0, outside));
        }
    }

    #[test]
    fn a_place_is_next_from_the_one_before_it_alone() {
        let up = places(TurnDirection::Positive, [0, 900, 1800, 2700]);
        let from = |at: usize| (0..3600).filter(|&actual| up.is_next(at, actual)).collect::<Vec<_>>();
        assert_eq!((from(1).first(), from(1).last(), from(1).len()), (Some(&0), Some(&3599), 900));
        assert!(!up.is_next(1, 900) && !up.is_next(1, 910) && up.is_next(1, 3595) && !up.is_next(1, 3594));
        let down = places(TurnDirection::Negative, [0, 2700, 1800, 900]);
        assert!(down.is_next(1, 0) && down.is_next(1, 3000) && !down.is_next(1, 2699) && !down.is_next(1, 100));
    }
}
