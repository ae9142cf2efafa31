//! Where a task closes and opens a hand, beside the resources of its activity.
//!
//! An activity moves a part from one resource to another one, and the cell counts it there. At which nests a task really closes and opens
//! a hand follows from the line's description: from the positions to which its operations bring the axes, and the `[[station.reach]]` of the
//! hand at these. Where the two differ, the part stays behind, falls down, or lies at another resource than the one at which the cell counts
//! it; a sensor shows that only where the description has one there.
//!
//! A nest belongs to the resource with its name, or to those of its station. Nests of no resource are not judged, and neither is a hand
//! whose reach depends on where another station stands.

use linewright_line::{Grip, Holder, HolderId, Line, OutputId, Parameter, Reach};
use linewright_text::Problem;

use super::{Handshake, Player};
use crate::parse::draft::{DraftActivity, DraftCell, DraftResource};
use crate::{ParameterSource, Prototype, ResourceId, Role};

/// What a hand does in an operation.
#[derive(Clone, Copy, PartialEq, Eq)]
enum HandStep {
    Takes,
    LetsGo,
}

/// An operation that closes or opens a hand.
struct HandAction<'l> {
    operation: usize,
    step: HandStep,
    /// The nests that it may reach then.
    reaches: Vec<&'l Reach>,
}

impl Player<'_, '_> {
    /// Where a hand of this station closes at a nest, and opens with what it has taken, in the order of the task. Where it closes
    /// without a nest counts only if it takes nothing else.
    fn hand_actions<'l>(&self, line: &'l Line, hand: HolderId) -> Vec<HandAction<'l>> {
        let Grip::Hand(closed) = line.handling.holder(hand).grip else { return Vec::new() };
        let of_hand = || line.handling.reaches.iter().filter(move |reach| reach.hand == hand);
        let is_own = |reach: &Reach| reach.when.iter().all(|stand| stand.station == self.id);
        if closed.station != self.id || of_hand().next().is_none() || !of_hand().all(is_own) {
            return Vec::new();
        }
        let mut has_taken = false;
        let action = |operation: usize| {
            let (before, after) = (operation * 2, operation * 2 + 2);
            let reaches: Vec<&Reach> = of_hand().filter(|reach| self.is_at(before, reach)).collect();
            let step = match (self.stands(before, &closed), self.stands(after, &closed)) {
                (false, true) => HandStep::Takes,
                (true, false) if has_taken => HandStep::LetsGo,
                _ => return None,
            };
            has_taken = step == HandStep::Takes && !reaches.is_empty();
            Some(HandAction { operation, step, reaches })
        };
        let mut actions: Vec<HandAction<'_>> = (0..self.operations.len()).filter_map(action).collect();
        if actions.iter().any(|action| !action.reaches.is_empty()) {
            actions.retain(|action| action.step == HandStep::LetsGo || !action.reaches.is_empty());
        }
        actions
    }
}

impl Handshake<'_, '_> {
    /// A warning for each order that takes a part from somewhere else than the activity, or brings it somewhere else.
    pub(super) fn misplaced(&self, draft: &DraftCell<'_>, activity: &DraftActivity<'_>) -> Vec<Problem> {
        let hands = || (0..self.line.handling.holders.len()).map(HolderId::at);
        let of_player = |player: &Player<'_, '_>| {
            hands().find_map(|hand| {
                let actions = player.hand_actions(self.line, hand);
                let wrong = actions.iter().find_map(|action| self.wrong(draft, activity, player, action));
                wrong.or_else(|| actions.iter().find_map(|action| self.other_position(draft, activity, player, action)))
            })
        };
        self.players.iter().filter_map(of_player).collect()
    }

