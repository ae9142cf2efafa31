//! The directory of a run's journals and logs.

use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use linewright_line::{Line, Tick};
use linewright_plant::PlantOptions;
use linewright_racks::{KEPT_IN, KeptPositions, kept_positions};
use miette::{IntoDiagnostic, WrapErr, miette};

/// For a directory with journals of an earlier run and no positions of its machine.
const MACHINE_BEGINS_ANEW: &str = "no positions of the simulated machine are kept there: it begins at home, empty, and its \
                                   stations go on from their journals. Where one was stopped elsewhere, `position lost` \
                                   follows: lead it home in manual or give `linewright rejoin`, or start with another \
                                   --state-dir";

/// Is there while a run goes on, and after one that has not ended at home.
const UNFINISHED_FILE: &str = "run.unfinished";

/// The file with the line's name.
const LINE_FILE: &str = "line.name";
const LINE_BYTES_MAX: usize = 4096;
/// More than a few journals.
const PROBE_BYTES: usize = 64 * 1024;

/// The directory that was given, or a temporary one.
pub struct RunDirectory {
    pub dir: PathBuf,
    temporary: bool,
    /// There are journals of an earlier run in it.
    pub has_journals: bool,
    /// The run before in it has not ended at home: it was cut off, or everything stood after a fault.
    is_unfinished: bool,
}

