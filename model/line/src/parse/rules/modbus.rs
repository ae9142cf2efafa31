//! Devices in Modbus.

use std::ops::Range;

use linewright_text::{Located, Problem, Report, TextRange, or};

use crate::Table;
use crate::parse::draft::{DraftDevice, DraftLine};
use crate::parse::modbus::{CYCLE, TIMEOUT, host_and_port, inputs_at, outputs_at};
use crate::parse::raw::{RawDevice, RawDeviceKind, RawModbus};

pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        kind_and_table_agree(raw, report);
        let Some(modbus) = &raw.modbus else { continue };
        nothing_of_can_is_said(raw, modbus, report);
        address_has_host_and_port(modbus, report);
        times_are_in_order(modbus, report);
        registers_exist(device, modbus, report);
        watchdog_is_a_register_of_its_own(device, modbus, report);
        outputs_go_off_without_a_manager(raw, modbus, report);
    }
    outputs_are_one_devices(draft, report);
    watchdogs_and_settings_are_one_devices(draft, report);
}

fn kind_and_table_agree(device: &RawDevice, report: &mut Report) {
    let says_modbus = device.kind.as_ref().is_some_and(|kind| kind.value == RawDeviceKind::Modbus);
    match (&device.kind, &device.modbus) {
        (Some(kind), None) if says_modbus => report.add(
            Problem::error(kind.at.clone(), "a device of kind `modbus` needs a `modbus` table")
                .hint("write [device.modbus] with at least its `address`"),
        ),
        (_, Some(modbus)) if !says_modbus => report.add(
            Problem::error(modbus.at.clone(), "a `modbus` table in a device of another kind")
                .hint("write `kind = \"modbus\"` beside the device's name, or leave the table out"),
        ),
        _ => {}
    }
}

fn nothing_of_can_is_said(device: &RawDevice, modbus: &RawModbus, report: &mut Report) {
    let settings = device.settings.first().and_then(|setting| setting.object.as_ref()).map(|object| &object.at);
    let identity = device.identity.as_ref().and_then(|identity| identity.parts().into_iter().flatten().next());
    let said: [(&str, Option<&TextRange>); 10] = [
        ("`node`", device.node.as_ref().map(|node| &node.at)),
        ("`identity`", identity.map(|part| &part.at)),
        ("`settings` of objects", settings),
        ("`file`", device.file.as_ref().map(|file| &file.at)),
        ("`transmission`", device.transmission.as_ref().map(|transmission| &transmission.at)),
        ("`without_error_values`", device.without_error_values.as_ref().map(|why| &why.at)),
        ("`on_emergency`", device.on_emergency.as_ref().map(|key| &key.at)),
        ("`when_lost`", device.when_lost.as_ref().map(|key| &key.at)),
        ("`drive`", device.drive.as_ref().map(|drive| &drive.at)),
        ("`dbc`", device.frames.as_ref().map(|frames| &frames.at)),
    ];
    for (what, at) in said.into_iter().filter_map(|(what, at)| Some((what, at?))) {
        report.add(
            Problem::error(at.clone(), format!("a device with a `modbus` table has no {what}"))
                .also(&modbus.at, "it speaks Modbus")
                .hint("all that is known of it is in `inputs`, `outputs` and its `modbus` table"),
        );
    }
}

fn address_has_host_and_port(modbus: &RawModbus, report: &mut Report) {
    let Some(address) = modbus.address.as_ref().filter(|address| host_and_port(&address.value).is_none()) else {
        return;
    };
    report.add(
        Problem::error(address.at.clone(), format!("`{}` is no address", address.value))
            .hint("host and port, such as \"192.168.1.20:502\"; 502 is the usual port"),
    );
}

