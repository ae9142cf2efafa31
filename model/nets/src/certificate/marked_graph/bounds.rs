//! The bounds of the places of a marked graph, and the sums that certify them.
//!
//! One search finds the bound of one place, and its sum bounds all places on the path that was found. A safe ring needs
//! one search; a ring with several tokens needs one for each place, though they may all find the same sum. So searches
//! are counted, and what is left when they are used up has a wider bound or none.

use super::WeightedGraph;
use crate::certificate::evidence::{Evidence, NetProperty, Sums};
use crate::certificate::{CertificateAnswer, TokenBound, Unknown};
use crate::{Net, PlaceId};

/// Limits of the search for the bounds of all places. A ring with several tokens needs a search for each place.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    /// The most searches.
    searches: usize,
    /// The most entries of their sums, together.
    entries: usize,
}

impl Effort {
    /// Limits that take some seconds and some hundred megabytes.
    pub(super) fn of(net: &Net) -> Effort {
        Effort { searches: 50_000_000 / (1 + net.transition_count()), entries: 10_000_000 }
    }
}

impl WeightedGraph<'_> {
    /// The bound of each place; whether the net is bounded, and whether it is safe.
    pub(super) fn bounds(&self, effort: Effort) -> (Vec<TokenBound>, CertificateAnswer, CertificateAnswer) {
        let mut limits = PlaceBounds::new(self);
        for place in self.net.places() {
            if limits.bounds[place.index()] != TokenBound::Exactly(1) {
                limits.search(self, place, effort);
            }
        }
        let PlaceBounds { sums, of_place, bounds, .. } = limits;
        let endless = self.net.places().find(|p| bounds[p.index()] == TokenBound::Unbounded);
        let over = |p: &PlaceId| matches!(bounds[p.index()], TokenBound::Exactly(2..));
        let safe_no = endless.or_else(|| self.net.places().find(over)).map(|place| match self.two_on(place) {
            Some(run) => CertificateAnswer::no(NetProperty::Safe, Evidence::Overfull(run, place)),
            None => CertificateAnswer::Unknown(Unknown::TooLong),
        });
        let Some(of_place) = of_place.into_iter().collect::<Option<Vec<_>>>() else {
            let unknown = || CertificateAnswer::Unknown(Unknown::TooLarge);
            let bounded = endless.map_or_else(unknown, |place| self.pump(place));
            return (bounds, bounded, safe_no.unwrap_or_else(unknown));
        };
        let sums = Sums { bounds: of_place.into_iter().map(|(sum, bound)| (sum, bound.into())).collect(), ..sums };
        let safe = safe_no.unwrap_or_else(|| match sums.bounds.iter().all(|&(_, bound)| bound <= 1) {
            true => CertificateAnswer::yes(NetProperty::Safe, Evidence::Sums(sums.clone())),
            false => CertificateAnswer::Unknown(Unknown::TooLarge),
        });
        (bounds, CertificateAnswer::yes(NetProperty::Bounded, Evidence::Sums(sums)), safe)
    }
}

/// The bounds of all places, as far as they are known.
struct PlaceBounds {
    /// Without their bounds.
    sums: Sums,
    /// Per place, the sum that allows the fewest tokens, and how many.
    of_place: Vec<Option<(usize, u64)>>,
    bounds: Vec<TokenBound>,
    searches: usize,
    entries: usize,
}

impl PlaceBounds {
    fn new(graph: &WeightedGraph) -> PlaceBounds {
        let places = graph.edges.len();
        let sums = Sums { dead: graph.siphon.clone(), ..Sums::default() };
        PlaceBounds {
            sums,
            of_place: vec![None; places],
            bounds: vec![TokenBound::Unknown; places],
            searches: 0,
            entries: 0,
        }
    }

