//! The virtual buses of one run, apart from all others.
//!
//! A run that simulates its devices brings its whole bus along: it shares no device with another. So it gets a
//! directory of its own, in which every bus it names is another bus than one of the same name elsewhere. A tool that
//! looks for a bus by name finds it here as long as it has a member (see [`find`]).

use std::fs;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};

use super::members::{at, checked_base, chosen_base, scan};

/// Prefix of the directory of a run, before a number.
const PREFIX: &str = "run-";
/// The file that names the run.
const ABOUT: &str = "about";
/// Most names tried for a new directory.
const TRIES: u32 = 64;

/// A directory of buses. Dropping it removes it.
#[derive(Debug)]
pub struct OwnBuses {
    dir: PathBuf,
}

impl OwnBuses {
    /// A new one; `about` names its run. `None` where the environment names a directory for all buses: that is used.
    ///
    /// # Errors
    /// When the directory cannot be made.
    pub fn create(about: &str) -> io::Result<Option<Self>> {
        if chosen_base().is_some() {
            return Ok(None);
        }
        OwnBuses::create_in(&checked_base()?, about).map(Some)
    }

    /// The same in the directory `base`, whatever the environment names.
    ///
    /// # Errors
    /// When the directory cannot be made.
    pub fn create_in(base: &Path, about: &str) -> io::Result<Self> {
        sweep(base);
        for number in 0..TRIES {
            let dir = base.join(format!("{PREFIX}{:x}-{number}", std::process::id()));
            match fs::DirBuilder::new().mode(0o700).create(&dir) {
                Ok(()) => {
                    let own = OwnBuses { dir };
                    let file = own.dir.join(ABOUT);
                    fs::write(&file, about).map_err(|error| at(&file, &error))?;
                    return Ok(own);
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(at(&dir, &error)),
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("no name is free in {}", base.display())))
    }

    /// Their directory: for [`Options::dir`](super::BusOptions), and for other processes in `LINEWRIGHT_BUS_DIR`.
    pub fn dir(&self) -> &Path {
        &self.dir
    }
}

impl Drop for OwnBuses {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.dir);
    }
}

/// Removes the remains of killed runs: directories whose process has ended and whose buses have no member.
fn sweep(base: &Path) {
    for dir in runs(base) {
        let process = dir.file_name().and_then(|name| name.to_str()?.strip_prefix(PREFIX)?.split('-').next()?.into());
        let process = process.and_then(|hex: &str| u32::from_str_radix(hex, 16).ok());
        let is_there = process.is_none_or(|id| Path::new(&format!("/proc/{id}")).exists());
        if !is_there && !entries(&dir).any(|bus| has_members(&bus)) {
            let _ = fs::remove_dir_all(dir);
        }
    }
}

fn entries(dir: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path())
}

fn runs(base: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let is_run = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX));
    entries(base).filter(is_run)
}

/// Whether a living process is on a bus: the socket of a killed one refuses connections.
fn has_members(bus: &Path) -> bool {
    let is_alive = |path: PathBuf| UnixDatagram::unbound().is_ok_and(|socket| socket.connect(path).is_ok());
    scan(bus).unwrap_or_default().into_iter().any(is_alive)
}

/// A directory with members on a bus of the requested name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusDirectory {
    /// The run whose bus it is; `None` for the shared one.
    pub about: Option<String>,
    /// For [`Options::dir`](super::BusOptions).
    pub dir: PathBuf,
}

/// Directories with members on a virtual bus `name`: the shared one, and those of runs; only of the run `about` if that
/// is given. Empty where the environment names a directory for all buses.
pub fn find(name: &str, about: Option<&str>) -> Vec<BusDirectory> {
    if chosen_base().is_some() {
        return Vec::new();
    }
    let Ok(base) = checked_base() else { return Vec::new() };
    find_in(&base, name, about)
}

/// The same below the directory `base`.
pub fn find_in(base: &Path, name: &str, about: Option<&str>) -> Vec<BusDirectory> {
    let mut found: Vec<BusDirectory> = runs(base)
        .filter(|dir| has_members(&dir.join(name)))
        .map(|dir| BusDirectory { about: Some(fs::read_to_string(dir.join(ABOUT)).unwrap_or_default()), dir })
        .filter(|found| about.is_none() || found.about.as_deref() == about)
        .collect();
    if (about.is_none() || found.is_empty()) && has_members(&base.join(name)) {
        found.push(BusDirectory { about: None, dir: base.to_owned() });
    }
    found
}
