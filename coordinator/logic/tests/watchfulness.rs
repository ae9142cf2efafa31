//! Events that the coordinator detects by itself: silence, restarts, higher epochs, a lost console, buttons that run
//! out.

use std::time::Duration;

use linewright_coordinator_logic::{Coordinator, ModeCommand, ModeInput, ModeOutbox, StationView};
use linewright_line::net::ControlMode;
use linewright_line::{Owner, StationId, Tick};

use crate::common::{CoordinatorBench, line};

/// The console's image with these of its inputs on.
fn console(names: &[&str]) -> ModeInput {
    let inputs = line().console.inputs;
    let bit = |name: &&str| 1u128 << inputs.iter().position(|input| input == name).expect("an input of the console");
    ModeInput::Console { bits: names.iter().map(bit).fold(0, |bits, bit| bits | bit), valid: true }
}

#[test]
fn a_mode_is_enabled_only_when_every_station_has_acknowledged_it() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::StandBy);
    bench.acknowledge = false;
    assert_eq!(bench.command(ModeCommand::Auto), None);
    for station in 0..3 {
        assert!(!bench.coordinator.order().enabled, "{station} stations have acknowledged");
        assert_eq!(bench.coordinator.waiting_for().len(), 3 - station);
        bench.heard[station].mode_epoch = bench.coordinator.epoch();
        bench.say(station);
    }
    assert!(bench.coordinator.order().enabled);
    assert!(bench.coordinator.waiting_for().is_empty());
}

#[test]
fn a_mode_that_enables_no_motion_waits_for_nobody() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.acknowledge = false;
    bench.command(ModeCommand::EStop);
    assert!(bench.coordinator.order().enabled);
}

#[test]
fn a_station_that_falls_silent_ends_auto_and_a_silent_line_ends_nothing_else() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.wait(Duration::from_millis(200));
    bench.say(0);
    bench.say(1);
    let deadline = bench.coordinator.next_deadline().expect("the mill's silence is watched");
    bench.wait(deadline.since(bench.now) - Duration::from_micros(1));
    assert_eq!(bench.mode(), ControlMode::Auto);
    bench.wait(Duration::from_micros(1));
    assert_eq!(bench.mode(), ControlMode::StandBy);
    assert!(bench.coordinator.text().contains("mill_1: no state received"), "{}", bench.coordinator.text());
}

#[test]
fn a_station_restarted_in_auto_or_hand_means_stand_by_until_somebody_has_looked() {
    for mode in [ControlMode::Auto, ControlMode::Hand] {
        let mut bench = CoordinatorBench::in_mode(mode);
        bench.heard[1].boot_id += 1;
        bench.beat();
        assert_eq!(bench.mode(), ControlMode::StandBy, "from {mode}");
        let refusal = bench.command(ModeCommand::Auto).expect("it was restarted");
        assert!(refusal.contains("clamp_1: restarted; give start, or select manual first"), "{refusal}");
        assert_eq!(bench.command(ModeCommand::Start), None);
        assert_eq!(bench.command(ModeCommand::Auto), None);
    }
}

/// The reason that has ended auto is none any more where manual has been gone through.
#[test]
fn a_restart_that_has_been_looked_at_in_manual_asks_for_no_start() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard[1].boot_id += 1;
    bench.beat();
    assert_eq!(bench.coordinator.standing().restarted, [StationId(1)]);
    for (selects, mode) in [(true, ControlMode::Manual), (false, ControlMode::StandBy)] {
        bench.heard[2].selector_manual = selects;
        bench.beat();
        assert_eq!(bench.mode(), mode);
    }
    let (text, restarted) = (bench.coordinator.text(), bench.coordinator.standing().restarted);
    assert!(!text.contains("restarted") && restarted.is_empty(), "{text}");
    assert_eq!(bench.command(ModeCommand::Auto), None);
}

#[test]
fn a_station_restarted_in_manual_has_somebody_standing_in_front_of_it() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    bench.heard[1].boot_id += 1;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Manual);
    assert_eq!(bench.command(ModeCommand::Auto), None, "and manual has been gone through");
    assert_eq!(bench.mode(), ControlMode::Auto);
}

#[test]
fn epochs_rise_above_everything_heard() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.acknowledge = false;
    bench.heard[0].mode_epoch = 900;
    bench.say(0);
    assert!(bench.coordinator.epoch() > 900);
    assert_eq!(bench.mode(), ControlMode::StandBy, "somebody else coordinated the line: nothing starts");
    assert!(CoordinatorBench::with_last_epoch(41).coordinator.epoch() > 41);
}

