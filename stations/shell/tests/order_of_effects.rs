//! Order of effects: records before outputs, and those before messages.

use linewright_line::net::ControlMode;
use linewright_station_logic::HappeningKind;
use linewright_station_shell::StationEffect;

use crate::rig::{FOLLOWED, Rig};

#[test]
fn a_motion_begins_when_its_record_is_written_and_is_told_after_that() {
    let mut rig = Rig::new();
    rig.refresh(5, ControlMode::Manual);
    rig.advance(false);
    rig.act();
    rig.effects.clear();
    rig.refresh(5, ControlMode::Manual);
    rig.act();
    assert_eq!(rig.kinds(), ["remember", "on", "tell"]);
}

#[test]
fn the_emergency_stop_turns_outputs_off_before_its_record_is_written() {
    let mut rig = Rig::new();
    rig.close();
    rig.order(FOLLOWED, 6, ControlMode::EStop);
    rig.act();
    assert_eq!(rig.kinds(), ["off", "remember", "tell"]);
}

#[test]
fn a_loss_of_devices_between_two_images_is_seen() {
    let mut rig = Rig::new();
    rig.close();
    rig.lives += 1;
    rig.inputs(false);
    rig.act();
    let lost = StationEffect::Happened(linewright_station_logic::StationHappening {
        cycle: 1,
        what: HappeningKind::Devices(false),
    });
    assert!(rig.effects.contains(&lost), "{:?}", rig.effects);
    assert!(rig.shell.controller().marking().any(|place| place.is_incomplete()));
    assert_eq!(rig.driven().map(|image| (rig.motion(image.bits), image.lives)), Some((0, rig.lives)));
}

#[test]
fn what_is_ignored_is_told_the_first_second_fourth_and_eighth_time() {
    let mut rig = Rig::new();
    for _ in 0..9 {
        rig.shell.ignore("it is rubbish", &mut rig.effects);
    }
    let count = |effect: &StationEffect| match effect {
        StationEffect::Ignored { count, .. } => Some(*count),
        _ => None,
    };
    assert_eq!(rig.effects.iter().filter_map(count).collect::<Vec<_>>(), [1, 2, 4, 8]);
}

#[test]
fn a_motion_is_switched_off_before_its_record_is_written() {
    let mut rig = Rig::new();
    rig.close();
    rig.advance(false);
    rig.act();
    assert_eq!(rig.kinds()[..2], ["off", "remember"]);
    assert!(rig.shell.controller().marking().any(|place| place.is_incomplete()));
}

/// The disk takes long for the record of a motion that is to begin.
#[test]
fn after_a_slow_record_nothing_is_switched_on_by_what_was_decided_before_it() {
    for (late, begins) in [(std::time::Duration::from_millis(1), true), (std::time::Duration::from_secs(1), false)] {
        let mut rig = Rig::new();
        rig.refresh(5, ControlMode::Manual);
        rig.advance(false);
        rig.act();
        rig.refresh(5, ControlMode::Manual);
        rig.effects.clear();
        rig.act();
        assert_eq!(rig.kinds(), ["remember", "on", "tell"]);
        assert!(rig.shell.remembered(rig.now), "a record that takes no time changes nothing");
        rig.stand_still(rig.timing().refresh + late);
        assert!(!rig.shell.remembered(rig.now), "its image is not to be put out");
        assert!(rig.shell.next_deadline() <= rig.now, "it is to act at once");
        rig.effects.clear();
        rig.act();
        // Within the age of received state the motion begins by what holds now; after it, by nothing.
        assert_eq!(rig.kinds().contains(&"on"), begins, "{late:?}: {:?}", rig.kinds());
        assert!(rig.kinds().iter().any(|kind| ["on", "off"].contains(kind)), "the image is given again");
    }
}

/// While the record of a motion that is to begin is being written, and of one that runs, everything is turned off.
#[test]
fn what_is_turned_off_while_a_record_is_written_stays_off_until_it_is_decided_again() {
    for stops in [false, true] {
        let mut rig = Rig::new();
        rig.close();
        let off = rig.shell.interrupt();
        assert_eq!(off.bits, 0);
        assert!(!rig.shell.remembered(rig.now), "nothing is put out that was decided before");
        assert!(rig.shell.next_deadline() <= rig.now, "it is to act at once");
        rig.effects.clear();
        if stops {
            rig.order(FOLLOWED, 6, ControlMode::EStop);
        }
        rig.act();
        assert_eq!(rig.kinds().contains(&"on"), !stops, "{:?}", rig.kinds());
        // The motion goes on under the number that it had, since nothing else began meanwhile.
        assert!(stops || rig.driven().is_some_and(|image| image.number == off.number));
        assert!(rig.shell.remembered(rig.now));
    }
}
