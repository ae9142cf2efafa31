//! A line, written as the description it could have been read from.
//!
//! Signals, axes and operations have no text of their own to go back to, so this is for lines made in code: comments
//! and the order of keys are not kept. A line whose times are whole microseconds reads back the same.

use std::fmt::{self, Display, Write};
use std::time::Duration;

use linewright_line::{
    Arrow, AtRest, ButtonId, Canopen, Device, DeviceBus, DeviceIdentity, DeviceSetup, Drive, DriveMode, InputId, Line,
    MotionSignals, ObjectWrite, OpId, Operation, OperationModule, OutputId, Owner, Parameter, Rest, RestId, StateSpan,
    Station, StationId, Task, TurnDirection,
};

/// The description of a line, as [`linewright_line::parse`] reads it.
pub fn text(line: &Line) -> String {
    let mut out = String::new();
    write_line(&mut out, line).expect("writing to a string does not fail");
    out
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", items.into_iter().collect::<Vec<_>>().join(", "))
}

fn seconds(duration: Duration) -> impl Display {
    format!("{:?}", duration.as_secs_f64())
}

fn write_line(out: &mut String, line: &Line) -> fmt::Result {
    writeln!(out, "name = {}\ntitle = {}", quoted(&line.name), quoted(&line.title))?;
    writeln!(out, "buttons = {}", list(line.buttons.iter().map(|name| quoted(name))))?;
    let timing = &line.timing;
    writeln!(out, "\n[timing]")?;
    for (key, value) in [
        ("refresh_ms", timing.refresh),
        ("stale_ms", timing.stale),
        ("lease_ms", timing.lease),
        ("heartbeat_ms", timing.heartbeat),
        ("heartbeat_timeout_ms", timing.heartbeat_timeout),
    ] {
        writeln!(out, "{key} = {}", value.as_millis())?;
    }
    write_console(out, line)?;
    line.stations.iter().try_for_each(|station| write_station(out, line, station))?;
    line.arrows.iter().try_for_each(|arrow| write_arrow(out, line, arrow))?;
    for conflict in &line.conflicts {
        let span = |span: &StateSpan| {
            let name = |op: OpId| quoted(&line.operation((span.station, op)).name);
            let station = quoted(&line.station(span.station).name);
            format!("{{ station = {station}, from = {}, until = {} }}", name(span.from), name(span.until))
        };
        writeln!(out, "\n[[conflict]]\nwhy = {}", quoted(&conflict.why))?;
        writeln!(out, "a = {}\nb = {}", span(&conflict.a), span(&conflict.b))?;
    }
    line.devices.iter().try_for_each(|device| write_device(out, line, device))
}

fn write_console(out: &mut String, line: &Line) -> fmt::Result {
    let console = &line.console;
    let input = |id: InputId| quoted(&console.inputs[id.index()]);
    let keys = [
        ("start", console.start),
        ("stop", console.stop),
        ("auto", console.auto),
        ("hand", console.hand),
        ("reset", console.reset),
    ];
    let lamps: Vec<String> = ["auto", "hand", "manual", "fault"]
        .iter()
        .zip(console.lamps)
        .filter_map(|(key, lamp)| Some(format!("{key} = {}", quoted(&console.outputs[lamp?.index()]))))
        .collect();
    if keys.iter().all(|(_, id)| id.is_none()) && console.estop.is_none() && lamps.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n[console]")?;
    for (key, id) in keys {
        if let Some(id) = id {
            writeln!(out, "{key} = {}", input(id))?;
        }
    }
    match console.estop {
        Some(contact) if contact.pressed => writeln!(out, "estop = {}", input(contact.input))?,
        Some(contact) => writeln!(out, "estop = {{ input = {}, pressed = \"off\" }}", input(contact.input))?,
        None => {}
    }
    if lamps.is_empty() { Ok(()) } else { writeln!(out, "lamps = {{ {} }}", lamps.join(", ")) }
}

