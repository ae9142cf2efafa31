//! A line explored in parts, each once, and larger ones where a part reaches a conflict.

use linewright_line::Line;
use linewright_proof::explore::LineNotExplorable;
use linewright_proof::parts::{self, SubLine};
use linewright_proof::structure::chart::{direct_arrows, written};

use super::explored::{Exploration, LineFinding};
use super::explorer::{Explorer, PART};
use super::larger::{self, PartFound};

/// Explores one part, under its name.
pub type EachPart<'a> = fn(&Explorer<'a>, &Line, &str) -> Result<Vec<Exploration>, LineNotExplorable>;

impl<'a> Explorer<'a> {
    /// Parts of this line; those that are alike are explored once. Beside what was found stand the parts, larger ones behind the others.
    pub(super) fn by_parts(
        &self,
        line: &Line,
        parts: Vec<SubLine>,
        what: &str,
        each: EachPart<'a>,
    ) -> Result<(Vec<Exploration>, Vec<PartFound>), LineNotExplorable> {
        let (mut found, mut explored) = (Vec::new(), Vec::new());
        let number = parts.len();
        for (nth, part) in parts.into_iter().enumerate() {
            self.progress
                .in_part(nth + 1, number, || self.add_part(line, part, what, each, (&mut found, &mut explored)))?;
        }
        // Arrows join the parts: what is explored alone has no larger one.
        if what == PART {
            self.add_larger(line, each, (&mut found, &mut explored))?;
            larger::take_over(&mut found, &explored);
        }
        Ok((found, explored))
    }

    fn add_part(
        &self,
        line: &Line,
        part: SubLine,
        what: &str,
        each: EachPart<'a>,
        (found, parts): (&mut Vec<Exploration>, &mut Vec<PartFound>),
    ) -> Result<(), LineNotExplorable> {
        let begins = found.len();
        let like = parts.iter().find(|other| part.is_like(&other.part));
        let known = like.map(|other| (other.holds, other.kept));
        let mut explored = match like {
            Some(other) => vec![Exploration::like(&part, what, &other.part.names(), other.holds)],
            None => match each(self, &part.line, &format!("{what}: {}", part.names())) {
                // A part that is too large leaves its conflicts open, and the others are decided.
                Err(why) if !matches!(why, LineNotExplorable::Compile(_)) => {
                    vec![Exploration::unexplored(&part, what, "undecided", &why.to_string())]
                }
                explored => explored?,
            },
        };
        // Arrows join the stations of a part to those outside it; one that is explored alone has none.
        if what == PART {
            let (mut arrows, mut kept_apart) = (Vec::new(), Vec::new());
            for (at, arrow) in direct_arrows(line, &part) {
                arrows.push(written(line, &arrow));
                kept_apart.push(format!("never: {}", part.line.conflicts[at].why));
            }
            arrows.sort_unstable();
            arrows.dedup();
            let outside = line.station_ids().filter(|id| !part.stations.contains(id));
            let outside: Vec<String> = outside.map(|id| line.station(id).name.clone()).collect();
            for exploration in &mut explored {
                exploration.left_out.extend(outside.iter().cloned());
                // A smaller part within this one has its own already.
                let is_open = exploration.properties.iter().any(LineFinding::is_open_by_parts);
                if is_open && exploration.direct_arrows.is_empty() {
                    exploration.direct_arrows.clone_from(&arrows);
                    exploration.kept_apart.clone_from(&kept_apart);
                }
            }
        }
        let found_now = || (explored.iter().all(Exploration::holds), explored.first().map_or(0, |first| first.kept));
        let (holds, kept) = known.unwrap_or_else(found_now);
        found.extend(explored);
        parts.push(PartFound { part, holds, kept, explorations: begins..found.len() });
        Ok(())
    }

    /// Where a part reaches a conflict, it is explored with the stations that may prevent it, as long as these do.
    fn add_larger(
        &self,
        line: &Line,
        each: EachPart<'a>,
        (found, parts): (&mut Vec<Exploration>, &mut Vec<PartFound>),
    ) -> Result<(), LineNotExplorable> {
        for at in 0..parts.len() {
            let open = |one: &Exploration| one.properties.iter().any(LineFinding::is_open_by_parts);
            if !found[parts[at].explorations.clone()].iter().any(open) {
                continue;
            }
            let Some(larger) = parts::larger(line, &parts[at].part) else { continue };
            // The whole line is for `--whole`.
            let is_known = parts.iter().any(|other| other.part.stations == larger.stations);
            if is_known || larger.stations.len() == line.stations.len() {
                continue;
            }
            self.add_part(line, larger, PART, each, (found, parts))?;
            if parts.last().is_some_and(|larger| !larger.holds) {
                break;
            }
        }
        Ok(())
    }
}

impl Exploration {
    /// A part that differs in names and times alone from one that has been explored.
    fn like(part: &SubLine, what: &str, other: &str, holds: bool) -> Self {
        let verdict = if holds { "holds" } else { "undecided" };
        Exploration::unexplored(part, what, verdict, &format!("differs from {other} in names and times alone"))
    }

    /// The conflicts of a part that is not explored itself; of one without conflicts, that it is not.
    fn unexplored(part: &SubLine, what: &str, verdict: &'static str, reason: &str) -> Self {
        let property = |(name, holds_by_parts)| {
            let (reason, is_left_open) = (reason.to_owned(), holds_by_parts && verdict == "undecided");
            LineFinding { name, verdict, reason, counterexample: None, holds_by_parts, is_left_open }
        };
        let conflicts = part.line.conflicts.iter().map(|conflict| (format!("never: {}", conflict.why), true));
        let whole = part.line.conflicts.is_empty().then(|| ("explored".to_owned(), false));
        Exploration {
            scope: format!("{what}: {}", part.names()),
            states: 0,
            kept: 0,
            arcs: 0,
            bytes: 0,
            exhausted: verdict == "holds",
            help: None,
            left_out: Vec::new(),
            direct_arrows: Vec::new(),
            kept_apart: Vec::new(),
            is_left_to_parts: false,
            is_restarted: false,
            properties: conflicts.chain(whole).map(property).collect(),
        }
    }
}
