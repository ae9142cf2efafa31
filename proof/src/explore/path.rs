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
