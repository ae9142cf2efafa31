//! What is said between nodes, and what a network does to it.
//!
//! The middleware's promises are not relied on: a message may be late, lost, doubled or overtaken. Lost is what is
//! said again anyway (states, orders, images, held buttons); a command is either delivered or, across a partition,
//! gone: its sender sees no answer and asks again. What people say carries no number, and an emergency stop is obeyed
//! whatever its number. For these one thing is relied on that the middleware does give: messages of one writer on one
//! topic arrive in their order, or not at all. An emergency stop that overtook its own end would cost another reset.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use linewright_coordinator_logic::Command;
use linewright_line::{OpId, StationId, Tick};
use linewright_station_logic::{ModeOrder, PanelCommand, Report};

use linewright_simulation::Rng;

/// Who speaks or listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Node {
    /// The coordinator with its gateway.
    Coordinator,
    /// A station's controller.
    Station(StationId),
    /// The people: panels, pages, consoles that speak by message.
    Operator,
}

/// A process image on its way, as the message that carries it.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Which life of the sender.
    pub boot_id: u64,
    /// Its number.
    pub sequence: u64,
    /// The bits.
    pub bits: u128,
    /// Whether the sender vouches for them.
    pub valid: bool,
    /// How often the devices have been lost.
    pub losses: u64,
    /// Outputs: the number of this image. Inputs: which life of the station, and which image of it, they were taken
    /// under.
    pub under: (u64, u64),
    /// Outputs: the newest mode epoch that was heard when they were decided.
    pub mode_epoch: u64,
}

/// What is said.
#[derive(Clone, Debug)]
pub enum Message {
    /// A station's state: sequence and content.
    Report(u64, Rc<Report>),
    /// The mode: sequence and content.
    Order(u64, ModeOrder),
    /// A station's inputs, from the gateway.
    Inputs(Image),
    /// A station's outputs, to the gateway.
    Outputs(Image),
    /// A station's panel.
    Panel(PanelCommand),
    /// An operator's confirmation of where a station stands.
    Rejoin(Option<OpId>),
    /// An operator's command.
    Command(Command),
    /// Hand-mode buttons held.
    Buttons(u32),
}

impl Message {
    fn is_repeated(&self) -> bool {
        match self {
            Message::Report(..) | Message::Order(..) | Message::Inputs(_) | Message::Outputs(_) => true,
            Message::Panel(PanelCommand::Selector(_)) | Message::Command(_) | Message::Rejoin(_) => false,
            Message::Panel(_) | Message::Buttons(_) => true,
        }
    }
}

/// What the network does to a message.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Shortest way, in microseconds.
    pub delay_min_us: u64,
    /// Longest way, in microseconds. Drawn for each message alone, so messages overtake each other.
    pub delay_max_us: u64,
    /// Lost, of a thousand repeated messages.
    pub loss_per_mille: u64,
    /// Doubled, of a thousand repeated messages.
    pub double_per_mille: u64,
}

impl Conditions {
    /// A quiet machine: a tenth of a millisecond or so, nothing lost.
    pub const QUIET: Conditions =
        Conditions { delay_min_us: 50, delay_max_us: 500, loss_per_mille: 0, double_per_mille: 0 };
    /// A loaded network: up to 20 ms, 5 % lost, 5 % doubled.
    pub const ROUGH: Conditions =
        Conditions { delay_min_us: 100, delay_max_us: 20_000, loss_per_mille: 50, double_per_mille: 50 };
}

/// The network's state.
#[derive(Clone, Debug)]
pub(crate) struct Network {
    pub(crate) conditions: Conditions,
    /// For process images, between the gateway and the stations.
    pub(crate) image_conditions: Conditions,
    /// Directed links that carry nothing.
    cut: BTreeSet<(Node, Node)>,
    /// When the last of what people said, and of the coordinator's orders, arrives, for each listener.
    last_word: BTreeMap<(Node, Node), Tick>,
}

impl Network {
    pub(crate) fn new(conditions: Conditions) -> Self {
        Network { conditions, image_conditions: conditions, cut: BTreeSet::new(), last_word: BTreeMap::new() }
    }

    pub(crate) fn cut(&mut self, from: Node, to: Node) {
        self.cut.insert((from, to));
    }

    pub(crate) fn heal(&mut self) {
        self.cut.clear();
    }

    fn conditions_of(&self, message: &Message) -> Conditions {
        match message {
            Message::Inputs(_) | Message::Outputs(_) => self.image_conditions,
            _ => self.conditions,
        }
    }

    /// When a message arrives: never, once, or several times.
    pub(crate) fn ways(
        &mut self,
        rng: &mut Rng,
        now: Tick,
        from: Node,
        to: Node,
        message: &Message,
    ) -> [Option<Tick>; 2] {
        let Conditions { delay_min_us, delay_max_us, loss_per_mille, double_per_mille } = self.conditions_of(message);
        let mut way = || now + std::time::Duration::from_micros(rng.within(delay_min_us, delay_max_us));
        let ways = [way(), way()];
        if self.cut.contains(&(from, to)) || (message.is_repeated() && rng.chance(loss_per_mille)) {
            return [None, None];
        }
        if from == Node::Operator {
            let last = self.last_word.entry((from, to)).or_insert(now);
            *last = ways[0].max(*last);
            return [Some(*last), None];
        }
        let again = message.is_repeated() && rng.chance(double_per_mille);
        if matches!(message, Message::Order(..)) {
            let last = self.last_word.entry((from, to)).or_insert(now);
            let first = ways[0].max(*last);
            *last = if again { ways[1].max(first) } else { first };
            return [Some(first), again.then_some(*last)];
        }
        [Some(ways[0]), again.then_some(ways[1])]
    }
}
