//! Any bytes as a DBC file: a database or an error with a place in it, never a panic. Every message of it is bound,
//! with every signal as an input and as an output: each bound signal is inside its frame, and goes in and out of it
//! again.

#![cfg_attr(feature = "engine", no_main)]

use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use linewright_dbc::{Database, DbcError, DbcMessage, bind, read};
use linewright_line::{
    CyclicFrame, DbcName, FrameTable, InputId, OutputId, ReceivedMessageTable, SignalInput, SignalOutput, When,
};

/// Most messages of a file that are bound.
const MESSAGES_MAX: usize = 8;

fuzz_target!(|bytes: &[u8]| match read(bytes) {
    Ok(database) => database.messages.iter().take(MESSAGES_MAX).for_each(|message| use_it(&database, message)),
    Err(DbcError::Syntax { line, column, .. }) => {
        assert!(line >= 1 && column >= 1);
        assert!(line <= 1 + bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count());
    }
    Err(_) => {}
});

fn use_it(database: &Database, message: &DbcMessage) {
    for signal in &message.signals {
        let frames = frames(&message.name, &signal.name);
        let Ok(bound) = bind(&frames, database) else { continue };
        for (_, field, when) in bound.heard.iter().flat_map(|heard| &heard.pages).flat_map(|page| &page.inputs) {
            assert!(field.fits(message.len as u8));
            let mut data = [0x5A; 8];
            let bits = field.get(&data);
            field.put(&mut data, bits);
            assert_eq!(data, [0x5A; 8]);
            let _ = when.holds(field, bits, true);
        }
        for told in &bound.told {
            let (_, field, on) = told.outputs[0];
            assert_eq!(field.get(&told.bytes(1, 0)), on);
            assert_ne!(field.get(&told.bytes(0, 0)), on);
        }
    }
}

fn frames(message: &str, signal: &str) -> FrameTable {
    let named = |name: &str| DbcName { name: name.to_owned(), at: 0..0 };
    let when = When::Above { at: 1.0, hysteresis: 0.5 };
    let input = SignalInput { input: InputId(0), signal: named(signal), when };
    let output = SignalOutput { output: OutputId(0), signal: named(signal), on: 1.0, off: 0.0 };
    let (timeout, every) = (Duration::from_millis(100), Duration::from_millis(100));
    let (counter, checksum) = (None, None);
    FrameTable {
        file: named("any.dbc"),
        receive: vec![ReceivedMessageTable {
            message: named(message),
            timeout,
            counter,
            checksum,
            inputs: vec![input],
        }],
        send: vec![CyclicFrame {
            message: named(message),
            every,
            counter: None,
            checksum: None,
            outputs: vec![output],
            set: Vec::new(),
            lets_go_after: None,
        }],
        bound: None,
    }
}

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
