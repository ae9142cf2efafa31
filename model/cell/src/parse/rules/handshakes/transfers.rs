//! Parts that are handed over while nothing says where the other holder stands: a hand that lets go at the clamp of another station,
//! or carries away what it has taken there.
//!
//! Looked for in all states in which the operation may start, so only where every input that the orders wait for is understood. A
//! station without an order in the activity does what it likes: its inputs are on and off, and order nothing here. A clamp that is
//! certainly open may get its part laid in, so letting go is reported only where the clamp may be open and closed, or moves.

use linewright_line::{Grip, InputId, Reach, Sensor, Sign, Stand};
use linewright_text::Problem;

use super::{Handshake, Player, State, SwitchEdge, axis_of, same_place, stands_of};

/// What an operation does with a part at a clamp of another station.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PartTransfer {
    LetsGo,
    CarriesAway,
}

/// An operation that hands a part over, and the clamp.
struct ClampTransfer {
    player: usize,
    operation: usize,
    what: PartTransfer,
    /// Where the clamp is closed.
    closed: Stand,
}

impl Player<'_, '_> {
    pub(super) fn stands(&self, progress: usize, stand: &Stand) -> bool {
        stand.station == self.id && self.places[progress][stand.axis.index()].is_some_and(|at| same_place(at, stand.at))
    }

    pub(super) fn is_at(&self, progress: usize, reach: &Reach) -> bool {
        reach.when.iter().all(|stand| self.stands(progress, stand))
    }

    /// What an operation does with a part at what the hand reaches.
    pub(super) fn transfer(&self, operation: usize, reach: &Reach, hand: &Stand) -> Option<PartTransfer> {
        let (before, after) = (operation * 2, operation * 2 + 2);
        if !self.is_at(before, reach) || !self.stands(before, hand) {
            return None;
        }
        if !self.stands(after, hand) {
            return Some(PartTransfer::LetsGo);
        }
        // It has closed there, so what it holds may be held by both.
        let closes = self.operations[..operation].iter().rposition(|of| of.motion.axis == hand.axis)?;
        (self.is_at(closes * 2, reach) && !self.is_at(after, reach)).then_some(PartTransfer::CarriesAway)
    }
}

impl Handshake<'_, '_> {
    /// A warning for each operation that hands a part over while the clamp may stand anywhere.
    pub(super) fn unordered_transfers(&self, left: &mut usize) -> Vec<Problem> {
        let Some(states) = self.states(None, SwitchEdge::Sharp, left) else { return Vec::new() };
        let transfers = (0..self.players.len()).flat_map(|player| self.transfers(player));
        transfers
            .filter(|of| self.is_understood(of) && self.is_unordered(of, &states))
            .filter_map(|of| self.unordered(&of))
            .collect()
    }

    fn transfers(&self, player: usize) -> Vec<ClampTransfer> {
        let (of, flow) = (&self.players[player], &self.line.handling);
        let at_clamp = |reach: &Reach| {
            let (Grip::Hand(hand), Grip::Clamp(closed)) = (flow.holder(reach.hand).grip, flow.holder(reach.to).grip)
            else {
                return Vec::new();
            };
            let is_played = hand.station == of.id && self.players.iter().any(|other| other.id == closed.station);
            let operations = (0..of.operations.len()).filter(|_| is_played && closed.station != of.id);
            let transfer = |operation| {
                let what = of.transfer(operation, reach, &hand)?;
                Some(ClampTransfer { player, operation, what, closed })
            };
            operations.filter_map(transfer).collect()
        };
        flow.reaches.iter().flat_map(at_clamp).collect()
    }

    /// Whether each input is understood that the transfer's own task has waited for by then, and that the other ones wait for.
    fn is_understood(&self, transfer: &ClampTransfer) -> bool {
        let waits = |(at, player): (usize, &Player<'_, '_>)| {
            let own = if at == transfer.player { transfer.operation + 1 } else { player.operations.len() };
            let results = player.operations[..own].iter().filter_map(|operation| operation.result.as_ref());
            let waits = player.operations[..own].iter().flat_map(|operation| &operation.waits);
            waits.chain(results.map(|result| &result.input)).all(|input| self.is_known(player, *input))
        };
        self.players.iter().enumerate().all(waits)
    }

