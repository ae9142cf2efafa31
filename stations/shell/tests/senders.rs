//! Senders whose orders for tasks a station takes.

use linewright_line::net::ControlMode;
use linewright_line::{StationId, TaskOrderSource};
use linewright_station_logic::Restore;
use linewright_station_shell::StationShell;

use crate::rig::{FOLLOWED, LIFE, OTHER, Rig, sender_of};

fn takes(rig: &Rig) -> [bool; 2] {
    [FOLLOWED, OTHER].map(|life| rig.shell.takes_tasks_of(sender_of(life)))
}

/// The followed coordinator is silent for so long that another life may be followed. The station goes on without a gap.
fn coordinator_falls_silent(rig: &mut Rig) {
    let until = rig.now + rig.timing().stale * 2;
    while rig.now < until {
        rig.now = rig.now + rig.timing().refresh;
        rig.act();
    }
}

#[test]
fn before_any_order_of_a_coordinator_no_sender_is_taken() {
    let mut rig = Rig::new();
    rig.restart();
    assert_eq!(takes(&rig), [false, false]);
}

#[test]
fn the_sender_of_the_mode_that_is_followed_is_taken_alone() {
    let mut rig = Rig::new();
    assert_eq!(takes(&rig), [true, false]);
    // Not followed: of another life while the present one is fresh, of an older epoch, for another life of the station.
    rig.order(OTHER, 9, ControlMode::Manual);
    assert_eq!(takes(&rig), [true, false], "another coordinator");
    rig.sequence += 1;
    rig.order_to(LIFE + 1, rig.sequence, (OTHER, 9, ControlMode::Manual));
    assert_eq!(takes(&rig), [true, false], "not for this start");
    coordinator_falls_silent(&mut rig);
    rig.order(OTHER, 3, ControlMode::Manual);
    assert_eq!(takes(&rig), [true, false], "an epoch that is over");
    rig.order(OTHER, 3, ControlMode::EStop);
    rig.act();
    assert_eq!(rig.mode(), ControlMode::EStop);
    assert_eq!(takes(&rig), [true, false], "a stop that is obeyed and not followed");
}

#[test]
fn a_coordinator_that_was_started_again_is_taken_once_its_mode_is_followed() {
    let mut rig = Rig::new();
    coordinator_falls_silent(&mut rig);
    rig.order(OTHER, 9, ControlMode::Manual);
    assert_eq!(takes(&rig), [false, true]);
}

#[test]
fn any_sender_is_taken_where_the_description_says_so() {
    let mut rig = Rig::new();
    let station = StationId(1);
    rig.line.stations[station.index()].order_source = TaskOrderSource::Any;
    rig.shell = StationShell::new(&rig.line, station, LIFE, Restore::Fresh).expect("it compiles");
    assert_eq!(takes(&rig), [true, true]);
}
