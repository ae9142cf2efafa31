//! What is to happen, by time; what is to happen at the same moment, in the order in which it was planned.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use linewright_fieldbus::Frame;
use linewright_line::Tick;

use crate::network::{Message, Node};

/// What happens at a moment.
#[derive(Debug)]
pub(crate) enum Due {
    /// A message arrives.
    Message { from: Node, to: Node, message: Message },
    /// A node's deadline.
    Wake(Node),
    /// A frame arrives at the devices.
    ToDevices(Frame),
    /// A frame arrives at the manager.
    ToManager(Frame),
    /// The devices' or the mechanisms' deadline.
    Field,
    /// Held buttons are said again.
    Fingers,
}

#[derive(Debug)]
struct Event {
    at: Tick,
    order: u64,
    due: Due,
}

impl PartialEq for Event {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Event {}

impl PartialOrd for Event {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Event {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.at, self.order).cmp(&(other.at, other.order))
    }
}

/// The queue.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    events: BinaryHeap<Reverse<Event>>,
    planned: u64,
}

impl Queue {
    pub(crate) fn push(&mut self, at: Tick, due: Due) {
        self.planned += 1;
        self.events.push(Reverse(Event { at, order: self.planned, due }));
    }

    pub(crate) fn pop(&mut self) -> Option<(Tick, Due)> {
        self.events.pop().map(|Reverse(event)| (event.at, event.due))
    }

    /// When the next thing happens.
    pub(crate) fn next(&self) -> Option<Tick> {
        self.events.peek().map(|Reverse(event)| event.at)
    }
}
