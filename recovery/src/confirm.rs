//! Texts and commands of the confirmation of a station's position by a person (`linewright rejoin`): how the station stands in each place
//! that its switches permit, and the command for it.

use linewright_line::net::{Block, MotionStage, StationPlace};
use linewright_line::{AxisId, Line, OpId, Parameter, StationId};
use linewright_station_logic::RejoinAt;

use crate::image;
use crate::step::{ConfirmedNumber, RejoinChoice};

/// What to look at, and what is confirmed by it.
pub(crate) fn text(line: &Line, station: StationId, (at, or): (&RejoinChoice, &[RejoinChoice])) -> String {
    let all = || std::iter::once(at).chain(or);
    let described = line.station(station);
    let is_index =
        |choice: &&RejoinChoice| matches!(choice.at, RejoinAt::Within(op) if described.index_of(op).is_some());
    let within = |choice: &RejoinChoice| match choice.at {
        RejoinAt::Within(op) => Some(op),
        RejoinAt::Measured | RejoinAt::Rest(_) => None,
    };
    let confirm = match all().find(is_index).and_then(within).filter(|_| !or.is_empty()) {
        Some(index) => index_text(line, station, index, all().filter(|of| !is_index(of)).filter_map(within)),
        None if or.is_empty() => {
            let moves_unseen = |place: &StationPlace| described.index_of(place.op).is_some();
            let unseen = match at.at == RejoinAt::Measured && at.places.iter().any(moves_unseen) {
                true => ". Whether it has moved on no switch says: see whether parts are passed over by it",
                false => "",
            };
            let named = within(at).map(|op| format!(" --within `{}`", line.operation((station, op)).name));
            let (stands, named) = (stands_text(line, station, at), named.unwrap_or_default());
            format!("look, and if it stands so ({stands}): rejoin{named}{unseen}")
        }
        None => {
            let ops = all().filter_map(within).map(|op| line.operation((station, op)).name.as_str());
            let ops: Vec<String> = ops.map(|name| format!("`{name}`")).collect();
            let (first, all) = (ops.first().map_or("", String::as_str), ops.join(" or "));
            format!(
                "look where it stands, then rejoin --within {all}; the steps below are for {first}: where it looks alike in several, that one"
            )
        }
    };
    format!("{}: {confirm}{}", described.name, numbers_text(all()))
}

/// How a person tells whether an index is done, of which the switch does not say it.
fn index_text(line: &Line, station: StationId, index: OpId, others: impl Iterator<Item = OpId>) -> String {
    let op = |op: OpId| format!("`{}`", line.operation((station, op)).name);
    let axis = &line.station(station).axes[line.operation((station, index)).motion.axis.index()].name;
    let others: Vec<String> = others.map(op).collect();
    let (index, others) = (op(index), others.join(" or "));
    format!(
        "look at `{axis}`, then rejoin. Has it moved on to the next place: --within {index}; does it stand where it began: \
         --within {others}. Auto goes on with the operation after that: see whether parts are passed over by it"
    )
}

/// An operation with how far it is, e.g. `decel done`.
pub(crate) fn place_text(line: &Line, station: StationId, place: StationPlace) -> String {
    let name = &line.operation((station, place.op)).name;
    match place.number() {
        1 => format!("{name} under way"),
        2 => format!("{name} incomplete"),
        3 => format!("{name} done"),
        4 => format!("undoing {name}"),
        5 => format!("undoing {name} incomplete"),
        _ => format!("{name} undone"),
    }
}

