//! Stretches of time that do not overlap, and taking some out of them.

use std::time::Duration;

use linewright_line::Tick;

/// From a moment until another.
pub type Stretch = (Tick, Tick);

/// Stretches in their order, none of which overlap.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spans(Vec<Stretch>);

impl Spans {
    /// Of these, in any order; overlapping ones are joined, empty ones left out.
    pub fn of(stretches: impl IntoIterator<Item = Stretch>) -> Self {
        let mut all: Vec<Stretch> = stretches.into_iter().filter(|(from, to)| from < to).collect();
        all.sort_unstable();
        let mut joined: Vec<Stretch> = Vec::with_capacity(all.len());
        for (from, to) in all {
            match joined.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => joined.push((from, to)),
            }
        }
        Spans(joined)
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = Stretch> {
        self.0.iter().copied()
    }

    /// All of it together.
    pub fn total(&self) -> Duration {
        self.0.iter().map(|(from, to)| to.since(*from)).sum()
    }

    /// Removes the intersection with the others; gives its duration.
    pub fn take(&mut self, others: &Spans) -> Duration {
        let (mut rest, mut taken) = (Vec::with_capacity(self.0.len()), Duration::ZERO);
        let mut others = others.0.as_slice();
        for &(mut from, to) in &self.0 {
            while let Some(&(begin, end)) = others.first() {
                if end <= from {
                    others = &others[1..];
                } else if begin >= to {
                    break;
                } else {
                    if from < begin {
                        rest.push((from, begin));
                    }
                    taken += end.min(to).since(begin.max(from));
                    from = end.min(to);
                    if end >= to {
                        break;
                    }
                }
            }
            if from < to {
                rest.push((from, to));
            }
        }
        self.0 = rest;
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spans(of: &[(u64, u64)]) -> Spans {
        Spans::of(of.iter().map(|&(from, to)| (Tick::from_millis(from), Tick::from_millis(to))))
    }

    #[test]
    fn what_overlaps_or_touches_is_joined() {
        assert_eq!(spans(&[(5, 9), (1, 3), (2, 4), (4, 5), (7, 7), (20, 30)]), spans(&[(1, 9), (20, 30)]));
        assert_eq!(spans(&[(1, 9), (20, 30)]).total(), Duration::from_millis(18));
    }

    #[test]
    fn what_is_taken_and_what_is_left_are_the_whole() {
        for (others, left) in [
            (vec![], vec![(10, 20), (30, 40)]),
            (vec![(0, 5), (20, 30), (40, 50)], vec![(10, 20), (30, 40)]),
            (vec![(12, 15)], vec![(10, 12), (15, 20), (30, 40)]),
            (vec![(11, 12), (13, 14), (15, 35)], vec![(10, 11), (12, 13), (14, 15), (35, 40)]),
            (vec![(0, 100)], vec![]),
        ] {
            let mut of = spans(&[(10, 20), (30, 40)]);
            let taken = of.take(&spans(&others));
            assert_eq!(of, spans(&left), "{others:?}");
            assert_eq!(taken + of.total(), Duration::from_millis(20), "{others:?}");
        }
    }
}