fn write_station(out: &mut String, line: &Line, station: &Station) -> fmt::Result {
    let op = |id: OpId| quoted(&station.operations[id.index()].name);
    writeln!(out, "\n[[station]]\nname = {}\ntitle = {}", quoted(&station.name), quoted(&station.title))?;
    if station.is_task_driven() {
        write_tasks(out, station)?;
    } else {
        writeln!(out, "home = {}", op(station.home))?;
    }
    if let DeviceBus::Own(interface) = &station.bus {
        writeln!(out, "bus = {}", quoted(interface))?;
    }
    let axes: Vec<String> =
        station.axes.iter().map(|axis| format!("{} = {:?}", quoted(&axis.name), axis.home)).collect();
    writeln!(out, "axes = {{ {} }}", axes.join(", "))?;
    let panel =
        [("manual", station.panel.manual), ("advance", station.panel.advance), ("return", station.panel.retract)];
    let panel: Vec<String> = panel
        .iter()
        .filter_map(|(key, input)| Some(format!("{key} = {}", quoted(&station.inputs[(*input)?.index()]))))
        .collect();
    if !panel.is_empty() {
        writeln!(out, "panel = {{ {} }}", panel.join(", "))?;
    }
    station.op_ids().try_for_each(|id| write_operation(out, line, station, id))
}

fn write_tasks(out: &mut String, station: &Station) -> fmt::Result {
    let rest = |rest: &Rest| {
        let moved = station.axes.iter().zip(&rest.at).filter(|(axis, at)| axis.home != **at);
        let at: Vec<String> = moved.map(|(axis, at)| format!("{} = {at:?}", quoted(&axis.name))).collect();
        let at = if at.is_empty() { String::new() } else { format!(", at = {{ {} }}", at.join(", ")) };
        format!("{{ name = {}{at} }}", quoted(&rest.name))
    };
    writeln!(out, "rest = {}", list(station.rests.iter().map(rest)))?;
    let name = |id: RestId| quoted(&station.rests[id.index()].name);
    let task = |task: &Task| {
        let bits = |parameter: &Parameter| {
            let bits = list(parameter.bits.iter().map(|bit| quoted(&station.outputs[bit.index()])));
            format!("{} = {bits}", quoted(&parameter.name))
        };
        let parameters = task.parameters.iter().map(bits).collect::<Vec<_>>().join(", ");
        let (from, to, limit) = (name(task.from), name(task.to), seconds(task.limit));
        let key = quoted(&task.name);
        format!("{{ name = {key}, from = {from}, to = {to}, limit_s = {limit}, parameters = {{ {parameters} }} }}")
    };
    writeln!(out, "task = {}", list(station.tasks.iter().map(task)))
}

