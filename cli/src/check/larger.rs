//! What a part does not decide, decided by a larger one: a part gives its stations more freedom than the line does, and a part with more
//! stations gives them less. A state that is never reached in the larger part is never reached in the line, whatever the smaller one finds.

use std::ops::Range;

use linewright_proof::parts::SubLine;

use super::explored::{Exploration, LineFinding};

/// The explorations of one part, among those of all parts.
pub struct PartFound {
    pub part: SubLine,
    /// All of it holds.
    pub holds: bool,
    /// States that were kept of it, or of the one that it is like; without restarts where there are explorations without.
    pub kept: usize,
    pub explorations: Range<usize>,
}

/// Takes over what holds in a larger part; the part with its stations is named.
pub fn take_over(found: &mut [Exploration], parts: &[PartFound]) {
    let open = |finding: &&LineFinding| finding.is_open_by_parts();
    for part in parts {
        let larger: Vec<&PartFound> = parts.iter().filter(|other| has_more(other, part)).collect();
        for index in part.explorations.clone() {
            let names: Vec<String> =
                found[index].properties.iter().filter(open).map(|finding| finding.name.clone()).collect();
            let mut is_settled = false;
            let is_restarted = found[index].is_restarted;
            for name in names {
                let has_setting = |other: &&&PartFound| {
                    !is_restarted || found[other.explorations.clone()].iter().any(|of| of.is_restarted)
                };
                let holds = |other: &&&PartFound| holds_in(&found[other.explorations.clone()], &name);
                let of = larger.iter().find(|other| has_setting(other) && holds(other));
                let Some(scope) = of.map(|of| found[of.explorations.start].scope.clone()) else { continue };
                let scope = scope.split(": ").nth(1).unwrap_or_default().to_owned();
                for finding in found[index].properties.iter_mut().filter(|finding| finding.name == name) {
                    finding.verdict = "holds";
                    finding.reason = format!("in the larger part of {scope}");
                    finding.counterexample = None;
                    finding.is_left_open = false;
                }
                is_settled = true;
            }
            // Its search ended with what the larger part excludes; what it had not seen by then is nothing that parts decide.
            let properties = &mut found[index].properties;
            if is_settled && !properties.iter().any(|finding| finding.verdict == "fails") {
                properties.retain(|finding| finding.verdict != "undecided");
            }
        }
    }
}

fn has_more(other: &PartFound, part: &PartFound) -> bool {
    let (other, part) = (&other.part.stations, &part.part.stations);
    other.len() > part.len() && part.iter().all(|id| other.contains(id))
}

/// Whether these explorations have a property of this name, and it holds in each that has it. Conflicts that are described by the same
/// text have the same name; then all of them have to hold.
fn holds_in(explorations: &[Exploration], name: &str) -> bool {
    let mut of_name = explorations.iter().flat_map(|one| &one.properties).filter(|of| of.name == name).peekable();
    of_name.peek().is_some() && of_name.all(|of| of.verdict == "holds")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exploration(scope: &str, verdicts: &[(&str, &'static str)]) -> Exploration {
        let finding = |&(name, verdict): &(&str, &'static str)| LineFinding {
            name: name.to_owned(),
            verdict,
            reason: String::new(),
            counterexample: None,
            holds_by_parts: name.starts_with("never"),
            is_left_open: false,
        };
        Exploration {
            scope: scope.to_owned(),
            states: 1,
            kept: 1,
            arcs: 0,
            bytes: 0,
            exhausted: true,
            help: None,
            left_out: Vec::new(),
            direct_arrows: Vec::new(),
            kept_apart: Vec::new(),
            is_left_to_parts: false,
            is_restarted: scope.contains("restarted"),
            properties: verdicts.iter().map(finding).collect(),
        }
    }

    fn part(stations: &[u16], explorations: Range<usize>) -> PartFound {
        let text = linewright_line::TransferLine::default().text();
        let line = linewright_line::parse("line.toml", &text).expect("the shipped line is sound").line;
        let stations = stations.iter().map(|&id| linewright_line::StationId(id)).collect();
        PartFound { part: SubLine { stations, conflicts: Vec::new(), line }, holds: false, kept: 1, explorations }
    }

    /// The larger one may be explored first or last, with restarts or without.
    #[test]
    fn what_never_is_in_a_larger_part_never_is_and_nothing_else_is_taken_over() {
        let whole = || exploration("part: a, b, c: auto", &[("never: a and c meet", "holds"), ("home", "holds")]);
        let small = || {
            let found = [("never: a and c meet", "fails"), ("never: others", "fails"), ("home", "fails")];
            exploration("part: a, c: auto", &found)
        };
        for first in [true, false] {
            let mut found = if first { vec![whole(), small()] } else { vec![small(), whole()] };
            let at = usize::from(first);
            let parts = [part(&[0, 1, 2], 1 - at..2 - at), part(&[0, 2], at..at + 1)];
            take_over(&mut found, &parts);
            let verdicts: Vec<_> = found[at].properties.iter().map(|of| of.verdict).collect();
            assert_eq!(verdicts, ["holds", "fails", "fails"]);
            assert_eq!(found[at].properties[0].reason, "in the larger part of a, b, c");
        }
        // What its search had not seen when it ended is left out.
        let ended = exploration("part: a, c: auto", &[("never: a and c meet", "fails"), ("home", "undecided")]);
        let mut found = vec![whole(), ended];
        take_over(&mut found, &[part(&[0, 1, 2], 0..1), part(&[0, 2], 1..2)]);
        assert_eq!((found[1].properties.len(), found[1].holds()), (1, true));
        // Restarted it does not hold there.
        let restarted = exploration("part: a, b, c, restarted", &[("never: a and c meet", "fails")]);
        let mut found = vec![whole(), restarted, small()];
        take_over(&mut found, &[part(&[0, 1, 2], 0..2), part(&[0, 2], 2..3)]);
        assert_eq!(found[2].properties[0].verdict, "fails");
        // It was not restarted there at all.
        let mut found = vec![whole(), exploration("part: a, c, restarted", &[("never: a and c meet", "fails")])];
        take_over(&mut found, &[part(&[0, 1, 2], 0..1), part(&[0, 2], 1..2)]);
        assert_eq!(found[1].properties[0].verdict, "fails");
        // Another one with as many stations is no larger one.
        let mut found = vec![whole(), small()];
        take_over(&mut found, &[part(&[0, 1], 0..1), part(&[0, 2], 1..2)]);
        assert_eq!(found[1].properties[0].verdict, "fails");
    }
}
