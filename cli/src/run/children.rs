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
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, ChildStdout, Command};
use tokio::sync::mpsc;

use super::directory::can_write;
use crate::files::description;
use crate::load::Files;

/// Most time for a child to end by itself before it is killed: it has outputs to let go of.
const END_WITHIN: Duration = Duration::from_secs(2);
/// A child that is killed sooner than this after its start, or ends by itself sooner than that, has not come up.
const SHORT_LIFE: Duration = Duration::from_secs(1);
const SHORT_LIFE_BY_ITSELF: Duration = Duration::from_secs(10);
/// A child that never lives long is given up after this many starts in a row.
const SHORT_LIVES_MAX: u32 = 3;
/// Characters of a log that are shown in a line of what has happened.
const LINE_CHARS: usize = 400;

/// As much of a log's end is looked at to show its last lines.
const TAIL_BYTES: u64 = 16 * 1024;

/// Lines of the plant that are kept until they are shown; what comes when they are so many is in its log alone.
const PLANT_LINES_MAX: usize = 64;

/// One process of the line.
struct ChildProcess {
    name: String,
    args: Vec<String>,
    log: PathBuf,
    child: Child,
    started: Instant,
    short_lives: u32,
    /// Length of its log when it was started last.
    log_from: u64,
    /// It ends when all others have: they let go of its devices' outputs first.
    is_last: bool,
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
    /// Lines of the plant's standard output: mishaps in the simulated machine.
    plant_lines: (mpsc::Sender<String>, mpsc::Receiver<String>),
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
            plant_lines: mpsc::channel(PLANT_LINES_MAX),
        })
    }

    /// Starts this very program again, with `args`.
    pub fn start(&mut self, name: &str, args: Vec<String>) -> miette::Result<()> {
        self.add(name, args, false)
    }

    /// Starts this very program again as the simulated plant. It ends after all others.
    pub fn start_plant(&mut self, args: Vec<String>) -> miette::Result<()> {
        self.add("plant", args, true)
    }

    fn add(&mut self, name: &str, args: Vec<String>, is_last: bool) -> miette::Result<()> {
        let log = self.dir.join(format!("{name}.log"));
        let log_from = length(&log);
        let mut child =
            spawn(&args, &log, self.buses.as_deref(), is_last).wrap_err_with(|| format!("cannot start {name}"))?;
        pass_on(child.stdout.take(), &self.plant_lines.0);
        let started = Instant::now();
        let (name, short_lives) = (name.to_owned(), 0);
        self.members.push(ChildProcess { name, args, log, child, started, short_lives, log_from, is_last });
        Ok(())
    }

    /// Number of restarts of children.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// What the plant has reported since this was asked last.
    pub fn plant_reports(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.plant_lines.1.try_recv().ok()).collect()
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
            let limit = if status.code().is_some() { SHORT_LIFE_BY_ITSELF } else { SHORT_LIFE };
            let short = member.started.elapsed() < limit;
            member.short_lives = if short { member.short_lives + 1 } else { 0 };
            if member.short_lives >= SHORT_LIVES_MAX {
                let why = why_ended(&member.log, member.log_from);
                return Err(miette!("{} does not stay up ({status}):\n{why}", member.name));
            }
            if let Some((file, _)) = self.described.iter().find(|(file, before)| !is_still(file, before)) {
                let (name, file) = (&member.name, file.display());
                return Err(miette!(
                    help = "start the line again, with one description for all of it",
                    "{name} has ended ({status}) and is not started again: {file} is not what the line was started with"
                ));
            }
            let why = match status.code() {
                None | Some(0) => String::new(),
                Some(_) => format!(": {}", last_line(&why_ended(&member.log, member.log_from))),
            };
            member.log_from = length(&member.log);
            member.child = spawn(&member.args, &member.log, self.buses.as_deref(), member.is_last)?;
            pass_on(member.child.stdout.take(), &self.plant_lines.0);
            member.started = Instant::now();
            self.restarts += 1;
            revived.push(format!("{} ({status}){why}", member.name));
        }
        Ok(revived)
    }

    /// Ends all of them, the plant after the others: each may end by itself first, and is killed if it does not.
    pub async fn end(&mut self) {
        for is_last in [false, true] {
            let mut these: Vec<_> = self.members.iter_mut().filter(|member| member.is_last == is_last).collect();
            these.iter_mut().for_each(|member| drop(member.child.stdin.take()));
            let deadline = tokio::time::Instant::now() + END_WITHIN;
            for member in these {
                if tokio::time::timeout_at(deadline, member.child.wait()).await.is_err() {
                    let _ = member.child.kill().await;
                }
            }
        }
        self.members.clear();
    }
}

