//! A second socket on a bus, for frames that must go out while the task that owns the first one does not run.
//!
//! It receives nothing, waits for nothing and shares nothing with the [`Bus`](super::Bus) but the wire, so any thread
//! can use it at any time.

use std::os::unix::net::UnixDatagram;
use std::path::PathBuf;

use socketcan::{CanSocket, Socket, SocketOptions};

use linewright_canopen::Frame;

use super::{kernel, members};

pub(crate) enum LastWire {
    Kernel(CanSocket),
    Virtual { sender: UnixDatagram, dir: PathBuf },
}

impl LastWire {
    pub(super) fn kernel(name: &str) -> std::io::Result<Self> {
        let socket = CanSocket::open(name)?;
        socket.set_nonblocking(true)?;
        socket.set_filter_drop_all()?;
        Ok(LastWire::Kernel(socket))
    }

    pub(super) fn of_directory(dir: PathBuf) -> std::io::Result<Self> {
        let sender = UnixDatagram::unbound()?;
        sender.set_nonblocking(true)?;
        Ok(LastWire::Virtual { sender, dir })
    }

    /// Sends what the interface takes; gives how many frames that were.
    pub(crate) fn send(&self, frames: &[Frame]) -> usize {
        match self {
            LastWire::Kernel(socket) => {
                let sent = |frame| kernel::to_kernel(frame).is_some_and(|frame| socket.write_frame(&frame).is_ok());
                frames.iter().filter(|frame| sent(frame)).count()
            }
            LastWire::Virtual { sender, dir } => {
                let members = members::scan(dir).unwrap_or_default();
                for frame in frames {
                    members.iter().for_each(|path| drop(sender.send_to(&frame.to_bytes(), path)));
                }
                frames.len()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Bus, BusOptions, Transport};
    use super::*;

    #[tokio::test]
    async fn frames_reach_the_bus_past_its_first_owner() {
        let dir = tempfile::tempdir().expect("a directory");
        let options = BusOptions { transport: Transport::Virtual, dir: Some(dir.path().to_owned()) };
        let stuck = Bus::open("vcan0", &options).expect("a virtual bus");
        let mut device = Bus::open("vcan0", &options).expect("a virtual bus");
        let last = stuck.last_wire().expect("a socket");
        let frame = Frame::data_frame(0x123, &[0, 5]).expect("a frame");
        assert_eq!(std::thread::spawn(move || last.send(&[frame])).join().expect("it ends"), 1);
        assert_eq!(device.recv().await.expect("a virtual bus stays"), frame);
    }
}
