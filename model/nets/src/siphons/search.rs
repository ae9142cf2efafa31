//! All minimal siphons, by growing sets from a place until nothing is missing.
//!
//! For each place in turn: all minimal siphons with this place, without those before it. A set that is not a siphon yet
//! has a transition that gives to it and does not take from it; one of the inputs of that transition must join. The
//! search tries them one after the other, and excludes those already tried, so that no set is met twice. A branch ends
//! early when it cannot become a siphon (the largest siphon in what is allowed does not contain the set) and when it
//! cannot become a minimal one (there is a smaller siphon in it already).

use super::sides::Sides;
use super::{SiphonLimit, SiphonLimits, SiphonsUndecided};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Membership {
    Open,
    In,
    Out,
}

struct SiphonSearch<'a> {
    sides: &'a Sides,
    limits: &'a SiphonLimits,
    sets: usize,
    found: Vec<Vec<bool>>,
}

/// All minimal siphons of the net, or of its reverse.
pub(super) fn minimal(sides: &Sides, limits: &SiphonLimits) -> Result<Vec<Vec<bool>>, SiphonsUndecided> {
    let mut search = SiphonSearch { sides, limits, sets: 0, found: Vec::new() };
    let mut allowed = sides.largest_in(vec![true; sides.place_count()]);
    for root in 0..sides.place_count() {
        if allowed[root] {
            search.with(root, &allowed)?;
            allowed[root] = false;
            allowed = sides.largest_in(allowed);
        }
    }
    Ok(search.found)
}

impl SiphonSearch<'_> {
    /// All minimal siphons with `root` within what is allowed.
    fn with(&mut self, root: usize, allowed: &[bool]) -> Result<(), SiphonsUndecided> {
        let mut start: Vec<Membership> =
            allowed.iter().map(|&allowed| if allowed { Membership::Open } else { Membership::Out }).collect();
        start[root] = Membership::In;
        let mut stack = vec![start];
        while let Some(mut set) = stack.pop() {
            let Some(inputs) = self.grow(&mut set, stack.len())? else { continue };
            if inputs.is_empty() {
                let members: Vec<bool> = set.iter().map(|&is| is == Membership::In).collect();
                if self.is_minimal(&members, stack.len())? {
                    self.found.push(members);
                }
                continue;
            }
            let mut without = set;
            for &input in &inputs {
                let mut with = without.clone();
                with[input] = Membership::In;
                stack.push(with);
                without[input] = Membership::Out;
            }
        }
        Ok(())
    }

    fn check(&self, open: usize) -> Result<(), SiphonsUndecided> {
        let stop = |cause| SiphonsUndecided { sets: self.sets - 1, found: self.found.len(), cause };
        if self.sets > self.limits.sets {
            return Err(stop(SiphonLimit::Sets));
        }
        if (open + self.found.len() + 1) * self.sides.place_count() > self.limits.bytes {
            return Err(stop(SiphonLimit::Bytes));
        }
        Ok(())
    }

    /// Lets join what must. The inputs among which to choose then; none of them if the set is a siphon; nothing if it
    /// cannot become a minimal one. Each place that joins makes another partial set, of which there are so many and no
    /// more; `open` others wait.
    fn grow(&mut self, set: &mut [Membership], open: usize) -> Result<Option<Vec<usize>>, SiphonsUndecided> {
        loop {
            self.sets += 1;
            self.check(open)?;
            let open_inputs = |t: usize| self.sides.inputs[t].iter().copied().filter(|&p| set[p] == Membership::Open);
            let wanting = |t: &usize| {
                self.sides.outputs[*t].iter().any(|&p| set[p] == Membership::In)
                    && !self.sides.inputs[*t].iter().any(|&p| set[p] == Membership::In)
            };
            let tightest = (0..self.sides.inputs.len()).filter(wanting).min_by_key(|&t| open_inputs(t).count());
            let Some(t) = tightest else { return Ok(Some(Vec::new())) };
            let inputs: Vec<usize> = open_inputs(t).collect();
            match inputs[..] {
                [] => return Ok(None),
                [only] => set[only] = Membership::In,
                _ => return Ok(self.is_promising(set).then_some(inputs)),
            }
        }
    }

    fn is_promising(&self, set: &[Membership]) -> bool {
        let possible = self.sides.largest_in(set.iter().map(|&is| is != Membership::Out).collect());
        let within = self.sides.largest_in(set.iter().map(|&is| is == Membership::In).collect());
        set.iter().zip(possible).all(|(&is, possible)| is != Membership::In || possible) && !within.contains(&true)
    }

    /// Whether nothing but the empty set is left when any one place is taken out.
    fn is_minimal(&mut self, siphon: &[bool], open: usize) -> Result<bool, SiphonsUndecided> {
        for place in (0..siphon.len()).filter(|&place| siphon[place]) {
            self.sets += 1;
            self.check(open)?;
            let mut rest = siphon.to_vec();
            rest[place] = false;
            if self.sides.largest_in(rest).contains(&true) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
