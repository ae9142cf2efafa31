//! Subject and freedom of an exploration.
//!
//! The line is taken out of time: views, leases and watchdogs do not run out by themselves. What running out would do
//! is among what may happen anyway: a watchdog is a failing motion, a lapsed lease is a change of mode, and a stale
//! view only ever delays.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId};
use linewright_station_logic::Rules;

use super::station::StationAct;

/// Subject and freedom of an exploration. Made by [`LineExploration::new`]; the fields may be changed before exploring.
#[derive(Clone, Debug)]
pub struct LineExploration {
    pub(crate) line: Line,
    /// The rules in force; all of them on a machine.
    pub rules: Rules,
    /// The modes that may be granted.
    pub modes: Vec<ControlMode>,
    /// Rule by which modes come to the stations.
    pub grants: Grants,
    /// Most reports on their way to one reader; one more pushes the oldest out. 0: every report is received at once.
    pub lag: usize,
    /// Motions may fail, and devices may be lost for a moment.
    pub faults: bool,
    /// Stations are restarted at any moment, with their memories.
    pub restarts: bool,
    /// Stations are restarted at any moment of auto and hand mode, without their memories. Manual mode is not granted
    /// any more then: measured positions stand in for the counts in it, and these are not explored here. Deadlocks and
    /// ways home are not checked.
    pub forgets: bool,
    /// Operators let go of their panels before the mode changes. Fewer situations.
    pub tidy_hands: bool,
    /// Keep one state for all that differ only in what stations come and go between by themselves. Every verdict and
    /// every count is the same without, which is how it is tested; it only takes longer.
    pub lumped: bool,
    pub(crate) links: Vec<ReaderLink>,
}

/// Rule by which modes come to the stations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grants {
    /// By the coordinator's rule: a mode that enables motion is acted on only when every station has acknowledged its
    /// epoch, and so has left the mode before. Until then, and whenever an order or its lease ends, a station is in
    /// stand-by. The sequence of modes is arbitrary: what holds here holds under every decision.
    InEpochs,
    /// Each station receives any mode at any moment, whatever the others act on: a coordinator that keeps no rule.
    Anyhow,
}

/// Reader and writer, and the writer's counts that matter to the reader.
#[derive(Clone, Debug)]
pub(crate) struct ReaderLink {
    pub writer: usize,
    pub reader: usize,
    pub counts: Vec<OpId>,
    /// The link the other way.
    pub reverse: usize,
}

/// Nothing runs out within the one moment in which everything happens.
const FOR_EVER: Duration = Duration::from_secs(1 << 20);

impl LineExploration {
    /// Everything on: every rule, auto, hand and manual mode, faults, and reports that lag.
    ///
    /// Home and emergency stop are left out because they add nothing: they start nothing, as stand-by starts nothing,
    /// and what the emergency stop interrupts may fail in any mode.
    pub fn new(line: &Line) -> Self {
        let mut line = line.clone();
        (line.timing.stale, line.timing.lease) = (FOR_EVER, FOR_EVER);
        let links = links_of(&line);
        LineExploration {
            line,
            rules: Rules::COUNTS,
            modes: vec![ControlMode::Auto, ControlMode::Hand, ControlMode::Manual],
            grants: Grants::InEpochs,
            lag: 1,
            faults: true,
            restarts: false,
            forgets: false,
            tidy_hands: true,
            lumped: true,
            links,
        }
    }

    /// The line, out of time.
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// The same with stations that are restarted at any moment, with their memories and without, and the rule that counts of
    /// another generation are unknown.
    #[must_use]
    pub fn with_lost_memories(mut self) -> Self {
        self.rules.generations = true;
        if self.grants == Grants::Anyhow {
            self.modes.retain(|&mode| mode != ControlMode::Manual);
        }
        (self.restarts, self.forgets) = (true, true);
        self
    }

    /// Whether one report on its way over each link is every delay there is.
    ///
    /// It is where the stations that read each other form no ring. A reader that receives a report only after a newer
    /// one was sent could then as well have received it before: nothing it did in between can have come from the newer
    /// one, for the link itself is the only way from its writer.
    pub fn covers_every_delay(&self) -> bool {
        let mut group: Vec<usize> = (0..self.line.stations.len()).collect();
        self.links.iter().filter(|link| link.writer < link.reader).all(|link| {
            let (from, to) = (group[link.writer], group[link.reader]);
            group.iter_mut().filter(|number| **number == from).for_each(|number| *number = to);
            from != to
        })
    }

    /// Whether it is asked of all states together if each leads home and back to the start. Without manual mode a stopped
    /// motion cannot be recovered: then that is promised only where nothing fails.
    pub(crate) fn asks_for_ways(&self) -> bool {
        !self.forgets && (self.modes.contains(&ControlMode::Manual) || !self.faults)
    }

    /// Whether a station may hear of a mode, or anything else happen to it, while this mode is granted. Of the modes it
    /// may hear of, only the granted one and stand-by are there to be heard.
    pub(crate) fn lets(&self, granted: usize, act: StationAct) -> bool {
        match act {
            StationAct::Mode(mode) => {
                self.grants == Grants::Anyhow || mode == ControlMode::StandBy || self.modes[granted] == mode
            }
            StationAct::Forget => self.modes.get(granted) != Some(&ControlMode::Manual),
            _ => true,
        }
    }

    /// The links that end at a station, in their own order.
    pub(crate) fn into(&self, station: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.links.len()).filter(move |&link| self.links[link].reader == station)
    }

    /// The links that begin at a station, in their own order.
    pub(crate) fn out_of(&self, station: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.links.len()).filter(move |&link| self.links[link].writer == station)
    }
}

fn links_of(line: &Line) -> Vec<ReaderLink> {
    let mut links: Vec<ReaderLink> = Vec::new();
    for writer in line.station_ids() {
        for reader in line.station_ids() {
            let between = |a: StationId, b: StationId| line.arrows.iter().any(|x| x.from.0 == a && x.to.0 == b);
            if between(writer, reader) || between(reader, writer) {
                let read = line.arrows.iter().filter(|a| a.from.0 == writer && a.to.0 == reader);
                let mut counts: Vec<OpId> = read.map(|a| a.from.1).collect();
                counts.sort_unstable();
                counts.dedup();
                links.push(ReaderLink { writer: writer.index(), reader: reader.index(), counts, reverse: 0 });
            }
        }
    }
    for link in 0..links.len() {
        let (writer, reader) = (links[link].writer, links[link].reader);
        let back = links.iter().position(|other| other.writer == reader && other.reader == writer);
        links[link].reverse = back.expect("stations joined by an arrow read each other");
    }
    links
}
