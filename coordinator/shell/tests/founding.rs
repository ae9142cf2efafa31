//! Founding a generation: by a command while all stand at home, and given up where a station cannot take it.

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::CoordinatorRecord;
use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::rig::Rig;

/// All at home, none with a generation; *start* has just been given.
fn begun() -> Rig {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.heard.iter_mut().for_each(|heard| heard.generation = 0);
    rig.refresh();
    rig.command(ModeCommand::Start);
    rig.refresh();
    assert!(rig.shell.coordinator().founding().is_some());
    rig
}

#[test]
fn it_ends_when_all_have_taken_it() {
    let mut rig = begun();
    let order = rig.shell.order_for(StationId(1));
    let generation = order.found.expect("begun");
    assert_eq!((order.station_life, Some(generation)), (rig.heard[1].boot_id, rig.shell.coordinator().founding()));
    rig.heard.iter_mut().for_each(|heard| heard.generation = generation);
    rig.refresh();
    assert_eq!(rig.shell.coordinator().founding(), None);
    rig.command(ModeCommand::Auto);
    rig.refresh();
    rig.refresh();
    assert!(rig.shell.order().enabled && rig.mode() == ControlMode::Auto, "{}", rig.shell.coordinator().text());
}

/// A life that was not seen at home is never named together with the generation.
#[test]
fn a_station_restarted_meanwhile_ends_it() {
    let mut rig = begun();
    let (before, after) = (rig.heard[1].boot_id, rig.heard[1].boot_id + 1);
    rig.heard[1].boot_id = after;
    let mut named = Vec::new();
    for _ in 0..8 {
        rig.refresh();
        let order = rig.shell.order_for(StationId(1));
        assert!(order.found.is_none() || order.station_life == before, "{order:?}");
        named.push(order.station_life);
    }
    assert_eq!((named.first(), named.last()), (Some(&before), Some(&after)));
}

#[test]
fn a_station_that_cannot_take_it_does_not_keep_manual_mode_disabled() {
    let faults: [fn(&mut Rig); 3] = [
        |rig| rig.heard[1].position_lost = true,
        |rig| rig.heard[1].devices_valid = false,
        |rig| rig.heard[1].at_home = false,
    ];
    for (nth, fault) in faults.into_iter().enumerate() {
        let mut rig = begun();
        fault(&mut rig);
        rig.refresh();
        rig.command(ModeCommand::Manual);
        rig.refresh();
        rig.refresh();
        assert!(
            rig.shell.order().enabled && rig.mode() == ControlMode::Manual,
            "{nth}: {}",
            rig.shell.coordinator().text()
        );
        assert_eq!(rig.shell.coordinator().founding(), None, "{nth}");
    }
}
