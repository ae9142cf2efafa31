//! Recovery rules of a description, by the modes and resources of the table.

use std::collections::BTreeMap;
use std::sync::Arc;

use linewright_cell::net::{CellNet, PlaceMeaning, ResourcePosition, Supply};
use linewright_cell::{Activity, ActivityId, Cell, ExceptionRule, LeftOut, Resource, ResourceId as Of, Role, StopOf};
use linewright_line::{ButtonId, Line, OperationModule, RestId, Station, StationId};
use linewright_nets::coloured::Unfolding;

use crate::exception::{
    AwaitedInput, FailureMatch, ModeHandling, PermittedAnswer, RecoveryDecision, RecoveryPolicy, RecoveryRule,
    ResourcePolicy, RestTask, StationRests, Strategy, Whereabouts,
};
use crate::{CellId, CellTable, ModeId, PlayedOrderTemplate, ResourceId};

/// Recovery policy of a cell.
pub(super) fn handling(
    cell: &Cell,
    net: &CellNet,
    long: &Unfolding,
    table: &CellTable,
    (line, stations): (Option<&Line>, &[StationId]),
    supply: Supply<'_>,
) -> RecoveryPolicy {
    let made = BuiltPolicy::new(cell, net, long, table, supply);
    let begins = |mode: ModeId| {
        let begin = |order: &PlayedOrderTemplate| {
            let station = line?.station(order.station);
            Some((order.station, station.task(station.task_named(&order.task)?).from))
        };
        table.activity(mode).orders.iter().filter_map(begin).collect()
    };
    let resource = |id: Of| {
        let of = cell.resource(id);
        ResourcePolicy {
            name: of.name.as_str().into(),
            station: of.controller.map(|controller| stations[controller.index()]),
            is_sensed: of.presence.is_some() && of.controller.is_some(),
            has: made.cells_of(Some(id), |meaning| matches!(meaning, PlaceMeaning::Held(..))).collect(),
            sees: made.cells_of(Some(id), |meaning| is_seen(of, meaning)).collect(),
            is_single: of.capacity == 1,
        }
    };
    RecoveryPolicy {
        resources: cell.resource_ids().map(resource).collect(),
        modes: table.modes().map(|mode| ModeHandling { begins: begins(mode), ..made.mode(mode) }).collect(),
        rules: cell.exceptions.iter().map(|of| rule(of, stations)).collect(),
        stations: stations.iter().zip(&cell.controllers).map(|(&id, name)| (id, name.as_str().into())).collect(),
        rests: line.into_iter().flat_map(|line| stations.iter().map(|&id| rests(line, id))).collect(),
        ..RecoveryPolicy::default()
    }
}

impl StationRests {
    /// Ways from one rest to another in hand mode: a task there, one that waits for nothing before one that may wait for ever; and the
    /// button that takes back a task that has led away from there, with that task.
    pub fn ways(&self, from: RestId, to: RestId) -> (Option<&RestTask>, Option<(&str, &str)>) {
        let there = self.tasks.iter().filter(|task| (task.from, task.to) == (from, to));
        let mut ended = self.tasks.iter().filter(|task| (task.from, task.to) == (to, from));
        (there.min_by_key(|task| task.waits), ended.find_map(|task| Some((task.back.as_deref()?, &*task.name))))
    }

    /// The button of these that texts name first.
    pub fn button(&self, from: RestId, to: RestId) -> Option<&str> {
        match self.ways(from, to) {
            (Some(task), None) => Some(&task.button),
            (Some(task), Some(_)) if !task.waits => Some(&task.button),
            (_, back) => back.map(|(button, _)| button),
        }
    }
}

