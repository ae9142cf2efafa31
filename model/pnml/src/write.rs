//! A net as PNML of the standard's place/transition nets, on one page and without drawing.
//!
//! Ids are numbers (`p0`, `t0`, `a0`), because a name can be anything and an id cannot; the names are beside them. A
//! character that XML has no way to write, such as a bell, becomes U+FFFD.

use std::fmt::{self, Write};

use linewright_nets::Net;

use crate::xml::is_legal;

/// The net as a PNML file.
pub fn write(net: &Net) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    file(net, &mut out).expect("a string accepts every write");
    out
}

fn file(net: &Net, out: &mut String) -> fmt::Result {
    out.push_str("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    out.push_str("<pnml xmlns=\"http://www.pnml.org/version-2009/grammar/pnml\">\n");
    out.push_str("  <net id=\"net\" type=\"http://www.pnml.org/version-2009/grammar/ptnet\">\n");
    writeln!(out, "    {}", EscapedName(net.name()))?;
    out.push_str("    <page id=\"page\">\n");
    let initial = net.initial_marking();
    for p in net.places() {
        write!(out, "      <place id=\"p{}\">{}", p.0, EscapedName(net.place_name(p)))?;
        if initial.tokens(p) > 0 {
            write!(out, "<initialMarking><text>{}</text></initialMarking>", initial.tokens(p))?;
        }
        out.push_str("</place>\n");
    }
    for t in net.transitions() {
        writeln!(out, "      <transition id=\"t{}\">{}</transition>", t.0, EscapedName(net.transition_name(t)))?;
    }
    let mut count = 0_usize;
    let mut arc = |out: &mut String, source: fmt::Arguments<'_>, target: fmt::Arguments<'_>, weight: u32| {
        write!(out, "      <arc id=\"a{count}\" source=\"{source}\" target=\"{target}\"")?;
        count += 1;
        match weight {
            1 => writeln!(out, "/>"),
            _ => writeln!(out, "><inscription><text>{weight}</text></inscription></arc>"),
        }
    };
    for t in net.transitions() {
        for &(p, weight) in net.preset(t) {
            arc(out, format_args!("p{}", p.0), format_args!("t{}", t.0), weight)?;
        }
        for &(p, weight) in net.postset(t) {
            arc(out, format_args!("t{}", t.0), format_args!("p{}", p.0), weight)?;
        }
    }
    out.push_str("    </page>\n  </net>\n</pnml>\n");
    Ok(())
}

/// A name as a label. Blanks at its ends and line ends within it are written as references: readers drop or change
/// them otherwise.
struct EscapedName<'a>(&'a str);

impl fmt::Display for EscapedName<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("<name><text>")?;
        let inside = self.0.trim();
        let start = inside.as_ptr() as usize - self.0.as_ptr() as usize;
        for (at, c) in self.0.char_indices() {
            let is_end = at < start || at >= start + inside.len();
            match c {
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '&' => f.write_str("&amp;")?,
                '\t' | '\n' | '\r' => write!(f, "&#{};", c as u32)?,
                c if !is_legal(c) => f.write_char('\u{FFFD}')?,
                // What counts as a line end in some version of XML, or as a blank that may be dropped.
                c if c.is_control() || c == '\u{2028}' || (is_end && c.is_whitespace()) => {
                    write!(f, "&#{};", c as u32)?
                }
                c => f.write_char(c)?,
            }
        }
        f.write_str("</text></name>")
    }
}