/// What is lost must show, and what is written must come before the device turns its outputs off.
fn times_are_in_order(modbus: &RawModbus, report: &mut Report) {
    let (cycle, timeout) = (or(&modbus.cycle, CYCLE), or(&modbus.timeout, TIMEOUT));
    for (key, time) in [("cycle_ms", &modbus.cycle), ("timeout_ms", &modbus.timeout)] {
        if let Some(time) = time.as_ref().filter(|time| time.value.is_zero()) {
            report.add(Problem::error(time.at.clone(), format!("`{key}` is 0")).hint("at least 1"));
        }
    }
    let Some(own) = modbus.watchdog.as_ref().and_then(|watchdog| watchdog.timeout.as_ref()) else { return };
    if own.value <= cycle + 2 * timeout {
        report.add(
            Problem::error(own.at.clone(), "this device turns its outputs off before the next write comes").hint(
                format!(
                    "more than `cycle_ms` and twice `timeout_ms` together, which are {} ms: two answers may be late",
                    (cycle + 2 * timeout).as_millis()
                ),
            ),
        );
    }
}

/// The addresses that so many bits from there take.
fn addresses((table, first): (Table, u16), bits: usize) -> Range<usize> {
    let first = usize::from(first);
    first..first + table.addresses(bits)
}

/// The table and the addresses of a device's outputs.
fn outputs_of(device: &DraftDevice, modbus: &RawModbus) -> Option<(Table, Range<usize>)> {
    let at = outputs_at(modbus)?;
    Some((at.0, addresses(at, device.outputs.len())))
}

fn registers_exist(device: &DraftDevice, modbus: &RawModbus, report: &mut Report) {
    let parts = [
        (modbus.inputs.as_ref().map(|raw| &raw.at), inputs_at(modbus), device.inputs.len()),
        (modbus.outputs.as_ref().map(|raw| &raw.at), outputs_at(modbus), device.outputs.len()),
    ];
    for (place, at, bits) in parts {
        let (Some(place), Some(at)) = (place, at) else { continue };
        let end = addresses(at, bits).end;
        if end > 0x1_0000 {
            report.add(
                Problem::error(place.clone(), format!("{bits} bits from {} go beyond address 65535", at.1))
                    .hint("addresses count from 0: coil 1 of a manual is 0 here"),
            );
        }
    }
}

fn watchdog_is_a_register_of_its_own(device: &DraftDevice, modbus: &RawModbus, report: &mut Report) {
    let Some(watchdog) = &modbus.watchdog else { return };
    let Some(register) = &watchdog.register else { return };
    let is = |taken: &Range<usize>| usize::try_from(register.value).is_ok_and(|at| taken.contains(&at));
    let outputs = outputs_of(device, modbus).filter(|(table, _)| *table == Table::HoldingRegisters);
    if outputs.is_some_and(|(_, taken)| is(&taken)) {
        report.add(
            Problem::error(register.at.clone(), format!("register {} holds outputs", register.value))
                .hint("a watchdog register is written with another number in each cycle: it has nothing else in it"),
        );
    }
    let set = modbus.settings.iter().filter_map(|setting| setting.register.as_ref());
    if let Some(setting) = set.into_iter().find(|setting| setting.value == register.value) {
        report.add(
            Problem::error(setting.at.clone(), format!("register {} is the watchdog's", setting.value))
                .also(&register.at, "named here")
                .hint("it is written in each cycle"),
        );
    }
}

/// A Modbus device keeps its outputs when nothing is written any more, unless it has a watchdog.
fn outputs_go_off_without_a_manager(device: &RawDevice, modbus: &RawModbus, report: &mut Report) {
    let output = device.outputs.iter().find(|output| !output.value.is_empty());
    match (&modbus.without_watchdog, &modbus.watchdog, output) {
        (Some(why), Some(watchdog), _) => report.add(
            Problem::error(why.at.clone(), "a reason to be without a watchdog, and a watchdog")
                .also(&watchdog.at, "here")
                .hint("leave one of them out"),
        ),
        (Some(why), None, _) if why.value.trim().is_empty() => report.add(
            Problem::error(why.at.clone(), "no reason is given")
                .hint("say what lets its outputs go when the manager is gone, such as a safety relay in their supply"),
        ),
        (None, None, Some(output)) => report.add(
            Problem::warning(modbus.at.clone(), format!("`{}` may stay on when the manager is gone", output.value))
                .also(&output.at, "an output of this device")
                .hint(
                    "name the device's watchdog register in `watchdog`, or say in `without_watchdog` what else turns its \
                     outputs off",
                ),
        ),
        _ => {}
    }
}