/// The rests of a station, and its tasks as ways between them.
pub fn rests(line: &Line, id: StationId) -> StationRests {
    let station: &Station = line.station(id);
    let task = |of: linewright_line::TaskId| {
        let task = station.task(of);
        let forward = station.operations[station.first_of(of).index()].hand.forward();
        let back = station.operations[station.last_of(of).index()].hand.reverses_from_its_end();
        let goes_back = |button: &ButtonId| {
            let mut all = station.operations_of(of).map(|op| &station.operations[op.index()]);
            all.all(|op| op.hand.back() == Some(*button) && matches!(op.module, OperationModule::Reversible { .. }))
        };
        let awaited = station.operations_of(of).map(|op| &station.operations[op.index()]).flat_map(|of| {
            let waits = of.waits.iter().filter(|_| of.waits_code > 0).map(|&input| (of.waits_code, input));
            let all = waits.chain(of.result.map(|result| (result.code, result.input)));
            all.map(|(code, input)| AwaitedInput {
                code,
                bit: input.bit(),
                input: station.inputs[input.index()].as_str().into(),
                operation: of.name.as_str().into(),
            })
        });
        let back = back.filter(goes_back);
        let name = |button: ButtonId| Arc::from(line.buttons[usize::from(button.0)].as_str());
        let shared = [Some(forward), back].into_iter().flatten().flat_map(|button| {
            let others = line.station_ids().filter(|&of| of != id).map(|of| line.station(of));
            let others = others.filter(move |of| of.operations.iter().any(|op| is_moved(op, button)));
            others.map(move |of| (name(button), Arc::from(of.name.as_str())))
        });
        RestTask {
            shared: shared.collect(),
            awaited: awaited.collect(),
            name: task.name.as_str().into(),
            from: task.from,
            to: task.to,
            limit: task.limit,
            button: name(forward),
            back: back.map(name),
            waits: station.waits_for_inputs(of),
        }
    };
    StationRests {
        station: id,
        label: station.label().into(),
        names: station.rests.iter().map(|rest| rest.name.as_str().into()).collect(),
        tasks: station.task_ids().map(task).collect(),
    }
}

/// Whether a resource's sensor sees the parts of a place: in a row it looks at the end.
fn is_seen(of: &Resource, meaning: PlaceMeaning) -> bool {
    match meaning {
        PlaceMeaning::Held(_, ResourcePosition::Position(at)) => at == of.capacity,
        PlaceMeaning::Held(_, ResourcePosition::Stored | ResourcePosition::Loaded | ResourcePosition::Ready) => true,
        PlaceMeaning::Room(_)
        | PlaceMeaning::Free(_)
        | PlaceMeaning::Position(..)
        | PlaceMeaning::Top(_)
        | PlaceMeaning::Waiting
        | PlaceMeaning::Admission
        | PlaceMeaning::Busy { .. }
        | PlaceMeaning::Idle(_) => false,
    }
}

struct BuiltPolicy<'a> {
    cell: &'a Cell,
    net: &'a CellNet,
    long: &'a Unfolding,
    table: &'a CellTable,
    supply: Supply<'a>,
    /// Of each cell.
    meanings: Vec<PlaceMeaning>,
    /// The cells of each resource, and those of none, so that none are searched for among all.
    cells: BTreeMap<Option<Of>, Vec<CellId>>,
}

