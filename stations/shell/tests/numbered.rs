//! Orders to places by number: while one follows another, nothing in between is ordered.

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick, parse};
use linewright_station_logic::{ModeOrder, Restore, Rules};
use linewright_station_shell::{StationArrival, StationEffect, StationShell};

const IN_PLACE: u128 = 1 << 3;
/// First bit of the place number, after the fault of the drive.
const PLACE: u32 = 5;
const TURN: u128 = 1 << 1;

/// The table of the example by itself, with so many places.
fn table(places: u32) -> Line {
    let text = include_str!("../../../examples/driven-table.toml");
    let index = format!("by = {}", 360 / places);
    let text = text.replace("by = 90", &index);
    assert!(text.contains(&index));
    let mut line = parse("driven-table.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    line.arrows.clear();
    line.conflicts.clear();
    line
}

#[test]
fn from_one_place_to_the_next_nothing_is_driven_before_the_record() {
    for places in [5, 6] {
        let line = table(places);
        let shell = StationShell::new(&line, StationId(0), 7, Restore::Fresh).expect("it compiles");
        let mut shell = shell.with_rules(Rules::COUNTS);
        let (mut now, mut effects) = (Tick::from_millis(1000), Vec::new());
        for step in 0..2 * u128::from(places) {
            let place = step % u128::from(places) + 1;
            now = now + line.timing.refresh;
            let order = ModeOrder::of(11, 5, ControlMode::Auto, line.timing.lease);
            shell.handle(now, StationArrival::Order { sequence: step as u64 + 1, order }, &mut effects);
            let bits = IN_PLACE | place << PLACE;
            shell.handle(now, StationArrival::Devices { bits, valid: true, losses: 0 }, &mut effects);
            effects.clear();
            shell.act(now, &mut effects);
            let recorded = effects.iter().position(|effect| *effect == StationEffect::Remember).expect("a record");
            let turning =
                |effect: &StationEffect| matches!(effect, StationEffect::Drive(image) if image.bits & TURN != 0);
            assert!(!effects[..recorded].iter().any(turning), "{places} places, at {place}: {effects:?}");
            let next = place % u128::from(places) + 1;
            let to_next = |effect: &StationEffect| matches!(effect, StationEffect::Drive(image) if image.bits & !1 == TURN | next << 2);
            assert!(effects[recorded..].iter().any(to_next), "{places} places, at {place}: {effects:?}");
            shell.remembered(now);
            // It leaves its place.
            now = now + line.timing.refresh;
            shell.handle(now, StationArrival::Devices { bits: place << PLACE, valid: true, losses: 0 }, &mut effects);
            shell.act(now, &mut effects);
        }
    }
}
