//! What the whole line can reach, some part of it can: lines with a mistake in them, whole and in parts.

use linewright_line::Line;
use linewright_proof::explore::{LineExploration, Verdict};
use linewright_proof::generate::{self, LineShape, break_it, breakages, text};
use linewright_proof::parts::parts;

use crate::common::{APART, begins_well, explored, lines, met, verdict, with_conflict};

/// Whether the whole line meets its conflict, as far as it is looked at; and whether the part that decides it is
/// smaller and meets it too. A part in which stations run away from each other, whom others hold back in the whole
/// line, is not sound either and decides nothing.
fn whole_and_part(what: &str, line: &Line) -> (bool, bool) {
    if !met(&explored(&LineExploration::new(line), 6_000)) {
        return (false, false);
    }
    let parts = parts(line);
    assert_eq!(parts.len(), 1, "{what}: one conflict, one part");
    let part = &parts[0];
    // A part has fewer states than the whole on the way to the same end, but freer ones: look further.
    let found = explored(&LineExploration::new(&part.line), 400_000);
    assert!(!found.holds(), "{what}: the whole meets it, the part {} is sound\n{}", part.names(), text(line));
    let ran_away = verdict(&found, APART) == Verdict::Fails;
    assert!(met(&found) || ran_away, "{what}: {:?}", found.properties);
    (true, met(&found) && part.stations.len() < line.stations.len())
}

#[test]
fn a_conflict_that_the_whole_line_meets_is_met_in_its_part() {
    let shape = LineShape { stations: 3..=4, ..LineShape::small() };
    let (mut met, mut smaller) = (0, 0);
    for seed in 0..lines(12) {
        let line = generate::line(&shape, seed);
        for breakage in breakages(&line).into_iter().step_by(4) {
            let Some(broken) = break_it(&line, breakage) else { continue };
            for conflict in broken.conflicts.iter().filter(|_| begins_well(&broken)) {
                let what = format!("seed {seed}, {breakage:?}, {}", conflict.why);
                let (whole, part) = whole_and_part(&what, &with_conflict(&broken, conflict));
                (met, smaller) = (met + u32::from(whole), smaller + u32::from(part));
            }
        }
    }
    println!("{met} conflicts met by the whole line, {smaller} of them met by a part that is smaller");
    assert!(met > 20 && smaller > 10, "too few to tell: {met} met, {smaller} in smaller parts");
}