#[test]
fn a_higher_epoch_heard_in_manual_does_not_lead_back_into_manual() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    bench.heard[0].mode_epoch = 900;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
}

#[test]
fn the_greatest_epoch_there_is_does_not_end_the_coordinator() {
    let mut bench = CoordinatorBench::with_last_epoch(u64::MAX);
    bench.heard[0].mode_epoch = u64::MAX;
    bench.beat();
    bench.command(ModeCommand::Start);
    assert_eq!(bench.mode(), ControlMode::StandBy);
}

#[test]
fn a_console_that_is_lost_is_an_emergency_stop_and_must_be_back_before_the_reset() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.input(console(&[]));
    assert_eq!(bench.mode(), ControlMode::Auto);
    bench.input(ModeInput::Console { bits: 0, valid: false });
    assert_eq!(bench.mode(), ControlMode::EStop);
    let refusal = bench.command(ModeCommand::Reset).expect("the button cannot be heard");
    assert!(refusal.ends_with("console: I/O devices not operational"), "{refusal}");
    bench.input(console(&["ES_pressed"]));
    let refusal = bench.command(ModeCommand::Reset).expect("the button is in");
    assert!(refusal.ends_with("emergency stop button pressed; release it first"), "{refusal}");
    bench.input(console(&[]));
    assert_eq!(bench.command(ModeCommand::Reset), None);
    assert_eq!(bench.command(ModeCommand::Manual), None);
}

/// The mushroom button's contact opens when it is pressed, and so does a broken wire.
#[test]
fn a_closed_circuit_contact_is_pressed_while_it_is_off() {
    let mut described = line();
    let contact = described.console.estop.as_mut().expect("it has one");
    contact.pressed = false;
    let mut bench = CoordinatorBench::of(described, 0);
    assert_eq!(bench.command(ModeCommand::Start), None);
    assert_eq!(bench.command(ModeCommand::Auto), None);
    assert_eq!(bench.mode(), ControlMode::Auto);
    bench.input(console(&[]));
    assert_eq!(bench.mode(), ControlMode::EStop);
    let refusal = bench.command(ModeCommand::Reset).expect("the button is in");
    assert!(refusal.ends_with("emergency stop button pressed; release it first"), "{refusal}");
    bench.input(console(&["ES_pressed"]));
    assert_eq!(bench.command(ModeCommand::Reset), None);
}

/// Whether its emergency stop is pressed is unknown.
#[test]
fn nothing_is_enabled_before_a_described_console_was_heard() {
    for mode in [ModeCommand::Auto, ModeCommand::Hand, ModeCommand::Manual] {
        let mut bench = CoordinatorBench::of_unheard_console(line(), 0);
        assert_eq!(bench.command(ModeCommand::Start), None);
        let refusal = bench.command(mode).expect("the console is not heard");
        assert!(refusal.contains("no console input received yet"), "{refusal}");
        assert!(refusal.contains("check supply and bus"), "{refusal}");
        bench.input(ModeInput::Console { bits: 0, valid: false });
        assert!(bench.command(mode).is_some());
        bench.input(console(&[]));
        assert_eq!(bench.command(mode), None);
        assert!(bench.coordinator.order().enabled);
    }
}

/// A selector leads into manual without a command.
#[test]
fn a_selector_enables_nothing_before_a_described_console_was_heard() {
    let mut bench = CoordinatorBench::of_unheard_console(line(), 0);
    assert_eq!(bench.command(ModeCommand::Start), None);
    bench.heard[0].selector_manual = true;
    bench.beat();
    assert!(!bench.coordinator.order().enabled || !bench.mode().enables_motion(), "{}", bench.coordinator.text());
    bench.input(console(&[]));
    bench.beat();
    assert_eq!((bench.mode(), bench.coordinator.order().enabled), (ControlMode::Manual, true));
}

#[test]
fn an_emergency_stop_is_not_reset_before_a_described_console_was_heard() {
    let mut bench = CoordinatorBench::of_unheard_console(line(), 0);
    bench.command(ModeCommand::EStop);
    let refusal = bench.command(ModeCommand::Reset).expect("the button may be in");
    assert!(refusal.contains("no console input received yet"), "{refusal}");
}

