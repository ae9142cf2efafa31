//! One line on this machine, with a ROS domain, a bus and a directory of its own.
//!
//! Whatever becomes of a test, no process of its rig outlives it.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::UdpSocket;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use linewright_msgs::StationState;
use serde_json::Value;
use tempfile::TempDir;

use super::bus::{self, Member};
use super::eye::Eye;
use super::operator::Operator;
use super::plan::Plan;
use super::turn::{self, Turn};
use super::{PATIENCE, wait_for};

/// No CAN interface has this name, so it is a virtual bus even where the kernel has `vcan0`, or a machine on `can0`.
pub const BUS: &str = "rig-line";
/// Another one, for a station's own devices.
pub const OWN_BUS: &str = "rig-own";

/// Ages and leases are much longer than those of a plant: a machine that is busy, or that its own host lets stand for
/// half a second, must not look like a broken one.
pub const TIMING: &str = "\n[timing]\nstale_ms = 1000\nlease_ms = 2000\nheartbeat_timeout_ms = 1500\n";

/// The shipped line, its mechanisms faster or slower.
pub fn line(time_scale: f64) -> String {
    linewright_line::TransferLine { machines: 1, time_scale }.text() + TIMING
}

/// A line and everything around it.
pub struct Rig {
    pub eye: Eye,
    pub plan: Plan,
    run: Option<Child>,
    domain: u16,
    directory: TempDir,
    environment: Vec<(&'static str, PathBuf)>,
    /// Command line by which `linewright` is started, as `nsenter` in a namespace; empty if it is started by itself.
    prefix: Vec<String>,
    _turn: Turn,
}

impl Rig {
    /// A rig for this description; nothing runs yet.
    pub fn new(text: &str) -> Self {
        let turn = turn::rig();
        let directory = tempfile::Builder::new().prefix("lw").tempdir().expect("a directory");
        fs::create_dir_all(directory.path().join("line")).expect("a directory");
        fs::create_dir_all(directory.path().join("state")).expect("a directory");
        fs::write(directory.path().join("line/line.toml"), text).expect("a description");
        let plan = Plan::of(text);
        let buses = [BUS, OWN_BUS].map(|bus| directory.path().join("bus").join(bus));
        let eye = Eye::open(plan.clone(), buses.to_vec());
        Rig {
            eye,
            plan,
            run: None,
            domain: free_domain(),
            directory,
            environment: Vec::new(),
            prefix: Vec::new(),
            _turn: turn,
        }
    }

    /// Adds a variable to the environment of its processes.
    pub fn environment(&mut self, name: &'static str, value: &Path) {
        self.environment.push((name, value.to_owned()));
    }

    /// Starts its processes by the command line `prefix`, as `nsenter` in a namespace.
    pub fn inside(&mut self, prefix: Vec<String>) {
        self.prefix = prefix;
    }

    /// The `linewright` command behind its prefix, still without arguments.
    fn program(&self) -> Command {
        let own = env!("CARGO_BIN_EXE_linewright");
        let Some((first, rest)) = self.prefix.split_first() else { return Command::new(own) };
        let mut command = Command::new(first);
        command.args(rest).arg(own);
        command
    }

    /// One more file beside the description.
    pub fn file(&self, name: &str, text: &str) {
        fs::write(self.directory.path().join("line").join(name), text).expect("a file beside the description");
    }

    /// Replaces texts in a file beside the description; each has to be there.
    pub fn change(&self, name: &str, pairs: &[(&str, &str)]) {
        let path = self.directory.path().join("line").join(name);
        let mut text = fs::read_to_string(&path).expect("a file beside the description");
        for (from, to) in pairs {
            assert!(text.contains(from), "{name} has no {from}");
            text = text.replace(from, to);
        }
        self.file(name, &text);
    }

    /// The ROS domain of this rig.
    pub fn domain(&self) -> u16 {
        self.domain
    }

    /// The `linewright` command in this rig's surroundings: `words`, then the line, then `more`.
    pub fn command(&self, words: &[&str], more: &[&str]) -> Command {
        let mut command = self.program();
        command.args(words).arg(self.directory.path().join("line")).args(more);
        for other in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "RUST_LOG"] {
            command.env_remove(other);
        }
        command.envs(self.environment.iter().map(|(name, value)| (name, value)));
        command.env("ROS_DOMAIN_ID", self.domain.to_string());
        command.env("LINEWRIGHT_BUS_DIR", self.directory.path().join("bus"));
        command
    }

