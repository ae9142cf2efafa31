//! One shape for siphons and traps: a trap of a net is a siphon of the net with its arcs reversed.
//!
//! Weights are left out: emptiness does not depend on them.

use crate::{Net, PlaceId};

/// For a net, or for its reverse: what has to be in a set of places because of what.
pub(super) struct Sides {
    /// Per transition, the places of which one must be in the set …
    pub inputs: Vec<Vec<usize>>,
    /// … if one of these is.
    pub outputs: Vec<Vec<usize>>,
    /// Per place, the transitions that have it among their outputs.
    pub producers: Vec<Vec<usize>>,
    /// Per place, the transitions that have it among their inputs.
    pub consumers: Vec<Vec<usize>>,
}

impl Sides {
    pub fn of_siphons(net: &Net) -> Sides {
        let indices = |arcs: &[(PlaceId, u32)]| arcs.iter().map(|&(place, _)| place.index()).collect();
        Sides {
            inputs: net.transitions().map(|t| indices(net.preset(t))).collect(),
            outputs: net.transitions().map(|t| indices(net.postset(t))).collect(),
            producers: net.places().map(|p| net.producers(p).iter().map(|&(t, _)| t.index()).collect()).collect(),
            consumers: net.places().map(|p| net.consumers(p).iter().map(|&(t, _)| t.index()).collect()).collect(),
        }
    }

    pub fn of_traps(net: &Net) -> Sides {
        let Sides { inputs, outputs, producers, consumers } = Sides::of_siphons(net);
        Sides { inputs: outputs, outputs: inputs, producers: consumers, consumers: producers }
    }

    pub fn place_count(&self) -> usize {
        self.producers.len()
    }

    /// Takes out, again and again, the outputs of transitions that have no input left in the set.
    pub fn largest_in(&self, mut set: Vec<bool>) -> Vec<bool> {
        let count = |places: &Vec<usize>| places.iter().filter(|&&place| set[place]).count();
        let mut left: Vec<usize> = self.inputs.iter().map(count).collect();
        let mut starved: Vec<usize> = (0..left.len()).filter(|&t| left[t] == 0).collect();
        while let Some(t) = starved.pop() {
            for &place in &self.outputs[t] {
                if !std::mem::replace(&mut set[place], false) {
                    continue;
                }
                for &consumer in &self.consumers[place] {
                    left[consumer] -= 1;
                    if left[consumer] == 0 {
                        starved.push(consumer);
                    }
                }
            }
        }
        set
    }
}