/// How a station stands in a place that may be confirmed: each operation that is marked then, where each axis stands, and its switches that
/// are on, e.g. `decel done: conveyor at 120, LS_decel on; gate between 0 and 40, no switch on`; then what the task was for.
pub(crate) fn stands_text(line: &Line, id: StationId, choice: &RejoinChoice) -> String {
    let station = line.station(id);
    let axis_text = |axis: AxisId, at: Option<String>| {
        let on = choice.on & image::switches_of(station, axis);
        let names = station.inputs.iter().enumerate().filter(|&(input, _)| on & (1 << input) != 0);
        let names: Vec<&str> = names.map(|(_, name)| name.as_str()).collect();
        let name = &station.axes[axis.index()].name;
        match (at, names.is_empty()) {
            // An endless axis turns by its way: where it stands, its switch tells alone.
            (None, false) => format!("{name} at {}", names.join(" and ")),
            (None, true) => format!("{name} at no switch"),
            (Some(at), false) => format!("{name} {at}, {} on", names.join(" and ")),
            (Some(at), true) => format!("{name} {at}, no switch on"),
        }
    };
    let marked = |place: &StationPlace| {
        let way = station.operations[place.op.index()].motion;
        let (from, to) = if place.block == Block::Recovery { (way.to, way.from) } else { (way.from, way.to) };
        let at = match place.stage {
            _ if station.index_of(place.op).is_some() => None,
            MotionStage::Completed => Some(format!("at {to}")),
            MotionStage::Operating | MotionStage::Incomplete if from == to => Some(format!("at {to}")),
            MotionStage::Operating | MotionStage::Incomplete => Some(format!("between {from} and {to}")),
        };
        format!("{}: {}", place_text(line, id, *place), axis_text(way.axis, at))
    };
    let mut text = choice.places.iter().map(marked).collect::<Vec<_>>().join(" and ");
    if let Some(first) = choice.places.first() {
        let is_marked = |axis: usize| {
            choice.places.iter().any(|place| station.operations[place.op.index()].motion.axis.index() == axis)
        };
        // Where they were before the step, they are after it.
        let before = station.positions_before_steps().swap_remove(station.step_of(first.op));
        let others = before.into_iter().enumerate().filter(|&(axis, _)| !is_marked(axis));
        for (axis, at) in others.filter(|&(axis, _)| station.axes[axis].index.is_none()) {
            text = format!("{text}; {}", axis_text(AxisId::at(axis), Some(format!("at {at}"))));
        }
    }
    match &choice.activity {
        Some(activity) => format!("{text}; it had an order of this task, for {activity}"),
        None => text,
    }
}

/// The numbers that are confirmed with a place within a task: those of its order, and those that are lost with the journal.
fn numbers_text<'c>(choices: impl Iterator<Item = &'c RejoinChoice> + Clone) -> String {
    let mut lost: Vec<&Parameter> = Vec::new();
    let unknown = choices.clone().flat_map(|choice| &choice.numbers).filter(|of| of.known.is_none());
    for ConfirmedNumber { parameter, .. } in unknown {
        if !lost.iter().any(|known| known.name == parameter.name) {
            lost.push(parameter);
        }
    }
    let with: Vec<String> = lost.iter().map(|of| format!("--with {}=N (0 to {})", of.name, of.most())).collect();
    let names: Vec<String> = lost.iter().map(|of| format!("`{}`", of.name)).collect();
    let is_one = choices.clone().count() == 1;
    let ordered = choices.clone().find_map(|choice| {
        let activity = choice.activity.as_deref()?;
        let known = choice.numbers.iter().filter_map(|of| Some(format!("{}={}", of.parameter.name, of.known?)));
        let known: Vec<String> = known.collect();
        (!known.is_empty()).then_some((known, activity))
    });
    match (with.as_slice(), ordered) {
        ([], None) => String::new(),
        // Each place has numbers of its own.
        ([], Some(_)) if !is_one => ", with the numbers that `linewright recover` lists for it".to_owned(),
        ([], Some((known, activity))) => format!(", --with {} by its order for {activity}", known.join(" --with ")),
        (with, ordered) => format!(
            ", {}. Its {} is lost with its journal: see which one the task was for. Where nobody sees it, take out what the station carries, \
             then any will do{}",
            with.join(" "),
            names.join(" and "),
            match ordered {
                None => String::new(),
                Some(_) if !is_one =>
                    ". Where the order of a place is known, `linewright recover` lists the numbers with it".to_owned(),
                Some((known, activity)) => format!(". For {activity} its order had {}", known.join(" and ")),
            }
        ),
    }
}

/// The confirmations of places that the switches fit.
pub(crate) fn commands<'c>(
    line: &Line,
    station: StationId,
    choices: impl Iterator<Item = &'c RejoinChoice>,
) -> Vec<Vec<String>> {
    let described = line.station(station);
    let command = |choice: &RejoinChoice| {
        let place = match choice.at {
            RejoinAt::Measured => None,
            RejoinAt::Within(op) => Some(("--within", described.operations[op.index()].name.clone())),
            RejoinAt::Rest(rest) => Some(("--rest", described.rests[rest.index()].name.clone())),
        };
        let number = |of: &ConfirmedNumber| {
            let number = of.known.map_or_else(|| "N".to_owned(), |number| number.to_string());
            ("--with", format!("{}={number}", of.parameter.name))
        };
        let named = place.into_iter().chain(choice.numbers.iter().map(number));
        let named = named.flat_map(|(key, value)| [key.to_owned(), value]);
        ["rejoin", "LINE", &described.name].map(str::to_owned).into_iter().chain(named).collect()
    };
    choices.map(command).collect()
}
