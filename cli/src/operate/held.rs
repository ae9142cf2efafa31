//! The motions that a held button leads at a station: whether they were let go before their end.

use linewright_msgs::StationState;

/// The places of an operation under way.
const OPERATING: [u8; 2] = [StationState::PLACE_OPERATING, StationState::PLACE_UNDOING];

/// Motions of a station while a button is held.
#[derive(Debug, Default)]
pub struct HeldMotions {
    /// By operation: its place before.
    places: Vec<u8>,
    /// By operation: it was seen moving, or has been moved.
    led: Vec<bool>,
    measured: Vec<u8>,
    /// A switch has changed since.
    is_seen_moving: bool,
}

impl HeldMotions {
    pub fn before(state: Option<&StationState>) -> Self {
        state.map_or_else(HeldMotions::default, |state| HeldMotions {
            places: state.places.to_vec(),
            led: vec![false; state.places.len()],
            measured: state.measured.as_slice().to_vec(),
            is_seen_moving: false,
        })
    }

    pub fn look(&mut self, state: Option<&StationState>) {
        let Some(state) = state else { return };
        let now = state.places.iter().zip(&self.places);
        for (led, (place, before)) in self.led.iter_mut().zip(now) {
            *led |= place != before || OPERATING.contains(place);
        }
        self.is_seen_moving |= state.devices_valid && state.measured.as_slice() != self.measured;
    }

    /// Whether something was led, and nothing of the station is under way or stands before its end.
    pub fn has_arrived(&self, state: &StationState) -> bool {
        let is_under_way = |place: &u8| OPERATING.contains(place);
        self.led.contains(&true)
            && state.stopped
            && state.incomplete.is_empty()
            && !state.places.iter().any(is_under_way)
    }

    /// Advice for a motion that stands before its end because its button was released; none where no such motion stands half-way.
    pub fn let_go(&self, state: &StationState) -> Option<&'static str> {
        let is_led = |op: &u16| self.led.get(usize::from(*op)).is_some_and(|led| *led);
        // In hand mode it stays in its operating place, and is not driven.
        let is_paused = |(place, led): (&u8, &bool)| *led && OPERATING.contains(place);
        let stands_half_way =
            state.incomplete.iter().any(is_led) || (state.stopped && state.places.iter().zip(&self.led).any(is_paused));
        stands_half_way.then_some(match self.is_seen_moving {
            true => "hold it longer (--for)",
            false => "no switch has changed: hold it longer (--for), or look whether the mechanism moves at all",
        })
    }
}

#[cfg(test)]
mod tests {
    use linewright_msgs::Bounded;

    use super::*;

    fn state(places: &[u8], incomplete: &[u16], measured: u8) -> StationState {
        StationState {
            places: places.to_vec(),
            incomplete: incomplete.to_vec(),
            measured: Bounded::new(vec![measured]).expect("it fits"),
            devices_valid: true,
            ..StationState::default()
        }
    }

    #[test]
    fn a_motion_that_was_led_and_stands_before_its_end_was_let_go() {
        use StationState as S;
        let before = state(&[S::PLACE_INCOMPLETE, S::PLACE_INCOMPLETE], &[0, 1], 1);
        let after = |moving: &StationState, end: &StationState| {
            let mut held = HeldMotions::before(Some(&before));
            held.look(Some(moving));
            held.look(Some(end));
            held.let_go(end)
        };
        let moving = state(&[S::PLACE_OPERATING, S::PLACE_INCOMPLETE], &[1], 1);
        let left = state(&[S::PLACE_OPERATING, S::PLACE_INCOMPLETE], &[1], 0);
        assert_eq!(after(&left, &state(&[S::PLACE_INCOMPLETE; 2], &[0, 1], 0)), Some("hold it longer (--for)"));
        let arrives = |end: &StationState| {
            let mut held = HeldMotions::before(Some(&before));
            held.look(Some(&moving));
            held.has_arrived(end)
        };
        let standing = |state: StationState| StationState { stopped: true, ..state };
        assert!(arrives(&standing(state(&[S::PLACE_COMPLETED, S::PLACE_COMPLETED], &[], 2))));
        // The other one is held on, and a motion that has not ended is.
        assert!(!arrives(&standing(state(&[S::PLACE_COMPLETED, S::PLACE_INCOMPLETE], &[1], 2))));
        assert!(!arrives(&state(&[S::PLACE_COMPLETED, S::PLACE_OPERATING], &[], 2)));
        assert!(!HeldMotions::before(Some(&before)).has_arrived(&standing(state(&[S::PLACE_COMPLETED; 2], &[], 2))));
        let jammed = after(&moving, &before).expect("it has not arrived");
        assert!(jammed.contains("no switch has changed"), "{jammed}");
        // In hand mode it is not driven, and its place is the same.
        let paused = StationState { stopped: true, ..state(&[S::PLACE_OPERATING, S::PLACE_INCOMPLETE], &[1], 0) };
        assert_eq!(after(&left, &paused), Some("hold it longer (--for)"));
        // The other one was not led: it stands where it stood.
        assert_eq!(after(&left, &state(&[S::PLACE_COMPLETED, S::PLACE_INCOMPLETE], &[1], 2)), None);
    }
}
