//! Rules that are broken: in the world around the shells, or in the controllers.
//!
//! A world that breaks none of its promises finds nothing wrong with a sound product. It is worth believing only if it finds
//! something wrong with each of these.

use linewright_station_logic::Rules;

use crate::message::Message;
use crate::world::World;

/// One broken rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mutant {
    /// A station writes its record after everything that follows from it.
    RecordAfterEffects,
    /// A station's record is acknowledged and never kept.
    RecordNotKept,
    /// A station's record is acknowledged before it is written; on a slow disk it is never there.
    AcknowledgedBeforeWritten,
    /// A record from before the last start of the host counts as the newest.
    HostStartIgnored,
    /// A station without its journal says it has the generation of the others.
    MemorylessBelieved,
    /// What a slow record held up is put out after it.
    LateEffects,
    /// An emergency stop waits for the record that is being written.
    StopWaitsForRecord,
    /// The coordinator's record leaves the emergency stop out.
    StopNotRecorded,
    /// A record of the coordinator that failed counts as written.
    FailedRecordIgnored,
    /// An emergency stop of another coordinator is not obeyed.
    ForeignStopIgnored,
    /// The orders of any coordinator count as those of the one that is followed.
    RivalObeyed,
    /// Messages are taken in the order of their arrival, whatever their number.
    NumbersIgnored,
    /// A mode order holds until the next one arrives.
    LeaseIgnored,
    /// A station's state holds until the next one arrives.
    StaleViewBelieved,
    /// A station's outputs hold at the gateway until the next ones arrive.
    GatewayAgeIgnored,
    /// A loss of devices shorter than a scan is not seen.
    LossesUnseen,
    /// Counts of another generation are compared.
    GenerationsOff,
    /// The barrier of counts is off.
    CountsOff,
    /// The barrier of counts is off in one direction: Booleans instead of counts.
    BooleansInstead,
    /// The barrier of measured positions is off.
    PositionsOff,
    /// Both barriers are off.
    BarriersOff,
    /// Counts are taken back without agreement.
    AgreementOff,
    /// A count is taken back after the motion.
    WithdrawnLate,
}

impl Mutant {
    /// All of them.
    pub const ALL: [Mutant; 23] = [
        Mutant::RecordAfterEffects,
        Mutant::RecordNotKept,
        Mutant::AcknowledgedBeforeWritten,
        Mutant::HostStartIgnored,
        Mutant::MemorylessBelieved,
        Mutant::LateEffects,
        Mutant::StopWaitsForRecord,
        Mutant::StopNotRecorded,
        Mutant::FailedRecordIgnored,
        Mutant::ForeignStopIgnored,
        Mutant::RivalObeyed,
        Mutant::NumbersIgnored,
        Mutant::LeaseIgnored,
        Mutant::StaleViewBelieved,
        Mutant::GatewayAgeIgnored,
        Mutant::LossesUnseen,
        Mutant::GenerationsOff,
        Mutant::CountsOff,
        Mutant::BooleansInstead,
        Mutant::PositionsOff,
        Mutant::BarriersOff,
        Mutant::AgreementOff,
        Mutant::WithdrawnLate,
    ];

    /// The rules that its controllers keep.
    pub(crate) fn rules(self) -> Rules {
        let all = Rules::ALL;
        match self {
            Mutant::GenerationsOff => Rules { generations: false, ..all },
            Mutant::CountsOff => Rules { arrows: false, ..all },
            Mutant::BooleansInstead => Rules { counted: false, ..all },
            Mutant::PositionsOff => Rules { positions: false, ..all },
            Mutant::BarriersOff => Rules { positions: false, arrows: false, ..all },
            Mutant::AgreementOff => Rules { ask: false, ..all },
            Mutant::WithdrawnLate => Rules { withdraw_first: false, ..all },
            _ => all,
        }
    }

    fn renews(self) -> Option<usize> {
        match self {
            Mutant::LeaseIgnored => Some(0),
            Mutant::StaleViewBelieved => Some(1),
            Mutant::GatewayAgeIgnored => Some(3),
            _ => None,
        }
    }
}

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
        if mutant == Mutant::RivalObeyed || mutant == Mutant::ForeignStopIgnored {
            let followed =
                self.stations.get(reader).and_then(|at| at.shell.as_ref()).map_or(0, |s| s.controller().followed());
            if let Message::Order { order, sequence } = &mut message
                && followed != 0
                && order.boot_id != followed
            {
                if mutant == Mutant::RivalObeyed {
                    (order.boot_id, *sequence) = (followed, self.next_number());
                } else if order.mode == linewright_line::net::ControlMode::EStop {
                    order.mode = linewright_line::net::ControlMode::StandBy;
                }
            }
            return message;
        }
        let topic = mutant.renews();
        if topic.is_some() && message.topic() == topic || mutant == Mutant::NumbersIgnored {
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
                Message::Inputs(image) => {
                    image.sequence = number;
                    self.coordinator_node()
                }
                _ => return message,
            };
            let nodes = self.last.nodes;
            self.last.messages[reader * nodes + writer] = Some(message.clone());
        }
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
}
