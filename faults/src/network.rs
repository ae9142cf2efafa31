//! The network between processes: loss, copies, delay, overtaking, and partitions that heal.

use std::time::Duration;

use linewright_line::Tick;
use linewright_simulation::Rng;

use crate::message::{Message, TOPICS};

/// Effect on messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Weather {
    /// Lost, in ‰.
    pub loss: u64,
    /// Received twice, in ‰.
    pub double: u64,
    /// Additional delay at most.
    pub jitter: Duration,
}

impl Weather {
    pub(crate) const GOOD: Weather = Weather { loss: 0, double: 0, jitter: Duration::ZERO };
}

const DELAY: Duration = Duration::from_micros(700);

/// A way from one process to another.
#[derive(Clone, Debug, Default)]
struct Way {
    cuts: u32,
    /// Additional delay, and whether each message has all of it.
    slow: (Duration, bool),
    last: Tick,
    /// Newest message of each topic that was sent while the way was cut.
    kept: [Option<Message>; TOPICS],
}

#[derive(Debug)]
pub(crate) struct Network {
    pub(crate) weather: Weather,
    rng: Rng,
    nodes: usize,
    ways: Vec<Way>,
}

impl Network {
    pub(crate) fn new(seed: u64, nodes: usize) -> Self {
        let ways = vec![Way::default(); nodes * nodes];
        Network { weather: Weather::GOOD, rng: Rng::named(seed, "network"), nodes, ways }
    }

    /// When the copies of a message that is sent now arrive.
    pub(crate) fn send(&mut self, now: Tick, (from, to): (usize, usize), message: &Message) -> [Option<Tick>; 2] {
        let Weather { loss, double, jitter } = self.weather;
        let way = &mut self.ways[from * self.nodes + to];
        if way.cuts > 0 {
            if let Some(topic) = message.topic() {
                way.kept[topic] = Some(message.clone());
            }
            return [None; 2];
        }
        let is_repeated = message.topic().is_some()
            || matches!(message, Message::Panel(_) | Message::Buttons(_) | Message::Resume(_));
        if is_repeated && loss > 0 && self.rng.chance(loss) {
            return [None; 2];
        }
        let (rng, (slow, is_even)) = (&mut self.rng, way.slow);
        let mut arrival = || {
            let mut drawn = |most: Duration| if most.is_zero() { 0 } else { rng.below(most.as_micros() as u64 + 1) };
            let slow = if is_even { slow } else { Duration::from_micros(drawn(slow)) };
            now + DELAY + slow + Duration::from_micros(drawn(jitter))
        };
        let mut first = arrival();
        if !message.may_overtake() {
            first = first.max(way.last);
            way.last = first;
        }
        let is_double = is_repeated && double > 0 && self.rng.chance(double);
        [Some(first), is_double.then(|| first + Duration::from_micros(self.rng.below(20_000)))]
    }

    /// Everything on a way takes so much longer, or something of it.
    pub(crate) fn slow(&mut self, (from, to): (usize, usize), by: Duration, is_even: bool) {
        self.ways[from * self.nodes + to].slow = (by, is_even);
    }

    pub(crate) fn cut(&mut self, from: usize, to: usize) {
        self.ways[from * self.nodes + to].cuts += 1;
    }

    /// Joins a way; gives the messages that were kept for its reader.
    pub(crate) fn join(&mut self, from: usize, to: usize) -> Vec<Message> {
        let way = &mut self.ways[from * self.nodes + to];
        way.cuts = way.cuts.saturating_sub(1);
        if way.cuts > 0 { Vec::new() } else { way.kept.iter_mut().filter_map(Option::take).collect() }
    }
}
