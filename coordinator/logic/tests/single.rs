//! Manual of one station of a cell, while the others are in auto.

use linewright_coordinator_logic::{ManualPermit, ModeCommand, ModeInput, StationView};
use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};

use crate::common::CoordinatorBench;

const ROBOT: StationId = StationId(1);
/// It stands in the one task that its failed activity has.
const LEFT_OUT: ManualPermit = ManualPermit::LeftOut { tasks: 1, kept_in: Some(0) };

/// The line in auto, one station left out between two rests.
fn bench() -> CoordinatorBench {
    let mut bench = CoordinatorBench::with_one_task_driven();
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        assert_eq!(bench.command(command), None);
    }
    bench.coordinator.isolate(|id, _| id == ROBOT);
    let robot = &mut bench.heard[1];
    (robot.at_home, robot.incomplete, robot.stands_in) = (false, true, Some(OpId(0)));
    bench.permit(LEFT_OUT);
    bench
}

impl CoordinatorBench {
    fn permit(&mut self, permit: ManualPermit) {
        self.permit = Some(permit);
        self.beat();
    }

    fn single(&mut self, is_manual: bool) -> Option<String> {
        self.out.refusals.clear();
        self.input(ModeInput::Single(ROBOT, is_manual));
        let refusal = self.out.refusals.first().map(|refusal| refusal.text(&self.line));
        self.beat();
        refusal
    }

    /// Single, and led.
    fn states(&self) -> (bool, bool) {
        (self.coordinator.is_single(ROBOT), self.coordinator.is_led(ROBOT))
    }
}

/// In manual by itself.
fn led() -> CoordinatorBench {
    let mut bench = bench();
    assert_eq!((bench.single(true), bench.states()), (None, (true, true)));
    bench
}

const FOLLOWS: (bool, bool) = (false, false);
const STANDS_BY: (bool, bool) = (true, false);
const LED: (bool, bool) = (true, true);

#[test]
fn the_others_go_on_and_each_change_has_an_epoch_that_all_acknowledge() {
    let mut bench = bench();
    let epoch = bench.coordinator.epoch();
    bench.acknowledge = false;
    assert_eq!(bench.single(true), None);
    assert_eq!((bench.coordinator.epoch(), bench.states()), (epoch + 1, STANDS_BY));
    // The station alone has acknowledged; then all but the station.
    bench.heard[1].mode_epoch = epoch + 1;
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
    (bench.heard[0].mode_epoch, bench.heard[2].mode_epoch) = (epoch + 1, epoch + 1);
    bench.heard[1].mode_epoch = epoch;
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
    bench.heard[1].mode_epoch = epoch + 1;
    bench.beat();
    assert_eq!(
        (bench.states(), bench.coordinator.text().as_str()),
        (LED, "auto, clamp_1 in manual. Left out: clamp_1")
    );
    assert!(bench.coordinator.order().enabled && bench.mode() == ControlMode::Auto);
    assert_eq!(bench.single(true).as_deref(), Some("manual of clamp_1 refused in auto: mode already in force"));
    assert_eq!((bench.single(false), bench.states()), (None, FOLLOWS));
    assert_eq!(bench.coordinator.epoch(), epoch + 2);
    assert!(bench.single(false).is_some_and(|refusal| refusal.contains("not in manual by itself")));
}

/// An acknowledgement of another coordinator's epoch is none.
#[test]
fn a_station_that_follows_another_coordinator_is_not_led() {
    let mut bench = led();
    bench.heard[1].follows = 23;
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
}

#[test]
fn what_the_cell_does_not_permit_is_refused_with_its_reason() {
    for (permit, expected) in [
        (ManualPermit::InService, "takes part in auto"),
        (ManualPermit::Securing, "come to rest"),
        (ManualPermit::Unattended, "log of the cell"),
        (ManualPermit::LeftOut { tasks: 0, kept_in: Some(0) }, "no failed activity"),
        (ManualPermit::LeftOut { tasks: !1, kept_in: Some(0) }, "no failed activity"),
    ] {
        let mut bench = bench();
        bench.permit(permit);
        let epoch = bench.coordinator.epoch();
        let refusal = bench.single(true).expect("it is refused");
        assert!(refusal.starts_with("manual of clamp_1 refused in auto: clamp_1: "), "{refusal}");
        assert!(refusal.contains(expected), "{refusal}");
        assert_eq!((bench.states(), bench.coordinator.epoch()), (FOLLOWS, epoch));
        // Nor does its panel go on acting where that was permitted before; and it does not go over to auto by itself.
        let mut bench = led();
        bench.permit(permit);
        assert_eq!(bench.states(), STANDS_BY, "{permit:?}");
        let text = bench.coordinator.text();
        assert!(text.contains("clamp_1 in manual without effect (clamp_1: ") && text.contains(expected), "{text}");
        bench.permit(LEFT_OUT);
        assert_eq!(bench.states(), LED);
    }
}

