//! `linewright deploy`, and what a node reports to its service manager.

use std::os::unix::net::UnixDatagram;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::command::{Scratch, linewright, shipped, text};
use crate::support::rig::free_domain;

#[test]
fn each_host_gets_its_services_and_the_same_description() {
    let scratch = Scratch::new();
    let (line, out) = (shipped().display().to_string(), scratch.path("out"));
    let deploy = |more: &[&str]| {
        let words = ["deploy", &line, "--out", &out, "--host", "mill_1=b", "--host", "*=a"];
        linewright(&[&words[..], more].concat())
    };
    let refused = deploy(&[]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("2 hosts need the network"), "{refused:?}");
    let network = ["--network", "192.168.7.0/24"];
    let written = deploy(&network);
    let said = text(&written.stdout);
    assert!(written.status.success(), "{written:?}");
    assert!(said.contains("a: coordinator, transfer, clamp_1\nb: mill_1\n"), "{said}");

    let description = std::fs::read_to_string(shipped().join("line.toml")).expect("the shipped line");
    for host in ["a", "b"] {
        assert_eq!(scratch.read(&format!("out/{host}/etc/linewright/transfer_line/line.toml")), description);
        let environment = scratch.read(&format!("out/{host}/etc/linewright/environment"));
        assert!(environment.contains("ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET\n"), "{environment}");
        let station =
            scratch.read(&format!("out/{host}/etc/systemd/system/linewright-station@.service.d/network.conf"));
        assert!(station.ends_with("IPAddressAllow=localhost 192.168.7.0/24 239.255.0.1\n"), "{station}");
        let script = format!("{out}/{host}/install.sh");
        assert!(Command::new("sh").args(["-n", &script]).status().expect("a shell").success());
        // Each file beside it is installed, and nothing that is not there.
        let script = scratch.read(&format!("out/{host}/install.sh"));
        for install in script.lines().filter_map(|line| line.strip_prefix("install -D -m 644 '")) {
            let (file, _) = install.split_once('\'').expect(install);
            assert!(!scratch.read(&format!("out/{host}/{file}")).is_empty(), "{file}");
        }
    }
    let script = scratch.read("out/b/install.sh");
    assert!(script.contains("systemctl enable linewright-station@mill_1\n"), "{script}");
    assert!(!std::path::Path::new(&scratch.path("out/b/etc/systemd/system/linewright-coordinator.service")).exists());

    let again = deploy(&network);
    assert!(!again.status.success() && text(&again.stderr).contains("a is not empty"), "{again:?}");
    assert!(deploy(&[&network[..], &["--force"]].concat()).status.success());
}

/// systemd reads the services that are shipped without a complaint, where it is at hand.
#[test]
fn the_services_are_ones_that_systemd_reads() {
    use std::io::Write as _;
    let Ok(found) = Command::new("systemd-analyze").arg("--version").output() else {
        let _ = writeln!(std::io::stderr(), "SKIPPED the services as systemd reads them: no systemd-analyze");
        return;
    };
    assert!(found.status.success());
    // Of the program, which is not where the services have it, alone.
    let expected = ["is not executable", "No such file or directory"];
    for unit in ["linewright-coordinator.service", "linewright-station@.service", "linewright-recovery.service"] {
        let path = shipped().join("../../systemd").join(unit);
        let output = Command::new("systemd-analyze").arg("verify").arg(path).output().expect("it runs");
        let complaints: Vec<&str> = text(&output.stderr)
            .lines()
            .filter(|line| line.contains("linewright") && !expected.iter().any(|known| line.contains(known)))
            .collect();
        assert!(complaints.is_empty(), "{unit}: {complaints:?}");
    }
}

/// Ready once its loop goes round, and then alive each second.
#[test]
fn a_node_reports_to_its_service_manager() {
    let scratch = Scratch::new();
    let path = scratch.path("notify");
    let manager = UnixDatagram::bind(&path).expect("a socket");
    manager.set_read_timeout(Some(Duration::from_secs(60))).expect("a timeout");
    let mut node = Command::new(env!("CARGO_BIN_EXE_linewright"));
    node.args(["station", &shipped().display().to_string(), "--station", "mill_1"]);
    node.env("ROS_DOMAIN_ID", free_domain().to_string()).env("NOTIFY_SOCKET", &path);
    let mut node = node.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started");
    let began = Instant::now();
    let next = || {
        let mut buffer = [0; 256];
        let length = manager.recv(&mut buffer).expect("a report");
        String::from_utf8_lossy(&buffer[..length]).trim().to_owned()
    };
    let first = next();
    let second = next();
    let ready = began.elapsed();
    node.kill().expect("ours");
    node.wait().expect("ours");
    assert_eq!((first.as_str(), second.as_str()), ("WATCHDOG=1\nREADY=1", "WATCHDOG=1"), "after {ready:?}");
}
