//! One directed way of messages, from one writer to one reader.
//!
//! Messages arrive in their order, as a reliable or a keep-newest reader sees them, each after the network's delay; only with
//! [`Network::best_effort`] those that are read by their numbers overtake each other. A way that is cut carries nothing.
//! Nodes repeat their whole state every refresh period. A repetition without news for *this* reader only renews a term: it
//! moves the moment at which the reader's view would run out. Such a message is queued like any other, with its own delay and
//! its own chance to be lost, but it wakes no reader: the reader takes it, at the time of its arrival, before the next thing
//! it does. Between two things it does, there is no difference. If the writer dies nothing is queued any more, and the
//! reader's own deadline finds the view run out at the right microsecond. A repetition that comes after that is news, for
//! what was unknown is known again: it wakes the reader.

use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, OutputImage, StationView};
use linewright_line::{OpId, StationId, Tick};
use linewright_random::stir;
use linewright_station_logic::{ModeOrder, PanelCommand, StationReport};
use linewright_station_shell::InputsMessage;

use crate::options::Network;

/// Contents of a message.
#[derive(Clone, Debug)]
pub(crate) enum LinkPayload {
    /// The same as before, to this reader.
    Again,
    /// A station's state, to another station.
    Report(Rc<StationReport>),
    /// A station's state, as far as the coordinator looks at it.
    Heard(StationView),
    Order(ModeOrder),
    /// An operator's confirmation of where a station stands.
    Rejoin(Option<OpId>),
    /// A panel's button or selector.
    Panel(PanelCommand),
    /// An operator's command.
    Command(ModeCommand),
    /// Hand-mode buttons held.
    Buttons(u32),
    /// Resume held.
    Resume(bool),
    /// A whole message, with its number.
    Whole(Box<Numbered>),
}

/// A message that is read by its number.
#[derive(Clone, Debug)]
pub(crate) struct Numbered {
    /// In its writer's life.
    pub(crate) number: u64,
    pub(crate) said: WholeMessage,
}

/// Contents of such a message.
#[derive(Clone, Debug)]
pub(crate) enum WholeMessage {
    /// A station's state, to another station.
    Report(Rc<StationReport>),
    /// A station's state, as far as the coordinator looks at it.
    Heard(StationView),
    Order(ModeOrder),
    /// A station's inputs, from the gateway.
    Inputs(InputsMessage),
    /// A station's outputs, to the gateway.
    Outputs(OutputImage),
}

impl LinkPayload {
    /// The state it carries to another station, if any.
    pub(crate) fn report(&self) -> Option<&StationReport> {
        match self {
            LinkPayload::Report(report) => Some(report),
            LinkPayload::Whole(message) => match &message.said {
                WholeMessage::Report(report) => Some(report),
                _ => None,
            },
            _ => None,
        }
    }
}

#[derive(Clone, Debug)]
struct LinkMessage {
    arrives: Tick,
    said: LinkPayload,
    /// The reader must look at once.
    wakes: bool,
}

/// One directed way.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Between stations: the operations of the writer that the reader has an arrow from. It looks at no other count.
    reads: Vec<OpId>,
    /// The inputs of the writer that measure whether the two are clear of each other, where a conflict joins them. Then the
    /// reader looks at the writer's marking, too.
    measures: Option<u128>,
    /// The reader judges by the writer's cycle; see [`linewright_station_logic::Rules::counted`].
    reads_cycle: bool,
    queue: VecDeque<LinkMessage>,
    last_arrival: Tick,
    /// Validity of a message.
    term: Duration,
    /// Time until which the reader relies on what it has taken so far.
    holds_until: Tick,
    sent: u64,
    key: u64,
    /// Last message sent and not lost.
    said: Option<LinkPayload>,
    /// Number of that state of the writer.
    said_version: u64,
    /// Last message received.
    pub(crate) heard: Option<LinkPayload>,
    /// It carries nothing.
    pub(crate) is_cut: bool,
    /// The reader is woken by repetitions too.
    pub(crate) wakes_always: bool,
    /// Until then every message wakes the reader: which is the first of a new life of the writer that it takes depends on when the
    /// one before was received last.
    new_life_until: Tick,
    /// Arrival of the first message that wakes the reader.
    wakes: Tick,
}

