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
