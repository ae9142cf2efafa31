//! Devices in Modbus.

use std::ops::Range;
use std::time::Duration;

use linewright_text::{Located, Problem, Report, TextRange, or};

use super::devices::{canopen_keys, settings_at};
use crate::parse::draft::{DraftDevice, DraftLine};
use crate::parse::modbus::{CYCLE, TIMEOUT, host_and_port, inputs_at, outputs_at};
use crate::parse::raw::{RawDevice, RawDeviceKind, RawModbus};
use crate::{Table, Timing};

pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    for (device, raw) in draft.devices.iter().zip(&draft.raw.devices) {
        kind_and_table_agree(raw, report);
        let Some(modbus) = &raw.modbus else { continue };
        nothing_of_can_is_said(raw, modbus, report);
        address_has_host_and_port(modbus, report);
        times_are_in_order(modbus, draft.raw.timing.stale.as_ref(), report);
        registers_exist(device, modbus, report);
        outputs_go_off_without_a_manager(raw, modbus, report);
    }
    addresses_are_written_for_one_thing(draft, report);
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
    let others =
        [("`settings` of objects", settings_at(device)), ("`dbc`", device.frames.as_ref().map(|frames| &frames.at))];
    let others = others.into_iter().filter_map(|(what, at)| Some((what, at?)));
    for (what, at) in canopen_keys(device).chain(others) {
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

/// A loss must show, and a write must come before the device turns its outputs off.
fn times_are_in_order(modbus: &RawModbus, written_stale: Option<&Located<Duration>>, report: &mut Report) {
    let (cycle, timeout) = (or(&modbus.cycle, CYCLE), or(&modbus.timeout, TIMEOUT));
    for (key, time) in [("cycle_ms", &modbus.cycle), ("timeout_ms", &modbus.timeout)] {
        if let Some(time) = time.as_ref().filter(|time| time.value.is_zero()) {
            report.add(Problem::error(time.at.clone(), format!("`{key}` is 0")).hint("at least 1"));
        }
    }
    let stale = written_stale.map_or(Timing::default().stale, |stale| stale.value);
    if let Some(at) = modbus.timeout.as_ref().or(written_stale).filter(|_| timeout > stale) {
        let (timeout, stale) = (timeout.as_millis(), stale.as_millis());
        report.add(
            Problem::error(at.at.clone(), format!("`timeout_ms` is {timeout} ms, but `stale_ms` is {stale} ms"))
                .also(&modbus.at, "of this device")
                .hint(
                    "`timeout_ms` of a device must not exceed `stale_ms` of the line: what is older counts as unknown",
                ),
        );
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

/// Purpose of an address of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WrittenFor {
    Outputs,
    Watchdog,
    Setting,
}

/// Addresses that are written for one thing.
struct Written<'a> {
    /// Index of the device.
    device: usize,
    /// Address and unit, where an address is given.
    server: Option<(&'a str, i64)>,
    table: Table,
    addresses: Range<usize>,
    what: WrittenFor,
    /// In the description.
    place: &'a TextRange,
}

impl Written<'_> {
    fn overlaps(&self, other: &Written<'_>) -> bool {
        (self.device == other.device || (self.server.is_some() && self.server == other.server))
            && self.table == other.table
            && self.addresses.start < other.addresses.end
            && other.addresses.start < self.addresses.end
    }
}

/// Each address is written for one thing of one device. A watchdog that two nodes feed keeps the outputs of the one on while the
/// other hangs.
fn addresses_are_written_for_one_thing(draft: &DraftLine<'_>, report: &mut Report) {
    let mut seen: Vec<Written<'_>> = Vec::new();
    for (device, (described, raw)) in draft.devices.iter().zip(&draft.raw.devices).enumerate() {
        let Some(modbus) = &raw.modbus else { continue };
        for written in written(device, described, modbus) {
            // A register may be set twice.
            let is_set_again = |other: &Written<'_>| other.device == device && other.what == written.what;
            if let Some(other) = seen.iter().find(|other| written.overlaps(other) && !is_set_again(other)) {
                report.add(written_twice(&written, other));
            }
            seen.push(written);
        }
    }
}

fn written<'a>(device: usize, described: &DraftDevice, modbus: &'a RawModbus) -> Vec<Written<'a>> {
    let unit = modbus.unit.as_ref().map_or(1, |unit| unit.value);
    let server = modbus.address.as_ref().map(|address| (address.value.as_str(), unit));
    let named = modbus.address.as_ref().map_or(&modbus.at, |address| &address.at);
    let of = |what, table, addresses, place| Written { device, server, table, addresses, what, place };
    let outputs = outputs_of(described, modbus);
    let outputs = outputs.map(|(table, addresses)| of(WrittenFor::Outputs, table, addresses, named));
    let register = |what, register: &'a Option<Located<i64>>| {
        let register = register.as_ref()?;
        let at = usize::try_from(register.value).ok()?;
        Some(of(what, Table::HoldingRegisters, at..at + 1, &register.at))
    };
    let watchdog = modbus.watchdog.as_ref().and_then(|dog| register(WrittenFor::Watchdog, &dog.register));
    let settings = modbus.settings.iter().filter_map(|setting| register(WrittenFor::Setting, &setting.register));
    outputs.into_iter().chain(watchdog).chain(settings).collect()
}

fn written_twice(written: &Written<'_>, other: &Written<'_>) -> Problem {
    use WrittenFor::{Outputs, Setting, Watchdog};
    let at = written.addresses.start;
    let error = |text: String| Problem::error(written.place.clone(), text);
    match (written.device == other.device, written.what, other.what) {
        (_, Outputs, Outputs) => error(format!("two devices write the same {} there", written.table))
            .also(other.place, "first here")
            .hint("give each its own `first` in `outputs`, or its own `unit`"),
        (true, Watchdog, Outputs) => error(format!("register {at} holds outputs"))
            .hint("a watchdog register is written with another number in each cycle: it has nothing else in it"),
        (true, Setting, Watchdog) => error(format!("register {at} is the watchdog's"))
            .also(other.place, "named here")
            .hint("it is written in each cycle"),
        _ => error(format!("{} and {} share register {at}", written.what.name(), other.what.name()))
            .also(other.place, "there")
            .hint("each register is written for one thing; devices with one watchdog are one device"),
    }
}

impl WrittenFor {
    const fn name(self) -> &'static str {
        match self {
            WrittenFor::Outputs => "outputs",
            WrittenFor::Watchdog => "the watchdog",
            WrittenFor::Setting => "a setting",
        }
    }
}
