//! Any bytes as a device description: it or problems with their places, never a panic. What is read is written byte for
//! byte; what is configured is read back, twice the same; every value is one of its type.

#![cfg_attr(feature = "engine", no_main)]

use libfuzzer_sys::fuzz_target;
use linewright_eds::{Configuration, DataType, DownloadContent, Eds, NodeId, ObjectValue, Problems, limits, read};
use linewright_fuzz::draw_foreign;

/// No drawing of a few dozen problems is longer, whatever the lines of the file are.
const DRAWN_MAX: usize = 400_000;
/// Most entries of a file that are given a value.
const SET_MAX: usize = 8;

fuzz_target!(|bytes: &[u8]| {
    match read("any.eds", bytes) {
        Ok(eds) => {
            assert_eq!(eds.to_bytes(), bytes);
            assert_eq!(eds.warnings().errors(), 0);
            if !eds.warnings().is_empty() {
                draw(bytes, eds.warnings());
            }
            use_it(&eds);
        }
        Err(problems) => {
            assert!(problems.errors() >= 1);
            draw(bytes, &problems);
        }
    }
    // As a value, of every type.
    for data_type in DataType::ALL {
        if let Ok(value) = data_type.decode(bytes)
            && !matches!(data_type, DataType::VisibleString | DataType::Boolean)
        {
            assert_eq!(data_type.encode(&value).as_deref(), Ok(bytes));
        }
    }
});

fn use_it(eds: &Eds) {
    let node = eds.node_id().unwrap_or(NodeId::new(127).expect("a node id"));
    let _ = eds.identity();
    let mut configuration = Configuration::new(node);
    for (index, sub, entry) in eds.entries() {
        for value in [entry.default_for(node), entry.value_for(node)].into_iter().flatten() {
            let bytes = entry.data_type.encode(&value).expect("what is read is of its type");
            entry.data_type.decode(&bytes).expect("its own bytes");
        }
        if entry.access.is_writable() && configuration.values.len() < SET_MAX {
            let value = entry.default_for(node).unwrap_or(ObjectValue::Unsigned(1));
            configuration.values.insert((index, sub), value);
        }
    }
    for download in eds.downloads(node).expect("for its own node") {
        assert!(!matches!(&download.content, DownloadContent::Bytes(bytes) if bytes.len() > limits::FILE_BYTES_MAX));
    }
    // Values without a form in a file are refused; the others are there when it is read again.
    let Ok(dcf) = eds.configure("any.dcf", &configuration) else { return };
    let again = read("any.dcf", &dcf.to_bytes()).expect("what is written can be read");
    assert_eq!(again.node_id(), Some(node));
    for (&(index, sub), value) in &configuration.values {
        let entry = again.entry(index, sub).expect("still there");
        let read = entry.value_for(node).expect("set");
        assert_eq!(entry.data_type.encode(&read), entry.data_type.encode(value), "{index:04X} {sub}");
    }
    assert_eq!(again.configure("any.dcf", &configuration).expect("once more").to_bytes(), dcf.to_bytes());
}

fn draw(bytes: &[u8], problems: &Problems) {
    assert!(problems.errors() <= limits::PROBLEMS_MAX && problems.warnings() <= limits::PROBLEMS_MAX);
    draw_foreign(bytes, problems, DRAWN_MAX);
}

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
