//! Clamps that close or open wherever the part is: one that closes before a part has been brought, or opens while nothing else may
//! hold what it has. The counterpart of what a hand does at a clamp, in the module of transfers.
//!
//! Decided by what the task of the clamp has waited for by then. An input that sees a part, or whose sensor is not described, or that
//! sees a station without an order in the activity, may make sure of it, and nothing is reported.

use linewright_line::{Grip, Holder, InputId, Reach, Sensor, Sign, Stand};
use linewright_text::Problem;

use super::places::owners;
use super::transfers::PartTransfer;
use super::{Handshake, Player, State, SwitchEdge};
use crate::Role;
use crate::parse::draft::{DraftActivity, DraftCell};

/// What an operation does with a clamp of its station.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ClampStep {
    Closes,
    Opens,
}

/// An operation that closes or opens a clamp.
struct ClampAction<'l> {
    player: usize,
    operation: usize,
    step: ClampStep,
    clamp: &'l Holder,
}

impl Handshake<'_, '_> {
    /// A warning for each operation that closes a clamp for which the activity brings a part, or opens one from which it takes one, and
    /// may start whether the part is there, or is held by a hand, or not.
    pub(super) fn unordered_clamps(
        &self,
        draft: &DraftCell<'_>,
        activity: &DraftActivity<'_>,
        left: &mut usize,
    ) -> Vec<Problem> {
        let Some(states) = self.states(None, SwitchEdge::Sharp, left) else { return Vec::new() };
        let players = 0..self.players.len();
        let actions = players.flat_map(|player| self.clamp_actions(draft, activity, player));
        actions.filter(|action| self.is_free(action, &states)).filter_map(|action| self.free_clamp(&action)).collect()
    }

