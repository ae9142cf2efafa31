//! All texts about Modbus devices in one list. A new variant without a text, or without a place in the list, does not
//! compile.

use std::time::Duration;

use linewright_line::Table;
use linewright_modbus::{
    ModbusCondition, ModbusFailure, ModbusNote, ModbusRequest, ModbusServiceReply, ModbusTrouble, exception_text,
};
use linewright_testkit::samples::{listed, samples};

const READ: ModbusRequest = ModbusRequest::Read { table: Table::DiscreteInputs, first: 0, count: 16 };
const COILS: ModbusRequest = ModbusRequest::WriteCoils { first: 0, count: 8, bits: 0 };
const REGISTERS: ModbusRequest = ModbusRequest::WriteRegisters { first: 16, count: 1, words: 7 };

const fn ms(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

fn requests() -> Vec<ModbusRequest> {
    samples!(ModbusRequest {
        ModbusRequest::Read { .. } => READ;
        ModbusRequest::WriteCoils { .. } => COILS;
        ModbusRequest::WriteRegisters { .. } => REGISTERS;
    })
}

fn failures() -> Vec<ModbusFailure> {
    samples!(ModbusFailure {
        ModbusFailure::Gone(_) => ModbusFailure::Gone("connection refused".to_owned());
        ModbusFailure::Exception(_) => ModbusFailure::Exception(2), ModbusFailure::Exception(4);
        ModbusFailure::Malformed(_) => ModbusFailure::Malformed("invalid data length".to_owned());
        ModbusFailure::OtherAnswer => ModbusFailure::OtherAnswer;
        ModbusFailure::Count { .. } => ModbusFailure::Count { came: 3, count: 4 };
    })
}

fn troubles() -> Vec<ModbusTrouble> {
    samples!(ModbusTrouble {
        ModbusTrouble::NotAsked(_) => ModbusTrouble::NotAsked(ms(350));
        ModbusTrouble::WatchdogUnwritten(_) => ModbusTrouble::WatchdogUnwritten(ms(900));
        ModbusTrouble::NotConnected(_) => ModbusTrouble::NotConnected(ms(1000));
        ModbusTrouble::Unanswered { .. } => ModbusTrouble::Unanswered { request: READ, within: ms(100) };
        ModbusTrouble::OutputsChanged { .. } => ModbusTrouble::OutputsChanged { found: 0x1F, written: 0x10 };
        ModbusTrouble::OtherDevice { .. } => ModbusTrouble::OtherDevice { register: 40, found: 3, expected: 4 };
        ModbusTrouble::Failed { .. } =>
            ModbusTrouble::Failed { request: None, failure: ModbusFailure::Gone("connection refused".to_owned()) };
        ModbusTrouble::Reset => ModbusTrouble::Reset;
    })
}

fn conditions(trouble: &ModbusTrouble) -> Vec<ModbusCondition<'_>> {
    samples!(ModbusCondition<'_> {
        ModbusCondition::Down { .. } => ModbusCondition::Down { trouble, retry: Some(ms(400)) },
            ModbusCondition::Down { trouble, retry: None };
        ModbusCondition::Connecting => ModbusCondition::Connecting;
        ModbusCondition::Preparing(_) => ModbusCondition::Preparing(COILS);
        ModbusCondition::Unanswered(_) => ModbusCondition::Unanswered(READ);
        ModbusCondition::Unasked => ModbusCondition::Unasked;
        ModbusCondition::Slow { .. } => ModbusCondition::Slow { took: ms(30), cycle: ms(10) };
        ModbusCondition::Operational { .. } => ModbusCondition::Operational { inputs: Some(ms(4)) },
            ModbusCondition::Operational { inputs: None };
    })
}

fn notes(trouble: &ModbusTrouble) -> Vec<ModbusNote<'_>> {
    samples!(ModbusNote<'_> {
        ModbusNote::Operational => ModbusNote::Operational;
        ModbusNote::Lost(_) => ModbusNote::Lost(trouble);
        ModbusNote::NotStarted(_) => ModbusNote::NotStarted(trouble);
        ModbusNote::Slow { .. } => ModbusNote::Slow { took: ms(30), cycle: ms(10) };
        ModbusNote::SlowNoLonger => ModbusNote::SlowNoLonger;
    })
}

fn replies() -> Vec<ModbusServiceReply> {
    samples!(ModbusServiceReply {
        ModbusServiceReply::Reset => ModbusServiceReply::Reset;
        ModbusServiceReply::Started => ModbusServiceReply::Started;
        ModbusServiceReply::TriedAgain => ModbusServiceReply::TriedAgain;
        ModbusServiceReply::NoObjects => ModbusServiceReply::NoObjects;
    })
}

#[test]
fn all_texts_about_a_modbus_device() {
    let trouble = ModbusTrouble::NotConnected(ms(1000));
    let failed =
        |failure: &ModbusFailure| ModbusTrouble::Failed { request: Some(READ), failure: failure.clone() }.to_string();
    let exceptions: Vec<u8> = (1..=12).collect();
    let lists = [
        listed("requests", &requests(), ToString::to_string),
        listed("failures of a request, behind the device", &failures(), failed),
        listed("troubles, behind the device", &troubles(), ToString::to_string),
        listed("conditions, behind the device", &conditions(&trouble), ToString::to_string),
        listed("notes, behind the device's name", &notes(&trouble), ToString::to_string),
        listed("replies to requests", &replies(), |reply| reply.text().to_owned()),
        listed("exception codes", &exceptions, |code| exception_text(*code).to_owned()),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
