//! Queue of arrivals while a record is being written, which takes as long as a disk takes.

use std::collections::VecDeque;

use linewright_fieldbus_seam::News;
use tokio::sync::mpsc;

/// Arrivals not taken yet. A record that takes longer than [`linewright_node_shell::Watchdog::LIMIT`] ends the process,
/// so this does not grow for ever.
pub struct Waiting<A> {
    /// Messages, oldest first.
    pub arrived: VecDeque<A>,
    /// News from the bus.
    pub news: Vec<News>,
}

impl<A> Default for Waiting<A> {
    fn default() -> Self {
        Waiting { arrived: VecDeque::new(), news: Vec::new() }
    }
}

impl<A> Waiting<A> {
    /// Takes from the channel what has arrived there, at most so many messages: no flood of them keeps the bus waiting.
    pub fn fill(&mut self, from: &mut mpsc::Receiver<A>, at_most: usize) {
        self.arrived.extend(std::iter::from_fn(|| from.try_recv().ok()).take(at_most));
    }

    pub fn is_empty(&self) -> bool {
        self.arrived.is_empty() && self.news.is_empty()
    }

    /// News from the bus, if any.
    pub fn take_news(&mut self) -> Option<Vec<News>> {
        (!self.news.is_empty()).then(|| std::mem::take(&mut self.news))
    }
}
