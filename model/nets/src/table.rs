//! A net and its markings as plain text, for terminals, logs and golden files.
//!
//! One line per place and one per transition, in the order of declaration, so that a difference between two nets is a
//! difference between two texts.

use std::fmt;

use crate::{Marking, Net, PlaceId};

impl fmt::Display for Net {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (places, transitions) = (self.place_count(), self.transition_count());
        let initial = self.initial_marking();
        writeln!(f, "net {}: places {places}, transitions {transitions}, tokens {}", self.name(), initial.total())?;
        let widest_place = self.places().map(|p| self.place_name(p).chars().count()).max().unwrap_or(0);
        for p in self.places() {
            writeln!(f, "  {:widest_place$}  {}", self.place_name(p), initial.tokens(p))?;
        }
        let widest = self.transitions().map(|t| self.transition_name(t).chars().count()).max().unwrap_or(0);
        for t in self.transitions() {
            let (takes, gives) = (self.bag(self.preset(t)), self.bag(self.postset(t)));
            writeln!(f, "  {:widest$}  {takes} → {gives}", self.transition_name(t))?;
        }
        Ok(())
    }
}

impl Net {
    /// A marking in words: the marked places, each with its tokens if there is more than one ("bolts ×4, fixture").
    pub fn describe(&self, marking: &Marking) -> String {
        let show = |place| match marking.tokens(place) {
            1 => self.place_name(place).to_owned(),
            tokens => format!("{} ×{tokens}", self.place_name(place)),
        };
        let marked: Vec<_> = marking.marked().map(show).collect();
        if marked.is_empty() { "no tokens".to_owned() } else { marked.join(", ") }
    }

    /// Tokens on one side of a transition ("4 bolts + fixture").
    fn bag(&self, arcs: &[(PlaceId, u32)]) -> String {
        let show = |&(place, weight): &(PlaceId, u32)| match weight {
            1 => self.place_name(place).to_owned(),
            _ => format!("{weight} {}", self.place_name(place)),
        };
        if arcs.is_empty() { "nothing".to_owned() } else { arcs.iter().map(show).collect::<Vec<_>>().join(" + ") }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Marking, NetBuilder};

    #[test]
    fn a_net_reads_as_a_table() {
        let mut b = NetBuilder::new("assembly");
        let [bolts, fixture, part] = [("bolts", 9), ("fixture", 1), ("part", 0)].map(|(name, n)| b.place(name, n));
        let [screw, ship] = ["screw", "ship"].map(|name| b.transition(name));
        b.input(screw, bolts, 4).input(screw, fixture, 1).output(screw, fixture, 1).output(screw, part, 1);
        b.input(ship, part, 1);
        let net = b.build().unwrap();
        let expected = "\
net assembly: places 3, transitions 2, tokens 10
  bolts    9
  fixture  1
  part     0
  screw  4 bolts + fixture → fixture + part
  ship   part → nothing
";
        assert_eq!(net.to_string(), expected);
        assert_eq!(net.describe(&net.initial_marking()), "bolts ×9, fixture");
        assert_eq!(net.describe(&Marking::from_tokens([0, 0, 0])), "no tokens");
    }
}
