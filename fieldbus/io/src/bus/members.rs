//! Members of a virtual bus: the sockets in its directory.
//!
//! Each participant binds one datagram socket, under a name that is never used twice. The directory is the whole
//! membership: a process with a socket in it is on the bus, one that dies without removing it is detected by the first
//! frame sent to it, and no process has to run for the others to meet. Because names are never reused, removing a dead
//! one can never hit a living newcomer.

use std::collections::VecDeque;
use std::fs;
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant, SystemTime};

use linewright_canopen::FRAME_BYTES;

/// Most time until a sender notices a newcomer. Devices and managers time out at ten times that or more. A change of
/// the directory's own time is noticed at once, but that clock can be as coarse as 10 ms.
const RESCAN: Duration = Duration::from_millis(20);

/// One other participant.
pub(super) struct BusMember {
    pub(super) path: PathBuf,
    /// Frames its queue had no room for, oldest first.
    pub(super) backlog: VecDeque<[u8; FRAME_BYTES]>,
}

/// The other participants, as of the last look.
pub(super) struct Members {
    dir: PathBuf,
    own: PathBuf,
    others: Vec<BusMember>,
    scanned: Option<(Instant, Option<SystemTime>)>,
}

impl Members {
    pub(super) fn new(dir: PathBuf, own: PathBuf) -> Self {
        Members { dir, own, others: Vec::new(), scanned: None }
    }

    pub(super) fn dir(&self) -> &Path {
        &self.dir
    }

    pub(super) fn own(&self) -> &Path {
        &self.own
    }

    pub(super) fn rename_own(&mut self, own: PathBuf) {
        self.own = own;
    }

    pub(super) fn others(&mut self) -> &mut Vec<BusMember> {
        &mut self.others
    }

    /// Looks again if there may be something new. Returns whether this participant's own socket is still there: some
    /// systems clean directories of temporary files.
    pub(super) fn refresh(&mut self) -> bool {
        let now = Instant::now();
        let changed = fs::metadata(&self.dir).and_then(|m| m.modified()).ok();
        if self.scanned.is_some_and(|(at, when)| when == changed && now.duration_since(at) < RESCAN) {
            return true;
        }
        self.scanned = Some((now, changed));
        let Ok(found) = scan(&self.dir) else { return false };
        let present = found.contains(&self.own);
        self.others.retain(|m| found.contains(&m.path));
        for path in found {
            if path != self.own && !self.others.iter().any(|m| m.path == path) {
                self.others.push(BusMember { path, backlog: VecDeque::new() });
            }
        }
        present
    }
}

pub(super) fn scan(dir: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(dir)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "can") {
            found.push(path);
        }
    }
    Ok(found)
}

/// A name for a socket that no other participant has, had, or will have.
pub(super) fn fresh_name() -> String {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let nanos = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_nanos() as u64;
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    // Short, because a socket's whole path is limited to 107 bytes.
    format!("{:x}-{nanos:x}-{count:x}.can", std::process::id())
}

/// Makes sure the bus's directory exists.
pub(super) fn prepare(name: &str, dir: Option<&Path>) -> io::Result<PathBuf> {
    let dir = base(dir)?.join(name);
    prepare_again(&dir)?;
    Ok(dir)
}

/// Directory of the buses: this one, if one is given.
pub(super) fn base(dir: Option<&Path>) -> io::Result<PathBuf> {
    match dir.map(Path::to_owned).or_else(chosen_base) {
        Some(base) => Ok(base),
        None => checked_base(),
    }
}

/// The directory for all buses that the environment names.
pub(super) fn chosen_base() -> Option<PathBuf> {
    from_env("LINEWRIGHT_BUS_DIR")
}

/// The directory for buses where the user has chosen none; it exists, and other users cannot listen in.
pub(super) fn checked_base() -> io::Result<PathBuf> {
    let base = default_base()?;
    prepare_again(&base)?;
    // In a shared directory for temporary files another user may have made it first.
    let meta = fs::symlink_metadata(&base)?;
    if !meta.is_dir() || meta.uid() != own_uid()? || meta.mode() & 0o022 != 0 {
        return Err(io::Error::new(
            io::ErrorKind::PermissionDenied,
            format!("{} belongs to someone else or is writable by others", base.display()),
        ));
    }
    Ok(base)
}

fn default_base() -> io::Result<PathBuf> {
    match from_env("XDG_RUNTIME_DIR") {
        Some(run) => Ok(run.join("linewright-bus")),
        None => Ok(std::env::temp_dir().join(format!("linewright-bus-{}", own_uid()?))),
    }
}

fn from_env(name: &str) -> Option<PathBuf> {
    std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from)
}

/// The user this process runs as: the owner of its own entry in `/proc`, which needs no unsafe call.
fn own_uid() -> io::Result<u32> {
    fs::metadata("/proc/self").map(|m| m.uid())
}

/// Makes the directory, anew after its removal.
pub(super) fn prepare_again(dir: &Path) -> io::Result<()> {
    fs::DirBuilder::new().recursive(true).mode(0o700).create(dir).map_err(|error| at(dir, &error))
}

/// An error that names the path.
pub(super) fn at(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}
