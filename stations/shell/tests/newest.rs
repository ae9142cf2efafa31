//! Which of several messages is the newest: by the writer's life and its number.

use std::time::Duration;

use linewright_line::Tick;
use linewright_station_shell::NewestBySequence;

const TERM: Duration = Duration::from_millis(250);
const NEWEST: bool = true;
const OLD: bool = false;

/// Offers messages given as (milliseconds, boot id, sequence), with whether each is to be the newest.
fn judged(messages: &[(u64, u64, u64, bool)]) -> NewestBySequence {
    let mut newest = NewestBySequence::new(TERM);
    for &(at, boot, sequence, expected) in messages {
        let is_newest = newest.offer(Tick::from_millis(at), boot, sequence);
        assert_eq!(is_newest, expected, "boot {boot} sequence {sequence} at {at} ms");
    }
    newest
}

#[test]
fn one_writer_and_its_restarts() {
    let newest = judged(&[
        (0, 0, 1, OLD),
        (0, 7, 5, NEWEST),
        (50, 7, 6, NEWEST),
        (50, 7, 6, OLD),
        (100, 7, 9, NEWEST),
        (101, 7, 8, OLD),
        (150, 8, 1, OLD),
        (349, 8, 5, OLD),
        (350, 8, 6, NEWEST),
        (351, 7, 10, OLD),
        (400, 8, 7, NEWEST),
        (650, 7, 10, OLD),
        (651, 9, 1, NEWEST),
        (900, 7, 11, OLD),
        (901, 9, u64::MAX, NEWEST),
    ]);
    assert_eq!(newest.current(), Some((9, u64::MAX)));
}

#[test]
fn the_last_message_of_a_short_life_does_not_deafen_its_readers() {
    // Life 2 was never received while it lived; its last message overtakes nothing.
    judged(&[(0, 1, 500, NEWEST), (300, 3, 1, NEWEST), (301, 2, 1, OLD), (350, 3, 2, NEWEST)]);
    // The same while life 3 is cut off: it is received again one term later.
    let cut_off = [(0, 3, 1, NEWEST), (300, 2, 9, NEWEST), (310, 3, 7, OLD), (550, 3, 8, OLD)];
    judged(&[&cut_off[..], &[(600, 3, 9, NEWEST), (601, 3, 10, NEWEST)]].concat());
}

#[test]
fn a_sequence_that_its_writer_never_gave_deafens_its_readers_for_one_term() {
    let newest = judged(&[
        (0, 7, 5, NEWEST),
        (10, 7, u64::MAX, NEWEST),
        (50, 7, 6, OLD),
        (259, 7, 10, OLD),
        // One message alone may be a late one, however often it comes.
        (300, 7, 11, OLD),
        (301, 7, 11, OLD),
        // Messages that waited somewhere arrive at once.
        (302, 7, 12, OLD),
        (303, 7, 13, OLD),
        (350, 7, 12, NEWEST),
        (400, 7, 13, NEWEST),
    ]);
    assert_eq!(newest.current(), Some((7, 13)));
}

#[test]
fn of_two_that_are_heard_at_once_the_first_stays() {
    let mut newest = NewestBySequence::new(TERM);
    for round in 0..100 {
        let at = Tick::from_millis(50 * round);
        assert!(newest.offer(at, 1, round + 1));
        assert!(!newest.offer(at, 2, round + 1));
    }
}

#[test]
fn only_the_last_boots_are_remembered() {
    let mut newest = NewestBySequence::new(TERM);
    for boot in 1..=10 {
        newest.offer(Tick::from_millis(1000 * boot), boot, 1);
    }
    assert!(!newest.offer(Tick::from_millis(20_000), 2, 2));
    assert!(newest.offer(Tick::from_millis(20_000), 1, 2), "forgotten after eight more");
}
