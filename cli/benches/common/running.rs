//! The processes of a line, for benchmarks that look at them from outside.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use linewright_line::{Line, TransferLine};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const LINEWRIGHT: &str = env!("CARGO_BIN_EXE_linewright");
pub const LINE_BUS: &str = "vcan0";

/// The processes of a line.
pub struct Running {
    pub line: Line,
    pub dir: PathBuf,
    pub buses_dir: PathBuf,
    pub domain: u16,
    pub children: Vec<(String, Child)>,
    environment: Vec<(&'static str, PathBuf)>,
}

impl Running {
    /// Starts the processes in a directory of this name, with all devices on the stations' own buses or none, and all times
    /// multiplied.
    ///
    /// `environment` is what the processes find more in theirs; it may be in the directory.
    pub fn start(
        name: &str,
        own: bool,
        time_scale: f64,
        environment: impl Fn(&Path) -> Vec<(&'static str, PathBuf)>,
    ) -> Result<Self> {
        let dir = std::env::temp_dir().join(format!("linewright-{name}-{}-{own}", std::process::id()));
        let _ = fs::remove_dir_all(&dir);
        fs::create_dir_all(&dir)?;
        let mut text = TransferLine { machines: 1, time_scale }.text();
        if own {
            for station in ["transfer", "clamp_1", "mill_1"] {
                let head = format!("[[station]]\nname = \"{station}\"\n");
                let bus = format!("{head}bus = \"can_{station}\"\n");
                text = text.replacen(&head, &bus, 1);
            }
        }
        fs::write(dir.join("line.toml"), &text)?;
        let line = linewright_line::parse("line.toml", &text)?.line;
        let (buses_dir, domain) = (dir.join("bus"), if own { 92 } else { 93 });
        let environment = environment(&dir);
        let mut running = Running { line, buses_dir, domain, dir, children: Vec::new(), environment };
        running.spawn("plant", &["plant", "--virtual-bus"])?;
        running.spawn("coordinator", &["coordinator", "--virtual-bus"])?;
        for name in ["transfer", "clamp_1", "mill_1"] {
            running.spawn(name, &["station", "--virtual-bus", "--station", name])?;
        }
        Ok(running)
    }

    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(LINEWRIGHT);
        command.args(words).arg(&self.dir).env("LINEWRIGHT_BUS_DIR", &self.buses_dir);
        command.env("ROS_DOMAIN_ID", self.domain.to_string());
        command.envs(self.environment.iter().map(|(name, value)| (name, value)));
        command
    }

    fn spawn(&mut self, name: &str, words: &[&str]) -> Result<()> {
        let log = fs::File::create(self.dir.join(format!("{name}.log")))?;
        let state = self.dir.join("state");
        let mut command = self.command(words);
        command.arg("--state-dir").arg(state).stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        self.children.push((name.to_owned(), command.spawn()?));
        Ok(())
    }

    /// Gives a command until the mode is there.
    pub fn mode_until(&self, word: &str, mode: &str) -> Result<()> {
        let dir = self.dir.display().to_string();
        for _ in 0..40 {
            let output = Command::new(LINEWRIGHT)
                .args(["mode", &dir, word])
                .env("LINEWRIGHT_BUS_DIR", &self.buses_dir)
                .env("ROS_DOMAIN_ID", self.domain.to_string())
                .output()?;
            if String::from_utf8_lossy(&output.stdout).starts_with(mode) {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        Err(format!("the line did not go to {mode}; logs in {dir}").into())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        for (_, child) in &mut self.children {
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = fs::remove_dir_all(&self.dir);
    }
}

/// Prints times: the median, 99 of 100, and the worst.
pub fn print_samples(name: &str, samples: &mut [Duration]) {
    samples.sort_unstable();
    let at = |share: f64| samples.get(((samples.len() as f64 * share) as usize).min(samples.len().saturating_sub(1)));
    let micros = |share: f64| at(share).map_or(0, |d| d.as_micros());
    println!(
        "{name:55} n {:5}  p50 {:6} µs  p99 {:6} µs  max {:6} µs",
        samples.len(),
        micros(0.5),
        micros(0.99),
        micros(1.0)
    );
}
