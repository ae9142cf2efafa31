//! Output images of stations at the gateway: which is energised, and for how long.

use std::time::Duration;

use linewright_coordinator_logic::{Gateway, OutputImage};
use linewright_line::{StationId, Tick};

const STATION: StationId = StationId(0);

fn heard_at_zero(image: OutputImage) -> Gateway {
    let mut gateway = Gateway::new(1, Duration::from_millis(250));
    gateway.hear(Tick::ZERO, STATION, image);
    gateway
}

const ON: OutputImage = OutputImage { bits: 5, valid: true, losses: 2, boot_id: 7, number: 4, mode_epoch: 6 };

#[test]
fn a_fresh_image_is_energised_and_a_stale_one_is_not() {
    let gateway = heard_at_zero(ON);
    assert_eq!(gateway.in_force(Tick::from_millis(249), STATION, 2, 0).bits, 5);
    assert_eq!(gateway.in_force(Tick::from_millis(250), STATION, 2, 0).bits, 0);
    assert_eq!(gateway.next_deadline(Tick::ZERO), Some(Tick::from_millis(250)));
}

#[test]
fn an_image_decided_before_a_loss_is_not_energised_after_it() {
    assert_eq!(heard_at_zero(ON).in_force(Tick::ZERO, STATION, 3, 0).bits, 0);
}

#[test]
fn an_image_from_before_an_emergency_stop_is_not_energised_after_it() {
    assert_eq!(heard_at_zero(ON).in_force(Tick::ZERO, STATION, 2, 6).bits, 5);
    assert_eq!(heard_at_zero(ON).in_force(Tick::ZERO, STATION, 2, 7).bits, 0);
}

#[test]
fn an_image_nobody_vouches_for_and_a_station_never_heard_are_off() {
    assert_eq!(heard_at_zero(OutputImage { valid: false, ..ON }).in_force(Tick::ZERO, STATION, 2, 0).bits, 0);
    assert_eq!(Gateway::new(1, Duration::from_secs(1)).in_force(Tick::ZERO, STATION, 0, 0).bits, 0);
}