impl Link {
    pub(crate) fn new(
        (from, to): (usize, usize),
        (reads, measures): (Vec<OpId>, Option<u128>),
        reads_cycle: bool,
        term: Duration,
        seed: u64,
    ) -> Self {
        let key = stir(seed ^ stir((from as u64) << 32 | to as u64));
        Link {
            from,
            to,
            reads,
            measures,
            reads_cycle,
            queue: VecDeque::new(),
            last_arrival: Tick::ZERO,
            term,
            holds_until: Tick::ZERO,
            sent: 0,
            key,
            said: None,
            said_version: 0,
            heard: None,
            is_cut: false,
            wakes_always: false,
            new_life_until: Tick::ZERO,
            wakes: Tick::NEVER,
        }
    }

    /// Whether state number `version` of the writer has been sent already: then it is the same again.
    pub(crate) fn has_said(&self, version: u64) -> bool {
        self.said.is_some() && self.said_version == version
    }

    /// Repeats the last message.
    pub(crate) fn say_again(&mut self, now: Tick, network: &Network) {
        self.say_state(now, network, true, self.said_version, || LinkPayload::Again);
    }

    /// Sends a station's state, number `version`.
    pub(crate) fn say_report(&mut self, now: Tick, network: &Network, report: &Rc<StationReport>, version: u64) {
        let is_known = match &self.said {
            Some(LinkPayload::Report(before)) => self.is_same(before, report),
            _ => false,
        };
        self.say_state(now, network, is_known, version, || LinkPayload::Report(Rc::clone(report)));
    }

    /// Sends a station's state to the coordinator.
    pub(crate) fn say_heard(&mut self, now: Tick, network: &Network, heard: StationView, version: u64) {
        let is_known = matches!(&self.said, Some(LinkPayload::Heard(before)) if *before == heard);
        self.say_state(now, network, is_known, version, || LinkPayload::Heard(heard));
    }

    pub(crate) fn say_order(&mut self, now: Tick, network: &Network, order: ModeOrder) {
        let is_known = matches!(&self.said, Some(LinkPayload::Order(before)) if *before == order);
        self.say_state(now, network, is_known, self.said_version, || LinkPayload::Order(order));
    }

    fn say_state(
        &mut self,
        now: Tick,
        network: &Network,
        is_known: bool,
        version: u64,
        what: impl Fn() -> LinkPayload,
    ) {
        let before = self.last_arrival;
        let Some(arrives) = self.way(now, network) else { return };
        self.said_version = version;
        let said = if is_known { LinkPayload::Again } else { what() };
        if !is_known {
            self.said = Some(said.clone());
        }
        let wakes = !is_known || arrives >= before + self.term || arrives < self.new_life_until;
        self.push(LinkMessage { arrives, said, wakes });
    }

    /// Sends a whole message, number `number` of its writer.
    pub(crate) fn say_numbered(&mut self, now: Tick, network: &Network, number: u64, said: WholeMessage) {
        // An order that overtook the end of an emergency stop would cost another reset.
        let overtakes = network.best_effort && !matches!(said, WholeMessage::Order(_));
        let key = stir(!self.key ^ stir(self.sent));
        let is_doubled = network.double_per_mille > 0 && key % 1000 < u64::from(network.double_per_mille);
        let mut way = || if overtakes { self.draw(now, network) } else { self.way(now, network) };
        let Some(arrives) = way() else { return };
        let again = is_doubled.then(way).flatten();
        let said = LinkPayload::Whole(Box::new(Numbered { number, said }));
        if let Some(arrives) = again {
            self.push_between(LinkMessage { arrives, said: said.clone(), wakes: true });
        }
        self.push_between(LinkMessage { arrives, said, wakes: true });
    }

    /// Sends an input of a person. It is not lost; but with [`Network::best_effort`] held buttons, which are repeated, can be.
    pub(crate) fn say_word(&mut self, now: Tick, network: &Network, said: LinkPayload) {
        let is_held = match said {
            LinkPayload::Panel(command) => !matches!(command, PanelCommand::Selector(_)),
            LinkPayload::Buttons(_) | LinkPayload::Resume(_) => true,
            _ => false,
        };
        let loss_per_mille = if network.best_effort && is_held { network.loss_per_mille } else { 0 };
        if let Some(arrives) = self.way(now, &Network { loss_per_mille, ..*network }) {
            self.push(LinkMessage { arrives, said, wakes: true });
        }
    }

