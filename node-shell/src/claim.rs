//! Exclusive claims on this machine: a node name in a ROS domain, a run of a line, a CAN bus as its manager, a state
//! directory.
//!
//! The middleware accepts two nodes of one name, and both would control the same machine. So each process claims its name
//! before it opens anything; a second process is refused with the id of the first. The kernel holds a claim and ends it with
//! the process, however that ends; no file has to be cleaned up:
//!
//! - a name is an abstract socket address. It needs no directory that may be missing, full or another user's, and it is as
//!   far-reaching as the loopback address and the CAN interfaces are: one network namespace;
//! - a directory is a locked file in it, because a directory may be shared between network namespaces.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use chrono::{DateTime, Utc};
use thiserror::Error;

use crate::RosArgs;
use crate::names::{self, NameError};

/// An abstract address holds 107 bytes.
const NAME_MAX: usize = 107;
/// As much of a command line as is shown.
const SHOWN: usize = 160;
/// Ticks of the kernel's clock in `/proc/<id>/stat`, a fixed number for programs.
const TICKS: f64 = 100.0;

/// Why a claim fails.
#[derive(Debug, Error)]
pub enum ClaimError {
    /// Another process holds it.
    #[error("{what} is already running: {holder}. {advice}")]
    Taken {
        /// The claimed name.
        what: String,
        /// Its holder.
        holder: String,
        /// Remedy.
        advice: &'static str,
    },
    /// The name or namespace is none.
    #[error("node name: {0}")]
    Name(#[from] NameError),
    /// The system refuses.
    #[error("cannot claim {what}: {error}")]
    System {
        /// The claimed name.
        what: String,
        /// The system's reason.
        error: io::Error,
    },
}

/// Held until it is dropped, or the process ends.
#[derive(Debug)]
pub enum Claim {
    /// By an address.
    Name(UnixDatagram),
    /// By a lock; `None` on a file system without locks.
    File(Option<File>),
}

impl Claim {
    /// Claims the node name `name`, as the remap rules of `args` rename it, in its ROS domain.
    ///
    /// # Errors
    /// When another process holds it; when the name is not valid.
    pub fn node(args: &RosArgs, namespace: &str, name: &str) -> Result<Self, ClaimError> {
        let full = full_name(args, namespace, name)?;
        let what = format!("node {full} in ROS domain {}", args.domain_id);
        let advice = "End that process first, or give this one another ROS_DOMAIN_ID or name.";
        Self::named(&format!("linewright/node/{}{full}", args.domain_id), what, advice)
    }

    /// Claims the run of the line of this namespace, as the remap rules of `args` rename it, in its ROS domain.
    ///
    /// # Errors
    /// When another process holds it; when the namespace is not valid.
    pub fn line(args: &RosArgs, namespace: &str) -> Result<Self, ClaimError> {
        let (namespace, _) = names::identify(&args.remaps, namespace, "coordinator")?;
        let what = format!("a run of {}", RunName::of(&namespace, args.domain_id));
        let advice = "End that run first, or give this one another ROS_DOMAIN_ID or namespace (-r __ns:=/other).";
        Self::named(&format!("linewright/run/{}{namespace}", args.domain_id), what, advice)
    }

    /// Claims a CAN bus for its manager; `place` is its interface, or the directory of a virtual one.
    ///
    /// # Errors
    /// When another process holds it.
    pub fn bus(place: &str) -> Result<Self, ClaimError> {
        let what = format!("a manager of CAN bus {place}");
        let advice = "End that process first, or give this one another bus: `--bus vcan1` for the line's, `bus` in the description for a \
                      station's own. Virtual buses are others in another directory as well: set LINEWRIGHT_BUS_DIR, for all commands of this line.";
        Self::named(&format!("linewright/bus/{place}"), what, advice)
    }

    /// Marks `interface`, which is at `place` (see [`Claim::bus`]), as the bus that this node manages; processes of this machine
    /// find it by [`bus_managed_by`] and [`lines_managing`].
    ///
    /// # Errors
    /// When another process has marked it so; when the name is not valid.
    pub fn managed_bus(
        args: &RosArgs,
        (namespace, name): (&str, &str),
        interface: &str,
        place: &str,
    ) -> Result<Self, ClaimError> {
        let node = full_name(args, namespace, name)?;
        let what = format!("the manager {node} in ROS domain {} on CAN bus {interface}", args.domain_id);
        let advice = "End that process first, or give this one another ROS_DOMAIN_ID or name.";
        Self::named(&mark(interface, checksum(place), args.domain_id, &node), what, advice)
    }

