//! A place on the virtual bus, made by hand: a datagram socket in the bus's directory, sixteen bytes a frame.
//!
//! One socket listens on several buses: it is bound in the first one's directory, and a link in each other one leads to
//! it. What happens on all of them then arrives in one queue, in the order it happened.

use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// A member of one or more buses.
pub struct Member {
    socket: UnixDatagram,
    directories: Vec<PathBuf>,
    name: String,
}

impl Member {
    /// Joins the buses in these directories.
    pub fn join(directories: Vec<PathBuf>, name: &str) -> io::Result<Self> {
        for directory in &directories {
            fs::create_dir_all(directory)?;
        }
        let own = directories[0].join(name);
        let socket = UnixDatagram::bind(&own)?;
        for other in &directories[1..] {
            symlink(&own, other.join(name))?;
        }
        socket.set_read_timeout(Some(Duration::from_millis(50)))?;
        socket.set_write_timeout(Some(Duration::from_millis(50)))?;
        Ok(Member { socket, directories, name: name.to_owned() })
    }

    /// The next datagram, if one comes soon.
    pub fn receive<'a>(&self, bytes: &'a mut [u8]) -> Option<&'a [u8]> {
        let length = self.socket.recv(bytes).ok()?;
        Some(&bytes[..length])
    }

    /// Sends any bytes to all other members of the buses.
    pub fn send(&self, bytes: &[u8]) {
        for directory in &self.directories {
            for path in self.others(directory) {
                // A member that has just died, or does not read for a while, misses it: as on any bus.
                let _ = self.socket.send_to(bytes, path);
            }
        }
    }

    fn others(&self, directory: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(directory).into_iter().flatten().flatten().map(|entry| entry.path());
        let is_socket = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "can");
        let is_ours = |path: &PathBuf| path.file_name().is_some_and(|name| name == self.name.as_str() || name == EYE);
        entries.filter(|path| is_socket(path) && !is_ours(path)).collect()
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        for directory in &self.directories {
            let _ = fs::remove_file(directory.join(&self.name));
        }
    }
}

/// A name for a member, never used before.
pub fn fresh_name() -> String {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    format!("hand-{}.can", COUNT.fetch_add(1, Ordering::Relaxed))
}

/// The observer's name on the bus. Frames that a test sends are not shown to it, so that it sees only those of the line
/// itself.
pub const EYE: &str = "eye.can";

/// A classic CAN frame as Linux lays it out: identifier with flags, length, data.
pub fn frame(identifier: u32, data: &[u8]) -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[..4].copy_from_slice(&identifier.to_ne_bytes());
    bytes[4] = u8::try_from(data.len()).expect("at most eight bytes");
    bytes[8..8 + data.len()].copy_from_slice(data);
    bytes
}
