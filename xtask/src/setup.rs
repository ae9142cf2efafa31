//! Requirements of tests on the machine besides a Rust toolchain: CAN sockets, foreign stacks to be tested against, and
//! a browser.
//!
//! On Debian, as root, packages that are missing are installed; Python packages go into an environment of their own below
//! the target directory. What is there is not fetched again, every step has a time limit, and what cannot be had is
//! reported with the reason: its tests are skipped then. The whole output of the package managers is in `set-up.log` there.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// A program, and the Debian package that has it.
const PROGRAMS: [(&str, &str); 4] =
    [("linux.uml", "user-mode-linux"), ("candump", "can-utils"), ("ip", "iproute2"), ("insmod", "kmod")];

/// The browser that tests of the console's page drive, and its driver, with their Debian packages.
const BROWSER: [(&str, &str); 2] = [("chromium", "chromium"), ("chromedriver", "chromium-driver")];

/// A module of Python that tests import, or a program, and the package of PyPI that has it.
const MODULES: [(&str, &str); 8] = [
    ("canopen", "canopen"),
    ("can", "python-can"),
    ("cantools", "cantools"),
    ("jsonschema", "jsonschema"),
    ("pymodbus", "pymodbus"),
    ("mcap", "mcap"),
    ("cyclonedds.core", "cyclonedds"),
    ("typos", "typos"),
];

/// Result of the set-up.
#[derive(Debug, Default)]
pub struct Setup {
    /// The Python that has the packages, if there is any.
    python: Option<PathBuf>,
    /// Missing parts, with reasons.
    pub missing: Vec<String>,
}

impl Setup {
    /// Names the Python to the tests, unless the environment names one already.
    pub fn apply(&self, command: &mut Command) {
        for name in ["LINEWRIGHT_PYTHON", "LINEWRIGHT_INTEROP_PYTHON"] {
            if let (None, Some(python)) = (std::env::var_os(name), &self.python) {
                command.env(name, python);
            }
        }
    }

    /// A program that came with the Python packages, if it did.
    pub fn program(&self, name: &str) -> Option<PathBuf> {
        let named = std::env::var_os("LINEWRIGHT_PYTHON").map(PathBuf::from);
        let beside = named.as_ref().or(self.python.as_ref())?.with_file_name(name);
        beside.is_file().then_some(beside)
    }
}

/// Parts that are there already; nothing is fetched.
pub fn find(root: &Path) -> Setup {
    let python = environment(root).join("bin/python");
    Setup { python: python.is_file().then_some(python), missing: Vec::new() }
}

/// Fetches what is missing.
pub fn run(root: &Path) -> Setup {
    let mut setup = find(root);
    let mut log = Log::new(&target(root).join("set-up.log"));
    setup.missing.extend(debian(&mut log).err());
    setup.missing.extend(browser(&mut log).err());
    if let Some(named) = std::env::var_os("LINEWRIGHT_PYTHON") {
        let lacking: Vec<&str> = lacking(Path::new(&named)).iter().map(|(_, package)| *package).collect();
        if !lacking.is_empty() {
            setup.missing.push(format!(
                "{}, named by LINEWRIGHT_PYTHON, lacks {}",
                named.display(),
                lacking.join(", ")
            ));
        }
        return setup;
    }
    setup.missing.extend(python(&environment(root), &mut log).err());
    setup.python = find(root).python;
    setup
}