impl RunDirectory {
    /// The directory `given`, if it is of this line and can be written to, or a new one.
    ///
    /// # Errors
    /// Why it cannot be used.
    pub fn new(given: Option<&Path>, line: &Line) -> miette::Result<Self> {
        let cannot = |dir: &Path| format!("cannot use {}", dir.display());
        crate::files::keep_from_others();
        if let Some(dir) = given {
            let unusable = |error: std::io::Error| crate::files::cannot_use(dir, &error);
            std::fs::create_dir_all(dir).map_err(unusable)?;
            can_write(dir).map_err(unusable)?;
            is_of_line(dir, line)?;
            let has_journals = has_journals(dir);
            let is_unfinished = has_journals && dir.join(UNFINISHED_FILE).exists();
            return Ok(RunDirectory { dir: dir.to_owned(), temporary: false, has_journals, is_unfinished });
        }
        let first = std::env::temp_dir().join(format!("linewright-run-{}", std::process::id()));
        // A run that failed has left its own, and its number may be this process's now. Its journals are of another line.
        let others = (2..100).map(|nth| first.with_extension(nth.to_string()));
        for dir in std::iter::once(first.clone()).chain(others) {
            match std::fs::create_dir(&dir) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                outcome => {
                    outcome.into_diagnostic().wrap_err_with(|| cannot(&dir))?;
                    return Ok(RunDirectory { dir, temporary: true, has_journals: false, is_unfinished: false });
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

    /// Why auto is not to be given by itself: a run in this directory has not ended at home, and none since has.
    pub fn unfinished(&self) -> Option<String> {
        self.is_unfinished.then(|| {
            format!(
                "the run before in {} has not ended at home: it was cut off, or stood after a fault. Auto is not given by this run. Look at \
                 the machine; `linewright recover` lists the way, and auto is given with `linewright mode`",
                self.dir.display()
            )
        })
    }

    /// Notes that a run has begun. Until it has ended at home the next one gives no auto.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub fn begin(&self) -> miette::Result<()> {
        let file = self.dir.join(UNFINISHED_FILE);
        std::fs::write(&file, "").into_diagnostic().wrap_err_with(|| format!("cannot write {}", file.display()))
    }

    /// Why auto is not to be given by itself: stations of an earlier run have no journal any more, and what was done to the parts in the
    /// machine is not known. (A cell's log has its parts, and its alarms ask about them.)
    pub fn lost_journals(&self, line: &Line) -> Option<String> {
        let is_used = self.has_journals || self.dir.join(KEPT_IN).exists();
        let is_lost = |name: &&str| !self.dir.join(format!("{name}.journal")).exists();
        let lost: Vec<&str> = line.stations.iter().map(|station| station.name.as_str()).filter(is_lost).collect();
        (is_used && !lost.is_empty()).then(|| {
            format!(
                "{} has no journal of {}: what was done to the parts in the line is not known, and auto is not given by this run. Look at \
                 every station, take parts out or finish them; `linewright recover` lists the way",
                self.dir.display(),
                lost.join(", ")
            )
        })
    }

    /// Notes that the run has ended, at home or elsewhere. Removes a temporary directory, unless the run failed: its logs are needed then.
    pub fn end(self, at_home: bool, ok: bool) {
        if at_home {
            let _ = std::fs::remove_file(self.dir.join(UNFINISHED_FILE));
        }
        if self.temporary && ok {
            let _ = std::fs::remove_dir_all(&self.dir);
        }
    }
}

/// Whether as much can be written to a directory as a journal may need. On a full disk nodes do not start, and log nothing.
pub fn can_write(dir: &Path) -> std::io::Result<()> {
    let file = dir.join(format!(".probe-{}", std::process::id()));
    let written = File::create(&file).and_then(|mut file| {
        file.write_all(&[0; PROBE_BYTES])?;
        file.sync_all()
    });
    let _ = std::fs::remove_file(&file);
    written
}

/// Whether the directory is the line's, by its name in a file that is written at the first use.
fn is_of_line(dir: &Path, line: &Line) -> miette::Result<()> {
    let file = dir.join(LINE_FILE);
    let cannot = || format!("cannot use {}", dir.display());
    match crate::files::text(&file, LINE_BYTES_MAX, "the name of a line") {
        Ok(name) if name.trim() == line.name => Ok(()),
        Ok(name) => Err(miette!(
            help = "give this line another --state-dir",
            "{} has the journals of line {}, and this is {} ({})",
            dir.display(),
            name.trim(),
            line.name,
            file.display()
        )),
        Err(_) if !file.exists() => {
            std::fs::write(&file, format!("{}\n", line.name)).into_diagnostic().wrap_err_with(cannot)
        }
        Err(error) => Err(error.wrap_err(cannot())),
    }
}

fn has_journals(dir: &Path) -> bool {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).any(|path| path.extension().is_some_and(|extension| extension == "journal"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Line {
        let text = linewright_line::TransferLine::default().text();
        linewright_line::parse("line.toml", &text).expect("parses").line
    }

    #[test]
    fn a_directory_with_a_journal_in_it_is_of_an_earlier_run() {
        let dir = tempfile::tempdir().expect("a directory");
        let has_journals = || RunDirectory::new(Some(dir.path()), &line()).expect("it can be used").has_journals;
        std::fs::write(dir.path().join("clamp_1.log"), "").expect("a file");
        assert!(!has_journals());
        std::fs::write(dir.path().join("clamp_1.journal"), "").expect("a file");
        assert!(has_journals());
    }

    #[test]
    fn a_directory_of_another_line_is_refused_and_so_is_one_without_room() {
        let dir = tempfile::tempdir().expect("a directory");
        let (own, mut other) = (line(), line());
        other.name = "table".to_owned();
        let used = |line: &Line| RunDirectory::new(Some(dir.path()), line).map(drop);
        used(&own).expect("nobody's yet");
        used(&own).expect("its own");
        let refused = used(&other).expect_err("another line's").to_string();
        assert!(refused.contains(&format!("of line {}, and this is table", own.name)), "{refused}");
        let left: Vec<_> = std::fs::read_dir(dir.path()).expect("it is there").flatten().collect();
        assert_eq!(left.len(), 1, "the name alone: {left:?}");
        let full = RunDirectory::new(Some(Path::new("/proc")), &own).err().expect("nothing can be written there");
        assert!(full.to_string().starts_with("cannot use /proc: ") && full.help().is_some(), "{full}");
    }

    #[test]
    fn auto_is_not_given_where_journals_of_an_earlier_run_are_gone() {
        let (dir, line) = (tempfile::tempdir().expect("a directory"), line());
        let lost = || RunDirectory::new(Some(dir.path()), &line).expect("it can be used").lost_journals(&line);
        let file = |name: &str| dir.path().join(name);
        assert_eq!(lost(), None, "the first run there");
        std::fs::write(file(KEPT_IN), "{}").expect("a file");
        assert!(lost().is_some_and(|why| line.stations.iter().all(|station| why.contains(&station.name))));
        for station in &line.stations {
            std::fs::write(file(&format!("{}.journal", station.name)), "").expect("a file");
        }
        assert_eq!(lost(), None);
        std::fs::remove_file(file("clamp_1.journal")).expect("a file");
        assert!(lost().is_some_and(|why| why.contains("no journal of clamp_1: ")));
    }

    #[test]
    fn auto_is_not_given_after_a_run_that_has_not_ended_at_home() {
        let (dir, line) = (tempfile::tempdir().expect("a directory"), line());
        let used = || RunDirectory::new(Some(dir.path()), &line).expect("it can be used");
        let run = |at_home: Option<bool>| {
            let before = used();
            before.begin().expect("it is written");
            std::fs::write(dir.path().join("clamp_1.journal"), "").expect("a file");
            if let Some(at_home) = at_home {
                before.end(at_home, at_home);
            }
        };
        assert_eq!(used().unfinished(), None, "the first run there");
        run(Some(true));
        assert_eq!(used().unfinished(), None);
        for ended in [None, Some(false)] {
            run(ended);
            assert!(used().unfinished().is_some_and(|why| why.contains("has not ended at home")), "{ended:?}");
        }
        run(Some(true));
        assert_eq!(used().unfinished(), None);
    }

    #[test]
    fn a_machine_that_does_not_stand_where_it_stood_is_said_to_begin_at_home() {
        let (dir, line) = (tempfile::tempdir().expect("a directory"), line());
        let note = || RunDirectory::new(Some(dir.path()), &line).expect("it can be used").machine_note(&line);
        assert_eq!(note(), None);
        std::fs::write(dir.path().join("clamp_1.journal"), "").expect("a file");
        assert!(note().is_some_and(|note| note.contains("no positions") && note.contains("at home")));
        std::fs::write(dir.path().join("plant.json"), "{").expect("a file");
        assert!(note().is_some_and(|note| note.contains("plant.json cannot be used") && note.contains("at home")));
    }
}