    /// Whether what an input shows follows from where the stations of the activity stand, or has nothing to do with them.
    fn is_known(&self, player: &Player<'_, '_>, input: InputId) -> bool {
        let is_played = |stand: &Stand| self.players.iter().any(|player| player.id == stand.station);
        let is_known = |sign: &Sign| match sign {
            Sign::Stands(_) => true,
            Sign::Part(holder) => match self.line.handling.holder(*holder).grip {
                Grip::Hand(_) => true,
                Grip::Clamp(closed) => !is_played(&closed),
                Grip::Loose => false,
            },
        };
        let mut sensors = self.sensors(player.id, input).peekable();
        sensors.peek().is_some() && sensors.all(|sensor| sensor.when.iter().all(is_known))
    }

    fn is_unordered(&self, transfer: &ClampTransfer, states: &[State]) -> bool {
        let starts = |state: &&State| {
            state[transfer.player] == transfer.operation * 2
                && self.may_start(state, transfer.player, None, SwitchEdge::Sharp)
        };
        let clamp = |state: &State| {
            let (player, progress) =
                self.players.iter().zip(state).find(|(player, _)| player.id == transfer.closed.station)?;
            player.places[*progress][transfer.closed.axis.index()].map(|at| same_place(at, transfer.closed.at))
        };
        let stands: Vec<Option<bool>> = states.iter().filter(starts).map(clamp).collect();
        let always = |is_closed: bool| stands.iter().all(|stand| *stand == Some(is_closed));
        match transfer.what {
            PartTransfer::LetsGo => !always(true) && !always(false),
            PartTransfer::CarriesAway => !always(false),
        }
    }

    fn unordered(&self, transfer: &ClampTransfer) -> Option<Problem> {
        let player = &self.players[transfer.player];
        let operation = player.operations[transfer.operation];
        let other = self.line.station(transfer.closed.station);
        let clamp = format!("`{}.{}`", other.name, other.axes[transfer.closed.axis.index()].name);
        let (does, needed) = match transfer.what {
            PartTransfer::LetsGo => ("lets a part go", "closed"),
            PartTransfer::CarriesAway => ("carries a part away", "open"),
        };
        let waited: Vec<String> = operation.waits.iter().map(|input| self.input_text(player, *input)).collect();
        let waits = if waited.is_empty() { String::new() } else { format!("; it waits for {}", waited.join(" and ")) };
        let (name, station) = (&operation.name, &player.station.name);
        let message = format!(
            "`{name}` of `{station}` {does} wherever {clamp} stands: nothing makes sure that it is {needed}{waits}"
        );
        let hint = match self.shows(player, transfer) {
            Some(input) => format!(
                "let it wait for {}: `waits = [\"{}\"]` in the line's description",
                self.input_text(player, input),
                player.station.inputs[input.index()]
            ),
            None => format!(
                "give `{station}` an input that is on while {clamp} is {needed}, with a `[[sensor]]` that says so, and let it wait for that"
            ),
        };
        let task = player.order.raw.task.as_ref()?;
        Some(Problem::warning(task.at.clone(), message).label("nothing orders this").hint(hint))
    }

    pub(super) fn input_text(&self, player: &Player<'_, '_>, input: InputId) -> String {
        format!("`{}`, which is on while {}", player.station.inputs[input.index()], self.shown(player.id, input))
    }

    /// An input of the station that shows the clamp as it has to be, and nothing else.
    fn shows(&self, player: &Player<'_, '_>, transfer: &ClampTransfer) -> Option<InputId> {
        let is_closed = transfer.what == PartTransfer::LetsGo;
        let is_so = |stand: &Stand| {
            axis_of(stand) == axis_of(&transfer.closed) && same_place(stand.at, transfer.closed.at) == is_closed
        };
        let shows = |sensor: &&Sensor| {
            sensor.station == player.id
                && stands_of(sensor).count() == sensor.when.len()
                && stands_of(sensor).all(|of| is_so(&of))
        };
        self.line.handling.sensors.iter().find(shows).map(|sensor| sensor.input)
    }
}
