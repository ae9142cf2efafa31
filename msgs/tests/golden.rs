//! The bytes on the wire, checked in.
//!
//! DO NOT change a file under `golden/` to make this test pass. A difference means that nodes of two versions no longer
//! understand each other: give the changed message a new name or add a new version directory beside `v1`, and keep this
//! one passing for as long as `v1` is in use.
//!
//! `LINEWRIGHT_WRITE_GOLDEN=1` writes files that do not exist yet, and only those.

use std::fmt::{Debug, Write};
use std::path::Path;

use byteorder::LittleEndian;
use linewright_msgs::RosMessage;

use crate::samples;

fn holds<T: RosMessage + PartialEq + Debug>(version: &str, message: T) {
    message.validate().expect("a sample is valid");
    let name = format!("{}-{}.hex", T::PACKAGE, T::NAME);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(version).join(&name);
    let bytes = cdr_encoding::to_vec::<T, LittleEndian>(&message).expect("encodes");
    if !path.exists() && std::env::var_os("LINEWRIGHT_WRITE_GOLDEN").is_some() {
        std::fs::write(&path, file(&bytes)).expect("written");
    }
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let golden = unhex(&text);
    assert_eq!(hex(&bytes), hex(&golden), "{name}: read the head of tests/golden.rs before you change anything");
    let (decoded, consumed) = cdr_encoding::from_bytes::<T, LittleEndian>(&golden).expect("decodes");
    assert_eq!((decoded, consumed), (message, golden.len()), "{name}");
}

const HEAD: &str = "\
# CDR, little endian, without the encapsulation header.
# Do not change this file to make a test pass: add a version beside it.
";

fn file(bytes: &[u8]) -> String {
    format!("{HEAD}{}", hex(bytes))
}

fn hex(bytes: &[u8]) -> String {
    let mut text = String::new();
    for row in bytes.chunks(16) {
        let digits: Vec<String> = row.iter().map(|byte| format!("{byte:02x}")).collect();
        writeln!(text, "{}", digits.join(" ")).expect("a string takes it");
    }
    text
}

fn unhex(text: &str) -> Vec<u8> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(str::split_whitespace)
        .map(|digits| u8::from_str_radix(digits, 16).expect("two hex digits"))
        .collect()
}

#[test]
fn version_1() {
    holds("v1", samples::answer());
    holds("v1", samples::station_event());
    holds("v1", samples::text());
    holds("v1", samples::flag());
    holds("v1", samples::diagnostics());
    let (read, value) = samples::co_read();
    holds("v1", read);
    holds("v1", value);
    holds("v1", samples::co_write_id());
    holds("v1", samples::trigger());
    let (goal, result, feedback) = samples::run_task();
    holds("v1", goal);
    holds("v1", result);
    holds("v1", feedback);
    holds("v1", samples::production_request());
    holds("v1", samples::cycle_time());
    let (event, described) = samples::parameters();
    holds("v1", event);
    holds("v1", described);
    let (transitions, event) = samples::lifecycle();
    holds("v1", transitions);
    holds("v1", event);
    let (command, answer) = samples::set_mode();
    holds("v1", command);
    holds("v1", answer);
    let (goal, result, feedback) = samples::dispatch_order();
    holds("v1", goal);
    holds("v1", result);
    holds("v1", feedback);
    holds("v1", samples::log_line());
}

/// Mode orders found generations, name stations that are in emergency stop or in manual by themselves, carry resume, and name the
/// start of each station that they are for. No node was released that used an earlier version.
#[test]
fn version_6() {
    holds("v6", samples::mode_order());
}

/// The state of the line has what keeps a mode as fields, and the age of a refusal. It, images and states of orders have the fingerprint
/// of the description. Orders are left in three ways, and a station reports the way of the last message, and whether it stands in a
/// handshake. No node was released that used an earlier version.
#[test]
fn version_7() {
    holds("v7", samples::line_state());
    holds("v7", samples::order_state());
    holds("v7", samples::secure_order());
    holds("v7", samples::process_image());
}

/// An alarm has which way its stations are led, which one is brought to another rest, which still have an order, what each of its
/// answers means, and what sensors say of each; an activity has the orders of its stations with their numbers. No node was released that
/// used an earlier version.
#[test]
fn version_9() {
    holds("v9", samples::cell_state());
}

/// A station reports its generation, its measured positions, whether its place is known, why an operation was stopped, the fingerprint
/// of the description, and the state of its node. No node was released that used an earlier version.
#[test]
fn version_10() {
    holds("v10", samples::station_state());
}
