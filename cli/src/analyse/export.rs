//! Files that come out of an analysis: the reachability graph, the drawing, the certificates.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use linewright_nets::Net;
use linewright_nets::explicit::{ExplorationLimits, GraphEvent, walk};
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

/// File format of a graph.
#[derive(Clone, Copy)]
pub enum GraphFormat {
    Dot,
    Json,
    Aldebaran,
}

impl GraphFormat {
    /// The format of a file's name.
    pub fn of(file: &Path) -> miette::Result<GraphFormat> {
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("dot" | "gv") => Ok(GraphFormat::Dot),
            Some("json") => Ok(GraphFormat::Json),
            Some("aut") => Ok(GraphFormat::Aldebaran),
            _ => Err(miette!(
                help = "end the name in .dot, .json or .aut",
                "{} names no format for a graph",
                file.display()
            )),
        }
    }
}

/// Plays the net out once more, and again while the graph is written: the arcs are never held, and the states are within
/// the limits.
pub fn graph(file: &Path, format: GraphFormat, net: &Net, limits: &ExplorationLimits) -> miette::Result<()> {
    let limits = ExplorationLimits { states: limits.states.min(STATES_MAX), ..*limits };
    let (mut states, mut arcs) = (0_u64, 0_u64);
    let count = |event: GraphEvent| match event {
        GraphEvent::State(..) => states += 1,
        GraphEvent::Arc { .. } => arcs += 1,
    };
    walk(net, &limits, count).map_err(|why| {
        miette!(help = format!("a graph is written up to {} states", limits.states), "no graph is written: {why}")
    })?;
    let cannot = || format!("cannot write {}", file.display());
    let mut out = BufWriter::new(File::create(file).into_diagnostic().wrap_err_with(cannot)?);
    let graph = ReachabilityGraph { net, limits, states, arcs };
    let written = match format {
        GraphFormat::Dot => graph.dot(&mut out),
        GraphFormat::Json => graph.json(&mut out),
        GraphFormat::Aldebaran => graph.aldebaran(&mut out),
    };
    written.and_then(|()| out.flush()).into_diagnostic().wrap_err_with(cannot)
}

/// A graph that has been seen to end within the limits.
struct ReachabilityGraph<'a> {
    net: &'a Net,
    limits: ExplorationLimits,
    states: u64,
    arcs: u64,
}

impl ReachabilityGraph<'_> {
    /// Shows the graph, each piece with the number of the last state shown.
    fn show(&self, mut write: impl FnMut(u32, GraphEvent) -> io::Result<()>) -> io::Result<()> {
        let (mut written, mut last) = (Ok(()), 0);
        let show = |event: GraphEvent| {
            if let GraphEvent::State(state, _) = &event {
                last = state.0;
            }
            if written.is_ok() {
                written = write(last, event);
            }
        };
        walk(self.net, &self.limits, show).map_err(io::Error::other)?;
        written
    }

    /// A state is a box with the marked places in it, the initial one bold; an arc has the name of its transition.
    fn dot(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "digraph \"{}\" {{\n  node [shape=box];", escape(self.net.name()))?;
        self.show(|from, event| match event {
            GraphEvent::State(state, marking) => {
                let bold = if state.0 == 0 { ", penwidth=2" } else { "" };
                let label = escape(&self.net.describe(&marking.to_marking()));
                writeln!(out, "  s{} [label=\"{label}\"{bold}];", state.0)
            }
            GraphEvent::Arc { transition, to } => {
                let label = escape(self.net.transition_name(transition));
                writeln!(out, "  s{from} -> s{} [label=\"{label}\"];", to.0)
            }
        })?;
        writeln!(out, "}}")
    }

    /// `des (initial, arcs, states)`, then a line per arc.
    fn aldebaran(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "des (0, {}, {})", self.arcs, self.states)?;
        self.show(|from, event| match event {
            GraphEvent::State(..) => Ok(()),
            GraphEvent::Arc { transition, to } => {
                let label = self.net.transition_name(transition).replace(['"', '\n', '\r'], "'");
                writeln!(out, "({from}, \"{label}\", {})", to.0)
            }
        })
    }

    fn json(&self, out: &mut impl Write) -> io::Result<()> {
        let places: Vec<_> = self.net.places().map(|p| self.net.place_name(p)).collect();
        let transitions: Vec<_> = self.net.transitions().map(|t| self.net.transition_name(t)).collect();
        write!(out, "{{\"places\":{},\"transitions\":{},\"states\":[", json!(places), json!(transitions))?;
        self.show(|_, event| match event {
            GraphEvent::State(state, marking) => {
                let comma = if state.0 == 0 { "" } else { "," };
                write!(out, "{comma}{}", json!(marking.to_marking().as_slice()))
            }
            GraphEvent::Arc { .. } => Ok(()),
        })?;
        write!(out, "],\"arcs\":[")?;
        let mut comma = "";
        self.show(|from, event| match event {
            GraphEvent::State(..) => Ok(()),
            GraphEvent::Arc { transition, to } => {
                write!(out, "{comma}[{from},{},{}]", transition.0, to.0)?;
                comma = ",";
                Ok(())
            }
        })?;
        writeln!(out, "]}}")
    }
}

/// The inside of a quoted DOT string.
fn escape(name: &str) -> String {
    name.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}
