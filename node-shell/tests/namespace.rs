//! Network namespaces of a test: one with only loopback and one end of a pair of interfaces, and another one with the other end.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};

/// Writes past the test harness, which would swallow it.
pub fn skip(why: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED {why}");
}

/// Runs an ignored test of this program in a namespace of its own, and checks that it passes; a message on the terminal without the
/// right to make one.
pub fn run_inside(what: &str, inside: &str) {
    let script = "ip link add lwcut0 type veth peer name lwcut1 && ip link del lwcut0";
    let probe = Command::new("unshare").args(["-rn", "sh", "-c", script]).stderr(Stdio::null()).status();
    if !probe.is_ok_and(|status| status.success()) {
        return skip(&format!("{what}: no right to make a network namespace with a pair of interfaces"));
    }
    let own = std::env::current_exe().expect("own path");
    let mut command = Command::new("unshare");
    command.arg("-rn").arg(own).args(["--exact", inside, "--ignored", "--nocapture"]);
    let ended = command.stderr(Stdio::inherit()).output().expect("started");
    let output = String::from_utf8_lossy(&ended.stdout);
    println!("{output}");
    assert!(ended.status.success() && output.contains("1 passed"), "see above");
}

/// Whether only loopback is there, and the pair of interfaces of these tests.
pub fn is_alone() -> bool {
    let devices = std::fs::read_to_string("/proc/net/dev").unwrap_or_default();
    let mut names = devices.lines().skip(2).filter_map(|line| Some(line.split_once(':')?.0.trim()));
    names.all(|name| name == "lo" || name.starts_with("lwcut"))
}

pub fn shell(script: &str) {
    let status = Command::new("sh").args(["-ec", script]).status().expect("a shell");
    assert!(status.success(), "{script}");
}

/// Gives this end of the pair its address, and multicast its way.
pub fn up(interface: &str, address: &str) -> String {
    format!(
        "ip addr replace {address}/24 dev {interface}; ip link set {interface} up; ip route replace 239.0.0.0/8 dev {interface}"
    )
}

/// A process of its own that ends with this.
pub struct Ended(pub Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The other namespace, at 10.77.0.2 behind the pair of interfaces; this one is at 10.77.0.1.
pub struct OtherNamespace(Ended);

impl OtherNamespace {
    pub fn start() -> Self {
        let mut holder = Command::new("unshare");
        holder.args(["-n", "sh", "-c", "echo there && exec sleep 300"]).stdout(Stdio::piped());
        let mut holder = Ended(holder.spawn().expect("a namespace"));
        let mut line = String::new();
        BufReader::new(holder.0.stdout.take().expect("piped")).read_line(&mut line).expect("it is there");
        let id = holder.0.id();
        shell(&format!(
            "ip link set lo up; ip link add lwcut0 type veth peer name lwcut1; ip link set lwcut1 netns {id}; {}; \
             nsenter -t {id} -n sh -ec 'ip link set lo up; {}'",
            up("lwcut0", "10.77.0.1"),
            up("lwcut1", "10.77.0.2")
        ));
        OtherNamespace(holder)
    }

    /// An ignored test of this program, to be started there.
    pub fn test(&self, name: &str) -> Command {
        let mut beside = Command::new("nsenter");
        beside.args(["-t", &self.0.0.id().to_string(), "-n"]).arg(std::env::current_exe().expect("own path"));
        beside.args(["--exact", name, "--ignored", "--nocapture"]);
        beside
    }
}