fn write_operation(out: &mut String, line: &Line, station: &Station, id: OpId) -> fmt::Result {
    let operation: &Operation = &station.operations[id.index()];
    let op = |id: OpId| quoted(&station.operations[id.index()].name);
    writeln!(out, "\n[[station.operation]]\nname = {}", op(id))?;
    if let Some(task) = station.task_of(id) {
        writeln!(out, "task = {}", quoted(&station.task(task).name))?;
    }
    if !operation.waits.is_empty() {
        let waits = operation.waits.iter().map(|id| quoted(&station.inputs[id.index()]));
        writeln!(out, "waits = {}", list(waits))?;
    }
    if operation.waits_code != 0 {
        writeln!(out, "waits_code = {}", operation.waits_code)?;
    }
    if let Some(result) = &operation.result {
        let (input, within) = (quoted(&station.inputs[result.input.index()]), seconds(result.within));
        writeln!(out, "result = {{ input = {input}, within_s = {within}, code = {} }}", result.code)?;
    }
    let step = &station.steps[station.step_of(id)];
    if step[0] != id {
        writeln!(out, "with = {}", op(step[0]))?;
    }
    let motion = &operation.motion;
    let axis = quoted(&station.axes[motion.axis.index()].name);
    match station.index_of(id) {
        Some(by) => writeln!(out, "moves = {{ axis = {axis}, by = {by:?} }}")?,
        None => writeln!(out, "moves = {{ axis = {axis}, from = {:?}, to = {:?} }}", motion.from, motion.to)?,
    }
    writeln!(out, "duration_s = {}", seconds(operation.duration))?;
    writeln!(out, "watchdog_s = {}", seconds(operation.watchdog))?;
    writeln!(out, "normal = {{ {} }}", signals(station, &operation.normal))?;
    match &operation.module {
        OperationModule::Reversible { recovery, recovery_duration, recovery_watchdog } => {
            let (duration, watchdog) = (seconds(*recovery_duration), seconds(*recovery_watchdog));
            let signals = signals(station, recovery);
            writeln!(out, "module = \"R\"")?;
            writeln!(out, "recovery = {{ {signals}, duration_s = {duration}, watchdog_s = {watchdog} }}")?;
        }
        OperationModule::Irreversible { recovery_path } => {
            writeln!(out, "module = \"I\"")?;
            if !recovery_path.is_empty() {
                writeln!(out, "recovery_path = {}", list(recovery_path.iter().map(|&id| op(id))))?;
            }
        }
    }
    let button = |key: &str, id: Option<ButtonId>| {
        id.map_or_else(String::new, |id| format!(", {key} = {}", quoted(&line.buttons[id.index()])))
    };
    let hand = &operation.hand;
    // After the end of a task, any may follow.
    let next = hand.next().filter(|_| station.rest_after(id).is_none());
    let buttons = [("forward", Some(hand.forward())), ("back", hand.back()), ("next", next)];
    let buttons: String = buttons.iter().map(|&(key, id)| button(key, id)).collect();
    writeln!(out, "hand = {{ type = {}{buttons} }}", hand.number())
}

fn signals(station: &Station, signals: &MotionSignals) -> String {
    let input = |id: InputId| quoted(&station.inputs[id.index()]);
    let output = |id: OutputId| quoted(&station.outputs[id.index()]);
    let mut text = format!("actuator = {}, complete = {}", output(signals.actuator), input(signals.complete));
    text.extend(signals.fault.map(|id| format!(", fault = {}", input(id))));
    text.extend(signals.lamp.map(|id| format!(", lamp = {}", output(id))));
    text
}

fn write_arrow(out: &mut String, line: &Line, arrow: &Arrow) -> fmt::Result {
    let end = |(station, op): (StationId, OpId)| {
        quoted(&format!("{}: {}", line.station(station).name, line.operation((station, op)).name))
    };
    writeln!(out, "\n[[arrow]]\nfrom = {}\nto = {}\nlag = {}", end(arrow.from), end(arrow.to), arrow.lag)?;
    match (arrow.auto, arrow.manual) {
        (true, true) => Ok(()),
        (auto, manual) => {
            let modes = [("auto", auto), ("manual", manual)];
            let modes = modes.iter().filter(|(_, holds)| *holds).map(|(mode, _)| quoted(mode));
            writeln!(out, "modes = {}", list(modes))
        }
    }
}

fn write_device(out: &mut String, line: &Line, device: &Device) -> fmt::Result {
    writeln!(out, "\n[[device]]\nname = {}", quoted(&device.name))?;
    if let Some(Canopen { node_id, .. }) = device.canopen() {
        writeln!(out, "node = {node_id}")?;
    }
    let (inputs, outputs) = match device.owner {
        Owner::Station(id) => {
            let station = line.station(id);
            writeln!(out, "station = {}", quoted(&station.name))?;
            (&station.inputs, &station.outputs)
        }
        Owner::Console => {
            writeln!(out, "console = true")?;
            (&line.console.inputs, &line.console.outputs)
        }
    };
    if let Some(Canopen { setup, .. }) = device.canopen() {
        write_setup(out, setup)?;
    }
    let name = |names: &[String], index: Option<usize>| quoted(index.map_or("", |index| names[index].as_str()));
    if let (Owner::Station(id), Some(drive)) = (device.owner, device.drive()) {
        return write_drive(out, line.station(id), drive);
    }
    writeln!(out, "inputs = {}", list(device.input_bits().iter().map(|bit| name(inputs, bit.map(InputId::index)))))?;
    writeln!(out, "outputs = {}", list(device.output_bits().iter().map(|bit| name(outputs, bit.map(OutputId::index)))))
}

