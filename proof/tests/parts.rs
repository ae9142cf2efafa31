//! A conflict that the whole line can reach, some part of it can: lines with a mistake in them, whole and in parts.

use std::collections::BTreeSet;

use linewright_line::net::ControlMode;
use linewright_line::{Line, TransferLine, parse};
use linewright_proof::explore::{LineExploration, Verdict};
use linewright_proof::generate::{self, LineShape, break_it, breakages, text};
use linewright_proof::parts::{larger, parts, smallest_parts};
use linewright_proof::structure::chart::{direct_arrows, every_circuit_has_a_token, home_is_consistent, separated};
use linewright_station_logic::Program;
use linewright_testkit::cases::cases;

use crate::common::{APART, SOUND, begins_well, explored, met, verdict, with_conflict};

fn transfer_line(machines: usize) -> Line {
    parse("line.toml", &TransferLine { machines, time_scale: 1.0 }.text()).expect("the shipped line is sound").line
}

#[test]
fn a_line_of_one_machine_is_its_own_part() {
    let line = transfer_line(1);
    let parts = parts(&line);
    assert_eq!(parts.len(), 1);
    assert_eq!(parts[0].names(), "transfer, clamp_1, mill_1");
    assert_eq!((&parts[0].line.arrows, &parts[0].line.conflicts), (&line.arrows, &line.conflicts));
    assert_eq!(parts[0].conflicts, [0, 1]);
}

#[test]
fn machines_beside_each_other_are_parts_that_differ_in_names_alone() {
    let line = transfer_line(4);
    let parts = parts(&line);
    assert_eq!(parts.len(), 4);
    assert!(parts.iter().all(|part| part.is_like(&parts[0])));
    assert!(parts.iter().enumerate().all(|(nth, part)| part.names().contains(&format!("mill_{}", nth + 1))));
    let decided: usize = parts.iter().map(|part| part.conflicts.len()).sum();
    assert_eq!(decided, line.conflicts.len());
}

/// Stations in a row, each waiting for the one before it: the first is held off the last by all between them.
#[test]
fn a_larger_part_has_the_stations_between() {
    let line = parse("row.toml", include_str!("row.toml")).expect("the row is sound").line;
    let found = parts(&line);
    assert_eq!(found.iter().map(|part| part.names()).collect::<Vec<_>>(), ["s0, s2"]);
    let in_auto = |line| {
        let mut setting = LineExploration::new(line);
        setting.modes = vec![ControlMode::Auto];
        explored(&setting, 400_000)
    };
    assert!(met(&in_auto(&found[0].line)), "nothing joins the two");
    let wider = larger(&line, &found[0]).expect("arrows lead there through another one");
    assert_eq!((wider.names().as_str(), &wider.conflicts), ("s0, s1, s2", &found[0].conflicts));
    let explored = in_auto(&wider.line);
    assert!(!met(&explored) && explored.exhausted, "{:?}", explored.properties);
    assert!(larger(&line, &wider).is_none(), "the fourth has one arrow alone");
}

/// Whether the whole line meets its conflict, as far as it is explored; and whether the part that decides it is smaller
/// and meets it too. A part whose stations run away from each other, while others hold them back in the whole line, is
/// not sound either and decides nothing.
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
    let (mut met, mut smaller) = (0u64, 0u64);
    for seed in 0..cases(6) {
        let line = generate::line(&shape, seed);
        for breakage in breakages(&line).into_iter().step_by(4) {
            let Some(broken) = break_it(&line, breakage) else { continue };
            for conflict in broken.conflicts.iter().filter(|_| begins_well(&broken)) {
                let what = format!("seed {seed}, {breakage:?}, {}", conflict.why);
                let (whole, part) = whole_and_part(&what, &with_conflict(&broken, conflict));
                (met, smaller) = (met + u64::from(whole), smaller + u64::from(part));
            }
        }
    }
    println!("{met} conflicts met by the whole line, {smaller} of them met by a part that is smaller");
    assert!(met > cases(20) && smaller > cases(10), "too few to tell: {met} met, {smaller} in smaller parts");
}