/// Where a task has ended nothing is moved, in whichever it was. Where one was taken back to its beginning it is at a rest too, and
/// *advance* would begin it again.
#[test]
fn where_a_task_has_ended_it_needs_none_that_has_failed() {
    let mut bench = bench();
    (bench.heard[1].at_home, bench.heard[1].stands_in) = (true, None);
    bench.permit(ManualPermit::LeftOut { tasks: 0, kept_in: Some(0) });
    assert_eq!((bench.single(true), bench.states()), (None, LED));
    bench.heard[1].stands_in = Some(OpId(0));
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
    // Between two rests, at no place that is known.
    (bench.heard[1].at_home, bench.heard[1].stands_in) = (false, None);
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
}

/// Before the cell has taken it, it might close the activity that keeps the others away.
#[test]
fn its_panel_acts_when_the_cell_has_taken_it() {
    let mut bench = bench();
    bench.permit(ManualPermit::LeftOut { tasks: 1, kept_in: None });
    assert_eq!((bench.single(true), bench.states()), (None, STANDS_BY));
    bench.permit(LEFT_OUT);
    assert_eq!(bench.states(), LED);
}

/// A permit that the cell gave in an earlier period of manual does not enable the panel: between two periods the cell may have started other
/// activities.
#[test]
fn what_the_cell_has_taken_of_an_earlier_time_does_not_count() {
    let mut bench = led();
    let first = bench.coordinator.single_epoch(ROBOT);
    assert_eq!(bench.single(false), None);
    bench.permit = None;
    let of = |epoch| move |_| Some(ManualPermit::LeftOut { tasks: 1, kept_in: Some(epoch) });
    bench.coordinator.permit_manual(of(first));
    assert_eq!((bench.single(true), bench.states()), (None, STANDS_BY));
    let second = bench.coordinator.single_epoch(ROBOT);
    assert!(second > first);
    bench.coordinator.permit_manual(of(second));
    bench.beat();
    assert_eq!(bench.states(), LED);
}

/// The cell is to know it in manual until it has acknowledged that it is no more, or its last order has run out.
#[test]
fn it_is_by_hand_until_it_has_acknowledged_the_end() {
    let ends: [fn(&mut CoordinatorBench); 2] =
        [|bench| _ = bench.single(false), |bench| _ = bench.command(ModeCommand::EStop)];
    for end in ends {
        let mut bench = led();
        bench.acknowledge = false;
        end(&mut bench);
        assert_eq!(bench.states(), FOLLOWS);
        assert!(bench.coordinator.is_by_hand(ROBOT));
        bench.acknowledge = true;
        bench.beat();
        assert!(!bench.coordinator.is_by_hand(ROBOT));
    }
    let mut bench = led();
    bench.acknowledge = false;
    bench.single(false);
    let timing = bench.line.timing;
    bench.wait(timing.lease + timing.stale - std::time::Duration::from_millis(1));
    assert!(bench.coordinator.is_by_hand(ROBOT), "it may have the order still");
    bench.wait(std::time::Duration::from_millis(1));
    assert!(!bench.coordinator.is_by_hand(ROBOT));
}

#[test]
fn a_line_without_a_cell_has_one_mode() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Auto);
    bench.coordinator.permit_manual(|_| Some(LEFT_OUT));
    let refusal = bench.single(true).expect("not task-driven");
    assert!(refusal.contains("in a cell only; the stations of a line"), "{refusal}");
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, FOLLOWS));
}

#[test]
fn beside_another_mode_than_auto_there_is_none() {
    for (mode, expected) in [
        (ModeCommand::Stop, "while the others are in auto only"),
        (ModeCommand::Manual, "mode already in force"),
        (ModeCommand::EStop, "emergency stop active"),
    ] {
        let mut bench = bench();
        if mode == ModeCommand::Manual {
            bench.command(ModeCommand::Stop);
        }
        assert_eq!(bench.command(mode), None);
        assert_ne!(bench.mode(), ControlMode::Auto);
        let refusal = bench.single(true).expect("refused");
        assert!(refusal.contains(expected), "{refusal}");
        let refusal = bench.single(false).expect("refused");
        assert!(refusal.contains("follows the mode of the line"), "{refusal}");
    }
}