#[test]
fn a_line_without_a_console_is_not_kept_from_moving() {
    let mut described = line();
    described.devices.retain(|device| device.owner != Owner::Console);
    described.console = linewright_line::Console::default();
    let mut bench = CoordinatorBench::of_unheard_console(described, 0);
    assert_eq!(bench.command(ModeCommand::Start), None);
    assert_eq!(bench.command(ModeCommand::Auto), None);
    assert!(bench.coordinator.order().enabled);
}

/// The finger may never have left it.
#[test]
fn a_wired_hand_button_that_is_down_when_the_console_comes_back_counts_when_it_was_up() {
    let mut described = line();
    // With an emergency stop, its loss would be one.
    described.console.estop = None;
    let mut bench = CoordinatorBench::of(described, 0);
    let button = bench.line.buttons[0].clone();
    bench.input(console(&[&button]));
    assert_eq!(bench.coordinator.order().buttons, 1);
    for _ in 0..2 {
        bench.input(ModeInput::Console { bits: 0, valid: false });
        assert_eq!(bench.coordinator.order().buttons, 0);
        bench.input(console(&[&button]));
        assert_eq!(bench.coordinator.order().buttons, 0);
        bench.input(console(&[&button, "PB_reset"]));
        assert_eq!(bench.coordinator.order().buttons, 0);
    }
    bench.input(console(&[]));
    bench.input(console(&[&button]));
    assert_eq!(bench.coordinator.order().buttons, 1);
}

#[test]
fn a_console_button_counts_when_it_is_pressed_not_when_it_is_found_down() {
    let mut bench = CoordinatorBench::of_unheard_console(line(), 0);
    bench.input(console(&["PB_start"]));
    assert_eq!(bench.mode(), ControlMode::Home, "it was down when the console came up");
    bench.input(console(&[]));
    bench.input(console(&["PB_start"]));
    assert_eq!(bench.mode(), ControlMode::StandBy);
    bench.beat();
    bench.input(console(&["PB_start", "PB_auto"]));
    assert_eq!(bench.mode(), ControlMode::Auto);
    bench.input(console(&["ES_pressed"]));
    assert_eq!(bench.mode(), ControlMode::EStop);
}

#[test]
fn lamps_show_the_mode_and_a_fault() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    let lamps = bench.line.console.lamps;
    let bit = |at: usize| 1 << lamps[at].expect("the shipped console has four lamps").0;
    assert_eq!(bench.out.lamps, bit(0));
    bench.heard[2].incomplete = true;
    bench.beat();
    assert_eq!(bench.out.lamps, bit(3), "a fault: no longer auto");
}

#[test]
fn held_buttons_run_out_and_a_late_refresh_is_no_new_press() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Hand);
    bench.input(ModeInput::Buttons(0b100));
    assert_eq!(bench.coordinator.order().buttons, 0b100);
    bench.out.changed = false;
    bench.wait(Duration::from_millis(250));
    assert_eq!(bench.coordinator.order().buttons, 0);
    for silence in [0, 750, 5000, 3_600_000] {
        bench.now = bench.now + Duration::from_millis(silence);
        bench.input(ModeInput::Buttons(0b100));
        assert_eq!(bench.coordinator.order().buttons, 0, "nobody has decided to go on, {silence} ms later");
    }
    bench.input(ModeInput::Buttons(0));
    bench.input(ModeInput::Buttons(0b100));
    assert_eq!(bench.coordinator.order().buttons, 0b100);
}

#[test]
fn a_report_of_a_station_that_is_not_there_is_ignored() {
    let mut bench = CoordinatorBench::new();
    bench.input(ModeInput::Station(StationId(99), StationView::default()));
    assert_eq!(bench.mode(), ControlMode::Home);
}

#[test]
fn a_coordinator_that_has_heard_nobody_stays_where_nothing_moves() {
    let mut coordinator = Coordinator::new(line(), 1, 0);
    let mut out = ModeOutbox::default();
    for command in [ModeCommand::Start, ModeCommand::Auto, ModeCommand::Hand, ModeCommand::Manual] {
        coordinator.handle(Tick::from_millis(5), ModeInput::Command(command));
        coordinator.step(Tick::from_millis(5), &mut out);
    }
    assert_eq!(coordinator.mode(), ControlMode::StandBy);
    assert_eq!(out.refusals.len(), 3);
    assert!(out.refusals.iter().all(|refusal| refusal.text(&line()).contains("transfer: no state received")));
}

