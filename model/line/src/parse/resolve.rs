//! Names → numbers: from the description as written to a [`DraftLine`].
//!
//! The only pass that looks names up. Each reference either becomes a number or is reported with what it could have
//! been; what the numbers may be combined to is for the rules.

use linewright_text::{Located, LocatedName, NameTable, Problem, Report, TextRange, nearest, suggestion};

use super::draft::{
    DraftArrow, DraftConflict, DraftConsole, DraftEnd, DraftLine, DraftOperation, DraftSignals, DraftStation,
};
use super::names::LineNames;
use super::raw::{RawArrow, RawConflict, RawEnd, RawLine, RawMoves, RawOperation, RawSpan, RawStation};
use super::{hand, handling, rules, task, wiring};
use crate::{Axis, DeviceBus, InputId, Motion, OpId, OutputId, StationId, TaskId};
use wiring::{OwnedImages, Wires};

/// Resolves everything that can be.
pub(super) fn resolve<'a>(raw: &'a RawLine, names: LineNames<'a>, report: &mut Report) -> DraftLine<'a> {
    let buses: Vec<DeviceBus> = raw.stations.iter().map(bus).collect();
    let (devices, mut owned) = wiring::wire(raw, &names, &buses, report);
    let mut stations = Vec::new();
    for (id, station) in raw.stations.iter().enumerate() {
        let wires = std::mem::take(&mut owned.stations[id]);
        stations.push(self::station(StationId::at(id), station, &names, &owned, wires, buses[id].clone(), report));
    }
    let handling = handling::resolve(raw, &names, &mut stations, report);
    let arrows = raw.arrows.iter().map(|a| arrow(a, &names, report)).collect();
    let conflicts = raw.conflicts.iter().map(|c| conflict(c, &stations, &names, report)).collect();
    let console = console(&names, owned, report);
    DraftLine { raw, names, stations, arrows, conflicts, devices, console, handling }
}

fn bus(station: &RawStation) -> DeviceBus {
    station.bus.as_ref().map_or(DeviceBus::Line, |bus| DeviceBus::Own(bus.value.clone()))
}

fn station<'a>(
    id: StationId,
    raw: &'a RawStation,
    names: &LineNames<'a>,
    owned: &OwnedImages<'a>,
    wires: Wires<'a>,
    bus: DeviceBus,
    report: &mut Report,
) -> DraftStation<'a> {
    let inside = &names.inside[id.index()];
    let name = raw.name.as_ref().map_or("?", |n| n.value.as_str());
    let has_device = raw.name.as_ref().is_none_or(|own| owned.has_device(own, &names.stations));
    let bare = (!has_device).then(BareSignals::default);
    let mut scope = StationScope { name, wires: &wires, owned, names, bare };
    let ends_task = |nth: usize| task::ends(raw, nth);
    let operations = raw.operations.iter().enumerate();
    let mut operations: Vec<_> =
        operations.map(|(nth, op)| operation(op, id, (names, &raw.axes), &mut scope, ends_task(nth), report)).collect();
    let rests = task::rests(raw, inside, report);
    let tasks = task::tasks(raw, inside, &operations, &mut scope, report);
    task::lead_on(&mut operations, &tasks);
    let panel = match &raw.panel {
        None => [None, None, None],
        Some(panel) => [&panel.manual, &panel.advance, &panel.retract].map(|name| scope.input(name.as_ref(), report)),
    };
    if let (Some(bare), Some(name)) = (scope.bare, &raw.name) {
        let subject = format!("station `{}`", name.value);
        bare.report(&name.at, &subject, &format!("station = \"{}\"", name.value), report);
    }
    let home = raw.home.as_ref().and_then(|home| {
        let op = inside.operations.find(home, "operation", report)?;
        Some(Located::new(OpId::at(op), home.at.clone()))
    });
    let home = if tasks.is_empty() { home } else { task::home(&tasks) };
    DraftStation {
        raw,
        name,
        home,
        steps: rules::steps::steps(raw, inside, report),
        axes: axes(raw, &operations),
        operations,
        rests,
        tasks,
        sensed: Vec::new(),
        bus,
        wiring: wires.wiring,
        panel,
    }
}

