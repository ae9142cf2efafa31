//! The processes of a line on one machine: started, watched, started again, ended.
//!
//! Each child gets a pipe as its standard input and ends when it closes, so that no node outlives its supervisor,
//! however that ends. What a child logs goes into a file of its own, or nowhere where that cannot be written: a full disk
//! costs the log and not the line.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use miette::{IntoDiagnostic, WrapErr, miette};
use tokio::process::{Child, Command};

use crate::files::description;
use crate::load::Files;

/// Most time for a child to end by itself before it is killed: it has outputs to let go of.
const END_WITHIN: Duration = Duration::from_secs(2);
/// A child that ends sooner than this after its start is not started again at once.
const SHORT_LIFE: Duration = Duration::from_secs(1);
/// A child that never lives long is given up after this many starts in a row.
const SHORT_LIVES_MAX: u32 = 3;

/// As much of a log's end is looked at to show its last lines.
const TAIL_BYTES: u64 = 16 * 1024;

/// One process of the line.
struct ChildProcess {
    name: String,
    args: Vec<String>,
    log: PathBuf,
    child: Child,
    started: Instant,
    short_lives: u32,
}

/// All processes of a line.
pub struct Children {
    members: Vec<ChildProcess>,
    dir: PathBuf,
    /// Directory of their virtual buses; `None`: the shared one.
    buses: Option<PathBuf>,
    /// The descriptions, as they were when the line was started.
    described: Vec<(PathBuf, String)>,
    restarts: u32,
}

impl Children {
    /// No processes yet, for the line of these descriptions; logs go to `dir`, and the virtual buses are in `buses` if that
    /// is given.
    ///
    /// # Errors
    /// When a description cannot be read.
    pub fn new(dir: &Path, buses: Option<&Path>, files: &Files) -> miette::Result<Self> {
        let files = [&files.line, &files.cell].into_iter().flatten();
        let described = files.map(|file| Ok((file.clone(), description(file)?))).collect::<miette::Result<_>>()?;
        Ok(Children {
            members: Vec::new(),
            dir: dir.to_owned(),
            buses: buses.map(Path::to_owned),
            described,
            restarts: 0,
        })
    }

    /// Starts this very program again, with `args`.
    pub fn start(&mut self, name: &str, args: Vec<String>) -> miette::Result<()> {
        let log = self.dir.join(format!("{name}.log"));
        let child = spawn(&args, &log, self.buses.as_deref()).wrap_err_with(|| format!("cannot start {name}"))?;
        let started = Instant::now();
        self.members.push(ChildProcess { name: name.to_owned(), args, log, child, started, short_lives: 0 });
        Ok(())
    }

    /// Number of restarts of children.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// Starts again what has ended; gives the names.
    ///
    /// # Errors
    /// When a child keeps ending right after its start: with the end of its log. When a description is not the one that the
    /// others were started with: bits would have other meanings to the new process, and switch other outputs on.
    pub fn revive(&mut self) -> miette::Result<Vec<String>> {
        let mut revived = Vec::new();
        for member in &mut self.members {
            let Some(status) = member.child.try_wait().into_diagnostic()? else { continue };
            let short = member.started.elapsed() < SHORT_LIFE;
            member.short_lives = if short { member.short_lives + 1 } else { 0 };
            if member.short_lives >= SHORT_LIVES_MAX {
                return Err(miette!("{} does not stay up ({status}):\n{}", member.name, tail(&member.log)));
            }
            if let Some((file, _)) = self.described.iter().find(|(file, before)| !is_still(file, before)) {
                let (name, file) = (&member.name, file.display());
                return Err(miette!(
                    help = "start the line again, with one description for all of it",
                    "{name} has ended ({status}) and is not started again: {file} is not what the line was started with"
                ));
            }
            member.child = spawn(&member.args, &member.log, self.buses.as_deref())?;
            member.started = Instant::now();
            self.restarts += 1;
            revived.push(format!("{} ({status})", member.name));
        }
        Ok(revived)
    }

    /// Ends all of them: each may end by itself first, and is killed if it does not.
    pub async fn end(&mut self) {
        for member in &mut self.members {
            drop(member.child.stdin.take());
        }
        let deadline = tokio::time::Instant::now() + END_WITHIN;
        for member in &mut self.members {
            if tokio::time::timeout_at(deadline, member.child.wait()).await.is_err() {
                let _ = member.child.kill().await;
            }
        }
        self.members.clear();
    }
}

fn is_still(file: &Path, before: &str) -> bool {
    description(file).is_ok_and(|now| now == before)
}

fn spawn(args: &[String], log: &Path, buses: Option<&Path>) -> miette::Result<Child> {
    let program = std::env::current_exe().into_diagnostic().wrap_err("cannot find this program")?;
    let mut command = Command::new(program);
    match File::options().create(true).append(true).open(log).and_then(|log| Ok((log.try_clone()?, log))) {
        Ok((out, err)) => command.stdout(out).stderr(err),
        Err(error) => {
            crate::out::complain!("linewright: nothing is logged to {}: {error}", log.display());
            command.stdout(Stdio::null()).stderr(Stdio::null())
        }
    };
    command
        .args(args)
        .envs(buses.map(|dir| ("LINEWRIGHT_BUS_DIR", dir)))
        .stdin(Stdio::piped())
        .kill_on_drop(true)
        // A Ctrl-C at the terminal goes to every process of its group; it is the supervisor's to answer.
        .process_group(0)
        .spawn()
        .into_diagnostic()
}

/// The last lines of a log.
fn tail(log: &Path) -> String {
    let read = || -> std::io::Result<String> {
        // A pipe or a device in the place of a log has no end, or none that can be waited for.
        if !std::fs::metadata(log)?.is_file() {
            return Ok(String::new());
        }
        let mut file = File::open(log)?;
        file.seek(SeekFrom::Start(file.metadata()?.len().saturating_sub(TAIL_BYTES)))?;
        let mut bytes = Vec::new();
        file.take(TAIL_BYTES).read_to_end(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    };
    let text = read().unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(10)..].join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn no_process_is_started_again_with_another_description() {
        let dir = tempfile::tempdir().expect("a directory");
        let file = dir.path().join("line.toml");
        std::fs::write(&file, "name = \"a\"").expect("a file");
        let files = Files { line: Some(file.clone()), cell: None };
        let mut children = Children::new(dir.path(), None, &files).expect("the file is there");
        // The program of this test ends at once.
        children.start("clamp", vec!["--list".to_owned()]).expect("it starts");
        let revive = |children: &mut Children| {
            let until = Instant::now() + Duration::from_secs(30);
            loop {
                match children.revive() {
                    Ok(revived) if revived.is_empty() && Instant::now() < until => {
                        std::thread::sleep(Duration::from_millis(10))
                    }
                    outcome => return outcome,
                }
            }
        };
        assert_eq!(revive(&mut children).expect("started again").len(), 1);
        std::fs::write(&file, "name = \"b\"").expect("a file");
        let refused = revive(&mut children).expect_err("another description").to_string();
        assert!(refused.contains("clamp has ended") && refused.contains("line.toml is not what"), "{refused}");
        children.end().await;
    }
}