/// A station that was last received at home may have begun its next round before it received the stop.
#[test]
fn home_is_reached_only_when_every_station_has_heard_of_the_stop() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.acknowledge = false;
    assert_eq!(bench.command(ModeCommand::Stop), None);
    assert_eq!(bench.mode(), ControlMode::Auto, "all are at home, as far as anybody knows");
    assert!(bench.coordinator.order().enabled, "and go on meanwhile");
    // The bar had begun: the others have to follow it.
    bench.heard[0] = StationView { at_home: false, stopped: false, round: 1, ..bench.heard[0] };
    bench.say(0);
    assert_eq!(bench.coordinator.order().master_stop, Some(1));
    bench.acknowledge = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Auto);
    for heard in &mut bench.heard {
        *heard = StationView { at_home: true, stopped: true, round: 1, ..*heard };
    }
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Home);
}

/// The same for stand-by: a station may have begun what it was ordered in auto since it was last received.
#[test]
fn in_stand_by_a_station_stands_only_when_it_has_heard_of_it() {
    for command in [ModeCommand::Stop, ModeCommand::Hand] {
        let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
        bench.acknowledge = false;
        bench.heard[1].devices_valid = false;
        bench.say(1);
        assert_eq!(bench.mode(), ControlMode::StandBy);
        bench.heard[1].devices_valid = true;
        bench.say(1);
        let refusal = bench.command(command).expect("nobody has heard of stand-by");
        assert!(refusal.contains("transfer: stand-by not acknowledged yet"), "{refusal}");
        bench.acknowledge = true;
        bench.beat();
        assert_eq!(bench.command(command), None);
        assert_ne!(bench.mode(), ControlMode::StandBy);
    }
}

#[test]
fn manual_is_entered_as_soon_as_every_station_has_heard_of_stand_by() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.acknowledge = false;
    bench.heard[1].devices_valid = false;
    bench.say(1);
    assert_eq!(bench.command(ModeCommand::Manual), None);
    assert_eq!(bench.mode(), ControlMode::StandBy);
    // One of them had begun to move.
    bench.heard[0] = StationView { stopped: false, mode_epoch: bench.coordinator.epoch(), ..bench.heard[0] };
    bench.acknowledge = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
    bench.heard[0].stopped = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Manual);
}

/// A station that is lost after the command comes back when a person may have turned away.
#[test]
fn a_manual_that_waits_for_half_a_minute_is_given_up_and_does_not_come_late() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.acknowledge = false;
    bench.heard[1].devices_valid = false;
    bench.say(1);
    assert_eq!(bench.command(ModeCommand::Manual), None);
    bench.out.refusals.clear();
    // From now on the second station is not heard.
    let lost_at = bench.now;
    let beat_of_others = |bench: &mut CoordinatorBench, ms: u64| {
        bench.wait(Duration::from_millis(ms));
        for at in [0, 2] {
            bench.heard[at].mode_epoch = bench.coordinator.epoch();
            bench.say(at);
        }
    };
    while bench.now < lost_at + Duration::from_millis(29_900) {
        beat_of_others(&mut bench, 100);
    }
    assert!(bench.out.refusals.is_empty(), "it may still come");
    assert!(bench.coordinator.next_deadline().is_some());
    beat_of_others(&mut bench, 100);
    let texts: Vec<String> = bench.out.refusals.iter().map(|refusal| refusal.text(&bench.line)).collect();
    assert_eq!(
        texts,
        ["manual refused in stand-by: clamp_1: no state received; given up after 30 s: command it again"]
    );
    bench.acknowledge = true;
    bench.heard[1].devices_valid = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
    assert_eq!(bench.command(ModeCommand::Manual), None);
    assert_eq!(bench.mode(), ControlMode::Manual);
    bench.wait(Duration::from_secs(60));
    assert_eq!((bench.mode(), bench.out.refusals.len()), (ControlMode::Manual, 0), "what was reached stays");
}

/// At a start no device is lost: none was there before. The same once the station has been started anew.
#[test]
fn devices_that_were_not_there_yet_are_not_lost() {
    const AWAITED: &str = "clamp_1: I/O devices not operational yet; after 10 s check supply and bus";
    let mut bench = CoordinatorBench::in_mode(ControlMode::StandBy);
    bench.heard[1].devices_valid = false;
    bench.beat();
    assert!(bench.coordinator.text().contains("clamp_1: I/O devices lost"), "{}", bench.coordinator.text());
    bench.heard[1].boot_id += 100;
    bench.beat();
    let text = bench.coordinator.text();
    assert!(text.contains(AWAITED) && !text.contains("lost"), "{text}");
    bench.heard[1].devices_valid = true;
    bench.beat();
    bench.heard[1].devices_valid = false;
    bench.beat();
    assert!(bench.coordinator.text().contains("clamp_1: I/O devices lost"), "{}", bench.coordinator.text());
}