/// Every setting is written as bytes of an unsigned number, which is how it is sent.
fn write_setup(out: &mut String, setup: &DeviceSetup) -> fmt::Result {
    if let Some(file) = &setup.file {
        writeln!(out, "file = {}", quoted(file))?;
    }
    let DeviceIdentity { device_type, vendor, product, revision, serial } = setup.identity;
    let parts =
        [("type", device_type), ("vendor", vendor), ("product", product), ("revision", revision), ("serial", serial)];
    let parts: Vec<String> =
        parts.iter().filter_map(|(key, number)| number.map(|number| format!("{key} = {number}"))).collect();
    if !parts.is_empty() {
        writeln!(out, "identity = {{ {} }}", parts.join(", "))?;
    }
    let setting = |setting: &ObjectWrite| {
        let value = setting.data.iter().rev().fold(0u64, |value, byte| value << 8 | u64::from(*byte));
        let ObjectWrite { index, sub, data } = setting;
        format!("{{ object = \"{index:04X}:{sub:02X}\", type = \"u{}\", value = {value} }}", 8 * data.len())
    };
    if !setup.settings.is_empty() {
        writeln!(out, "settings = {}", list(setup.settings.iter().map(setting)))?;
    }
    Ok(())
}

fn write_drive(out: &mut String, station: &Station, drive: &Drive) -> fmt::Result {
    let input = |id: InputId| quoted(&station.inputs[id.index()]);
    let output = |id: OutputId| quoted(&station.outputs[id.index()]);
    writeln!(out, "\n[device.drive]\naxis = {}", quoted(&station.axes[drive.axis.index()].name))?;
    let mode = if drive.mode == DriveMode::Position { "position" } else { "velocity" };
    let at_rest = if drive.at_rest == AtRest::Off { "off" } else { "hold" };
    writeln!(out, "mode = \"{mode}\"\nat_rest = \"{at_rest}\"\nunits_per_mm = {:?}", drive.units_per_mm)?;
    writeln!(out, "window = {:?}\nvelocity = {:?}", drive.window, drive.velocity)?;
    writeln!(out, "acceleration = {:?}\nquick_stop = {:?}", drive.acceleration, drive.quick_stop)?;
    if let Some(fault) = drive.fault {
        writeln!(out, "fault = {}", input(fault))?;
    }
    if let Some(homing) = drive.homing {
        let done = homing.done.map_or(String::new(), |done| format!(", done = {}", input(done)));
        let (method, fast, slow) = (homing.method, homing.fast, homing.slow);
        let (acceleration, offset, start) = (homing.acceleration, homing.offset, output(homing.output));
        writeln!(
            out,
            "homing = {{ method = {method}, fast = {fast:?}, slow = {slow:?}, acceleration = {acceleration:?}, \
             offset = {offset:?}, output = {start}{done} }}",
        )?;
    }
    if let Some(index) = &drive.index {
        let direction = if index.direction == TurnDirection::Positive { "positive" } else { "negative" };
        let to: Vec<String> = index.to.iter().map(|&bit| output(bit)).collect();
        let place: Vec<String> = index.place.iter().map(|&bit| input(bit)).collect();
        let (turns, at, turn) = (output(drive.targets[0].output), input(drive.targets[0].at), index.turn);
        let (to, place) = (to.join(", "), place.join(", "));
        return writeln!(
            out,
            "index = {{ output = {turns}, at = {at}, turn = {turn:?}, direction = \"{direction}\", to = [{to}], \
             place = [{place}] }}",
        );
    }
    drive.targets.iter().try_for_each(|target| {
        let (to, velocity) = (target.to, target.velocity);
        writeln!(out, "\n[[device.drive.targets]]\noutput = {}\nto = {to:?}", output(target.output))?;
        writeln!(out, "at = {}\nvelocity = {velocity:?}", input(target.at))
    })
}
