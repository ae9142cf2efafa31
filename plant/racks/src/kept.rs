//! Positions of the simulated plant in a file, so that a plant that is started again stands where it stood.
//!
//! A thread writes: a plant does not wait for a disk. The file is replaced whole; a kill leaves the one before. It is not
//! forced onto the disk: a simulated machine survives no power cut. It has the positions of every bus, or is not written. A file that
//! cannot be used is kept beside it.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use linewright_line::{DeviceBus, Line, Tick};
use linewright_plant::{PlantOptions, Rack, RackPositions};
use serde::{Deserialize, Serialize};

use crate::texts::{PlantNews, UnusablePositions};

/// Name of the file in a state directory.
pub const KEPT_IN: &str = "plant.json";
/// The form of the file. Another one gets another number.
pub(crate) const VERSION: u32 = 1;
/// Shortest time between two writes.
const WRITE_EVERY: Duration = Duration::from_millis(200);
/// Longest wait at the end of the process for the last write, and the period of the check.
const END: Duration = Duration::from_secs(2);
const POLL: Duration = Duration::from_millis(10);
/// Files kept that could not be used; of more the last is replaced.
const SET_ASIDE_MAX: usize = 5;

/// Contents of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlantFile {
    version: u32,
    line: String,
    /// By name of the bus.
    buses: BTreeMap<String, RackPositions>,
}

/// The version alone, of any form.
#[derive(Deserialize)]
struct AnyPlantFile {
    version: u32,
}

/// What was found in a state directory.
pub enum KeptPositions {
    /// No plant has kept its positions there.
    Nothing,
    /// By name of the bus.
    Racks(BTreeMap<String, Rack>),
}

/// Racks as they were when a plant last kept its positions in `dir`.
///
/// # Errors
/// Why they cannot be used, with what follows.
pub fn kept_positions(dir: &Path, line: &Line, now: Tick, options: PlantOptions) -> Result<KeptPositions, String> {
    let path = dir.join(KEPT_IN);
    let unusable = |why: UnusablePositions| why.text(&path);
    let unreadable = |why: String| unusable(UnusablePositions::Unreadable(why));
    let text = match std::fs::read(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(KeptPositions::Nothing),
        Err(error) => return Err(unreadable(error.to_string())),
    };
    let AnyPlantFile { version } = serde_json::from_slice(&text).map_err(|error| unreadable(error.to_string()))?;
    if version != VERSION {
        return Err(unusable(UnusablePositions::Version(version)));
    }
    let file: PlantFile = serde_json::from_slice(&text).map_err(|error| unreadable(error.to_string()))?;
    if file.line != line.name {
        return Err(unusable(UnusablePositions::OtherLine(file.line)));
    }
    let buses: BTreeMap<String, &DeviceBus> =
        line.devices.iter().map(|device| (device.bus.to_string(), &device.bus)).collect();
    if !buses.keys().eq(file.buses.keys()) {
        return Err(unusable(UnusablePositions::OtherBuses));
    }
    let rack = |(name, bus): (String, &DeviceBus)| {
        let rack = Rack::resumed(now, line, bus, options, &file.buses[&name])
            .map_err(|why| unusable(UnusablePositions::Misfit(why)))?;
        Ok((name, rack))
    };
    buses.into_iter().map(rack).collect::<Result<_, String>>().map(KeptPositions::Racks)
}

/// Renames a file that cannot be used, so that it is not overwritten.
pub(crate) fn set_aside(dir: &Path) {
    let name = |nth: usize| dir.join(format!("{KEPT_IN}.unusable-{nth}"));
    let free = (1..SET_ASIDE_MAX).map(name).find(|name| !name.exists()).unwrap_or_else(|| name(SET_ASIDE_MAX));
    match std::fs::rename(dir.join(KEPT_IN), &free) {
        Ok(()) => tracing::warn!("the positions that cannot be used are kept as {}", free.display()),
        Err(error) => tracing::warn!("the positions that cannot be used are overwritten: {error}"),
    }
}

/// Takes positions to be written.
#[derive(Clone)]
pub struct Keeper {
    newest: Newest,
    wake: SyncSender<()>,
}

/// Positions to be written, by name of the bus: the newest alone.
type Newest = Arc<Mutex<BTreeMap<String, RackPositions>>>;

impl Keeper {
    /// Begins to write into `dir`. It ends when every copy of this is dropped.
    pub fn begin(dir: &Path, line: &Line) -> (Self, KeeperThread) {
        let ((wake, woken), newest) = (sync_channel(1), Newest::default());
        let file = PlantFile { version: VERSION, line: line.name.clone(), buses: BTreeMap::new() };
        let mut buses: Vec<String> = line.devices.iter().map(|device| device.bus.to_string()).collect();
        buses.sort();
        buses.dedup();
        let (dir, its) = (dir.to_owned(), newest.clone());
        let thread = std::thread::spawn(move || write_all(&dir, file, buses.len(), &its, &woken));
        (Keeper { newest, wake }, KeeperThread(thread))
    }

    /// It never waits.
    pub fn keep(&self, bus: &str, positions: RackPositions) {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).insert(bus.to_owned(), positions);
        // One that is awake takes this too. One that has ended, which would be a bug, costs the positions alone.
        let _ = self.wake.try_send(());
    }
}

/// The thread that writes.
pub struct KeeperThread(JoinHandle<()>);

impl KeeperThread {
    /// Returns when the last positions are written, or the disk has not taken them for a while.
    pub fn end(self) {
        let since = Instant::now();
        while !self.0.is_finished() {
            if since.elapsed() >= END {
                tracing::warn!(
                    "the last positions of the simulated machine are not written after {} s, the disk hangs; a run that goes on \
                     from this state may find it elsewhere",
                    END.as_secs()
                );
                return;
            }
            std::thread::sleep(POLL);
        }
    }
}

fn write_all(dir: &Path, mut file: PlantFile, buses: usize, newest: &Newest, woken: &Receiver<()>) {
    let mut is_reported = false;
    while let Ok(()) = woken.recv() {
        file.buses.append(&mut newest.lock().unwrap_or_else(PoisonError::into_inner));
        if file.buses.len() < buses {
            continue;
        }
        match write(dir, &file) {
            Ok(()) => is_reported = false,
            Err(error) if !is_reported => {
                is_reported = true;
                tracing::warn!("{}", PlantNews::NotKept { path: &dir.join(KEPT_IN), why: error.to_string() });
            }
            Err(_) => {}
        }
        std::thread::sleep(WRITE_EVERY);
    }
}

fn write(dir: &Path, file: &PlantFile) -> io::Result<()> {
    let name: PathBuf = dir.join(KEPT_IN);
    let unfinished = name.with_extension("json.new");
    std::fs::create_dir_all(dir)?;
    std::fs::write(&unfinished, serde_json::to_vec(file)?)?;
    std::fs::rename(&unfinished, &name)
}
