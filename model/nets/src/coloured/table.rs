//! A coloured net as plain text: domains, places with their tokens, transitions with their functions.
//!
//! Functions are shown by what they mean, not by how they were written: each component of the token as the component of
//! the mode it comes from, so many tones on. `<1,3+1>` is proj(1,3) after one successor of the third.

use std::fmt;

use super::guard::{Case, GuardOperand};
use super::linear::{ComponentPick, LinearTerm};
use super::net::{ColouredArc, ColouredNet};

impl fmt::Display for ColouredNet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (places, transitions) = (self.place_count(), self.transition_count());
        let tokens = self.initial.total();
        writeln!(f, "coloured net {}: places {places}, transitions {transitions}, tokens {tokens}", self.name())?;
        for basic in &self.basics {
            let tones: Vec<_> = basic.tones.iter().map(|tone| &**tone).collect();
            let named = if tones.is_empty() { String::new() } else { format!(": {}", tones.join(", ")) };
            writeln!(f, "  colours {} = 1..{}{named}", basic.name(), basic.size())?;
        }
        for p in self.places() {
            let (name, domain) = (&self.places[p.index()].name, self.show_domain(self.place_domain(p)));
            let shape = &self.places[p.index()].shape;
            let entries = super::bind::on_place(&self.initial.entries, &self.places[p.index()]);
            let show = |&(cell, count): &(u32, u32)| {
                let colour = shape.show(cell - self.places[p.index()].offset, &self.basics);
                let colour = if colour.is_empty() { "<•>".to_owned() } else { colour };
                if count == 1 { colour } else { format!("{count}*{colour}") }
            };
            let tokens: Vec<_> = entries.iter().map(show).collect();
            let tokens = if tokens.is_empty() { "0".to_owned() } else { tokens.join(" + ") };
            writeln!(f, "  place {name} of {domain} = {tokens}")?;
        }
        for t in self.transitions() {
            let transition = &self.transitions[t.index()];
            let domain = self.show_domain(&transition.shape.basics);
            let (takes, gives) = (self.bag(&transition.inputs), self.bag(&transition.outputs));
            writeln!(f, "  transition {} of {domain}: {takes} → {gives}", transition.name)?;
            if let Some(cases) = &transition.guard {
                writeln!(f, "    if {}", cases.iter().map(Case::to_string).collect::<Vec<_>>().join(" or "))?;
            }
        }
        Ok(())
    }
}

impl ColouredNet {
    fn bag(&self, sides: &[ColouredArc]) -> String {
        let show = |side: &ColouredArc| {
            let terms: Vec<_> = side.terms.iter().map(LinearTerm::to_string).collect();
            format!("{} {}", self.places[side.place.index()].name, terms.join("+"))
        };
        if sides.is_empty() { "nothing".to_owned() } else { sides.iter().map(show).collect::<Vec<_>>().join(", ") }
    }
}

fn turned(f: &mut fmt::Formatter<'_>, from: u32, shift: u32) -> fmt::Result {
    write!(f, "{}", from + 1)?;
    if shift > 0 { write!(f, "+{shift}") } else { Ok(()) }
}

impl fmt::Display for ComponentPick {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        turned(f, self.from, self.shift)
    }
}

impl fmt::Display for LinearTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.weight != 1 {
            write!(f, "{}*", self.weight)?;
        }
        if self.picks.is_empty() {
            return f.write_str("<•>");
        }
        let picks: Vec<_> = self.picks.iter().map(ComponentPick::to_string).collect();
        write!(f, "<{}>", picks.join(","))
    }
}

impl fmt::Display for GuardOperand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            GuardOperand::Number(number) => write!(f, "{number}"),
            GuardOperand::Component { from, shift, .. } => {
                f.write_str("<")?;
                turned(f, from, shift)?;
                f.write_str(">")
            }
        }
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts: Vec<_> = self.scheduled.then(|| "scheduled".to_owned()).into_iter().collect();
        parts.extend(self.tests.iter().map(|test| format!("{} {} {}", test.left, test.comparison, test.right)));
        f.write_str(if parts.is_empty() { "always".to_owned() } else { parts.join(" and ") }.as_str())
    }
}

#[cfg(test)]
mod tests {
    use crate::coloured::{Clause, ColouredBuilder, Domain, Guard, abs, colour, id, not_colour, proj, succ};

    #[test]
    fn a_coloured_net_reads_as_a_table() {
        let mut b = ColouredBuilder::new("loading");
        let machine = b.named_basic("M", ["drill", "mill"]);
        let part = b.basic("P", 3);
        let free = b.place("free", machine);
        let loaded = b.place("loaded", [machine, part]);
        let power = b.place("power", Domain::Uncoloured);
        b.tokens(free, &[1], 1).tokens(free, &[2], 2).tokens(power, &[], 4);
        let load = b.transition("load", Domain::Universal);
        b.input(load, free, proj([1])).input(load, power, 2 * abs()).output(load, loaded, id() + succ(2, 1));
        b.guard(
            load,
            Guard::any([Clause::all([colour(1, 1), not_colour(2, 3)]).scheduled(), Clause::all([colour(1, 2)])]),
        );
        let expected = "\
coloured net loading: places 3, transitions 1, tokens 7
  colours M = 1..2: drill, mill
  colours P = 1..3
  place free of M = <drill> + 2*<mill>
  place loaded of M*P = 0
  place power of <•> = 4*<•>
  transition load of M*P: free <1>, power 2*<•> → loaded <1,2>+<1,2+1>
    if scheduled and <1> = 1 and <2> ≠ 3 or <1> = 2
";
        assert_eq!(b.build().unwrap().to_string(), expected);
    }
}