    fn wrong(
        &self,
        draft: &DraftCell<'_>,
        activity: &DraftActivity<'_>,
        player: &Player<'_, '_>,
        action: &HandAction<'_>,
    ) -> Option<Problem> {
        let nests = action.reaches.iter().map(|reach| self.line.handling.holder(reach.to));
        let owners: Vec<Vec<ResourceId>> = nests.clone().map(|nest| owners(draft, nest)).collect();
        let (role, opposite) = match action.step {
            HandStep::Takes => (Role::Source, Role::Target),
            HandStep::LetsGo => (Role::Target, Role::Source),
        };
        let is_used = |of: &ResourceId, but: Role| {
            activity.uses.iter().any(|part| part.value.of == Some(*of) && part.value.action.role() != but)
        };
        let fits = |of: &Vec<ResourceId>| of.is_empty() || of.iter().any(|of| is_used(of, opposite));
        if !owners.is_empty() && owners.iter().any(fits) {
            return None;
        }
        let places: Vec<String> = nests.map(|nest| format!("`{}`", nest.name)).collect();
        let (operation, station) = (&player.operations[action.operation].name, &player.station.name);
        let does = match (action.step, places.is_empty()) {
            (HandStep::Takes, false) => format!("takes a part from {}", places.join(" or ")),
            (HandStep::Takes, true) => "closes a hand where it reaches nothing".to_owned(),
            (HandStep::LetsGo, false) => format!("lets a part go at {}", places.join(" or ")),
            (HandStep::LetsGo, true) => "lets a part go where the hand reaches nothing".to_owned(),
        };
        let named = activity.used(role).map(|part| draft.holder(part.value.of)).next()?;
        let way = match action.step {
            HandStep::Takes => "from",
            HandStep::LetsGo => "to",
        };
        let message =
            format!("`{operation}` of `{station}` {does}, but `{}` moves the part {way} `{named}`", activity.name);
        let task = player.order.raw.task.as_ref()?;
        let hint = format!(
            "the cell would count the part at `{named}`: look at where the operations of task `{}` bring the hand, at its \
             `[[station.reach]]` in the line's description, and at the actions here",
            task.value
        );
        Some(Problem::warning(task.at.clone(), message).label("at another place").hint(hint))
    }

    /// A position that the hand reaches, and that is not the one of the part: the same outputs in another order, or always the same number.
    fn other_position(
        &self,
        draft: &DraftCell<'_>,
        activity: &DraftActivity<'_>,
        player: &Player<'_, '_>,
        action: &HandAction<'_>,
    ) -> Option<Problem> {
        let [reach] = action.reaches.as_slice() else { return None };
        let task = player.station.task(player.station.task_named(&player.order.raw.task.as_ref()?.value)?);
        let nest = self.line.handling.holder(reach.to);
        let carries = |parameter: &&Parameter| {
            !reach.position.is_empty() && parameter.bits.iter().all(|bit| reach.position.contains(bit))
        };
        let parameter = task.parameters.iter().find(carries)?;
        let (name, station) = (&parameter.name, &player.station.name);
        if parameter.bits != reach.position {
            let named = |bits: &[OutputId]| {
                bits.iter().map(|bit| player.station.outputs[bit.index()].as_str()).collect::<Vec<_>>().join(", ")
            };
            let message = format!(
                "the position at `{}` is read from {}, and `{name}` stands on {}, lowest bit first",
                nest.name,
                named(&reach.position),
                named(&parameter.bits)
            );
            let hint = format!(
                "`position` of `{station}`'s `[[station.reach]]` and the task's `parameters` list the same outputs in one order"
            );
            return Some(
                Problem::warning(player.order.raw.task.as_ref()?.at.clone(), message)
                    .label("another position")
                    .hint(hint),
            );
        }
        let (_, source) = player.order.parameters.iter().find(|(of, _)| of == name)?;
        let owners = owners(draft, nest);
        let store = activity.uses.iter().filter_map(|part| part.value.of).find(|of| owners.contains(of))?;
        let is_constant = matches!(source, ParameterSource::Number(_)) && nest.places > 1;
        if !is_constant || !draft.resource(store).prototype.is_some_and(Prototype::has_positions) {
            return None;
        }
        let (_, value) = player.order.raw.parameters.iter().find(|(of, _)| of.value == *name)?;
        let message = format!("`{name}` is always the same position of `{}`", draft.resource(store).name);
        let hint =
            format!("`{name} = \"{}.position\"`: the one that the part has, or will have", draft.resource(store).name);
        Some(Problem::warning(value.at.clone(), message).label("of each part").hint(hint))
    }
}

/// The resources that a nest may belong to: the one with its name, else those of its station.
pub(super) fn owners(draft: &DraftCell<'_>, nest: &Holder) -> Vec<ResourceId> {
    let all = || draft.resources.iter().enumerate().map(|(id, resource)| (ResourceId::at(id), resource));
    let named: Vec<ResourceId> = all().filter(|(_, resource)| resource.name == nest.name).map(|(id, _)| id).collect();
    if !named.is_empty() {
        return named;
    }
    let Some((station, _)) = nest.name.split_once('.') else { return Vec::new() };
    let is_of_station =
        |resource: &DraftResource<'_>| resource.raw.station.as_ref().is_some_and(|of| of.value == station);
    all().filter(|(_, resource)| is_of_station(resource)).map(|(id, _)| id).collect()
}