    /// The first operation of a task that closes the clamp to which the activity brings a part, or opens the one from which it takes it.
    fn clamp_actions<'l>(
        &'l self,
        draft: &DraftCell<'_>,
        activity: &DraftActivity<'_>,
        player: usize,
    ) -> Vec<ClampAction<'l>> {
        let of = &self.players[player];
        let action = |clamp: &'l Holder| {
            let Grip::Clamp(closed) = clamp.grip else { return None };
            let owners = owners(draft, clamp);
            let is_used = |role: Role| {
                activity.used(role).any(|part| part.value.of.is_some_and(|resource| owners.contains(&resource)))
            };
            let step = match (is_used(Role::Target), is_used(Role::Source)) {
                (true, false) => ClampStep::Closes,
                (false, true) => ClampStep::Opens,
                _ => return None,
            };
            let is_closed = |progress: usize| of.stands(progress, &closed);
            let begins = |operation: &usize| match step {
                ClampStep::Closes => !is_closed(operation * 2) && is_closed(operation * 2 + 2),
                ClampStep::Opens => is_closed(operation * 2) && !is_closed(operation * 2 + 2),
            };
            let operation = (0..of.operations.len()).find(begins).filter(|_| closed.station == of.id)?;
            Some(ClampAction { player, operation, step, clamp })
        };
        self.line.handling.holders.iter().filter_map(action).collect()
    }

    /// Whether nothing that its task has waited for by then makes sure of the part.
    fn is_free(&self, action: &ClampAction<'_>, states: &[State]) -> bool {
        let player = &self.players[action.player];
        let inputs: Vec<InputId> =
            (0..=action.operation).flat_map(|of| self.awaited(action.player, of, None)).collect();
        if !inputs.iter().all(|input| self.shows_axes_of_players(player, *input)) {
            return false;
        }
        let sees_another = inputs.iter().any(|input| self.sees_others(player, *input));
        let hands =
            || self.players.iter().filter(|other| other.id != player.id).any(|of| self.reaches(of, action.clamp));
        match action.step {
            // No hand of the activity brings it: only the clamp's own inputs count.
            ClampStep::Closes if !hands() => !inputs.iter().any(|input| self.sees_a_part(player, *input)),
            ClampStep::Opens if !hands() => false,
            // Where the others' inputs are not understood, their order among themselves is not known.
            _ if sees_another && !self.is_understood_by_all() => false,
            step => {
                let starts = |state: &&State| {
                    state[action.player] == action.operation * 2
                        && self.may_start(state, action.player, None, SwitchEdge::Sharp)
                };
                let held: Vec<bool> =
                    states.iter().filter(starts).map(|state| self.is_brought(action, state)).collect();
                match step {
                    ClampStep::Closes => held.contains(&false),
                    ClampStep::Opens => held.contains(&false) && held.contains(&true),
                }
            }
        }
    }

    /// Whether every input that an order waits for is described, and sees no part in a nest.
    fn is_understood_by_all(&self) -> bool {
        let mut each =
            self.players.iter().enumerate().flat_map(|(at, of)| (0..of.operations.len()).map(move |op| (at, op)));
        each.all(|(at, op)| {
            self.awaited(at, op, None).all(|input| self.shows_axes_of_players(&self.players[at], input))
        })
    }

    /// Whether each sensor of an input is described, and sees axes, or a closed hand, of the stations of the activity.
    fn shows_axes_of_players(&self, player: &Player<'_, '_>, input: InputId) -> bool {
        let is_limit = player.operations.iter().any(|operation| operation.normal.complete == input);
        let is_known = |sign: &Sign| {
            let stand = self.stand_of(sign);
            stand.is_some_and(|stand| self.players.iter().any(|other| other.id == stand.station))
        };
        let mut sensors = self.sensors(player.id, input).peekable();
        is_limit || (sensors.peek().is_some() && sensors.all(|sensor| sensor.when.iter().all(is_known)))
    }

    fn sees_a_part(&self, player: &Player<'_, '_>, input: InputId) -> bool {
        self.sensors(player.id, input).flat_map(|sensor| &sensor.when).any(|sign| matches!(sign, Sign::Part(_)))
    }

    fn sees_others(&self, player: &Player<'_, '_>, input: InputId) -> bool {
        let stands =
            |sensor: &Sensor| sensor.when.iter().filter_map(|sign| self.stand_of(sign)).collect::<Vec<Stand>>();
        self.sensors(player.id, input).flat_map(stands).any(|stand| stand.station != player.id)
    }

    fn reaches(&self, player: &Player<'_, '_>, clamp: &Holder) -> bool {
        self.reaches_of(player, clamp).next().is_some()
    }

    fn reaches_of<'s>(
        &'s self,
        player: &'s Player<'_, '_>,
        clamp: &'s Holder,
    ) -> impl Iterator<Item = (&'s Reach, Stand)> + 's {
        let handling = &self.line.handling;
        handling.reaches.iter().filter_map(move |reach| match handling.holder(reach.hand).grip {
            Grip::Hand(hand) if hand.station == player.id && handling.holder(reach.to).name == clamp.name => {
                Some((reach, hand))
            }
            _ => None,
        })
    }

    /// Whether a hand holds the part at the clamp; of one that is to be closed, also whether a hand has put it there.
    fn is_brought(&self, action: &ClampAction<'_>, state: &State) -> bool {
        self.players.iter().zip(state).enumerate().any(|(at, (player, &progress))| {
            at != action.player
                && self.reaches_of(player, action.clamp).any(|(reach, hand)| {
                    let holds = player.is_at(progress, reach) && player.stands(progress, &hand);
                    let puts = |of: usize| player.transfer(of, reach, &hand) == Some(PartTransfer::LetsGo);
                    let has_put = (0..player.operations.len()).any(|of| of * 2 <= progress && puts(of));
                    holds || (has_put && action.step == ClampStep::Closes)
                })
        })
    }

    fn free_clamp(&self, action: &ClampAction<'_>) -> Option<Problem> {
        let player = &self.players[action.player];
        let (name, station) = (&player.operations[action.operation].name, &player.station.name);
        let clamp = &action.clamp.name;
        let awaited: Vec<String> =
            self.awaited(action.player, action.operation, None).map(|input| self.input_text(player, input)).collect();
        let waits =
            if awaited.is_empty() { String::new() } else { format!("; it waits for {}", awaited.join(" and ")) };
        let (does, unsure) = match action.step {
            ClampStep::Closes => {
                ("closes", "whether a part is there or not: nothing makes sure that it has been brought")
            }
            ClampStep::Opens => ("opens", "whether a hand holds the part or not: nothing makes sure of it"),
        };
        let message = format!("`{name}` of `{station}` {does} `{clamp}` {unsure}{waits}");
        let hint = match self.part_input(player, action) {
            Some(input) => format!(
                "let it wait for {}: `waits = [\"{}\"]` in the line's description",
                self.input_text(player, input),
                player.station.inputs[input.index()]
            ),
            None => {
                let seen = match action.step {
                    ClampStep::Closes => format!("a part is in `{clamp}`, or is held there by a hand"),
                    ClampStep::Opens => "the hand holds the part there".to_owned(),
                };
                format!(
                    "give `{station}` an input that is on while {seen}, with a `[[sensor]]` that says so, and let it wait for that"
                )
            }
        };
        let task = player.order.raw.task.as_ref()?;
        Some(Problem::warning(task.at.clone(), message).label("waits for no part").hint(hint))
    }

    /// An input of the station that sees a hand hold a part at the clamp; else one that sees a part in the clamp, which is closed then.
    fn part_input(&self, player: &Player<'_, '_>, action: &ClampAction<'_>) -> Option<InputId> {
        let sees = |sensor: &Sensor, is_it: &dyn Fn(&Holder, &Grip) -> bool| {
            sensor.when.iter().any(|sign| match sign {
                Sign::Part(holder) => {
                    let holder = self.line.handling.holder(*holder);
                    is_it(holder, &holder.grip)
                }
                Sign::Stands(_) => false,
            })
        };
        let reached = |stand: &Stand| {
            let others = self.players.iter().filter(|other| other.id != player.id);
            others.flat_map(|of| self.reaches_of(of, action.clamp)).any(|(reach, _)| reach.when.contains(stand))
        };
        let in_hand = |sensor: &Sensor| {
            let at_clamp = sensor.when.iter().any(|sign| matches!(sign, Sign::Stands(stand) if reached(stand)));
            at_clamp && sees(sensor, &|_, grip| matches!(grip, Grip::Hand(_)))
        };
        let in_clamp = |sensor: &Sensor| {
            action.step == ClampStep::Closes && sees(sensor, &|holder, _| holder.name == action.clamp.name)
        };
        let own = || self.line.handling.sensors.iter().filter(|sensor| sensor.station == player.id);
        let found = own().find(|sensor| in_hand(sensor)).or_else(|| own().find(|sensor| in_clamp(sensor)));
        found.map(|sensor| sensor.input)
    }
}
