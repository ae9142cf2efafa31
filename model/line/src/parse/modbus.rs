//! A device's `modbus` table → addresses and times.

use std::time::Duration;

use linewright_text::{Located, or};

use super::draft::DraftDevice;
use super::raw::{RawModbus, RawRegisterValue};
use crate::{Modbus, RegisterValue, Table, WatchdogRegister};

/// Default period of reading and writing a device.
pub(super) const CYCLE: Duration = Duration::from_millis(20);
/// Default time limit of its answer.
pub(super) const TIMEOUT: Duration = Duration::from_millis(100);

/// An address or a number in a register, if it can be one.
pub(super) fn word(value: i64) -> Option<u16> {
    u16::try_from(value).ok()
}

/// Host and port, if the text has both: `192.168.1.20:502`, `press-io:502`, `[::1]:502`.
pub(super) fn host_and_port(text: &str) -> Option<(&str, u16)> {
    let (host, port) = text.rsplit_once(':')?;
    let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    let is_host = bare.is_some_and(|bare| !bare.is_empty())
        || !host.is_empty()
            && host.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'_'));
    let port = port.bytes().all(|byte| byte.is_ascii_digit()).then(|| port.parse().ok())??;
    (is_host && port != 0).then_some((host, port))
}

/// Table and address of the first input bit; `None` if that is no address.
pub(super) fn inputs_at(raw: &RawModbus) -> Option<(Table, u16)> {
    first(raw.inputs.as_ref().map(|at| (at.table, at.first.as_ref())), Table::DiscreteInputs)
}

/// Table and address of the first output bit; `None` if that is no address.
pub(super) fn outputs_at(raw: &RawModbus) -> Option<(Table, u16)> {
    first(raw.outputs.as_ref().map(|at| (at.table, at.first.as_ref())), Table::Coils)
}

fn first(raw: Option<(Table, Option<&Located<i64>>)>, usual: Table) -> Option<(Table, u16)> {
    match raw {
        None => Some((usual, 0)),
        Some((table, first)) => Some((table, first.map_or(Some(0), |first| word(first.value))?)),
    }
}

/// The device a `modbus` table describes; `None` if a part is missing.
pub(super) fn finish(device: &DraftDevice, raw: &RawModbus) -> Option<Modbus> {
    let watchdog = match &raw.watchdog {
        None => None,
        Some(raw) => Some(WatchdogRegister {
            register: word(raw.register.as_ref()?.value)?,
            timeout: raw.timeout.as_ref()?.value,
        }),
    };
    Some(Modbus {
        address: raw.address.as_ref()?.value.clone(),
        unit: raw.unit.as_ref().map_or(Some(1), |unit| u8::try_from(unit.value).ok())?,
        cycle: or(&raw.cycle, CYCLE),
        timeout: or(&raw.timeout, TIMEOUT),
        inputs: device.inputs.clone(),
        inputs_at: inputs_at(raw)?,
        outputs: device.outputs.clone(),
        outputs_at: outputs_at(raw)?,
        reads_back: raw.read_back.as_ref().is_some_and(|read_back| read_back.value),
        watchdog,
        without_watchdog: raw.without_watchdog.as_ref().map(|why| why.value.clone()),
        expect: raw.expect.iter().map(register_value).collect::<Option<_>>()?,
        settings: raw.settings.iter().map(register_value).collect::<Option<_>>()?,
    })
}

fn register_value(raw: &RawRegisterValue) -> Option<RegisterValue> {
    let number = |raw: &Option<Located<i64>>| word(raw.as_ref()?.value);
    Some(RegisterValue { register: number(&raw.register)?, value: number(&raw.value)? })
}
