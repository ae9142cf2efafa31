//! Lives of a writer beside the one that is followed.

use std::time::Duration;

use linewright_line::Tick;
use linewright_station_shell::{RivalLife, Rivals};

fn ms(at: u64) -> Tick {
    Tick::from_millis(at)
}

fn rivals() -> Rivals {
    Rivals::new(Duration::from_millis(50), Duration::from_millis(250))
}

#[test]
fn one_late_message_its_copies_and_a_predecessor_of_a_silent_life_do_not_count() {
    let mut late = rivals();
    late.hear(ms(1000), (2, 7), ms(990));
    late.hear(ms(1100), (2, 7), ms(1090));
    assert_eq!(late.there(ms(1100)), None);
    // Messages that come at once come from one buffer.
    late.hear(ms(1300), (3, 7), ms(1290));
    late.hear(ms(1301), (3, 8), ms(1301));
    assert_eq!(late.there(ms(1301)), None);
    // A successor sends while the life before has just fallen silent.
    let mut successor = rivals();
    for at in [1000, 1050, 1100] {
        successor.hear(ms(at), (4, at), ms(990));
    }
    assert_eq!(successor.there(ms(1100)), None);
}

#[test]
fn a_life_that_goes_on_beside_the_followed_one_counts_until_it_is_silent() {
    let mut beside = rivals();
    for at in [1000, 1050] {
        beside.hear(ms(at), (2, at), ms(at));
    }
    assert_eq!(beside.there(ms(1299)), Some(RivalLife { life: 2, sequence: 1050, until: ms(1300) }));
    assert_eq!(beside.there(ms(1300)), None);
    // After the silence it has to be received twice again.
    beside.hear(ms(1400), (2, 1400), ms(1400));
    assert_eq!(beside.there(ms(1400)), None);
}

#[test]
fn who_becomes_the_followed_one_is_no_rival() {
    let mut beside = rivals();
    for at in [1000, 1050] {
        beside.hear(ms(at), (2, at), ms(at));
    }
    beside.forget(2);
    assert_eq!(beside.there(ms(1051)), None);
}

#[test]
fn lives_heard_once_do_not_keep_out_one_that_goes_on() {
    let mut crowd = rivals();
    for nth in 0..20 {
        let at = 1000 + 50 * nth;
        (0..4).for_each(|life| crowd.hear(ms(at), (100 + 4 * nth + life, 1), ms(at)));
        crowd.hear(ms(at + 1), (7, nth + 1), ms(at));
    }
    assert_eq!(crowd.there(ms(1952)).map(|rival| rival.life), Some(7));
}
