//! Messages between the nodes: which are sent, to which reader, and when they are taken.
//!
//! A node sends its state when it changes and repeats it every refresh period; each link decides whether that is news
//! to its reader. A message without news is taken before the reader's next step, each at its own time.

use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::link::LinkPayload;
use crate::sim::LineSim;

impl LineSim {
    /// Takes messages that have arrived without news, each at its own time.
    #[inline]
    pub(crate) fn catch_up(&mut self, node: usize) {
        let mut renewals = std::mem::take(&mut self.renewals);
        for &at in &self.into[node] {
            self.links[at].take_repetitions(self.now, at, &mut renewals);
        }
        if renewals.len() > 1 {
            renewals.sort_unstable();
        }
        for (arrived, at) in renewals.drain(..) {
            let link = &self.links[at];
            let Some(said) = &link.heard else { continue };
            match self.stations.get_mut(node) {
                Some(station) => station.hear(arrived, link.from, said),
                None => self.coordinator.hear(arrived, link.from, said),
            }
        }
        self.renewals = renewals;
    }

    /// Where a person's button decides what a station does next, its controller is woken by every message: a press is
    /// looked at again in the step after the one it arrived in.
    pub(crate) fn attend(&mut self, at: usize) {
        let mode = self.stations[at].controller().mode();
        let attends = self.options.one_by_one || matches!(mode, ControlMode::Hand | ControlMode::Manual);
        for index in 0..self.into[at].len() {
            let link = self.into[at][index];
            if self.links[link].wakes_always != attends {
                self.links[link].wake_always(attends);
                self.timers.set(link, self.links[link].wakes());
            }
        }
    }

    /// A node repeats its state.
    pub(crate) fn repeat(&mut self, node: usize, life: u64) {
        if self.lives[node] != life || !self.is_up(node) {
            return;
        }
        if node < self.stations.len() {
            self.say_station(node);
        } else if node == self.coordinator_node() {
            self.say_order();
        } else {
            self.say_held();
        }
        let again = (self.now + self.line.timing.refresh, node, life);
        let place = self.repeats.partition_point(|repeat| repeat.0 <= again.0);
        self.repeats.insert(place, again);
    }

    pub(crate) fn say_station(&mut self, at: usize) {
        self.stations[at].write_report();
        let (now, network, coordinator) = (self.now, self.options.network, self.coordinator_node());
        for index in 0..self.out_of[at].len() {
            let number = self.out_of[at][index];
            if !self.is_up(self.links[number].to) {
                continue;
            }
            let (link, node) = (&mut self.links[number], &self.stations[at]);
            if link.has_said(node.version) {
                link.say_again(now, &network);
            } else if link.to == coordinator {
                link.say_heard(now, &network, node.heard(), node.version);
            } else {
                link.say_report(now, &network, &node.report, node.version);
            }
            self.timers.set(number, self.links[number].wakes());
        }
    }

    pub(crate) fn say_order(&mut self) {
        let (now, network) = (self.now, self.options.network);
        let node = self.coordinator_node();
        for index in 0..self.out_of[node].len() {
            let number = self.out_of[node][index];
            if self.is_up(self.links[number].to) {
                let order = self.coordinator.shell.order_for(StationId::at(self.links[number].to));
                self.links[number].say_order(now, &network, order);
                self.timers.set(number, self.links[number].wakes());
            }
        }
    }

    /// Sends an operator's message to a node.
    pub(crate) fn say_word(&mut self, to: usize, said: LinkPayload) {
        let operator = self.operator_node();
        let number = self.out_of[operator].iter().copied().find(|&at| self.links[at].to == to);
        if let Some(number) = number.filter(|_| self.is_reached(to)) {
            self.links[number].say_word(self.now, &self.options.network, said);
            self.timers.set(number, self.links[number].wakes());
        }
    }
}