    fn is_same(&self, before: &StationReport, now: &StationReport) -> bool {
        let reader = StationId::at(self.to);
        let answer = |report: &StationReport| report.answers.iter().find(|answer| answer.to == reader).copied();
        before.boot_id == now.boot_id
            && before.request == now.request
            && (before.generation, before.position_lost, before.devices_valid)
                == (now.generation, now.position_lost, now.devices_valid)
            && self.measures.is_none_or(|inputs| {
                (before.measured ^ now.measured) & inputs == 0
                    && (&before.places, before.recovering_home) == (&now.places, now.recovering_home)
            })
            && self.reads.iter().all(|op| before.done[op.index()] == now.done[op.index()])
            && answer(before) == answer(now)
            && (!self.reads_cycle || before.cycle == now.cycle)
    }

    /// Arrival of a message that is sent now and stays behind those before it, if it arrives.
    fn way(&mut self, now: Tick, network: &Network) -> Option<Tick> {
        let arrives = self.draw(now, network)?;
        self.last_arrival = self.last_arrival.max(arrives);
        Some(self.last_arrival)
    }

    /// Arrival of a message that is sent now, if it arrives.
    #[inline]
    fn draw(&mut self, now: Tick, network: &Network) -> Option<Tick> {
        self.sent += 1;
        let mut arrives = now + network.delay;
        let loss = u64::from(network.loss_per_mille);
        if self.is_cut || loss > 0 && stir(self.key ^ stir(self.sent)) % 1000 < loss {
            return None;
        }
        let jitter = network.jitter.as_micros() as u64;
        if jitter > 0 {
            let drawn = stir(self.key.rotate_left(32) ^ stir(self.sent)) % (jitter + 1);
            arrives = Tick::from_micros(arrives.as_micros() + drawn);
        }
        Some(arrives)
    }

    #[inline]
    fn push(&mut self, message: LinkMessage) {
        if self.wakes == Tick::NEVER && (self.wakes_always || message.wakes) {
            self.wakes = message.arrives;
        }
        self.queue.push_back(message);
    }

    /// The same of a message that may arrive before others.
    fn push_between(&mut self, message: LinkMessage) {
        self.wakes = self.wakes.min(message.arrives);
        let after = self.queue.partition_point(|before| before.arrives <= message.arrives);
        self.queue.insert(after, message);
    }

    /// Time at which it next wakes the reader.
    pub(crate) fn wakes(&self) -> Tick {
        self.wakes
    }

    fn find_wake(&mut self) {
        let wakes_always = self.wakes_always;
        let first = self.queue.iter().find(|message| wakes_always || message.wakes);
        self.wakes = first.map_or(Tick::NEVER, |message| message.arrives);
    }

    /// Whether repetitions wake the reader from now on.
    pub(crate) fn wake_always(&mut self, always: bool) {
        self.wakes_always = always;
        self.find_wake();
    }

    /// Takes the repetitions that have arrived until `now` before the next message with news, and puts the moments that
    /// matter to the reader into `moments`, with `number`: the last one, and of the others only those without which the
    /// term would have run out in between.
    #[inline]
    pub(crate) fn take_repetitions(&mut self, now: Tick, number: usize, moments: &mut Vec<(Tick, usize)>) {
        let mut last = None;
        while let Some(&LinkMessage { arrives, said: LinkPayload::Again, .. }) = self.queue.front()
            && arrives <= now
        {
            if let Some(before) = last
                && arrives >= self.holds_until
            {
                moments.push((before, number));
                self.holds_until = before + self.term;
            }
            last = Some(arrives);
            self.queue.pop_front();
        }
        if let Some(last) = last {
            moments.push((last, number));
            self.holds_until = last + self.term;
            if last >= self.wakes {
                self.find_wake();
            }
        }
    }

    /// Takes the message that has arrived at `now` and has news.
    pub(crate) fn take_news(&mut self, now: Tick) -> Option<LinkPayload> {
        if self.queue.front().is_none_or(|message| message.arrives > now) {
            return None;
        }
        let LinkMessage { arrives, said, .. } = self.queue.pop_front()?;
        self.holds_until = arrives + self.term;
        self.find_wake();
        // A whole message is not repeated by an [`LinkPayload::Again`].
        if !matches!(said, LinkPayload::Whole(_)) {
            self.heard = Some(said.clone());
        }
        Some(said)
    }

    /// The writer has started anew, without its predecessor's messages.
    pub(crate) fn forget_said(&mut self) {
        self.said = None;
        self.new_life_until = self.last_arrival + 2 * self.term;
    }

    /// The reader has started anew: a repetition counts only after a first message.
    pub(crate) fn forget_heard(&mut self) {
        self.said = None;
        self.heard = None;
        self.queue.clear();
        self.wakes = Tick::NEVER;
    }
}