/// A belt and stations around it: every station begins when the belt stands, and the belt when all of them are back.
/// One button of each station leads on and back. Each has one operation forth or two, by the bits of `longer`.
fn star(around: usize, longer: u32) -> Line {
    let mut text = "name = \"star\"\nbuttons = [\"B0\", \"B1\", \"B2\", \"B3\", \"B4\", \"B5\"]\n".to_owned();
    for station in 0..=around {
        let ops = if longer >> (station % 32) & 1 == 1 { 3 } else { 2 };
        let own = if station == 0 { 0 } else { 3 };
        text += &format!(
            "[[station]]\nname = \"s{station}\"\nhome = \"back\"\naxes = {{ x = 0.0 }}\nbus = \"can{station}\"\n"
        );
        for op in 0..ops {
            let last = op + 1 == ops;
            let (from, to) = if last { (op * 10, 0) } else { (op * 10, op * 10 + 10) };
            let (forward, next) = (own + op, own + (op + 1) % ops);
            let name = if last { "back".to_owned() } else { format!("forth {op}") };
            text += &format!(
                "[[station.operation]]\nname = \"{name}\"\nmodule = \"R\"\nmoves = {{ axis = \"x\", from = {from}, to = {to} }}\n\
                 duration_s = 0.5\nwatchdog_s = 2.0\nnormal = {{ actuator = \"Y_{op}\", complete = \"X_{to}\" }}\n\
                 recovery = {{ actuator = \"R_{op}\", complete = \"X_{from}\" }}\n\
                 hand = {{ type = 6, forward = \"B{forward}\", back = \"B{next}\", next = \"B{next}\" }}\n"
            );
        }
        let quoted = |names: Vec<String>| names.iter().map(|name| format!("{name:?}, ")).collect::<String>();
        let inputs = quoted((0..ops).map(|op| format!("X_{}", op * 10)).collect());
        let outputs = quoted((0..ops).flat_map(|op| [format!("Y_{op}"), format!("R_{op}")]).collect());
        let mut joined = format!(
            "[[device]]\nname = \"io {station}\"\nstation = \"s{station}\"\nnode = 1\ninputs = [{inputs}]\noutputs = [{outputs}]\n"
        );
        if station > 0 {
            joined += &format!(
                "[[arrow]]\nfrom = \"s0: back\"\nto = \"s{station}: forth 0\"\n\
                 [[arrow]]\nfrom = \"s{station}: back\"\nto = \"s0: forth 0\"\nlag = 1\n\
                 [[conflict]]\nwhy = \"s{station} is in the way\"\n\
                 a = {{ station = \"s0\", from = \"forth 0\", until = \"back\" }}\n\
                 b = {{ station = \"s{station}\", from = \"forth 0\", until = \"back\" }}\n"
            );
        }
        text += &joined;
    }
    // Tables of the line may stand between its stations.
    parse("star.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

#[test]
fn the_parts_of_a_star_are_pairs_and_meet_whatever_the_star_meets() {
    let (mut met_in, mut stars) = (0u64, 0u64);
    for longer in 0..cases(3) as u32 {
        let whole = star(3, longer);
        assert!(parts(&whole).iter().all(|part| part.stations.len() == 2), "{longer:b}: pairs");
        for breakage in breakages(&whole).into_iter().step_by(4) {
            let Some(broken) = break_it(&whole, breakage) else { continue };
            for conflict in broken.conflicts.iter().filter(|_| begins_well(&broken)) {
                stars += 1;
                let what = format!("{longer:b}, {breakage:?}, {}", conflict.why);
                met_in += u64::from(whole_and_part(&what, &with_conflict(&broken, conflict)).0);
            }
        }
    }
    println!("{stars} stars, {met_in} conflicts met");
    assert!(met_in > cases(10), "too few to tell: {met_in} of {stars}");
}

/// Whatever the whole star does, a pair of it can do: what is switched off for all shows in the pair.
#[test]
fn a_rule_that_a_star_misses_is_missed_by_its_parts() {
    let line = star(3, 0);
    let pair = &parts(&line)[0];
    let without = |line: &Line, change: fn(&mut LineExploration)| {
        let mut setting = LineExploration::new(line);
        change(&mut setting);
        met(&explored(&setting, 60_000))
    };
    let rules: [fn(&mut LineExploration); 2] = [|s| s.rules.counted = false, |s| s.rules.ask = false];
    for (nth, rule) in rules.into_iter().enumerate() {
        let (whole, part) = (without(&line, rule), without(&pair.line, rule));
        println!("rule {nth}: whole {whole}, part {part}");
        assert!(part, "rule {nth}");
    }
}

/// In a ring two stations may be kept apart by way of the third alone, which their part leaves out. The arrows that say so directly bring
/// nothing into the line that was not there, and decide the part.
#[test]
fn a_part_is_decided_with_the_direct_arrows_of_what_it_leaves_out() {
    let shape =
        LineShape { stations: 3..=3, operations: 2..=3, more_arrows: 0, more_conflicts: 2, ..LineShape::default() };
    let (mut decided, mut met_without) = (0, 0);
    for seed in 0..40 {
        let whole = generate::line(&shape, seed);
        for index in 0..whole.arrows.len() {
            let mut line = whole.clone();
            line.arrows.remove(index);
            if line.conflicts.iter().any(|conflict| separated(&line, conflict).is_err()) {
                continue;
            }
            for part in smallest_parts(&line) {
                let direct = direct_arrows(&line, &part);
                if direct.is_empty() {
                    continue;
                }
                let what = format!("seed {seed}, without arrow {index}: {}", part.names());
                let mut with = line.clone();
                with.arrows.extend(direct.into_iter().map(|(_, arrow)| arrow));
                assert!(every_circuit_has_a_token(&with).is_ok() && home_is_consistent(&with).is_ok(), "{what}");
                let of_with = smallest_parts(&with).into_iter().find(|other| other.stations == part.stations);
                let of_with = of_with.expect("arrows join no more stations");
                assert_eq!(direct_arrows(&with, &of_with), [], "{what}");
                // Some of them are explored as well.
                if decided < 6 {
                    met_without += u64::from(met(&explored(&LineExploration::new(&part.line), 60_000)));
                    let found = explored(&LineExploration::new(&of_with.line), 600_000);
                    assert!(found.exhausted && found.holds(), "{what}: {:?}", found.properties);
                }
                decided += 1;
            }
        }
    }
    println!("{decided} parts, {met_without} of the first explored meet without");
    assert!(decided >= 6 && met_without > 0, "{decided}, {met_without}");
}

#[test]
fn a_star_of_two_hundred_stations_is_decided_by_one_part() {
    let line = star(199, 0);
    let began = std::time::Instant::now();
    let parts = parts(&line);
    assert_eq!(parts.len(), 199);
    assert!(parts.iter().all(|part| part.stations.len() == 2 && part.is_like(&parts[0])));
    let found = explored(&LineExploration::new(&parts[0].line), 2_000_000);
    println!("{} parts; one of them: {} states, {:?}", parts.len(), found.states, began.elapsed());
    for station in line.station_ids() {
        let program = Program::compile(&line, station);
        assert!(program.is_ok(), "{}: {program:?}", line.station(station).name);
    }
    assert!(found.exhausted && found.holds(), "{:?}", found.properties);
}

/// Whether the whole line, with stations that are restarted and lose their memories, does something wrong as far as it is
/// looked at. Then one of its smallest parts does, too.
fn wrong_with_restarts(what: &str, line: &Line, change: fn(&mut LineExploration)) -> bool {
    let setting = |line: &Line| {
        let mut setting = LineExploration::new(line).with_lost_memories();
        change(&mut setting);
        setting
    };
    let whole = explored(&setting(line), 6_000);
    if !met(&whole) && verdict(&whole, SOUND) != Verdict::Fails {
        return false;
    }
    let parts = smallest_parts(line);
    let is_wrong = |part: &Line| explored(&setting(part), 400_000).counterexample().is_some();
    assert!(
        parts.is_empty() || parts.iter().any(|part| is_wrong(&part.line)),
        "{what}: the whole is wrong, its parts are not: {:?}\n{}",
        whole.properties,
        text(line)
    );
    !parts.is_empty()
}

#[test]
fn what_restarts_make_wrong_in_the_whole_line_is_wrong_in_a_smallest_part() {
    // Without the rule that a round is redone a station's own record contradicts itself, and it does not come up again.
    type Change = fn(&mut LineExploration);
    let rules: [(&str, Change); 3] = [
        ("generations", |setting| setting.rules.generations = false),
        ("agreement", |setting| setting.rules.ask = false),
        ("withdraw first", |setting| setting.rules.withdraw_first = false),
    ];
    let shape = LineShape { stations: 3..=3, operations: 2..=3, ..LineShape::small() };
    let generated = (0..cases(2)).map(|seed| (format!("seed {seed}"), generate::line(&shape, seed)));
    let stars = (0..cases(2) as u32).map(|longer| (format!("star {longer:b}"), star(2, longer)));
    let (mut found, mut broken_found) = (0, 0);
    for (what, line) in generated.chain(stars) {
        for (rule, change) in rules {
            found += u32::from(wrong_with_restarts(&format!("{what} without {rule}"), &line, change));
        }
        for breakage in breakages(&line).into_iter().step_by(6) {
            let Some(broken) = break_it(&line, breakage) else { continue };
            broken_found += u32::from(wrong_with_restarts(&format!("{what}, {breakage:?}"), &broken, |_| {}));
        }
    }
    println!("{found} without a rule, {broken_found} broken ones wrong, and so in a part");
    assert!(found >= 4 && broken_found >= 4, "too few to tell: {found}, {broken_found}");
}

#[test]
fn the_smallest_parts_have_every_station() {
    for (line, pairs) in [(star(2, 0), 2), (star(1, 0), 0)] {
        let parts = smallest_parts(&line);
        assert_eq!(parts.len(), pairs);
        assert!(parts.iter().all(|part| part.stations.len() == 2));
        let stations: BTreeSet<_> = parts.iter().flat_map(|part| part.stations.iter().copied()).collect();
        let all = if pairs == 0 { BTreeSet::new() } else { line.station_ids().collect() };
        assert_eq!(stations, all);
    }
    let line = Line { conflicts: Vec::new(), ..star(2, 0) };
    assert!(smallest_parts(&line).iter().map(|part| part.stations.len()).eq([1, 1, 1]), "each alone, with its buttons");
}
