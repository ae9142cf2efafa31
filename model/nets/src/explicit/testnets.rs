//! Small random nets of many kinds, bounded and not, for the unit tests.

use linewright_random::Random;

use crate::{Net, NetBuilder};

/// A net as plain data: tokens, and per transition those it takes and gives.
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
pub(super) fn any(random: &mut Random) -> Net {
    let mut draft = match random.below(4) {
        0 => wild(random),
        1 => machines(random),
        2 => exchanges(random),
        _ => drain(random),
    };
    if random.chance(20) && !draft.tokens.is_empty() {
        // A place twice.
        let (of, copy) = (random.below(draft.tokens.len()), draft.tokens.len());
        draft.tokens.push(draft.tokens[of] + random.below(2) as u32);
        for side in draft.transitions.iter_mut().flatten() {
            let weight = side.iter().find(|&&(place, _)| place == of).map(|&(_, weight)| weight);
            side.extend(weight.map(|weight| (copy, weight)));
        }
    }
    if random.chance(10) {
        // A place by itself.
        draft.tokens.push(random.below(3) as u32);
    }
    if draft.tokens.is_empty() && draft.transitions.is_empty() {
        draft.tokens.push(1);
    }
    draft.build()
}

/// Any arcs at all, sources and sinks among the transitions.
fn wild(random: &mut Random) -> PlainNet {
    let places = random.below(5);
    let mut draft = PlainNet { tokens: (0..places).map(|_| random.below(4) as u32).collect(), ..PlainNet::default() };
    for _ in 0..random.below(5) {
        let mut sides = [Vec::new(), Vec::new()];
        for side in &mut sides {
            for _ in 0..random.below(4).min(places) {
                let weight = 1 + random.below(3) as u32;
                PlainNet::arc(side, random.below(places), weight);
            }
        }
        draft.transitions.push(sides);
    }
    draft
}

/// State machines that do some of their steps together and use common buffers, as stations of a line do.
fn machines(random: &mut Random) -> PlainNet {
    let mut draft = PlainNet::default();
    let mut machines: Vec<Vec<usize>> = Vec::new();
    for _ in 0..1 + random.below(3) {
        let first = draft.tokens.len();
        let states = 1 + random.below(4);
        draft.tokens.extend(std::iter::repeat_n(0, states));
        let at = first + random.below(states);
        draft.tokens[at] = 1;
        machines.push((first..first + states).collect());
    }
    let buffers: Vec<usize> = (0..random.below(3)).map(|i| draft.tokens.len() + i).collect();
    buffers.iter().for_each(|_| draft.tokens.push(random.below(3) as u32));
    for _ in 0..1 + random.below(8) {
        let mut sides = [Vec::new(), Vec::new()];
        for _ in 0..1 + random.below(2) {
            let machine = &machines[random.below(machines.len())];
            let mut pick = || machine[random.below(machine.len())];
            let (from, to) = (pick(), pick());
            // At most one step of a machine, mostly.
            if sides.iter().flatten().all(|&(place, _): &(usize, u32)| !machine.contains(&place)) {
                PlainNet::arc(&mut sides[0], from, 1);
                PlainNet::arc(&mut sides[1], to, 1);
            }
        }
        for &buffer in &buffers {
            if random.chance(25) {
                PlainNet::arc(&mut sides[random.below(2)], buffer, 1 + random.below(2) as u32);
            }
        }
        draft.transitions.push(sides);
    }
    // Half of the buffers get a complement, so that they are bounded.
    for &buffer in &buffers {
        if random.chance(70) {
            let other = draft.tokens.len();
            draft.tokens.push(random.below(4) as u32);
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
fn exchanges(random: &mut Random) -> PlainNet {
    let places = 2 + random.below(3);
    let rates: Vec<u32> = (0..places).map(|_| 1 + random.below(3) as u32).collect();
    let mut draft = PlainNet { tokens: (0..places).map(|_| random.below(5) as u32).collect(), ..PlainNet::default() };
    for _ in 0..1 + random.below(6) {
        let (from, to) = (random.below(places), random.below(places));
        let mut sides = [vec![(from, rates[to])], vec![(to, rates[from])]];
        if random.chance(40) {
            let needs = random.below(places);
            if needs != from && needs != to {
                sides.iter_mut().for_each(|side| side.push((needs, 1)));
            }
        }
        draft.transitions.push(sides);
    }
    draft
}

/// Transitions that take more than they give: bounded, without a sum that shows it.
fn drain(random: &mut Random) -> PlainNet {
    let places = 1 + random.below(4);
    let mut draft = PlainNet { tokens: (0..places).map(|_| random.below(7) as u32).collect(), ..PlainNet::default() };
    for _ in 0..1 + random.below(5) {
        let (from, to) = (random.below(places), random.below(places));
        let (takes, gives) = (1 + random.below(3) as u32, random.below(3) as u32);
        let gives = if gives == 0 || (to <= from && gives >= takes) { Vec::new() } else { vec![(to, gives)] };
        draft.transitions.push([vec![(from, takes)], gives]);
    }
    draft
}
