//! Random cells: the check and the player of parts agree on each.

use linewright_cell::net::Detail;
use linewright_proof::cell::{CellExploration, Checked, Verdict, check};
use linewright_proof::generate::{self, CellShape};
use linewright_testkit::cases::cases;

use super::oracle::{Played, groups, play};
use super::{cell, checked, verdicts};

/// More moments than this are not looked at one by one.
const MOMENTS_MAX: usize = 8_000;

/// Result of the player of parts: the sound number of parts, and the result with one more; none if there are too many
/// states.
fn by_hand(cell: &linewright_cell::Cell) -> Option<(u32, Option<Played>, Played)> {
    let mut last = play(cell, 0, MOMENTS_MAX)?;
    for parts in 1..=cell.limits.wip_max {
        let played = play(cell, parts, MOMENTS_MAX)?;
        if played.stuck.is_some() || !played.empties {
            return Some((parts - 1, Some(played), last));
        }
        last = played;
    }
    Some((cell.limits.wip_max, None, last))
}

#[track_caller]
fn agrees(seed: u64, checked: &Checked, (sound, wrong, last): &(u32, Option<Played>, Played), text: &str) {
    let [stuck, finished, happens] = verdicts(checked);
    assert_eq!(checked.sound, *sound, "seed {seed}: {checked:#?}\n{text}");
    let expected = match wrong {
        None => [Verdict::Holds; 2],
        Some(Played { stuck: Some(_), .. }) => [Verdict::Fails; 2],
        Some(Played { stuck: None, .. }) => [Verdict::Undecided, Verdict::Fails],
    };
    assert_eq!([stuck, finished], expected, "seed {seed}: {checked:#?}\n{text}");
    assert_eq!(happens, Verdict::Holds, "seed {seed}: {checked:#?}\n{text}");
    if let [group] = checked.groups.as_slice() {
        let seen = wrong.as_ref().unwrap_or(last);
        assert_eq!((group.states, group.arcs), (seen.moments as u64, seen.steps as u64), "seed {seed}\n{text}");
        let story = checked.properties.iter().find_map(|property| property.counterexample.as_ref());
        if let Some(steps) = seen.stuck {
            assert_eq!(story.map(|story| story.steps.len()), Some(steps), "seed {seed}: a shortest way\n{text}");
        }
    }
}

/// So many cells, and not a different word on any: whether it gets stuck, with how many parts, how many states and
/// steps there are, and how long the shortest way is.
#[test]
fn the_check_finds_what_a_player_of_parts_finds() {
    let (mut seen, mut of) = (0, [0; 2]);
    let (mut apart, mut too_large) = (0, 0);
    for seed in 0.. {
        if seen == cases(100) {
            break;
        }
        let text = generate::cell(&CellShape { apart: 10, ..CellShape::small() }, seed);
        let cell = cell(&text);
        let Some(expected) = by_hand(&cell) else {
            too_large += 1;
            continue;
        };
        let checked = checked(&cell);
        agrees(seed, &checked, &expected, &text);
        assert_eq!(checked.groups.len(), groups(&cell), "seed {seed}\n{text}");
        apart += u64::from(checked.groups.len() > 1);
        of[usize::from(expected.1.is_some())] += 1;
        seen += 1;
    }
    let [sound, wrong] = of;
    println!("{sound} sound, {wrong} get stuck; {apart} in groups, {too_large} too large");
    assert!(sound >= cases(10) && wrong >= cases(10) && apart >= cases(3));
}

/// Starts and ends explored apart give the same verdicts as whole activities, and about as many parts.
#[test]
fn both_details_say_the_same() {
    for seed in 0..cases(30) {
        let cell = cell(&generate::cell(&CellShape { wip: 1..=3, ..CellShape::small() }, seed));
        let whole = checked(&cell);
        let fully =
            check(&CellExploration { detail: Detail::Expanded, ..CellExploration::new(&cell) }).expect("it is small");
        assert_eq!((verdicts(&whole), whole.sound), (verdicts(&fully), fully.sound), "seed {seed}");
        let states = |checked: &Checked| checked.groups.iter().map(|group| group.states).sum::<u64>();
        assert!(states(&whole) <= states(&fully), "seed {seed}");
    }
}

#[test]
fn the_same_seed_gives_the_same_cell_and_another_seed_another() {
    let shape = CellShape::default();
    assert_eq!(generate::cell(&shape, 7), generate::cell(&shape, 7));
    assert_ne!(generate::cell(&shape, 7), generate::cell(&shape, 8));
}

/// Of what not every plan has there are plans among the small cells.
#[test]
fn everything_a_plan_may_have_is_generated() {
    let texts: Vec<String> = (0..300).map(|seed| generate::cell(&CellShape::small(), seed)).collect();
    texts.iter().for_each(|text| _ = cell(text));
    for what in ["stays = \"may\"", "stays = \"must\"", "then = \"done\""] {
        assert!(texts.iter().filter(|text| text.contains(what)).count() >= 10, "{what}");
    }
}

/// Of everything a cell can have there are cells.
#[test]
fn everything_a_cell_may_have_is_generated() {
    let texts: Vec<String> = (0..300).map(|seed| generate::cell(&CellShape::default(), seed)).collect();
    texts.iter().for_each(|text| _ = cell(text));
    for what in [
        "prototype = \"machine\"",
        "prototype = \"human\"",
        "prototype = \"random-access-store\"",
        "prototype = \"fifo-buffer\"",
        "prototype = \"lifo-buffer\"",
        "prototype = \"robot\"",
        "prototype = \"conveyor\"",
        "reserve = false",
        "or = ",
        "orders = ",
        "name = \"enter M",
        "name = \"leave M",
    ] {
        assert!(texts.iter().filter(|text| text.contains(what)).count() >= 10, "{what}");
    }
}
