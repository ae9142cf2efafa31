//! A confirmation of a station's place, there and back as the text of its message.

use linewright_line::{Line, StationId, parse};
use linewright_node_line::{Confirmation, ConfirmationError};
use linewright_station_logic::RejoinAt;

fn line() -> Line {
    let text = include_str!("../../model/line/tests/descriptions/task_driven.toml");
    parse("task_driven.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

#[test]
fn what_is_confirmed_comes_back_from_its_text() {
    let line = line();
    let station = line.station(StationId(0));
    let op = station.operation_named("slide in").expect("it has it");
    let rest = station.rest_named("clamped").expect("it has it");
    let numbers = vec![("program".into(), 5), ("slot".into(), -1)];
    for (at, text) in [
        (RejoinAt::Measured, "\nprogram=5\nslot=-1"),
        (RejoinAt::Within(op), "slide in\nprogram=5\nslot=-1"),
        (RejoinAt::Rest(rest), "rest: clamped\nprogram=5\nslot=-1"),
    ] {
        let of = Confirmation { at, numbers: numbers.clone() };
        assert_eq!((of.text(station).as_str(), Confirmation::read(station, text).as_ref()), (text, Ok(&of)));
        let plain = text.split('\n').next().expect("one line");
        assert_eq!(Confirmation::read(station, plain), Ok(Confirmation { at, numbers: Vec::new() }));
    }
}

#[test]
fn what_is_no_confirmation_is_refused_with_the_reason() {
    let line = line();
    let read = |text: &str| Confirmation::read(line.station(StationId(0)), text).expect_err(text).to_string();
    assert!(read("fly").starts_with("unknown operation 'fly'; operations: clamp close, "));
    assert!(read("rest: bed").starts_with("unknown rest 'bed'; rests: open, clamped"));
    for text in ["slot", "slot=", "=2", "slot=2.5", "slot=99999999999"] {
        assert_eq!(read(&format!("\n{text}")), format!("'{text}' is not NAME=NUMBER, e.g. slot=2"));
    }
    let many = "\nslot=1".repeat(1000);
    assert_eq!(read(&many), ConfirmationError::TooMany.to_string());
}