    /// Looks for the bound of a place, unless that would be too much. Its sum bounds the other places on the path too.
    fn search(&mut self, graph: &WeightedGraph, place: PlaceId, effort: Effort) {
        if self.searches >= effort.searches || self.entries >= effort.entries {
            return;
        }
        self.searches += 1;
        let Some((path, bound)) = graph.heaviest(place) else {
            self.bounds[place.index()] = TokenBound::Unbounded;
            return;
        };
        if self.of_place[place.index()].is_none_or(|(_, known)| bound < known) {
            self.entries += path.len();
            let number = self.sums.sums.len();
            for p in &path {
                let known = &mut self.of_place[p.index()];
                if known.is_none_or(|(_, known)| bound < known) {
                    *known = Some((number, bound));
                    self.bounds[p.index()] = match bound {
                        // In a live net no place is always empty, so nothing is less than 1.
                        1 if graph.siphon.is_empty() => TokenBound::Exactly(1),
                        _ => TokenBound::AtMost(bound.into()),
                    };
                }
            }
            self.sums.sums.push(path.into_iter().map(|place| (place, 1)).collect());
        }
        self.bounds[place.index()] = TokenBound::Exactly(bound.into());
    }
}

#[cfg(test)]
mod tests {
    use super::super::decide;
    use super::*;
    use crate::NetBuilder;

    /// Separate rings, each given by its length and the tokens on one place.
    fn rings(of: &[(usize, u32)]) -> Net {
        let mut b = NetBuilder::new("rings");
        for (ring, &(length, tokens)) in of.iter().enumerate() {
            let name = |i: usize| format!("{ring}.{i}");
            let places: Vec<_> = (0..length).map(|i| b.place(name(i), if i == 0 { tokens } else { 0 })).collect();
            for i in 0..length {
                let t = b.transition(name(i));
                b.input(t, places[i], 1).output(t, places[(i + 1) % length], 1);
            }
        }
        b.build().unwrap()
    }

    #[test]
    fn one_sum_bounds_a_whole_ring() {
        let net = rings(&[(50, 2), (30, 3)]);
        let verdict = decide(&net);
        let Some(Evidence::Sums(sums)) = verdict.bounded.certificate().map(|c| &c.evidence) else { panic!() };
        assert_eq!(sums.sums.len(), 2);
        assert!(
            verdict.bounds.iter().zip(0..).all(|(bound, i)| *bound == TokenBound::Exactly(if i < 50 { 2 } else { 3 }))
        );
        verdict.certificates().for_each(|certificate| crate::certificate::check(&net, certificate).unwrap());
    }

    #[test]
    fn with_too_little_effort_bounds_are_wider_or_unknown_and_never_wrong() {
        let few = |net: &Net, searches| {
            let graph = WeightedGraph::new(net);
            let (bounds, bounded, safe) = graph.bounds(Effort { searches, entries: usize::MAX });
            let answers = [bounded, safe];
            for certificate in answers.iter().filter_map(CertificateAnswer::certificate) {
                crate::certificate::check(net, certificate).unwrap();
            }
            (bounds, answers.map(|answer| answer.holds()))
        };
        let net = rings(&[(3, 2), (2, 1)]);
        assert_eq!(few(&net, 0), (vec![TokenBound::Unknown; 5], [None, None]));
        let [two, about_two, one] = [TokenBound::Exactly(2), TokenBound::AtMost(2), TokenBound::Exactly(1)];
        assert_eq!(few(&net, 1).0, [two, about_two, about_two, TokenBound::Unknown, TokenBound::Unknown]);
        assert_eq!(few(&net, 1).1, [None, Some(false)]);
        assert_eq!(few(&net, 3), (vec![two, two, two, TokenBound::Unknown, TokenBound::Unknown], [None, Some(false)]));
        assert_eq!(few(&net, 4), (vec![two, two, two, one, one], [Some(true), Some(false)]));
        assert_eq!(few(&rings(&[(9, 1)]), 1), (vec![one; 9], [Some(true), Some(true)]));
        // In a dead ring each place is limited by the transition before it.
        let dead = rings(&[(2, 0)]);
        assert_eq!(few(&dead, 1), (vec![TokenBound::Exactly(0), TokenBound::Unknown], [None, None]));
        assert_eq!(few(&dead, 2), (vec![TokenBound::Exactly(0); 2], [Some(true), Some(true)]));
    }
}