fn target(root: &Path) -> PathBuf {
    root.join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

fn environment(root: &Path) -> PathBuf {
    target(root).join("python")
}

/// User-mode Linux and CAN tools, where the kernel itself has no CAN, and what Python needs to make an environment.
fn debian(log: &mut Log) -> Result<(), String> {
    let mut packages: Vec<&str> = if Path::new("/sys/class/net/vcan0").exists() {
        Vec::new()
    } else {
        PROGRAMS.iter().filter(|(program, _)| !is_program(program)).map(|(_, package)| *package).collect()
    };
    let can = packages.len();
    let has_environments = log.run(Command::new("python3").args(["-c", "import ensurepip"]), 20).is_ok();
    if !has_environments && std::env::var_os("LINEWRIGHT_PYTHON").is_none() {
        packages.push("python3-venv");
    }
    let what = if can > 0 { "no CAN sockets" } else { "no Python environment" };
    install(what, &packages, log)
}

/// The browser of the console's tests.
fn browser(log: &mut Log) -> Result<(), String> {
    let missing = BROWSER.iter().filter(|(program, _)| !is_program(program));
    let packages: Vec<&str> = missing.map(|(_, package)| *package).collect();
    install("no browser for the page of the console", &packages, log)
}

/// Installs Debian packages that are missing.
///
/// # Errors
/// What is not there without them, and why they are not to be had.
fn install(what: &str, packages: &[&str], log: &mut Log) -> Result<(), String> {
    if packages.is_empty() {
        return Ok(());
    }
    let why = match (is_program("apt-get"), is_root()) {
        (false, _) => "no Debian".to_owned(),
        (true, false) => format!("not root; as root: apt-get install {}", packages.join(" ")),
        (true, true) => match fetch(packages, log) {
            Ok(()) => return Ok(()),
            Err(error) => error,
        },
    };
    Err(format!("{what}, {} missing: {why}", packages.join(", ")))
}

fn fetch(packages: &[&str], log: &mut Log) -> Result<(), String> {
    // Without a network this ends within seconds.
    let patience = ["-qq", "-o", "Acquire::http::Timeout=5", "-o", "Acquire::Retries=0"];
    let apt_get = || {
        let mut command = Command::new("apt-get");
        command.args(patience).env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    // The lists from before suffice.
    let _ = log.run(apt_get().arg("update"), 120);
    log.run(apt_get().args(["install", "-y", "--no-install-recommends"]).args(packages), 300)
}

/// The environment with its packages.
fn python(environment: &Path, log: &mut Log) -> Result<(), String> {
    let python = environment.join("bin/python");
    let missing = lacking(&python);
    if missing.is_empty() {
        return Ok(());
    }
    let all: Vec<&str> = missing.iter().map(|(_, package)| *package).collect();
    if !python.is_file() {
        log.run(Command::new("python3").args(["-m", "venv"]).arg(environment), 60)
            .map_err(|why| format!("no Python environment for {}: {why}", all.join(", ")))?;
    }
    // One package after the other: one that is not to be had for this Python takes no other with it.
    let mut refused = Vec::new();
    for (index, package) in all.iter().enumerate() {
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"]);
        pip.args(["--timeout", "5", "--retries", "0", package]);
        if let Err(why) = log.run(&mut pip, 120) {
            refused.push(format!("no Python package {package}: {why}"));
            if index == 0 {
                // Most likely no network; then none of them is to be had, and each would wait for it.
                refused.extend((all.len() > 1).then(|| format!("{} were not tried", all[1..].join(", "))));
                break;
            }
        }
    }
    if refused.is_empty() { Ok(()) } else { Err(refused.join("; ")) }
}

/// The modules that this Python cannot import: all of them, if there is no such Python.
fn lacking(python: &Path) -> Vec<(&'static str, &'static str)> {
    const TRY: &str = "
import importlib, sys
for name in sys.argv[1:]:
    try: importlib.import_module(name)
    except Exception: continue
    print(name)
";
    let modules = MODULES.map(|(module, _)| module);
    let has = Command::new(python).args(["-c", TRY]).args(modules).stdin(Stdio::null()).stderr(Stdio::null()).output();
    let has = has.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    let is_there = |name: &str| has.lines().any(|line| line == name) || python.with_file_name(name).is_file();
    MODULES.into_iter().filter(|(name, _)| !is_there(name)).collect()
}

fn is_program(name: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let system = ["/usr/sbin", "/sbin"].map(PathBuf::from);
    std::env::split_paths(&path).chain(system).any(|dir| dir.join(name).is_file())
}

/// The owner of a process's own directory in `/proc` is its user.
fn is_root() -> bool {
    #[cfg(unix)]
    return fs::metadata("/proc/self").is_ok_and(|of| std::os::unix::fs::MetadataExt::uid(&of) == 0);
    #[cfg(not(unix))]
    false
}

/// Destination of the output of started programs.
struct Log {
    path: PathBuf,
}

impl Log {
    fn new(path: &Path) -> Self {
        // Without a log there are reasons without words, nothing else.
        let _ = path.parent().map(fs::create_dir_all);
        let _ = File::create(path);
        Self { path: path.to_owned() }
    }

    /// Runs a program to its end, for so many seconds at most.
    ///
    /// # Errors
    /// The last line of its output, if it fails.
    fn run(&mut self, command: &mut Command, seconds: u64) -> Result<(), String> {
        let name = command.get_program().to_string_lossy().into_owned();
        let output = || File::options().append(true).open(&self.path).map_or_else(|_| Stdio::null(), Stdio::from);
        let before = fs::metadata(&self.path).map_or(0, |of| of.len());
        command.stdin(Stdio::null()).stdout(output()).stderr(output());
        let mut child = command.spawn().map_err(|error| format!("{name}: {error}"))?;
        let end = Instant::now() + Duration::from_secs(seconds);
        loop {
            match child.try_wait().map_err(|error| format!("{name}: {error}"))? {
                Some(status) if status.success() => return Ok(()),
                Some(status) => return Err(self.last_line(before).unwrap_or_else(|| format!("{name}: {status}"))),
                None if Instant::now() >= end => {
                    // A package manager puts down its locks when it is terminated.
                    let _ = Command::new("kill").arg(child.id().to_string()).status();
                    thread::sleep(Duration::from_secs(2));
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(format!("{name} took longer than {seconds} s"));
                }
                None => thread::sleep(Duration::from_millis(20)),
            }
        }
    }

    fn last_line(&self, from: u64) -> Option<String> {
        let mut text = Vec::new();
        File::open(&self.path).ok()?.read_to_end(&mut text).ok()?;
        let text = String::from_utf8_lossy(text.get(usize::try_from(from).ok()?..)?).into_owned();
        text.lines().rev().map(str::trim).find(|line| !line.is_empty()).map(str::to_owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(name: &str) -> Log {
        Log::new(&std::env::temp_dir().join(format!("linewright-{name}-{}.log", std::process::id())))
    }

    #[test]
    fn a_program_that_fails_gives_its_last_line_as_the_reason() {
        let mut log = log("reason");
        assert_eq!(log.run(Command::new("sh").args(["-c", "echo before"]), 10), Ok(()));
        let why = log.run(Command::new("sh").args(["-c", "echo one; echo two >&2; echo; exit 3"]), 10);
        assert_eq!(why, Err("two".to_owned()));
        let silent = log.run(Command::new("sh").args(["-c", "exit 3"]), 10).expect_err("it fails");
        assert!(silent.starts_with("sh: ") && silent.ends_with('3'), "{silent}");
        fs::remove_file(&log.path).expect("it was there");
    }

    #[test]
    fn a_program_that_does_not_end_is_ended() {
        let mut log = log("limit");
        let start = Instant::now();
        let why = log.run(Command::new("sleep").arg("60"), 0);
        fs::remove_file(&log.path).expect("it was there");
        assert_eq!(why, Err("sleep took longer than 0 s".to_owned()));
        assert!(start.elapsed() < Duration::from_secs(30));
    }

    #[test]
    fn what_a_python_lacks_is_known_by_importing_it() {
        assert_eq!(lacking(Path::new("no such python")), MODULES);
    }
}
