//! Orders to places by number: while one follows another, nothing in between is ordered.

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick, parse};
use linewright_station_logic::{ModeOrder, Restore, Rules};
use linewright_station_shell::{StationArrival, StationEffect, StationShell};

/// The bits of an image that are on: names of `all`, in the order of their bits.
fn bits(all: &[String], on: &[&str]) -> u128 {
    on.iter().map(|name| 1 << all.iter().position(|known| known == name).expect("a name of the table's")).sum()
}

/// A number by its three bits.
fn number(all: &[String], names: [&str; 3], number: u128) -> u128 {
    (0..3).filter(|bit| number >> bit & 1 == 1).map(|bit| bits(all, &[names[bit]])).sum()
}

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
        let (inputs, outputs) = (line.stations[0].inputs.clone(), line.stations[0].outputs.clone());
        let (in_place, turn) = (bits(&inputs, &["in_place"]), bits(&outputs, &["turn"]));
        let measured = |place| number(&inputs, ["place_1", "place_2", "place_4"], place);
        let lamp = bits(&outputs, &["lamp_table"]);
        let shell = StationShell::new(&line, StationId(0), 7, Restore::Fresh).expect("it compiles");
        let mut shell = shell.with_rules(Rules { timely: true, positions: true, ..Rules::COUNTS });
        let (mut now, mut effects) = (Tick::from_millis(1000), Vec::new());
        // At rest its place becomes known.
        shell.handle(
            now,
            StationArrival::Devices { bits: in_place | measured(1), valid: true, losses: 0 },
            &mut effects,
        );
        shell.act(now, &mut effects);
        shell.remembered(now);
        for step in 0..2 * u128::from(places) {
            let place = step % u128::from(places) + 1;
            now = now + line.timing.refresh;
            let order = ModeOrder { station_life: 7, ..ModeOrder::of(11, 5, ControlMode::Auto, line.timing.lease) };
            shell.handle(now, StationArrival::Order { sequence: step as u64 + 1, from: [0; 12], order }, &mut effects);
            let bits = in_place | measured(place);
            shell.handle(now, StationArrival::Devices { bits, valid: true, losses: 0 }, &mut effects);
            effects.clear();
            shell.act(now, &mut effects);
            let recorded = effects.iter().position(|effect| *effect == StationEffect::Remember).expect("a record");
            let turning =
                |effect: &StationEffect| matches!(effect, StationEffect::Drive(image) if image.bits & turn != 0);
            assert!(!effects[..recorded].iter().any(turning), "{places} places, at {place}: {effects:?}");
            let next = place % u128::from(places) + 1;
            let ordered = turn | number(&outputs, ["to_1", "to_2", "to_4"], next);
            let to_next =
                |effect: &StationEffect| matches!(effect, StationEffect::Drive(image) if image.bits & !lamp == ordered);
            assert!(effects[recorded..].iter().any(to_next), "{places} places, at {place}: {effects:?}");
            shell.remembered(now);
            // It leaves its place.
            now = now + line.timing.refresh;
            shell.handle(now, StationArrival::Devices { bits: measured(place), valid: true, losses: 0 }, &mut effects);
            shell.act(now, &mut effects);
        }
    }
}
