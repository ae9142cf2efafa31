//! Commands as text and as messages, refusals, the coordinator's record over restarts, and the time at which an emergency stop was latched.

use std::path::Path;
use std::time::{Duration, SystemTime};

use linewright_coordinator_logic::{ModeCommand, ModeRefusal};
use linewright_coordinator_node::{
    Refusals, StopTime, command_of, outputs_from_message, record_of, remembered, words_of,
};
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorRecord};
use linewright_line::{StationId, Tick};
use linewright_msgs::{LineState, ProcessImage, SetModeRequest};
use linewright_testkit::built::transfer_line;

#[test]
fn one_station_is_named_after_manual_or_auto() {
    let line = transfer_line();
    let command = |words| command_of(&line, words);
    let single = |words| match command(words) {
        Ok(CoordinatorArrival::Single(id, is_manual)) => (id, is_manual),
        other => panic!("{other:?}"),
    };
    assert_eq!(single(" manual  clamp_1 "), (StationId(1), true));
    assert_eq!(single("auto clamp_1"), (StationId(1), false));
    assert!(matches!(command("E-Stop"), Ok(CoordinatorArrival::Command(ModeCommand::EStop))));
    for (words, expected) in [
        ("faster", "unknown command 'faster'; commands: start, stop, auto"),
        ("faster clamp_1", "unknown command 'faster clamp_1'"),
        ("hand clamp_1", "'hand clamp_1' is no command for one station"),
        ("manual clamp_9", "no station 'clamp_9'; "),
    ] {
        let refusal = command(words).expect_err(words);
        assert!(refusal.starts_with(expected), "{refusal}");
    }
}

#[test]
fn a_refusal_stands_with_its_age_until_something_ends_it_or_half_a_minute_is_over() {
    let mut refusals = Refusals::default();
    let at = Tick::from_millis;
    refusals.refuse(at(1000), "hand refused in auto".to_owned(), "hand".to_owned(), &[]);
    let refused = |refusals: &Refusals, now| refusals.message(now, LineState::default()).refused;
    assert_eq!(refused(&refusals, at(2000)), "hand");
    assert_eq!(refusals.standing(at(30_999)), ("hand refused in auto", Duration::from_millis(29_999)));
    assert_eq!(refusals.standing(at(31_000)), ("", Duration::ZERO));
    refusals.refuse(at(40_000), "manual refused in auto".to_owned(), "manual".to_owned(), &[]);
    refusals.end();
    assert_eq!((refusals.standing(at(40_001)), refusals.count), (("", Duration::ZERO), 2));
    assert_eq!(refused(&refusals, at(40_001)), "");
}

#[test]
fn a_journal_that_holds_something_else_is_an_emergency_stop() {
    let path = Path::new("coordinator.journal");
    for estop in [false, true] {
        let kept = CoordinatorRecord { epoch: 7, estop };
        assert_eq!(remembered(&record_of(kept), path), kept);
    }
    for other in [&b"epoch x -"[..], b"epoch 7", b"epoch 7 maybe", b"\xff", b"", b"epoch 18446744073709551616 -"] {
        assert_eq!(remembered(other, path), CoordinatorRecord { epoch: 0, estop: true }, "{other:?}");
    }
}

#[test]
fn it_is_the_time_of_the_stop_and_stays() {
    let mut time = StopTime::default();
    let wall = SystemTime::UNIX_EPOCH + Duration::from_secs(72_389);
    let at = Tick::from_millis;
    assert_eq!(time.text((at(5000), wall), None), "");
    assert_eq!(time.text((at(7000), wall + Duration::from_secs(2)), Some(at(5000))), "1970-01-01 20:06:29 UTC");
    assert_eq!(time.text((at(8000), wall + Duration::from_secs(99)), Some(at(5000))), "1970-01-01 20:06:29 UTC");
    assert_eq!(time.text((at(9000), wall), None), "", "it was reset");
}

#[test]
fn outputs_of_another_description_are_not_taken() {
    let mut message = ProcessImage { boot_id: 5, description: 7, valid: true, number: 3, ..ProcessImage::default() };
    message.set_word(0b101);
    let image = outputs_from_message("mill_1", 7, &message).expect("of the same description");
    assert_eq!((image.boot_id, image.number, image.bits, image.valid), (5, 3, 0b101, true));
    let error = outputs_from_message("mill_1", 8, &message).expect_err("of another one").to_string();
    assert!(error.starts_with("mill_1 runs with another description"), "{error}");
}

#[test]
fn a_refusal_that_asks_for_the_release_of_a_button_ends_with_it() {
    let refused = |reasons: &[ModeRefusal], estop_pressed, console_lost| {
        let mut refusals = Refusals::default();
        refusals.refuse(Tick::from_millis(1), "reset refused".to_owned(), "reset".to_owned(), reasons);
        let state = LineState { estop_pressed, console_lost, ..LineState::default() };
        refusals.message(Tick::from_millis(2), state).refusal
    };
    let pressed = [ModeRefusal::EStopPressed];
    assert_eq!(refused(&pressed, true, false), "reset refused");
    assert_eq!(refused(&pressed, false, true), "reset refused", "whether it is released is not known");
    assert_eq!(refused(&pressed, false, false), "");
    assert_eq!(refused(&[], false, false), "reset refused", "another one asks for something else");
}

#[test]
fn a_request_of_the_service_is_the_words_of_the_topic() {
    let words = |command, station: &str| {
        words_of(&SetModeRequest { command, station: station.to_owned(), ..Default::default() })
    };
    assert_eq!(words(SetModeRequest::ESTOP, "").as_deref(), Ok("estop"));
    assert_eq!(words(SetModeRequest::MANUAL, " clamp_1 ").as_deref(), Ok("manual clamp_1"));
    for (command, station) in (SetModeRequest::START..=SetModeRequest::RESET).map(|command| (command, "")) {
        let words = words(command, station).expect("a command");
        assert!(matches!(command_of(&transfer_line(), &words), Ok(CoordinatorArrival::Command(_))), "{words}");
    }
    // What the topic refuses is refused by it here as well.
    let hand = words(SetModeRequest::HAND, "clamp_1").expect("words");
    assert!(command_of(&transfer_line(), &hand).is_err());
    for unknown in [0, 8, 255] {
        assert!(words(unknown, "").expect_err("no command").starts_with(&format!("unknown command {unknown}; ")));
    }
}

#[test]
fn the_latest_senders_of_refused_commands_are_counted() {
    let mut refusals = Refusals::default();
    (0..20).for_each(|sender| refusals.count_sender([sender; 12]));
    refusals.count_sender([10; 12]);
    let senders = refusals.senders();
    assert_eq!((senders.len(), senders[0].1), (16, 2));
    assert_eq!(senders[0].0, ["0a"; 12].join("."));
    assert!(senders.iter().all(|(sender, _)| *sender != ["00"; 12].join(".")), "the oldest is forgotten");
}
