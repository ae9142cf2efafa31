//! Certificates as text, for a file or another program.
//!
//! One line per item, a key and a list of words. Places are `p0`, `p1`, … and transitions `t0`, `t1`, … in the order of
//! declaration in the net; `t3x5` is t3 five times in a row, `p2*-1` is p2 with the weight −1, `4=7` is "by sum 4, at
//! most 7". Lines that begin with `#` and empty lines are skipped. Reading builds data and judges nothing: whether the
//! numbers exist in a net and prove anything is for [`super::check`].

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::evidence::{
    Certificate, Component, Dead, Evidence, FiringOrder, NetProperty, NoReturn, RepeatedFiring, Sums, UnboundedCycle,
    WellFormed,
};
use crate::{PlaceId, TransitionId};

/// Reason why a text is no certificate.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {what}")]
pub struct ParseError {
    /// The line, from 1; one more than there are lines if the end came too early.
    pub line: usize,
    /// Text expected, and text found.
    pub what: String,
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "claim: {} {}", self.property, if self.holds { "yes" } else { "no" })?;
        match &self.evidence {
            Evidence::Order(order) => {
                writeln!(f, "evidence: order")?;
                line(f, "order", order.transitions.iter().map(|t| format!("t{}", t.0)))
            }
            Evidence::Components(parts) => {
                writeln!(f, "evidence: components")?;
                parts.iter().try_for_each(|part| {
                    line(f, "root", [format!("p{}", part.root.0)].into_iter())?;
                    line(f, "out", part.out.iter().map(|t| format!("t{}", t.0)))?;
                    line(f, "back", part.back.iter().map(|t| format!("t{}", t.0)))
                })
            }
            Evidence::Trap(trap) => {
                writeln!(f, "evidence: trap")?;
                places(f, "trap", trap)
            }
            Evidence::Sums(sums) => {
                writeln!(f, "evidence: sums")?;
                places(f, "dead", &sums.dead)?;
                sums.sums
                    .iter()
                    .try_for_each(|sum| line(f, "sum", sum.iter().map(|(p, weight)| format!("p{}*{weight}", p.0))))?;
                line(f, "bounds", sums.bounds.iter().map(|(sum, bound)| format!("{sum}={bound}")))
            }
            Evidence::WellFormed(formed) => {
                writeln!(f, "evidence: well-formed")?;
                well_formed(f, formed)
            }
            Evidence::UnmarkedTrap(formed, trap) => {
                writeln!(f, "evidence: unmarked-trap")?;
                well_formed(f, formed)?;
                places(f, "trap", trap)
            }
            Evidence::Dead(dead) => {
                writeln!(f, "evidence: dead")?;
                runs(f, "run", &dead.run)?;
                places(f, "siphon", &dead.siphon)?;
                line(f, "transition", [format!("t{}", dead.transition.0)].into_iter())
            }
            Evidence::Deadlock(run) => {
                writeln!(f, "evidence: deadlock")?;
                runs(f, "run", run)
            }
            Evidence::Overfull(run, place) => {
                writeln!(f, "evidence: overfull")?;
                runs(f, "run", run)?;
                places(f, "place", &[*place])
            }
            Evidence::Pump(pump) => {
                writeln!(f, "evidence: pump")?;
                runs(f, "prefix", &pump.prefix)?;
                runs(f, "cycle", &pump.cycle)?;
                places(f, "place", &[pump.place])
            }
            Evidence::NoReturn(no_return) => {
                writeln!(f, "evidence: no-return")?;
                runs(f, "run", &no_return.run)?;
                places(f, "dead", &no_return.dead)?;
                line(f, "weights", no_return.weights.iter().map(|(p, weight)| format!("p{}*{weight}", p.0)))
            }
        }
    }
}

fn line(f: &mut fmt::Formatter<'_>, key: &str, words: impl Iterator<Item = String>) -> fmt::Result {
    write!(f, "{key}:")?;
    for word in words {
        write!(f, " {word}")?;
    }
    writeln!(f)
}

fn places(f: &mut fmt::Formatter<'_>, key: &str, places: &[PlaceId]) -> fmt::Result {
    line(f, key, places.iter().map(|place| format!("p{}", place.0)))
}

fn runs(f: &mut fmt::Formatter<'_>, key: &str, runs: &[RepeatedFiring]) -> fmt::Result {
    line(f, key, runs.iter().map(|run| format!("t{}x{}", run.transition.0, run.times)))
}

