//! The directory of a run's journals and logs.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use linewright_line::{Line, Tick};
use linewright_plant::PlantOptions;
use linewright_racks::{KeptPositions, kept_positions};
use miette::{IntoDiagnostic, WrapErr, miette};

/// A run goes on from an earlier one's journals, and its simulated machine does not.
const MACHINE_BEGINS_ANEW: &str = "no positions of the simulated machine are kept there: it begins at home, empty, and its \
                                   stations go on from their journals. Where one was stopped elsewhere, `position lost` \
                                   follows: lead it home in manual or give `linewright rejoin`, or start with another \
                                   --state-dir";

/// The directory that was given, or a temporary one.
pub struct RunDirectory {
    pub dir: PathBuf,
    temporary: bool,
    /// There are journals of an earlier run in it.
    pub has_journals: bool,
}

impl RunDirectory {
    pub fn new(given: Option<&Path>) -> miette::Result<Self> {
        let cannot = |dir: &Path| format!("cannot use {}", dir.display());
        if let Some(dir) = given {
            std::fs::create_dir_all(dir).into_diagnostic().wrap_err_with(|| cannot(dir))?;
            let has_journals = has_journals(dir);
            return Ok(RunDirectory { dir: dir.to_owned(), temporary: false, has_journals });
        }
        let first = std::env::temp_dir().join(format!("linewright-run-{}", std::process::id()));
        // A run that failed has left its own, and its number may be this process's now. Its journals are of another line.
        let others = (2..100).map(|nth| first.with_extension(nth.to_string()));
        for dir in std::iter::once(first.clone()).chain(others) {
            match std::fs::create_dir(&dir) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                outcome => {
                    outcome.into_diagnostic().wrap_err_with(|| cannot(&dir))?;
                    return Ok(RunDirectory { dir, temporary: true, has_journals: false });
                }
            }
        }
        Err(miette!("{} and 98 like it are there; remove those of runs that have ended", first.display()))
    }

    /// What a run with a simulated machine finds: why that does not stand where it stood, if it should.
    pub fn machine_note(&self, line: &Line) -> Option<String> {
        match kept_positions(&self.dir, line, Tick::ZERO, PlantOptions::default()) {
            Ok(KeptPositions::Nothing) => self.has_journals.then(|| MACHINE_BEGINS_ANEW.to_owned()),
            Ok(KeptPositions::Racks(_)) => None,
            Err(why) => Some(why),
        }
    }

    /// Removes a temporary directory, unless the run failed: its logs are needed then.
    pub fn end(self, ok: bool) {
        if self.temporary && ok {
            let _ = std::fs::remove_dir_all(&self.dir);
        }
    }
}

fn has_journals(dir: &Path) -> bool {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).any(|path| path.extension().is_some_and(|extension| extension == "journal"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_with_a_journal_in_it_is_of_an_earlier_run() {
        let dir = tempfile::tempdir().expect("a directory");
        std::fs::write(dir.path().join("clamp_1.log"), "").expect("a file");
        assert!(!RunDirectory::new(Some(dir.path())).expect("it can be used").has_journals);
        std::fs::write(dir.path().join("clamp_1.journal"), "").expect("a file");
        assert!(RunDirectory::new(Some(dir.path())).expect("it can be used").has_journals);
    }

    #[test]
    fn a_machine_that_does_not_stand_where_it_stood_is_said_to_begin_at_home() {
        let dir = tempfile::tempdir().expect("a directory");
        let text = linewright_line::TransferLine::default().text();
        let line = linewright_line::parse("line.toml", &text).expect("parses").line;
        let note = || RunDirectory::new(Some(dir.path())).expect("it can be used").machine_note(&line);
        assert_eq!(note(), None);
        std::fs::write(dir.path().join("clamp_1.journal"), "").expect("a file");
        assert!(note().is_some_and(|note| note.contains("no positions") && note.contains("at home")));
        std::fs::write(dir.path().join("plant.json"), "{").expect("a file");
        assert!(note().is_some_and(|note| note.contains("plant.json cannot be used") && note.contains("at home")));
    }
}