fn is_still(file: &Path, before: &str) -> bool {
    description(file).is_ok_and(|now| now == before)
}

/// Takes the lines of a plant's standard output, so that writing to it does not hold the plant up.
fn pass_on(output: Option<ChildStdout>, to: &mpsc::Sender<String>) {
    let (Some(output), to) = (output, to.clone()) else { return };
    tokio::spawn(async move {
        let mut lines = BufReader::new(output).lines();
        while let Ok(Some(line)) = lines.next_line().await {
            let _ = to.try_send(line);
        }
    });
}

/// The program that runs, also where its file has been replaced since: a node that is started again has to be of the version of the others.
fn this_program() -> miette::Result<PathBuf> {
    let file = std::env::current_exe().into_diagnostic().wrap_err("cannot find this program")?;
    Ok(if file.exists() { file } else { PathBuf::from("/proc/self/exe") })
}

/// `reports`: its standard output is read, and not part of its log.
fn spawn(args: &[String], log: &Path, buses: Option<&Path>, reports: bool) -> miette::Result<Child> {
    let mut command = Command::new(this_program()?);
    match File::options().create(true).append(true).open(log).and_then(|log| Ok((log.try_clone()?, log))) {
        Ok((out, err)) => command.stdout(out).stderr(err),
        Err(error) => {
            crate::out::complain!("linewright: nothing is logged to {}: {error}", log.display());
            command.stdout(Stdio::null()).stderr(Stdio::null())
        }
    };
    if reports {
        command.stdout(Stdio::piped());
    }
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

fn length(log: &Path) -> u64 {
    std::fs::metadata(log).map_or(0, |log| log.len())
}

/// The end of what a process has logged since it was started; if that is nothing, why it may be.
fn why_ended(log: &Path, from: u64) -> String {
    let lines = tail(log, from);
    let dir = log.parent().unwrap_or(Path::new(""));
    match (lines.trim().is_empty(), can_write(dir)) {
        (false, _) => lines,
        (true, Err(error)) => format!("nothing can be written to {}, its log neither: {error}", dir.display()),
        (true, Ok(())) => format!("it has logged nothing to {}", log.display()),
    }
}

/// The last line of a log that is not empty, as far as it can be shown in one.
fn last_line(lines: &str) -> String {
    lines.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default().trim().chars().take(LINE_CHARS).collect()
}

/// The last lines of a log, from this byte on.
fn tail(log: &Path, from: u64) -> String {
    let read = || -> std::io::Result<String> {
        // A pipe or a device in the place of a log has no end, or none that can be waited for.
        if !std::fs::metadata(log)?.is_file() {
            return Ok(String::new());
        }
        let mut file = File::open(log)?;
        file.seek(SeekFrom::Start(file.metadata()?.len().saturating_sub(TAIL_BYTES).max(from)))?;
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

    #[test]
    fn the_end_of_a_process_is_explained_by_its_last_life_or_by_the_disk() {
        let dir = tempfile::tempdir().expect("a directory");
        let log = dir.path().join("clamp.log");
        std::fs::write(&log, "the first life\n").expect("a file");
        let from = length(&log);
        assert!(why_ended(&log, from).starts_with("it has logged nothing to "));
        std::fs::write(&log, "the first life\nthe second\n").expect("a file");
        assert_eq!(why_ended(&log, from), "the second");
        // Every write to it fails as on a full disk.
        let full = why_ended(Path::new("/proc/clamp.log"), 0);
        assert!(full.starts_with("nothing can be written to /proc, its log neither: "), "{full}");
    }

    #[tokio::test]
    async fn the_plant_ends_after_all_others() {
        let dir = tempfile::tempdir().expect("a directory");
        let mut children = Children::new(dir.path(), None, &Files { line: None, cell: None }).expect("no files");
        children.start_plant(vec!["--list".to_owned()]).expect("it starts");
        children.start("clamp", vec!["--list".to_owned()]).expect("it starts");
        let mut add = |nth: usize, script: &str| {
            let mut shell = Command::new("sh");
            shell.args(["-c", script]).stdin(Stdio::piped()).current_dir(dir.path());
            children.members[nth].child = shell.spawn().expect("a shell");
        };
        add(0, "cat; echo plant >> order");
        add(1, "cat; sleep 0.2; echo clamp >> order");
        children.end().await;
        assert_eq!(std::fs::read_to_string(dir.path().join("order")).expect("written"), "clamp\nplant\n");
    }
}