    /// Claims `name` in a directory, which must exist.
    ///
    /// # Errors
    /// When another process holds it; when the lock file cannot be opened.
    pub fn file(directory: &Path, name: &str) -> Result<Self, ClaimError> {
        let path = directory.join(format!("{name}.lock"));
        let what = format!("a process that keeps its state in {}", path.display());
        let failed = |error| ClaimError::System { what: what.clone(), error };
        let mut file =
            File::options().read(true).write(true).create(true).truncate(false).open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {
                // For refused processes. A full disk costs this text only: the lock is no text.
                let text = format!("process {}, since {}\n", std::process::id(), clock(SystemTime::now()));
                let _ = file.set_len(0).and_then(|()| file.write_all(text.as_bytes()));
                Ok(Claim::File(Some(file)))
            }
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                let _ = Read::by_ref(&mut file).take(SHOWN as u64).read_to_string(&mut holder);
                let holder = match holder.trim() {
                    "" => "another process".to_owned(),
                    text => text.to_owned(),
                };
                Err(ClaimError::Taken { what, holder, advice: "End it first, or give this one another --state-dir." })
            }
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {
                tracing::warn!("{} cannot be locked: {error}; a second process there is not noticed", path.display());
                Ok(Claim::File(None))
            }
            Err(TryLockError::Error(error)) => Err(failed(error)),
        }
    }

    fn named(name: &str, what: String, advice: &'static str) -> Result<Self, ClaimError> {
        let name = shortened(name);
        let bound =
            SocketAddr::from_abstract_name(name.as_bytes()).and_then(|address| UnixDatagram::bind_addr(&address));
        match bound {
            Ok(socket) => Ok(Claim::Name(socket)),
            Err(error) if error.kind() == io::ErrorKind::AddrInUse => {
                let holder = holder_of(&name).unwrap_or_else(|| "another process of this machine".to_owned());
                Err(ClaimError::Taken { what, holder, advice })
            }
            Err(error) => Err(ClaimError::System { what, error }),
        }
    }
}

/// What a mark of a managed bus begins with. Interface, checksum of its place, ROS domain and node follow.
const MANAGED: &str = "linewright/managed";

fn mark(interface: &str, place: u32, domain: u16, node: &str) -> String {
    format!("{MANAGED}/{interface}/{place:08x}/{domain}{node}")
}

fn checksum(place: &str) -> u32 {
    crc32fast::hash(place.as_bytes())
}

fn full_name(args: &RosArgs, namespace: &str, name: &str) -> Result<String, NameError> {
    let (namespace, name) = names::identify(&args.remaps, namespace, name)?;
    names::expand(&name, &namespace, &name)
}

/// A bus that a node of this machine manages.
struct ManagedBus {
    /// Name of the mark, which may be shortened.
    mark: String,
    interface: String,
    /// Checksum of its place.
    place: u32,
    /// ROS domain and node, as far as the mark has them.
    by: String,
}

/// Every managed bus of this machine.
fn managed() -> Vec<ManagedBus> {
    let sockets = fs::read_to_string("/proc/self/net/unix").unwrap_or_default();
    let found = sockets.lines().filter_map(|line| {
        let name = line.split_whitespace().nth(7)?.strip_prefix('@')?;
        let (interface, rest) = name.strip_prefix(MANAGED)?.strip_prefix('/')?.split_once('/')?;
        let (place, by) = rest.split_once('/')?;
        let place = u32::from_str_radix(place, 16).ok()?;
        Some(ManagedBus { mark: name.to_owned(), interface: interface.to_owned(), place, by: by.to_owned() })
    });
    found.collect()
}

/// The interface of the bus that a node manages on this machine; `None` if none runs here, or its name is not valid.
pub fn bus_managed_by(args: &RosArgs, namespace: &str, name: &str) -> Option<String> {
    let node = full_name(args, namespace, name).ok()?;
    let is_own = |bus: &ManagedBus| bus.mark == shortened(&mark(&bus.interface, bus.place, args.domain_id, &node));
    managed().into_iter().find(is_own).map(|bus| bus.interface)
}

/// The name of a run: its line and its ROS domain.
pub struct RunName;

impl RunName {
    const DOMAIN: &str = " in ROS domain ";

