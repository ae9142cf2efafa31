//! The report of a run, and its exit code.

use std::process::ExitCode;

use miette::IntoDiagnostic;

use super::cell::CellRun;
use super::{Args, Session};
use crate::states::mode_name;

impl Session {
    /// Prints the report.
    pub(super) fn report(&self, args: &Args, outcome: miette::Result<()>, restarts: u32) -> miette::Result<ExitCode> {
        let faults = self.tally.faults();
        let parts = self.cell.as_ref().map(CellRun::made).filter(|(_, wanted)| *wanted > 0);
        let short = self.target.is_some_and(|target| self.tally.cycles() < target);
        let short = short || parts.is_some_and(|(made, wanted)| made < wanted);
        let conflicts = self.observer.conflicts();
        let ok = outcome.is_ok() && !short && conflicts.is_empty() && (!self.ends() || faults == 0);
        let of_faults = if faults == 1 { "1 fault".to_owned() } else { format!("{faults} faults") };
        let error = match &outcome {
            Err(error) => Some(error.to_string()),
            Ok(()) if let Some((made, wanted)) = parts.filter(|_| short) => {
                Some(format!("{made} of {wanted} parts finished"))
            }
            Ok(()) if short => Some(format!("{} of {} cycles ended", self.tally.cycles(), args.cycles.unwrap_or(0))),
            Ok(()) if self.ends() && faults > 0 => {
                Some(format!("{of_faults} on the way: {}", self.tally.fault_texts(self.states()).join("; ")))
            }
            Ok(()) => None,
        };
        let mode = self.client.coordinator().map_or("no state received", |state| mode_name(state.mode));
        let mut report = self.tally.report(mode, &self.observer, restarts, error.clone());
        (report.parts_made, report.parts_wanted) = parts.unzip();
        (report.alarms, report.parts_lost) = self.cell.as_ref().map(CellRun::exceptions).unzip();
        if args.json {
            crate::out::say!("{}", serde_json::to_string(&report).into_diagnostic()?);
        } else {
            let exceptions = self.cell.as_ref().map(CellRun::exceptions).unwrap_or_default();
            let done = done(parts, self.cell.as_ref().map(CellRun::left), report.cycles);
            crate::out::say!(
                "{done}, {of_faults}{}, {} conflicts seen in {} CAN frames",
                of_exceptions(exceptions),
                conflicts.len(),
                report.frames_seen
            );
            for conflict in &report.conflicts_seen {
                crate::out::say!("conflict: {conflict}");
            }
            if let Some(text) = unobserved(&report.conflicts_not_watched, &args.line.display().to_string()) {
                crate::out::say!("{text}");
            }
            if let Some(error) = error {
                crate::out::complain!("linewright: {error}");
            }
        }
        Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

/// How many conflicts the observer of the frames cannot see, and where they are listed; none if it sees all. Which they are is in `--json`.
fn unobserved(conflicts: &[String], line: &str) -> Option<String> {
    let number = match conflicts.len() {
        0 => return None,
        1 => "1 conflict".to_owned(),
        more => format!("{more} conflicts"),
    };
    Some(format!(
        "{number} cannot be seen in CAN frames: `linewright check {}` decides about all; `run --json` names them",
        crate::out::shell_word(line)
    ))
}

/// What a run has done: parts made of those it ordered; in a cell otherwise the parts that have left; in a line its cycles.
fn done(ordered: Option<(u32, u32)>, left: Option<u64>, cycles: usize) -> String {
    match (ordered, left) {
        (Some((made, wanted)), _) => format!("{made} of {wanted} parts of its orders"),
        (None, Some(1)) => "1 part has left in this run".to_owned(),
        (None, Some(left)) => format!("{left} parts have left in this run"),
        (None, None) => format!("{cycles} cycles"),
    }
}

/// Alarms, and parts that were lost and made again; empty where there was nothing.
fn of_exceptions((alarms, lost): (usize, u32)) -> String {
    let some = |count: usize, one: &str, more: &str| match count {
        0 => String::new(),
        1 => format!(", 1 {one}"),
        _ => format!(", {count} {more}"),
    };
    some(alarms, "alarm", "alarms") + &some(lost as usize, "part lost", "parts lost")
}

#[cfg(test)]
mod tests {
    use super::{done, of_exceptions, unobserved};

    #[test]
    fn a_conflict_that_the_frames_do_not_show_is_left_to_check() {
        assert_eq!(unobserved(&[], "line"), None);
        let one = unobserved(&["a against b: they meet".to_owned()], "my line").expect("one is not seen");
        let text = "1 conflict cannot be seen in CAN frames: `linewright check \"my line\"` decides about all; `run --json` names them";
        assert_eq!(one, text);
        let two = unobserved(&["a".to_owned(), "b".to_owned()], "line").expect("two are not seen");
        assert!(two.starts_with("2 conflicts cannot be seen in CAN frames: `linewright check line`"), "{two}");
    }

    #[test]
    fn a_run_of_a_cell_counts_parts() {
        assert_eq!(done(Some((2, 3)), Some(4), 0), "2 of 3 parts of its orders");
        assert_eq!(done(None, Some(4), 0), "4 parts have left in this run");
        assert_eq!(done(None, Some(1), 0), "1 part has left in this run");
        assert_eq!(done(None, None, 7), "7 cycles");
        assert_eq!(of_exceptions((0, 0)), "");
        assert_eq!(of_exceptions((2, 1)), ", 2 alarms, 1 part lost");
    }
}
