//! Another coordinator of the line.

use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, StationView};
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord};
use linewright_line::StationId;
use linewright_line::net::ControlMode;
use linewright_station_shell::EPOCH_JUMP_MAX;

use crate::rig::{LIFE, Rig};

const OTHER: u64 = 90;

impl Rig {
    /// For this many periods another coordinator gives orders as well.
    fn beside_another(&mut self, periods: u64, from: u64) -> Vec<CoordinatorEffect> {
        let mut done = Vec::new();
        for sequence in from..from + periods {
            self.shell.handle(self.now, CoordinatorArrival::Order { boot_id: OTHER, sequence });
            self.shell.handle(self.now, CoordinatorArrival::Order { boot_id: LIFE, sequence });
            done = self.refresh();
        }
        done
    }

    fn refusal(&mut self, command: ModeCommand) -> String {
        self.command(command);
        let done = self.act();
        let text = |effect: &CoordinatorEffect| match effect {
            CoordinatorEffect::Refused(refusal) => Some(refusal.text(&self.line)),
            _ => None,
        };
        done.iter().find_map(text).unwrap_or_else(|| panic!("not refused: {done:?}"))
    }
}

#[test]
fn auto_ends_while_another_coordinator_gives_orders_and_no_mode_that_moves_is_entered() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    rig.beside_another(4, 1);
    assert_eq!(rig.mode(), ControlMode::StandBy);
    let expected = format!("second coordinator active on this line (boot id {OTHER}), no motion; stop one of the two");
    assert!(rig.shell.coordinator().text().contains(&expected), "{}", rig.shell.coordinator().text());
    for command in [ModeCommand::Auto, ModeCommand::Hand, ModeCommand::Manual] {
        let refusal = rig.refusal(command);
        assert!(refusal.contains(&expected), "{refusal}");
    }
    assert_eq!(rig.shell.gives_way_to(rig.now), None, "it is the one that is followed");
    // Once the other one is silent an operator goes on.
    (0..8).for_each(|_| drop(rig.refresh()));
    rig.command(ModeCommand::Auto);
    rig.refresh();
    assert_eq!(rig.mode(), ControlMode::Auto);
}

#[test]
fn manual_is_not_enabled_while_another_coordinator_gives_orders() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.command(ModeCommand::Start);
    rig.refresh();
    rig.command(ModeCommand::Manual);
    (0..2).for_each(|_| drop(rig.refresh()));
    assert!(rig.shell.order().enabled && rig.mode() == ControlMode::Manual);
    rig.beside_another(4, 1);
    assert!(!rig.shell.order().enabled);
}

#[test]
fn one_late_order_of_a_predecessor_changes_nothing() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    for _ in 0..4 {
        rig.shell.handle(rig.now, CoordinatorArrival::Order { boot_id: OTHER, sequence: 800 });
        rig.refresh();
    }
    assert_eq!(rig.mode(), ControlMode::Auto);
}

#[test]
fn who_comes_second_gives_way_and_who_is_followed_does_not() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    // The stations follow the other one, whose epochs they acknowledge.
    for round in 0..4 {
        rig.now = rig.now + Duration::from_millis(50);
        rig.shell.handle(rig.now, CoordinatorArrival::Order { boot_id: OTHER, sequence: 10 + round });
        // The same epoch as this one's, by chance.
        let heard = StationView { mode_epoch: rig.shell.coordinator().epoch(), follows: OTHER, ..rig.heard[0] };
        let station = StationId(0);
        rig.shell.handle(rig.now, CoordinatorArrival::State { station, sequence: 1 + round, heard });
        rig.act();
    }
    assert_eq!(rig.shell.gives_way_to(rig.now), Some(OTHER));
}

/// No station is up yet: the one that has given fewer orders came second.
#[test]
fn of_two_that_no_station_has_heard_the_younger_one_gives_way() {
    for (from, expected) in [(1000, Some(OTHER)), (1, None)] {
        let mut rig = Rig::new(CoordinatorRecord::default());
        (0..100).for_each(|_| {
            rig.now = rig.now + Duration::from_millis(50);
            rig.act();
        });
        for sequence in from..from + 4 {
            rig.now = rig.now + Duration::from_millis(50);
            rig.shell.handle(rig.now, CoordinatorArrival::Order { boot_id: OTHER, sequence });
            rig.act();
        }
        assert_eq!(rig.shell.gives_way_to(rig.now), expected);
    }
}

/// Two that do not receive each other can come to the same epoch.
#[test]
fn a_station_that_follows_another_coordinator_has_acknowledged_nothing() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.command(ModeCommand::Start);
    rig.refresh();
    rig.heard[1].follows = OTHER;
    rig.command(ModeCommand::Manual);
    (0..4).for_each(|_| drop(rig.refresh()));
    assert!(!rig.shell.order().enabled);
    rig.heard[1].follows = rig.shell.boot_id();
    rig.refresh();
    assert!(rig.shell.order().enabled, "{}", rig.shell.coordinator().text());
}

/// A forged epoch that one station has followed. The others follow a limited jump.
#[test]
fn an_epoch_that_is_followed_leaves_room_for_the_stations_that_did_not_receive_it() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    let before = rig.shell.coordinator().epoch();
    for jump in [EPOCH_JUMP_MAX, EPOCH_JUMP_MAX / 2] {
        let heard = StationView { mode_epoch: before + jump, ..rig.heard[0] };
        let arrival = CoordinatorArrival::State { station: StationId(0), sequence: 1 << 40, heard };
        rig.shell.handle(rig.now, arrival);
        rig.command(ModeCommand::EStop);
        rig.act();
        rig.command(ModeCommand::Reset);
        rig.act();
        let epoch = rig.shell.coordinator().epoch();
        assert!(epoch <= before + EPOCH_JUMP_MAX, "{epoch} is beyond what a station at {before} follows");
    }
}