    /// `line /name in ROS domain 3`
    pub fn of(namespace: &str, domain: impl std::fmt::Display) -> String {
        format!("line {namespace}{}{domain}", RunName::DOMAIN)
    }

    /// Whether two names are of one line, in whatever ROS domain.
    pub fn is_same_line(a: &str, b: &str) -> bool {
        let line = |name: &str| name.split_once(RunName::DOMAIN).map_or(name.len(), |(line, _)| line.len());
        a[..line(a)] == b[..line(b)]
    }
}

/// The lines whose nodes manage the bus `interface` at `place`, each as `line /name in ROS domain 3`; without those whose names are
/// too long for a mark.
pub fn lines_managing(interface: &str, place: &str) -> Vec<String> {
    let place = checksum(place);
    let here = managed().into_iter().filter(|bus| bus.interface == interface && bus.place == place);
    let line = |bus: ManagedBus| {
        let (domain, node) = bus.by.split_once('/').filter(|_| bus.mark.len() < NAME_MAX)?;
        let (namespace, _) = node.rsplit_once('/')?;
        Some(RunName::of(&format!("/{namespace}"), domain))
    };
    here.filter_map(line).collect()
}

/// A name that is too long ends in a checksum of all of it.
fn shortened(name: &str) -> String {
    if name.len() <= NAME_MAX {
        return name.to_owned();
    }
    let sum = format!("~{:08x}{:08x}", crc32fast::hash(name.as_bytes()), name.len());
    let kept =
        name.char_indices().map(|(at, c)| at + c.len_utf8()).take_while(|end| end + sum.len() <= NAME_MAX).last();
    format!("{}{sum}", &name[..kept.unwrap_or(0)])
}

/// The process that holds an abstract address: its number, command line and age, as far as the system shows them.
fn holder_of(name: &str) -> Option<String> {
    let sockets = fs::read_to_string("/proc/self/net/unix").ok()?;
    let address = format!("@{name}");
    let line = sockets.lines().find(|line| line.split_whitespace().nth(7) == Some(&address))?;
    let link = format!("socket:[{}]", line.split_whitespace().nth(6)?);
    let process = fs::read_dir("/proc").ok()?.flatten().find(|process| {
        // Not `self`, which names no process to the reader.
        if !process.file_name().to_string_lossy().bytes().all(|byte| byte.is_ascii_digit()) {
            return false;
        }
        let opened = fs::read_dir(process.path().join("fd")).into_iter().flatten().flatten();
        opened.into_iter().any(|file| fs::read_link(file.path()).is_ok_and(|to| to.as_os_str() == link.as_str()))
    })?;
    Some(described(&process.file_name().to_string_lossy(), &process.path()))
}

fn described(number: &str, process: &Path) -> String {
    let mut text = format!("process {number}");
    if let Some(age) = age_of(process) {
        let since = SystemTime::now().checked_sub(age).unwrap_or(UNIX_EPOCH);
        text.push_str(&format!(", since {}", clock(since)));
    }
    let line = fs::read(process.join("cmdline")).unwrap_or_default();
    let words: Vec<_> = line.split(|byte| *byte == 0).map(String::from_utf8_lossy).collect();
    let words: String = words.join(" ").trim().chars().filter(|c| !c.is_control()).take(SHOWN).collect();
    if words.is_empty() { text } else { format!("{text} ({words})") }
}

/// Age of a process: the 22nd field of its `stat` is its start, after the name in parentheses, which may hold anything.
fn age_of(process: &Path) -> Option<Duration> {
    let stat = fs::read_to_string(process.join("stat")).ok()?;
    let began: f64 = stat.rsplit_once(')')?.1.split_whitespace().nth(19)?.parse().ok()?;
    let uptime: f64 = fs::read_to_string("/proc/uptime").ok()?.split_whitespace().next()?.parse().ok()?;
    Duration::try_from_secs_f64((uptime - began / TICKS).max(0.0)).ok()
}