fn operation<'a>(
    raw: &'a RawOperation,
    station: StationId,
    (names, homes): (&LineNames<'a>, &[(LocatedName, f64)]),
    scope: &mut StationScope<'a, '_>,
    ends_task: bool,
    report: &mut Report,
) -> DraftOperation<'a> {
    let inside = &names.inside[station.index()];
    let mut path = Vec::new();
    for step in raw.recovery_path.iter().flat_map(|path| &path.value) {
        if let Some(op) = inside.operations.find(step, "operation", report) {
            path.push(Located::new(OpId::at(op), step.at.clone()));
        }
    }
    DraftOperation {
        raw,
        name: raw.name.as_ref().map_or("?", |n| n.value.as_str()),
        motion: raw.moves.as_ref().and_then(|moves| motion(moves, homes, inside, report)),
        normal: raw.normal.as_ref().map(|s| scope.signals(s, report)).unwrap_or_default(),
        recovery: raw.recovery.as_ref().map(|r| scope.signals(&r.signals, report)),
        hand: raw.hand.as_ref().and_then(|raw| hand::hand(raw, &names.buttons, ends_task, report)),
        path,
        task: raw.task.as_ref().and_then(|name| {
            let task = inside.tasks.find(name, "task", report)?;
            Some(Located::new(TaskId::at(task), name.at.clone()))
        }),
        waits: raw
            .waits
            .iter()
            .flat_map(|waits| &waits.value)
            .filter_map(|name| scope.input(Some(name), report))
            .collect(),
        result: raw.result.as_ref().and_then(|result| scope.input(result.input.as_ref(), report)),
    }
}

/// An index leads from the home position round to it again.
fn motion(
    raw: &RawMoves,
    homes: &[(LocatedName, f64)],
    inside: &super::names::StationNames<'_>,
    report: &mut Report,
) -> Option<Located<Motion>> {
    let axis = inside.axes.find(raw.axis.as_ref()?, "axis", report)?;
    let (from, to) = match raw.by {
        Some(_) => (homes.get(axis)?.1, homes.get(axis)?.1),
        None => (raw.from.as_ref()?.value, raw.to.as_ref()?.value),
    };
    Some(Located::new(Motion { axis: crate::AxisId::at(axis), from, to }, raw.at.clone()))
}

/// The axes; one that an operation moves `by` so much is endless.
fn axes(raw: &RawStation, operations: &[DraftOperation<'_>]) -> Vec<Axis> {
    let index = |axis: usize| {
        let of_axis = |op: &&DraftOperation<'_>| op.motion.as_ref().is_some_and(|m| m.value.axis.index() == axis);
        operations.iter().filter(of_axis).find_map(|op| Some(op.by()?.value))
    };
    let axes = raw.axes.iter().enumerate();
    axes.map(|(axis, (name, home))| Axis { name: name.value.clone(), home: *home, index: index(axis) }).collect()
}

/// Signals that a station or console without a device uses, each once and in order. That it has none is one error.
#[derive(Default)]
struct BareSignals {
    inputs: Vec<String>,
    outputs: Vec<String>,
}

impl BareSignals {
    fn note(&mut self, name: &str, direction: SignalDirection) {
        let names = match direction {
            SignalDirection::Input => &mut self.inputs,
            SignalDirection::Output => &mut self.outputs,
        };
        if !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }

    /// `subject`: what has no device; `owner`: the key of the device that is missing.
    fn report(&self, at: &TextRange, subject: &str, owner: &str, report: &mut Report) {
        let list = |key: &str, names: &[String]| {
            let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
            (!names.is_empty()).then(|| format!(", `{key} = [{}]`", names.join(", ")))
        };
        let lists: String =
            [list("inputs", &self.inputs), list("outputs", &self.outputs)].into_iter().flatten().collect();
        if !lists.is_empty() {
            report.add(
                Problem::error(at.clone(), format!("{subject} has no device, so none of its signals"))
                    .label("no [[device]] names it")
                    .hint(format!("write a [[device]] with `{owner}`{lists}, in the order of its bits")),
            );
        }
    }
}

#[derive(Clone, Copy)]
enum SignalDirection {
    Input,
    Output,
}

impl SignalDirection {
    const fn name(self) -> &'static str {
        match self {
            SignalDirection::Input => "input",
            SignalDirection::Output => "output",
        }
    }
}

/// Meanings of signal names inside one station.
pub(super) struct StationScope<'a, 's> {
    name: &'a str,
    wires: &'s Wires<'a>,
    owned: &'s OwnedImages<'a>,
    names: &'s LineNames<'a>,
    /// Of a station without a device.
    bare: Option<BareSignals>,
}