    /// Starts `linewright run` with these options.
    pub fn start(&mut self, options: &[&str]) {
        let state = self.state().display().to_string();
        let mut all = vec!["--bus", BUS, "--json", "--state-dir", &state];
        all.extend(options);
        let said = File::create(self.directory.path().join("run.err")).expect("a file");
        let mut command = self.command(&["run"], &all);
        let run = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(said).spawn();
        self.run = Some(run.expect("the command starts"));
    }

    /// Output of a command that has succeeded.
    pub fn said(&self, words: &[&str], more: &[&str]) -> Result<String, String> {
        let output = self.command(words, more).output().expect("the command starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
    }

    /// Report of `linewright report` on the database, with its chart.
    pub fn report(&self) -> String {
        self.reported(&["--chart"])
    }

    /// Report of `linewright report` on the database with these options.
    pub fn reported(&self, options: &[&str]) -> String {
        let mut command = self.program();
        let output = command.arg("report").arg(self.state()).args(options).output().expect("the command starts");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).expect("text")
    }

    /// Starts the line, joins it and brings it to stand-by.
    pub fn in_stand_by(&mut self) -> Operator {
        self.start(&["--no-auto"]);
        let operator = Operator::join(self);
        operator.order("start", StationState::MODE_STANDBY);
        operator
    }

    /// The same, and then to auto.
    pub fn in_auto(&mut self) -> Operator {
        let operator = self.in_stand_by();
        operator.order("auto", StationState::MODE_AUTO);
        operator
    }

    /// Ctrl-C: the run ends well, after so many restarts of its processes and without a conflict; gives its report.
    pub fn ends_well(&mut self, restarts: u32) -> Value {
        self.signal("INT");
        let (code, report) = self.ended();
        assert_eq!((code, &report["restarts"]), (0, &restarts.into()), "{report}");
        assert_eq!(self.eye.seen().conflicts(), [""; 0]);
        report
    }

    /// Waits for `linewright run` to end; gives its exit code and its report.
    pub fn ended(&mut self) -> (i32, Value) {
        self.ended_within(PATIENCE * 2)
    }

    /// The same, no longer than this.
    pub fn ended_within(&mut self, long: Duration) -> (i32, Value) {
        let ended = ended(self.run.as_mut().expect("it runs"), long);
        self.run = None;
        ended
    }

    /// Sends a signal to `linewright run`.
    pub fn signal(&self, name: &str) {
        send_signal(name, self.run.as_ref().expect("it runs").id());
    }

    /// The process whose command line has all these words.
    pub fn process(&self, words: &[&str]) -> Option<u32> {
        let all = |args: &[String]| words.iter().all(|word| args.iter().any(|arg| arg == word));
        self.processes().into_iter().find(|(_, args)| all(args)).map(|(id, _)| id)
    }

    /// Every process of this rig, with its command line.
    pub fn processes(&self) -> Vec<(u32, Vec<String>)> {
        let ours = self.directory.path().display().to_string();
        let mut found = Vec::new();
        for entry in fs::read_dir("/proc").into_iter().flatten().flatten() {
            let Some(id) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
            let line = fs::read(entry.path().join("cmdline")).unwrap_or_default();
            let args: Vec<String> =
                line.split(|byte| *byte == 0).map(|arg| String::from_utf8_lossy(arg).into_owned()).collect();
            if args.iter().any(|arg| arg.contains(&ours)) {
                found.push((id, args));
            }
        }
        found
    }

    /// Kills a process as no handler can prevent.
    pub fn kill(&self, words: &[&str]) -> u32 {
        let id = self.process(words).unwrap_or_else(|| panic!("a process with {words:?}"));
        send_signal("KILL", id);
        id
    }

    /// Makes a mechanism fail (1 sticks, 3 breaks, 0 works again) by one SDO frame, as `cansend` would.
    pub fn fault(&self, station: &str, operation: &str, code: u8) {
        let (node, sub) = self.plan.fault_object(station, operation);
        let request = 0x600 + u32::from(node);
        self.member().send(&bus::frame(request, &[0x2F, 0x00, 0x5F, sub, code, 0, 0, 0]));
    }

    /// The same by the command.
    pub fn fail(&self, station: &str, operation: &str, what: &str) {
        let more = [station, what, "--operation", operation, "--bus", BUS];
        let output = self.command(&["fail"], &more).output().expect("the command starts");
        assert!(output.status.success(), "{output:?}");
    }