fn well_formed(f: &mut fmt::Formatter<'_>, formed: &WellFormed) -> fmt::Result {
    line(f, "conserved", formed.conserved.iter().map(u64::to_string))?;
    line(f, "repeated", formed.repeated.iter().map(u64::to_string))?;
    formed.flows.iter().try_for_each(|flow| line(f, "flow", flow.iter().map(|(t, n)| format!("t{}*{n}", t.0))))
}

impl Certificate {
    /// Reads what `Display` writes.
    pub fn parse(text: &str) -> Result<Certificate, ParseError> {
        let mut lines = CertificateLines::new(text);
        let claim = lines.next("claim")?;
        let property = |name: &&str| NetProperty::ALL.into_iter().find(|property| property.to_string() == **name);
        let (Some(property), Some(holds)) = (claim.words.first().and_then(property), answer(&claim.words)) else {
            return Err(claim.error("expected a property and `yes` or `no`"));
        };
        let kind = lines.next("evidence")?;
        let evidence = match kind.words[..] {
            ["order"] => Evidence::Order(FiringOrder { transitions: lines.next("order")?.all(transition)? }),
            ["components"] => Evidence::Components(lines.components()?),
            ["trap"] => Evidence::Trap(lines.next("trap")?.all(place)?),
            ["sums"] => Evidence::Sums(lines.sums()?),
            ["well-formed"] => Evidence::WellFormed(lines.well_formed()?),
            ["unmarked-trap"] => Evidence::UnmarkedTrap(lines.well_formed()?, lines.next("trap")?.all(place)?),
            ["dead"] => Evidence::Dead(Dead {
                run: lines.next("run")?.all(run)?,
                siphon: lines.next("siphon")?.all(place)?,
                transition: lines.next("transition")?.one(transition)?,
            }),
            ["deadlock"] => Evidence::Deadlock(lines.next("run")?.all(run)?),
            ["overfull"] => Evidence::Overfull(lines.next("run")?.all(run)?, lines.next("place")?.one(place)?),
            ["pump"] => Evidence::Pump(UnboundedCycle {
                prefix: lines.next("prefix")?.all(run)?,
                cycle: lines.next("cycle")?.all(run)?,
                place: lines.next("place")?.one(place)?,
            }),
            ["no-return"] => Evidence::NoReturn(NoReturn {
                run: lines.next("run")?.all(run)?,
                dead: lines.next("dead")?.all(place)?,
                weights: lines.next("weights")?.all(weighed)?,
            }),
            _ => return Err(kind.error("this kind of evidence is not known")),
        };
        match lines.rest.first() {
            Some(&(line, text)) => {
                Err(ParseError { line, what: format!("nothing more was expected, but `{text}` is there") })
            }
            None => Ok(Certificate { property, holds, evidence }),
        }
    }
}

fn answer(words: &[&str]) -> Option<bool> {
    match words {
        [_, "yes"] => Some(true),
        [_, "no"] => Some(false),
        _ => None,
    }
}

/// The lines that are left.
struct CertificateLines<'text> {
    rest: Vec<(usize, &'text str)>,
    end: usize,
}

/// One line, without its key.
struct CertificateLine<'text> {
    number: usize,
    words: Vec<&'text str>,
}

