//! Files that come out of an analysis: the reachability graph, the drawing, the certificates.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use linewright_nets::{Net, Reachability, explore};
use miette::{IntoDiagnostic, WrapErr, miette};
use serde_json::json;

use super::decide::Findings;

/// A graph is written up to so many states: it is for looking at, and for tools that read all of it.
const STATES_MAX: u64 = 200_000;

/// Writes a text as a file.
pub fn text(file: &Path, text: &str) -> miette::Result<()> {
    std::fs::write(file, text).into_diagnostic().wrap_err_with(|| format!("cannot write {}", file.display()))
}

/// Writes all certificates; each begins with `claim:`.
pub fn certificates(file: &Path, net: &Net, findings: &Findings) -> miette::Result<()> {
    let accepted = |property| findings.by_structure(property).is_some();
    let certificates: Vec<String> =
        findings.structure.certificates().filter(|c| accepted(c.property)).map(ToString::to_string).collect();
    if certificates.is_empty() {
        return Err(miette!(
            help = "the answers above are by exploration or coverability, which leave no certificate",
            "structure decides nothing of {}, so there is no certificate to write",
            net.name()
        ));
    }
    text(file, &certificates.join("\n"))
}

/// How a graph is written.
#[derive(Clone, Copy)]
enum Format {
    Dot,
    Json,
    Aldebaran,
}

/// Plays the net out once more, now keeping every step, and writes the graph in the format that the name asks for.
pub fn graph(file: &Path, net: &Net, states: u64) -> miette::Result<()> {
    let name = file.display();
    let format = match file.extension().and_then(|extension| extension.to_str()) {
        Some("dot" | "gv") => Format::Dot,
        Some("json") => Format::Json,
        Some("aut") => Format::Aldebaran,
        _ => return Err(miette!(help = "end the name in .dot, .json or .aut", "{name} names no format for a graph")),
    };
    let limit = states.min(STATES_MAX);
    let graph = explore(net, limit as usize).map_err(|why| {
        miette!(help = format!("a graph is written up to {limit} states"), "no graph is written: {why}")
    })?;
    let cannot = || format!("cannot write {name}");
    let mut out = BufWriter::new(File::create(file).into_diagnostic().wrap_err_with(cannot)?);
    let written = match format {
        Format::Dot => dot(&mut out, net, &graph),
        Format::Json => serde_json::to_writer(&mut out, &value(net, &graph)).map_err(io::Error::from),
        Format::Aldebaran => aldebaran(&mut out, net, &graph),
    };
    written.and_then(|()| out.flush()).into_diagnostic().wrap_err_with(cannot)
}

/// A state is a box with the marked places in it, the initial one bold; an arc has the name of its transition.
fn dot(out: &mut impl Write, net: &Net, graph: &Reachability) -> io::Result<()> {
    writeln!(out, "digraph \"{}\" {{\n  node [shape=box];", escape(net.name()))?;
    for (state, marking) in graph.states().iter().enumerate() {
        let bold = if state == 0 { ", penwidth=2" } else { "" };
        writeln!(out, "  s{state} [label=\"{}\"{bold}];", escape(&net.describe(marking)))?;
    }
    for step in graph.steps() {
        let label = escape(net.transition_name(step.transition));
        writeln!(out, "  s{} -> s{} [label=\"{label}\"];", step.from.0, step.to.0)?;
    }
    writeln!(out, "}}")
}

/// `des (initial, arcs, states)`, then a line per arc.
fn aldebaran(out: &mut impl Write, net: &Net, graph: &Reachability) -> io::Result<()> {
    writeln!(out, "des (0, {}, {})", graph.steps().len(), graph.states().len())?;
    for step in graph.steps() {
        let label = net.transition_name(step.transition).replace(['"', '\n', '\r'], "'");
        writeln!(out, "({}, \"{label}\", {})", step.from.0, step.to.0)?;
    }
    Ok(())
}

fn value(net: &Net, graph: &Reachability) -> serde_json::Value {
    let places: Vec<_> = net.places().map(|p| net.place_name(p)).collect();
    let transitions: Vec<_> = net.transitions().map(|t| net.transition_name(t)).collect();
    let states: Vec<_> = graph.states().iter().map(|marking| marking.as_slice()).collect();
    let steps: Vec<_> = graph.steps().iter().map(|step| (step.from.0, step.transition.0, step.to.0)).collect();
    json!({ "places": places, "transitions": transitions, "states": states, "arcs": steps })
}

/// The inside of a quoted DOT string.
fn escape(name: &str) -> String {
    name.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}
