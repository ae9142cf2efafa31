//! The `modbus` table of a device.

use linewright_text::{At, Fields, Problem, Report};

use super::SETTINGS_MAX;
use super::line::each;
use crate::Table;
use crate::parse::raw::{RawModbus, RawRegisterValue, RawRegisters, RawWatchdog};

/// The greatest address, and the greatest number in a register.
const WORD_MAX: i64 = 0xFFFF;

pub(super) fn modbus(mut f: Fields<'_>, report: &mut Report) -> RawModbus {
    let raw = RawModbus {
        at: f.at.clone(),
        address: f.required_text(report, "address"),
        unit: f.whole(report, "unit", 0, 255),
        cycle: f.millis(report, "cycle_ms"),
        timeout: f.millis(report, "timeout_ms"),
        inputs: f.table(report, "inputs", "`inputs`").map(|f| inputs(f, report)),
        outputs: f.table(report, "outputs", "`outputs`").map(|f| outputs(f, report)),
        watchdog: f.table(report, "watchdog", "`watchdog`").map(|f| watchdog(f, report)),
        without_watchdog: f.text(report, "without_watchdog"),
        expect: each(f.tables(report, "expect", "an expected register", SETTINGS_MAX), report, register_value),
        settings: each(f.tables(report, "settings", "a setting", SETTINGS_MAX), report, register_value),
    };
    f.finish(report);
    raw
}

fn inputs(mut f: Fields<'_>, report: &mut Report) -> RawRegisters {
    let tables = [
        ("discrete_inputs", Table::DiscreteInputs),
        ("coils", Table::Coils),
        ("input_registers", Table::InputRegisters),
        ("holding_registers", Table::HoldingRegisters),
    ];
    let table = f.word(report, "table", &tables);
    registers(f, table, report)
}

fn outputs(mut f: Fields<'_>, report: &mut Report) -> RawRegisters {
    let table = f.word(report, "table", &[("coils", Table::Coils), ("holding_registers", Table::HoldingRegisters)]);
    registers(f, table, report)
}

fn registers(mut f: Fields<'_>, table: Table, report: &mut Report) -> RawRegisters {
    let raw = RawRegisters { at: f.at.clone(), table, first: f.whole(report, "first", 0, WORD_MAX) };
    f.finish(report);
    raw
}

fn watchdog(mut f: Fields<'_>, report: &mut Report) -> RawWatchdog {
    let raw = RawWatchdog {
        at: f.at.clone(),
        register: word(&mut f, "register", report),
        timeout: f.required_millis(report, "timeout_ms"),
    };
    f.finish(report);
    raw
}

fn register_value(mut f: Fields<'_>, report: &mut Report) -> RawRegisterValue {
    let raw = RawRegisterValue { register: word(&mut f, "register", report), value: word(&mut f, "value", report) };
    f.finish(report);
    raw
}

fn word(f: &mut Fields<'_>, key: &'static str, report: &mut Report) -> Option<At<i64>> {
    let number = f.required_integer(report, key)?;
    if (0..=WORD_MAX).contains(&number.value) {
        return Some(number);
    }
    let problem = Problem::error(number.at, format!("`{key}` is {}", number.value));
    report.add(problem.hint(format!("between 0 and {WORD_MAX}")));
    None
}