impl<'text> CertificateLines<'text> {
    fn new(text: &'text str) -> Self {
        let lines = (1..).zip(text.lines().map(str::trim));
        let mut rest: Vec<_> = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).collect();
        // The next line is the last one here.
        rest.reverse();
        CertificateLines { rest, end: text.lines().count() + 1 }
    }

    fn has(&self, key: &str) -> bool {
        self.rest.last().is_some_and(|(_, line)| line.split_once(':').is_some_and(|(found, _)| found == key))
    }

    fn next(&mut self, key: &str) -> Result<CertificateLine<'text>, ParseError> {
        let expected = |line, found: &str| ParseError { line, what: format!("expected `{key}:`, found {found}") };
        let (number, text) = self.rest.pop().ok_or_else(|| expected(self.end, "the end"))?;
        match text.split_once(':') {
            Some((found, words)) if found == key => {
                Ok(CertificateLine { number, words: words.split_whitespace().collect() })
            }
            _ => Err(expected(number, &format!("`{text}`"))),
        }
    }

    fn components(&mut self) -> Result<Vec<Component>, ParseError> {
        let mut parts = Vec::new();
        while self.has("root") {
            parts.push(Component {
                root: self.next("root")?.one(place)?,
                out: self.next("out")?.all(transition)?,
                back: self.next("back")?.all(transition)?,
            });
        }
        Ok(parts)
    }

    fn sums(&mut self) -> Result<Sums, ParseError> {
        let mut sums = Sums { dead: self.next("dead")?.all(place)?, ..Sums::default() };
        while self.has("sum") {
            sums.sums.push(self.next("sum")?.all(weighed)?);
        }
        sums.bounds = self.next("bounds")?.all(|word| {
            let (sum, bound) = word.split_once('=')?;
            Some((sum.parse().ok()?, bound.parse().ok()?))
        })?;
        Ok(sums)
    }

    fn well_formed(&mut self) -> Result<WellFormed, ParseError> {
        let number = |word: &str| word.parse().ok();
        let mut formed = WellFormed {
            conserved: self.next("conserved")?.all(number)?,
            repeated: self.next("repeated")?.all(number)?,
            flows: Vec::new(),
        };
        while self.has("flow") {
            formed.flows.push(self.next("flow")?.all(|word| {
                let (t, count) = word.split_once('*')?;
                Some((transition(t)?, count.parse().ok()?))
            })?);
        }
        Ok(formed)
    }
}

impl CertificateLine<'_> {
    fn error(&self, what: &str) -> ParseError {
        ParseError { line: self.number, what: format!("{what}, found `{}`", self.words.join(" ")) }
    }

    fn all<T>(&self, read: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, ParseError> {
        let what = |word: &str| ParseError { line: self.number, what: format!("`{word}` cannot be read here") };
        self.words.iter().map(|word| read(word).ok_or_else(|| what(word))).collect()
    }

    fn one<T>(&self, read: impl Fn(&str) -> Option<T>) -> Result<T, ParseError> {
        let mut all = self.all(read)?;
        match (all.pop(), all.pop()) {
            (Some(one), None) => Ok(one),
            _ => Err(self.error("expected one word")),
        }
    }
}

fn place(word: &str) -> Option<PlaceId> {
    word.strip_prefix('p')?.parse().ok().map(PlaceId)
}

fn transition(word: &str) -> Option<TransitionId> {
    word.strip_prefix('t')?.parse().ok().map(TransitionId)
}

fn run(word: &str) -> Option<RepeatedFiring> {
    let (t, times) = word.split_once('x')?;
    Some(RepeatedFiring { transition: transition(t)?, times: times.parse().ok()? })
}

fn weighed<N: FromStr>(word: &str) -> Option<(PlaceId, N)> {
    let (p, weight) = word.split_once('*')?;
    Some((place(p)?, weight.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_can_be_read_back() {
        let run = vec![
            RepeatedFiring { transition: TransitionId(3), times: 5 },
            RepeatedFiring { transition: TransitionId(0), times: 1 },
        ];
        let no_return = NoReturn { run, dead: vec![], weights: vec![(PlaceId(2), -1), (PlaceId(7), 4)] };
        let certificate =
            Certificate { property: NetProperty::Reversible, holds: false, evidence: Evidence::NoReturn(no_return) };
        let text = certificate.to_string();
        assert_eq!(text, "claim: reversible no\nevidence: no-return\nrun: t3x5 t0x1\ndead:\nweights: p2*-1 p7*4\n");
        assert_eq!(Certificate::parse(&text), Ok(certificate));
    }

    #[test]
    fn what_cannot_be_read_is_shown() {
        let error = |text: &str| Certificate::parse(text).unwrap_err().to_string();
        assert_eq!(error(""), "line 1: expected `claim:`, found the end");
        assert_eq!(error("claim: live maybe"), "line 1: expected a property and `yes` or `no`, found `live maybe`");
        assert_eq!(
            error("claim: live yes\nevidence: faith"),
            "line 2: this kind of evidence is not known, found `faith`"
        );
        assert_eq!(error("claim: live yes\n\nevidence: order\norder: t1 x2"), "line 4: `x2` cannot be read here");
        assert_eq!(
            error("claim: live yes\nevidence: order\norder: t1\norder: t2"),
            "line 4: nothing more was expected, but `order: t2` is there"
        );
    }
}