impl StationScope<'_, '_> {
    fn signals(&mut self, raw: &super::raw::RawSignals, report: &mut Report) -> DraftSignals {
        DraftSignals {
            actuator: self.output(raw.actuator.as_ref(), report),
            complete: self.input(raw.complete.as_ref(), report),
            fault: self.input(raw.fault.as_ref(), report),
            lamp: self.output(raw.lamp.as_ref(), report),
        }
    }

    fn input(&mut self, name: Option<&LocatedName>, report: &mut Report) -> Option<Located<InputId>> {
        let name = name?;
        let found = self.wires.inputs.meant(&name.value);
        match found {
            Some(id) => Some(Located::new(InputId::at(id), name.at.clone())),
            None => {
                self.unbound(name, SignalDirection::Input, report);
                None
            }
        }
    }

    pub fn output(&mut self, name: Option<&LocatedName>, report: &mut Report) -> Option<Located<OutputId>> {
        let name = name?;
        let found = self.wires.outputs.meant(&name.value);
        match found {
            Some(id) => Some(Located::new(OutputId::at(id), name.at.clone())),
            None => {
                self.unbound(name, SignalDirection::Output, report);
                None
            }
        }
    }

    /// Reports a name that no device of the station has, unless that follows from another error.
    fn unbound(&mut self, name: &LocatedName, direction: SignalDirection, report: &mut Report) {
        if report.is_full() || wiring::is_on_unowned(self.owned.raw, self.names, &name.value) {
            return;
        }
        match &mut self.bare {
            Some(bare) => bare.note(&name.value, direction),
            None => report.add_unknown(self.not_bound(name, direction)),
        }
    }

    fn not_bound(&self, name: &LocatedName, direction: SignalDirection) -> Problem {
        let (table, other, others) = match direction {
            SignalDirection::Input => (&self.wires.inputs, SignalDirection::Output, &self.wires.outputs),
            SignalDirection::Output => (&self.wires.outputs, SignalDirection::Input, &self.wires.inputs),
        };
        let (direction, other) = (direction.name(), other.name());
        if let Some(place) = others.place(&name.value) {
            return Problem::error(name.at.clone(), format!("`{}` is an {other}, not an {direction}", name.value))
                .label(format!("used as an {direction}"))
                .also(place, format!("bound as an {other}"));
        }
        let add = format!("add it to the {direction}s of a [[device]] with station = \"{}\"", self.name);
        let hint = match nearest(&name.value, table.names()) {
            Some(near) => format!("did you mean `{near}`? If it is another one, {add}"),
            None => match self.owned.elsewhere(&name.value) {
                Some(elsewhere) => format!("{elsewhere} has a signal of that name, but stations do not share signals"),
                None => add,
            },
        };
        let message = format!("no device of station `{}` has an {direction} `{}`", self.name, name.value);
        Problem::error(name.at.clone(), message).label("not bound").hint(hint)
    }
}

fn arrow(raw: &RawArrow, names: &LineNames<'_>, report: &mut Report) -> DraftArrow {
    DraftArrow {
        at: raw.at.clone(),
        from: raw.from.as_ref().and_then(|end| self::end(end, names, report)),
        to: raw.to.as_ref().and_then(|end| self::end(end, names, report)),
        lag: raw.lag,
        auto: raw.modes.auto,
        manual: raw.modes.manual,
    }
}

fn end(raw: &RawEnd, names: &LineNames<'_>, report: &mut Report) -> Option<DraftEnd> {
    let station = names.stations.find(&raw.station, "station", report)?;
    let mut operation = raw.operation.clone();
    // A malformed name may contain the colon at which the end was taken apart.
    if names.stations.is_malformed(station)
        && names.inside[station].operations.get(&operation.value).is_none()
        && let Some((_, rest)) = operation.value.rsplit_once(':')
    {
        operation.value = rest.trim().to_owned();
    }
    let op = station_operation(station, &operation, names, report)?;
    Some(Located::new((StationId::at(station), op), raw.station.at.start..raw.operation.at.end))
}

/// An operation that is named together with its station: it may be another station's by mistake.
fn station_operation(station: usize, name: &LocatedName, names: &LineNames<'_>, report: &mut Report) -> Option<OpId> {
    let operations = &names.inside[station].operations;
    if let Some(op) = operations.meant(&name.value) {
        return Some(OpId::at(op));
    }
    if report.is_full() {
        return None;
    }
    let owner = names.stations.names().find(|other| {
        names.stations.get(other).is_some_and(|id| names.inside[id].operations.get(&name.value).is_some())
    });
    let hint = match (nearest(&name.value, operations.names()), owner) {
        (None, Some(owner)) => Some(format!("that is an operation of station `{owner}`")),
        _ => suggestion(&name.value, operations.names()),
    };
    let of = names.stations.name(station);
    report.add_unknown(
        Problem::error(name.at.clone(), format!("station `{of}` has no operation `{}`", name.value)).maybe_hint(hint),
    );
    None
}

