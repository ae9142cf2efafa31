//! Whether the nodes of a running line were started with the description that a command has read.
//!
//! Names and numbers of operations may be the same in both, and conditions, times or wiring differ: a plan made with one does not
//! hold for the other. The states of all nodes have a fingerprint for it.

use std::path::Path;

use linewright_line::Line;

use crate::load;

/// The description that a command has read.
pub struct OwnDescription {
    /// What was given on the command line.
    path: String,
    /// Fingerprint of the line.
    line: u64,
    /// The same with the cell. None where there is one that cannot be read: it is no running cell's.
    whole: Option<u64>,
    is_cell: bool,
}

impl OwnDescription {
    /// That of `line`, read from `path`.
    pub fn of(path: &Path, line: &Line) -> Self {
        let own = line.fingerprint();
        let cell = load::cell_of(path, line);
        let is_cell = !matches!(cell, Ok(None));
        let whole = cell.map(|cell| cell.map_or(own, |cell| cell.fingerprint(line))).ok();
        OwnDescription { path: crate::out::shell_word(&path.display().to_string()), line: own, whole, is_cell }
    }

    /// Whether a station with this fingerprint was started with the same line.
    pub fn is_of_station(&self, fingerprint: u64) -> bool {
        fingerprint == self.line
    }

    /// What the running coordinator was started with, where that is something else, and what to do. `stations` are those of the
    /// stations received.
    pub fn of_coordinator(&self, runs: u64, stations: &[u64]) -> Option<String> {
        if self.whole == Some(runs) {
            return None;
        }
        let path = &self.path;
        let remedy = "put that one back, or end all nodes and start them with this one";
        let is_line_same = !stations.is_empty() && stations.iter().all(|of| self.is_of_station(*of));
        Some(match (is_line_same, self.is_cell) {
            (false, _) => format!("the running line was started with another description than {path}: {remedy}"),
            (true, true) => format!("the coordinator was started with another cell.toml than that of {path}: {remedy}"),
            (true, false) => format!(
                "the coordinator was started with another description than {path}, the stations with this one: no station follows it; \
                 start it again"
            ),
        })
    }

    /// The same of a station, whose coordinator has this description.
    pub fn of_station(&self, name: &str) -> String {
        let path = &self.path;
        format!(
            "{name} was started with another description than {path}, and gets no orders: start its node again with this one"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn own(is_cell: bool) -> OwnDescription {
        OwnDescription { path: "line".to_owned(), line: 1, whole: Some(if is_cell { 2 } else { 1 }), is_cell }
    }

    #[test]
    fn what_runs_with_something_else_is_named_by_the_file_that_differs() {
        let text = |is_cell, runs, stations: &[u64]| own(is_cell).of_coordinator(runs, stations);
        assert_eq!(text(false, 1, &[1, 1]), None);
        assert_eq!(text(true, 2, &[]), None);
        let of_all = "the running line was started with another description than line: put that one back, or end all nodes and start \
                      them with this one";
        for (is_cell, stations) in [(false, &[5, 1][..]), (true, &[5, 5]), (false, &[])] {
            assert_eq!(text(is_cell, 7, stations).as_deref(), Some(of_all));
        }
        let text_of = |is_cell| text(is_cell, 7, &[1, 1]).unwrap_or_default();
        assert!(text_of(true).starts_with("the coordinator was started with another cell.toml than that of line: "));
        assert!(text_of(false).ends_with("no station follows it; start it again"));
    }

    #[test]
    fn a_cell_that_cannot_be_read_is_not_the_one_that_runs() {
        let of = OwnDescription { whole: None, ..own(true) };
        assert!(of.of_coordinator(2, &[1]).is_some());
    }
}