fn outputs_are_one_devices(draft: &DraftLine<'_>, report: &mut Report) {
    type Taken<'a> = (&'a str, i64, Table, Range<usize>, &'a TextRange);
    let mut seen: Vec<Taken<'_>> = Vec::new();
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        let Some(modbus) = &raw.modbus else { continue };
        let (Some(address), Some((table, taken))) = (&modbus.address, outputs_of(device, modbus)) else { continue };
        let unit = modbus.unit.as_ref().map_or(1, |unit| unit.value);
        let same = seen.iter().find(|(at, of, other, others, ..)| {
            (*at, *of, *other) == (address.value.as_str(), unit, table)
                && taken.start < others.end
                && others.start < taken.end
        });
        if let Some((.., earlier)) = same {
            report.add(
                Problem::error(address.at.clone(), format!("two devices write the same {table} there"))
                    .also(earlier, "first here")
                    .hint("give each its own `first` in `outputs`, or its own `unit`"),
            );
        }
        seen.push((&address.value, unit, table, taken, &address.at));
    }
}

/// A register that one device's table has written in each cycle, or once, is written for nothing else.
fn watchdogs_and_settings_are_one_devices(draft: &DraftLine<'_>, report: &mut Report) {
    struct Written<'a> {
        device: usize,
        server: (&'a str, i64),
        what: &'static str,
        registers: Range<usize>,
        place: &'a TextRange,
    }
    let mut seen: Vec<Written<'_>> = Vec::new();
    for (device, (described, raw)) in draft.devices.iter().zip(&draft.raw.devices).enumerate() {
        let Some(modbus) = &raw.modbus else { continue };
        let Some(address) = &modbus.address else { continue };
        let server = (address.value.as_str(), modbus.unit.as_ref().map_or(1, |unit| unit.value));
        let outputs = outputs_of(described, modbus).filter(|(table, _)| *table == Table::HoldingRegisters);
        let outputs = outputs.map(|(_, registers)| ("outputs", registers, &address.at));
        let one = |register: &Option<Located<i64>>| usize::try_from(register.as_ref()?.value).ok();
        let watchdog = modbus.watchdog.as_ref();
        let watchdog = watchdog.and_then(|dog| Some(("the watchdog", one(&dog.register)?, &dog.at)));
        let settings = modbus.settings.iter().filter_map(|set| Some(("a setting", one(&set.register)?, &set.at)));
        let single = watchdog.into_iter().chain(settings).map(|(what, at, place)| (what, at..at + 1, place));
        for (what, registers, place) in outputs.into_iter().chain(single) {
            let shared = seen.iter().find(|earlier| {
                // Within one device the watchdog is looked at above, and a register may be set twice.
                let pair = [what, earlier.what];
                let is_looked_at = earlier.device == device && (pair.contains(&"the watchdog") || what == earlier.what);
                earlier.server == server
                    && registers.start < earlier.registers.end
                    && earlier.registers.start < registers.end
                    && !is_looked_at
                    && pair != ["outputs", "outputs"]
            });
            if let Some(earlier) = shared {
                report.add(
                    Problem::error(
                        place.clone(),
                        format!("{what} and {} share register {}", earlier.what, registers.start),
                    )
                    .also(earlier.place, "there")
                    .hint("each register is written for one thing; devices with one watchdog are one device"),
                );
            }
            seen.push(Written { device, server, what, registers, place });
        }
    }
}