impl<'a> BuiltPolicy<'a> {
    fn new(
        cell: &'a Cell,
        net: &'a CellNet,
        long: &'a Unfolding,
        table: &'a CellTable,
        supply: Supply<'a>,
    ) -> BuiltPolicy<'a> {
        let meaning = |cell: CellId| net.meaning(long.cell(net.net(), linewright_nets::PlaceId(cell.0)).place);
        let meanings: Vec<PlaceMeaning> = table.cells().map(meaning).collect();
        let mut cells: BTreeMap<_, Vec<CellId>> = BTreeMap::new();
        for (at, meaning) in table.cells().zip(&meanings) {
            cells.entry(meaning.resource()).or_default().push(at);
        }
        BuiltPolicy { cell, net, long, table, supply, meanings, cells }
    }

    fn meaning(&self, cell: CellId) -> PlaceMeaning {
        self.meanings[cell.index()]
    }

    fn cells_of(&self, of: Option<Of>, is: impl Fn(PlaceMeaning) -> bool) -> impl Iterator<Item = CellId> {
        let all = self.cells.get(&of).into_iter().flatten().copied();
        all.filter(move |&cell| is(self.meaning(cell)))
    }

    fn mode(&self, mode: ModeId) -> ModeHandling {
        let transition = self.long.mode(linewright_nets::TransitionId(mode.0));
        let Some((activity, of)) = self.net.move_of(self.cell, transition) else { return ModeHandling::default() };
        let id = |role| activity.used(role).and_then(|part| part.of).map(number);
        let worker = id(Role::Worker);
        let rules = self.cell.activity_named(&activity.name).map(|id| self.rules(id)).unwrap_or_default();
        let part_type = self.cell.stages[of.from.index()].part_type;
        let nominal = self.cell.nominal_limit(of);
        ModeHandling {
            activity: activity.name.as_str().into(),
            part_type: self.cell.part_types[part_type.index()].name.as_str().into(),
            from: worker.or_else(|| id(Role::Source)),
            to: worker.or_else(|| id(Role::Target)),
            carrier: id(Role::Carrier),
            rules,
            begins: Vec::new(),
            nominal: activity.orders.iter().map(|order| nominal.filter(|_| order.limit.is_none())).collect(),
            gone: self.gone(mode, activity, of.from),
        }
    }

    fn rules(&self, id: ActivityId) -> Vec<usize> {
        let all = self.cell.exceptions.iter().enumerate();
        all.filter(|(_, rule)| rule.activities.contains(&id)).map(|(at, _)| at).collect()
    }

    /// Tokens left when the part of a mode is no more: the place where it was or was to go has room again, and another
    /// may come. None where parts that leave come again by themselves: they could not.
    fn gone(&self, mode: ModeId, activity: &Activity, stage: linewright_cell::StageId) -> Option<Vec<(CellId, u32)>> {
        let source = activity.used(Role::Source).and_then(|part| part.of);
        let is_part = |cell: CellId| matches!(self.table.kind(cell), crate::CellKind::Parts(_));
        let is_sources = |cell: CellId| source.is_some() && self.meaning(cell).resource() == source;
        let mut gone = BTreeMap::new();
        // The state of a stack is what it is without its part; what was reserved to take it is free.
        let taken = self.table.takes(mode).iter().filter(|&&(cell, _)| !is_part(cell) && !is_sources(cell));
        let given = self.table.gives(mode).iter().filter(|&&(cell, _)| !is_part(cell) && is_sources(cell));
        gone.extend(taken.chain(given).copied());
        let worker = activity.used(Role::Worker).and_then(|part| part.of);
        let room = self.cells_of(worker, |meaning| matches!(meaning, PlaceMeaning::Room(_)));
        gone.extend(room.map(|cell| (cell, 1)));
        gone.extend(self.cells_of(None, |meaning| meaning == PlaceMeaning::Admission).map(|cell| (cell, 1)));
        match self.supply {
            Supply::Open => (),
            Supply::Batch(_) => {
                let part = &self.cell.part_types[self.cell.stages[stage.index()].part_type.index()];
                let new = self.cell.stages[part.new_stage().index()].name.as_str();
                let waiting = self.cells_of(None, |meaning| meaning == PlaceMeaning::Waiting);
                let named = format!("<{new}>");
                gone.extend(waiting.filter(|&cell| self.table.cell_name(cell).ends_with(&named)).map(|cell| (cell, 1)));
            }
            Supply::Closed(_) => return None,
        }
        Some(gone.into_iter().collect())
    }
}

/// Whether a hand-mode button moves an operation, on or back.
fn is_moved(operation: &linewright_line::Operation, button: ButtonId) -> bool {
    operation.hand.forward() == button || operation.hand.back() == Some(button)
}

fn number(id: Of) -> ResourceId {
    // Descriptions are bounded far below 32 bits.
    ResourceId(id.index() as u32)
}

fn rule(of: &ExceptionRule, stations: &[StationId]) -> RecoveryRule {
    let named = |stop: &StopOf| match *stop {
        StopOf::Activity => None,
        StopOf::Station(controller) => Some(stations[controller.index()]),
    };
    RecoveryRule {
        code: if of.code == "*" { FailureMatch::Any } else { FailureMatch::Word(of.code.as_str().into()) },
        tell: of.tell.as_str().into(),
        retries: of.retries,
        is_automatic: of.automatic,
        stops: of.emergency_stop.iter().filter_map(named).collect(),
        stops_activity: of.emergency_stop.contains(&StopOf::Activity),
        answers: of.answers.iter().map(answer).collect(),
    }
}

fn answer(of: &linewright_cell::AlarmAnswer) -> PermittedAnswer {
    let then = match of.then {
        linewright_cell::Strategy::Redo => Strategy::Redo,
        linewright_cell::Strategy::Backward => Strategy::Backward,
        linewright_cell::Strategy::Forward => Strategy::Forward,
    };
    let (mut down, mut down_as) = (Vec::new(), Vec::new());
    for left_out in &of.down {
        match *left_out {
            LeftOut::Resource(id) => down.push(number(id)),
            LeftOut::As(part) => down_as.push(whereabouts(part)),
        }
    }
    PermittedAnswer {
        ruling: RecoveryDecision { word: of.word.clone(), part: whereabouts(of.part), then },
        down,
        down_as,
    }
}

fn whereabouts(of: linewright_cell::Whereabouts) -> Whereabouts {
    match of {
        linewright_cell::Whereabouts::From => Whereabouts::From,
        linewright_cell::Whereabouts::To => Whereabouts::To,
        linewright_cell::Whereabouts::Carrier => Whereabouts::Carrier,
        linewright_cell::Whereabouts::Gone => Whereabouts::Gone,
    }
}
