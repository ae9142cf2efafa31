//! The answers for people: a short table, the counterexamples, and what is not decided.

use std::fmt::Write;

use super::plays::ViolationPath;
use super::report::{AnalysisReport, ReportedFlow};

/// Most semiflows shown; `--json` has more.
const FLOWS_SHOWN: usize = 12;

/// Most names of a list shown, and most steps of a sequence.
const NAMES_SHOWN: usize = 12;
const STEPS_SHOWN: usize = 40;

/// The report in words.
pub fn text(report: &AnalysisReport) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    write(report, &mut out).expect("a string accepts every write");
    // A name from a file must not reach the terminal as a command.
    out.replace(|c: char| c.is_control() && c != '\n', " ")
}

fn write(r: &AnalysisReport, out: &mut String) -> std::fmt::Result {
    let class = if r.class.is_empty() { "of no special class".to_owned() } else { r.class.join(", ") };
    writeln!(out, "{}: {} places, {} transitions; {class}\n", r.net, r.places, r.transitions)?;
    let by = &r.decided_by;
    let answers = [
        ("bounded", r.bounded, by.bounded),
        ("safe", r.safe, by.safe),
        ("deadlock-free", r.deadlock_free, by.deadlock_free),
        ("live", r.live, by.live),
        ("reversible", r.reversible, by.reversible),
    ];
    for (name, holds, by) in answers {
        let word = holds.map_or("undecided", |holds| if holds { "yes" } else { "no" });
        writeln!(out, "  {:<14} {}", name, by.map_or(word.to_owned(), |by| format!("{word:<9}  by {by}")))?;
    }
    let number = |n: Option<u64>| n.map_or("undecided".to_owned(), |n| n.to_string());
    writeln!(out)?;
    writeln!(out, "  {:<14} {}", "bound", if r.bounded == Some(false) { "none".to_owned() } else { number(r.bound) })?;
    writeln!(out, "  {:<14} {}", "states", number(r.states))?;
    writeln!(out, "  {:<14} {}", "arcs", number(r.arcs))?;
    writeln!(out, "  {:<14} {}", "deadlocks", number(r.deadlocks))?;
    writeln!(out, "  {:<14} {}", "home states", number(r.home_states))?;
    writeln!(out, "  {:<14} {}", "P-semiflows", number(r.p_semiflows.map(|n| n as u64)))?;
    writeln!(out, "  {:<14} {}", "T-semiflows", number(r.t_semiflows.map(|n| n as u64)))?;
    names(out, "dead transitions", r.dead_transitions.as_deref())?;
    names(out, "not live", r.transitions_not_live.as_deref())?;
    names(out, "unbounded", r.unbounded_places.as_deref())?;
    flows(out, "conserved sums", &r.place_semiflows)?;
    flows(out, "repetitions", &r.transition_semiflows)?;
    for play in &r.counterexamples {
        counterexample(out, play)?;
    }
    if !r.undecided.is_empty() {
        writeln!(out, "\nundecided:")?;
        r.undecided.iter().try_for_each(|open| writeln!(out, "- {open}"))?;
    }
    let bytes = r.bytes.map_or(String::new(), |bytes| format!(", {bytes} bytes for the markings"));
    writeln!(out, "\n{:.3} s{bytes}", r.seconds)
}

fn names(out: &mut String, what: &str, names: Option<&[String]>) -> std::fmt::Result {
    match names {
        None | Some([]) => Ok(()),
        Some(names) => writeln!(out, "\n{what}: {}", some(names, NAMES_SHOWN, ", ")),
    }
}

fn some(words: &[String], most: usize, between: &str) -> String {
    match words.len().checked_sub(most) {
        None | Some(0) => words.join(between),
        Some(more) => format!("{}{between}… and {more} more", words[..most].join(between)),
    }
}

fn flows(out: &mut String, what: &str, flows: &[ReportedFlow]) -> std::fmt::Result {
    if flows.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{what}:")?;
    let term = |(name, weight): &(String, u64)| if *weight == 1 { name.clone() } else { format!("{weight} {name}") };
    for flow in flows.iter().take(FLOWS_SHOWN) {
        let terms: Vec<_> = flow.weights.iter().map(term).collect();
        let sum = flow.sum.map_or(String::new(), |sum| format!(" = {sum}"));
        writeln!(out, "  {}{sum}", some(&terms, NAMES_SHOWN, " + "))?;
    }
    match flows.len().checked_sub(FLOWS_SHOWN) {
        None | Some(0) => Ok(()),
        Some(more) => writeln!(out, "  … and {more} more"),
    }
}

fn counterexample(out: &mut String, play: &ViolationPath) -> std::fmt::Result {
    let of = play.of.as_ref().map_or(String::new(), |of| format!(" ({of})"));
    writeln!(out, "\n{}{of}:", play.shows)?;
    let fire = if play.fire.is_empty() {
        "nothing, it is so initially".to_owned()
    } else {
        some(&play.fire, STEPS_SHOWN, ", ")
    };
    writeln!(out, "  fire    {fire}")?;
    if !play.repeat.is_empty() {
        writeln!(out, "  repeat  {}", some(&play.repeat, STEPS_SHOWN, ", "))?;
    }
    let tokens =
        |(name, tokens): &(String, u32)| if *tokens == 1 { name.clone() } else { format!("{name} ×{tokens}") };
    let marking: Vec<_> = play.marking.iter().map(tokens).collect();
    writeln!(
        out,
        "  then    {}",
        if marking.is_empty() { "no tokens".to_owned() } else { some(&marking, STEPS_SHOWN, ", ") }
    )
}