/// A time of day in UTC, with its date: `2026-11-23 20:06:29 UTC`.
pub fn clock(at: SystemTime) -> String {
    DateTime::<Utc>::from(at).format("%Y-%m-%d %H:%M:%S UTC").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(domain_id: u16, more: &[&str]) -> RosArgs {
        let words = more.iter().map(|word| (*word).to_owned());
        let (mut args, _) = RosArgs::parse(words, |_| None, |_| Ok(String::new())).expect("arguments");
        args.domain_id = domain_id;
        args
    }

    /// A namespace that no line has and no other test claims.
    fn namespace(name: &str) -> String {
        format!("/claims_{}_{name}", std::process::id())
    }

    #[test]
    fn the_second_node_of_a_name_is_refused_with_the_first_ones_process_and_follows_when_that_has_ended() {
        let here = namespace("node");
        let first = Claim::node(&args(7, &[]), &here, "clamp_1").expect("the first");
        let refused = Claim::node(&args(7, &[]), &here, "clamp_1").expect_err("the second").to_string();
        let this = format!("process {}, since ", std::process::id());
        assert!(refused.contains(&this), "{refused}");
        assert!(refused.starts_with(&format!("node {here}/clamp_1 in ROS domain 7 is already running")), "{refused}");
        drop(first);
        Claim::node(&args(7, &[]), &here, "clamp_1").expect("the first has ended");
    }

    #[test]
    fn domains_names_and_kinds_do_not_exclude_each_other() {
        let here = namespace("apart");
        let other = ["--ros-args", "-r", "__ns:=/elsewhere_in_a_test"];
        let _held = [
            Claim::node(&args(7, &[]), &here, "clamp_1").expect("one"),
            Claim::node(&args(8, &[]), &here, "clamp_1").expect("another domain"),
            Claim::node(&args(7, &[]), &here, "clamp_2").expect("another name"),
            Claim::node(&args(7, &other), &here, "clamp_1").expect("another namespace"),
            Claim::line(&args(7, &[]), &here).expect("a run"),
            Claim::line(&args(8, &[]), &here).expect("a run in another domain"),
        ];
        assert!(matches!(Claim::line(&args(7, &[]), &here), Err(ClaimError::Taken { .. })));
    }

    #[test]
    fn the_bus_of_a_line_is_found_as_long_as_its_manager_runs_and_so_is_the_line_of_a_bus() {
        let (here, long) = (namespace("bus"), namespace(&"y".repeat(90)));
        let find = |domain, line: &str| bus_managed_by(&args(domain, &[]), line, "coordinator");
        let at = |name: &str| format!("/run/{here}/{name}");
        let mark = |line: &str, name: &str| {
            Claim::managed_bus(&args(7, &[]), (line, "coordinator"), name, &at(name)).expect("nobody manages it")
        };
        assert_eq!(find(7, &here), None);
        let held = [mark(&here, "vcan7"), mark(&long, "vcan8")];
        assert_eq!(find(7, &here).as_deref(), Some("vcan7"));
        assert_eq!(find(7, &long).as_deref(), Some("vcan8"), "a name that is shortened");
        assert_eq!((find(8, &here), find(7, &format!("{here}_2"))), (None, None), "others have none");
        assert_eq!(lines_managing("vcan7", &at("vcan7")), [format!("line {here} in ROS domain 7")]);
        assert_eq!(lines_managing("vcan7", "/elsewhere/vcan7"), [""; 0], "a bus of that name elsewhere");
        drop(held);
        assert_eq!((find(7, &here), lines_managing("vcan7", &at("vcan7"))), (None, Vec::new()));
    }

    #[test]
    fn names_that_are_too_long_are_still_told_apart() {
        let long = namespace(&"x".repeat(150));
        let _one = Claim::node(&args(7, &[]), &long, "a").expect("one");
        let _two = Claim::node(&args(7, &[]), &long, "b").expect("two");
        let refused = Claim::node(&args(7, &[]), &long, "a").expect_err("the same").to_string();
        assert!(refused.contains(&std::process::id().to_string()), "{refused}");
        assert_eq!(shortened(&"é".repeat(200)).len(), NAME_MAX);
    }

    #[test]
    fn a_state_directory_has_one_process_of_a_name() {
        let directory = tempfile::tempdir().expect("a directory");
        let first = Claim::file(directory.path(), "clamp_1").expect("the first");
        Claim::file(directory.path(), "mill_1").expect("another name");
        let refused = Claim::file(directory.path(), "clamp_1").expect_err("the second").to_string();
        assert!(refused.contains(&format!("process {}, since 20", std::process::id())), "{refused}");
        assert!(refused.contains("--state-dir"), "{refused}");
        drop(first);
        Claim::file(directory.path(), "clamp_1").expect("the first has ended");
    }
}
