//! The processes of a line on one machine: started, watched, started again, ended.
//!
//! Each child gets a pipe as its standard input and ends when it closes, so that no node outlives its supervisor,
//! however that ends. What a child logs goes into a file of its own.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use miette::{IntoDiagnostic, WrapErr, miette};
use tokio::process::{Child, Command};

/// How long a child may take to end by itself before it is killed: it has outputs to let go of.
const END_WITHIN: Duration = Duration::from_secs(2);
/// A child that ends sooner than this after its start is not started again at once.
const SHORT_LIFE: Duration = Duration::from_secs(1);
/// A child that never lives long is given up after this many starts in a row.
const SHORT_LIVES_MAX: u32 = 3;

/// One process of the line.
struct Member {
    name: String,
    args: Vec<String>,
    log: PathBuf,
    child: Child,
    started: Instant,
    short_lives: u32,
}

/// All processes of a line.
pub struct Children {
    members: Vec<Member>,
    dir: PathBuf,
    restarts: u32,
}

impl Children {
    /// No processes yet; logs go to `dir`.
    pub fn new(dir: &Path) -> Self {
        Children { members: Vec::new(), dir: dir.to_owned(), restarts: 0 }
    }

    /// Starts this very program again, with `args`.
    pub fn start(&mut self, name: &str, args: Vec<String>) -> miette::Result<()> {
        let log = self.dir.join(format!("{name}.log"));
        let child = spawn(&args, &log).wrap_err_with(|| format!("cannot start {name}"))?;
        let started = Instant::now();
        self.members.push(Member { name: name.to_owned(), args, log, child, started, short_lives: 0 });
        Ok(())
    }

    /// How often a child had to be started again.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// Starts again what has ended; gives the names.
    ///
    /// # Errors
    /// When a child keeps ending right after its start: with the end of its log.
    pub fn revive(&mut self) -> miette::Result<Vec<String>> {
        let mut revived = Vec::new();
        for member in &mut self.members {
            let Some(status) = member.child.try_wait().into_diagnostic()? else { continue };
            let short = member.started.elapsed() < SHORT_LIFE;
            member.short_lives = if short { member.short_lives + 1 } else { 0 };
            if member.short_lives >= SHORT_LIVES_MAX {
                return Err(miette!("{} does not stay up ({status}):\n{}", member.name, tail(&member.log)));
            }
            member.child = spawn(&member.args, &member.log)?;
            member.started = Instant::now();
            self.restarts += 1;
            revived.push(format!("{} ({status})", member.name));
        }
        Ok(revived)
    }

    /// Ends all of them: each is asked first, and killed if it does not.
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

fn spawn(args: &[String], log: &Path) -> miette::Result<Child> {
    let program = std::env::current_exe().into_diagnostic().wrap_err("cannot find this program")?;
    let log = File::options().create(true).append(true).open(log).into_diagnostic()?;
    Command::new(program)
        .args(args)
        .stdin(Stdio::piped())
        .stdout(log.try_clone().into_diagnostic()?)
        .stderr(log)
        .kill_on_drop(true)
        // A Ctrl-C at the terminal goes to every process of its group; it is the supervisor's to answer.
        .process_group(0)
        .spawn()
        .into_diagnostic()
}

fn tail(log: &Path) -> String {
    let text = std::fs::read_to_string(log).unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(10)..].join("\n")
}
