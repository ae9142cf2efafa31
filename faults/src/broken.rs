//! Messages as a mutant has their readers take them.

use std::rc::Rc;

use linewright_coordinator_logic::{ModeCommand, StationView};
use linewright_line::net::ControlMode;
use linewright_station_logic::{ModeOrder, StationReport, StationSnapshot};

use crate::message::Message;
use crate::mutants::Mutant;
use crate::world::World;

/// The last message of each writer to each reader, and a number for what is taken by arrival.
pub(crate) struct LastHeard {
    nodes: usize,
    messages: Vec<Option<Message>>,
    number: u64,
}

impl LastHeard {
    pub(crate) fn new(nodes: usize) -> Self {
        LastHeard { nodes, messages: vec![None; nodes * nodes], number: 1 << 40 }
    }
}

impl World {
    pub(crate) fn mutant_is(&self, mutant: Mutant) -> bool {
        self.mutant == Some(mutant)
    }

    /// A message as the mutant has its reader take it.
    pub(crate) fn mutated(&mut self, reader: usize, mut message: Message) -> Message {
        let Some(mutant) = self.mutant else { return message };
        let shell = self.stations.get(reader).and_then(|at| at.shell.as_ref());
        let (followed, newest, own) = shell.map_or((0, 0, 0), |shell| {
            let controller = shell.controller();
            (controller.followed(), controller.mode_epoch(), shell.boot_id())
        });
        match &mut message {
            Message::Order { order, sequence } if reader < self.stations.len() => {
                let is_foreign = followed != 0 && order.boot_id != followed;
                if mutant == Mutant::RivalObeyed && is_foreign {
                    (order.boot_id, *sequence) = (followed, self.next_number());
                } else if mutant == Mutant::OldOrdersObeyed && order.epoch < newest && !is_foreign {
                    (order.epoch, *sequence) = (newest, self.next_number());
                } else if mutant == Mutant::EpochsUnread && newest != 0 {
                    order.epoch = newest;
                } else {
                    self::order(mutant, order, (is_foreign, own));
                }
            }
            Message::State { report, .. } if reader < self.stations.len() => {
                let changed = self::report(mutant, report, own);
                if let Some(changed) = changed {
                    *report = Rc::new(changed);
                }
            }
            Message::Outputs { image, .. } if mutant == Mutant::GatewayStopIgnored => image.mode_epoch = u64::MAX,
            _ => {}
        }
        self.renewed(reader, mutant, message)
    }

    fn renewed(&mut self, reader: usize, mutant: Mutant, mut message: Message) -> Message {
        let topic = mutant.renews();
        if topic.is_none() || message.topic() != topic {
            return message;
        }
        let number = self.next_number();
        let writer = match &mut message {
            Message::Order { sequence, .. } => {
                *sequence = number;
                self.coordinator_node()
            }
            Message::State { sequence, station, .. } | Message::Outputs { sequence, station, .. } => {
                *sequence = number;
                station.index()
            }
            _ => return message,
        };
        let nodes = self.last.nodes;
        self.last.messages[reader * nodes + writer] = Some(message.clone());
        message
    }

    fn next_number(&mut self) -> u64 {
        self.last.number += 1;
        self.last.number
    }

    /// With a mutant that renews them, the last messages count as if they had been sent again.
    pub(crate) fn renew(&mut self) {
        let Some(topic) = self.mutant.and_then(Mutant::renews) else { return };
        let nodes = self.last.nodes;
        for reader in 0..self.operator_node() {
            if !self.process(reader).runs() || self.process(reader).writing.is_some() {
                continue;
            }
            for writer in 0..nodes {
                let Some(message) = self.last.messages[reader * nodes + writer].clone() else { continue };
                if message.topic() != Some(topic) {
                    continue;
                }
                let message = self.mutated(reader, message);
                if reader < self.stations.len() {
                    self.hand_to_station(reader, &message);
                } else {
                    self.hand_to_coordinator(reader - self.stations.len(), &message);
                }
            }
            self.run_node(reader);
        }
    }

