//! A way through the states that a search keeps, as a way through the line's own.

use super::search::LineSearch;
use super::state::ComposedState;
use super::successors::{Successor, SuccessorMove, Successors};
use super::system::{FixedSituation, SystemMove};

impl<const N: usize> LineSearch<N> {
    /// The way from the start to one of the states that the kept one stands for, to one with these pins: each state
    /// with the move from it, and the last.
    pub fn way_to(
        &mut self,
        number: u32,
        pins: &[FixedSituation],
    ) -> (Vec<(ComposedState, SystemMove)>, ComposedState) {
        let mut kept = vec![number];
        while let Some(&number) = kept.last().filter(|&&number| number != 0) {
            kept.push(self.store.came_from(number));
        }
        kept.reverse();
        let (mut way, mut here) = (Vec::new(), self.start.clone());
        for pair in kept.windows(2) {
            let (needed, what) = self.move_between(pair[0], pair[1]);
            self.walk_to(&mut here, &needed, &mut way);
            self.step(&mut here, what, &mut way);
        }
        self.walk_to(&mut here, pins, &mut way);
        (way, here)
    }

    /// The first move that leads from one kept state to another, and the situations it needs.
    fn move_between(&mut self, from: u32, to: u32) -> (Vec<FixedSituation>, SystemMove) {
        let (here, goal) = (self.state(from), *self.store.key(to));
        let key = *self.store.key(from);
        let mut found = None;
        let LineSearch { system, layout, .. } = self;
        let mut look = |follower: &SuccessorMove<'_>| {
            let next = match follower.next {
                Successor::Beside { station, to } => layout.with_situation(&key, station, to),
                Successor::State(next) => layout.pack(next).ok(),
            };
            if next != Some(goal) {
                return Ok(());
            }
            found = Some((follower.pins.to_vec(), follower.what));
            Err(())
        };
        let _ = Successors::new(&here).each(system, &here, &mut look);
        found.expect("a state was reached by one of its predecessor's moves")
    }

    /// Each station comes by itself to the situation named.
    fn walk_to(
        &mut self,
        here: &mut ComposedState,
        pins: &[FixedSituation],
        way: &mut Vec<(ComposedState, SystemMove)>,
    ) {
        for &pin in pins {
            for act in self.system.walk(here, pin) {
                self.step(here, SystemMove::Act { station: pin.station, nth: act.nth as usize }, way);
            }
        }
    }

    fn step(&mut self, here: &mut ComposedState, what: SystemMove, way: &mut Vec<(ComposedState, SystemMove)>) {
        way.push((here.clone(), what));
        self.system.play(here, what, 0).expect("where no station is loose none matters");
    }
}

#[cfg(test)]
pub(super) mod tests {
    use linewright_line::{Line, TransferLine, parse};
    use linewright_station_logic::Rules;

    use crate::explore::LineExploration;
    use crate::explore::properties::Violation;
    use crate::explore::search::{LineSearch, SearchEnd, SearchLimits, search};
    use crate::explore::state::Widths;
    use crate::explore::system::System;

    fn shipped() -> Line {
        parse("line.toml", &TransferLine::default().text()).expect("the shipped line is sound").line
    }

    /// The way found among kept states is one of the line's own, move by move, and ends where something is wrong.
    fn leads_to_what_is_wrong(rules: Rules) {
        let mut setting = LineExploration::new(&shipped());
        setting.rules = rules;
        let (system, start) = System::new(&setting).expect("the shipped line compiles");
        let mut search = search::<4>(system, start, Widths::FIRST, SearchLimits::default()).expect("it fits");
        check_way(&mut search);
    }

    /// Of a search that ended with something wrong.
    pub fn check_way<const N: usize>(search: &mut LineSearch<N>) {
        let SearchEnd::Wrong(number) = search.end else { panic!("nothing is wrong in {:?}", search.tally) };
        let kept = search.state(number);
        let (wrong, pins) = search.system.wrong(&kept).expect("the search says so");
        let (way, last) = search.way_to(number, &pins);
        let mut here = search.start.clone();
        for (state, what) in &way {
            assert_eq!(&here, state);
            search.system.play(&mut here, *what, 0).expect("nothing is loose");
        }
        assert_eq!(here, last);
        let facts = |station: usize| &search.system.stations[station].facts[last.situations[station] as usize];
        let stations = || 0..last.situations.len();
        let in_a = stations().fold(0, |bits, station| bits | facts(station).in_a);
        let in_b = stations().fold(0, |bits, station| bits | facts(station).in_b);
        match wrong {
            Violation::Conflict(nth) => assert!(in_a & in_b & (1 << nth) != 0),
            Violation::Station(station) => assert!(facts(station).wrong.is_some()),
            Violation::Apart(least, most) => {
                let cycles = || last.cycles.iter();
                assert_eq!(cycles().max().zip(cycles().min()).map(|(max, min)| max - min), Some(most - least));
            }
        }
    }

    #[test]
    fn a_way_through_kept_states_is_a_way_of_the_line() {
        leads_to_what_is_wrong(Rules { counted: false, ..Rules::COUNTS });
        leads_to_what_is_wrong(Rules { withdraw_first: false, ..Rules::COUNTS });
        leads_to_what_is_wrong(Rules { ask: false, ..Rules::COUNTS });
        leads_to_what_is_wrong(Rules { fresh_numbers: false, ..Rules::COUNTS });
        leads_to_what_is_wrong(Rules { redo_round: false, ..Rules::COUNTS });
    }
}
