//! Positions of the simulated plant in a file, so that a plant that is started again stands where it stood.
//!
//! A thread writes: a plant does not wait for a disk. The file is replaced whole; a kill leaves the one before. It is not
//! forced onto the disk: a simulated machine survives no power cut.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use linewright_line::{DeviceBus, Line, Tick};
use linewright_plant::{PlantOptions, Rack, RackPositions};
use serde::{Deserialize, Serialize};

/// Name of the file in a state directory.
pub const KEPT_IN: &str = "plant.json";
/// The form of the file. Another one gets another number.
const VERSION: u32 = 1;
/// Shortest time between two writes.
const WRITE_EVERY: Duration = Duration::from_millis(200);

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
    let unusable = |why: &dyn std::fmt::Display| {
        format!(
            "positions of the simulated machine in {} cannot be used: {why}; it begins at home, empty, and stations that were \
             stopped elsewhere report `position lost`",
            path.display()
        )
    };
    let text = match std::fs::read(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(KeptPositions::Nothing),
        Err(error) => return Err(unusable(&error)),
    };
    let AnyPlantFile { version } = serde_json::from_slice(&text).map_err(|error| unusable(&error))?;
    if version != VERSION {
        return Err(unusable(&format!("it has form {version}, this program reads form {VERSION}")));
    }
    let file: PlantFile = serde_json::from_slice(&text).map_err(|error| unusable(&error))?;
    if file.line != line.name {
        return Err(unusable(&format!("they are those of line `{}`", file.line)));
    }
    let buses: BTreeMap<String, &DeviceBus> =
        line.devices.iter().map(|device| (device.bus.to_string(), &device.bus)).collect();
    if !buses.keys().eq(file.buses.keys()) {
        return Err(unusable(&"the line has other buses now"));
    }
    let rack = |(name, bus): (String, &DeviceBus)| {
        let rack = Rack::resumed(now, line, bus, options, &file.buses[&name]).map_err(|why| unusable(&why))?;
        Ok((name, rack))
    };
    buses.into_iter().map(rack).collect::<Result<_, String>>().map(KeptPositions::Racks)
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
        let (dir, its) = (dir.to_owned(), newest.clone());
        let thread = std::thread::spawn(move || write_all(&dir, file, &its, &woken));
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
    /// Returns when the last positions are written.
    pub fn end(self) {
        let _ = self.0.join();
    }
}

fn write_all(dir: &Path, mut file: PlantFile, newest: &Newest, woken: &Receiver<()>) {
    let mut is_reported = false;
    while let Ok(()) = woken.recv() {
        file.buses.append(&mut newest.lock().unwrap_or_else(PoisonError::into_inner));
        match write(dir, &file) {
            Ok(()) => is_reported = false,
            Err(error) if !is_reported => {
                is_reported = true;
                tracing::warn!(
                    "positions of the simulated machine cannot be written to {}: {error}; a run that goes on from this state \
                     finds it elsewhere; make room on the disk, or the directory writable",
                    dir.join(KEPT_IN).display()
                );
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