    /// What the coordinator takes from a station's state.
    pub(crate) fn mutated_view(&self, which: usize, station: usize, mut heard: StationView) -> StationView {
        let Some(mutant) = self.mutant else { return heard };
        match mutant {
            Mutant::AutoAwayFromHome => heard.at_home = true,
            Mutant::LostPositionUnheard => heard.position_lost = false,
            Mutant::IncompleteUnheard => (heard.incomplete, heard.incomplete_op) = (false, None),
            Mutant::DevicesUnheard => heard.devices_valid = true,
            Mutant::MotionUnheard => heard.stopped = true,
            Mutant::GenerationsUnheard if heard.generation == 0 => {
                let other = |at: &crate::station::StationProcess| Some(at.shell.as_ref()?.controller().generation());
                heard.generation = self.stations.iter().filter_map(other).max().unwrap_or(0);
            }
            Mutant::AcknowledgedUnheard => {
                let epoch = self.coordinators[which].shell.as_ref().map_or(0, |shell| shell.coordinator().epoch());
                (heard.mode_epoch, heard.follows) = (heard.mode_epoch.max(epoch), 0);
            }
            // Manual waits until every station has received the stop, and the gateway looks at the epoch of each image: either alone
            // keeps off what was decided before.
            Mutant::GatewayStopIgnored => {
                let coordinator = self.coordinators[which].shell.as_ref().map(|shell| shell.coordinator());
                if coordinator.is_some_and(|coordinator| coordinator.mode() == ControlMode::EStop) {
                    let epoch = coordinator.map_or(0, |coordinator| coordinator.epoch());
                    (heard.mode_epoch, heard.follows, heard.stopped) = (heard.mode_epoch.max(epoch), 0, true);
                }
            }
            Mutant::StationStopUnheard => heard.estopped = false,
            Mutant::RestartUnheard => heard.boot_id = station as u64 + 1,
            _ => {}
        }
        heard
    }

    /// Commands that come to a coordinator before this one.
    pub(crate) fn commands_before(&self, command: ModeCommand) -> Option<ModeCommand> {
        (self.mutant_is(Mutant::ResetNotNeeded) && command == ModeCommand::Manual).then_some(ModeCommand::Reset)
    }

    /// A station's record as it reaches the disk.
    pub(crate) fn mutated_record(&self, at: usize, mut record: StationSnapshot) -> StationSnapshot {
        match self.mutant {
            Some(Mutant::RecordWithoutPath) => record.path = None,
            Some(Mutant::RequestNumbersUsedAgain) => record.next_request = 1,
            Some(Mutant::RecordWithoutCounts) => {
                let station = &self.line.stations[at];
                for op in station.op_ids() {
                    record.done[op.index()] = record.done[op.index()].min(station.home_count(op, 0));
                    record.started[op.index()] = record.done[op.index()];
                }
            }
            _ => {}
        }
        record
    }
}

fn order(mutant: Mutant, order: &mut ModeOrder, (is_foreign, own): (bool, u64)) {
    match mutant {
        Mutant::ForeignStopIgnored if is_foreign && order.mode == ControlMode::EStop => {
            order.mode = ControlMode::StandBy;
        }
        Mutant::EnabledAlways => order.enabled = true,
        Mutant::OrderOfAnotherLife => order.station_life = own,
        Mutant::GenerationsAlike => {
            if let Some(found) = &mut order.found {
                *found = 7;
            }
        }
        Mutant::FoundingLost => order.found = None,
        _ => {}
    }
}

/// Another station's state, where it is taken otherwise.
fn report(mutant: Mutant, report: &StationReport, own: u64) -> Option<StationReport> {
    let mut changed = report.clone();
    match mutant {
        Mutant::AgreementsInvented => changed.answers.iter_mut().for_each(|answer| answer.in_the_way = None),
        Mutant::AgreementsOfEarlierLives => changed.answers.iter_mut().for_each(|answer| answer.boot_id = own),
        Mutant::RequestsUnread => changed.request = None,
        _ => return None,
    }
    Some(changed)
}
