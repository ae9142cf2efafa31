//! Small random nets of many kinds, bounded and not, for the unit tests.

use crate::{Net, NetBuilder};

/// Random numbers that are the same on every run.
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// Less than `n`.
    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// A net as plain data: tokens, and per transition what it takes and gives.
#[derive(Default)]
struct PlainNet {
    tokens: Vec<u32>,
    transitions: Vec<[Vec<(usize, u32)>; 2]>,
}

impl PlainNet {
    fn build(&self) -> Net {
        let mut b = NetBuilder::new("generated");
        let places: Vec<_> = self.tokens.iter().enumerate().map(|(i, &n)| b.place(format!("p{i}"), n)).collect();
        for (i, [takes, gives]) in self.transitions.iter().enumerate() {
            let t = b.transition(format!("t{i}"));
            takes.iter().for_each(|&(place, weight)| _ = b.input(t, places[place], weight));
            gives.iter().for_each(|&(place, weight)| _ = b.output(t, places[place], weight));
        }
        b.build().expect("generated nets are sound")
    }

    /// An arc, unless there is one already.
    fn arc(side: &mut Vec<(usize, u32)>, place: usize, weight: u32) {
        if side.iter().all(|&(known, _)| known != place) {
            side.push((place, weight));
        }
    }
}

/// A net of any kind, bounded or not.
pub(super) fn any(dice: &mut Dice) -> Net {
    let mut draft = match dice.below(4) {
        0 => wild(dice),
        1 => machines(dice),
        2 => exchanges(dice),
        _ => drain(dice),
    };
    if dice.chance(20) && !draft.tokens.is_empty() {
        // A place twice.
        let (of, copy) = (dice.below(draft.tokens.len() as u64) as usize, draft.tokens.len());
        draft.tokens.push(draft.tokens[of] + dice.below(2) as u32);
        for side in draft.transitions.iter_mut().flatten() {
            let weight = side.iter().find(|&&(place, _)| place == of).map(|&(_, weight)| weight);
            side.extend(weight.map(|weight| (copy, weight)));
        }
    }
    if dice.chance(10) {
        // A place by itself.
        draft.tokens.push(dice.below(3) as u32);
    }
    if draft.tokens.is_empty() && draft.transitions.is_empty() {
        draft.tokens.push(1);
    }
    draft.build()
}

/// Any arcs at all, sources and sinks among the transitions.
fn wild(dice: &mut Dice) -> PlainNet {
    let places = dice.below(5);
    let mut draft = PlainNet { tokens: (0..places).map(|_| dice.below(4) as u32).collect(), ..PlainNet::default() };
    for _ in 0..dice.below(5) {
        let mut sides = [Vec::new(), Vec::new()];
        for side in &mut sides {
            for _ in 0..dice.below(4).min(places) {
                let weight = 1 + dice.below(3) as u32;
                PlainNet::arc(side, dice.below(places) as usize, weight);
            }
        }
        draft.transitions.push(sides);
    }
    draft
}

/// State machines that do some of their steps together and use common buffers, as stations of a line do.
fn machines(dice: &mut Dice) -> PlainNet {
    let mut draft = PlainNet::default();
    let mut machines: Vec<Vec<usize>> = Vec::new();
    for _ in 0..1 + dice.below(3) {
        let first = draft.tokens.len();
        let states = 1 + dice.below(4) as usize;
        draft.tokens.extend(std::iter::repeat_n(0, states));
        let at = first + dice.below(states as u64) as usize;
        draft.tokens[at] = 1;
        machines.push((first..first + states).collect());
    }
    let buffers: Vec<usize> = (0..dice.below(3) as usize).map(|i| draft.tokens.len() + i).collect();
    buffers.iter().for_each(|_| draft.tokens.push(dice.below(3) as u32));
    for _ in 0..1 + dice.below(8) {
        let mut sides = [Vec::new(), Vec::new()];
        for _ in 0..1 + dice.below(2) {
            let machine = &machines[dice.below(machines.len() as u64) as usize];
            let mut pick = || machine[dice.below(machine.len() as u64) as usize];
            let (from, to) = (pick(), pick());
            // At most one step of a machine, mostly.
            if sides.iter().flatten().all(|&(place, _): &(usize, u32)| !machine.contains(&place)) {
                PlainNet::arc(&mut sides[0], from, 1);
                PlainNet::arc(&mut sides[1], to, 1);
            }
        }
        for &buffer in &buffers {
            if dice.chance(25) {
                PlainNet::arc(&mut sides[dice.below(2) as usize], buffer, 1 + dice.below(2) as u32);
            }
        }
        draft.transitions.push(sides);
    }
    // Half of the buffers get a complement, so that they are bounded.
    for &buffer in &buffers {
        if dice.chance(70) {
            let other = draft.tokens.len();
            draft.tokens.push(dice.below(4) as u32);
            for [takes, gives] in &mut draft.transitions {
                let weight = |side: &[(usize, u32)]| side.iter().find(|&&(p, _)| p == buffer).map(|&(_, w)| w);
                let (taken, given) = (weight(takes), weight(gives));
                takes.extend(given.map(|weight| (other, weight)));
                gives.extend(taken.map(|weight| (other, weight)));
            }
        }
    }
    draft
}

/// Tokens of one place turn into tokens of another at a rate: a positive sum never changes.
fn exchanges(dice: &mut Dice) -> PlainNet {
    let places = 2 + dice.below(3);
    let rates: Vec<u32> = (0..places).map(|_| 1 + dice.below(3) as u32).collect();
    let mut draft = PlainNet { tokens: (0..places).map(|_| dice.below(5) as u32).collect(), ..PlainNet::default() };
    for _ in 0..1 + dice.below(6) {
        let (from, to) = (dice.below(places) as usize, dice.below(places) as usize);
        let mut sides = [vec![(from, rates[to])], vec![(to, rates[from])]];
        if dice.chance(40) {
            let needs = dice.below(places) as usize;
            if needs != from && needs != to {
                sides.iter_mut().for_each(|side| side.push((needs, 1)));
            }
        }
        draft.transitions.push(sides);
    }
    draft
}

/// Transitions that take more than they give: bounded, with no sum that says so.
fn drain(dice: &mut Dice) -> PlainNet {
    let places = 1 + dice.below(4);
    let mut draft = PlainNet { tokens: (0..places).map(|_| dice.below(7) as u32).collect(), ..PlainNet::default() };
    for _ in 0..1 + dice.below(5) {
        let (from, to) = (dice.below(places) as usize, dice.below(places) as usize);
        let (takes, gives) = (1 + dice.below(3) as u32, dice.below(3) as u32);
        let gives = if gives == 0 || (to <= from && gives >= takes) { Vec::new() } else { vec![(to, gives)] };
        draft.transitions.push([vec![(from, takes)], gives]);
    }
    draft
}