    /// One more place on the line's bus.
    pub fn member(&self) -> Member {
        Member::join(vec![self.bus()], &bus::fresh_name()).expect("a place on the bus")
    }

    /// Diverts the log of one process to this path.
    pub fn log_into(&self, name: &str, path: &Path) {
        symlink(path, self.state().join(format!("{name}.log"))).expect("a link");
    }

    /// The log of one process becomes a full pipe without a reader.
    pub fn log_into_a_full_pipe(&self, name: &str) -> FullPipe {
        let path = self.state().join(format!("{name}.log"));
        let made = Command::new("mkfifo").arg(&path).status().expect("the mkfifo command is there");
        assert!(made.success(), "{made:?}");
        // Open for both, it opens without the other side.
        let open = || File::options().read(true).write(true).open(&path).expect("a pipe");
        let mut filled = open();
        // Ends when the pipe is read, or with the process.
        std::thread::spawn(move || while filled.write_all(&[b'\n'; 512]).is_ok() {});
        FullPipe { _open: open() }
    }

    /// What the run has printed to standard error.
    pub fn run_notes(&self) -> String {
        fs::read_to_string(self.directory.path().join("run.err")).unwrap_or_default()
    }

    /// The log of one process.
    pub fn log(&self, name: &str) -> String {
        fs::read_to_string(self.state().join(format!("{name}.log"))).unwrap_or_default()
    }

    fn bus(&self) -> PathBuf {
        self.directory.path().join("bus").join(BUS)
    }

    /// Directory of the line's journals and logs.
    pub fn state(&self) -> PathBuf {
        self.directory.path().join("state")
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.tell_what_was_said();
        }
        if let Some(mut run) = self.run.take() {
            let _ = run.kill();
            let _ = run.wait();
        }
        // Its children end when their standard input does; those left by then are killed.
        if !wait_for(Duration::from_secs(3), || self.processes().is_empty()) {
            for (id, _) in self.processes() {
                send_signal("KILL", id);
            }
        }
    }
}

impl Rig {
    fn tell_what_was_said(&self) {
        let logs = fs::read_dir(self.state()).into_iter().flatten().flatten().map(|entry| entry.path());
        let logs = logs.filter(|path| path.extension().is_some_and(|extension| extension == "log"));
        let logs = logs.filter(|path| fs::metadata(path).is_ok_and(|of| of.is_file()));
        for path in logs.chain([self.directory.path().join("run.err")]) {
            let text = fs::read_to_string(&path).unwrap_or_default();
            let lines: Vec<&str> = text.lines().collect();
            let last = &lines[lines.len().saturating_sub(25)..];
            eprintln!("--- {}\n{}", path.display(), last.join("\n"));
        }
    }
}

/// Waits for a `linewright run` to end; gives its exit code and its report.
pub fn ended(run: &mut Child, long: Duration) -> (i32, Value) {
    let mut status = None;
    let done = wait_for(long, || {
        status = run.try_wait().expect("a child");
        status.is_some()
    });
    assert!(done, "`linewright run` has not ended after {long:?}");
    let mut text = String::new();
    run.stdout.take().expect("its output").read_to_string(&mut text).expect("text");
    let report = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text:?}"));
    (status.and_then(|status| status.code()).unwrap_or(-1), report)
}

/// An open pipe without a reader.
pub struct FullPipe {
    _open: File,
}

/// Sends a signal to a process.
pub fn send_signal(name: &str, id: u32) {
    let status = Command::new("kill").args([&format!("-{name}"), &id.to_string()]).stderr(Stdio::null()).status();
    assert!(status.is_ok(), "the kill command is there");
}

/// A domain in which no participant of this machine sits (the first one's port is free), and another one each time.
/// Below 34 are the usual ones, above 101 Linux gives the ports to any process.
pub fn free_domain() -> u16 {
    static GIVEN: Mutex<Vec<u16>> = Mutex::new(Vec::new());
    let mut given = GIVEN.lock().unwrap_or_else(PoisonError::into_inner);
    let first = (std::process::id() % 57) as u16;
    let mut domains = (0..57).map(|step| 34 + (first + step) % 57);
    let is_free =
        |domain: &u16| !given.contains(domain) && UdpSocket::bind(("0.0.0.0", 7400 + 250 * domain + 10)).is_ok();
    let domain = domains.find(is_free).expect("a ROS domain that nobody uses");
    given.push(domain);
    domain
}