fn conflict(
    raw: &RawConflict,
    stations: &[DraftStation<'_>],
    names: &LineNames<'_>,
    report: &mut Report,
) -> DraftConflict {
    let mut span = |raw: &Option<RawSpan>| raw.as_ref().and_then(|span| self::span(span, stations, names, report));
    let (a, b) = (span(&raw.a), span(&raw.b));
    DraftConflict { at: raw.at.clone(), a, b }
}

fn span(
    raw: &RawSpan,
    stations: &[DraftStation<'_>],
    names: &LineNames<'_>,
    report: &mut Report,
) -> Option<Located<crate::StateSpan>> {
    let station = names.stations.find(raw.station.as_ref()?, "station", report)?;
    let described = &stations[station];
    if let Some(task) = &raw.task {
        if !described.is_task_driven() {
            report.add(
                Problem::error(task.at.clone(), format!("station `{}` has no tasks", described.name))
                    .hint("it goes round a cycle: name the stretch by `from` and `until`"),
            );
            return None;
        }
        let ops = &described.tasks[names.inside[station].tasks.find(task, "task of this station", report)?].ops;
        let last = ops.end.checked_sub(1).filter(|_| !ops.is_empty())?;
        let span =
            crate::StateSpan { station: StationId::at(station), from: OpId::at(ops.start), until: OpId::at(last) };
        return Some(Located::new(span, raw.at.clone()));
    }
    if described.is_task_driven() {
        if raw.from.is_some() && raw.until.is_some() {
            report.add(
                Problem::error(
                    raw.at.clone(),
                    format!("a stretch of a cycle of `{}`, which is task-driven", described.name),
                )
                .hint("name one of its tasks: `task = \"…\"` instead of `from` and `until`"),
            );
        }
        return None;
    }
    let from = raw.from.as_ref().and_then(|name| station_operation(station, name, names, report));
    let until = raw.until.as_ref().and_then(|name| station_operation(station, name, names, report));
    let span = crate::StateSpan { station: StationId::at(station), from: from?, until: until? };
    Some(Located::new(span, raw.at.clone()))
}

/// The console. Without a device it has none of its signals, which is one error; buttons may be on ROS topics alone.
fn console(names: &LineNames<'_>, owned: OwnedImages<'_>, report: &mut Report) -> DraftConsole {
    let OwnedImages { console: wires, raw, .. } = owned;
    let buttons = raw.buttons.iter().map(|b| wires.inputs.get(&b.value).map(InputId::at)).collect();
    let mut console = DraftConsole { buttons, ..DraftConsole::default() };
    let Some(written) = &raw.console else {
        console.wiring = wires.wiring;
        return console;
    };
    let has_device = raw.devices.iter().any(|device| device.console.as_ref().is_some_and(|console| console.value));
    let mut bare = BareSignals::default();
    raw.buttons.iter().for_each(|button| bare.note(&button.value, SignalDirection::Input));
    let without_buttons = bare.inputs.len();
    let mut find = |table: &NameTable<'_>, name: &Option<LocatedName>, direction: SignalDirection| {
        let name = name.as_ref()?;
        if has_device {
            let what = format!("{} of the console's devices:", direction.name());
            return Some(Located::new(table.find(name, &what, report)?, name.at.clone()));
        }
        if !wiring::is_on_unowned(raw, names, &name.value) {
            bare.note(&name.value, direction);
        }
        None
    };
    let keys = [&written.start, &written.stop, &written.auto, &written.hand, &written.estop.input, &written.reset];
    console.inputs = keys.map(|name| Some(find(&wires.inputs, name, SignalDirection::Input)?.map(InputId::at)));
    let lamps = &written.lamps;
    console.lamps = [&lamps.auto, &lamps.hand, &lamps.manual, &lamps.fault]
        .map(|name| Some(find(&wires.outputs, name, SignalDirection::Output)?.map(OutputId::at)));
    if bare.inputs.len() > without_buttons || !bare.outputs.is_empty() {
        bare.report(&written.at, "the console", "console = true", report);
    }
    console.wiring = wires.wiring;
    console
}