type EndsAuto = fn(&mut CoordinatorBench);

/// Whatever ends auto ends it, at once, and it does not come back with auto.
#[test]
fn it_ends_with_auto() {
    let ends: [(&str, EndsAuto); 4] = [
        ("stop", |bench| _ = bench.command(ModeCommand::Stop)),
        ("estop", |bench| _ = bench.command(ModeCommand::EStop)),
        ("trouble", |bench| bench.heard[0].incomplete = true),
        ("selector", |bench| bench.heard[2].selector_manual = true),
    ];
    for (what, end) in ends {
        let mut bench = led();
        end(&mut bench);
        bench.beat();
        assert_ne!(bench.mode(), ControlMode::Auto, "{what}");
        assert_eq!(bench.states(), FOLLOWS, "{what}");
    }
    let mut bench = led();
    bench.command(ModeCommand::Stop);
    assert_eq!((bench.command(ModeCommand::Auto), bench.mode(), bench.states()), (None, ControlMode::Auto, FOLLOWS));
}

#[test]
fn a_second_coordinator_and_a_station_that_is_not_heard_end_the_motion_alone() {
    let mut bench = led();
    bench.input(ModeInput::Rival(23, bench.now + bench.line.timing.stale));
    assert_ne!(bench.mode(), ControlMode::Auto);
    assert_eq!(bench.states(), FOLLOWS);

    let mut bench = led();
    for _ in 0..4 {
        bench.now = bench.now + bench.line.timing.stale / 2;
        [0, 2].into_iter().for_each(|station| bench.say(station));
    }
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, STANDS_BY));
    // Restarted meanwhile it is led again; its buttons have to be released first, which is the station's own rule.
    bench.heard[1] = StationView { boot_id: 99, ..bench.heard[1] };
    bench.beat();
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, LED));
}

/// Put into emergency stop by its cell it is in that, and in nothing else afterwards.
#[test]
fn an_emergency_stop_of_its_own_ends_it() {
    let mut bench = led();
    bench.coordinator.stop_alone(|id| id == ROBOT);
    bench.heard[1].estopped = true;
    bench.beat();
    assert_eq!((bench.states(), bench.coordinator.is_stopped(ROBOT)), (FOLLOWS, true));
    assert!(bench.single(true).is_some_and(|refusal| refusal.contains("in emergency stop")));
    bench.coordinator.stop_alone(|_| false);
    bench.heard[1].estopped = false;
    bench.beat();
    assert_eq!(bench.states(), FOLLOWS);
}

/// The selector of a station that is left out is the same request. It stays in force until the selector is turned back.
#[test]
fn its_selector_requests_it_too() {
    let mut bench = bench();
    bench.heard[1].selector_manual = true;
    bench.beat();
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, LED));
    let refusal = bench.single(false).expect("the selector is against it");
    assert!(refusal.contains("selector at manual"), "{refusal}");
    bench.heard[1].selector_manual = false;
    bench.beat();
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, FOLLOWS));

    // Where it is not permitted it has no effect, and the text says why; nor does it stop the others.
    bench.permit(ManualPermit::Securing);
    bench.heard[1].selector_manual = true;
    bench.beat();
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, FOLLOWS));
    let text = bench.coordinator.text();
    assert!(text.contains("selector of clamp_1 at manual without effect (clamp_1: stations of its"), "{text}");
    // A station that takes part in auto leads the line to stand-by, as ever.
    bench.permit(LEFT_OUT);
    bench.heard[1].selector_manual = false;
    bench.beat();
    bench.heard[2].selector_manual = true;
    bench.beat();
    assert_ne!(bench.mode(), ControlMode::Auto);
}

/// A selector counts as turned back only by a report of the same life of the station, with a valid input image.
#[test]
fn a_selector_that_is_unknown_is_not_turned_back() {
    let by_selector = || {
        let mut bench = bench();
        bench.heard[1].selector_manual = true;
        bench.beat();
        assert_eq!(bench.states(), LED);
        bench.heard[1].selector_manual = false;
        bench
    };
    let mut bench = by_selector();
    bench.heard[1].devices_valid = false;
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
    bench.heard[1].devices_valid = true;
    bench.beat();
    assert_eq!(bench.states(), FOLLOWS, "turned back, as its inputs show");

    let mut bench = by_selector();
    bench.heard[1].boot_id = 99;
    bench.beat();
    assert_eq!(bench.states(), STANDS_BY);
    let text = bench.coordinator.text();
    assert!(text.contains("clamp_1: selector not at manual, or unknown since a restart; give auto"), "{text}");
    // By what is known: the selector, a command for manual, one for auto.
    let mut again = bench;
    again.heard[1].selector_manual = true;
    again.beat();
    assert_eq!(again.states(), LED);
    again.heard[1].selector_manual = false;
    again.beat();
    assert_eq!(again.states(), FOLLOWS);
    for (is_manual, expected) in [(true, LED), (false, FOLLOWS)] {
        let mut bench = by_selector();
        bench.heard[1].boot_id = 99;
        bench.beat();
        assert_eq!((bench.single(is_manual), bench.states()), (None, expected));
    }
}

