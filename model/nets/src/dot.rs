//! A net as a GraphViz drawing.
//!
//! Circles and bars as in any textbook, with the initial tokens as a number below the name. Node ids are `p0`, `t0` and
//! so on, so that names can contain anything. The drawing shows structure only; a caller with more to show (conditions,
//! actions) has its own export.

use std::fmt::Write;

use crate::Net;

/// The net in the DOT language, with its initial marking.
pub fn dot(net: &Net) -> String {
    let mut out = format!("digraph \"{}\" {{\n", escape(net.name()));
    // Writing to a string cannot fail.
    write(net, &mut out).expect("a string accepts every write");
    out
}

fn write(net: &Net, out: &mut String) -> std::fmt::Result {
    writeln!(out, "  node [shape=circle];")?;
    let initial = net.initial_marking();
    for p in net.places() {
        let name = escape(net.place_name(p));
        match initial.tokens(p) {
            0 => writeln!(out, "  p{} [label=\"{name}\"];", p.0)?,
            tokens => writeln!(out, "  p{} [label=\"{name}\\n{tokens}\", penwidth=2];", p.0)?,
        }
    }
    writeln!(out, "  node [shape=box, height=0.1];")?;
    for t in net.transitions() {
        writeln!(out, "  t{} [label=\"{}\"];", t.0, escape(net.transition_name(t)))?;
    }
    for t in net.transitions() {
        for &(p, weight) in net.preset(t) {
            writeln!(out, "  p{} -> t{}{};", p.0, t.0, label(weight))?;
        }
        for &(p, weight) in net.postset(t) {
            writeln!(out, "  t{} -> p{}{};", t.0, p.0, label(weight))?;
        }
    }
    writeln!(out, "}}")
}

fn label(weight: u32) -> String {
    if weight == 1 { String::new() } else { format!(" [label=\"{weight}\"]") }
}

/// The inside of a quoted DOT string.
fn escape(name: &str) -> String {
    name.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NetBuilder;

    #[test]
    fn names_weights_and_tokens_are_drawn() {
        let mut b = NetBuilder::new("the \"line\"");
        let bolts = b.place("bolts", 4);
        let part = b.place("part\\A", 0);
        let screw = b.transition("screw\nin");
        b.input(screw, bolts, 4).output(screw, part, 1);
        let expected = r#"digraph "the \"line\"" {
  node [shape=circle];
  p0 [label="bolts\n4", penwidth=2];
  p1 [label="part\\A"];
  node [shape=box, height=0.1];
  t0 [label="screw\nin"];
  p0 -> t0 [label="4"];
  t0 -> p1;
}
"#;
        assert_eq!(dot(&b.build().unwrap()), expected);
    }
}
