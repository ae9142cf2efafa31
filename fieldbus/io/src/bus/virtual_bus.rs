//! The virtual bus: CAN between processes of one machine, for kernels without CAN.
//!
//! A send goes as one datagram to every other member's socket; there is no hub whose death would take the bus along.
//! A member that does not read soon fills its queue (ten datagrams on many kernels), so a backlog of its own is kept
//! for it: bounded, because a stopped process must not grow another one, and in order, because CAN keeps a sender's
//! frames in order. What exceeds it is lost and counted.

use std::io;
use std::os::unix::net::UnixDatagram as Sender;
use std::path::{Path, PathBuf};
use std::time::Duration;

use linewright_canopen::{FRAME_BYTES, Frame};
use tokio::net::UnixDatagram;

use super::members::{self, BusMember, Members};
use super::{BusError, BusStats};

/// Frames kept for a member that does not read. At 1 Mbit/s a real bus carries some 8,000 frames a second: this is
/// 60 ms of a fully loaded one.
const BACKLOG: usize = 512;
/// Period of the retries of a backlog.
const FLUSH: Duration = Duration::from_millis(1);

pub(super) struct VirtualBus {
    socket: UnixDatagram,
    /// Sends, outside the async runtime: that would take one member's full queue for a socket that cannot send at all,
    /// and wait for a readiness that is never reported.
    sender: Sender,
    members: Members,
    /// A socket this member had before its place in the directory was taken away; emptied first.
    former: Option<UnixDatagram>,
    waiting: bool,
}

/// Result of sending one datagram.
enum DatagramResult {
    Yes,
    Full,
    Dead,
    Refused,
}

impl VirtualBus {
    pub(super) fn open(name: &str, dir: Option<&Path>) -> Result<Self, BusError> {
        let at =
            |path: &Path, error| BusError::Virtual { name: name.to_owned(), path: path.display().to_string(), error };
        let shown = dir.unwrap_or(Path::new("the default directory"));
        let dir = members::prepare(name, dir).map_err(|error| at(shown, error))?;
        let (socket, own) = bind(&dir).map_err(|error| at(&dir, error))?;
        let sender = sender().map_err(|error| at(&dir, error))?;
        let mut members = Members::new(dir, own);
        members.refresh();
        Ok(VirtualBus { socket, sender, members, former: None, waiting: false })
    }

    pub(super) fn dir(&self) -> &Path {
        self.members.dir()
    }

    pub(super) fn send(&mut self, frame: &Frame, stats: &mut BusStats) {
        if !self.members.refresh() {
            self.rejoin();
        }
        let bytes = frame.to_bytes();
        let mut complete = true;
        self.members.others().retain_mut(|member| {
            flush(&self.sender, member);
            if member.backlog.is_empty() {
                match send_to(&self.sender, &bytes, &member.path) {
                    DatagramResult::Yes => return true,
                    DatagramResult::Full => {}
                    DatagramResult::Dead => return bury(member),
                    DatagramResult::Refused => {
                        stats.send_errors += 1;
                        return true;
                    }
                }
            }
            if member.backlog.len() < BACKLOG {
                member.backlog.push_back(bytes);
            } else {
                complete = false;
            }
            true
        });
        self.waiting = self.members.others().iter().any(|m| !m.backlog.is_empty());
        stats.sent += 1;
        stats.overruns += u64::from(!complete);
    }

    pub(super) async fn recv(&mut self, stats: &mut BusStats) -> Frame {
        loop {
            // One byte more than a frame: a longer datagram is then seen to be longer.
            let mut bytes = [0; FRAME_BYTES + 1];
            let len = if self.waiting {
                tokio::select! {
                    biased;
                    result = receive(&self.socket, &mut self.former, &mut bytes) => result,
                    () = tokio::time::sleep(FLUSH) => {
                        self.flush();
                        continue;
                    }
                }
            } else {
                receive(&self.socket, &mut self.former, &mut bytes).await
            };
            match len.map(|len| Frame::from_bytes(&bytes[..len])) {
                Ok(Ok(frame)) => return frame,
                Ok(Err(_)) => stats.malformed += 1,
                Err(error) => {
                    tracing::debug!(%error, "virtual bus not readable");
                    stats.receive_errors += 1;
                    tokio::time::sleep(FLUSH).await;
                }
            }
        }
    }

    fn flush(&mut self) {
        self.members
            .others()
            .retain_mut(|member| !matches!(flush(&self.sender, member), DatagramResult::Dead) || bury(member));
        self.waiting = self.members.others().iter().any(|m| !m.backlog.is_empty());
    }

    /// Binds a new socket after the old one's name has gone from the directory: without it nothing would be sent here.
    fn rejoin(&mut self) {
        if members::prepare_again(self.members.dir()).is_err() {
            return;
        }
        if let Ok((socket, own)) = bind(self.members.dir()) {
            self.members.rename_own(own);
            self.former = Some(std::mem::replace(&mut self.socket, socket));
        }
    }
}

impl Drop for VirtualBus {
    fn drop(&mut self) {
        // A killed member cannot do this; the others then detect it themselves.
        let _ = std::fs::remove_file(self.members.own());
    }
}

fn bind(dir: &Path) -> io::Result<(UnixDatagram, PathBuf)> {
    let own = dir.join(members::fresh_name());
    let socket = UnixDatagram::bind(&own)?;
    Ok((socket, own))
}

fn sender() -> io::Result<Sender> {
    let sender = Sender::unbound()?;
    sender.set_nonblocking(true)?;
    Ok(sender)
}

async fn receive(socket: &UnixDatagram, former: &mut Option<UnixDatagram>, bytes: &mut [u8]) -> io::Result<usize> {
    if let Some(old) = former {
        if let Ok(len) = old.try_recv(bytes) {
            return Ok(len);
        }
        *former = None;
    }
    socket.recv(bytes).await
}

/// Sends what is waiting for a member, as far as its queue takes it.
fn flush(socket: &Sender, member: &mut BusMember) -> DatagramResult {
    while let Some(bytes) = member.backlog.front() {
        match send_to(socket, bytes, &member.path) {
            DatagramResult::Yes | DatagramResult::Refused => {
                member.backlog.pop_front();
            }
            full_or_dead => return full_or_dead,
        }
    }
    DatagramResult::Yes
}

fn send_to(socket: &Sender, bytes: &[u8], path: &Path) -> DatagramResult {
    match socket.send_to(bytes, path) {
        Ok(_) => DatagramResult::Yes,
        Err(error) => match (error.kind(), error.raw_os_error()) {
            (io::ErrorKind::WouldBlock, _) | (_, Some(libc::ENOBUFS)) => DatagramResult::Full,
            (io::ErrorKind::ConnectionRefused | io::ErrorKind::NotFound, _) => DatagramResult::Dead,
            _ => DatagramResult::Refused,
        },
    }
}

/// Removes a dead member's socket. Always false: it is not to be kept.
fn bury(member: &BusMember) -> bool {
    let _ = std::fs::remove_file(&member.path);
    false
}