#[test]
fn why_auto_ended_by_itself_is_said_until_the_next_command() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard[1].devices_valid = false;
    bench.beat();
    assert_eq!(bench.coordinator.text(), "stand-by: clamp_1: I/O devices lost");
    bench.heard[1].devices_valid = true;
    bench.beat();
    let ended = "stand-by, auto ended (clamp_1: I/O devices lost)";
    assert_eq!(bench.coordinator.text(), ended);
    assert!(bench.command(ModeCommand::Start).is_some());
    assert_eq!(bench.coordinator.text(), ended, "what is refused is no command");
    assert_eq!(bench.command(ModeCommand::Manual), None);
    assert_eq!(bench.coordinator.text(), "manual");
}

#[test]
fn the_cause_of_an_emergency_stop_is_kept_until_it_is_reset_and_no_older_one_is_shown() {
    use linewright_coordinator_logic::EStopCause;
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard[1].devices_valid = false;
    bench.beat();
    bench.heard[1].devices_valid = true;
    bench.beat();
    assert!(bench.coordinator.text().contains("auto ended"), "{}", bench.coordinator.text());
    let at = bench.now;
    let bits = bench.line.console.estop.filter(|contact| !contact.pressed).map_or(0, |contact| 1 << contact.input.0);
    bench.input(ModeInput::Console { bits, valid: false });
    bench.wait(Duration::from_millis(50));
    bench.command(ModeCommand::EStop);
    assert_eq!(bench.coordinator.stop_cause(), Some((EStopCause::ConsoleLost, at)), "the first one");
    bench.input(ModeInput::Console { bits, valid: true });
    let text = "e-stop (console lost: its I/O devices were not operational), not reset; give reset, then manual";
    assert_eq!(bench.coordinator.text(), text, "also when the console is back");
    assert!(bench.coordinator.text_with("20:06:29").starts_with("e-stop since 20:06:29 (console lost"));
    bench.command(ModeCommand::Reset);
    assert_eq!(
        (bench.coordinator.stop_cause(), bench.coordinator.text().as_str()),
        (None, "e-stop, reset; select manual")
    );

    // The button by its name.
    let contact = bench.line.console.estop.expect("the line has one");
    bench.input(ModeInput::Console { bits: if contact.pressed { 1 << contact.input.0 } else { 0 }, valid: true });
    let name = bench.line.console.inputs[usize::from(contact.input.0)].clone();
    let expected = format!("e-stop (button {name} of the console pressed), not reset");
    let text = bench.coordinator.text();
    assert_eq!(text, format!("{expected}; release the emergency stop button, then give reset, then manual"));
    bench.input(ModeInput::Console { bits, valid: true });
    let text = bench.coordinator.text();
    assert_eq!(
        text,
        format!("e-stop (button {name} of the console pressed), button released, not reset; give reset, then manual")
    );
    // And a successor knows that it was there before.
    let coordinator = Coordinator::new(bench.line.clone(), 2, 9).with_estop();
    assert_eq!(coordinator.stop_cause().map(|(cause, _)| cause), Some(EStopCause::Restarted));
}

/// At home nothing depends on it, and start leads to manual.
#[test]
fn a_selector_at_manual_is_in_the_text_of_a_line_at_home() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Home);
    assert_eq!(bench.coordinator.text(), "home");
    bench.heard[1].selector_manual = true;
    bench.beat();
    assert_eq!(bench.coordinator.text(), "home: clamp_1: selector at manual");
}

#[test]
fn auto_is_refused_while_the_line_stops_with_what_takes_the_stop_back() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.heard[2].at_home = false;
    bench.beat();
    bench.command(ModeCommand::Stop);
    let refused = bench.command(ModeCommand::Auto).expect("it is refused");
    assert_eq!(refused, "auto refused in auto: stopping at home; give start to take the stop back");
    assert_eq!(bench.command(ModeCommand::Start), None);
    assert_eq!(bench.coordinator.text(), "auto");
}