/// Turned back while auto for it is refused it stays, and what was refused does not take effect later.
#[test]
fn a_selector_turned_back_is_judged_as_the_command_is() {
    let mut bench = bench();
    bench.heard[1].selector_manual = true;
    bench.beat();
    bench.coordinator.isolate(|_, _| false);
    bench.permit(ManualPermit::InService);
    bench.heard[1].selector_manual = false;
    bench.beat();
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, STANDS_BY));
    (bench.heard[1].incomplete, bench.heard[1].at_home) = (false, true);
    bench.beat();
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, STANDS_BY));
    assert_eq!((bench.single(false), bench.mode(), bench.states()), (None, ControlMode::Auto, FOLLOWS));
}

/// While the panel of a station in manual has no effect, the text of the mode names the conditions that are missing.
#[test]
fn the_text_says_what_the_panel_waits_for() {
    let mut bench = bench();
    bench.acknowledge = false;
    bench.single(true);
    let text = bench.coordinator.text();
    assert!(text.contains("clamp_1 in manual without effect (transfer: manual not acknowledged yet; "), "{text}");
    bench.acknowledge = true;
    bench.permit = None;
    bench.coordinator.permit_manual(|_| Some(ManualPermit::LeftOut { tasks: 1, kept_in: None }));
    bench.beat();
    let text = bench.coordinator.text();
    assert!(text.contains("in manual without effect (clamp_1: the cell has not acknowledged manual yet)"), "{text}");
}

/// Manual of one station is none of another's: neither its beginning nor its end stops what is led there.
#[test]
fn two_stations_are_in_manual_independently() {
    const OTHER: StationId = StationId(2);
    let mut bench = CoordinatorBench::with_task_driven(&[1, 2]);
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        assert_eq!(bench.command(command), None);
    }
    bench.coordinator.isolate(|id, _| id == ROBOT || id == OTHER);
    for heard in &mut bench.heard[1..] {
        (heard.at_home, heard.incomplete, heard.stands_in) = (false, true, Some(OpId(0)));
    }
    bench.permit(LEFT_OUT);
    assert_eq!((bench.single(true), bench.states()), (None, LED));
    for is_manual in [true, false] {
        bench.acknowledge = false;
        bench.input(ModeInput::Single(OTHER, is_manual));
        bench.beat();
        assert_eq!(bench.coordinator.is_single(OTHER), is_manual);
        assert_eq!((bench.states(), bench.coordinator.is_led(OTHER)), (LED, false));
        bench.acknowledge = true;
        bench.beat();
        assert_eq!((bench.states(), bench.coordinator.is_led(OTHER)), (LED, is_manual));
    }
}

/// In service again by its cell it is still in manual, and auto for it is refused while it would end auto for all.
#[test]
fn it_goes_back_to_auto_by_command_only_and_in_order() {
    let mut bench = led();
    bench.coordinator.isolate(|_, _| false);
    bench.permit(ManualPermit::InService);
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Auto, STANDS_BY));
    bench.coordinator.hold(|id| id == ROBOT);
    let refusal = bench.single(false).expect("it is incomplete");
    assert!(refusal.contains("operation incomplete") && refusal.contains("between two rests"), "{refusal}");
    bench.coordinator.hold(|_| false);
    (bench.heard[1].incomplete, bench.heard[1].at_home) = (false, true);
    bench.beat();
    assert_eq!((bench.single(false), bench.mode(), bench.states()), (None, ControlMode::Auto, FOLLOWS));
}

/// A coordinator that comes up anew knows of none: the station follows its mode, in which nothing moves.
#[test]
fn a_coordinator_that_is_started_again_begins_without() {
    let mut bench = CoordinatorBench::with_one_task_driven();
    bench.coordinator.isolate(|id, _| id == ROBOT);
    bench.permit(LEFT_OUT);
    assert_eq!((bench.mode(), bench.states()), (ControlMode::Home, FOLLOWS));
}
