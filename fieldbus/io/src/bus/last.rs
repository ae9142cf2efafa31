//! A second socket on a bus, for frames that must go out while the task that owns the first one does not run.
//!
//! It receives nothing, waits for nothing and shares nothing with the [`Bus`](super::Bus) but the wire, so any thread
//! can use it at any time.

use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;

use socketcan::{CanSocket, Socket, SocketOptions};

use linewright_canopen::Frame;

use super::{kernel, members};

/// The second socket.
pub struct LastWire(LastSocket);

enum LastSocket {
    Kernel(CanSocket),
    Virtual { sender: UnixDatagram, dir: PathBuf },
}

impl LastWire {
    pub(super) fn kernel(name: &str) -> std::io::Result<Self> {
        let socket = CanSocket::open(name)?;
        socket.set_nonblocking(true)?;
        socket.set_filter_drop_all()?;
        Ok(LastWire(LastSocket::Kernel(socket)))
    }

    pub(super) fn of_directory(dir: PathBuf) -> std::io::Result<Self> {
        let sender = UnixDatagram::unbound()?;
        sender.set_nonblocking(true)?;
        Ok(LastWire(LastSocket::Virtual { sender, dir }))
    }

    /// Sends what the interface takes; gives how many frames that were.
    pub fn send(&self, frames: &[Frame]) -> usize {
        match &self.0 {
            LastSocket::Kernel(socket) => {
                let sent = |frame| kernel::to_kernel(frame).is_some_and(|frame| socket.write_frame(&frame).is_ok());
                frames.iter().filter(|frame| sent(frame)).count()
            }
            LastSocket::Virtual { sender, dir } => {
                let members = members::scan(dir).unwrap_or_default();
                for frame in frames {
                    members.iter().for_each(|path| drop(sender.send_to(&frame.to_bytes(), path)));
                }
                frames.len()
            }
        }
    }
}
